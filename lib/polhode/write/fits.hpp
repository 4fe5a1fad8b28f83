#pragma once

#include <string>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/write/stream.hpp"

namespace polhode {

struct FitsOptions {
  bool momentum = false;  ///< add column L, the angular momentum in body axes
  bool time_low = false;  ///< add column TIME_LO, what one double of seconds cannot hold of the row's time
  bool packed = false;    ///< by gzip
};

/// An attitude ephemeris as a FITS file with one binary table ATTITUDE that HEASoft's and astropy's readers open as it
/// is. Columns: TIME, seconds of TIMESYS from MJDREF; QPARAM, the unit quaternion with its scalar last that takes
/// components from frame A (inertial, REFFRAMA) to frame B (body, REFFRAMB), passive, as in CCSDS and HEASoft: our
/// q_frame_from_named with its scalar moved to the end and no sign changed; OMEGA, angular velocity in body axes,
/// rad/s. A body turned by +90 degrees about inertial z has QPARAM (0, 0, 0.7071, 0.7071) and its x axis along
/// inertial y. DATASUM is summed while writing, so that the file is not read again.
///
/// A packed file is made from a hidden file beside it that is as long as the table, and what goes to a pipe or a device
/// from one in the system's folder for such files. Progress counts the rows that have arrived.
/// Throws FileError, and what Ephemeris::fill and `progress` throw; then there is no file.
void write_fits(const std::string& path, const Ephemeris& ephemeris, const FitsOptions& options = {},
                const Progress& progress = {});

}  // namespace polhode
