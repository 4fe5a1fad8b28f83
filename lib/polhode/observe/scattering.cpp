#include "polhode/observe/scattering.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "polhode/base/error.hpp"
#include "polhode/base/units.hpp"

namespace polhode {

std::string_view names_of_scattering_laws() {
  return "projected-area, lambert, lommel-seeliger, lommel-seeliger-lambert";
}

ScatteringLaw scattering_law(std::string_view name, double lambert_weight, double specular) {
  if (!(specular >= 0.0 && specular <= 1.0)) {
    throw InputError(fmt::format("the specular part is {}; a part from 0 to 1 is wanted", specular));
  }
  if (name == "projected-area") return {0.0, 0.0, specular};
  if (name == "lambert") return {0.0, 1.0, specular};
  if (name == "lommel-seeliger") return {1.0, 0.0, specular};
  if (name == "lommel-seeliger-lambert") {
    if (!(lambert_weight > 0.0 && lambert_weight <= 1e6)) {
      throw InputError(
          fmt::format("the weight of Lambert's law is {}; a positive number up to 1e6 is wanted", lambert_weight));
    }
    return {1.0, lambert_weight, specular};
  }
  throw InputError(fmt::format("'{:.40}' is no scattering law; allowed: {}", name, names_of_scattering_laws()));
}

double sphere_brightness(const ScatteringLaw& law, double phase_rad) {
  constexpr double pi = std::numbers::pi;
  const double half = 0.5 * phase_rad, sine = std::sin(phase_rad);
  if (law.lommel_seeliger == 0.0 && law.lambert == 0.0) return pi * std::cos(half) * std::cos(half);
  // sin tan ln cot is 0 at phase 0 and, the other way, 1 at pi.
  const double logarithm = phase_rad > 0.0 ? -std::log(std::tan(0.5 * half)) : 0.0;
  const double lommel_seeliger = phase_rad < pi ? 0.5 * pi * (1.0 - std::sin(half) * std::tan(half) * logarithm) : 0.0;
  const double lambert = 2.0 / 3.0 * (sine + (pi - phase_rad) * std::cos(phase_rad));
  return law.lommel_seeliger * lommel_seeliger + law.lambert * lambert;
}

namespace {

/// A point of a curve, with its derivative by the angle in rad.
struct CurvePoint {
  double angle_deg, value, slope;
};
// Muinonen et al. 2010, tables 3 and 4.
constexpr std::array<CurvePoint, 6> phi_1{{{7.5, 7.5e-1, -1.9098593},
                                           {30.0, 3.3486016e-1, -5.5463432e-1},
                                           {60.0, 1.3410560e-1, -2.4404599e-1},
                                           {90.0, 5.1104756e-2, -9.4980438e-2},
                                           {120.0, 2.1465687e-2, -2.1411424e-2},
                                           {150.0, 3.6396989e-3, -9.1328612e-2}}};
constexpr std::array<CurvePoint, 6> phi_2{{{7.5, 9.25e-1, -5.7295780e-1},
                                           {30.0, 6.2884169e-1, -7.6705367e-1},
                                           {60.0, 3.1755495e-1, -4.5665789e-1},
                                           {90.0, 1.2716367e-1, -2.8071809e-1},
                                           {120.0, 2.2373903e-2, -1.1173257e-1},
                                           {150.0, 1.6505689e-4, -8.6573138e-8}}};
constexpr std::array<CurvePoint, 9> phi_3{{{0.0, 1.0, -1.0630097e-1},
                                           {0.3, 8.3381185e-1, -4.1180439e1},
                                           {1.0, 5.7735424e-1, -1.0366915e1},
                                           {2.0, 4.2144772e-1, -7.5784615},
                                           {4.0, 2.3174230e-1, -3.6960950},
                                           {8.0, 1.0348178e-1, -7.8605652e-1},
                                           {12.0, 6.1733473e-2, -4.6527012e-1},
                                           {20.0, 1.6107006e-2, -2.0459545e-1},
                                           {30.0, 0.0, 0.0}}};

/// By cubic polynomials between the points; 0 beyond the last.
double on_curve(std::span<const CurvePoint> curve, double angle_deg) {
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const CurvePoint &a = curve[i], &b = curve[i + 1];
    if (angle_deg > b.angle_deg) continue;
    const double width_rad = (b.angle_deg - a.angle_deg) * degree;
    const double t = (angle_deg - a.angle_deg) / (b.angle_deg - a.angle_deg), rest = 1.0 - t, rise = b.value - a.value;
    return rest * a.value + t * b.value +
           t * rest * (rest * (a.slope * width_rad - rise) + t * (rise - b.slope * width_rad));
  }
  return 0.0;
}

}  // namespace

double hg1g2(const HG1G2Phase& phase, double phase_rad) {
  const double angle_deg = phase_rad / degree;
  const bool straight = angle_deg < phi_1.front().angle_deg;
  const double first = straight ? 1.0 - 6.0 * phase_rad / std::numbers::pi : on_curve(phi_1, angle_deg);
  const double second = straight ? 1.0 - 1.8 * phase_rad / std::numbers::pi : on_curve(phi_2, angle_deg);
  const double sum = phase.g1 * first + phase.g2 * second + (1.0 - phase.g1 - phase.g2) * on_curve(phi_3, angle_deg);
  return sum > 0.0 ? sum : 0.0;
}

void check(const PhaseFunction& function) {
  constexpr double most_mag = 500.0;
  if (const auto* const polynomial = std::get_if<PolynomialPhase>(&function)) {
    const double sum = 180.0 * (std::abs(polynomial->linear_mag_deg) + 180.0 * std::abs(polynomial->square_mag_deg2));
    if (!(sum <= most_mag)) {
      throw InputError(
          fmt::format("the phase function {} mag/deg and {} mag/deg2 changes by more than {} mag in 180 deg",
                      polynomial->linear_mag_deg, polynomial->square_mag_deg2, most_mag));
    }
  }
  if (const auto* const curve = std::get_if<HG1G2Phase>(&function)) {
    for (const double part : {curve->g1, curve->g2, 1.0 - curve->g1 - curve->g2}) {
      if (!(part >= -0.5 && part <= 1.5)) {
        throw InputError(
            fmt::format("G1 = {} and G2 = {}: they and 1 - G1 - G2 are parts of three phase curves; each is allowed "
                        "from -0.5 to 1.5",
                        curve->g1, curve->g2));
      }
    }
  }
}

double phase_magnitude(const PhaseFunction& function, const ScatteringLaw& law, double phase_rad) {
  if (const auto* const polynomial = std::get_if<PolynomialPhase>(&function)) {
    const double a = phase_rad / degree;
    return a * (polynomial->linear_mag_deg + a * polynomial->square_mag_deg2);
  }
  if (const auto* const curve = std::get_if<HG1G2Phase>(&function)) {
    const double sphere = sphere_brightness(law, phase_rad) / sphere_brightness(law, 0.0);
    return -2.5 * std::log10(hg1g2(*curve, phase_rad) / sphere);
  }
  return 0.0;
}

}  // namespace polhode
