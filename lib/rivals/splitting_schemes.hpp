#pragma once

#include <span>
#include <string_view>

#include "polhode/motion/splitting.hpp"

namespace polhode::rivals {

/// Schemes of kicks between exact free motion: the library's own and those that are compared with them, by rising
/// order.
std::span<const SplittingScheme> splitting_schemes();

/// The scheme of that name. Throws InputError naming the allowed ones.
const SplittingScheme& splitting_scheme(std::string_view name);

}  // namespace polhode::rivals
