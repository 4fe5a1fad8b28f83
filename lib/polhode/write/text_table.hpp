#pragma once

#include <string>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/write/stream.hpp"

namespace polhode {

enum class TextTableKind {
  csv,        ///< comma-separated values, one line of names
  ecsv,       ///< the same with the header of units, scale and frames that astropy.table reads
  json_lines  ///< each row an object of JSON with these names
};

struct TextTableOptions {
  TextTableKind kind = TextTableKind::csv;
  bool momentum = false;  ///< add the angular momentum in body axes
};

/// An attitude ephemeris as a table of text, one line per row: the date in the
/// scale that the name says; q_x, q_y, q_z, q_scalar, the unit quaternion that takes components from the inertial frame
/// to the body, passive (as in AEM and FITS: a body turned by +90 degrees about inertial z has 0, 0, 0.7071, 0.7071);
/// the angular velocity in body axes; in CSV and JSON lines the frame's name, which ECSV has in its header. Numbers and
/// times as in write_aem. Throws as write_aem.
void write_text_table(const std::string& path, const Ephemeris& ephemeris, const TextTableOptions& options = {},
                      const Progress& progress = {});

}  // namespace polhode
