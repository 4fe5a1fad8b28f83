#include "polhode/motion/splitting.hpp"

#include <cmath>

namespace polhode {
namespace {

constexpr double kStrangA[] = {0.5};
constexpr double kStrangB[] = {1.0};
constexpr double k1064A[] = {0.03809449742241219545697532230863756534060, 0.1452987161169137492940200726606637497442,
                             0.2076276957255412507162056113249882065158, 0.4359097036515261592231548624010651844006,
                             -0.6538612258327867093807117373907094120024};
constexpr double k1064B[] = {0.09585888083707521061077150377145884776921, 0.2044461531429987806805077839164344779763,
                             0.2170703479789911017143385924306336714532, -0.01737538195906509300561788011852699719871};

/// What m' = c - D I^-1 m adds to m over h: the exponential series, which the smallness of h D/I makes short.
Vector3 damping_change(const Vector3& m, double h, const TorqueTerms<double>& terms, const Vector3& moments) {
  Vector3 term = h * (terms.constant - terms.damping * m.cwiseQuotient(moments));
  Vector3 result = Vector3::Zero();
  for (int n = 2; n < 60; ++n) {
    result += term;
    if (term.squaredNorm() <= 1e-36 * result.squaredNorm()) break;
    term = terms.damping * term.cwiseQuotient(moments) * (-h / n);
  }
  return result;
}

/// m' = k m x (m x omega), q' = q (0, k m x omega)/2 over h. The momentum in closed form, m_i ~ exp(-k |m|^2 h / I_i)
/// at its length; the attitude by a Magnus step of order 4 (Gauss points), local error (k |m| omega h)^5.
void relax(FreeBody& body, double h, double relaxation) {
  const Vector3 m = body.momentum_body;
  const double length = m.norm();
  if (!(length > 0.0)) return;
  const Vector3 rates = -relaxation * length * length * body.principal_moments.cwiseInverse();
  const auto after = [&](double s) -> Vector3 {
    const Vector3 stretched = m.array() * (s * (rates.array() - rates.maxCoeff())).exp();
    return stretched * (length / stretched.norm());
  };
  const auto turn = [&](double s) -> Vector3 {
    const Vector3 m_s = after(s);
    return relaxation * m_s.cross(m_s.cwiseQuotient(body.principal_moments));
  };
  const double offset = std::sqrt(3.0) / 6.0;
  const Vector3 w1 = turn(h * (0.5 - offset)), w2 = turn(h * (0.5 + offset));
  const Vector3 angle = 0.5 * h * (w1 + w2) + std::sqrt(3.0) / 12.0 * h * h * w1.cross(w2);
  const double half = 0.5 * angle.norm();
  const double sinc = half < 1e-8 ? 1.0 : std::sin(half) / half;
  const Vector3 v = 0.5 * sinc * angle;
  body.q_inertial_from_body = body.q_inertial_from_body * Quaternion(std::cos(half), v[0], v[1], v[2]);
  body.momentum_body = after(h);
}

}  // namespace

constinit const SplittingScheme kStrang{"strang", "2",      "Strang 1968, SIAM J. Numer. Anal. 5, 506",
                                        1,        kStrangA, kStrangB};
constinit const SplittingScheme kNear1064{
    "near-10-6-4", "(10,6,4)", "Blanes et al. 2013, Appl. Numer. Math. 68, 58, ABA", 8, k1064A, k1064B};

Vector3 apply_kick(FreeBody& body, double t_s, double length_s, const Torques& torques) {
  const TorqueTerms<double> terms = torques.at(t_s, body.q_inertial_from_body, body.principal_moments);
  const auto relax_half = [&] {
    if (terms.relaxation != 0.0) relax(body, 0.5 * length_s, terms.relaxation);
  };
  relax_half();
  const Vector3 change = terms.depends_on_rate
                             ? damping_change(body.momentum_body, length_s, terms, body.principal_moments)
                             : Vector3(length_s * terms.constant);
  body.momentum_body += change;
  const Vector3 added = body.q_inertial_from_body * change;
  relax_half();
  return added;
}

void SplittingRun::kick(double t_s, double length_s) {
  ++evaluations_;
  const Vector3 added = apply_kick(body_, t_s, length_s, torques_) + momentum_rounded_;
  const Vector3 sum = momentum_inertial_ + added;
  momentum_rounded_ = added - (sum - momentum_inertial_);
  momentum_inertial_ = sum;
}

void SplittingRun::step(double length_s) {
  double drifted = 0.0;
  for (std::size_t i = 0; i < scheme_.kicks; ++i) {
    drifted += scheme_.drift(i);
    if (!free_) free_.emplace(ThetaMotion::Unchecked{}, body_, ThetaMotion::Span::step);
    const State now = free_->at(since_kick_s_ + scheme_.drift(i) * length_s);
    body_.q_inertial_from_body = now.q_inertial_from_body;
    body_.momentum_body = now.q_inertial_from_body.conjugate() * momentum_inertial_;
    since_kick_s_ = 0.0;
    kick(t_s_ + drifted * length_s, scheme_.kick(i) * length_s);
    free_.reset();
  }
  free_.emplace(ThetaMotion::Unchecked{}, body_, ThetaMotion::Span::step);  // also drifts into the next step
  since_kick_s_ = scheme_.drift(scheme_.kicks) * length_s;
  t_s_ += length_s;
}

State SplittingRun::state() const {
  if (!free_) return {body_.q_inertial_from_body.normalized(), body_.momentum_body};
  State state = free_->at(since_kick_s_);
  state.momentum_body = state.q_inertial_from_body.conjugate() * momentum_inertial_;
  return state;
}

}  // namespace polhode
