#include "polhode/motion/free_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"

namespace polhode {
namespace {

using theta::kBlock;
using Block = FreeBodies::Block;
using BlockRows = FreeBodies::BlockRows;

std::size_t blocks_of(std::size_t count) { return (count + kBlock - 1) / kBlock; }

// A block's bodies component by component; beyond the last body that one again.
theta::BlockInput block_input(const BodyArrays& bodies, std::size_t first) {
  theta::BlockInput in;
  for (int lane = 0; lane < kBlock; ++lane) {
    const auto row = static_cast<std::ptrdiff_t>(std::min(first + static_cast<std::size_t>(lane), bodies.count - 1));
    for (int k = 0; k < 3; ++k) in.moments[k][lane] = bodies.moments[k][row * bodies.moments_stride];
    for (int k = 0; k < 4; ++k) in.q[k][lane] = bodies.q[k][row * bodies.q_stride];
    for (int k = 0; k < 3; ++k) in.momentum[k][lane] = bodies.momentum[k][row * bodies.momentum_stride];
  }
  return in;
}

void copy_lane(const theta::BodyBlock& from, theta::BodyBlock& to, int lane) {
  static_assert(sizeof(theta::BodyBlock) % (kBlock * sizeof(double)) == 0);
  const auto* const source = reinterpret_cast<const double*>(&from);
  auto* const place = reinterpret_cast<double*>(&to);
  for (std::size_t i = static_cast<std::size_t>(lane); i < sizeof from / sizeof(double); i += kBlock) {
    place[i] = source[i];
  }
}

// The lanes whose short form keeps the tolerance.
unsigned short_enough(const theta::BodyBlock& lanes, const BodiesOptions& options) {
  unsigned enough = 0;
  for (int k = 0; k < kBlock; ++k) {
    const double quarters_per_s =
        2.0 * std::abs(lanes.rho_quarters_per_s[0][k]) + std::abs(lanes.v_quarters_per_s[0][k]);
    const double angle_rad = 0.5 * std::numbers::pi * quarters_per_s * options.longest_s;
    if (theta::short_form_error_rad(angle_rad) <= options.tolerance_rad) enough |= 1U << k;
  }
  return enough;
}

void build_block(const BodyArrays& bodies, std::size_t first, std::size_t number, const BodiesOptions& options,
                 const theta::Target& target, Block& block) {
  const theta::BlockInput in = block_input(bodies, first);
  const unsigned all = (1U << kBlock) - 1U;
  block.short_form = 0;
  block.others.clear();
  if (options.tolerance_rad > 0.0) {
    block.alone = target.build_block_short(in, block.lanes);
    block.short_form = short_enough(block.lanes, options) & ~block.alone;
  }
  if ((block.short_form | block.alone) != all || options.tolerance_rad <= 0.0) {
    theta::BodyBlock any_span;
    block.alone = target.build_block(in, any_span);
    block.short_form &= ~block.alone;
    for (int lane = 0; lane < kBlock; ++lane) {
      if ((block.short_form >> lane & 1U) == 0) copy_lane(any_span, block.lanes, lane);
    }
  }
  for (unsigned rest = block.alone; rest != 0; rest &= rest - 1) {
    const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(rest));
    if (i >= bodies.count) break;
    const FreeBody body = bodies.at(i);
    try {
      checked(body);
    } catch (const InputError& error) {
      throw InputError(fmt::format("body {}: {}", number + i, error.what()));
    }
    target.build(theta_input(body), block.others.emplace_back());
  }
}

// A block's bodies, each at its own time, to the rows given; of `here` bodies.
void answer_block(const theta::Target& target, const Block& block, int here, const theta::BlockTimes& times,
                  const StateArrays& out, const BlockRows& rows) {
  if (block.alone != (1U << kBlock) - 1U) {
    theta::BlockStates states;
    target.block_at(block.lanes, times, states);
    for (int k = 0; k < 4; ++k) {
      for (int lane = 0; lane < here; ++lane) out.q[k][rows[lane] * out.q_stride] = states.q[k][lane];
    }
    for (int k = 0; k < 3 && out.m[0] != nullptr; ++k) {
      for (int lane = 0; lane < here; ++lane) out.m[k][rows[lane] * out.m_stride] = states.m[k][lane];
    }
  }
  std::size_t other = 0;
  for (unsigned rest = block.alone; rest != 0 && other < block.others.size(); rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    State state;
    target.at(block.others[other++], times.high[lane], times.low[lane], state.q_inertial_from_body.coeffs().data(),
              state.momentum_body.data());
    out.put(static_cast<std::size_t>(rows[lane]), state);
  }
}

// The body of a lane by itself, with its constants in the form of theta::OutputFrame: the product of `frame` with a
// quaternion, by the components of that.
theta::Solution solution_of(const theta::BodyBlock& lanes, int lane) {
  theta::Solution out;
  out.chart = theta::Chart::fourier;
  out.long_axis_mode = lanes.long_axis_mode[lane] < 0.0;
  out.fourier = {};
  theta::FourierChart& chart = out.fourier;
  chart.rho_quarters_per_s = {lanes.rho_quarters_per_s[0][lane], lanes.rho_quarters_per_s[1][lane]};
  chart.v_quarters_per_s = {lanes.v_quarters_per_s[0][lane], lanes.v_quarters_per_s[1][lane]};
  chart.v_quarters_at_0 = lanes.v_quarters_at_0[lane];
  chart.v_whole_quarters_at_0 = lanes.v_whole_quarters_at_0[lane];
  for (int n = 0; n <= theta::kMaxDegree; ++n) {
    for (int i = 0; i < 4; ++i) {
      chart.polynomial[n][i] = lanes.polynomial[n][i][lane];
      if (chart.polynomial[n][i] != 0.0) chart.degree = n;
    }
  }
  const double f[4] = {lanes.frame[0][lane], lanes.frame[1][lane], lanes.frame[2][lane], lanes.frame[3][lane]};
  const double columns[4][4] = {
      {f[0], f[1], f[2], f[3]}, {-f[1], f[0], f[3], -f[2]}, {-f[2], -f[3], f[0], f[1]}, {-f[3], f[2], -f[1], f[0]}};
  for (int i = 0; i < 4; ++i) {
    const int column = i % 2 == 1 && out.long_axis_mode ? 4 - i : i;
    for (int k = 0; k < 4; ++k) {
      chart.frame.frame[i][k] = i == 0 ? columns[0][k] : lanes.sign[i - 1][lane] * columns[column][k];
    }
  }
  for (int k = 0; k < 3; ++k) chart.frame.momentum_scale[k] = lanes.momentum_scale[k][lane];
  chart.frame.exchange_1_3 = out.long_axis_mode;
  return out;
}

// One body of a block at all times.
void answer_body(const theta::Target& target, const Block& block, int lane, const theta::BatchArguments& arguments) {
  if ((block.alone >> lane & 1U) == 0) return target.batch(solution_of(block.lanes, lane), arguments);
  const auto before = static_cast<std::size_t>(std::popcount(block.alone & ((1U << lane) - 1U)));
  target.batch(block.others.at(before), arguments);
}

int bodies_in_block(std::size_t block, std::size_t count) {
  return static_cast<int>(std::min<std::size_t>(kBlock, count - block * kBlock));
}

void answer_grid(const theta::Target& target, const Block& block, std::size_t number, int here, const TimeArrays& times,
                 const StateArrays& out, const GridRows& grid) {
  if (times.high.size() >= FreeBodies::kManyTimes) {
    for (int lane = 0; lane < here; ++lane) {
      const std::ptrdiff_t row = (static_cast<std::ptrdiff_t>(number * kBlock) + lane) * grid.body_rows;
      StateArrays to = part_of(out, static_cast<std::size_t>(row));
      to.q_stride *= grid.time_rows;
      to.m_stride *= grid.time_rows;
      answer_body(target, block, lane, theta_batch(times, to));
    }
    return;
  }
  theta::BlockTimes all{};
  BlockRows rows;
  for (std::size_t j = 0; j < times.high.size(); ++j) {
    std::fill_n(all.high, kBlock, times.high[j]);
    if (!times.low.empty()) std::fill_n(all.low, kBlock, times.low[j]);
    for (int lane = 0; lane < kBlock; ++lane) {
      rows[lane] = (static_cast<std::ptrdiff_t>(number * kBlock) + lane) * grid.body_rows +
                   static_cast<std::ptrdiff_t>(j) * grid.time_rows;
    }
    answer_block(target, block, here, all, out, rows);
  }
}

}  // namespace

BodyArrays BodyArrays::of_structures(const double* moments, const double* q, const double* momentum,
                                     std::size_t count) {
  BodyArrays a;
  for (int k = 0; k < 3; ++k) a.moments[k] = moments + k;
  for (int k = 0; k < 4; ++k) a.q[k] = q + k;
  for (int k = 0; k < 3; ++k) a.momentum[k] = momentum + k;
  a.count = count;
  return a;
}

BodyArrays BodyArrays::of_bodies(std::span<const FreeBody> bodies) {
  static_assert(sizeof(FreeBody) % sizeof(double) == 0);
  constexpr std::ptrdiff_t stride = sizeof(FreeBody) / sizeof(double);
  BodyArrays a;
  a.moments_stride = a.q_stride = a.momentum_stride = stride;
  a.count = bodies.size();
  if (bodies.empty()) return a;
  const double* xyzw = bodies.front().q_inertial_from_body.coeffs().data();
  for (int k = 0; k < 4; ++k) a.q[k] = xyzw + (k + 3) % 4;
  for (int k = 0; k < 3; ++k) {
    a.moments[k] = bodies.front().principal_moments.data() + k;
    a.momentum[k] = bodies.front().momentum_body.data() + k;
  }
  return a;
}

FreeBody BodyArrays::at(std::size_t i) const {
  const auto row = static_cast<std::ptrdiff_t>(i);
  FreeBody body;
  for (int k = 0; k < 3; ++k) body.principal_moments[k] = moments[k][row * moments_stride];
  Eigen::Vector4d scalar_first_q;
  for (int k = 0; k < 4; ++k) scalar_first_q[k] = q[k][row * q_stride];
  body.q_inertial_from_body = from_scalar_first(scalar_first_q);
  for (int k = 0; k < 3; ++k) body.momentum_body[k] = momentum[k][row * momentum_stride];
  return body;
}

FreeBodies::FreeBodies(const BodyArrays& bodies, const BodiesOptions& options, const theta::Target& target)
    : target_(&target), count_(bodies.count), blocks_(blocks_of(bodies.count)) {
  parallel_chunks(blocks_.size(), 1, options.thread_count, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) build_block(bodies, b * kBlock, 0, options, target, blocks_[b]);
  });
}

std::size_t FreeBodies::built_alone() const {
  std::size_t sum = 0;
  for (const Block& block : blocks_) sum += block.others.size();
  return sum;
}

std::size_t FreeBodies::short_forms() const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < count_; ++i) sum += blocks_[i / kBlock].short_form >> (i % kBlock) & 1U;
  return sum;
}

State FreeBodies::at(std::size_t body, double t_high_s, double t_low_s) const {
  theta::BlockTimes times;
  std::fill_n(times.high, kBlock, t_high_s);
  std::fill_n(times.low, kBlock, t_low_s);
  double q[kBlock][4], m[kBlock][3];
  BlockRows rows;
  std::iota(rows, rows + kBlock, 0);
  const Block& block = blocks_.at(body / kBlock);
  answer_block(*target_, block, kBlock, times, StateArrays::of_structures(q[0], m[0]), rows);
  const std::size_t lane = body % kBlock;
  return {Quaternion(q[lane][0], q[lane][1], q[lane][2], q[lane][3]), Vector3(m[lane])};
}

void FreeBodies::block(std::size_t number, const theta::BlockTimes& times, const StateArrays& out,
                       const BlockRows& rows) const {
  answer_block(*target_, blocks_.at(number), bodies_in_block(number, count_), times, out, rows);
}

void FreeBodies::batch(std::size_t body, const TimeArrays& times, const StateArrays& out) const {
  check_lengths(times);
  answer_body(*target_, blocks_.at(body / kBlock), static_cast<int>(body % kBlock), theta_batch(times, out));
}

void FreeBodies::grid(const TimeArrays& times, const StateArrays& out, const GridRows& rows,
                      unsigned thread_count) const {
  check_lengths(times);
  parallel_chunks(blocks_.size(), 1, thread_count, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      answer_grid(*target_, blocks_[b], b, bodies_in_block(b, count_), times, out, rows);
    }
  });
}

void free_body_states(const BodyArrays& bodies, const TimeArrays& times, const StateArrays& out, const GridRows& rows,
                      const BodiesOptions& options, std::size_t first_number, const theta::Target& target) {
  check_lengths(times);
  parallel_chunks(blocks_of(bodies.count), 1, options.thread_count, [&](std::size_t begin, std::size_t end) {
    Block block;
    for (std::size_t b = begin; b < end; ++b) {
      build_block(bodies, b * kBlock, first_number, options, target, block);
      answer_grid(target, block, b, bodies_in_block(b, bodies.count), times, out, rows);
    }
  });
}

}  // namespace polhode
