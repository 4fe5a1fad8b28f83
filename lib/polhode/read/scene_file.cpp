#include "polhode/read/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/read/torque_table.hpp"
#include "polhode/read/trajectory_file.hpp"
#include "polhode/read/uncertain_numbers.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

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

/// Whether numbers are those of the file, or of a clone.
enum class NumbersAre { published, drawn };

OrbitAboutMass read_orbit(const TomlTable& table, const std::string& name, const Scene& scene,
                          const std::filesystem::path& folder, const ContentOf& content_of, NumbersAre numbers) {
  const double mu_m3_s2 = table.number("mu_m3_s2");
  if (!(mu_m3_s2 > 0.0)) throw table.error("mu_m3_s2", fmt::format("found {}, a positive number is wanted", mu_m3_s2));
  if (table.has("trajectory")) return {mu_m3_s2, read_trajectory_of(table, name, scene, folder, content_of)};
  table.allow_only({"mu_m3_s2", "periapsis_m", "eccentricity", "periapsis_after_epoch_s", "to_periapsis", "normal"});
  KeplerElements elements{mu_m3_s2,
                          table.number("periapsis_m"),
                          table.number("eccentricity"),
                          table.number("periapsis_after_epoch_s"),
                          table.vector3("to_periapsis"),
                          table.vector3("normal")};
  if (numbers == NumbersAre::drawn) {  // each component by itself, and so at no right angle
    const Vector3 along = elements.to_periapsis.stableNormalized();
    elements.along_normal -= elements.along_normal.dot(along) * along;
  }
  if (const auto fault = fault_of(elements)) throw table.error(key_of(fault->element), fault->message);
  return {mu_m3_s2, table.located("periapsis_m", [&] { return Trajectory(elements); })};  // refuses what is no orbit
}

/// Of the tables [orbit.NAME]: how the body moves about the mass of that name.
OrbitsByName read_orbits(const TomlTable& root, const Scene& scene, const std::filesystem::path& folder,
                         const ContentOf& content_of, NumbersAre numbers) {
  OrbitsByName orbits;
  if (!root.has("orbit")) return orbits;
  const TomlTable tables = root.table("orbit");
  for (const std::string& name : tables.keys()) {
    orbits.emplace(name, read_orbit(tables.table(name), name, scene, folder, content_of, numbers));
  }
  return orbits;
}

SurfacesByName read_surfaces(const TomlTable& root) {
  SurfacesByName surfaces;
  if (!root.has("surface")) return surfaces;
  const TomlTable tables = root.table("surface");
  for (const std::string& name : tables.keys()) {
    const TomlTable table = tables.table(name);
    check_surface(table);
    surfaces.emplace(name, table);
  }
  return surfaces;
}

Torques read_torques(const TomlTable& root, const Scene& scene, const std::filesystem::path& folder,
                     const ContentOf& content_of, NumbersAre numbers) {
  const OrbitsByName orbits = read_orbits(root, scene, folder, content_of, numbers);
  const SurfacesByName surfaces = read_surfaces(root);
  const TorqueSurroundings surroundings{scene.body, orbits, surfaces, folder, content_of};
  std::vector<Torque> torques;
  for (const TomlTable& table : root.tables("torque")) torques.push_back(read_torque(table, surroundings));
  return Torques(std::move(torques));
}

/// Whether a number is one of torque `place`, from 0, of its orbits or of a surface of its mesh.
bool acts_on(const TomlTable::NumberWithSigma& number, const TomlTable& torque, std::size_t place) {
  if (number.section == "torque") return number.table == fmt::format("{}", place + 1);
  if (number.section == "surface") return torque.has("mesh");
  return std::ranges::any_of(std::array{"orbit", "shadow_orbit"},
                             [&](const char* key) { return torque.has(key) && torque.text(key) == number.table; });
}

std::shared_ptr<const UncertainTorques> uncertain_torques(const TomlTable& root,
                                                          std::vector<TomlTable::NumberWithSigma> numbers,
                                                          const Scene& scene, const std::filesystem::path& folder,
                                                          std::map<std::string, std::string, std::less<>> files) {
  UncertainTorques out;
  std::vector<double> sigmas;
  for (const TomlTable::NumberWithSigma& number : numbers) {
    out.numbers.push_back({number.name(), number.value, {}});
    sigmas.push_back(number.sigma);
  }
  out.covariance = covariance_in_file(root, out.numbers, sigmas, "number of the scene with its _sigma beside it");
  if (numbers.empty()) return nullptr;
  for (const TomlTable& torque : root.tables("torque")) {
    out.acts_on.push_back(std::ranges::any_of(
        numbers, [&, place = out.acts_on.size()](const auto& number) { return acts_on(number, torque, place); }));
  }
  out.torques_with = [root, numbers = std::move(numbers), scene, folder,
                      files = std::move(files)](const Eigen::VectorXd& values) {
    std::vector<TomlTable::NumberWithSigma> changed = numbers;
    for (std::size_t i = 0; i < changed.size(); ++i) changed[i].value = values[static_cast<Eigen::Index>(i)];
    return read_torques(
        root.with_values(changed), scene, folder, [&files](const std::string& file) { return files.at(file); },
        NumbersAre::drawn);
  };
  return std::make_shared<const UncertainTorques>(std::move(out));
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

std::variant<Scene, BodyAndHistory> read_scene_or_body(const std::string& path, const ContentOf& content_of) {
  const RowOfFile place(path);
  const std::string text = content_of(place.file);
  if (is_scene(text)) return parse_scene(text, place.file, content_of);
  return parse_body_and_history(text, place, content_of);
}

Scene parse_scene(std::string_view content, const std::string& path, const ContentOf& content_of) {
  constexpr const char* no_scene =
      "is no scene, but a body or an attitude history: `polhode info` says what it holds; a scene names it, body = "
      "\"…\"";
  if (const InputFormat* format = input_format_of(content); format != nullptr && !format->histories.empty())
    throw InputError({path, 0}, no_scene);
  std::vector<TomlTable::NumberWithSigma> uncertain;
  const TomlTable root = TomlTable::parse_with_sigmas(content, path, {"orbit", "surface", "torque"}, uncertain);
  if (root.has("inertia") || root.has("state") || root.has("spin")) throw InputError({path, 0}, no_scene);
  root.allow_only({"name", "source", "body", "frame", "before", "after", "accuracy", "period_uncertainty", "orbit",
                   "surface", "torque", "uncertainty"});
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
  scene.frame = root.parsed("frame", inertial_frame);
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
    if (!(span.high >= 0.0)) throw root.error(key, fmt::format("found '{:.60}', a span of 0 or more is wanted", text));
    return span.high + span.low;
  };
  scene.first_s = 0.0 - duration_s("before");  // not -0
  scene.last_s = duration_s("after");
  if (scene.first_s == scene.last_s)
    throw root.error("after", "the span is empty; 'before' or 'after' says how long it is");
  const std::string accuracy = quantity("accuracy", "0.1 deg");
  scene.accuracy_rad = root.located("accuracy", [&] { return parse_tolerance_rad(accuracy); });
  if (root.has("period_uncertainty")) {
    root.located("period_uncertainty",
                 [&] { set_period_uncertainty(scene.body, root.positive_number("period_uncertainty")); });
  }
  std::map<std::string, std::string, std::less<>> files;  // which a clone's torques are read from once more
  const auto kept_content_of = [&](const std::string& file) {
    std::string text = content_of(file);
    if (!uncertain.empty()) files.insert_or_assign(file, text);
    return text;
  };
  scene.torques = read_torques(root, scene, folder, kept_content_of, NumbersAre::published);
  for (const TomlTable& table : root.tables("torque")) {
    std::string name(torque_name(scene.torques.list()[scene.torque_names.size()]));
    if (table.has("orbit")) name += ", " + table.text("orbit");
    scene.torque_names.push_back(std::move(name));
  }
  scene.uncertain = uncertain_torques(root, std::move(uncertain), scene, folder, std::move(files));
  return scene;
}

}  // namespace polhode
