#include "polhode/motion/methods.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {

std::span<const Method> methods() {
  static const std::vector<Method> all{
      {"theta", "exact", "exact", "everything", "nowhere known", "theta.md; Jacobi 1850",
       [](const FreeBody& body) -> std::unique_ptr<FreeMotion> { return std::make_unique<ThetaMotion>(body); },
       [](const FreeBody& body) -> std::unique_ptr<FreeMotion> {
         return std::make_unique<ThetaMotion>(body, ThetaMotion::Span::step);
       }},
  };
  return all;
}

const Method& method(std::string_view name) {
  std::string allowed = "auto";
  for (const Method& m : methods()) {
    if (name == m.name || name == "auto") return m;
    allowed += fmt::format(", {}", m.name);
  }
  throw InputError(fmt::format("unknown method '{:.40}', allowed are {}", name, allowed));
}

}  // namespace polhode
