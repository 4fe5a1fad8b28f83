#pragma once

#include <functional>
#include <span>
#include <string>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/write/ephemeris_formats.hpp"

namespace polhode::tools {

/// What `propagate` was told about its output, for every format.
struct OutputOptions : WriteOptions {
  std::string path;    ///< "-" is standard output
  std::string format;  ///< an ending without its dot; empty: the path's
};

/// The format that is asked for, or that the path's ending names, in any case. Throws InputError if there is none.
const EphemerisFormat& format_of(const OutputOptions& options);

/// Throws InputError for an option that means nothing in the format.
void refuse_meaningless(const OutputOptions& options, const EphemerisFormat& format);

/// Throws InputError where the output is a file that the work reads.
void refuse_overwriting(const OutputOptions& options, std::span<const std::string> inputs);

/// Writes all, watched as below.
void write_watched(const OutputOptions& options, const EphemerisFormat& format, std::span<const Ephemeris> segments);

/// Calls `write` for the file of that name, shows how far it is, and says how many rows it has; a signal that comes
/// meanwhile removes what was begun and then ends the program.
void write_watched(const std::string& path, std::size_t rows, const std::function<void(const Progress&)>& write,
                   const char* rows_are = "rows");

}  // namespace polhode::tools
