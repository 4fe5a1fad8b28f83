#include "rivals/registry.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "rivals/celledoni.hpp"
#include "rivals/discrete_moser_veselov.hpp"
#include "rivals/fixed_step.hpp"
#include "rivals/general_purpose.hpp"
#include "rivals/implicit_midpoint.hpp"
#include "rivals/integrated_motion.hpp"
#include "rivals/lie_group.hpp"
#include "rivals/quaternion_steps.hpp"
#include "rivals/rotation_splittings.hpp"

namespace polhode::rivals {

namespace {

template <Run run>
std::unique_ptr<Motion> make_controlled(const FreeBody& body, const StepControl& control) {
  return std::make_unique<IntegratedMotion>(body, control, run);
}
template <Run run>
std::unique_ptr<Motion> make(const FreeBody& body) {
  return make_controlled<run>(body, {});
}

/// What is drawn alike.
struct Family {
  std::string_view kind, name;
};
constexpr Family exact{"exact", "exact"};
constexpr Family splitting{"geometric", "splitting"};
constexpr Family moser_veselov{"geometric", "moser-veselov"};
constexpr Family lie_group{"geometric", "lie group"};
constexpr Family adaptive_steps{"general", "adaptive"};
constexpr Family quaternion{"general", "quaternion"};

constexpr Conserved everything_while{
    .text = "everything, while it works", .momentum = true, .energy = true, .norm = true};
constexpr Conserved momentum_and_bounded_energy{
    .text = "momentum (inertial and |m|), |q|; energy oscillates without drift", .momentum = true, .norm = true};
constexpr Conserved momentum_and_energy{
    .text = "momentum (inertial and |m|), energy, |q|", .momentum = true, .energy = true, .norm = true};
constexpr Conserved momentum_alone{.text = "momentum (inertial and |m|), |q|", .momentum = true, .norm = true};
constexpr Conserved norm_alone{.text = "|q|", .norm = true};
constexpr Conserved tolerance_only{.text = "nothing beyond its tolerance"};
constexpr Conserved nothing{.text = "nothing"};

constexpr std::string_view phase = "phase error grows with the span";
constexpr std::string_view drift = "energy and phase errors grow with the span";
constexpr std::string_view tolerance_fails =
    "cost grows with the span and errors faster; below about 1e-13 rounding stops it";

template <template <class> class Scheme>
void advance_in_quadruple(const InverseMoments<Quadruple>& body, ScaledState<Quadruple>& y, Quadruple step,
                          std::int64_t steps) {
  Scheme<Quadruple>(body, y, step).advance(y, steps);
}

template <template <class> class Scheme>
MeasuredMethod fixed_step(std::string_view name, const Family& family, const Conserved& conserves,
                          std::string_view fails, std::string_view source) {
  constexpr Run run = run_fixed_step<Scheme<double>>;
  static const std::string order = std::to_string(Scheme<double>::order);
  return {{name, family.kind, family.name, order, conserves, fails, source, make<run>},
          make_controlled<run>,
          Scheme<double>::order,
          advance_in_quadruple<Scheme>};
}

template <Run run>
MeasuredMethod adaptive(std::string_view name, std::string_view order, std::string_view source) {
  return {{name, adaptive_steps.kind, adaptive_steps.name, order, tolerance_only, tolerance_fails, source, make<run>},
          make_controlled<run>};
}

MeasuredMethod closed_form(std::string_view name, std::string_view fails, std::string_view source,
                           std::unique_ptr<Motion> (*make)(const FreeBody&)) {
  return {{name, exact.kind, exact.name, "exact", everything_while, fails, source, make}};
}

template <class Real>
using TopAndRotation2 = TopAndRotation<Real, 2>;
template <class Real>
using TopAndRotation4 = TopAndRotation<Real, 4>;
template <class Real>
using TopAndRotation6 = TopAndRotation<Real, 6>;
template <class Real>
using TopAndRotation8 = TopAndRotation<Real, 8>;
template <class Real>
using DiscreteMoserVeselov2 = DiscreteMoserVeselov<Real, 2>;
template <class Real>
using DiscreteMoserVeselov6 = DiscreteMoserVeselov<Real, 6>;
template <class Real>
using DiscreteMoserVeselov10 = DiscreteMoserVeselov<Real, 10>;
template <class Real>
using PlainRungeKutta4 = ClassicalRungeKutta4<Real, false>;
template <class Real>
using RenormalisedRungeKutta4 = ClassicalRungeKutta4<Real, true>;

/// A row per rival.
std::vector<MeasuredMethod> rival_methods() {
  constexpr std::string_view fasso = "Fasso, J. Comput. Phys. 189, 527 (2003)";
  constexpr std::string_view no_long_steps =
      "no solution for steps longer than about a quarter turn; phase error grows";
  return {
      closed_form(
          "matrix-basis",
          "constant momentum; long stays beside the middle axis; beside any axis with few digits; extreme units",
          "Celledoni et al. 2007, matrix form, with the corrections of Leroy 2020, who gives it up", make_matrix_basis),
      closed_form("cfsz-quaternion",
                  "momentum at or near -e3; constant momentum; beside the separatrix with few digits; extreme units",
                  "Celledoni et al. 2007, quaternion form, with the corrections of Leroy 2020, who gives it up",
                  make_cfsz_quaternion),
      fixed_step<ThreeRotations>(
          "three-rotations", splitting, momentum_and_bounded_energy, phase,
          "McLachlan, Phys. Rev. Lett. 71, 3043 (1993); Touma & Wisdom, AJ 107, 1189 (1994); Reich, Physica D 76, 375 "
          "(1994)"),
      fixed_step<TopAndRotation2>("top-rotation", splitting, momentum_and_bounded_energy, phase, fasso),
      fixed_step<TopAndRotation4>("top-rotation-4", splitting, momentum_and_bounded_energy, phase,
                                  "Fasso 2003 with S6 of Blanes & Moan, J. Comput. Appl. Math. 142, 313 (2002)"),
      fixed_step<TopAndRotation6>("top-rotation-6", splitting, momentum_and_bounded_energy, phase,
                                  "Fasso 2003 with S10 of Blanes & Moan, J. Comput. Appl. Math. 142, 313 (2002)"),
      fixed_step<TopAndRotation8>("top-rotation-8", splitting, momentum_and_bounded_energy, phase,
                                  "Fasso 2003 with 17 stages of Kahan & Li, Math. Comp. 66, 1089 (1997)"),
      fixed_step<DiscreteMoserVeselov2>(
          "dmv", moser_veselov, momentum_and_energy,
          "no solution for steps longer than about a radian; phase error grows",
          "Moser & Veselov, Commun. Math. Phys. 139, 217 (1991); McLachlan & Zanna, Found. Comput. Math. 5, 87 (2005)"),
      fixed_step<DiscreteMoserVeselov6>("dmv-6", moser_veselov, momentum_and_energy, no_long_steps,
                                        "Hairer & Vilmart, J. Phys. A 39, 13225 (2006)"),
      fixed_step<DiscreteMoserVeselov10>("dmv-10", moser_veselov, momentum_and_energy, no_long_steps,
                                         "Hairer & Vilmart, J. Phys. A 39, 13225 (2006)"),
      fixed_step<ImplicitMidpoint>("implicit-midpoint", moser_veselov, momentum_and_energy, phase,
                                   "Austin, Krishnaprasad & Wang, J. Comput. Phys. 107, 105 (1993)"),
      fixed_step<RungeKuttaMuntheKaas4>("rkmk-4", lie_group, momentum_alone, drift,
                                        "Munthe-Kaas, Appl. Numer. Math. 29, 115 (1999)"),
      fixed_step<CommutatorFree4>("commutator-free-4", lie_group, momentum_alone, drift,
                                  "Celledoni, Marthinsen & Owren, Future Gener. Comput. Syst. 19, 341 (2003)"),
      adaptive<run_taylor>("taylor", "1 - ln(tolerance) / 2", "Jorba & Zou, Exp. Math. 14, 99 (2005)"),
#ifdef POLHODE_HAS_ODEINT
      adaptive<run_bulirsch_stoer>("bulirsch-stoer", "variable",
                                   "Bulirsch & Stoer, Numer. Math. 8, 1 (1966); Boost.odeint"),
      adaptive<run_fehlberg_78>("fehlberg-78", "7(8)", "Fehlberg, NASA TR R-287 (1968); Boost.odeint"),
      adaptive<run_dormand_prince_5>("dormand-prince-5", "5(4)",
                                     "Dormand & Prince, J. Comput. Appl. Math. 6, 19 (1980); Boost.odeint"),
#endif
#ifdef POLHODE_HAS_SUNDIALS
      adaptive<run_cvode_adams>("cvode-adams", "1 to 12", "Hindmarsh et al., ACM TOMS 31, 363 (2005); SUNDIALS"),
#endif
      fixed_step<PlainRungeKutta4>("rk4", quaternion, nothing, drift, "Kutta, Z. Math. Phys. 46, 435 (1901)"),
      fixed_step<RenormalisedRungeKutta4>("rk4-renormalised", quaternion, norm_alone,
                                          "renormalising q hides the error and does not lessen it",
                                          "Kutta 1901, q divided by |q|"),
      fixed_step<FirstOrderQuaternion>("quaternion-1", quaternion, norm_alone,
                                       "momentum and energy grow exponentially: useless beyond a few turns",
                                       "common practice"),
  };
}

}  // namespace

std::span<const MeasuredMethod> measured_methods() {
  static const std::vector<MeasuredMethod> all = [] {
    std::vector<MeasuredMethod> list;
    for (const Method& own : methods()) list.push_back({own});
    const std::vector<MeasuredMethod> rivals = rival_methods();
    list.insert(list.end(), rivals.begin(), rivals.end());
    return list;
  }();
  return all;
}

const MeasuredMethod& measured_method(std::string_view name) {
  std::string allowed = "auto";
  for (const MeasuredMethod& m : measured_methods()) {
    if (name == m.name || name == "auto") return m;
    allowed += fmt::format(", {}", m.name);
  }
  for (const auto& [absent, library] : absent_methods()) {
    if (name == absent) {
      throw InputError(fmt::format("method '{}' is absent: this program was built without {}; allowed are {}", name,
                                   library, allowed));
    }
  }
  throw InputError(fmt::format("unknown method '{:.40}', allowed are {}", name, allowed));
}

std::span<const AbsentMethod> absent_methods() {
  static const std::vector<AbsentMethod> all{
#ifndef POLHODE_HAS_ODEINT
      {"bulirsch-stoer", "Boost.odeint"},
      {"fehlberg-78", "Boost.odeint"},
      {"dormand-prince-5", "Boost.odeint"},
#endif
#ifndef POLHODE_HAS_SUNDIALS
      {"cvode-adams", "SUNDIALS"},
#endif
  };
  return all;
}

}  // namespace polhode::rivals
