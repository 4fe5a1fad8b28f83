#include "polhode/motion/methods.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/celledoni.hpp"
#include "polhode/motion/legendre.hpp"
#include "polhode/motion/rivals/rivals.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {

std::span<const Method> methods() {
  static const std::vector<Method> exact{
      {.name = "theta",
       .kind = "exact",
       .order = "exact",
       .conserves = "everything",
       .fails = "nowhere known",
       .source = "theta.md; Jacobi 1850",
       .make = [](const FreeBody& body) -> std::unique_ptr<FreeMotion> { return std::make_unique<ThetaMotion>(body); },
       .make_short = [](const FreeBody& body) -> std::unique_ptr<FreeMotion> {
         return std::make_unique<ThetaMotion>(body, ThetaMotion::Span::step);
       },
       .exact_everywhere = true},
      {.name = "legendre",
       .kind = "exact",
       .order = "exact",
       .conserves = "everything",
       .fails = "nowhere known",
       .source = "legendre.md; Leroy 2020, On an Article by Celledoni et al.",
       .make = make_legendre,
       .exact_everywhere = true},
      {.name = "matrix-basis",
       .kind = "exact",
       .order = "exact",
       .conserves = "everything, while it works",
       .fails = "constant momentum; long stays beside the middle axis; beside any axis with few digits; extreme units",
       .source = "Celledoni et al. 2007, matrix form, with the corrections of Leroy 2020, who gives it up",
       .make = make_matrix_basis},
      {.name = "cfsz-quaternion",
       .kind = "exact",
       .order = "exact",
       .conserves = "everything, while it works",
       .fails = "momentum at or near -e3; constant momentum; beside the separatrix with few digits; extreme units",
       .source = "Celledoni et al. 2007, quaternion form, with the corrections of Leroy 2020, who gives it up",
       .make = make_cfsz_quaternion},
  };
  static const std::vector<Method> all = [] {
    std::vector<Method> list = exact;
    const std::span<const Method> integrators = rivals::methods();
    list.insert(list.end(), integrators.begin(), integrators.end());
    return list;
  }();
  return all;
}

const Method& method(std::string_view name) {
  std::string allowed = "auto";
  for (const Method& m : methods()) {
    if (name == m.name || name == "auto") return m;
    allowed += fmt::format(", {}", m.name);
  }
  for (const rivals::AbsentMethod& absent : rivals::absent_methods()) {
    if (name == absent.name) {
      throw InputError(fmt::format("method '{}' is absent: this program was built without {}; allowed are {}", name,
                                   absent.library, allowed));
    }
  }
  throw InputError(fmt::format("unknown method '{:.40}', allowed are {}", name, allowed));
}

}  // namespace polhode
