#pragma once

#include "polhode/body/body.hpp"

namespace polhode {

/// The moments of inertia, and the rates other than 0, that are taken from files: from 1e-50 to 1e50 in SI units or as
/// ratios, so that products of a few of them are neither infinite nor lost. Throw InputError beyond.
inline constexpr double kLeastRead = 1e-50, kGreatestRead = 1e50;
void check_range(const Inertia& inertia);
void check_range_of_rate(const Vector3& omega_rad_s);

/// Both, of what the body has.
void check_range(const Body& body);

}  // namespace polhode
