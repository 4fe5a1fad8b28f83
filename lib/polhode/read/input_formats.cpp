#include "polhode/read/input_formats.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "polhode/base/error.hpp"
#include "polhode/read/asteroid_files.hpp"
#include "polhode/read/attitude_history_file.hpp"
#include "polhode/read/body_file.hpp"
#include "polhode/read/ccsds_attitude.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/scene_file.hpp"

namespace polhode {
namespace {

template <Body (*parse)(std::string_view text, const std::string& path)>
BodyAndHistory body_alone(const std::string& text, const RowOfFile& place, const ContentOf&) {
  return {parse(text, place.file), {}};
}

BodyAndHistory read_damit_table(const std::string& text, const RowOfFile& place, const ContentOf&) {
  return {parse_damit_table(text, place.file, place.row), {}};
}

BodyAndHistory refuse_scene(const std::string&, const RowOfFile& place, const ContentOf&) {
  throw InputError({place.file, 0},
                   "is a scene, not a body: `polhode plan` says what it holds, and `polhode info` reads its body");
}

BodyAndHistory read_body_file(const std::string& text, const RowOfFile& place, const ContentOf& content_of) {
  return {parse_body_file(text, place.file, content_of), {}};
}

bool has_equal_sign(std::string_view text) { return text.find('=') != std::string_view::npos; }

constexpr auto formats = std::to_array<InputFormat>({
    {"CCSDS messages (KVN, XML)", "AEM, ACM", "samples/ccsds", is_ccsds, read_ccsds_attitude},
    {"tables of attitudes (FITS, CSV, ECSV)", "FITS, CSV, ECSV", "samples/attitude", is_attitude_table,
     read_attitude_table},
    {"DAMIT's tables (CSV, FILE#ID)", "", "samples/asteroid", is_damit_table, read_damit_table},
    {"DAMIT's spin.txt", "", "samples/asteroid", is_damit_spin, body_alone<parse_damit_spin>},
    {"SHAPE models", "", "samples/asteroid", is_shape_model, body_alone<parse_shape_model>},
    {"meshes (OBJ, PLY, STL, DAMIT's shape.txt)", "", "samples/mesh", is_mesh, body_alone<body_of_mesh>},
    {"scenes (TOML)", "", "scenes", is_scene, refuse_scene},
    {"body files (TOML)", "", "bodies", has_equal_sign, read_body_file},
});

std::string joined(std::string_view InputFormat::*text) {
  std::string all;
  for (const InputFormat& format : formats) {
    if (!(format.*text).empty()) all.append(all.empty() ? "" : ", ").append(format.*text);
  }
  return all;
}

}  // namespace

RowOfFile::RowOfFile(const std::string& path) {
  const std::size_t mark = std::filesystem::exists(path) ? std::string::npos : path.rfind('#');
  file = path.substr(0, mark);
  if (mark != std::string::npos) row = path.substr(mark + 1);
}

std::span<const InputFormat> input_formats() { return formats; }

const InputFormat* input_format_of(std::string_view text) {
  const auto* const found =
      std::find_if(formats.begin(), formats.end(), [&](const InputFormat& format) { return format.recognises(text); });
  return found == formats.end() ? nullptr : found;
}

std::string names_of_input_formats() { return joined(&InputFormat::name); }

std::string names_of_histories() { return joined(&InputFormat::histories); }

}  // namespace polhode
