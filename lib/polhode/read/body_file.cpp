#include "polhode/read/body_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

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

using Numbers = std::span<const double>;

void read_euler_angles(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  const std::string name = table.text("sequence");
  const std::string unit = table.text("unit");
  const EulerSequence sequence = table.located("sequence", [&] { return EulerSequence(name); });
  const double unit_rad = table.located("unit", [&] { return angle_unit_rad(unit); });
  const Vector3 angles = table.vector3("euler_angles");
  warn_of_degrees(table, "euler_angles", angles.cwiseAbs().maxCoeff(), unit, body);
  const std::size_t place = numbers.add(table, "euler_angles", {"1", "2", "3"});
  std::vector<EpochChange> changes;
  changes.reserve(3);
  for (int k = 0; k < 3; ++k) {
    changes.push_back(of_turn(omega_body_rad_s(sequence, unit_rad * angles, unit_rad * Vector3::Unit(k))));
  }
  numbers.set_changes(place, std::move(changes));
  numbers.make(body, [sequence, unit_rad, place](Numbers others, Body& made) {
    made.state->q_frame_from_named = q_frame_from_body(sequence, unit_rad * Vector3(&others[place]));
  });
}

/// As a file has it, of any length but 0.
Quaternion given_quaternion(const double* q, bool scalar_first) {
  return scalar_first ? Quaternion(q[0], q[1], q[2], q[3]) : Quaternion(q[3], q[0], q[1], q[2]);
}

void read_quaternion(const TomlTable& table, std::string_view form, Body& body, UncertainNumbers& numbers) {
  for (const std::string_view key : {"sequence", "unit"}) {
    if (table.has(key)) throw table.error(key, "goes with euler_angles, not with a quaternion");
  }
  const bool scalar_first = form.ends_with("first"), to_frame = form.starts_with("q_frame");
  const Quaternion given = given_quaternion(table.numbers(form, 4).data(), scalar_first);
  const double length = given.coeffs().stableNorm();
  if (length > 0.0 && std::abs(length - 1.0) > 1e-6) {
    body.warnings.push_back(fmt::format("the quaternion has length {:.9g}; it was scaled to 1", length));
  }
  const std::size_t place = scalar_first ? numbers.add(table, form, {"q0", "q1", "q2", "q3"})
                                         : numbers.add(table, form, {"q1", "q2", "q3", "q0"});
  table.located(form, [&] {
    numbers.make(body, [scalar_first, to_frame, place](Numbers others, Body& made) {
      const Quaternion q = given_quaternion(&others[place], scalar_first);
      if (!(q.coeffs().stableNorm() > 0.0)) throw InputError("found the zero quaternion, which is no attitude");
      const Quaternion unit(q.coeffs().stableNormalized().eval());
      made.state->q_frame_from_named = to_frame ? unit : unit.conjugate();
    });
  });
  const Quaternion& attitude = *body.state->q_frame_from_named;
  const Quaternion unit = to_frame ? attitude : attitude.conjugate();
  numbers.set_changes(place, changes_of_components(unit, length, scalar_first, to_frame));
}

void read_attitude(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"sequence", "unit"},
                   {"euler_angles", quaternion_keys[0], quaternion_keys[1], quaternion_keys[2], quaternion_keys[3]});
  const std::string_view form =
      table.one_of({"euler_angles", quaternion_keys[0], quaternion_keys[1], quaternion_keys[2], quaternion_keys[3]});
  if (form == "euler_angles") {
    read_euler_angles(table, body, numbers);
  } else {
    read_quaternion(table, form, body, numbers);
  }
}

/// "axes" of a rate: whether its components are those in the frame, not in the body.
bool components_in_frame(const TomlTable& table, const SpinState& state) {
  const std::string axes = table.text("axes");
  if (axes == "body") return false;
  if (axes != "frame") {
    throw table.error("axes", fmt::format("found '{:.60}'; allowed: 'body' (x, y, z of the inertia) or 'frame' (the "
                                          "inertial frame of the state)",
                                          axes));
  }
  if (!state.q_frame_from_named) throw table.error("axes", "components in the frame need an attitude, none is given");
  return true;
}

Vector3 in_body(const SpinState& state, bool in_frame, const Vector3& components) {
  return in_frame ? state.q_frame_from_named->conjugate() * components : components;
}

/// What the components of a rate do, where the rate in body axes is this matrix times those in body axes.
void set_changes_of_components(const SpinState& state, bool in_frame, const Matrix3& omega_of_components,
                               std::size_t place, UncertainNumbers& numbers) {
  const Matrix3 body_from_file =
      in_frame ? state.q_frame_from_named->conjugate().toRotationMatrix() : Matrix3(Matrix3::Identity());
  const Matrix3 omega = omega_of_components * body_from_file;
  numbers.set_changes(place, {of_rate(omega.col(0)), of_rate(omega.col(1)), of_rate(omega.col(2))});
}

void read_angular_velocity(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"axes", "unit"}, {"components"});
  const double unit_rad_s = table.parsed("unit", angular_velocity_unit_rad_s);
  const bool in_frame = components_in_frame(table, *body.state);
  const std::size_t place = numbers.add(table, "components", {"x", "y", "z"});
  numbers.make(body, [unit_rad_s, in_frame, place](Numbers others, Body& made) {
    made.state->omega_named_rad_s = unit_rad_s * in_body(*made.state, in_frame, Vector3(&others[place]));
  });
  if (in_frame) {  // it stays there where the body turns
    const Vector3 omega_rad_s = *body.state->omega_named_rad_s;
    numbers.follow([&](EpochChange& change) { change.omega_rad_s += omega_rad_s.cross(change.turn_rad); });
  }
  set_changes_of_components(*body.state, in_frame, unit_rad_s * Matrix3::Identity(), place, numbers);
}

void read_angular_momentum(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"axes", "unit"}, {"components"});
  const std::string unit_name = table.text("unit");
  const InertiaUnit unit = table.located("unit", [&] { return angular_momentum_unit(unit_name); });
  if (!body.inertia) throw table.error("components", "an angular momentum needs an [inertia] table");
  const Inertia& inertia = *body.inertia;
  if (unit.absolute != inertia.absolute) {
    throw table.error("unit",
                      fmt::format("found '{:.60}', but the inertia is in {}; both must be absolute, or both ratios",
                                  unit_name, inertia.absolute ? "absolute units" : "ratios"));
  }
  const bool in_frame = components_in_frame(table, *body.state);
  const std::size_t place = numbers.add(table, "components", {"x", "y", "z"});
  numbers.make(body, [factor = unit.factor, in_frame, place](Numbers others, Body& made) {
    const Vector3 momentum_named = factor * in_body(*made.state, in_frame, Vector3(&others[place]));
    const Vector3 momentum = made.inertia->named_from_principal.transpose() * momentum_named;
    made.state->omega_named_rad_s =
        made.inertia->named_from_principal * momentum.cwiseQuotient(made.inertia->principal_moments);
  });
  const Matrix3& axes = inertia.named_from_principal;
  const Vector3 omega_rad_s = *body.state->omega_named_rad_s;
  const Vector3 momentum_named = inertia_tensor(inertia) * omega_rad_s;
  const Matrix3 inverse_tensor = axes * inertia.principal_moments.cwiseInverse().asDiagonal() * axes.transpose();
  numbers.follow([&](EpochChange& change) {
    Vector3 of_momentum = -change.tensor * omega_rad_s;
    if (in_frame) of_momentum += momentum_named.cross(change.turn_rad);
    change.omega_rad_s += inverse_tensor * of_momentum;
  });
  set_changes_of_components(*body.state, in_frame, unit.factor * inverse_tensor, place, numbers);
}

Date epoch_of(const TomlTable& table) {
  return table.parsed("epoch", [](const std::string& text) { return parse_date_with_scale(text); });
}

void read_state(const TomlTable& table, Body& body, UncertainNumbers& numbers) {
  table.allow_only({"epoch", "frame", "attitude", "angular_velocity", "angular_momentum"});
  SpinState state;
  const Date date = epoch_of(table);
  state.epoch = date.instant;
  state.epoch_scale = date.scale;
  if (date.scale == TimeScale::utc) {
    if (const auto doubt = utc_doubt(date.instant)) body.warnings.push_back("epoch: " + *doubt);
  }
  state.frame = table.parsed("frame", frame_of_state);
  numbers.make(body, [state](Numbers, Body& made) { made.state = state; });
  if (table.has("attitude")) read_attitude(table.table("attitude"), body, numbers);
  if (table.has("angular_velocity") || table.has("angular_momentum")) {
    const std::string_view rate = table.one_of({"angular_velocity", "angular_momentum"});
    const TomlTable values = table.table(rate);
    if (rate == "angular_velocity") {
      read_angular_velocity(values, body, numbers);
    } else {
      read_angular_momentum(values, body, numbers);
    }
  }
}

/// Where the numbers of a [spin] are among those of the file.
struct SpinPlaces {
  std::size_t longitude = 0, latitude = 0;
  std::optional<std::size_t> phi0, psi0;
  std::optional<std::size_t> precession_period;  // none: rotation about one axis
  std::size_t rotation_period = 0;
};

/// What [spin] says besides, and the numbers in its units.
struct SpinText {
  PublishedSpin others;
  SpinPlaces places;
  double unit_deg = 1.0, unit_s = 1.0;

  PublishedSpin with(Numbers numbers) const {
    PublishedSpin spin = others;
    spin.longitude_deg = unit_deg * numbers[places.longitude];
    spin.latitude_deg = unit_deg * numbers[places.latitude];
    if (places.phi0) spin.phi0_deg = unit_deg * numbers[*places.phi0];
    if (places.psi0) spin.psi0_deg = unit_deg * numbers[*places.psi0];
    if (places.precession_period) spin.precession_period_s = unit_s * numbers[*places.precession_period];
    spin.rotation_period_s = unit_s * numbers[places.rotation_period];
    return spin;
  }
};

/// What the numbers of a tumbling [spin] do, those of the inertia through the motion that has the periods.
void set_changes_of_tumbling(const Body& body, PublishedTumbling spin, const SpinText& text,
                             UncertainNumbers& numbers) {
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
  const auto set = [&](std::size_t place, double unit, const TumblingPartials::Column& column) {
    numbers.set_changes(
        place, {epoch_change(inertia, omega_rad_s, unit * column.turn, unit * column.momentum, Matrix3::Zero())});
  };
  const double unit_rad = degree * text.unit_deg;
  const SpinPlaces& places = text.places;
  set(places.longitude, unit_rad, partials.longitude);
  set(places.latitude, unit_rad, partials.latitude);
  if (places.phi0) set(*places.phi0, unit_rad, partials.phi);
  if (places.psi0) set(*places.psi0, unit_rad, partials.psi);
  set(*places.precession_period, text.unit_s, partials.precession_period);
  set(places.rotation_period, text.unit_s, partials.rotation_period);
}

/// What the numbers of a [spin] about the z axis do.
void set_changes_of_principal_axis(const PublishedSpin& spin, const SpinText& text, UncertainNumbers& numbers) {
  const Vector3 angles = degree * Vector3(spin.longitude_deg, 90.0 - spin.latitude_deg, spin.phi0_deg.value_or(0.0));
  const auto turn = [&](const Vector3& of_angles) {
    return of_turn(degree * text.unit_deg * omega_body_rad_s(EulerSequence("ZYZ"), angles, of_angles));
  };
  numbers.set_changes(text.places.longitude, {turn(Vector3::UnitX())});
  numbers.set_changes(text.places.latitude, {turn(-Vector3::UnitY())});
  if (text.places.phi0) numbers.set_changes(*text.places.phi0, {turn(Vector3::UnitZ())});
  const double period_s = spin.rotation_period_s;
  numbers.set_changes(text.places.rotation_period,
                      {of_rate(-2.0 * std::numbers::pi * text.unit_s / (period_s * period_s) * Vector3::UnitZ())});
}

// Direction of the angular momentum, angles and periods, as light-curve papers have them.
void read_spin(const TomlTable& table, Body& body, const BodyFileSurroundings& around) {
  table.allow_only({"epoch", "frame", "unit", "convention", "mode", "period_unit"},
                   {"lambda", "beta", "phi0", "psi0", "theta0", "P_phi", "P_psi", "period", "energy"});
  SpinText text;
  PublishedSpin& spin = text.others;
  SpinPlaces& places = text.places;
  UncertainNumbers& numbers = around.numbers;
  const Date date = epoch_of(table);
  spin.epoch = date.instant;
  spin.epoch_scale = date.scale;
  spin.frame = table.parsed("frame", inertial_frame);
  const std::string unit = table.text("unit");
  text.unit_deg = table.located("unit", [&] { return angle_unit_rad(unit); }) * 180.0 / std::numbers::pi;
  for (const std::string_view key : {"lambda", "beta", "phi0", "psi0", "theta0"}) {
    if (table.has(key)) warn_of_degrees(table, key, table.number(key), unit, body);
  }
  const auto optional_place = [&](std::string_view key) {
    return table.has(key) ? std::optional(numbers.add(table, key)) : std::nullopt;
  };
  places.longitude = numbers.add(table, "lambda");
  places.latitude = numbers.add(table, "beta");
  table.located("beta", [&] {
    numbers.make(body, [text](Numbers others, Body&) {
      if (std::abs(text.unit_deg * others[text.places.latitude]) > 90.0) throw InputError("must be from -90 to 90 deg");
    });
  });
  places.phi0 = optional_place("phi0");
  text.unit_s = table.parsed("period_unit", duration_unit_s);
  const auto period_place = [&](std::string_view key) {
    const std::size_t place = numbers.add(table, key);
    table.located(key, [&] {
      numbers.make(body, [place, unit_s = text.unit_s](Numbers others, Body&) {
        if (!(unit_s * others[place] > 0.0)) throw InputError("must be positive");
      });
    });
    return place;
  };
  if (table.one_of({"period", "P_psi"}) == "period") {
    for (const std::string_view key : {"psi0", "theta0", "convention", "mode", "P_phi", "energy"}) {
      if (table.has(key)) throw table.error(key, "goes with P_phi and P_psi; `period` is rotation about one axis");
    }
    places.rotation_period = period_place("period");
    numbers.make(body, [text](Numbers others, Body& made) { set_principal_axis_state(made, text.with(others)); });
    set_changes_of_principal_axis(text.with(numbers.values()), text, numbers);
    return;
  }
  if (!body.inertia) throw table.error("P_psi", "tumbling needs an [inertia] table");
  places.psi0 = optional_place("psi0");
  if (table.has("theta0")) spin.theta0_deg = text.unit_deg * table.number("theta0");
  places.precession_period = period_place("P_phi");
  places.rotation_period = period_place("P_psi");
  if (table.has("energy")) spin.energy = table.number("energy");
  spin.energy_sigma = UncertainNumbers::sigma_beside(table, "energy");
  UncertainNumbers::sigma_beside(table, "theta0");
  const auto axis = [&](std::string_view key) {
    const std::string name = table.text(key);
    if (name != "long-axis" && name != "short-axis") {
      throw table.error(key, fmt::format("found '{:.60}'; allowed: 'long-axis', 'short-axis'", name));
    }
    return name == "long-axis";
  };
  spin.short_axis_convention = !axis("convention");
  if (table.has("mode")) spin.long_axis_mode = axis("mode");
  table.located("P_psi", [&] {
    numbers.make(body, [text](Numbers others, Body& made) { set_tumbling_state(made, text.with(others)); });
    if (!around.wants_changes) return;
    Body again = body;
    set_changes_of_tumbling(body, set_tumbling_state(again, text.with(numbers.values())), text, numbers);
  });
}

/// Makes the parts of a body that has its names.
void read_parts(const TomlTable& root, Body& body, const BodyFileSurroundings& around) {
  if (root.has("inertia")) read_inertia(root.table("inertia"), body, around);
  if (root.has("state") && root.has("spin")) throw root.error("spin", "either [state] or [spin], not both");
  if (root.has("state")) read_state(root.table("state"), body, around.numbers);
  if (root.has("spin")) read_spin(root.table("spin"), body, around);
  root.located(root.has("inertia") ? "inertia" : "spin", [&] {
    around.numbers.make(body, [](Numbers, Body& made) {
      if (made.inertia) check_range(*made.inertia);
    });
  });
  root.located(root.has("state") ? "state" : "spin", [&] {
    around.numbers.make(body, [](Numbers, Body& made) {
      if (made.state && made.state->omega_named_rad_s) check_range_of_rate(*made.state->omega_named_rad_s);
    });
  });
}

}  // namespace

Body parse_body_file(std::string_view text, const std::string& path, const ContentOf& content_of) {
  const TomlTable root = TomlTable::parse(text, path);
  root.allow_only({"name", "id", "source", "period_uncertainty", "inertia", "state", "spin", "uncertainty"});
  Body blank;
  blank.name = root.text("name");
  blank.id = root.optional_text("id").value_or("");
  blank.source = root.optional_text("source").value_or("");
  UncertainNumbers numbers;
  const bool wants_changes = root.has("uncertainty") || text.find("_sigma") != std::string_view::npos;
  Body body = blank;
  read_parts(root, body, {path, content_of, numbers, wants_changes});
  body.uncertainty = numbers.uncertainty(root, std::move(blank));
  if (root.has("period_uncertainty")) {
    root.located("period_uncertainty", [&] { set_period_uncertainty(body, root.number("period_uncertainty")); });
  }
  return body;
}

}  // namespace polhode
