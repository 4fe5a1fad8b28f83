// Included once by each target_*.cpp, which is compiled for its own instruction set.

#include "polhode/motion/theta/batch.hpp"
#include "polhode/motion/theta/bodies_build.hpp"
#include "polhode/motion/theta/bodies_kernel.hpp"
#include "polhode/motion/theta/build_partials.hpp"
#include "polhode/motion/theta/partials_batch.hpp"
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

void build_partials_any_span(const Input& in, Solution& out, PartialsSolution& partials) {
  build_with_partials<DoubleDouble>(in, out, partials);
}

void partials_at_one(const Solution& s, const PartialsSolution& p, double t_high, double t_low, double q_xyzw[4],
                     double m[3], double (&matrix)[54]) {
  Pair<double> t{t_high, t_low};
  if (t_low != 0.0) t = pair_sum(t_high, t_low);
  dispatch(s, p, [&](const auto& at, const auto& partials_at) {
    evaluate_at(at, t.high, t.low, q_xyzw, m);
    const double qs[4] = {q_xyzw[3], q_xyzw[0], q_xyzw[1], q_xyzw[2]};
    const double ms[3] = {m[0], m[1], m[2]};
    matrix_of_state(partials_at, t.high, t.low, qs, ms, matrix);
  });
}

void partials_batch_of(const Solution& s, const PartialsSolution& p, const PartialsBatchArguments& arguments) {
  dispatch(s, p, [&](const auto& at, const auto& partials_at) { partials_batch_with(at, partials_at, arguments); });
}

unsigned build_block_any_span(const BlockInput& in, BodyBlock& out) { return build_block<LanePairs>(in, out); }
unsigned build_block_short_span(const BlockInput& in, BodyBlock& out) { return build_block<Lanes>(in, out); }
void block_states(const BodyBlock& s, const BlockTimes& times, BlockStates& states) { block_at(s, times, states); }

constexpr Target target_named(const char* name) {
  return {name,
          kLanes,
          build_any_span,
          build_short_span,
          at_one,
          batch_of,
          build_partials_any_span,
          partials_at_one,
          partials_batch_of,
          build_block_any_span,
          build_block_short_span,
          block_states};
}

}  // namespace
}  // namespace polhode::theta
