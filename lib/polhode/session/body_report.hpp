#pragma once

#include <optional>
#include <string>

#include "polhode/body/invariants.hpp"
#include "polhode/motion/known_until.hpp"
#include "polhode/read/body.hpp"

namespace polhode {

/// What principal axes are called, of the smallest moment first.
inline constexpr const char* axis_words[3] = {"long", "intermediate", "short"};

/// What there is to say about one body: gathered once, printed as text or JSON.
struct BodyReport {
  std::string path;
  Body body;
  std::optional<SpinInvariants> spin;
  std::optional<Vector3> momentum_ecliptic, momentum_icrf;
  std::optional<AttitudeHistory> history;
  std::optional<double> next_flip_s;   ///< from the epoch
  std::optional<double> energy_sigma;  ///< of E/E0; this and the next of a body that has uncertainties
  std::optional<StateWorth> worth;
};

/// `path` is what the report calls the file.
BodyReport report_on(const std::string& path, BodyAndHistory file);

/// The report as a JSON object on one line: an element of what `polhode info --json` prints.
std::string json_text(const BodyReport& report);

}  // namespace polhode
