#include "polhode/read/body_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/read/asteroid_files.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/range.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

int axis_index(const TomlTable& table, std::string_view key) {
  const std::string axis = table.text(key);
  const auto at = std::string_view("xyz").find(axis);
  if (axis.size() != 1 || at == std::string_view::npos) {
    throw table.error(key, fmt::format("'{}' is not an axis; allowed: x, y, z", axis));
  }
  return static_cast<int>(at);
}

// What the file says about its axes must be what its moments say.
void check_axis_names(const TomlTable& table, const Inertia& inertia) {
  constexpr std::array<std::string_view, 3> keys{"long_axis", "intermediate_axis", "short_axis"};
  const Vector3 moments_named = inertia_tensor(inertia).diagonal();
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (!table.has(keys[k])) continue;
    const int axis = axis_index(table, keys[k]);
    const double wanted = inertia.principal_moments[static_cast<int>(k)];
    if (moments_named[axis] == wanted) continue;
    throw table.error(keys[k], fmt::format("the moment about {} is {:.9g}, but the {} of the three is {:.9g} (the long "
                                           "axis has the smallest moment, the short axis the largest)",
                                           "xyz"[axis], moments_named[axis],
                                           k == 0   ? "smallest"
                                           : k == 1 ? "middle one"
                                                    : "largest",
                                           wanted));
  }
}

// A solid of uniform density: its moments per mass, or with `mass_kg` or `density_kg_m3` in kg m2.
Inertia uniform_solid(const TomlTable& table, std::string_view form, const MassProperties& solid, double unit_m) {
  const bool has_mass = table.has("mass_kg");
  const bool has_density = table.has("density_kg_m3");
  if (has_mass && has_density) throw table.error("density_kg_m3", "either mass_kg or density_kg_m3, not both");
  double factor = unit_m * unit_m / solid.volume;  // of 1 kg
  if (has_mass || has_density) {
    const std::string_view key = has_mass ? "mass_kg" : "density_kg_m3";
    const double value = table.number(key);
    if (!(value > 0.0)) throw table.error(key, "must be positive");
    factor *= has_mass ? value : value * solid.volume * unit_m * unit_m * unit_m;
  }
  return table.located(
      form, [&] { return inertia_from_tensor(Matrix3(factor * solid.inertia_about_centre), has_mass || has_density); });
}

/// 1 where nothing depends on the unit.
double solid_unit_m(const TomlTable& table) {
  if (!table.has("mass_kg") && !table.has("density_kg_m3") && !table.has("length_unit")) return 1.0;
  return table.parsed("length_unit", length_unit_m);
}

Inertia read_mesh_inertia(const TomlTable& table, Body& body, const std::string& path, const ContentOf& content_of) {
  table.allow_only({"mesh", "mass_kg", "density_kg_m3", "length_unit"});
  const std::filesystem::path named = table.file_name("mesh");
  const std::string file = (named.is_absolute() ? named : std::filesystem::path(path).parent_path() / named).string();
  const double unit_m = solid_unit_m(table);
  const TriangleMesh mesh = read_mesh(table.opened("mesh", [&] { return content_of(file); }), file);
  const MassProperties solid = table.located("mesh", [&] { return mass_properties(mesh); });
  body.notes.push_back(describe(solid));
  return uniform_solid(table, "mesh", solid, unit_m);
}

Inertia read_ellipsoid_inertia(const TomlTable& table) {
  table.allow_only({"semi_axes", "mass_kg", "density_kg_m3", "length_unit"});
  const Vector3 axes = table.vector3("semi_axes");
  if (!(axes.minCoeff() > 0.0)) throw table.error("semi_axes", "must be positive");
  const double unit_m = solid_unit_m(table);
  const Vector3 squares = axes.cwiseProduct(axes);
  MassProperties solid;
  solid.volume = 4.0 / 3.0 * std::numbers::pi * axes.prod();
  solid.inertia_about_centre =
      Vector3(solid.volume / 5.0 * Vector3(squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]))
          .asDiagonal();
  return uniform_solid(table, "semi_axes", solid, unit_m);
}

Inertia read_inertia(const TomlTable& table, Body& body, const std::string& path, const ContentOf& content_of) {
  if (table.has("mesh")) return read_mesh_inertia(table, body, path, content_of);
  if (table.has("semi_axes")) return read_ellipsoid_inertia(table);
  // The last two have been asked for: they stand here for the messages.
  table.allow_only({"moments", "products", "products_are", "tensor", "unit", "long_axis", "intermediate_axis",
                    "short_axis", "mesh", "semi_axes"});
  const std::string_view form = table.one_of({"moments", "tensor", "mesh", "semi_axes"});
  const InertiaUnit unit = table.parsed("unit", inertia_unit);
  const bool axes_named = table.has("long_axis") || table.has("intermediate_axis") || table.has("short_axis");
  Matrix3 tensor;
  bool diagonal = false;
  if (form == "tensor") {
    for (const std::string_view key : {"products", "products_are"}) {
      if (table.has(key)) throw table.error(key, "goes with moments; a tensor has its products in it");
    }
    tensor = table.matrix3("tensor");
    if ((tensor - tensor.transpose()).cwiseAbs().maxCoeff() > 1e-12 * tensor.cwiseAbs().maxCoeff()) {
      throw table.error("tensor", "found a matrix that is not symmetric; a tensor of inertia is");
    }
  } else {
    Vector3 products = Vector3::Zero();
    ProductsOfInertia sign = ProductsOfInertia::tensor_elements;
    diagonal = !table.has("products");
    if (!diagonal) {
      products = table.vector3("products");
      const std::string are = table.text("products_are");
      if (are == "positive integrals") {
        sign = ProductsOfInertia::positive_integrals;
      } else if (are != "tensor elements") {
        throw table.error("products_are",
                          fmt::format("'{}' is not a sign convention; allowed: 'tensor elements' (Ixy = -integral of x "
                                      "y dm) or 'positive integrals' (Ixy = +integral of x y dm)",
                                      are));
      }
    } else if (table.has("products_are")) {
      throw table.error("products_are", "goes with products, which are not given");
    }
    tensor = inertia_tensor(table.vector3("moments"), products, sign);
  }
  if (axes_named && !diagonal) {
    throw table.error(table.one_of({"long_axis", "intermediate_axis", "short_axis"}),
                      "only moments without products belong to axes that can be named so");
  }
  const Inertia inertia =
      table.located(form, [&] { return inertia_from_tensor(Matrix3(unit.factor * tensor), unit.absolute); });
  check_axis_names(table, inertia);
  return inertia;
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

Quaternion read_attitude(const TomlTable& table, Body& body) {
  table.allow_only({"euler_angles", "sequence", "unit", quaternion_keys[0], quaternion_keys[1], quaternion_keys[2],
                    quaternion_keys[3]});
  const std::string_view form =
      table.one_of({"euler_angles", quaternion_keys[0], quaternion_keys[1], quaternion_keys[2], quaternion_keys[3]});
  if (form == "euler_angles") {
    const std::string name = table.text("sequence");
    const std::string unit = table.text("unit");
    const EulerSequence sequence = table.located("sequence", [&] { return EulerSequence(name); });
    const double unit_rad = table.located("unit", [&] { return angle_unit_rad(unit); });
    const Vector3 angles = table.vector3(form);
    warn_of_degrees(table, form, angles.cwiseAbs().maxCoeff(), unit, body);
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
  return form.starts_with("q_frame") ? unit : unit.conjugate();
}

// "axes" of a rate: the components as they are, or turned from the inertial frame into the body.
Vector3 read_components(const TomlTable& table, const SpinState& state) {
  const std::string axes = table.text("axes");
  const Vector3 components = table.vector3("components");
  if (axes == "body") return components;
  if (axes != "frame") {
    throw table.error("axes", fmt::format("found '{}'; allowed: 'body' (x, y, z of the inertia) or 'frame' (the "
                                          "inertial frame of the state)",
                                          axes));
  }
  if (!state.q_frame_from_named) throw table.error("axes", "components in the frame need an attitude, none is given");
  return state.q_frame_from_named->conjugate() * components;
}

Vector3 read_angular_velocity(const TomlTable& table, const SpinState& state) {
  table.allow_only({"components", "axes", "unit"});
  const double unit_rad_s = table.parsed("unit", angular_velocity_unit_rad_s);
  return unit_rad_s * read_components(table, state);
}

Vector3 read_angular_momentum(const TomlTable& table, const SpinState& state, const std::optional<Inertia>& inertia) {
  table.allow_only({"components", "axes", "unit"});
  const std::string unit_name = table.text("unit");
  const InertiaUnit unit = table.located("unit", [&] { return angular_momentum_unit(unit_name); });
  if (!inertia) throw table.error("components", "an angular momentum needs an [inertia] table");
  if (unit.absolute != inertia->absolute) {
    throw table.error("unit", fmt::format("found '{}', but the inertia is in {}; both must be absolute, or both ratios",
                                          unit_name, inertia->absolute ? "absolute units" : "ratios"));
  }
  const Vector3 momentum_named = unit.factor * read_components(table, state);
  const Vector3 momentum = inertia->named_from_principal.transpose() * momentum_named;
  return inertia->named_from_principal * momentum.cwiseQuotient(inertia->principal_moments);
}

Date epoch_of(const TomlTable& table) {
  return table.parsed("epoch", [](const std::string& text) { return parse_date_with_scale(text); });
}

SpinState read_state(const TomlTable& table, Body& body) {
  table.allow_only({"epoch", "frame", "attitude", "angular_velocity", "angular_momentum"});
  SpinState state;
  const Date date = epoch_of(table);
  state.epoch = date.instant;
  state.epoch_scale = date.scale;
  if (date.scale == TimeScale::utc) {
    if (const auto doubt = utc_doubt(date.instant)) body.warnings.push_back("epoch: " + *doubt);
  }
  state.frame = table.parsed("frame", frame_of_state);
  if (table.has("attitude")) state.q_frame_from_named = read_attitude(table.table("attitude"), body);
  if (table.has("angular_velocity") || table.has("angular_momentum")) {
    const std::string_view rate = table.one_of({"angular_velocity", "angular_momentum"});
    const TomlTable values = table.table(rate);
    state.omega_named_rad_s = rate == "angular_velocity" ? read_angular_velocity(values, state)
                                                         : read_angular_momentum(values, state, body.inertia);
  }
  return state;
}

// Direction of the angular momentum, angles and periods, as light-curve papers have them.
void read_spin(const TomlTable& table, Body& body) {
  table.allow_only({"epoch", "frame", "unit", "lambda", "beta", "phi0", "psi0", "theta0", "convention", "mode",
                    "period_unit", "P_phi", "P_psi", "period", "energy"});
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
    return;
  }
  if (!body.inertia) throw table.error("P_psi", "tumbling needs an [inertia] table");
  spin.psi0_deg = angle("psi0");
  spin.theta0_deg = angle("theta0");
  spin.precession_period_s = period("P_phi");
  spin.rotation_period_s = period("P_psi");
  if (table.has("energy")) spin.energy = table.number("energy");
  const auto axis = [&](std::string_view key) {
    const std::string name = table.text(key);
    if (name != "long-axis" && name != "short-axis") {
      throw table.error(key, fmt::format("found '{}'; allowed: 'long-axis', 'short-axis'", name));
    }
    return name == "long-axis";
  };
  spin.short_axis_convention = !axis("convention");
  if (table.has("mode")) spin.long_axis_mode = axis("mode");
  table.located("P_psi", [&] { set_tumbling_state(body, spin); });
}

}  // namespace

Body parse_body_file(std::string_view text, const std::string& path, const ContentOf& content_of) {
  const TomlTable root = TomlTable::parse(text, path);
  root.allow_only({"name", "id", "source", "period_uncertainty", "inertia", "state", "spin"});
  Body body;
  body.name = root.text("name");
  body.id = root.optional_text("id").value_or("");
  body.source = root.optional_text("source").value_or("");
  if (root.has("period_uncertainty")) body.period_uncertainty = root.positive_number("period_uncertainty");
  if (root.has("inertia")) body.inertia = read_inertia(root.table("inertia"), body, path, content_of);
  if (root.has("state") && root.has("spin")) throw root.error("spin", "either [state] or [spin], not both");
  if (root.has("state")) body.state = read_state(root.table("state"), body);
  if (root.has("spin")) read_spin(root.table("spin"), body);
  if (body.inertia) root.located(root.has("inertia") ? "inertia" : "spin", [&] { check_range(*body.inertia); });
  if (body.state && body.state->omega_named_rad_s) {
    root.located(root.has("state") ? "state" : "spin", [&] { check_range_of_rate(*body.state->omega_named_rad_s); });
  }
  return body;
}

}  // namespace polhode
