#pragma once

#include <array>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "polhode/torque/kepler_orbit.hpp"

namespace polhode {

/// Part of a trajectory that may be interpolated as one.
struct OrbitTable {
  std::vector<double> times_s;          ///< ascending, finite, on the body's clock
  std::vector<Vector3> positions_m;     ///< inertial, as many, finite and not 0
  std::vector<Vector3> velocities_m_s;  ///< as many, finite, or none
  int degree = 0;                       ///< of the interpolation, 1 to 15
  /// The rows beyond serve interpolation alone; empty: none are beyond.
  std::optional<double> useable_from_s, useable_to_s;

  double first_s() const { return useable_from_s.value_or(times_s.front()); }
  double last_s() const { return useable_to_s.value_or(times_s.back()); }
};

/// Motion given as a table, interpolated by polynomials through the nearest points: of positions (Lagrange: degree + 1
/// points), or where there are velocities of both (Hermite: (degree + 1)/2 points, rounded up); the velocity is the
/// derivative. The pieces meet with a jump in the derivatives that is as small as the interpolation error: a finer
/// table, not a higher accuracy of propagation, makes it smaller. From one table to the next nothing is interpolated:
/// where two overlap, the later counts.
class TabulatedOrbit {
 public:
  /// Throws InputError unless the tables are as OrbitTable says, the times of each increase strictly, there are enough
  /// rows for the degree, and the tables follow each other without a gap.
  explicit TabulatedOrbit(std::vector<OrbitTable> tables);

  /// Throws InputError outside the tables, and for NaN.
  template <class Real>
  OrbitState<Real> state(Real t_s) const;

  /// The polynomial in use just after (forward) or just before a time, and how far it is.
  struct Piece {
    std::array<Vector3, 16> coefficients;  ///< of the position, in powers of the time since then
    int degree;
    double end_s;
  };
  /// Throws as state().
  Piece piece(double t_s, bool forward) const;

  const std::vector<OrbitTable>& tables() const { return tables_; }
  double first_s() const { return tables_.front().first_s(); }
  double last_s() const { return tables_.back().last_s(); }
  /// Where one table follows another.
  std::vector<double> seams_s() const;

 private:
  const OrbitTable& table_at(double t_s) const;

  std::vector<OrbitTable> tables_;
};

extern template OrbitState<double> TabulatedOrbit::state(double) const;
extern template OrbitState<long double> TabulatedOrbit::state(long double) const;

/// The way of the body about another mass, from that mass, inertial. Copies share the table.
class Trajectory {
 public:
  Trajectory(const KeplerElements& elements)  // NOLINT(google-explicit-constructor)
      : orbit_(std::make_shared<const KeplerOrbit>(elements)) {}
  explicit Trajectory(TabulatedOrbit table) : orbit_(std::make_shared<const TabulatedOrbit>(std::move(table))) {}

  template <class Real>
  OrbitState<Real> state(Real t_s) const {
    return std::visit([t_s](const auto& orbit) { return orbit->state(t_s); }, orbit_);
  }
  /// From the mass to the periapsis, or to the nearest point of a table.
  double least_distance_m() const;
  /// The same orbit, not only one like it.
  bool operator==(const Trajectory&) const = default;
  /// Null for a table.
  const KeplerOrbit* orbit() const {
    const auto* orbit = std::get_if<0>(&orbit_);
    return orbit == nullptr ? nullptr : orbit->get();
  }
  /// Null for a Kepler orbit.
  const TabulatedOrbit* table() const {
    const auto* table = std::get_if<1>(&orbit_);
    return table == nullptr ? nullptr : table->get();
  }

 private:
  std::variant<std::shared_ptr<const KeplerOrbit>, std::shared_ptr<const TabulatedOrbit>> orbit_;
};

}  // namespace polhode
