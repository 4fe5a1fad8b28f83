#include "polhode/read/scene_file.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <map>

#include "polhode/base/error.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/read/attitude_history_file.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/text.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/read/trajectory_file.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

/// [orbit.NAME]: how the body moves about the mass of that name.
struct Orbit {
  double mu_m3_s2;
  Trajectory trajectory;
};
using Orbits = std::map<std::string, Orbit, std::less<>>;

Trajectory read_trajectory_of(const TomlTable& table, const std::string& name, const Scene& scene,
                              const std::filesystem::path& folder, const ContentOf& content_of) {
  table.allow_only({"mu_m3_s2", "trajectory", "trajectory_frame"});
  TrajectoryRequest request;
  request.centre = name;
  request.frame = scene.frame;
  if (const auto frame_name = table.optional_text("trajectory_frame")) {
    request.table_frame = table.located("trajectory_frame", [&] { return frame(*frame_name); });
  }
  request.zero = scene.body.state->epoch;
  const std::string path = (folder / table.file_name("trajectory")).string();
  TabulatedOrbit orbit = parse_trajectory(table.opened("trajectory", [&] { return content_of(path); }), path, request);
  if (!(orbit.first_s() <= scene.first_s && scene.last_s <= orbit.last_s())) {
    const auto date = [&](double t_s) { return format_date(request.zero + Seconds{t_s, 0.0}, TimeScale::tdb, 0); };
    throw table.error("trajectory",
                      fmt::format("it covers {} to {} TDB, the scene lasts from {} to {}", date(orbit.first_s()),
                                  date(orbit.last_s()), date(scene.first_s), date(scene.last_s)));
  }
  return Trajectory(std::move(orbit));
}

std::string_view key_of(KeplerFault::Element element) {
  switch (element) {
    case KeplerFault::Element::mu:
      return "mu_m3_s2";
    case KeplerFault::Element::periapsis:
      return "periapsis_m";
    case KeplerFault::Element::eccentricity:
      return "eccentricity";
    case KeplerFault::Element::periapsis_time:
      return "periapsis_after_epoch_s";
    case KeplerFault::Element::to_periapsis:
      return "to_periapsis";
    case KeplerFault::Element::along_normal:
      break;
  }
  return "normal";
}

Orbit read_orbit(const TomlTable& table, const std::string& name, const Scene& scene,
                 const std::filesystem::path& folder, const ContentOf& content_of) {
  const double mu_m3_s2 = table.number("mu_m3_s2");
  if (!(mu_m3_s2 > 0.0)) throw table.error("mu_m3_s2", fmt::format("found {}, a positive number is wanted", mu_m3_s2));
  if (table.has("trajectory")) return {mu_m3_s2, read_trajectory_of(table, name, scene, folder, content_of)};
  table.allow_only({"mu_m3_s2", "periapsis_m", "eccentricity", "periapsis_after_epoch_s", "to_periapsis", "normal"});
  const KeplerElements elements{mu_m3_s2,
                                table.number("periapsis_m"),
                                table.number("eccentricity"),
                                table.number("periapsis_after_epoch_s"),
                                table.vector3("to_periapsis"),
                                table.vector3("normal")};
  if (const auto fault = fault_of(elements)) throw table.error(key_of(fault->element), fault->message);
  return {mu_m3_s2, table.located("periapsis_m", [&] { return Trajectory(elements); })};  // refuses what is no orbit
}

Orbits read_orbits(const TomlTable& root, const Scene& scene, const std::filesystem::path& folder,
                   const ContentOf& content_of) {
  Orbits orbits;
  if (!root.has("orbit")) return orbits;
  const TomlTable tables = root.table("orbit");
  for (const std::string& name : tables.keys()) {
    orbits.emplace(name, read_orbit(tables.table(name), name, scene, folder, content_of));
  }
  return orbits;
}

/// The orbit that a torque names.
const Orbit& orbit_of(const TomlTable& torque, const Orbits& orbits) {
  const std::string name = torque.text("orbit");
  const auto found = orbits.find(name);
  if (found == orbits.end()) {
    throw torque.error("orbit", fmt::format("found '{:.40}', but the scene has no table [orbit.{:.40}]", name, name));
  }
  return found->second;
}

/// Torques in N m mean nothing to a body whose moments are ratios.
void need_absolute(const TomlTable& table, const Inertia& inertia) {
  if (!inertia.absolute) {
    throw table.error("kind", fmt::format("a torque of kind '{}' needs moments in kg m2, the body has ratios only",
                                          table.text("kind")));
  }
}

/// Where the body's centre of mass is in the axes of the mesh, by what the scene says: the light's torque is about it,
/// and a mesh alone does not know.
Vector3 centre_of_mass(const TomlTable& table, const TriangleMesh& mesh) {
  constexpr std::string_view choices =
      "'mesh origin' (the mesh's coordinates count from the centre of mass) or 'mesh centroid' (the mesh is moved to "
      "where the centre of mass of a solid of one density is)";
  if (!table.has("centre_of_mass")) {
    throw table.error("centre_of_mass", fmt::format("this key is missing; it says {}", choices));
  }
  const std::string choice = table.text("centre_of_mass");
  const MassProperties solid = mass_properties(mesh);  // refuses a mesh that is open or inside out
  if (choice == "mesh origin") return Vector3::Zero();
  if (choice == "mesh centroid") return solid.centre_of_mass;
  throw table.error("centre_of_mass", fmt::format("found '{:.40}'; allowed: {}", choice, choices));
}

Torque read_torque(const TomlTable& table, const Body& body, const Orbits& orbits, const std::filesystem::path& folder,
                   const ContentOf& content_of) {
  const Inertia& inertia = *body.inertia;
  const std::string kind = table.text("kind");
  if (kind == "gravity gradient") {
    table.allow_only({"kind", "orbit"});
    const Orbit& orbit = orbit_of(table, orbits);
    return GravityGradient(orbit.mu_m3_s2, orbit.trajectory);
  }
  if (kind == "constant") {
    table.allow_only({"kind", "torque_n_m", "axes"});
    need_absolute(table, inertia);
    const std::string axes = table.text("axes");
    if (axes == "frame") return ConstantTorque{table.vector3("torque_n_m"), ConstantTorque::Axes::inertial};
    if (axes != "body") throw table.error("axes", fmt::format("found '{}'; allowed: 'body' or 'frame'", axes));
    return ConstantTorque{table.vector3("torque_n_m"), ConstantTorque::Axes::body};
  }
  if (kind == "thruster pulse") {
    table.allow_only({"kind", "torque_n_m", "start_s", "duration_s"});
    need_absolute(table, inertia);
    const double duration_s = table.number("duration_s");
    if (!(duration_s > 0.0))
      throw table.error("duration_s", fmt::format("found {}, a positive number is wanted", duration_s));
    return ThrusterPulse{table.number("start_s"), duration_s, table.vector3("torque_n_m")};
  }
  if (kind == "linear damping") {
    table.allow_only({"kind", "coefficient_n_m_s"});
    need_absolute(table, inertia);
    return LinearDamping{Vector3::Constant(table.number("coefficient_n_m_s"))};
  }
  if (kind == "eddy currents") {
    table.allow_only({"kind", "magnetic_tensor_s_m4", "dipole_t_m3", "dipole_axis", "orbit"});
    need_absolute(table, inertia);
    const Vector3 axis = table.vector3("dipole_axis");
    if (!(axis.norm() > 0.0)) throw table.error("dipole_axis", "found the zero vector, a direction is wanted");
    return EddyCurrents{table.matrix3("magnetic_tensor_s_m4"), axis.normalized(), table.number("dipole_t_m3"),
                        orbit_of(table, orbits).trajectory};
  }
  if (kind == "internal dissipation") {
    table.allow_only({"kind", "quality_factor"});
    const double quality = table.number("quality_factor");
    const Vector3& I = inertia.principal_moments;
    if (!(quality > 0.0))
      throw table.error("quality_factor", fmt::format("found {}, a positive number is wanted", quality));
    if (!(I[0] < I[2])) throw table.error("kind", "a sphere has no energy to lose at constant momentum");
    const double momentum = momentum_principal(body).norm();
    if (!(momentum > 0.0)) throw table.error("kind", "a body at rest has no energy to lose");
    return InternalDissipation::from_quality_factor(quality, I, momentum);
  }
  if (kind == "sunlight") {
    table.allow_only({"kind", "mesh", "unit_m", "centre_of_mass", "specular", "diffuse", "orbit"});
    need_absolute(table, inertia);
    const std::string path = (folder / table.file_name("mesh")).string();
    TriangleMesh mesh = read_mesh(table.opened("mesh", [&] { return content_of(path); }), path);
    const double unit_m = table.number("unit_m");
    if (!(unit_m > 0.0)) throw table.error("unit_m", fmt::format("found {}, a positive number is wanted", unit_m));
    const Vector3 centre = centre_of_mass(table, mesh);
    for (Vector3& vertex : mesh.vertices) vertex = unit_m * (vertex - centre);
    const double specular = table.number("specular"), diffuse = table.number("diffuse");
    const Orbit& orbit = orbit_of(table, orbits);
    return table.located("specular", [&] { return Sunlight(mesh, {specular, diffuse}, orbit.trajectory); });
  }
  throw table.error("kind",
                    fmt::format("found '{:.40}'; allowed: gravity gradient, constant, thruster pulse, linear damping, "
                                "eddy currents, internal dissipation, sunlight",
                                kind));
}

}  // namespace

bool is_scene(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = trimmed(take_line(text));
    if (line.starts_with('[')) return false;
    if (line.starts_with("accuracy")) return trimmed(line.substr(8)).starts_with('=');
  }
  return false;
}

Scene read_scene(const std::string& path) { return parse_scene(read_text_file(path), path, read_text_file); }

std::variant<Scene, BodyAndHistory> read_scene_or_body(const std::string& path) {
  const RowOfFile place(path);
  const std::string text = read_text_file(place.file);
  if (is_scene(text)) return parse_scene(text, place.file, read_text_file);
  return parse_body_and_history(text, place, read_text_file);
}

Scene parse_scene(std::string_view content, const std::string& path, const ContentOf& content_of) {
  const std::string whole(content);
  constexpr const char* no_scene =
      "is no scene, but a body or an attitude history: `polhode info` says what it holds; a scene names it, body = "
      "\"…\"";
  if (is_ccsds(whole) || is_attitude_table(whole)) throw InputError({path, 0}, no_scene);
  const TomlTable root = TomlTable::parse(content, path);
  if (root.has("inertia") || root.has("state") || root.has("spin")) throw InputError({path, 0}, no_scene);
  root.allow_only(
      {"name", "source", "body", "frame", "before", "after", "accuracy", "period_uncertainty", "orbit", "torque"});
  Scene scene;
  scene.name = root.text("name");
  scene.source = root.text("source");
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const std::string body_path = (folder / root.file_name("body")).string();
  scene.body = root.opened("body", [&] { return read_body(body_path, content_of); });
  if (!scene.body.inertia || !scene.body.state || !scene.body.state->omega_named_rad_s ||
      !scene.body.state->q_frame_from_named) {
    throw root.error(
        "body", fmt::format("{} has no inertia, or no attitude and rate at an epoch; a scene needs them", body_path));
  }
  const std::string frame_name = root.text("frame");
  scene.frame = root.located("frame", [&] { return inertial_frame(frame_name); });
  // "30 d": a bare number would be seconds or radians, which its writer need not have meant.
  const auto quantity = [&](std::string_view key, std::string_view example) {
    const auto wanted = [&](const std::string& found) {
      return root.error(key, fmt::format("found {}, a number with its unit is wanted, in quotes, as {} = \"{}\"", found,
                                         key, example));
    };
    if (root.has(key) && root.is_number(key)) throw wanted("a number");
    std::string text = root.text(key);
    if (const auto bare = parse_number(trimmed(text)); bare && *bare != 0.0) {
      throw wanted(fmt::format("'{:.40}' without a unit", text));
    }
    return text;
  };
  const auto duration_s = [&](std::string_view key) {
    if (!root.has(key)) return 0.0;
    const std::string text = quantity(key, "30 d");
    const Seconds span = root.located(key, [&] { return parse_duration(text); });
    if (!(span.high >= 0.0)) throw root.error(key, fmt::format("found '{}', a span of 0 or more is wanted", text));
    return span.high + span.low;
  };
  scene.first_s = 0.0 - duration_s("before");  // not -0
  scene.last_s = duration_s("after");
  if (scene.first_s == scene.last_s)
    throw root.error("after", "the span is empty; 'before' or 'after' says how long it is");
  const std::string accuracy = quantity("accuracy", "0.1 deg");
  scene.accuracy_rad = root.located("accuracy", [&] { return parse_tolerance_rad(accuracy); });
  if (root.has("period_uncertainty")) scene.body.period_uncertainty = root.positive_number("period_uncertainty");
  const Orbits orbits = read_orbits(root, scene, folder, content_of);
  std::vector<Torque> torques;
  for (const TomlTable& table : root.tables("torque")) {
    const Torque torque = read_torque(table, scene.body, orbits, folder, content_of);
    table.located("kind", [&] { return Torques({torque}); });  // refuses what the torque's description excludes
    torques.push_back(torque);
    std::string name(torque_name(torques.back()));
    if (table.has("orbit")) name += ", " + table.text("orbit");
    scene.torque_names.push_back(std::move(name));
  }
  scene.torques = Torques(std::move(torques));
  return scene;
}

}  // namespace polhode
