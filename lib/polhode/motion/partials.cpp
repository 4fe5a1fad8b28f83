#include "polhode/motion/partials.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"

namespace polhode {
namespace {

constexpr std::size_t kMatrixSize = PartialsMatrix::SizeAtCompileTime;

void check_matrices(const TimeArrays& times, std::span<double> matrices) {
  if (matrices.size() != kMatrixSize * times.high.size()) {
    throw InputError(fmt::format("{} numbers for the matrices of {} times; {} are wanted, {} for each", matrices.size(),
                                 times.high.size(), kMatrixSize * times.high.size(), kMatrixSize));
  }
}

}  // namespace

PartialsMatrix named_partials(const FreeBody& body, const PartialsMatrix& partials) {
  const Matrix3& R = body.named_from_principal;
  PartialsMatrix named;
  for (int row = 0; row < 6; row += 3) {
    for (int column = 0; column < 9; column += 3) {
      const Matrix3 block = R * partials.block<3, 3>(row, column);
      named.block<3, 3>(row, column) = column < 6 ? Matrix3(block * R.transpose()) : block;
    }
  }
  return named;
}

FreePartials::FreePartials(const FreeBody& body, const theta::Target& target) : target_(&target) {
  target_->build_partials(theta_input(checked(body)), solution_, partials_);
}

StatePartials FreePartials::at(double t_high_s, double t_low_s) const {
  StatePartials result;
  target_->partials_at(solution_, partials_, t_high_s, t_low_s, result.state.q_inertial_from_body.coeffs().data(),
                       result.state.momentum_body.data(),
                       *reinterpret_cast<double(*)[kMatrixSize]>(result.partials.data()));
  return result;
}

void FreePartials::batch(const TimeArrays& times, const StateArrays& out, std::span<double> matrices) const {
  check_lengths(times);
  check_matrices(times, matrices);
  target_->partials_batch(solution_, partials_, {theta_batch(times, out), matrices.data()});
}

void batch_threads(const FreePartials& partials, const TimeArrays& times, const StateArrays& out,
                   std::span<double> matrices, unsigned thread_count) {
  check_lengths(times);
  check_matrices(times, matrices);
  constexpr std::size_t kGrain = 512;  // batches work in blocks of a divisor of this
  parallel_chunks(times.high.size(), kGrain, thread_count, [&](std::size_t begin, std::size_t end) {
    partials.batch(part_of(times, begin, end), part_of(out, begin),
                   matrices.subspan(kMatrixSize * begin, kMatrixSize * (end - begin)));
  });
}

}  // namespace polhode
