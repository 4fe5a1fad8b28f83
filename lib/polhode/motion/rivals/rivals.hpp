#pragma once

#include <span>
#include <string_view>

#include "polhode/motion/methods.hpp"

namespace polhode::rivals {

/// The integrators that the exact methods are measured against. Each answers a batch of instants in one pass, at() by
/// integrating from t = 0; a method that cannot go on answers NaN.
std::span<const Method> methods();

/// A method that this build lacks, for want of a library.
struct AbsentMethod {
  std::string_view name;
  std::string_view library;
};

std::span<const AbsentMethod> absent_methods();

}  // namespace polhode::rivals
