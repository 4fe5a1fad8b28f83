// Included once by each target_*.cpp, which is compiled for its own instruction set.

#include "polhode/motion/theta/batch.hpp"
#include "polhode/motion/theta/build.hpp"
#include "polhode/motion/theta/single.hpp"

namespace polhode::theta {
namespace {

void build_any_span(const Input& in, Solution& out) { build<DoubleDouble>(in, out); }
void build_short_span(const Input& in, Solution& out) { build<double>(in, out); }

void at_one(const Solution& s, double t_high, double t_low, double q_xyzw[4], double m[3]) {
  Pair<double> t{t_high, t_low};
  if (t_low != 0.0) t = pair_sum(t_high, t_low);  // the parts may overlap
  dispatch(s, [&](const auto& at) { evaluate_at(at, t.high, t.low, q_xyzw, m); });
}

void batch_of(const Solution& s, const BatchArguments& arguments) {
  if (arguments.m[0] != nullptr) {
    dispatch(s, [&](const auto& at) { batch_with<true>(at, arguments); });
  } else {
    dispatch(s, [&](const auto& at) { batch_with<false>(at, arguments); });
  }
}

}  // namespace
}  // namespace polhode::theta
