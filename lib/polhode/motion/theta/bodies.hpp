#pragma once

namespace polhode::theta {

// The constants of many motions side by side, for the lanes of registers. The names are those of series.hpp.

inline constexpr int kBlock = 8;  ///< bodies in a block, whatever the instruction set

/// Bodies at t = 0: as Input, component by component.
struct BlockInput {
  double moments[3][kBlock];
  double q[4][kBlock];
  double momentum[3][kBlock];
};

/// The first chart, with the attitude in a form that needs no matrix: a constant rotation C about the axes of
/// the body is its inverse on the other side of a product, where it exchanges and changes the signs of components:
///   q = frame (Re alpha, X) e^{i rho t} / sqrt(N),    X = (Re beta, Im beta, Im alpha) of e^{i rho t}, in the body's
///   axes
struct BodyBlock {
  double frame[4][kBlock];           ///< scalar first
  double sign[3][kBlock];            ///< -1 or 1, of canonical component 1, 2, 3
  double momentum_scale[3][kBlock];  ///< G times that
  double long_axis_mode[kBlock];     ///< -1: components 1 and 3 exchanged; 1: not
  double rho_quarters_per_s[2][kBlock];
  double v_quarters_per_s[2][kBlock];
  double v_quarters_at_0[kBlock];
  double v_whole_quarters_at_0[kBlock];
  double polynomial[4][4][kBlock];  ///< coefficient of c^n in p0 to p3
};

/// Bound on what the short form, plain double constants, adds to the error of an attitude when the body has turned by
/// `angle_rad` = (2 |rho| + |nu|) |t|: the rates are off by some units in the last place, so that it grows with time.
inline double short_form_error_rad(double angle_rad) { return 0x1p-52 * (8.0 + 16.0 * angle_rad); }

/// Times in, states out, component by component.
struct BlockTimes {
  double high[kBlock];
  double low[kBlock];
};
struct BlockStates {
  double q[4][kBlock];
  double m[3][kBlock];
};

}  // namespace polhode::theta
