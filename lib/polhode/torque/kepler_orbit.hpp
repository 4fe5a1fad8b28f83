#pragma once

#include <array>
#include <optional>
#include <string>

#include "polhode/torque/terms.hpp"

namespace polhode {

inline constexpr double kSunMu_m3_s2 = 1.32712440041279419e20;  ///< DE440

/// What fixes motion about a point mass: ellipse, parabola and hyperbola in one form.
struct KeplerElements {
  double mu_m3_s2 = 0.0;                    ///< positive
  double periapsis_m = 0.0;                 ///< distance, positive
  double eccentricity = 0.0;                ///< 0 or more
  double periapsis_time_s = 0.0;            ///< on the body's clock, at most kMostPeriapsisTime_s away from 0
  Vector3 to_periapsis = Vector3::UnitX();  ///< inertial, any length but 0
  Vector3 along_normal = Vector3::UnitZ();  ///< inertial, at a right angle to the other within kMostSkew_rad, and
                                            ///< made so to the last digit; the body moves along normal x periapsis at
                                            ///< periapsis
};

/// Thirty thousand years. A double holds times as long to a tenth of a millisecond; from times much longer no phase on
/// an orbit follows.
inline constexpr double kMostPeriapsisTime_s = 1e12;
/// How far from a right angle the directions of elements may be: four decimals of each component hold it so well.
inline constexpr double kMostSkew_rad = 2e-4;

/// The element that is out of its range, and what was found and is wanted, in words.
struct KeplerFault {
  enum class Element { mu, periapsis, eccentricity, periapsis_time, to_periapsis, along_normal } element;
  std::string message;
};
std::optional<KeplerFault> fault_of(const KeplerElements& elements);

/// Motion on a Kepler orbit, by universal functions from periapsis (Battin 1999, section 4.5): with alpha = (1 - e)/q
/// and U_k(chi) the time equation sqrt(mu) (t - tp) = q U1 + U3 and the radius r = q + e U2 are sums of positive terms
/// for every eccentricity, so that nothing is lost at or near e = 1. The equation is solved to the last digits of Real
/// (double or long double); an ellipse is first reduced to half a turn from periapsis. Position error below 1e-14 r in
/// double for up to a turn from periapsis (tested against a solution with 50 digits); afterwards a rounding of the time
/// may be more.
class KeplerOrbit {
 public:
  /// Throws InputError for elements out of range: what fault_of() finds, and what no double holds.
  explicit KeplerOrbit(const KeplerElements& elements);

  /// Of the body, from the point mass. NaN where t is not finite.
  template <class Real>
  OrbitState<Real> state(Real t_s) const;

  const KeplerElements& elements() const { return elements_; }
  /// Unit vectors towards periapsis, and a right angle ahead in the orbit.
  std::array<Vector3Of<long double>, 2> axes() const { return {extended_.x, extended_.y}; }

 private:
  template <class Real>
  struct Constants {
    Real sqrt_mu, alpha, period_s, time_s, sqrt_parameter;
    Vector3Of<Real> x, y;  // towards periapsis, and a right angle ahead
  };

  /// A first value of chi for sqrt(mu) |t - tp|, and an upper bound.
  template <class Real>
  void starter(Real path, Real& bound, Real& chi) const;

  KeplerElements elements_;
  Constants<long double> extended_;
  Constants<double> plain_;
  double period_rounding_s_ = 0.0;  // what plain_ has too little
};

extern template OrbitState<double> KeplerOrbit::state(double) const;
extern template OrbitState<long double> KeplerOrbit::state(long double) const;

}  // namespace polhode
