#pragma once

#include <span>

#include "polhode/motion/theta.hpp"
#include "polhode/motion/theta/partials.hpp"

namespace polhode {

/// d(theta, m at t) / d(theta0, m0, I), 6 x 9. Rows: theta (a small turn of the attitude at t in body axes, rad:
/// q exp(theta/2)), then the angular momentum m in body axes. Columns: theta0 (the same turn at t = 0), m0, and the
/// principal moments I1, I2, I3. Units: those of FreeBody; a turn by momentum is in 1/unit, and so on. Row-major.
using PartialsMatrix = Eigen::Matrix<double, 6, 9, Eigen::RowMajor>;

/// The same matrix in the axes that the body's file names (FreeBody::named_from_principal): turns and momenta, at t and
/// at t = 0, are taken in them. The moments remain the principal ones.
PartialsMatrix named_partials(const FreeBody& body, const PartialsMatrix& partials);

struct StatePartials {
  State state;
  PartialsMatrix partials;
};

/// The motion of a free rigid body with its exact partial derivatives, in closed form (partials.md): every body, on
/// axes, symmetric, spherical, on the separatrix or at rest, at any time.
///
/// Each column is the response to one quantity with the other eight held: a derivative by I is at constant q0, m0 and
/// principal axes, so that the initial rate changes with it. Derivatives by m0 are in the body's axes at t = 0.
/// Errors, by column: within some 1e-15 of the larger of 1 and the column's size, in units of G for momenta and of
/// I_k for moments; beside the separatrix within 1e-12 (partials.md, "Accuracy").
class FreePartials final {
 public:
  /// For the instruction set that this machine does best. Throws InputError for what checked() refuses.
  explicit FreePartials(const FreeBody& body) : FreePartials(body, ThetaMotion::best_target()) {}

  /// For one of theta::targets(), to compare them.
  FreePartials(const FreeBody& body, const theta::Target& target);

  /// State and matrix at t = high + low seconds; times as Motion::at has them.
  StatePartials at(double t_high_s, double t_low_s = 0.0) const;

  /// The same at many times: `matrices` has 54 numbers for each, row by row, else InputError. Allocates nothing.
  void batch(const TimeArrays& times, const StateArrays& out, std::span<double> matrices) const;

 private:
  const theta::Target* target_;
  theta::Solution solution_;
  theta::PartialsSolution partials_;
};

/// FreePartials::batch on several threads, 0 meaning one per core. The same bits for every thread count.
void batch_threads(const FreePartials& partials, const TimeArrays& times, const StateArrays& out,
                   std::span<double> matrices, unsigned thread_count = 0);

}  // namespace polhode
