#include "polhode/read/body.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "polhode/base/error.hpp"
#include "polhode/read/asteroid_files.hpp"
#include "polhode/read/attitude_history_file.hpp"
#include "polhode/read/body_file.hpp"
#include "polhode/read/ccsds_attitude.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/range.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

/// Of several messages the one that lacks least, the first of them.
BodyAndHistory of_messages(const std::string& text, const std::string& path) {
  std::vector<CcsdsAttitudeMessage> messages = parse_ccsds_attitude(text, path);
  std::optional<AttitudeHistory> history = take_history(messages, path);
  std::size_t best = 0;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    if (messages[i].body.missing.size() < messages[best].body.missing.size()) best = i;
  }
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (i == best) continue;
    messages[best].body.notes.push_back(fmt::format("the file also holds an {} {} of {}", messages[i].kind,
                                                    messages[i].version, messages[i].body.name));
  }
  return {std::move(messages[best].body), std::move(history)};
}

/// A table of attitudes: its first row is a state.
BodyAndHistory of_table(const std::string& text, const std::string& path) {
  AttitudeHistory history = parse_attitude_history(text, path).value();
  const AttitudeSegment& segment = history.segments.front();
  const AttitudeSample& row = segment.samples.front();
  Body body;
  body.name = history.object.empty() ? path : history.object;
  body.id = history.object_id;
  body.source = history.source;
  body.warnings = history.warnings;
  if (segment.known_frame) {
    body.state = SpinState{row.time, history.scale, *segment.known_frame, row.q_frame_from_body, row.omega_body_rad_s};
  } else {
    body.missing.push_back("an attitude in an inertial frame (" + segment.frame + " is given)");
  }
  if (!row.omega_body_rad_s) body.missing.emplace_back("an angular velocity");
  body.inertia = history.inertia;
  if (!body.inertia) body.missing.emplace_back("an inertia");
  return {std::move(body), std::move(history), true};
}

/// A shape alone: ratios of inertia at uniform density, no state.
Body body_of_mesh(const std::string& text, const std::string& path) {
  Body body;
  body.name = std::filesystem::path(path).stem().string();
  body.source = "shape model, uniform density";
  const TriangleMesh mesh = read_mesh(text, path);
  MassProperties solid;
  try {
    solid = mass_properties(mesh);
    body.inertia = inertia_from_tensor(Matrix3(solid.inertia_about_centre / solid.volume), false);
  } catch (const InputError& error) {
    throw InputError({path, 0}, error.what());
  }
  body.notes.push_back(describe(solid));
  body.missing = {"an attitude", "an angular velocity"};
  return body;
}

BodyAndHistory parse_any(const std::string& text, const RowOfFile& place, const ContentOf& content_of) {
  const std::string& file = place.file;
  if (is_ccsds(text)) return of_messages(text, file);
  if (is_attitude_table(text)) return of_table(text, file);
  if (is_damit_table(text)) return {parse_damit_table(text, file, place.row), {}};
  if (is_damit_spin(text)) return {parse_damit_spin(text, file), {}};
  if (is_shape_model(text)) return {parse_shape_model(text, file), {}};
  if (is_mesh(text)) return {body_of_mesh(text, file), {}};
  if (text.starts_with("{\"")) {
    throw InputError(
        {file, 0},
        "looks like JSON lines, which are written but not read; tables of attitudes are read from FITS, CSV "
        "and ECSV, and from CCSDS messages (KVN, XML)");
  }
  if (text.find('=') == std::string::npos) {
    throw InputError({file, 0},
                     "no kind of file that is known: body files (TOML), CCSDS messages (KVN, XML), tables of attitudes "
                     "(FITS, CSV, ECSV), DAMIT's spin.txt, shape.txt and tables, SHAPE models, meshes (OBJ, PLY, STL)");
  }
  if (is_scene(text)) {
    throw InputError({file, 0},
                     "is a scene, not a body: `polhode plan` says what it holds, and `polhode info` reads its body");
  }
  return {parse_body_file(text, file, content_of), {}};
}

}  // namespace

Body read_body(const std::string& path, const ContentOf& content_of) {
  return read_body_and_history(path, content_of).body;
}

BodyAndHistory read_body_and_history(const std::string& path, const ContentOf& content_of) {
  const RowOfFile place(path);
  return parse_body_and_history(content_of(place.file), place, content_of);
}

RowOfFile::RowOfFile(const std::string& path) {
  const std::size_t mark = std::filesystem::exists(path) ? std::string::npos : path.rfind('#');
  file = path.substr(0, mark);
  if (mark != std::string::npos) row = path.substr(mark + 1);
}

BodyAndHistory parse_body_and_history(const std::string& text, const RowOfFile& place, const ContentOf& content_of) {
  BodyAndHistory found = parse_any(text, place, content_of);
  try {
    check_range(found.body);
  } catch (const InputError& problem) {
    throw InputError({place.file, 0}, problem.what());
  }
  return found;
}

}  // namespace polhode
