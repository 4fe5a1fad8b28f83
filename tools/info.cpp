#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/read/body.hpp"
#include "polhode/session/body_report.hpp"
#include "polhode/time/duration_text.hpp"
#include "subcommands.hpp"

namespace polhode::tools {
namespace {

constexpr double hour_s = 3600.0;
constexpr double day_s = 86400.0;

std::string duration(double seconds) {
  if (!std::isfinite(seconds)) return "infinite";
  if (seconds < 600.0) return fmt::format("{:.7g} s", seconds);
  if (seconds < 2.0 * day_s) return fmt::format("{:.7g} h", seconds / hour_s);
  return fmt::format("{:.7g} d ({:.7g} h)", seconds / day_s, seconds / hour_s);
}

std::string triple(const Vector3& v) { return fmt::format("{:.9g}, {:.9g}, {:.9g}", v[0], v[1], v[2]); }

std::string in_degrees(const Direction& direction) {
  return fmt::format("{:7.3f}, {:+7.3f} deg", direction.longitude_rad * degrees, direction.latitude_rad * degrees);
}

std::string quaternion(const Quaternion& q) {
  return fmt::format("{:.12f}, {:.12f}, {:.12f}, {:.12f} (scalar first)", q.w(), q.x(), q.y(), q.z());
}

std::string angular_velocity(const Vector3& omega_rad_s) {
  const bool fast = omega_rad_s.norm() * degrees > 0.1;
  return triple(omega_rad_s * degrees * (fast ? 1.0 : day_s)) + (fast ? " deg/s" : " deg/day");
}

// "z", "-x", or the components of the principal axis in the axes of the file.
std::string axis_in_file(const Vector3& axis) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) == 1.0) return fmt::format("{}{}", axis[k] < 0.0 ? "-" : "", "xyz"[k]);
  }
  return fmt::format("({:+.6f}, {:+.6f}, {:+.6f})", axis[0], axis[1], axis[2]);
}

class Page {
 public:
  template <class... Arguments>
  void heading(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    line(fmt::format(format, std::forward<Arguments>(arguments)...));
  }
  void row(std::string_view label, std::string_view value) { line(fmt::format("  {:<31} {}", label, value)); }
  void gap() { text_.push_back('\n'); }
  std::string_view view() const { return text_; }

 private:
  /// What a file says is printed, not obeyed.
  void line(std::string_view text) { text_.append(printable(text)).push_back('\n'); }

  std::string text_;
};

void print_axis(Page& page, int principal, const AxisMotion& axis) {
  const char* word = axis_words[principal];
  page.row(fmt::format("P_phi, {}-axis convention", word), duration(axis.precession_period_s));
  page.row(fmt::format("{} axis to L", word),
           fmt::format("{:.3f} to {:.3f} deg", axis.least_angle_rad * degrees, axis.greatest_angle_rad * degrees));
}

void print_history(Page& page, const AttitudeHistory& history) {
  page.gap();
  page.heading("Attitude history of {}: {} row{} in {} segment{}, {}", history.object.empty() ? "?" : history.object,
               history.rows(), history.rows() == 1 ? "" : "s", history.segments.size(),
               history.segments.size() == 1 ? "" : "s",
               history.absolute_time ? name(history.scale) : "a clock of its own");
  for (const AttitudeSegment& s : history.segments) {
    const auto date = [&](Instant t) { return format_date(t, history.scale, 6); };
    page.row(
        fmt::format("{} in {}", s.body, s.frame),
        fmt::format("{} to {}, {} row{}{}, {} of degree {}{}", date(s.samples.front().time),
                    date(s.samples.back().time), s.samples.size(), s.samples.size() == 1 ? "" : "s",
                    s.has_rates() ? " with rates" : "", name(s.method), s.degree, s.method_stated ? "" : " (assumed)"));
    if (s.usable_start || s.usable_stop) {
      page.row("  usable",
               s.last() < s.first() ? "nothing of it" : fmt::format("{} to {}", date(s.first()), date(s.last())));
    }
  }
}

void print_uncertainty(Page& page, const BodyReport& report) {
  page.gap();
  page.heading("How well it is known (one sigma; linear, without torques)");
  const Uncertainty& uncertainty = *report.body.uncertainty;
  for (std::size_t i = 0; i < uncertainty.numbers.size(); ++i) {
    const PublishedNumber& number = uncertainty.numbers[i];
    page.row(number.name, fmt::format("{:.9g} +- {:.3g}", number.value, uncertainty.sigma(i)));
  }
  if (!report.worth) return;
  const StateWorth& worth = *report.worth;
  page.row("attitude at the epoch", fmt::format("{:.3g} deg", worth.sigma_at_epoch_rad * degrees));
  page.row("known to 1 deg", known_text(worth.degree));
  page.row("known to 10 deg", known_text(worth.ten_degrees));
  page.row("known at all (180 deg)", known_text(worth.at_all));
  page.row("largest term",
           fmt::format("{}: {:.0f} % of the variance {}", worth.limit, 100.0 * worth.limit_share,
                       worth.limit_s == 0.0 ? "at the epoch" : duration_text(worth.limit_s) + " after the epoch"));
  page.row("if that were ten times better", "known to 10 deg " + known_text(worth.with_better_limit));
}

void print(Page& page, const BodyReport& report) {
  const Body& body = report.body;
  page.heading("{}", body.name);
  page.row("file", report.path);
  if (!body.id.empty()) page.row("id", body.id);
  if (!body.source.empty()) page.row("source", body.source);
  if (body.inertia && !body.any_inertia) {
    const Inertia& inertia = *body.inertia;
    page.gap();
    page.heading("Inertia{}", inertia.absolute ? ", kg m2" : ", ratios");
    page.row("principal moments", triple(inertia.principal_moments));
    page.row("as parts of the largest", triple(inertia.principal_moments / inertia.principal_moments[2]));
    for (int k = 0; k < 3; ++k) {
      page.row(fmt::format("{} axis", axis_words[k]), axis_in_file(inertia.named_from_principal.col(k)));
    }
    const Vector3 ratios = equivalent_ellipsoid_ratios(inertia);
    page.row("axis ratios of an ellipsoid", fmt::format("1 : {:.4f} : {:.4f}", ratios[1], ratios[2]));
  }
  if (body.state) {
    const SpinState& state = *body.state;
    page.gap();
    page.heading("State at {} {}, frame {}", format_date(state.epoch, state.epoch_scale, 3), name(state.epoch_scale),
                 name(state.frame));
    if (state.q_frame_from_named) page.row("q_frame_from_body", quaternion(*state.q_frame_from_named));
    if (state.omega_named_rad_s) page.row("angular velocity, body axes", angular_velocity(*state.omega_named_rad_s));
  }
  for (const StatedAttitude& attitude : body.attitudes) {
    page.gap();
    page.heading("{}: attitude of {} in {}", attitude.block, attitude.body, attitude.frame);
    page.row("q_frame_from_body", quaternion(attitude.q_frame_from_body));
    if (attitude.omega_body_rad_s)
      page.row("angular velocity, body axes", angular_velocity(*attitude.omega_body_rad_s));
  }
  if (report.spin) {
    const SpinInvariants& spin = *report.spin;
    page.gap();
    page.heading("Motion: {}", name(body.any_inertia ? RotationMode::principal_axis : spin.mode));
    if (spin.rotation_axis >= 0) page.row("axis", axis_words[spin.rotation_axis]);
    if (spin.rotation_period_s) page.row("rotation period", duration(*spin.rotation_period_s));
    if (report.momentum_icrf) {
      page.row("angular momentum L, ecliptic", in_degrees(direction_of(*report.momentum_ecliptic)) + " (ECLIPJ2000)");
      page.row("angular momentum L, equatorial", in_degrees(direction_of(*report.momentum_icrf)) + " (ICRF)");
    }
    if (spin.mode != RotationMode::rest && !body.any_inertia) {
      page.row("energy E/E0 = 2 E I3 / L^2",
               fmt::format("{:.7g}{}", 1.0 + spin.energy_above_ground,
                           report.energy_sigma ? fmt::format(" +- {:.2g}", *report.energy_sigma) : ""));
      page.row("1 - 2 E I2 / L^2", fmt::format("{:+.4g}", spin.separatrix_offset));
    }
    if (spin.polhode_period_s) {
      page.row("P_psi, the polhode closes", duration(*spin.polhode_period_s));
      print_axis(page, 0, *spin.long_axis);
      print_axis(page, 2, *spin.short_axis);
      if (report.next_flip_s) page.row("first flip after the epoch", duration(*report.next_flip_s));
      page.row("distance from separatrix", fmt::format("{:.4g} (0 on it, 1 farthest)", *spin.separatrix_distance));
      for (const LightCurveFrequency& one : light_curve_frequencies(spin)) {
        page.row(fmt::format("light curve, {}", one.name),
                 fmt::format("{:.7g}/d, period {}", std::abs(one.per_s) * day_s, duration(1.0 / std::abs(one.per_s))));
      }
    }
  }
  if (body.uncertainty) print_uncertainty(page, report);
  if (report.history) print_history(page, *report.history);
  if (!body.notes.empty() || !body.warnings.empty()) page.gap();
  for (const std::string& note : body.notes) page.heading("note: {}", note);
  for (const std::string& warning : body.warnings) page.heading("warning: {}", warning);
}

}  // namespace

void add_info(CLI::App& app) {
  struct Options {
    std::vector<std::string> files;
    bool as_json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("info", "What a file of a body or of attitudes says: mode, periods, angular momentum, energy");
  command->footer(
      "Examples:\n  polhode info data/bodies/toutatis.toml\n"
      "  polhode info --json data/bodies/*.toml\n"
      "  polhode info ephemeris.fits\n"
      "  polhode info asteroid_models.csv#1234");
  command->add_option("FILE", options->files, "files of one of these kinds: " + names_of_input_formats())->required();
  command->add_flag("--json", options->as_json, "a JSON list, one object for each file");
  command->callback([options] {
    Page page;
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const std::string& file : options->files) {
      const BodyReport report = in_file(file, [&] { return report_on(file, read_body_and_history(file)); });
      if (options->as_json) {
        all.push_back(nlohmann::ordered_json::parse(json_text(report)));
      } else {
        if (!page.view().empty()) page.gap();
        print(page, report);
      }
    }
    write_standard_output(options->as_json
                              ? all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n"
                              : std::string(page.view()));
  });
}

}  // namespace polhode::tools
