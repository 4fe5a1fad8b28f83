#pragma once

#include <cstddef>

namespace polhode::variation {

/// Points of a window. In memory those come first that serve for a guess, two of three, both ends among them; either
/// lot is whole registers of any instruction set, and in order of time.
inline constexpr int kPoints = 24, kGuess = 16, kDegree = kPoints - 1;
inline constexpr int kRegister = 8, kLast = kGuess - 1;
static_assert(kPoints % kRegister == 0 && kGuess % kRegister == 0);

/// A number at each point.
using AtPoints = double[kPoints];

/// The six coefficients: the deviation of the momentum (3, inertial), and what there is of the derivatives of the free
/// motion by a turn about the momentum and by a shift in time, and of the third one (variation.md).
inline constexpr int kCoefficients = 6;

/// Gauss-Lobatto points, and what follows from values there for the polynomial through them. Its integral over the
/// window is exact to degree 2 kPoints - 3 (Abramowitz & Stegun 25.4.32).
struct Grid {
  Grid();
  AtPoints point;                  ///< on (-1, 1)
  AtPoints barycentric;            ///< weights (Berrut & Trefethen, SIAM Rev. 46, 501, 2004)
  AtPoints integral[kPoints];      ///< from the first point to each; row j is what the value at point j contributes
  AtPoints interpolation[kGuess];  ///< by the polynomial through the points of the guess
  /// Of the Legendre polynomials of degrees kPoints/2 - 1, kPoints/2, kPoints - 2 and kPoints - 1.
  AtPoints coefficients[4];
};

/// What is the same everywhere on one free motion.
struct Reference {
  double moments[3], inverse_moments[3];
  double along[3];      ///< unit vector of the momentum, inertial
  double magnitude;     ///< of the momentum
  double along_rad_s;   ///< the rate's part along the momentum
  double across_rad_s;  ///< length of its part across, at the base
  /// The shear, which the third derivative contains, is a swing, by_swing m1 m2 m3/|across|^2 for a unit momentum m in
  /// the body, and what by_rate |across|^2 integrates to, from shear_at_base.
  double shear_by_swing, shear_by_rate, shear_at_base;
};

/// Times, and what the free motion and its derivatives are there; all inertial.
struct Places {
  AtPoints since_base_s;
  AtPoints q[4];
  AtPoints omega[3], across[3];             ///< the rate, and its part across the momentum
  AtPoints reciprocal_square;               ///< of that part's length
  AtPoints shear_rate, shear_swing, shear;  ///< shear: what the rate integrates to
  AtPoints inertia[6], inverse_inertia[6];  ///< 11, 22, 33, 23, 31, 12
};

/// What the body felt at a deviation by `angle`.
struct Felt {
  AtPoints torque[3] = {};
  AtPoints relaxation[3] = {};  ///< what internal dissipation adds to the rate
  AtPoints angle[3] = {};
  AtPoints gradient[9] = {};  ///< of the torque by the deviation: three columns
};

/// Of several components: Legendre coefficients of the degrees that a grid has, and the largest magnitudes.
struct Spectrum {
  double coefficients[4][kCoefficients], largest[kCoefficients];
};

/// The loops over points, compiled once for each instruction set.
struct Kernel {
  const char* name;
  /// From the attitudes; of so many points, whole registers.
  void (*find_places)(const Reference&, int points, Places&);
  /// Six Chebyshev series, coefficients[degree + 1][6], of (since_base_s + base_s) times scale_1_s.
  void (*find_series)(const double* coefficients, int degree, double base_s, double scale_1_s,
                      const AtPoints& since_base_s, AtPoints* states);
  /// Position times sqrt(3 mu/r^5).
  void (*find_pull)(const AtPoints* position_m, double root_of_three_mu, AtPoints* pull);
  /// Of so many point masses, three AtPoints of pulls each; at so many points.
  void (*feel_gravity_gradients)(const Reference&, const Places&, const AtPoints* pulls, std::size_t masses,
                                 const AtPoints* coefficients, int points, Felt&);
  /// Their derivatives, half way from felt.angle.
  void (*find_gradients)(const Reference&, const Places&, const AtPoints* pulls, std::size_t masses,
                         const AtPoints* coefficients, Felt&);
  /// variation.md, "The equations of what differs"; and how far the deviation is from where the torque was felt.
  void (*find_rates)(const Reference&, const Places&, const Felt&, const AtPoints* coefficients, AtPoints* rates,
                     double* away_rad);
  /// Of the coefficients, from rates; and by how much the largest change of each is.
  void (*integrate)(const Grid&, const AtPoints* rates, double half_s, const double* start, AtPoints* coefficients,
                    double* changes);
  /// to += by times the values times the rows of a matrix, for several components.
  void (*add_products)(const AtPoints* rows, int count, const AtPoints* values, int components, double by,
                       AtPoints* to);
  void (*find_spectrum)(const Grid&, const AtPoints* values, int components, Spectrum&);
  /// The rotation vector of the deviation at one point.
  void (*angle)(const Reference&, const Places&, const AtPoints* coefficients, int point, double* rotation_vector);
};

/// For the instruction set of ThetaMotion::best_target().
const Kernel& best_kernel();

}  // namespace polhode::variation
