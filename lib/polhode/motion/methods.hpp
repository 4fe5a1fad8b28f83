#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "polhode/motion/motion.hpp"

namespace polhode {

/// What a user may choose about an integrator. Zero leaves the choice to the method.
struct StepControl {
  double step_s = 0.0;     ///< of fixed-step methods; by default a hundredth of a turn at the initial rate
  double tolerance = 0.0;  ///< of adaptive methods, absolute and relative, |m| and |q| being 1; by default 1e-10
  /// Splittings between kicks of a torque: of the free motion, where that is not exact; by default one step per drift.
  double free_step_s = 0.0;
  /// A span that would cost more than about this is not computed: its answers are NaN. 0 is no limit.
  std::int64_t max_evaluations = 0;
};

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
  /// Integrators: the same as `make`, under control; null for the exact methods, which need none.
  std::unique_ptr<FreeMotion> (*make_controlled)(const FreeBody&, const StepControl&) = nullptr;
  bool fixed_step = false;        ///< controlled by StepControl::step_s, else by its tolerance
  bool exact_everywhere = false;  ///< to rounding, for every body and span: such a method may promise its error unseen
};

/// All methods, the recommended first.
std::span<const Method> methods();

/// The method of that name, "auto" being the recommended one. Throws InputError naming the allowed ones.
const Method& method(std::string_view name);

}  // namespace polhode
