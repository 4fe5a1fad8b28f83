#pragma once

#include <cstddef>

namespace polhode::variation {

/// Degree of the polynomials of a window on the fine grid, and on the coarse one, which takes every second point.
inline constexpr int kFine = 24, kCoarse = kFine / 2;

/// Points in memory: the coarse ones first, in order of time and filled up to whole registers, then those between,
/// likewise. What takes the coarse grid alone takes the first slots.
inline constexpr int kCoarseSlots = 16, kSlots = 2 * kCoarseSlots;
/// Of point i of the fine grid.
constexpr int slot(int i) { return i % 2 == 0 ? i / 2 : kCoarseSlots + i / 2; }
/// Of the last point, whatever the grid.
inline constexpr int kLast = slot(kFine);

/// A number in each slot.
using InSlots = double[kSlots];

/// What fills up the registers is the last point again.
constexpr bool is_filled_up(int in_slot) {
  return (in_slot > kLast && in_slot < kCoarseSlots) || in_slot > slot(kFine - 1);
}
inline void fill_up(double* v) {
  for (int i = kLast + 1; i < kSlots; ++i) {
    if (is_filled_up(i)) v[i] = v[i < kCoarseSlots ? kLast : slot(kFine - 1)];
  }
}

/// The six coefficients: the deviation of the momentum (3, inertial), and what there is of the derivatives of the free
/// motion by a turn about the momentum and by a shift in time, and of the third one (variation.md).
inline constexpr int kCoefficients = 6;

/// From values at the points of a Chebyshev grid: values of the polynomial through them, and of its integral from the
/// first point, in all slots; and four of its Chebyshev coefficients (Clenshaw & Curtis, Numer. Math. 2, 197, 1960).
/// Row j is what the value in slot j contributes.
struct Grid {
  explicit Grid(int n);  ///< of degree kCoarse or kFine
  int degree, rows, slots;
  double interpolation[kSlots][kSlots] = {}, integral[kSlots][kSlots] = {};
  double coefficients[4][kSlots] = {};  ///< of degree n/2, n/2 + 1, n - 1, n
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
  InSlots since_base_s;
  InSlots q[4];
  InSlots omega[3], across[3];             ///< the rate, and its part across the momentum
  InSlots reciprocal_square;               ///< of that part's length
  InSlots shear_rate, shear_swing, shear;  ///< shear: what the rate integrates to
  InSlots inertia[6], inverse_inertia[6];  ///< 11, 22, 33, 23, 31, 12
};

/// What the body feels.
struct Felt {
  InSlots torque[3] = {};
  InSlots relaxation[3] = {};  ///< what internal dissipation adds to the rate
};

/// Of rates: Chebyshev coefficients of the degrees that a grid has, and the largest magnitudes.
struct Spectrum {
  double coefficients[4][kCoefficients], largest[kCoefficients];
};

/// The loops over slots, compiled once for each instruction set. Slots are counted in whole registers.
struct Kernel {
  const char* name;
  /// From the attitudes.
  void (*find_places)(const Reference&, int from, int to, Places&);
  /// Six Chebyshev series, coefficients[degree + 1][6], of (since_base_s + base_s) times scale_1_s.
  void (*find_series)(const double* coefficients, int degree, double base_s, double scale_1_s,
                      const InSlots& since_base_s, int from, int to, InSlots* states);
  /// Position times sqrt(3 mu/r^5).
  void (*find_pull)(const InSlots* position_m, double root_of_three_mu, int from, int to, InSlots* pull);
  /// Adds the gravity gradients of so many point masses, three InSlots each.
  void (*add_gravity_gradients)(const Reference&, const Places&, const InSlots* pulls, std::size_t masses,
                                const InSlots* coefficients, int slots, InSlots* torque);
  /// variation.md, "The equations of what differs".
  void (*find_rates)(const Reference&, const Places&, const Felt&, const InSlots* coefficients, int slots,
                     InSlots* rates);
  /// Of the coefficients, from rates; and by how much the largest change of each is.
  void (*integrate)(const Grid&, const InSlots* rates, double half_s, const InSlots* start, InSlots* coefficients,
                    double* changes);
  /// to += by times the values times the rows of a matrix, in some slots, for several components.
  void (*add_products)(const InSlots* values, int components, int rows, const InSlots* matrix, int from_slot,
                       int to_slot, double by, InSlots* to);
  void (*find_spectrum)(const Grid&, const InSlots* rates, Spectrum&);
  /// The rotation vector of the deviation in one slot.
  void (*angle)(const Reference&, const Places&, const InSlots* coefficients, int slot, double* rotation_vector);
};

/// For the instruction set of ThetaMotion::best_target().
const Kernel& best_kernel();

}  // namespace polhode::variation
