#pragma once

#include "polhode/body/body.hpp"

namespace polhode {

/// The moments of inertia, and the rates other than 0, that are taken from files, in SI units or as ratios: products of
/// a few of them are neither infinite nor lost.
inline constexpr double kLeastRead = 1e-50, kGreatestRead = 1e50;
/// The uncertainties, in the units of their numbers: their squares are finite.
inline constexpr double kGreatestSigmaRead = 1e100;

/// Throw InputError beyond.
void check_range(const Inertia& inertia);
void check_range_of_rate(const Vector3& omega_rad_s);

/// Both, of what the body has.
void check_range(const Body& body);

}  // namespace polhode
