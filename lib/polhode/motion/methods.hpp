#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "polhode/motion/motion.hpp"

namespace polhode {

/// What a method keeps to rounding.
struct Conserved {
  std::string_view text;  ///< all of it, in words
  bool momentum = false;  ///< in inertial axes, and with it its length
  bool energy = false;
  bool norm = false;  ///< |q|
};

/// A method of computing the free motion, as `polhode methods` lists it.
struct Method {
  std::string_view name;
  std::string_view kind;    ///< "exact", "geometric" or "general"
  std::string_view family;  ///< within the kind: what charts draw alike
  std::string_view order;   ///< "exact", "2", "5(4)", "1 to 12" …
  Conserved conserves;
  std::string_view fails;   ///< where, or "nowhere known"
  std::string_view source;  ///< paper
  std::unique_ptr<Motion> (*make)(const FreeBody&);
  /// The same for one short step inside a splitting method, in plain double; null where there is no cheaper form.
  std::unique_ptr<Motion> (*make_short)(const FreeBody&) = nullptr;
  bool exact_everywhere = false;  ///< to rounding, for every body and span: such a method may promise its error unseen
};

/// The methods of the library, the recommended first. All are exact; `rivals/registry.hpp` of the source tree has those
/// that they are measured against.
std::span<const Method> methods();

/// The method of that name, "auto" being the recommended one. Throws InputError naming the allowed ones.
const Method& method(std::string_view name);

}  // namespace polhode
