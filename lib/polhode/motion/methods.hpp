#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "polhode/motion/motion.hpp"

namespace polhode {

/// A method of computing the free motion, as `polhode methods` lists it.
struct Method {
  std::string_view name;
  std::string_view kind;       ///< "exact", "geometric" or "general"
  std::string_view order;      ///< "exact", "2", "5(4)", "1 to 12" …
  std::string_view conserves;  ///< what it keeps to rounding
  std::string_view fails;      ///< where, or "nowhere known"
  std::string_view source;     ///< paper
  std::unique_ptr<FreeMotion> (*make)(const FreeBody&);
  /// The same for one short step inside a splitting method, in plain double; null where there is no cheaper form.
  std::unique_ptr<FreeMotion> (*make_short)(const FreeBody&) = nullptr;
};

/// All methods, the recommended first.
std::span<const Method> methods();

/// The method of that name, "auto" being the recommended one. Throws InputError naming the allowed ones.
const Method& method(std::string_view name);

}  // namespace polhode
