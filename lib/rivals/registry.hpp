#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "polhode/motion/methods.hpp"
#include "rivals/state.hpp"
#include "rivals/step_control.hpp"

namespace polhode::rivals {

/// A method of computing the free motion as it is measured and compared. Integrators answer a batch of instants in one
/// pass, and at() by integrating from t = 0; one that cannot go on answers NaN.
struct MeasuredMethod : Method {
  /// Integrators: the same as `make`, under control; null for closed forms, which need none.
  std::unique_ptr<Motion> (*make_controlled)(const FreeBody&, const StepControl&) = nullptr;
  int fixed_order = 0;  ///< of a method of fixed steps; 0 of the others
  /// Methods of fixed steps: so many steps in quadruple precision, where their order can be seen.
  void (*advance_in_quadruple)(const InverseMoments<Quadruple>& body, ScaledState<Quadruple>& y, Quadruple step,
                               std::int64_t steps) = nullptr;

  bool fixed_step() const { return fixed_order != 0; }  ///< controlled by StepControl::step_s, else by its tolerance
};

/// The methods of the library, the recommended first, and after them all that they are measured against: the one list
/// behind `polhode methods`, `eval`, `bench` and `chart`.
std::span<const MeasuredMethod> measured_methods();

/// The method of that name, "auto" being the recommended one. Throws InputError naming the allowed ones.
const MeasuredMethod& measured_method(std::string_view name);

/// A method that this build lacks, for want of a library.
struct AbsentMethod {
  std::string_view name;
  std::string_view library;  ///< that this program was built without
};

std::span<const AbsentMethod> absent_methods();

}  // namespace polhode::rivals
