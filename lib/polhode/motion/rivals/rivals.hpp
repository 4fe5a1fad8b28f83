#pragma once

#include <span>

#include "polhode/motion/methods.hpp"

namespace polhode::rivals {

/// The integrators that the exact methods are measured against. Each answers a batch of instants in one pass, at() by
/// integrating from t = 0; a method that cannot go on answers NaN.
std::span<const Method> methods();

}  // namespace polhode::rivals
