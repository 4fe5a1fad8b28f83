#include "polhode/motion/splitting.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr double kStrangA[] = {0.5};
constexpr double kStrangB[] = {1.0};
constexpr double kBlanesMoan4A[] = {0.0792036964311957, 0.353172906049774, -0.0420650803577195, 0.2193769557534996};
constexpr double kBlanesMoan4B[] = {0.209515106613362, -0.143851773179818, 0.434336666566456};
constexpr double kBlanesMoan6A[] = {0.0502627644003922, 0.413514300428344, 0.0450798897943977,
                                    -0.188054853819569, 0.541960678450780, -0.7255255585086898};
constexpr double kBlanesMoan6B[] = {0.148816447901042, -0.132385865767784, 0.067307604692185, 0.432666402578175,
                                    -0.016404589403618};
constexpr double k84A[] = {0.07534696026989288841861, 0.51791685468825678230077, -0.09326381495814967071938};
constexpr double k84B[] = {0.19022593937367661924523, 0.84652407044352625705508, -1.07350001963440575260062};
constexpr double k104A[] = {0.04706710064597250612947887637243678556564, 0.1847569354170881069247376193702560968574,
                            0.2827060056798362053243616565541452479160, -0.01453004174289681837857815229683813033908};
constexpr double k104B[] = {0.1188819173681970199453503950853885936957, 0.2410504605515015657441667865901651105675,
                            -0.2732866667053238060543113981664559460630, 0.8267085775712504407295884329818044835997};
constexpr double k864A[] = {0.0711334264982231177779387300061549964174, 0.241153427956640098736487795326289649618,
                            0.521411761772814789212136078067994229991, -0.333698616227678005726562603400438876027};
constexpr double k864B[] = {0.183083687472197221961703757166430291072, 0.310782859898574869507522291054262796375,
                            -0.0265646185119588006972121379164987592663, 0.0653961422823734184559721793911134363710};
constexpr double k1064A[] = {0.03809449742241219545697532230863756534060, 0.1452987161169137492940200726606637497442,
                             0.2076276957255412507162056113249882065158, 0.4359097036515261592231548624010651844006,
                             -0.6538612258327867093807117373907094120024};
constexpr double k1064B[] = {0.09585888083707521061077150377145884776921, 0.2044461531429987806805077839164344779763,
                             0.2170703479789911017143385924306336714532, -0.01737538195906509300561788011852699719871};

constexpr SplittingScheme kSchemes[] = {
    {"strang", "2", "Strang 1968, SIAM J. Numer. Anal. 5, 506", 1, kStrangA, kStrangB},
    {"blanes-moan-4", "4", "Blanes & Moan 2002, J. Comput. Appl. Math. 142, 313, S6", 6, kBlanesMoan4A, kBlanesMoan4B},
    {"blanes-moan-6", "6", "Blanes & Moan 2002, J. Comput. Appl. Math. 142, 313, S10", 10, kBlanesMoan6A,
     kBlanesMoan6B},
    {"near-8-4", "(8,4)", "McLachlan 1995, BIT 35, 258", 5, k84A, k84B},
    {"near-10-4", "(10,4)", "Blanes et al. 2013, Appl. Numer. Math. 68, 58, ABA", 7, k104A, k104B},
    {"near-8-6-4", "(8,6,4)", "Blanes et al. 2013, Appl. Numer. Math. 68, 58, ABA", 7, k864A, k864B},
    {"near-10-6-4", "(10,6,4)", "Blanes et al. 2013, Appl. Numer. Math. 68, 58, ABA", 8, k1064A, k1064B},
};

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

std::span<const SplittingScheme> splitting_schemes() { return kSchemes; }

const SplittingScheme& splitting_scheme(std::string_view name) {
  std::string allowed;
  for (const SplittingScheme& scheme : kSchemes) {
    if (scheme.name == name) return scheme;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", scheme.name);
  }
  throw InputError(fmt::format("unknown splitting scheme '{:.40}', allowed are {}", name, allowed));
}

Vector3 kick(FreeBody& body, double t_s, double length_s, const Torques& torques) {
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
  const Vector3 added = polhode::kick(body_, t_s, length_s, torques_) + momentum_rounded_;
  const Vector3 sum = momentum_inertial_ + added;
  momentum_rounded_ = added - (sum - momentum_inertial_);
  momentum_inertial_ = sum;
}

void SplittingRun::step(double length_s) {
  double drifted = 0.0;
  for (std::size_t i = 0; i < scheme_.kicks; ++i) {
    drifted += scheme_.drift(i);
    if (!free_) free_.emplace(ThetaMotion::Unchecked{}, body_, ThetaMotion::Span::step);
    const FreeState now = free_->at(since_kick_s_ + scheme_.drift(i) * length_s);
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

FreeState SplittingRun::state() const {
  if (!free_) return {body_.q_inertial_from_body.normalized(), body_.momentum_body};
  FreeState state = free_->at(since_kick_s_);
  state.momentum_body = state.q_inertial_from_body.conjugate() * momentum_inertial_;
  return state;
}

}  // namespace polhode
