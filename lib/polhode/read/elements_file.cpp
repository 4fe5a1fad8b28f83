#include "polhode/read/elements_file.hpp"

#include <fmt/format.h>

#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/base/units.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/time/scale.hpp"
#include "polhode/torque/kepler_orbit.hpp"

namespace polhode {
namespace {

constexpr double au_m = 149597870700.0;

Vector3 turned(double node_rad, double inclination_rad, double angle_rad, const Vector3& v) {
  return Eigen::AngleAxisd(node_rad, Vector3::UnitZ()) * Eigen::AngleAxisd(inclination_rad, Vector3::UnitX()) *
         Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()) * v;
}

}  // namespace

bool is_elements(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = trimmed(take_line(text));
    if (line.starts_with('[')) return false;
    if (line.starts_with("eccentricity")) return trimmed(line.substr(12)).starts_with('=');
  }
  return false;
}

CentredTrajectory parse_elements(std::string_view text, const std::string& path, const TrajectoryRequest& request) {
  const TomlTable table = TomlTable::parse(text, path);
  table.allow_only({"name", "source", "centre", "mu_m3_s2", "frame", "epoch", "eccentricity", "semi_major_axis_au",
                    "periapsis_au", "inclination_deg", "node_deg", "periapsis_deg", "mean_anomaly_deg",
                    "periapsis_date"});
  const std::string centre = table.optional_text("centre").value_or(request.centre.empty() ? "SUN" : request.centre);
  KeplerElements elements;
  const bool about_sun = upper_case(centre) == "SUN";
  elements.mu_m3_s2 = about_sun && !table.has("mu_m3_s2") ? kSunMu_m3_s2 : table.positive_number("mu_m3_s2");
  elements.eccentricity = table.number("eccentricity");
  const std::string_view size = table.one_of({"semi_major_axis_au", "periapsis_au"});
  const double length_m = au_m * table.number(size);
  elements.periapsis_m = size == "periapsis_au" ? length_m : length_m * (1.0 - elements.eccentricity);
  if (!(elements.eccentricity >= 0.0)) throw table.error("eccentricity", "it must be 0 or more");
  if (!(std::abs(length_m) <= 1e6 * au_m)) throw table.error(size, "it must be a distance up to 1e6 au");
  if (!(elements.periapsis_m > 0.0)) {
    throw table.error(size,
                      "the distance of the periapsis must be positive: a semi-major axis is positive below the "
                      "eccentricity 1 and negative above it");
  }
  const std::string_view when = table.one_of({"mean_anomaly_deg", "periapsis_date"});
  const auto date = [&](std::string_view key) {
    return table.parsed(key, [](const std::string& value) { return parse_date_with_scale(value).instant; });
  };
  const Instant epoch = date("epoch");
  if (when == "periapsis_date") {
    elements.periapsis_time_s = (date("periapsis_date") - request.zero).high;
  } else {
    const double axis_m = elements.periapsis_m / std::abs(1.0 - elements.eccentricity);
    if (elements.eccentricity == 1.0) {
      throw table.error("mean_anomaly_deg", "a parabola has no mean anomaly; periapsis_date is wanted");
    }
    const double motion_rad_s = std::sqrt(elements.mu_m3_s2 / axis_m) / axis_m;
    elements.periapsis_time_s = (epoch - request.zero).high - table.number("mean_anomaly_deg") * degree / motion_rad_s;
  }
  const double node = degree * table.number("node_deg"), inclination = degree * table.number("inclination_deg");
  const Frame frame = table.has("frame") ? table.parsed("frame", inertial_frame) : Frame::ecliptic_j2000;
  const Quaternion q = q_icrf_from(request.frame).conjugate() * q_icrf_from(frame);
  elements.to_periapsis = q * turned(node, inclination, degree * table.number("periapsis_deg"), Vector3::UnitX());
  elements.along_normal = q * turned(node, inclination, 0.0, Vector3::UnitZ());
  return {table.located("eccentricity", [&] { return Trajectory(elements); }), upper_case(centre)};
}

}  // namespace polhode
