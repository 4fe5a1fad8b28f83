#pragma once

#include "polhode/motion/theta/series.hpp"

namespace polhode::theta {

// The constants of the partial derivatives at an instant (partials.md in the folder above). All in units in which the
// largest moment and momentum are near 1: time, momentum and moments are scaled by powers of two, exactly.

/// What every body has, in its own axes; the columns, of m_1 to m_3 and I_1 to I_3, in the units of the caller.
struct PartialsFrame {
  double time_scale;      ///< t in our units = time_scale t
  double momentum_scale;  ///< m in our units = momentum_scale m
  double q0[4];           ///< attitude at t = 0, normalised, scalar first
  /// theta_k = (row k of the body's turn) turn + t m_k of_tm[k] + c_k of_c[k] + sigma_k of_sigma[k] + R_k of_r[k],
  /// where m_k and R_k have the signs that they have in canonical axes.
  double turn[3][6];
  double of_tm[3][6], of_c[3][6], of_sigma[3][6], of_r[3][6];
};

/// Momentum constant in the body: sigma'' = h sigma, with h = 0, -rate^2 or rate^2 for two components, or none.
struct FixedAxisPartials {
  enum class Kind { linear, circular, hyperbolic } kind;
  bool varies[3];          ///< the components with h != 0
  TwoPart rate_per_s;      ///< of the caller's time: quarter turns if circular, hyperbolic angle if hyperbolic
  double reciprocal_rate;  ///< in our units
  double products[3];      ///< m_i m_j of the other two components
};

/// From the functions of Delta = lambda t, in canonical axes, to sigma_k, c_k and R_k.
struct AdditionConstants {
  double lambda, reciprocal_lambda;
  double k2, kp2;  ///< squares of the modulus and of its complement
  double reciprocal_k2, reciprocal_kp2;
  double g0, g1;  ///< kappa_3 / D_1 times m_2(0), and dm_2/dt(0) / lambda
  double m3, n3;  ///< m_3(0) and dm_3/dt(0)
  double e;       ///< kappa_1 kappa_3 m_2(0)^2
  double r1_c, r1_d, r1_periodic;
  double r2_cd, r2_s, r2_periodic;
  double r3_d, r3_c, r3_psi, r3_upsilon;
};

/// First chart: Delta by its theta functions, with v = nu t and polynomials in sin^2 v.
struct FourierPartials {
  TwoPart quarters_per_s;
  double delta_per_v, xi_scale;
  double period_sigma[3], period_c[3], period_r[3];  ///< what half a turn of v adds, over m_k
  double polynomial[4][5];  ///< of theta4, sn, cn, dn and the integral of sn^2, lowest power first
  AdditionConstants addition;
};

/// Second chart.
struct HyperbolicPartials {
  // Beside Delta = 0, with x = pi Delta / (2 K').
  double delta_per_x, psi_scale;
  double sinh1, cosh1, theta4[2], theta3[2], integral1;
  AdditionConstants addition;
  // Elsewhere, from the state itself.
  double nome, nome2;         ///< q' and its square
  double cn_scale, dn_scale;  ///< theta2 / theta4 and theta2 / theta3, over q'^(1/4)
  double b13;
  double s0, s1;                 ///< integral of 1/dn^2 = s0 w + s1 M(x)
  double e0, e0_m0;              ///< e^{-|x(0)|}, and that times M(x(0))
  double jump, reciprocal_root;  ///< e0 / (2 Q) and 1 / Q, or 0 where Q is as good as 0
  double kp2_scale;              ///< k'^2 Q / e0 / Q^2
  double b31, reciprocal_b23;
  double cn, sn, dn, cn_e, dn_e;  ///< at t = 0; divided by e0
  double sn_cn_dn, cn_over_dn;    ///< sn cn / dn and cn / dn at t = 0
  double m[3], n1, reciprocal_kappa_lambda[3];
  bool by_ratio;     ///< whether c_1 stands for m_1 / m_1(0), as c_3 does for m_3 / m_3(0)
  double growth[2];  ///< dm_k/dt / m_k at t = 0, k = 1, 3; or 0 where not by ratio
};

struct PartialsSolution {
  PartialsFrame frame;
  union {
    FixedAxisPartials fixed_axis = {};
    FourierPartials fourier;
    HyperbolicPartials hyperbolic;
  };
  bool exchange_1_3 = false;         ///< canonical components 1 and 3 are the body's 3 and 1
  double sign[3] = {1.0, 1.0, 1.0};  ///< canonical component k is sign[k] times the body's, after the exchange
};

}  // namespace polhode::theta
