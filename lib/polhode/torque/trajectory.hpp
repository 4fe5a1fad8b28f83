#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "polhode/torque/kepler_orbit.hpp"

namespace polhode {

/// Motion given as a table, interpolated by polynomials through the nearest points: positions through `degree` + 1 of
/// them, the velocity as their derivative. The pieces meet with a jump in the derivatives that is as small as the
/// interpolation error: a finer table, not a higher accuracy of propagation, makes it smaller.
class TabulatedOrbit {
 public:
  /// Throws InputError unless the times increase strictly, there are as many positions, more than `degree` of them, and
  /// 1 <= degree <= 15.
  TabulatedOrbit(std::vector<double> times_s, std::vector<Vector3> positions_m, int degree);

  /// Throws InputError outside the table.
  template <class Real>
  OrbitState<Real> state(Real t_s) const;

  double first_s() const { return times_s_.front(); }
  double last_s() const { return times_s_.back(); }

 private:
  std::vector<double> times_s_;
  std::vector<Vector3> positions_m_;
  int degree_;
};

extern template OrbitState<double> TabulatedOrbit::state(double) const;
extern template OrbitState<long double> TabulatedOrbit::state(long double) const;

/// The way of the body about another mass, from that mass, inertial. Copies share the table.
class Trajectory {
 public:
  Trajectory(const KeplerElements& elements) : orbit_(KeplerOrbit(elements)) {}  // NOLINT(google-explicit-constructor)
  explicit Trajectory(TabulatedOrbit table) : orbit_(std::make_shared<const TabulatedOrbit>(std::move(table))) {}

  template <class Real>
  OrbitState<Real> state(Real t_s) const {
    if (const KeplerOrbit* kepler = std::get_if<KeplerOrbit>(&orbit_)) return kepler->state(t_s);
    return std::get<1>(orbit_)->state(t_s);
  }
  /// The elements, or null for a table.
  const KeplerElements* elements() const {
    const KeplerOrbit* kepler = std::get_if<KeplerOrbit>(&orbit_);
    return kepler == nullptr ? nullptr : &kepler->elements();
  }

 private:
  std::variant<KeplerOrbit, std::shared_ptr<const TabulatedOrbit>> orbit_;
};

}  // namespace polhode
