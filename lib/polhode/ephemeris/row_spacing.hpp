#pragma once

#include <cstddef>

#include "polhode/ephemeris/ephemeris.hpp"

namespace polhode {

/// What a format's readers do between rows.
enum class RowInterpolation {
  great_circle,      ///< turn at a constant rate about a fixed axis from row to row: HEASoft's reader of FITS, SPICE CK
                     ///< type 3, "slerp"
  lagrange_degree_7  ///< polynomials through 8 rows for each component of the quaternion, then unit length: CCSDS
                     ///< LAGRANGE
};

/// The fewest equally spaced rows from first_s to last_s (TT seconds from the epoch, both rows included) between which
/// the interpolation stays within `tolerance_rad` of the motion. The error of an interpolation does not depend on the
/// inertial frame, only on where on its polhode the body is: it is measured in every gap between rows, or in 50000
/// gaps spread over the span if there are more, at three places each. Rows are at most 1 rad of turn apart, by the
/// fastest rate at a thousand instants: momentum over `principal_moments`, which are of the motion's body.
///
/// Of the tolerance `rows_error_rad`, the promised error of the rows themselves, is taken away first; interpolation is
/// held to 0.9 of what is left, for what lies between the places. Throws InputError unless the tolerance is positive
/// and finite, the span finite and not negative, its turns fewer than rows may be, and a fifth of the tolerance left
/// for interpolation.
std::size_t rows_for_tolerance(const PrincipalMotion& motion, const Vector3& principal_moments, double first_s,
                               double last_s, double tolerance_rad, double rows_error_rad,
                               RowInterpolation interpolation);

}  // namespace polhode
