#include "polhode/motion/methods.hpp"

#include <fmt/format.h>

#include <string>

#include "polhode/base/error.hpp"
#include "polhode/motion/legendre.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {
namespace {

constexpr Conserved kEverything{"everything", true, true, true};

constexpr Method kMethods[] = {
    {.name = "theta",
     .kind = "exact",
     .family = "exact",
     .order = "exact",
     .conserves = kEverything,
     .fails = "nowhere known",
     .source = "theta.md; Jacobi 1850",
     .make = [](const FreeBody& body) -> std::unique_ptr<Motion> { return std::make_unique<ThetaMotion>(body); },
     .make_short = [](const FreeBody& body) -> std::unique_ptr<Motion> {
       return std::make_unique<ThetaMotion>(body, ThetaMotion::Span::step);
     },
     .exact_everywhere = true},
    {.name = "legendre",
     .kind = "exact",
     .family = "exact",
     .order = "exact",
     .conserves = kEverything,
     .fails = "nowhere known",
     .source = "legendre.md; Leroy 2020, On an Article by Celledoni et al.",
     .make = make_legendre,
     .exact_everywhere = true},
};

}  // namespace

std::span<const Method> methods() { return kMethods; }

const Method& method(std::string_view name) {
  std::string allowed = "auto";
  for (const Method& m : methods()) {
    if (name == m.name || name == "auto") return m;
    allowed += fmt::format(", {}", m.name);
  }
  throw InputError(fmt::format("unknown method '{:.40}', allowed are {}", name, allowed));
}

}  // namespace polhode
