// What partial derivatives must keep whatever the body: the variational equations, the constancy of the momentum in
// space, composition, symmetries, differences of the motion itself, and what they are where they are elementary.
#include "polhode/motion/partials.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

Matrix3 cross(const Vector3& v) {
  Matrix3 result;
  result << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return result;
}

/// In every chart, on both sides of every border, and where the momentum is constant.
std::vector<FreeBody> bodies() {
  const Quaternion q(0.3, -0.5, 0.7, 0.2);
  const double separatrix = std::sqrt((13.0 - 8.0) * 18.0 / (8.0 * (18.0 - 13.0)));
  return {
      {{1.0, 2.2, 2.9}, q, {0.3, -0.2, 2.0}},                // short axis
      {{1.0, 2.2, 2.9}, q, {-1.3, 0.7, 0.4}},                // long axis
      {{1.0, 2.2, 2.9}, q, {0.0, 1.7, -0.4}},                // a zero component
      {{8.0, 13.0, 18.0}, q, {2.0, 3.0, 2.0 * separatrix}},  // on the separatrix
      {{8.0, 13.0, 18.0}, q, {-2.0, 3.0, 2.0000001 * separatrix}},
      {{8.0, 13.0, 18.0}, q, {1e-9, 9.0, -2e-9}},  // beside the middle axis
      {{8.0, 13.0, 18.0}, q, {0.0, 9.0, 0.0}},     // on it
      {{8.0, 13.0, 18.0}, q, {1e-9, 2e-9, -9.0}},
      {{8.0, 13.0, 18.0}, q, {0.0, 0.0, 9.0}},
      {{8.0, 13.0, 18.0}, q, {-9.0, 0.0, 0.0}},
      {{2.0, 2.0, 3.0}, q, {1.0, 2.0, -1.5}},  // tops
      {{2.0, 3.0, 3.0}, q, {1.0, 2.0, -1.5}},
      {{2.0, 2.0, 3.0}, q, {1.0, 2.0, 0.0}},
      {{2.0, 3.0, 3.0}, q, {0.0, 2.0, 1.0}},
      {{2.0, 2.0, 3.0}, q, {0.0, 0.0, 2.0}},
      {{2.0, 2.0 + 1e-15, 3.0}, q, {1.0, 2.0, -1.5}},
      {{2.5, 2.5, 2.5}, q, {1.0, 2.0, -1.5}},  // a sphere
      {{2.5, 2.5 + 1e-14, 2.5 + 3e-14}, q, {1.0, 2.0, -1.5}},
      {{1.0, 2.2, 2.9}, q, {0.0, 0.0, 0.0}},          // at rest
      {{1e-3, 2.2, 2.2000001}, q, {1e-3, 1.0, 1.1}},  // a needle
  };
}

std::string name_of(const FreeBody& body) {
  std::ostringstream text;
  text.precision(17);
  text << "I " << body.principal_moments.transpose() << " m " << body.momentum_body.transpose();
  return text.str();
}

/// Momenta in units of G, moments of I_k.
PartialsMatrix without_units(const FreeBody& body, PartialsMatrix matrix) {
  const double g = body.momentum_body.norm() > 0.0 ? body.momentum_body.norm() : body.principal_moments[1];
  for (int k = 0; k < 3; ++k) {
    matrix.col(3 + k) *= g;
    matrix.col(6 + k) *= body.principal_moments[k];
  }
  matrix.bottomRows<3>() /= g;
  return matrix;
}
double error_of(const FreeBody& body, const PartialsMatrix& answer, const PartialsMatrix& truth) {
  const PartialsMatrix difference = without_units(body, answer - truth), size = without_units(body, truth);
  double worst = 0.0;
  for (int k = 0; k < 9; ++k) {
    const double error = difference.col(k).norm() / std::max(1.0, size.col(k).norm());
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

/// The right-hand side of the variational equations: theta' = theta x omega + d(omega), m' = m x omega, with
/// d(omega) = dm / I - m dI / I^2.
PartialsMatrix rate_of(const FreeBody& body, const StatePartials& s) {
  const Vector3 inverse = body.principal_moments.cwiseInverse(), m = s.state.momentum_body;
  const Vector3 omega = inverse.cwiseProduct(m);
  const auto theta = s.partials.topRows<3>(), dm = s.partials.bottomRows<3>();
  Eigen::Matrix<double, 3, 9> d_omega = inverse.asDiagonal() * dm;
  d_omega.rightCols<3>() -= Matrix3(omega.cwiseProduct(inverse).asDiagonal());
  PartialsMatrix rate;
  rate.topRows<3>() = d_omega - cross(omega) * theta;
  rate.bottomRows<3>() = cross(m) * d_omega - cross(omega) * dm;
  return rate;
}

const std::vector<double> kTimes{0.0, 1e-6, 0.1, -0.9, 2.0, 7.3, -19.0, 61.0};

TEST(Partials, BeginWithTheIdentity) {
  PartialsMatrix identity = PartialsMatrix::Zero();
  identity.leftCols<6>().setIdentity();
  for (const FreeBody& body : bodies()) {
    EXPECT_LE(error_of(body, FreePartials(body).at(0.0).partials, identity), 1e-15) << name_of(body);
  }
}

TEST(Partials, ObeyTheVariationalEquations) {
  for (const FreeBody& body : bodies()) {
    const FreePartials partials(body);
    const double rate = std::max(1e-3, body.momentum_body.cwiseQuotient(body.principal_moments).norm());
    const double h = 1e-3 / rate;
    for (const double t : kTimes) {
      const auto at = [&](double steps) { return partials.at(t + steps * h).partials; };
      const PartialsMatrix slope = ((at(1) - at(-1)) * 0.75 - (at(2) - at(-2)) * 0.15 + (at(3) - at(-3)) / 60.0) / h;
      const StatePartials here = partials.at(t);
      // Against the size of the matrix itself: a slope by differences is as good as what it differs.
      const double error = without_units(body, slope - rate_of(body, here)).norm() / rate /
                           std::max(1.0, without_units(body, here.partials).norm());
      EXPECT_LE(error, 2e-11) << name_of(body) << " t=" << t;
    }
  }
}

/// Momentum in space R m: its change R (dm + theta x m) is that at t = 0. Columns of I leave it as it is.
TEST(Partials, KeepTheMomentumInSpace) {
  for (const FreeBody& body : bodies()) {
    const FreePartials partials(body);
    const Matrix3 at_0 = body.q_inertial_from_body.normalized().toRotationMatrix();
    for (const double t : kTimes) {
      const StatePartials s = partials.at(t);
      const Matrix3 r = s.state.q_inertial_from_body.toRotationMatrix();
      Eigen::Matrix<double, 3, 9> change =
          s.partials.bottomRows<3>() - cross(s.state.momentum_body) * s.partials.topRows<3>();
      change = at_0.transpose() * r * change;
      Eigen::Matrix<double, 3, 9> expected = Eigen::Matrix<double, 3, 9>::Zero();
      expected.leftCols<3>() = -cross(body.momentum_body);
      expected.middleCols<3>(3).setIdentity();
      for (int k = 0; k < 9; ++k) {
        const double size = s.partials.bottomRows<3>().col(k).norm() +
                            body.momentum_body.norm() * s.partials.topRows<3>().col(k).norm();
        EXPECT_LE((change - expected).col(k).norm(), 4e-15 * std::max(size, expected.col(k).norm()))
            << name_of(body) << " t=" << t << " column " << k;
      }
    }
  }
}

/// The flow of theta and m preserves its symplectic form, and so volumes: the determinant of the first six columns
/// is 1.
TEST(Partials, PreserveTheSymplecticForm) {
  for (const FreeBody& body : bodies()) {
    const FreePartials partials(body);
    for (const double t : kTimes) {
      const StatePartials s = partials.at(t);
      const PartialsMatrix free = without_units(body, s.partials);
      const double g = body.momentum_body.norm() > 0.0 ? body.momentum_body.norm() : body.principal_moments[1];
      // theta_1 . dm_2 - theta_2 . dm_1 + m . (theta_1 x theta_2), with m in units of g
      const auto form = [g](const Vector3& m) {
        Eigen::Matrix<double, 6, 6> j = Eigen::Matrix<double, 6, 6>::Zero();
        j.topRightCorner<3, 3>().setIdentity();
        j.bottomLeftCorner<3, 3>() = -Matrix3::Identity();
        j.topLeftCorner<3, 3>() = -cross(m / g);
        return j;
      };
      const Eigen::Matrix<double, 6, 6> phi = free.leftCols<6>();
      const Eigen::Matrix<double, 6, 6> kept = phi.transpose() * form(s.state.momentum_body) * phi;
      const double size = std::max(1.0, phi.squaredNorm());
      EXPECT_LE((kept - form(body.momentum_body)).norm(), 1e-14 * size) << name_of(body) << " t=" << t;
    }
  }
}

/// From 0 to s and from s to t, moments handed through.
TEST(Partials, Compose) {
  for (const FreeBody& body : bodies()) {
    const FreePartials whole(body);
    const double s = 1.7, t = 5.0;
    const StatePartials first = whole.at(s);
    const FreePartials rest(
        FreeBody{body.principal_moments, first.state.q_inertial_from_body, first.state.momentum_body});
    const PartialsMatrix then = rest.at(t - s).partials;
    PartialsMatrix both = then.leftCols<6>() * first.partials;
    both.rightCols<3>() += then.rightCols<3>();
    EXPECT_LE(error_of(body, both, whole.at(t).partials), 2e-12) << name_of(body);
  }
}

TEST(Partials, AreTheDifferencesOfTheMotion) {
  for (const FreeBody& body : bodies()) {
    const FreePartials partials(body);
    const double g = body.momentum_body.norm() > 0.0 ? body.momentum_body.norm() : body.principal_moments[1];
    for (const double t : {0.4, -3.0}) {
      const StatePartials here = partials.at(t);
      PartialsMatrix differences;
      for (int k = 0; k < 9; ++k) {
        std::array<State, 2> ends;
        double h = 1e-6;
        const double unit = k < 3 ? 1.0 : k < 6 ? g : body.principal_moments[k - 6];
        for (int side = 0; side < 2; ++side) {
          const double step = (side == 0 ? h : -h) * unit;
          FreeBody other = body;
          if (k < 3) {
            const Vector3 half = 0.5 * step * Vector3::Unit(k);
            other.q_inertial_from_body =
                body.q_inertial_from_body * Quaternion(1.0, half.x(), half.y(), half.z()).normalized();
          } else if (k < 6) {
            other.momentum_body[k - 3] += step;
          } else {
            // Moments must ascend: beyond a neighbour the axes are named anew.
            other.principal_moments[k - 6] += step;
          }
          // Sorted by a cyclic exchange or a swap with a sign, and back.
          std::array<int, 3> order{0, 1, 2};
          std::sort(order.begin(), order.end(),
                    [&](int a, int b) { return other.principal_moments[a] < other.principal_moments[b]; });
          Matrix3 p = Matrix3::Zero();  // from the body's axes to the sorted ones
          for (int i = 0; i < 3; ++i) p(i, order[static_cast<std::size_t>(i)]) = 1.0;
          if (p.determinant() < 0.0) p.row(0) *= -1.0;
          const FreeBody sorted{(p.cwiseAbs() * other.principal_moments).eval(),
                                other.q_inertial_from_body.normalized() * Quaternion(p.transpose()),
                                (p * other.momentum_body).eval()};
          const State end = ThetaMotion(sorted).at(t);
          ends[static_cast<std::size_t>(side)] = {end.q_inertial_from_body * Quaternion(p),
                                                  p.transpose() * end.momentum_body};
        }
        Quaternion plus = ends[0].q_inertial_from_body, minus = ends[1].q_inertial_from_body;
        if (plus.dot(minus) < 0.0) plus.coeffs() *= -1.0;
        const Quaternion turn = minus.conjugate() * plus;
        differences.block<3, 1>(0, k) = 2.0 * turn.vec() / (2.0 * h * unit);
        differences.block<3, 1>(3, k) = (ends[0].momentum_body - ends[1].momentum_body) / (2.0 * h * unit);
      }
      EXPECT_LE(error_of(body, differences, here.partials), 1e-5) << name_of(body) << " t=" << t;
    }
  }
}

/// A sphere turns about its momentum at m / I; each moment changes the rate of its own component.
TEST(Partials, OfASphere) {
  const FreeBody body{{2.5, 2.5, 2.5}, Quaternion(0.3, -0.5, 0.7, 0.2), {1.0, 2.0, -1.5}};
  const double t = 40.0;
  const StatePartials s = FreePartials(body).at(t);
  for (int k = 0; k < 3; ++k) {
    const Vector3 theta = -t * body.momentum_body[k] / 6.25 * Vector3::Unit(k);
    EXPECT_LE((s.partials.block<3, 1>(0, 6 + k) - theta).norm(), 1e-15 * theta.norm());
    EXPECT_LE((s.partials.block<3, 1>(3, 6 + k) + theta.cross(body.momentum_body)).norm(), 1e-13);
  }
}

TEST(Partials, OfABodyAtRest) {
  const FreeBody body{{1.0, 2.0, 2.5}, Quaternion(0.3, -0.5, 0.7, 0.2), {0.0, 0.0, 0.0}};
  PartialsMatrix expected = PartialsMatrix::Zero();
  expected.leftCols<6>().setIdentity();
  for (int k = 0; k < 3; ++k) expected(k, 3 + k) = 1e5 / body.principal_moments[k];
  EXPECT_LE((FreePartials(body).at(1e5).partials - expected).norm(), 1e-15);
}

/// Powers of two in the units change nothing else, up to the ends of the range of bodies.
TEST(Partials, DoNotDependOnUnits) {
  const FreeBody body{{1.0, 2.2, 2.9}, Quaternion(0.3, -0.5, 0.7, 0.2), {0.3, -0.2, 2.0}};
  const PartialsMatrix expected = without_units(body, FreePartials(body).at(3.25).partials);
  for (const int inertia : {-480, 0, 480}) {
    for (const int momentum : {-480, 0, 480}) {
      const FreeBody other{body.principal_moments * std::ldexp(1.0, inertia), body.q_inertial_from_body,
                           body.momentum_body * std::ldexp(1.0, momentum)};
      const PartialsMatrix got = FreePartials(other).at(std::ldexp(3.25, inertia - momentum)).partials;
      EXPECT_LE((without_units(other, got) - expected).norm(), 1e-15) << inertia << ' ' << momentum;
    }
  }
}

/// Finite whatever the body and the time, and what cannot be represented keeps its direction.
TEST(Partials, AreFinite) {
  std::vector<FreeBody> all = bodies();
  const Quaternion q(0.3, -0.5, 0.7, 0.2);
  for (const double tiny : {1e-160, 1e-300, 1e-304}) {
    all.push_back({{8.0, 13.0, 18.0}, q, {tiny, 9.0, -tiny}});
    all.push_back({{8.0, 13.0, 18.0}, q, {9.0, tiny, -tiny}});
    all.push_back({{8.0, 13.0, 18.0}, q, {tiny, -tiny, 9.0}});
    all.push_back({{2.0, 2.0, 3.0}, q, {1.0, 2.0, tiny}});
    all.push_back({{2.0, 3.0, 3.0}, q, {tiny, 2.0, 1.0}});
    all.push_back({{1e-40, 2.0, 2.0}, q, {tiny, 2.0, 1e-40}});
    all.push_back({{1.0, 2.0, 2.5}, q, {tiny, -tiny, tiny}});
  }
  for (const FreeBody& body : all) {
    const FreePartials partials(body);
    for (const double t : {0.0, 1e-300, 1e-9, 0.3, -2.0, 30.0, 1e3, -1e5, 1e9, 1e15, -1e22}) {
      EXPECT_TRUE(partials.at(t).partials.allFinite()) << name_of(body) << " t=" << t;
    }
  }
}

TEST(Partials, TakeTimesInTwoParts) {
  const FreePartials partials(bodies()[0]);
  const double t = 1e9, low = 3e-9;
  const PartialsMatrix both = partials.at(t, low).partials;
  EXPECT_NE(both, partials.at(t).partials);
  const std::vector<double> high(9, t), lows(9, low);
  std::vector<double> q(4 * 9), m(3 * 9), matrices(54 * 9);
  partials.batch({high, lows}, StateArrays::of_structures(q.data(), m.data()), matrices);
  EXPECT_EQ(both, PartialsMatrix(Eigen::Map<const PartialsMatrix>(matrices.data() + 54 * 8)));
}

TEST(Partials, WrongArgumentsAreRefused) {
  EXPECT_THROW(FreePartials({{3.0, 2.0, 1.0}, Quaternion::Identity(), {1.0, 0.0, 0.0}}), InputError);
  EXPECT_THROW(FreePartials({{1.0, 2.0, 2.5}, Quaternion(0.0, 0.0, 0.0, 0.0), {1.0, 0.0, 0.0}}), InputError);
  const FreePartials partials(bodies()[0]);
  const std::vector<double> times{1.0, 2.0}, one{0.0};
  std::vector<double> q(8), m(6), matrices(108), few(107);
  const StateArrays out = StateArrays::of_structures(q.data(), m.data());
  EXPECT_THROW(partials.batch({times, one}, out, matrices), InputError);
  EXPECT_THROW(partials.batch({times}, out, few), InputError);
  EXPECT_THROW(batch_threads(partials, {times}, out, few), InputError);
  EXPECT_TRUE(partials.at(std::numeric_limits<double>::quiet_NaN()).partials.hasNaN());
}

}  // namespace
}  // namespace polhode
