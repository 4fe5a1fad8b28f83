#include "rivals/torqued_methods.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "rivals/discrete_moser_veselov.hpp"
#include "rivals/extrapolated_motion.hpp"
#include "rivals/general_purpose.hpp"
#include "rivals/quaternion_steps.hpp"
#include "rivals/rotation_splittings.hpp"
#include "rivals/splitting_schemes.hpp"
#include "rivals/torqued_splittings.hpp"

namespace polhode::rivals {

namespace {

template <class Kernel>
TorquedMethod kicked(std::string_view name, std::string_view scheme, std::string_view source) {
  return {name, "other kernel", source, run_fixed_step<KernelSplitting<Kernel>>, &splitting_scheme(scheme), true, true};
}

TorquedMethod general(std::string_view name, std::string_view source, Run run) {
  return {name, "general", source, run, nullptr, false, false};
}

}  // namespace

std::span<const TorquedMethod> torqued_methods() {
  static const std::vector<TorquedMethod> all = [] {
    std::vector<TorquedMethod> list;
    static std::deque<std::string> names;
    for (const SplittingScheme& scheme : splitting_schemes()) {
      names.push_back(fmt::format("theta {}", scheme.name));
      list.push_back(
          {names.back(), "exact kernel", scheme.source, run_fixed_step<ExactSplitting>, &scheme, true, false});
    }
    // Of order 2 as their papers have them, and in the best scheme that there is for small torques.
    constexpr std::string_view celledoni = "Celledoni, Fasso, Safstrom & Zanna, SIAM J. Sci. Comput. 30, 2084 (2008)";
    constexpr std::string_view touma = "Touma & Wisdom, AJ 107, 1189 (1994)";
    constexpr std::string_view hairer = "Hairer & Vilmart, J. Phys. A 39, 13225 (2006)";
    list.push_back(kicked<ThreeRotations<double>>("three-rotations strang", "strang", touma));
    list.push_back(kicked<TopAndRotation<double, 2>>("top-rotation strang", "strang", celledoni));
    list.push_back(kicked<DiscreteMoserVeselov<double, 2>>("dmv strang", "strang", celledoni));
    list.push_back(kicked<DiscreteMoserVeselov<double, 6>>("dmv-6 strang", "strang", hairer));
    list.push_back(kicked<DiscreteMoserVeselov<double, 10>>("dmv-10 strang", "strang", hairer));
    list.push_back(kicked<ThreeRotations<double>>("three-rotations near-10-6-4", "near-10-6-4", touma));
    list.push_back(kicked<TopAndRotation<double, 8>>("top-rotation-8 near-10-6-4", "near-10-6-4", celledoni));
    list.push_back(kicked<DiscreteMoserVeselov<double, 6>>("dmv-6 near-10-6-4", "near-10-6-4", hairer));
    list.push_back(kicked<DiscreteMoserVeselov<double, 10>>("dmv-10 near-10-6-4", "near-10-6-4", hairer));
#ifdef POLHODE_HAS_ODEINT
    list.push_back(
        general("bulirsch-stoer", "Bulirsch & Stoer, Numer. Math. 8, 1 (1966); Boost.odeint", run_bulirsch_stoer));
    list.push_back(general("fehlberg-78", "Fehlberg, NASA TR R-287 (1968); Boost.odeint", run_fehlberg_78));
    list.push_back(general("dormand-prince-5", "Dormand & Prince, J. Comput. Appl. Math. 6, 19 (1980); Boost.odeint",
                           run_dormand_prince_5));
#endif
#ifdef POLHODE_HAS_SUNDIALS
    list.push_back(general("cvode-adams", "Hindmarsh et al., ACM TOMS 31, 363 (2005); SUNDIALS", run_cvode_adams));
#endif
    list.push_back({"rk4", "general", "Kutta, Z. Math. Phys. 46, 435 (1901)", run_fixed_step<ForcedRungeKutta4>,
                    nullptr, true, false});
    return list;
  }();
  return all;
}

std::unique_ptr<Motion> make_torqued_motion(std::string_view name, const FreeBody& body, const Torques& torques,
                                            const StepControl& control, double first_s, double last_s) {
  constexpr std::string_view kExtrapolation = "extrapolation";
  const std::span<const TorquedMethod> all = torqued_methods();
  const auto method = std::find_if(all.begin(), all.end(), [&](const TorquedMethod& one) { return one.name == name; });
  if (method == all.end() && name != kExtrapolation) {
    std::vector<std::string_view> names{kExtrapolation};
    for (const TorquedMethod& one : all) names.push_back(one.name);
    throw InputError(fmt::format("unknown method '{:.40}' to compare with under torques, allowed are {}", name,
                                 fmt::join(names, ", ")));
  }
  if (control.step_s != 0.0 && !(method != all.end() && method->fixed_step)) {
    throw InputError(fmt::format("a step is for methods of fixed step, {} is not one of them", name));
  }
  if (method != all.end()) {
    return std::make_unique<IntegratedMotion>(body, torques, control, method->run, method->scheme);
  }
  auto motion = std::make_unique<ExtrapolatedMotion>(
      body, torques,
      ExtrapolatedMotion::Options{control.tolerance, first_s, last_s,
                                  static_cast<std::size_t>(control.max_evaluations)});
  if (!motion->whole() || !(motion->error_rad() <= control.tolerance)) {
    throw ComputationError(fmt::format(
        "extrapolation took {} torque evaluations{}; its estimated error is {:.1e} rad, {:.1e} rad was asked for",
        motion->evaluations(), motion->whole() ? "" : ", and did not come to the end of the span", motion->error_rad(),
        control.tolerance));
  }
  return motion;
}

}  // namespace polhode::rivals
