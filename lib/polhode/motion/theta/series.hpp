#pragma once

#include <cstddef>

namespace polhode::theta {

// The constants of a motion as the evaluation at an instant needs them: plain doubles, one struct per chart. Formulas
// and letters: theta.md in the folder above. Time in seconds, phases in quarter turns.

inline constexpr int kMaxDegree = 3;

/// An unevaluated sum of two doubles.
struct TwoPart {
  double high;
  double low;
};

/// q(t) = cosine cos(a) + sine sin(a), a = quarters_per_s t quarter turns: the momentum is constant in the body.
struct FixedAxis {
  TwoPart quarters_per_s;
  double cosine[4];  ///< quaternions, scalar first
  double sine[4];
  double momentum[3];
};

/// What both charts share: q = frame . (Re alpha, Re beta, Im beta, Im alpha) e^{i rho t} / sqrt(N), and the momentum
/// in canonical axes, multiplied by `momentum_scale` (+-G) and, in long-axis mode, first and third exchanged.
struct OutputFrame {
  double frame[4][4];        ///< column, row
  double momentum_scale[3];  ///< of canonical component 1, 2, 3
  bool exchange_1_3;
};

/// First chart: with v = pi/2 (v_quarters_per_s t + v_quarters_at_0 + v_whole_quarters_at_0), c = cos 2v, polynomials
/// in c of the given degree:
///   Re alpha = p0(c), Re beta = sin v p1(c), Im alpha = sin 2v p2(c), Im beta = cos v p3(c).
struct FourierChart {
  OutputFrame frame;
  TwoPart rho_quarters_per_s;
  TwoPart v_quarters_per_s;
  double v_quarters_at_0;        ///< at most 1/2, to be added to
  double v_whole_quarters_at_0;  ///< -1, 0 or 1
  int degree;
  double polynomial[kMaxDegree + 1][4];  ///< coefficient of c^n in p0 to p3
};

/// Second chart: with x = x_per_s t + x_at_0 reduced to |x| <= x_period / 2 by n whole periods, E = e^{-|x|},
/// Y = e^{|x| - x_period / 2}, and s the sign of x:
///   Re alpha = g0(Y) + E f0(E)         Re beta = (-1)^n s (g1(Y) + E f1(E))
///   Im alpha = s (g2(Y) + E f2(E))     Im beta = (-1)^n (g3(Y) + E f3(E))
/// both times e^{i pi/2 x x_to_quarters}, to be combined with e^{i rho t}.
struct HyperbolicChart {
  OutputFrame frame;
  TwoPart rho_quarters_per_s;
  TwoPart x_per_s;
  TwoPart x_at_0;
  TwoPart x_period;  ///< 1e300 where infinite
  double reciprocal_x_period;
  double root_of_nome;  ///< Q = e^{-x_period / 2}
  double x_to_quarters;
  int degree;
  double growing[kMaxDegree + 1][4];  ///< coefficient of Y^n in g0 to g3
  double falling[kMaxDegree + 1][4];  ///< coefficient of E^n in f0 to f3
};

enum class Chart { fixed_axis, fourier, hyperbolic };

/// One motion. The chart says which member is meant; they are kept apart so that each evaluation sees its own only.
struct Solution {
  Chart chart = Chart::fixed_axis;
  union {
    FixedAxis fixed_axis = {};
    FourierChart fourier;
    HyperbolicChart hyperbolic;
  };
  bool long_axis_mode = false;
};

/// A body at t = 0: as FreeBody, in plain arrays.
struct Input {
  double moments[3];
  double q[4];
  double momentum[3];
};

/// Times in, states out; pointers as in StateArrays, `t_low` and `m` may be null.
struct BatchArguments {
  const double* t_high;
  const double* t_low;
  std::size_t count;
  double* q[4];
  std::ptrdiff_t q_stride;
  double* m[3];
  std::ptrdiff_t m_stride;
};

struct PartialsSolution;
struct BlockInput;
struct BodyBlock;
struct BlockTimes;
struct BlockStates;

/// As BatchArguments, and where the matrices go, 54 numbers each, one after the other.
struct PartialsBatchArguments {
  BatchArguments states;
  double* matrices;
};

/// The functions compiled once per instruction set.
struct Target {
  const char* name;
  int lanes;
  void (*build)(const Input&, Solution&);        ///< double-double: any span
  void (*build_short)(const Input&, Solution&);  ///< double: a step of a splitting method
  void (*at)(const Solution&, double t_high, double t_low, double q_xyzw[4], double m[3]);  ///< as Eigen stores them
  void (*batch)(const Solution&, const BatchArguments&);
  void (*build_partials)(const Input&, Solution&, PartialsSolution&);
  void (*partials_at)(const Solution&, const PartialsSolution&, double t_high, double t_low, double q_xyzw[4],
                      double m[3], double (&matrix)[54]);
  void (*partials_batch)(const Solution&, const PartialsSolution&, const PartialsBatchArguments&);
  /// Many bodies. Bit k of the result is set where body k is left to the build of one body.
  unsigned (*build_block)(const BlockInput&, BodyBlock&);        ///< double-double: any span
  unsigned (*build_block_short)(const BlockInput&, BodyBlock&);  ///< double: spans by short_form_error() (bodies.hpp)
  void (*block_at)(const BodyBlock&, const BlockTimes&, BlockStates&);
};

/// The targets that this machine can run, best last.
std::size_t targets(const Target* out[3]);

}  // namespace polhode::theta
