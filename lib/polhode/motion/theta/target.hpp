// Included once by each target_*.cpp, which is compiled for its own instruction set.

#include "polhode/motion/theta/batch.hpp"
#include "polhode/motion/theta/build.hpp"

namespace polhode::theta {
namespace {

void build_any_span(const Input& in, Solution& out) { build<DoubleDouble>(in, out); }
void build_short_span(const Input& in, Solution& out) { build<double>(in, out); }

void at_one(const Solution& s, double t_high, double t_low, double q_xyzw[4], double m[3]) {
  dispatch(s, [&](const auto& at) {
    double qs[4], ms[3];
    const Pair<double> t = two_sum<double>(t_high, t_low);
    at.state(at.phases(t.high, t.low), qs, ms);
    for (int k = 0; k < 4; ++k) q_xyzw[k] = qs[(k + 1) % 4];
    for (int k = 0; k < 3; ++k) m[k] = ms[k];
  });
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
