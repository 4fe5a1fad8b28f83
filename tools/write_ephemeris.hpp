#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/ephemeris/row_spacing.hpp"
#include "polhode/write/stream.hpp"

namespace polhode::tools {

/// What `propagate` was told about its output, for every format.
struct OutputOptions {
  std::string path;    // "-" is standard output
  std::string format;  // an ending without its dot; empty: the path's
  bool momentum = false;
  std::string adm;                      // empty: 2.0
  std::string attitude_type;            // empty: QUATERNION/ANGVEL, in ADM 1.0 QUATERNION
  std::string euler_sequence;           // empty: ZXZ
  bool promises_interpolation = false;  // there is a --tolerance
};

/// What an ephemeris can be written as. Help and messages are made from these.
struct EphemerisFormat {
  std::string_view name;
  std::vector<std::string_view> endings;
  RowInterpolation interpolation;  ///< what the format's readers do between rows
  std::string_view interpolation_text;
  bool has_segments;  ///< it can hold more than one
  bool has_momentum;  ///< --momentum means something
  bool is_message;    ///< of CCSDS: --adm, --attitude-type and --euler-sequence mean something
  void (*write)(const OutputOptions& options, std::span<const Ephemeris> segments, const Progress& progress);
};

/// The format that is asked for, or that the path's ending names, in any case. Throws InputError if there is none.
const EphemerisFormat& format_of(const OutputOptions& options);

/// Throws InputError for an option that means nothing in the format.
void refuse_meaningless(const OutputOptions& options, const EphemerisFormat& format);

/// Throws InputError where the output is a file that the work reads.
void refuse_overwriting(const OutputOptions& options, std::span<const std::string> inputs);

/// ".fits .fit (FITS), .csv (CSV), …": of the formats that have this property, or of all.
std::string endings(bool EphemerisFormat::*property = nullptr);

/// Writes all, and says so; a signal that comes meanwhile removes what was begun and then ends the program.
void write_watched(const OutputOptions& options, const EphemerisFormat& format, std::span<const Ephemeris> segments);

}  // namespace polhode::tools
