#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polhode/motion/free_bodies.hpp"
#include "polhode/time/scale.hpp"
#include "polhode/write/number_table.hpp"

namespace polhode {

/// Free bodies in their principal axes, as a table gives them.
struct Population {
  std::vector<std::string> names;         ///< empty: the table has none
  std::vector<double> moments, q, rates;  ///< rows of 3, 4 (scalar first, inertial from body) and 3 (rad/s, body axes)
  std::vector<Instant> epochs;
  std::string frame;  ///< inertial, of q, as the table names it; empty: it does not

  std::size_t size() const { return epochs.size(); }
};

/// Reads a table of bodies: FITS (table BODIES), or text with a line of names (CSV, ECSV, white space). Columns: I1,
/// I2, I3, the principal moments, ascending, in any unit of each row; q_x, q_y, q_z, q_scalar, as ephemerides of this
/// program have them; omega_body_x_rad_s, _y_ and _z_; a date (date_tdb, jd_utc, …) of each row's epoch, or `epoch` for
/// all; name, if there are names. FITS: MOMENTS, QPARAM, OMEGA, and TIME with MJDREF and TIMESYS. Throws InputError
/// with file and line.
Population read_population(const std::string& path, std::optional<Instant> epoch);

/// Writes the state of every body at every instant, a row each, bodies within instants, in the format of the path's
/// ending; `instants` increase. Throws InputError for a body that checked() refuses, and what write_number_table()
/// throws.
void write_population(const std::string& path, const Population& population, std::span<const Instant> instants,
                      TimeScale scale, const Progress& progress = {}, unsigned thread_count = 0);

}  // namespace polhode
