#pragma once

#include <string>
#include <string_view>

#include "polhode/read/input_formats.hpp"

namespace polhode {

/// Whether the content is a table of attitudes:
/// - FITS with a table ATTITUDE of TIME and QPARAM (scalar last), perhaps OMEGA and TIME_LO: ours, and those of
///   HEASoft. TIMESYS and MJDREF (or MJDREFI and MJDREFF) are needed; QORDER and QDIR are obeyed, REFFRAMA is the
///   frame;
/// - our tables of text, CSV and ECSV.
bool is_attitude_table(std::string_view text);

/// Such a table; its first row is the body's state. Rows with rates are interpolated by HERMITE of degree 3, others by
/// LINEAR. Throws InputError for faults, with file and line where there are lines.
BodyAndHistory read_attitude_table(const std::string& text, const RowOfFile& place, const ContentOf& content_of);

}  // namespace polhode
