#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/ephemeris/row_spacing.hpp"
#include "polhode/write/stream.hpp"

namespace polhode {

/// What may be wanted of a file of an ephemeris; an empty text is the format's own choice.
struct WriteOptions {
  bool momentum = false;                ///< the angular momentum too, where the format holds it
  std::string adm;                      ///< version of a CCSDS message, "1.0" or "2.0"; 2.0 unless said
  std::string attitude_type;            ///< of an AEM; QUATERNION/ANGVEL unless said, in ADM 1.0 QUATERNION
  std::string euler_sequence;           ///< of an AEM of Euler angles; ZXZ unless said
  bool promises_interpolation = false;  ///< the rows are spaced for a tolerance between them
};

/// What an ephemeris can be written as.
struct EphemerisFormat {
  std::string_view name;
  std::vector<std::string_view> endings;
  RowInterpolation interpolation;  ///< what the format's readers do between rows
  std::string_view interpolation_text;
  bool has_segments;    ///< it can hold more than one ephemeris
  bool has_momentum;    ///< the option `momentum` means something
  bool has_covariance;  ///< it can hold the covariance of an ephemeris that has one
  bool is_message;      ///< of CCSDS: the options of messages mean something
  void (*write)(const std::string& path, std::span<const Ephemeris> segments, const WriteOptions& options,
                const Progress& progress);
};

/// All of them. Help and messages are made from these.
const std::vector<EphemerisFormat>& ephemeris_formats();

/// The format of that ending, ".fits", or of a path that ends so, in any case; null if there is none.
const EphemerisFormat* ephemeris_format_of(std::string_view path);

/// ".fits .fit (FITS), .csv (CSV), …": of the formats that have this property, or of all.
std::string endings_of_formats(bool EphemerisFormat::*property = nullptr);

/// Writes the ephemerides, which are of one object, in this format. Throws InputError for an option that means nothing
/// in it and for more ephemerides than it holds, and what its writer throws; then there is no file.
void write_ephemeris(const std::string& path, const EphemerisFormat& format, std::span<const Ephemeris> segments,
                     const WriteOptions& options = {}, const Progress& progress = {});

}  // namespace polhode
