#include "polhode/read/body_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/spin_partials.hpp"
#include "polhode/read/asteroid_files.hpp"
#include "polhode/read/inertia_table.hpp"
#include "polhode/read/range.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/read/uncertain_numbers.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

EpochChange of_turn(const Vector3& turn_rad) {
  EpochChange change;
  change.turn_rad = turn_rad;
  return change;
}
EpochChange of_rate(const Vector3& omega_rad_s) {
  EpochChange change;
  change.omega_rad_s = omega_rad_s;
  return change;
}
/// An angle in rad beyond one turn is most likely one in degrees.
void warn_of_degrees(const TomlTable& table, std::string_view key, double largest_rad, std::string_view unit,
                     Body& body) {
  constexpr double turn_rad = 2.0 * std::numbers::pi * (1.0 + 1e-6);
  if (unit != "rad" || !(std::abs(largest_rad) > turn_rad)) return;
  body.warnings.push_back(fmt::format("{}: {} has {:g} under unit = \"rad\", more than one turn; are degrees meant?",
                                      table.where(key).text(), key, largest_rad));
}

constexpr std::array<std::string_view, 4> quaternion_keys{
    "q_frame_from_body_scalar_first", "q_frame_from_body_scalar_last", "q_body_from_frame_scalar_first",
    "q_body_from_frame_scalar_last"};

/// What the components of a quaternion do, as far as they are not its length.
std::vector<EpochChange> changes_of_components(const Quaternion& unit, double length, bool scalar_first_in_file,
                                               bool to_frame) {
  std::vector<EpochChange> changes;
  for (int component = 0; component < 4; ++component) {
    const int k = scalar_first_in_file ? component : (component + 1) % 4;  // scalar first
    const Quaternion change = from_scalar_first(Eigen::Vector4d(Eigen::Vector4d::Unit(k) / length));
    // q exp(turn/2) of q_frame_from_body, or of the conjugate of its conjugate.
    const Vector3 turn =
        to_frame ? Vector3(2.0 * (unit.conjugate() * change).vec()) : Vector3(-2.0 * (change * unit.conjugate()).vec());
    changes.push_back(of_turn(turn));
  }
  return changes;
}

Quaternion read_attitude(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"sequence", "unit"},
                   {"euler_angles", quaternion_keys[0], quaternion_keys[1], quaternion_keys[2], quaternion_keys[3]});
  const std::string_view form =
      table.one_of({"euler_angles", quaternion_keys[0], quaternion_keys[1], quaternion_keys[2], quaternion_keys[3]});
  if (form == "euler_angles") {
    const std::string name = table.text("sequence");
    const std::string unit = table.text("unit");
    const EulerSequence sequence = table.located("sequence", [&] { return EulerSequence(name); });
    const double unit_rad = table.located("unit", [&] { return angle_unit_rad(unit); });
    const Vector3 angles = table.vector3(form);
    warn_of_degrees(table, form, angles.cwiseAbs().maxCoeff(), unit, body);
    std::vector<EpochChange> changes;
    changes.reserve(3);
    for (int k = 0; k < 3; ++k) {
      changes.push_back(of_turn(omega_body_rad_s(sequence, unit_rad * angles, unit_rad * Vector3::Unit(k))));
    }
    numbers.add(table, form, {"1", "2", "3"}, std::move(changes));
    return q_frame_from_body(sequence, unit_rad * angles);
  }
  for (const std::string_view key : {"sequence", "unit"}) {
    if (table.has(key)) throw table.error(key, "goes with euler_angles, not with a quaternion");
  }
  const std::vector<double> q = table.numbers(form, 4);
  const Quaternion given =
      form.ends_with("first") ? Quaternion(q[0], q[1], q[2], q[3]) : Quaternion(q[3], q[0], q[1], q[2]);
  const double length = given.coeffs().stableNorm();
  if (!(length > 0.0)) throw table.error(form, "found the zero quaternion, which is no attitude");
  if (std::abs(length - 1.0) > 1e-6) {
    body.warnings.push_back(fmt::format("the quaternion has length {:.9g}; it was scaled to 1", length));
  }
  const Quaternion unit(given.coeffs().stableNormalized().eval());
  const bool scalar_first = form.ends_with("first");
  const auto changes = changes_of_components(unit, length, scalar_first, form.starts_with("q_frame"));
  if (scalar_first) {
    numbers.add(table, form, {"q0", "q1", "q2", "q3"}, changes);
  } else {
    numbers.add(table, form, {"q1", "q2", "q3", "q0"}, changes);
  }
  return form.starts_with("q_frame") ? unit : unit.conjugate();
}

/// "axes" of a rate: its components in the body's, and where each of the file's leads.
struct Components {
  Vector3 in_body;
  Matrix3 body_from_file = Matrix3::Identity();
  bool in_frame = false;
};

Components read_components(const TomlTable& table, const SpinState& state) {
  const std::string axes = table.text("axes");
  const Vector3 components = table.vector3("components");
  if (axes == "body") return {components};
  if (axes != "frame") {
    throw table.error("axes", fmt::format("found '{}'; allowed: 'body' (x, y, z of the inertia) or 'frame' (the "
                                          "inertial frame of the state)",
                                          axes));
  }
  if (!state.q_frame_from_named) throw table.error("axes", "components in the frame need an attitude, none is given");
  const Quaternion q_named_from_frame = state.q_frame_from_named->conjugate();
  return {q_named_from_frame * components, q_named_from_frame.toRotationMatrix(), true};
}

void add_components(const TomlTable& table, const Matrix3& omega_of_components, UncertainNumbers& numbers) {
  numbers.add(
      table, "components", {"x", "y", "z"},
      {of_rate(omega_of_components.col(0)), of_rate(omega_of_components.col(1)), of_rate(omega_of_components.col(2))});
}

Vector3 read_angular_velocity(const TomlTable& table, const SpinState& state, UncertainNumbers& numbers) {
  table.allow_only({"axes", "unit"}, {"components"});
  const double unit_rad_s = table.parsed("unit", angular_velocity_unit_rad_s);
  const Components components = read_components(table, state);
  const Vector3 omega_rad_s = unit_rad_s * components.in_body;
  if (components.in_frame) {  // it stays there where the body turns
    numbers.follow([&](EpochChange& change) { change.omega_rad_s += omega_rad_s.cross(change.turn_rad); });
  }
  add_components(table, unit_rad_s * components.body_from_file, numbers);
  return omega_rad_s;
}

Vector3 read_angular_momentum(const TomlTable& table, const SpinState& state, const std::optional<Inertia>& inertia,
                              UncertainNumbers& numbers) {
  table.allow_only({"axes", "unit"}, {"components"});
  const std::string unit_name = table.text("unit");
  const InertiaUnit unit = table.located("unit", [&] { return angular_momentum_unit(unit_name); });
  if (!inertia) throw table.error("components", "an angular momentum needs an [inertia] table");
  if (unit.absolute != inertia->absolute) {
    throw table.error("unit", fmt::format("found '{}', but the inertia is in {}; both must be absolute, or both ratios",
                                          unit_name, inertia->absolute ? "absolute units" : "ratios"));
  }
  const Components components = read_components(table, state);
  const Vector3 momentum_named = unit.factor * components.in_body;
  const Matrix3& axes = inertia->named_from_principal;
  const Vector3 momentum = axes.transpose() * momentum_named;
  const Vector3 omega_rad_s = axes * momentum.cwiseQuotient(inertia->principal_moments);
  const Matrix3 inverse_tensor = axes * inertia->principal_moments.cwiseInverse().asDiagonal() * axes.transpose();
  numbers.follow([&](EpochChange& change) {
    Vector3 of_momentum = -change.tensor * omega_rad_s;
    if (components.in_frame) of_momentum += momentum_named.cross(change.turn_rad);
    change.omega_rad_s += inverse_tensor * of_momentum;
  });
  add_components(table, unit.factor * inverse_tensor * components.body_from_file, numbers);
  return omega_rad_s;
}

Date epoch_of(const TomlTable& table) {
  return table.parsed("epoch", [](const std::string& text) { return parse_date_with_scale(text); });
}

SpinState read_state(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"epoch", "frame", "attitude", "angular_velocity", "angular_momentum"});
  SpinState state;
  const Date date = epoch_of(table);
  state.epoch = date.instant;
  state.epoch_scale = date.scale;
  if (date.scale == TimeScale::utc) {
    if (const auto doubt = utc_doubt(date.instant)) body.warnings.push_back("epoch: " + *doubt);
  }
  state.frame = table.parsed("frame", frame_of_state);
  if (table.has("attitude")) state.q_frame_from_named = read_attitude(table.table("attitude"), body, numbers);
  if (table.has("angular_velocity") || table.has("angular_momentum")) {
    const std::string_view rate = table.one_of({"angular_velocity", "angular_momentum"});
    const TomlTable values = table.table(rate);
    state.omega_named_rad_s = rate == "angular_velocity" ? read_angular_velocity(values, state, numbers)
                                                         : read_angular_momentum(values, state, body.inertia, numbers);
  }
  return state;
}

/// What the numbers of a tumbling [spin] do, those of the inertia through the motion that has the periods.
void add_tumbling_numbers(const TomlTable& table, const Body& body, PublishedTumbling spin, double unit_rad,
                          double unit_s, UncertainNumbers& numbers) {
  const Inertia inertia = separate_moments(*body.inertia);
  if (inertia.principal_moments != body.inertia->principal_moments) {
    spin.periods.long_axis_mode = spin.motion.long_axis_mode;
    spin.motion = solve_periods(inertia, spin.periods).front();
  }
  const Vector3& omega_rad_s = *body.state->omega_named_rad_s;
  const TumblingPartials partials = tumbling_partials(inertia, spin);
  numbers.follow([&](EpochChange& change) {
    const Vector3 moments =
        (inertia.named_from_principal.transpose() * change.tensor * inertia.named_from_principal).diagonal();
    Vector3 turn = Vector3::Zero(), momentum = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
      turn += moments[k] * partials.moments[static_cast<std::size_t>(k)].turn;
      momentum += moments[k] * partials.moments[static_cast<std::size_t>(k)].momentum;
    }
    change = epoch_change(inertia, omega_rad_s, turn, momentum, change.tensor);
  });
  const auto add = [&](std::string_view key, double unit, const TumblingPartials::Column& column) {
    if (!table.has(key)) return;
    numbers.add(table, key, {},
                {epoch_change(inertia, omega_rad_s, unit * column.turn, unit * column.momentum, Matrix3::Zero())});
  };
  add("lambda", unit_rad, partials.longitude);
  add("beta", unit_rad, partials.latitude);
  add("phi0", unit_rad, partials.phi);
  add("psi0", unit_rad, partials.psi);
  add("P_phi", unit_s, partials.precession_period);
  add("P_psi", unit_s, partials.rotation_period);
}

/// What the numbers of a [spin] about the z axis do.
void add_principal_axis_numbers(const TomlTable& table, const PublishedSpin& spin, double unit_rad, double unit_s,
                                UncertainNumbers& numbers) {
  const Vector3 angles = degree * Vector3(spin.longitude_deg, 90.0 - spin.latitude_deg, spin.phi0_deg.value_or(0.0));
  const auto turn = [&](const Vector3& of_angles) {
    return of_turn(unit_rad * omega_body_rad_s(EulerSequence("ZYZ"), angles, of_angles));
  };
  numbers.add(table, "lambda", {}, {turn(Vector3::UnitX())});
  numbers.add(table, "beta", {}, {turn(-Vector3::UnitY())});
  if (spin.phi0_deg) numbers.add(table, "phi0", {}, {turn(Vector3::UnitZ())});
  const double period_s = spin.rotation_period_s;
  numbers.add(table, "period", {},
              {of_rate(-2.0 * std::numbers::pi * unit_s / (period_s * period_s) * Vector3::UnitZ())});
}

// Direction of the angular momentum, angles and periods, as light-curve papers have them.
void read_spin(const TomlTable& table, Body& body, const BodyFileSurroundings& around) {
  table.allow_only({"epoch", "frame", "unit", "convention", "mode", "period_unit"},
                   {"lambda", "beta", "phi0", "psi0", "theta0", "P_phi", "P_psi", "period", "energy"});
  PublishedSpin spin;
  const Date date = epoch_of(table);
  spin.epoch = date.instant;
  spin.epoch_scale = date.scale;
  spin.frame = table.parsed("frame", inertial_frame);
  const std::string unit = table.text("unit");
  const double unit_deg = table.located("unit", [&] { return angle_unit_rad(unit); }) * 180.0 / std::numbers::pi;
  for (const std::string_view key : {"lambda", "beta", "phi0", "psi0", "theta0"}) {
    if (table.has(key)) warn_of_degrees(table, key, table.number(key), unit, body);
  }
  spin.longitude_deg = unit_deg * table.number("lambda");
  spin.latitude_deg = unit_deg * table.number("beta");
  if (std::abs(spin.latitude_deg) > 90.0) throw table.error("beta", "must be from -90 to 90 deg");
  const auto angle = [&](std::string_view key) {
    return table.has(key) ? std::optional(unit_deg * table.number(key)) : std::nullopt;
  };
  spin.phi0_deg = angle("phi0");
  const double unit_s = table.parsed("period_unit", duration_unit_s);
  const auto period = [&](std::string_view key) {
    const double value = unit_s * table.number(key);
    if (!(value > 0.0)) throw table.error(key, "must be positive");
    return value;
  };
  if (table.one_of({"period", "P_psi"}) == "period") {
    for (const std::string_view key : {"psi0", "theta0", "convention", "mode", "P_phi", "energy"}) {
      if (table.has(key)) throw table.error(key, "goes with P_phi and P_psi; `period` is rotation about one axis");
    }
    spin.rotation_period_s = period("period");
    set_principal_axis_state(body, spin);
    add_principal_axis_numbers(table, spin, degree * unit_deg, unit_s, around.numbers);
    return;
  }
  if (!body.inertia) throw table.error("P_psi", "tumbling needs an [inertia] table");
  spin.psi0_deg = angle("psi0");
  spin.theta0_deg = angle("theta0");
  spin.precession_period_s = period("P_phi");
  spin.rotation_period_s = period("P_psi");
  if (table.has("energy")) spin.energy = table.number("energy");
  spin.energy_sigma = UncertainNumbers::sigma_beside(table, "energy");
  UncertainNumbers::sigma_beside(table, "theta0");
  const auto axis = [&](std::string_view key) {
    const std::string name = table.text(key);
    if (name != "long-axis" && name != "short-axis") {
      throw table.error(key, fmt::format("found '{}'; allowed: 'long-axis', 'short-axis'", name));
    }
    return name == "long-axis";
  };
  spin.short_axis_convention = !axis("convention");
  if (table.has("mode")) spin.long_axis_mode = axis("mode");
  table.located("P_psi", [&] {
    const PublishedTumbling solved = set_tumbling_state(body, spin);
    if (around.wants_changes) add_tumbling_numbers(table, body, solved, degree * unit_deg, unit_s, around.numbers);
  });
}

Body body_of(const TomlTable& root, const BodyFileSurroundings& around) {
  root.allow_only({"name", "id", "source", "period_uncertainty", "inertia", "state", "spin", "uncertainty"});
  Body body;
  body.name = root.text("name");
  body.id = root.optional_text("id").value_or("");
  body.source = root.optional_text("source").value_or("");
  if (root.has("inertia")) body.inertia = read_inertia(root.table("inertia"), body, around);
  if (root.has("state") && root.has("spin")) throw root.error("spin", "either [state] or [spin], not both");
  if (root.has("state")) body.state = read_state(root.table("state"), body, around.numbers);
  if (root.has("spin")) read_spin(root.table("spin"), body, around);
  if (body.inertia) root.located(root.has("inertia") ? "inertia" : "spin", [&] { check_range(*body.inertia); });
  if (body.state && body.state->omega_named_rad_s) {
    root.located(root.has("state") ? "state" : "spin", [&] { check_range_of_rate(*body.state->omega_named_rad_s); });
  }
  return body;
}

}  // namespace

Body parse_body_file(std::string_view text, const std::string& path, const ContentOf& content_of) {
  const TomlTable root = TomlTable::parse(text, path);
  UncertainNumbers numbers;
  const bool wants_changes = root.has("uncertainty") || text.find("_sigma") != std::string_view::npos;
  Body body = body_of(root, {path, content_of, numbers, wants_changes});
  body.uncertainty = numbers.uncertainty(root, [path, content_of](const TomlTable& other) {
    UncertainNumbers of_clone;
    return body_of(other, {path, content_of, of_clone, false, true});
  });
  if (root.has("period_uncertainty")) {
    root.located("period_uncertainty", [&] { set_period_uncertainty(body, root.number("period_uncertainty")); });
  }
  return body;
}

}  // namespace polhode
