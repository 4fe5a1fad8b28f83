#pragma once

#include <limits>
#include <span>
#include <vector>

#include "polhode/motion/theta.hpp"
#include "polhode/motion/theta/bodies.hpp"

namespace polhode {

/// Where many bodies at t = 0 stand: component k of body i at moments[k][i * moments_stride] and so on. What the
/// numbers mean, and what is allowed, is as in FreeBody.
struct BodyArrays {
  const double* moments[3] = {};
  std::ptrdiff_t moments_stride = 3;
  const double* q[4] = {};  ///< scalar first
  std::ptrdiff_t q_stride = 4;
  const double* momentum[3] = {};
  std::ptrdiff_t momentum_stride = 3;
  std::size_t count = 0;

  /// Row-major n x 3, n x 4 (scalar first) and n x 3.
  static BodyArrays of_structures(const double* moments, const double* q, const double* momentum, std::size_t count);

  static BodyArrays of_bodies(std::span<const FreeBody> bodies);

  FreeBody at(std::size_t i) const;
};

/// What the constants of many bodies must serve, and on how many threads they are built.
struct BodiesOptions {
  /// The short form, plain double constants, is taken for the bodies for which short_form_error_rad() up to this long
  /// before and after t = 0 is within the tolerance; the others get double-double constants, whose error does not grow.
  /// Tolerance 0: all of them do.
  double longest_s = std::numeric_limits<double>::infinity();
  double tolerance_rad = 0.0;
  unsigned thread_count = 1;  ///< 0: one per core
};

/// Which row of a result holds body i at time j: body_rows i + time_rows j.
struct GridRows {
  std::ptrdiff_t body_rows = 1;
  std::ptrdiff_t time_rows = 0;
};

/// The free motions of many bodies, built side by side in the lanes of registers: several times faster than a
/// ThetaMotion for each. Bodies that lanes do not serve (constant momentum, beside the separatrix, moments or momenta
/// of sizes far apart) are built one by one; states agree with those of ThetaMotion to some units in the last place.
/// The state of a body does not depend on the others, nor on the number of threads.
class FreeBodies {
 public:
  /// Throws InputError, naming the body's number from 0, for what checked() refuses.
  explicit FreeBodies(const BodyArrays& bodies, const BodiesOptions& options = {})
      : FreeBodies(bodies, options, ThetaMotion::best_target()) {}
  FreeBodies(const BodyArrays& bodies, const BodiesOptions& options, const theta::Target& target);

  std::size_t size() const { return count_; }

  /// How many were built one by one, and how many have the short form.
  std::size_t built_alone() const;
  std::size_t short_forms() const;

  State at(std::size_t body, double t_high_s, double t_low_s = 0.0) const;

  /// From so many times on, the lanes of registers are times of one body, and no longer bodies.
  static constexpr std::size_t kManyTimes = 16;

  /// One body at many times, as fast as ThetaMotion does it. Throws std::out_of_range.
  void batch(std::size_t body, const TimeArrays& times, const StateArrays& out) const;

  /// Every body at every time.
  void grid(const TimeArrays& times, const StateArrays& out, const GridRows& rows, unsigned thread_count = 1) const;

  /// The bodies come in blocks: of block `number`, bodies 8 number to 8 number + 7 as far as there are, each at its own
  /// time, to the row given for it.
  static constexpr int kBlock = theta::kBlock;
  using BlockRows = std::ptrdiff_t[kBlock];
  std::size_t blocks() const { return blocks_.size(); }
  void block(std::size_t number, const theta::BlockTimes& times, const StateArrays& out, const BlockRows& rows) const;

  /// Eight bodies.
  struct Block {
    theta::BodyBlock lanes;
    unsigned alone = 0;  ///< bit k: body k stands in `others`, in order
    unsigned short_form = 0;
    std::vector<theta::Solution> others;
  };

 private:
  const theta::Target* target_;
  std::size_t count_;
  std::vector<Block> blocks_;
};

/// FreeBodies(bodies, options).grid(times, out, rows), keeping nothing: for many bodies at few times, and for tables
/// that do not fit in memory at once. `first_number` is what messages call the first body.
void free_body_states(const BodyArrays& bodies, const TimeArrays& times, const StateArrays& out, const GridRows& rows,
                      const BodiesOptions& options = {}, std::size_t first_number = 0,
                      const theta::Target& target = ThetaMotion::best_target());

}  // namespace polhode
