#pragma once

#include <string>
#include <string_view>

#include "polhode/body/body.hpp"
#include "polhode/body/spin_partials.hpp"

namespace polhode {

/// DAMIT's `spin.txt` of a principal-axis rotator: `lambda beta P`, then `JD0 phi0` (deg, hours, TDB), then perhaps
/// scattering parameters. https://damit.cuni.cz
bool is_damit_spin(std::string_view text);
Body parse_damit_spin(std::string_view text, const std::string& path);

/// A table exported by DAMIT as CSV, with a byte-order mark or not: `asteroid_models` (lambda, beta, period, jd0, phi0)
/// or `tumblers` (lambda, beta, phi0, psi0, p_phi, p_psi, i1, i2, jd0), found by the names in the first line. `row` is
/// the id of the model; it may be empty if there is only one. A tumbler's table may have no column that we do not know:
/// its layout was not seen, and a number with an unknown meaning must not be passed over.
bool is_damit_table(std::string_view text);
Body parse_damit_table(std::string_view text, const std::string& path, const std::string& row);

/// The `{SPIN STATE}` block of a model file of the radar program SHAPE: date, three angles (z-x-z, from the ecliptic to
/// the body, deg), three rates about body axes (deg/day), three moments of inertia, then rates of change, librations
/// and impulses, which a free motion does not have.
bool is_shape_model(std::string_view text);
Body parse_shape_model(std::string_view text, const std::string& path);

/// A body's spin by direction of its angular momentum, angles and periods. Throws InputError.
struct PublishedSpin {
  double longitude_deg = 0.0, latitude_deg = 0.0;  ///< of the angular momentum
  Frame frame = Frame::ecliptic_j2000;
  std::optional<double> phi0_deg, psi0_deg, theta0_deg;
  double precession_period_s = 0.0, rotation_period_s = 0.0;
  bool short_axis_convention = false;
  std::optional<bool> long_axis_mode;
  std::optional<double> energy;  ///< E/E0 as published, for the residual and to choose between modes
  double energy_sigma = 0.0;     ///< of that; 0: none is published
  bool likelier_mode = false;    ///< if neither says the mode: that farther from the separatrix, with a warning
  Instant epoch;
  TimeScale epoch_scale = TimeScale::tdb;
};

/// Sets `body.state` from its inertia, and notes what was solved and how far over-determined numbers disagree. Returns
/// what was solved; angles that are not given are 0.
PublishedTumbling set_tumbling_state(Body& body, const PublishedSpin& spin);

/// A rotation about the z axis, which is a principal one, at a constant rate: phi0 at the epoch counted as in DAMIT.
void set_principal_axis_state(Body& body, const PublishedSpin& spin);

}  // namespace polhode
