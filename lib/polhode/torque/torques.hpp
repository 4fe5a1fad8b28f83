#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>
#include <variant>
#include <vector>

#include "polhode/torque/aerodynamic.hpp"
#include "polhode/torque/constant_torque.hpp"
#include "polhode/torque/eddy_currents.hpp"
#include "polhode/torque/gravity_gradient.hpp"
#include "polhode/torque/internal_dissipation.hpp"
#include "polhode/torque/linear_damping.hpp"
#include "polhode/torque/own_torque.hpp"
#include "polhode/torque/sunlight.hpp"
#include "polhode/torque/thruster_pulse.hpp"

namespace polhode {

/// Every torque. A new one is a file of its own and an entry here; readers, plans and messages find the rest in it:
///
///     name, keys                   its kind, and the keys of its table in a scene
///     needs_absolute_inertia       whether it means nothing to a body whose moments are ratios
///     read(table)                  the torque of a scene's table (read/torque_table.hpp says what a table answers)
///     check()                      throws InputError for what its description excludes; Torques calls it
///     parameters(visit)            visit(name, number) for each number that its torque grows with in proportion, or
///                                  visit(name, number, &other) for two that are equal; and for mu_m3_s2 and
///                                  dipole_t_m3, which parameters.hpp knows
///     turned(to_from)              the same torque in other body axes, v_to = R v_from
///     largest(t_s, moments, |m|)   no attitude, and no momentum of this length, feels a larger torque at time t
///     add(place, moments, terms)   its part of TorqueTerms; or, for a torque that jumps in time and is constant
///     between, jumps_s(), during(inside_s)  its jumps, and what it is between two of them: nothing, or another torque
///
/// If it has a `trajectory`, `place` says where the body is on it, and likewise for a `second_trajectory`. May be left
/// out: has_kinks(), times_of_kinks_s(first_s, last_s), cost_of_evaluation() (beside that of a gravity gradient, 1),
/// and for a kind that no scene can state, `keys` and read().
using Torque = std::variant<GravityGradient, ConstantTorque, ThrusterPulse, LinearDamping, EddyCurrents,
                            InternalDissipation, Sunlight, Aerodynamic, OwnTorque>;

template <class One>
concept JumpingTorque = requires(const One& one) {
  one.jumps_s();
  one.during(0.0);
};
template <class One>
concept TorqueKind = requires(const One& one, const Matrix3& rotation, const Vector3& moments,
                              TorqueTerms<double>& terms) {
  { One::name } -> std::convertible_to<std::string_view>;
  { One::needs_absolute_inertia } -> std::convertible_to<bool>;
  one.check();
  { one.turned(rotation) } -> std::convertible_to<One>;
  { one.largest(0.0, moments, 1.0) } -> std::convertible_to<double>;
  requires JumpingTorque<One> || requires { one.add(TorquePlace<double>{}, moments, terms); };
};

/// One that a scene can state.
template <class One>
concept TorqueOfScenes = requires {
  {std::string_view(One::keys[0])};
};

/// Whether a kind that is read with an orbit has the member `trajectory`, by which `place.orbit` is found.
template <class One>
constexpr bool has_its_trajectory() {
  if constexpr (TorqueOfScenes<One>) {
    for (const std::string_view key : One::keys) {
      if (key == "orbit") return requires(One one) {
          one.trajectory;
        };
    }
  }
  return true;
}

/// Calls visit.template operator()<One>() for each kind of torque that a scene can state, in the order above.
template <class Visit>
void for_each_torque_kind(const Visit& visit) {
  const auto one = [&]<class Kind>(std::type_identity<Kind>) {
    if constexpr (TorqueOfScenes<Kind>) visit.template operator()<Kind>();
  };
  [&]<class... Kinds>(std::type_identity<std::variant<Kinds...>>) {
    (one(std::type_identity<Kinds>{}), ...);
  }(std::type_identity<Torque>{});
}
static_assert([]<class... Kinds>(std::type_identity<std::variant<Kinds...>>) {
  return (TorqueKind<Kinds> && ...) && (has_its_trajectory<Kinds>() && ...);
}(std::type_identity<Torque>{}));

/// "gravity gradient", "sunlight" …
std::string_view torque_name(const Torque& torque);

/// All torques on one body; they add up. "Body axes" of a torque are the axes that the body's inertia is named in
/// (Inertia::named_from_principal, FreeBody::named_from_principal): motions and plans turn the torques to the principal
/// axes themselves. Where those are the same, as in a FreeBody that says nothing else, body axes are the principal
/// ones.
class Torques {
 public:
  Torques() = default;
  /// Throws InputError, with the torque's name, for one that its description excludes; and for more than
  /// kMostTrajectories different trajectories.
  explicit Torques(std::vector<Torque> torques);

  /// The same torques with the principal axes for body axes, as at() wants them. For a body whose axes are the same,
  /// bit for bit what they were. Throws InputError for a matrix that is no rotation.
  Torques in_principal_axes(const Matrix3& named_from_principal) const;

  /// Whatever the attitude: a time (seconds on the body's clock), and the body's place on each trajectory then.
  static constexpr std::size_t kMostTrajectories = 8;
  template <class Real>
  struct Surroundings {
    Real t_s = 0;
    std::array<OrbitState<Real>, kMostTrajectories> orbits;  // as many as there are trajectories count
  };
  template <class Real>
  Surroundings<Real> surroundings(Real t_s) const {
    Surroundings<Real> now;
    now.t_s = t_s;
    for (std::size_t i = 0; i < trajectories_.size(); ++i) now.orbits[i] = trajectories_[i].state(t_s);
    return now;
  }

  /// The sum in these surroundings at an attitude (v_inertial = R v_principal), for a body of these principal moments
  /// with this rate (left out, torques of one's own do not know it); of torques in principal axes. Those that jump in
  /// time are left out: see during().
  template <class Real>
  TorqueTerms<Real> at(const Surroundings<Real>& surroundings, const Matrix3Of<Real>& inertial_from_body,
                       const Vector3Of<Real>& moments,
                       const Vector3Of<Real>& omega_rad_s = TorquePlace<Real>{}.omega_rad_s) const {
    TorquePlace<Real> place{inertial_from_body, nullptr, nullptr, surroundings.t_s, omega_rad_s};
    TorqueTerms<Real> terms;
    for (std::size_t i = 0; i < torques_.size(); ++i) {
      set_orbits(i, surroundings, place);
      std::visit(
          [&](const auto& one) {
            if constexpr (!JumpingTorque<std::decay_t<decltype(one)>>) one.add(place, moments, terms);
          },
          torques_[i]);
    }
    return terms;
  }
  /// The same at time t and attitude q (unit; v_inertial = q v_principal q*).
  template <class Real>
  TorqueTerms<Real> at(Real t_s, const Eigen::Quaternion<Real>& q, const Vector3Of<Real>& moments,
                       const Vector3Of<Real>& omega_rad_s = TorquePlace<Real>{}.omega_rad_s) const {
    return at(surroundings(t_s), Matrix3Of<Real>(q.toRotationMatrix()), moments, omega_rad_s);
  }

  /// How fast the surroundings change at time t: the least r/v of the trajectories, infinite without one. A step that
  /// is not much longer cannot miss an encounter.
  double time_scale_s(double t_s) const;

  /// Times, ascending, at which a torque jumps: its own jumps, and where one part of a trajectory follows another.
  std::vector<double> jumps_s() const;
  /// The torques at work between two neighbouring jumps, none of which jumps. `inside_s` is any time between the two.
  Torques during(double inside_s) const;

  /// Whether no torque has kinks in time or attitude.
  bool smooth() const;

  /// Times within a span, ascending, at which a torque has a kink whatever the attitude: where an eclipse begins or
  /// ends.
  std::vector<double> times_of_kinks_s(double first_s, double last_s) const;

  /// What one evaluation costs, in evaluations of a gravity gradient, roughly.
  double cost_of_evaluation() const;

  /// The streams on facets at a place, in principal axes: of light, of air. A stream from s makes a kink at each of its
  /// edges, where c = n . s changes its sign: the torque is smooth but for the part of all normals together
  ///
  ///     pressure x (sum, where c > 0, of -c (along x s + c square + linear))
  ///
  /// In the same order at every place; none of torques that have too many edges (Facets::kMostEdges). Replaces what
  /// `streams` holds; its edges live as long as these torques.
  void streams(const Surroundings<double>& surroundings, const Matrix3& inertial_from_body,
               std::vector<TorqueStream>& streams) const;
  bool has_edges() const;

  /// The same torques, those that have tables by them (Facets::with_table()), and after how many evaluations it pays.
  Torques with_tables() const;
  double evaluations_for_tables() const;

  bool empty() const { return torques_.empty(); }
  const std::vector<Trajectory>& trajectories() const { return trajectories_; }  ///< different ones
  const std::vector<Torque>& list() const { return torques_; }

 private:
  static constexpr auto kNone = static_cast<std::size_t>(-1);
  struct Orbits {  // of a torque: its trajectories, or kNone
    std::size_t first = kNone, second = kNone;
  };
  std::size_t index_of(const Trajectory& trajectory);
  template <class Real>
  void set_orbits(std::size_t torque, const Surroundings<Real>& surroundings, TorquePlace<Real>& place) const {
    const auto [first, second] = orbits_of_torque_[torque];
    place.orbit = first == kNone ? nullptr : &surroundings.orbits[first];
    place.second_orbit = second == kNone ? nullptr : &surroundings.orbits[second];
  }

  std::vector<Torque> torques_;
  std::vector<Trajectory> trajectories_;
  std::vector<Orbits> orbits_of_torque_;
};

/// Between two neighbouring jumps: the torques at work, none of which jumps.
struct TorqueStretch {
  double from_s, to_s;
  Torques torques;
};
/// The way from t = 0 to end_s, before or after it, in its stretches, one at least.
std::vector<TorqueStretch> stretches(const Torques& torques, double end_s);

}  // namespace polhode
