#pragma once

#include <string_view>
#include <variant>

namespace polhode {

/// What a surface element sends to an observer for its area, by the cosines mu (emission) and mu0 (incidence) where
/// both are positive: lommel_seeliger mu mu0 / (mu + mu0) + lambert mu mu0. Where both weights are 0 the brightness is
/// the projected area that is lit and seen, mu.
///
/// `specular` is the part of the Sun's light that flat facets of meshes, a satellite's, throw on like mirrors besides:
/// an observer to whom a facet shows the Sun's disc sees specular / sin^2(kSunRadius_rad) mu of it, where a white
/// Lambertian surface has mu mu0.
struct ScatteringLaw {
  double lommel_seeliger = 0.0, lambert = 0.0, specular = 0.0;
};

/// Of the Sun's disc at 1 au: half of half a degree.
inline constexpr double kSunRadius_rad = 4.6524e-3;

/// "projected-area", "lambert", "lommel-seeliger", or "lommel-seeliger-lambert": Lommel-Seeliger's law and
/// `lambert_weight` of Lambert's (Kaasalainen, Torppa & Muinonen 2001, Icarus 153, 37: 0.1). Throws InputError with
/// what is allowed, for a weight that is not above 0 and at most 1e6, and for a `specular` outside 0 to 1.
ScatteringLaw scattering_law(std::string_view name, double lambert_weight = 0.1, double specular = 0.0);

/// "projected-area, lambert, …"
std::string_view names_of_scattering_laws();

/// The brightness of a sphere of radius 1 at a phase angle, in closed form.
double sphere_brightness(const ScatteringLaw& law, double phase_rad);

/// Of the phase angle a, in magnitudes: linear a + square a^2 (a in deg).
struct PolynomialPhase {
  double linear_mag_deg = 0.0, square_mag_deg2 = 0.0;
};

/// H, G1, G2 of Muinonen et al. 2010, Icarus 209, 542: a sphere of the scattering law follows this phase curve exactly,
/// other shapes as their brightness differs from the sphere's.
struct HG1G2Phase {
  double g1 = 0.0, g2 = 0.0;
};

using PhaseFunction = std::variant<std::monostate, PolynomialPhase, HG1G2Phase>;

/// The phase curve G1 Phi1 + G2 Phi2 + (1 - G1 - G2) Phi3, 1 at phase 0. 0 where Phi1 and Phi2 are not known, from 150
/// deg on, and where the parameters make it negative.
double hg1g2(const HG1G2Phase& phase, double phase_rad);

/// Throws InputError for parameters that are not finite, for G1, G2 or 1 - G1 - G2 outside -0.5 to 1.5, and for a
/// polynomial that adds more than 500 magnitudes somewhere.
void check(const PhaseFunction& function);

/// What the phase function adds to -2.5 log10(brightness), in magnitudes.
double phase_magnitude(const PhaseFunction& function, const ScatteringLaw& law, double phase_rad);

}  // namespace polhode
