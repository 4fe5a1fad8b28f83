#include "polhode/motion/torqued_partials.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"
#include "polhode/motion/kicked_motion.hpp"
#include "polhode/motion/partials.hpp"

namespace polhode {

std::unique_ptr<const PropagatedMotion::Partials> PropagatedMotion::partials(
    const FreeBody& /*body*/, const Torques& /*torques_named*/, std::span<const TorqueParameter> /*parameters*/) const {
  throw InputError("this motion has no partial derivatives");
}

namespace {

const std::vector<std::string> kColumnsOfBody{"theta0_x", "theta0_y", "theta0_z", "m0_x", "m0_y",
                                              "m0_z",     "I1",       "I2",       "I3"};

}  // namespace

TorquedPartials::TorquedPartials(const TorquedMotion& motion, std::vector<TorqueParameter> parameters)
    : named_from_principal_(motion.body().named_from_principal),
      columns_(kColumnsOfBody),
      engine_(motion.engine_),
      partials_(engine_->partials(motion.body(), motion.torques(), parameters)) {
  for (TorqueParameter& one : parameters) columns_.push_back(std::move(one.name));
}

TorquedPartials::Matrix TorquedPartials::at(double t_high_s, double t_low_s) const {
  Matrix matrix(6, static_cast<Eigen::Index>(columns_.size()));
  batch({{&t_high_s, 1}, {&t_low_s, 1}}, {matrix.data(), static_cast<std::size_t>(matrix.size())});
  return matrix;
}

void TorquedPartials::batch(const TimeArrays& times, std::span<double> matrices) const {
  check_lengths(times);
  const std::size_t each = 6 * columns_.size();
  if (matrices.size() != each * times.high.size()) {
    throw InputError(fmt::format("{} numbers for the matrices of {} times; {} are wanted, {} for each", matrices.size(),
                                 times.high.size(), each * times.high.size(), each));
  }
  partials_->batch(times, matrices);
  const Matrix3& R = named_from_principal_;
  if (R.isIdentity(0.0)) return;
  for (std::size_t i = 0; i < times.high.size(); ++i) {
    Eigen::Map<Matrix> matrix(&matrices[each * i], 6, static_cast<Eigen::Index>(columns_.size()));
    for (const int row : {0, 3}) {
      matrix.middleRows<3>(row) = (R * matrix.middleRows<3>(row)).eval();
      for (const int column : {0, 3}) {
        matrix.block<3, 3>(row, column) = (matrix.block<3, 3>(row, column) * R.transpose()).eval();
      }
    }
  }
}

StatePartialsSource state_partials_of(const Motion& motion, const FreeBody& body) {
  if (dynamic_cast<const KickedMotion*>(&motion) != nullptr) {
    throw InputError(
        "this motion was computed by few kicks, which have no partial derivatives: one planned in full has them");
  }
  if (const auto* const torqued = dynamic_cast<const TorquedMotion*>(&motion)) {
    const auto partials = std::make_shared<const TorquedPartials>(*torqued);
    return {partials->columns(),
            [partials](const TimeArrays& times, std::span<double> matrices) { partials->batch(times, matrices); }};
  }
  const auto partials = std::make_shared<const FreePartials>(body);
  return {kColumnsOfBody, [partials, body](const TimeArrays& times, std::span<double> matrices) {
            const std::size_t count = times.high.size();
            std::vector<double> q(4 * count), m(3 * count);
            partials->batch(times, StateArrays::of_structures(q.data(), m.data()), matrices);
            if (body.named_from_principal.isIdentity(0.0)) return;
            constexpr std::size_t size = PartialsMatrix::SizeAtCompileTime;
            for (std::size_t i = 0; i < count; ++i) {
              Eigen::Map<PartialsMatrix> matrix(&matrices[size * i]);
              matrix = named_partials(body, matrix);
            }
          }};
}

}  // namespace polhode
