#pragma once

#include "polhode/base/geometry.hpp"

namespace polhode {

/// Inertia of a rigid body about its centre of mass.
struct Inertia {
  /// I1 <= I2 <= I3, all positive, I1 + I2 >= I3 within triangle_tolerance; kg m^2 if `absolute`, else any one unit.
  Vector3 principal_moments;
  /// The right-handed principal axes, as columns, in the axes that the user's file names: v_named = R v_principal.
  /// Where the axes are only permuted all entries are exactly 0 or +-1 (a quaternion would round them).
  Matrix3 named_from_principal = Matrix3::Identity();
  /// False where only ratios are known: free motion needs no more, torques do.
  bool absolute = false;

  /// The same rotation: v_named = q v_principal q*.
  Quaternion q_named_from_principal() const { return Quaternion(named_from_principal).normalized(); }
};

/// A flat body has I1 + I2 = I3; less than that by more than this part of I3 is impossible. Room for the rounding of
/// computed tensors, not for moments printed with few digits.
inline constexpr double triangle_tolerance = 1e-9;

/// The moments and momenta that are computed with, in any unit: to the last digit ordinary doubles.
inline constexpr double kLeastMagnitude = 1e-305, kGreatestMagnitude = 1e305;
/// The most that the largest moment may be of the smallest.
inline constexpr double kGreatestMomentRatio = 1e100;

/// Throws InputError unless the moments are positive, ascending, and within these limits.
void check_principal_moments(const Vector3& principal_moments);
/// Throws InputError unless they are those of a body: ascending, none larger than the two others together, but for
/// roundings.
void check_triangle(const Vector3& principal_moments);

/// Throws InputError unless the angular momentum is 0 or of a length within the limits.
void check_angular_momentum(const Vector3& momentum);

/// Throws InputError unless the columns are three right-handed axes of length 1 at right angles, within 1e-9.
void check_principal_axes(const Matrix3& named_from_principal);

/// Throws InputError unless the inertia is as Inertia says. The functions that take one call it.
void check(const Inertia& inertia);

/// Sign of products of inertia as published.
enum class ProductsOfInertia {
  tensor_elements,     ///< Ixy as it stands in the tensor: minus the integral of x y dm
  positive_integrals,  ///< Ixy = integral of x y dm: the tensor holds -Ixy
};

/// The symmetric tensor of moments (Ixx, Iyy, Izz) and products (Ixy, Ixz, Iyz).
Matrix3 inertia_tensor(const Vector3& moments, const Vector3& products, ProductsOfInertia sign);

/// The tensor in the named axes: R diag(I) R^T.
Matrix3 inertia_tensor(const Inertia& inertia);

/// Principal moments and axes of a symmetric tensor (the upper triangle counts), by Jacobi's method: R diag(I) R^T
/// gives the tensor back within some 4 eps of its size for near-degenerate tensors too, and a diagonal tensor keeps its
/// moments bit for bit. Of the four right-handed choices of signs the one nearest the named axes is taken. Throws
/// InputError for an element that is not finite, a tensor that is not symmetric within 1e-9 of its size, a moment that
/// is not positive, or a broken triangle inequality.
Inertia inertia_from_tensor(const Matrix3& tensor, bool absolute);

/// Moments about named axes that are principal, in any order: inertia_from_tensor of the diagonal tensor.
Inertia inertia_from_moments(const Vector3& moments_named, bool absolute);

/// Semi-axes a >= b >= c of the homogeneous ellipsoid with these moments, as parts of a: (1, b/a, c/a).
Vector3 equivalent_ellipsoid_ratios(const Inertia& inertia);

}  // namespace polhode
