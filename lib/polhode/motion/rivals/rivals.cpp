#include "polhode/motion/rivals/rivals.hpp"

#include <vector>

#include "polhode/motion/rivals/discrete_moser_veselov.hpp"
#include "polhode/motion/rivals/fixed_step.hpp"
#include "polhode/motion/rivals/general_purpose.hpp"
#include "polhode/motion/rivals/implicit_midpoint.hpp"
#include "polhode/motion/rivals/lie_group.hpp"
#include "polhode/motion/rivals/quaternion_steps.hpp"
#include "polhode/motion/rivals/splitting.hpp"

namespace polhode::rivals {

namespace {

template <Run run>
std::unique_ptr<FreeMotion> make_controlled(const FreeBody& body, const StepControl& control) {
  return std::make_unique<IntegratedMotion>(body, control, run);
}
template <Run run>
std::unique_ptr<FreeMotion> make(const FreeBody& body) {
  return make_controlled<run>(body, {});
}

struct Description {
  std::string_view order, conserves, fails, source;
};

template <class Scheme>
Method fixed_step(std::string_view name, std::string_view kind, const Description& d) {
  constexpr Run run = run_fixed_step<Scheme>;
  return {name, kind, d.order, d.conserves, d.fails, d.source, make<run>, nullptr, make_controlled<run>, true};
}

template <Run run>
Method adaptive(std::string_view name, const Description& d) {
  return {name, "general", d.order, d.conserves, d.fails, d.source, make<run>, nullptr, make_controlled<run>, false};
}

constexpr std::string_view keeps_momentum = "momentum (inertial and |m|), |q|; energy oscillates without drift";
constexpr std::string_view keeps_momentum_and_energy = "momentum (inertial and |m|), energy, |q|";
constexpr std::string_view phase = "phase error grows with the span";
constexpr std::string_view drift = "energy and phase errors grow with the span";
constexpr std::string_view tolerance_only = "nothing beyond its tolerance";
constexpr std::string_view tolerance_fails =
    "cost grows with the span and errors faster; below about 1e-13 rounding stops it";

}  // namespace

std::span<const Method> methods() {
  constexpr std::string_view fasso = "Fasso, J. Comput. Phys. 189, 527 (2003)";
  static const std::vector<Method> all{
      fixed_step<ThreeRotations<double>>(
          "three-rotations", "geometric",
          {"2", keeps_momentum, phase,
           "McLachlan, Phys. Rev. Lett. 71, 3043 (1993); Touma & Wisdom, AJ 107, 1189 (1994); Reich, Physica D 76, 375 "
           "(1994)"}),
      fixed_step<TopAndRotation<double, 2>>("top-rotation", "geometric", {"2", keeps_momentum, phase, fasso}),
      fixed_step<TopAndRotation<double, 4>>(
          "top-rotation-4", "geometric",
          {"4", keeps_momentum, phase, "Fasso 2003 with S6 of Blanes & Moan, J. Comput. Appl. Math. 142, 313 (2002)"}),
      fixed_step<TopAndRotation<double, 6>>(
          "top-rotation-6", "geometric",
          {"6", keeps_momentum, phase, "Fasso 2003 with S10 of Blanes & Moan, J. Comput. Appl. Math. 142, 313 (2002)"}),
      fixed_step<TopAndRotation<double, 8>>(
          "top-rotation-8", "geometric",
          {"8", keeps_momentum, phase, "Fasso 2003 with 17 stages of Kahan & Li, Math. Comp. 66, 1089 (1997)"}),
      fixed_step<DiscreteMoserVeselov<double, 2>>(
          "dmv", "geometric",
          {"2", keeps_momentum_and_energy, "no solution for steps longer than about a radian; phase error grows",
           "Moser & Veselov, Commun. Math. Phys. 139, 217 (1991); McLachlan & Zanna, Found. Comput. Math. 5, 87 "
           "(2005)"}),
      fixed_step<DiscreteMoserVeselov<double, 6>>(
          "dmv-6", "geometric",
          {"6", keeps_momentum_and_energy, "no solution for steps longer than about a quarter turn; phase error grows",
           "Hairer & Vilmart, J. Phys. A 39, 13225 (2006)"}),
      fixed_step<DiscreteMoserVeselov<double, 10>>(
          "dmv-10", "geometric",
          {"10", keeps_momentum_and_energy, "no solution for steps longer than about a quarter turn; phase error grows",
           "Hairer & Vilmart, J. Phys. A 39, 13225 (2006)"}),
      fixed_step<ImplicitMidpoint<double>>(
          "implicit-midpoint", "geometric",
          {"2", keeps_momentum_and_energy, phase, "Austin, Krishnaprasad & Wang, J. Comput. Phys. 107, 105 (1993)"}),
      fixed_step<RungeKuttaMuntheKaas4<double>>(
          "rkmk-4", "geometric",
          {"4", "momentum (inertial and |m|), |q|", drift, "Munthe-Kaas, Appl. Numer. Math. 29, 115 (1999)"}),
      fixed_step<CommutatorFree4<double>>(
          "commutator-free-4", "geometric",
          {"4", "momentum (inertial and |m|), |q|", drift,
           "Celledoni, Marthinsen & Owren, Future Gener. Comput. Syst. 19, 341 (2003)"}),
      adaptive<run_taylor>("taylor", {"1 - ln(tolerance) / 2", tolerance_only, tolerance_fails,
                                      "Jorba & Zou, Exp. Math. 14, 99 (2005)"}),
#ifdef POLHODE_HAS_ODEINT
      adaptive<run_bulirsch_stoer>("bulirsch-stoer", {"variable", tolerance_only, tolerance_fails,
                                                      "Bulirsch & Stoer, Numer. Math. 8, 1 (1966); Boost.odeint"}),
      adaptive<run_fehlberg_78>(
          "fehlberg-78", {"7(8)", tolerance_only, tolerance_fails, "Fehlberg, NASA TR R-287 (1968); Boost.odeint"}),
      adaptive<run_dormand_prince_5>("dormand-prince-5",
                                     {"5(4)", tolerance_only, tolerance_fails,
                                      "Dormand & Prince, J. Comput. Appl. Math. 6, 19 (1980); Boost.odeint"}),
#endif
#ifdef POLHODE_HAS_SUNDIALS
      adaptive<run_cvode_adams>("cvode-adams", {"1 to 12", tolerance_only, tolerance_fails,
                                                "Hindmarsh et al., ACM TOMS 31, 363 (2005); SUNDIALS"}),
#endif
      fixed_step<ClassicalRungeKutta4<double, false>>("rk4", "general",
                                                      {"4", "nothing", drift, "Kutta, Z. Math. Phys. 46, 435 (1901)"}),
      fixed_step<ClassicalRungeKutta4<double, true>>(
          "rk4-renormalised", "general",
          {"4", "|q|", "renormalising q hides the error and does not lessen it", "Kutta 1901, q divided by |q|"}),
      fixed_step<FirstOrderQuaternion<double>>(
          "quaternion-1", "general",
          {"1", "|q|", "momentum and energy grow exponentially: useless beyond a few turns", "common practice"}),
  };
  return all;
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
