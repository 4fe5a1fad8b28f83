#include "polhode/session/body_report.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "polhode/motion/events.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/known_until.hpp"

namespace polhode {
namespace {

using Json = nlohmann::ordered_json;

constexpr double degrees = 180.0 / std::numbers::pi;
constexpr double close_to_separatrix = 1e-4;

Json list(const Vector3& v) { return {v[0], v[1], v[2]}; }

Json json(const AxisMotion& axis) {
  return {{"precession_period_s", axis.precession_period_s},
          {"least_angle_deg", axis.least_angle_rad * degrees},
          {"greatest_angle_deg", axis.greatest_angle_rad * degrees}};
}

Json json(const Direction& direction) { return {direction.longitude_rad * degrees, direction.latitude_rad * degrees}; }

/// Seconds after the epoch; null: for ever.
Json json(const KnownUntil& known) { return std::isfinite(known.after_s) ? Json(known.after_s) : Json(); }

Json json(const Body& body, const std::optional<double>& energy_sigma, const std::optional<StateWorth>& worth) {
  Json out{{"parameters", Json::array()}, {"sigmas", Json::array()}};
  for (std::size_t i = 0; i < body.uncertainty->numbers.size(); ++i) {
    out["parameters"].push_back(body.uncertainty->numbers[i].name);
    out["sigmas"].push_back(body.uncertainty->sigma(i));
  }
  if (energy_sigma) out["energy_above_ground_sigma"] = *energy_sigma;
  if (!worth) return out;
  out["sigma_at_epoch_deg"] = worth->sigma_at_epoch_rad * degrees;
  out["known_to_1_deg_until_s"] = json(worth->degree);
  out["known_to_10_deg_until_s"] = json(worth->ten_degrees);
  out["known_until_s"] = json(worth->at_all);
  out["largest_term"] = worth->limit;
  out["largest_term_at_s"] = worth->limit_s;
  out["largest_term_share"] = worth->limit_share;
  out["known_to_10_deg_with_it_ten_times_better_until_s"] = json(worth->with_better_limit);
  return out;
}

Json json(const AttitudeHistory& history) {
  Json out{{"object", history.object},
           {"scale", name(history.scale)},
           {"rows", history.rows()},
           {"segments", Json::array()}};
  for (const AttitudeSegment& s : history.segments) {
    const Eigen::Vector4d q = scalar_first(s.samples.front().q_frame_from_body);
    out["segments"].push_back({{"frame", s.frame},
                               {"body", s.body},
                               {"start", format_date(s.samples.front().time, history.scale, 9)},
                               {"stop", format_date(s.samples.back().time, history.scale, 9)},
                               {"usable_start", format_date(s.first(), history.scale, 9)},
                               {"usable_stop", format_date(s.last(), history.scale, 9)},
                               {"rows", s.samples.size()},
                               {"rates", s.has_rates()},
                               {"interpolation", name(s.method)},
                               {"degree", s.degree},
                               {"interpolation_stated", s.method_stated},
                               {"first_q_frame_from_body_scalar_first", {q[0], q[1], q[2], q[3]}}});
  }
  return out;
}

}  // namespace

BodyReport report_on(const std::string& path, BodyAndHistory file) {
  BodyReport report{path,         std::move(file.body), std::nullopt,
                    std::nullopt, std::nullopt,         std::move(file.history),
                    std::nullopt, std::nullopt,         std::nullopt};
  Body& body = report.body;
  for (const std::string& what : body.missing) {
    body.warnings.push_back((report.history ? "cannot be propagated beyond its attitude history; it lacks "
                                            : "cannot be propagated; it lacks ") +
                            what);
  }
  if (!body.inertia) {
    body.warnings.push_back("no inertia is given: nothing can be said about the motion");
  } else if (!body.inertia->absolute && !body.any_inertia) {
    body.warnings.push_back(
        "the inertia is known as ratios only: free motion needs no more, torques cannot be computed");
  }
  if (!body.state || !body.state->omega_named_rad_s) {
    body.warnings.push_back("no angular velocity or momentum is given: nothing can be said about the motion");
  } else if (body.inertia) {
    report.spin = spin_invariants(*body.inertia, momentum_principal(body));
    if (!body.state->q_frame_from_named) {
      body.warnings.push_back("no attitude is given: the body's axes cannot be placed in the frame");
    } else if (report.spin->mode != RotationMode::rest) {
      report.momentum_ecliptic = momentum_in_frame(body, Frame::ecliptic_j2000);
      report.momentum_icrf = momentum_in_frame(body, Frame::icrf);
    }
    if (body.missing.empty() && report.spin->polhode_period_s) {
      report.next_flip_s = next_flip_s(ThetaMotion(free_body(body)), 0.0);
    }
    if (report.spin->separatrix_distance && *report.spin->separatrix_distance < close_to_separatrix) {
      body.warnings.push_back(
          "close to the separatrix: mode and periods hang on the last digits of the inertia and of the rate");
    }
    if (report.spin->mode == RotationMode::principal_axis && report.spin->rotation_axis == 1) {
      body.warnings.push_back("rotation about the intermediate axis is unstable: the smallest disturbance flips it");
    }
  }
  if (body.uncertainty && report.spin && report.spin->mode != RotationMode::rest) {
    constexpr double rounding = 1e-15;  // a factor of all rates changes nothing of it
    const double sigma = energy_sigma(body);
    if (sigma > rounding) report.energy_sigma = sigma;
    if (body.missing.empty()) report.worth = state_worth(body);
  }
  return report;
}

std::string json_text(const BodyReport& report) {
  const Body& body = report.body;
  Json out{{"file", report.path}, {"name", body.name}, {"id", body.id}, {"source", body.source}};
  if (body.inertia && !body.any_inertia) {
    const Inertia& inertia = *body.inertia;
    Json axes = Json::array();
    for (int k = 0; k < 3; ++k) axes.push_back(list(inertia.named_from_principal.col(k)));
    out["inertia"] = {{"unit", inertia.absolute ? "kg m2" : "ratios"},
                      {"principal_moments", list(inertia.principal_moments)},
                      {"principal_axes_in_body", axes},
                      {"ellipsoid_axis_ratios", list(equivalent_ellipsoid_ratios(inertia))}};
  }
  if (body.state) {
    const SpinState& state = *body.state;
    out["state"] = {{"epoch", format_date(state.epoch, state.epoch_scale, 9)},
                    {"scale", name(state.epoch_scale)},
                    {"frame", name(state.frame)}};
    if (state.q_frame_from_named) {
      const Eigen::Vector4d q = scalar_first(*state.q_frame_from_named);
      out["state"]["q_frame_from_body_scalar_first"] = {q[0], q[1], q[2], q[3]};
    }
    if (state.omega_named_rad_s) out["state"]["omega_body_rad_s"] = list(*state.omega_named_rad_s);
  }
  if (report.spin) {
    const SpinInvariants& spin = *report.spin;
    const bool absolute = body.inertia->absolute;
    Json motion{{"mode", name(body.any_inertia ? RotationMode::principal_axis : spin.mode)}};
    if (!body.any_inertia) {
      motion[absolute ? "momentum_N_m_s" : "momentum_ratios_rad_s"] = spin.momentum;
      motion[absolute ? "twice_energy_J" : "twice_energy_ratios_rad2_s2"] = spin.twice_energy;
    }
    if (spin.rotation_axis >= 0) motion["axis"] = axis_words[spin.rotation_axis];
    if (spin.rotation_period_s) motion["rotation_period_s"] = *spin.rotation_period_s;
    if (report.momentum_icrf) {
      motion["momentum_ecliptic_deg"] = json(direction_of(*report.momentum_ecliptic));
      motion["momentum_equatorial_deg"] = json(direction_of(*report.momentum_icrf));
    }
    if (!body.any_inertia) {
      motion["energy_above_ground_relative"] = spin.energy_above_ground;  // E/E0 - 1
      motion["separatrix_offset"] = spin.separatrix_offset;
    }
    if (spin.polhode_period_s) {
      motion["separatrix_distance"] = *spin.separatrix_distance;
      motion["polhode_period_s"] = *spin.polhode_period_s;  // null where infinite
      motion["long_axis"] = json(*spin.long_axis);
      motion["short_axis"] = json(*spin.short_axis);
      if (report.next_flip_s) motion["first_flip_after_epoch_s"] = *report.next_flip_s;
    }
    out["motion"] = motion;
  }
  if (body.uncertainty) out["uncertainty"] = json(body, report.energy_sigma, report.worth);
  for (const StatedAttitude& attitude : body.attitudes) {
    const Eigen::Vector4d q = scalar_first(attitude.q_frame_from_body);
    Json stated{{"block", attitude.block},
                {"frame", attitude.frame},
                {"body", attitude.body},
                {"q_frame_from_body_scalar_first", {q[0], q[1], q[2], q[3]}}};
    if (attitude.omega_body_rad_s) stated["omega_body_rad_s"] = list(*attitude.omega_body_rad_s);
    out["attitudes"].push_back(stated);
  }
  if (report.history) out["history"] = json(*report.history);
  out["missing"] = body.missing;
  out["notes"] = body.notes;
  out["warnings"] = body.warnings;
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace polhode
