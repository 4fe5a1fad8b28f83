#pragma once

#include "polhode/motion/motion.hpp"
#include "polhode/motion/theta/series.hpp"

namespace polhode {

/// A body and a batch as the functions of an instruction set take them.
theta::Input theta_input(const FreeBody& body);
theta::BatchArguments theta_batch(const TimeArrays& times, const StateArrays& out);

/// The exact motion of a free rigid body as one theta series (theta.md): every body, no special case but a momentum
/// that is constant in the body. At an instant t, with two phases v = nu t + v0 and rho t and two short series,
///
///     alpha + beta    the even and the odd part of a theta function of v
///     attitude(t)   = R (Re alpha, Re beta, Im beta, Im alpha) e^{i rho t} C / sqrt(N),    N = |alpha|^2 + |beta|^2
///     m1 + i m2     = 2 i G beta conj(alpha) / N,    m3 = G (|alpha|^2 - |beta|^2) / N     (canonical axes)
///
/// with R and C constant rotations. Near the separatrix the same functions are taken after Jacobi's transformation.
class ThetaMotion final : public Motion {
 public:
  /// What the constants must serve.
  enum class Span {
    any,   ///< double-double constants: the error does not grow with time
    step,  ///< plain double, several times cheaper to build: for a step of a splitting method, up to about a turn
  };

  /// For the instruction set that this machine does best. Throws InputError for what checked() refuses.
  explicit ThetaMotion(const FreeBody& body, Span span = Span::any) : ThetaMotion(body, span, best_target()) {}

  /// For one of theta::targets(), to compare them.
  ThetaMotion(const FreeBody& body, Span span, const theta::Target& target)
      : ThetaMotion(Unchecked{}, checked(body), span, target) {}

  /// For a body that comes from one that was checked, as inside a splitting method: an attitude or a momentum that is
  /// not finite gives states of NaN.
  struct Unchecked {};
  ThetaMotion(Unchecked, const FreeBody& body, Span span, const theta::Target& target = best_target());

  /// At any finite time a state of the body; beyond some 1e28 turns, where the last digit of a rate in two parts turns
  /// the body, its phase means nothing.
  State at(double t_high_s, double t_low_s = 0.0) const override;
  void batch(const TimeArrays& times, const StateArrays& out) const override;

  const theta::Solution& solution() const { return solution_; }

  /// The last of theta::targets(), or the one that POLHODE_TARGET in the environment names.
  static const theta::Target& best_target();

 private:
  const theta::Target* target_;
  theta::Solution solution_;
};

}  // namespace polhode
