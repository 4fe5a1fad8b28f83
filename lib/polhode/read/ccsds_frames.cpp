#include "polhode/read/ccsds_frames.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/read/ccsds_fields.hpp"

namespace polhode {

bool is_local_frame(std::string_view name) {
  constexpr std::array<std::string_view, 23> stems{
      "SC_BODY",       "ACC",    "ACTUATOR",  "AST",        "STARTRACKER", "CSS",     "DSS",        "ESA",
      "GYRO_FRAME",    "GYRO",   "IMU_FRAME", "IMU",        "MTA",         "RW",      "INSTRUMENT", "SA",
      "SC_BODY_FRAME", "SENSOR", "TAM",       "BODY_FRAME", "BODY",        "ANTENNA", "THRUSTER"};
  const std::string text = ccsds_text(name);
  return std::any_of(stems.begin(), stems.end(), [&](std::string_view stem) {
    if (text == stem) return true;
    return text.starts_with(stem) && text.size() > stem.size() + 1 && text[stem.size()] == '_' &&
           text.find('_', stem.size() + 1) == std::string::npos;
  });
}

std::optional<Frame> known_inertial_frame(std::string_view name) {
  try {
    std::string text = ccsds_text(name);
    if (text.starts_with("ICRF") && text.size() == 5) text = "ICRF";  // ICRF1, ICRF2, ICRF3
    const Frame found = frame(text);
    return is_inertial(found) ? std::optional(found) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool is_registered_frame(std::string_view name) {
  constexpr std::array<std::string_view, 35> stems{
      "ALIGN", "B1950", "CIRS", "DTRF", "ECLIP", "EFG", "EQUIN", "EQW", "FIXED", "GCRF", "GRC", "GTOD",
      "ICRF",  "ITRF",  "LVLH", "MCI",  "MOD",   "MOE", "NSW",   "NTW", "PEF",   "PQW",  "QSW", "RSW",
      "RTN",   "SEZ",   "TDR",  "TEME", "TIRS",  "TNW", "TOD",   "TOE", "UVW",   "VNC",  "VVLH"};
  const std::string text = ccsds_text(name);
  return known_inertial_frame(name) || is_local_frame(name) || text.starts_with("WGS84") || text == "VAR" ||
         std::any_of(stems.begin(), stems.end(), [&](std::string_view stem) { return text.starts_with(stem); });
}

bool same_frame(std::string_view a, std::string_view b) {
  const auto full = [](std::string_view name) {
    const std::string text = ccsds_text(name);
    return text == "SC_BODY" ? std::string("SC_BODY_1") : text;
  };
  if (full(a) == full(b)) return true;
  const std::optional<Frame> fa = known_inertial_frame(a);
  return fa && fa == known_inertial_frame(b);
}

}  // namespace polhode
