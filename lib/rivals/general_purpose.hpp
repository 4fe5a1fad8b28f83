#pragma once

#include "rivals/integrated_motion.hpp"

namespace polhode::rivals {

/// Integrators of kept libraries on the seven equations of right_hand_side.hpp, each in its fastest call: interpolated
/// output where the method has it. A library may be missing from a build, and its methods with it (absent_methods).

/// Boost.odeint: Dormand & Prince, J. Comput. Appl. Math. 6, 19 (1980), order 5(4), dense output.
std::int64_t run_dormand_prince_5(const Problem& problem, std::span<const double> times, ScaledState<double>* out);

/// Boost.odeint: Fehlberg, NASA TR R-287 (1968), order 7(8).
std::int64_t run_fehlberg_78(const Problem& problem, std::span<const double> times, ScaledState<double>* out);

/// Boost.odeint: Bulirsch & Stoer, Numer. Math. 8, 1 (1966), variable order.
std::int64_t run_bulirsch_stoer(const Problem& problem, std::span<const double> times, ScaledState<double>* out);

/// Our taylor.hpp, dense output.
std::int64_t run_taylor(const Problem& problem, std::span<const double> times, ScaledState<double>* out);

/// SUNDIALS CVODE, Adams-Moulton of order 1 to 12 with functional iteration, dense output. Hindmarsh et al., ACM TOMS
/// 31, 363 (2005).
std::int64_t run_cvode_adams(const Problem& problem, std::span<const double> times, ScaledState<double>* out);

}  // namespace polhode::rivals
