#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/read/ccsds_attitude.hpp"

namespace polhode {

/// The attitude history in a file, or nothing if the file is of a kind that has none (a body file, an APM, a shape):
/// - an AEM or ACM of CCSDS (read/ccsds_attitude.hpp);
/// - FITS with a table ATTITUDE of TIME and QPARAM (scalar last), perhaps OMEGA and TIME_LO: ours, and those of
/// HEASoft.
///   TIMESYS and MJDREF (or MJDREFI and MJDREFF) are needed; QORDER and QDIR are obeyed, REFFRAMA is the frame;
/// - our tables of text, CSV and ECSV.
/// Rows with rates are interpolated by HERMITE of degree 3, others by LINEAR, unless the file says otherwise. Throws
/// InputError for faults, with file and line where there are lines, FileError if the file cannot be read.
std::optional<AttitudeHistory> read_attitude_history(const std::string& path);

/// The same from memory; `name` stands for the file in messages.
std::optional<AttitudeHistory> parse_attitude_history(std::string_view content, const std::string& name);

/// The first attitude history of these messages, with a warning of further ones; `name` stands for their file.
std::optional<AttitudeHistory> take_history(std::vector<CcsdsAttitudeMessage>& messages, const std::string& name);

/// Whether the content is such a table in FITS or text.
bool is_attitude_table(std::string_view text);

}  // namespace polhode
