#include "polhode/read/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

/// A text read line by line, with its place for messages.
class Lines {
 public:
  Lines(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  /// The next line's words in `words`; false at the end.
  bool next(std::vector<std::string_view>& words) {
    if (text_.empty()) return false;
    words = split_words(take_line(text_));
    ++line_;
    return true;
  }

  [[noreturn]] void fail(const std::string& message) const { throw InputError({name_, line_}, message); }

  double number(std::string_view word) const {
    const std::optional<double> value = parse_number(word);
    if (!value) fail(fmt::format("'{:.60}' is not a number", word));
    return *value;
  }

  long long integer(std::string_view word) const {
    const std::optional<long long> value = parse_integer(word);
    if (!value) fail(fmt::format("'{:.60}' is not an integer", word));
    return *value;
  }

  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
  const std::string& name_;
  std::size_t line_ = 0;
};

/// Cuts a polygon into triangles from its first corner.
void add_polygon(TriangleMesh& mesh, const std::vector<std::uint32_t>& corners) {
  for (std::size_t k = 2; k < corners.size(); ++k) mesh.facets.push_back({corners[0], corners[k - 1], corners[k]});
}

TriangleMesh read_obj(std::string_view content, const std::string& name) {
  TriangleMesh mesh;
  Lines lines(content, name);
  std::vector<std::string_view> words;
  std::vector<std::uint32_t> corners;
  std::uint32_t surface = 0;
  while (lines.next(words)) {
    if (words.empty()) continue;
    if (words[0] == "v") {
      if (words.size() < 4) lines.fail("a vertex has three coordinates");
      mesh.vertices.emplace_back(lines.number(words[1]), lines.number(words[2]), lines.number(words[3]));
    } else if (words[0] == "f") {
      if (words.size() < 4) lines.fail("a face has at least three corners");
      corners.clear();
      const auto count = static_cast<long long>(mesh.vertices.size());
      for (std::size_t k = 1; k < words.size(); ++k) {
        const long long index = lines.integer(words[k].substr(0, words[k].find('/')));  // v, v/vt, v//vn, v/vt/vn
        const long long from_zero = index < 0 ? count + index : index - 1;
        if (from_zero < 0 || from_zero >= count) {
          lines.fail(fmt::format("corner {} is not one of the {} vertices above", index, count));
        }
        corners.push_back(static_cast<std::uint32_t>(from_zero));
      }
      add_polygon(mesh, corners);
      mesh.surface_of_facet.resize(mesh.facets.size(), surface);
    } else if (words[0] == "usemtl") {
      const std::string name_of_surface(words.size() > 1 ? words[1] : "");
      std::vector<std::string>& names = mesh.surface_names;
      const auto known = std::find(names.begin(), names.end(), name_of_surface);
      surface = static_cast<std::uint32_t>(known - names.begin());
      if (known == names.end()) names.push_back(name_of_surface);
      // Facets before the first name have none.
      if (names.size() == 1 && !mesh.facets.empty()) names.insert(names.begin(), ""), surface = 1;
    }  // everything else (names, normals, comments) says nothing about the solid or its surface
  }
  if (mesh.surface_names.empty()) mesh.surface_of_facet.clear();
  return mesh;
}

TriangleMesh read_shape_txt(std::string_view content, const std::string& name) {
  TriangleMesh mesh;
  Lines lines(content, name);
  std::vector<std::string_view> words;
  const auto row = [&](std::string_view what) {
    do {
      if (!lines.next(words)) lines.fail(fmt::format("the file ends before its last {}", what));
    } while (words.empty());
  };
  row("count");
  const long long vertices = lines.integer(words[0]);
  const long long facets = lines.integer(words[1]);
  if (vertices < 4 || facets < 4) lines.fail("a closed surface has at least 4 vertices and 4 facets");
  for (long long i = 0; i < vertices; ++i) {
    row("vertex");
    if (words.size() != 3) lines.fail(fmt::format("a vertex has three coordinates, found {}", words.size()));
    mesh.vertices.emplace_back(lines.number(words[0]), lines.number(words[1]), lines.number(words[2]));
  }
  for (long long i = 0; i < facets; ++i) {
    row("facet");
    if (words.size() != 3) lines.fail(fmt::format("a facet has three corners, found {}", words.size()));
    std::array<std::uint32_t, 3> facet{};
    for (std::size_t k = 0; k < 3; ++k) {
      const long long corner = lines.integer(words[k]);
      if (corner < 1 || corner > vertices) lines.fail(fmt::format("corner {} is not in 1 to {}", corner, vertices));
      facet[k] = static_cast<std::uint32_t>(corner - 1);
    }
    mesh.facets.push_back(facet);
  }
  return mesh;
}

TriangleMesh read_ascii_stl(std::string_view content, const std::string& name) {
  TriangleMesh mesh;
  Lines lines(content, name);
  std::vector<std::string_view> words;
  while (lines.next(words)) {
    if (words.empty()) continue;
    const std::string key = upper_case(words[0]);
    if (key == "VERTEX") {
      if (words.size() != 4) lines.fail("a vertex has three coordinates");
      mesh.vertices.emplace_back(lines.number(words[1]), lines.number(words[2]), lines.number(words[3]));
    } else if (key == "ENDFACET") {
      const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
      if (n != 3 * (mesh.facets.size() + 1)) lines.fail("a facet of an STL file has three vertices");
      mesh.facets.push_back({n - 3, n - 2, n - 1});
    } else if (key != "SOLID" && key != "FACET" && key != "OUTER" && key != "ENDLOOP" && key != "ENDSOLID") {
      lines.fail(fmt::format("'{:.60}' is not a word of an STL file", words[0]));
    }
  }
  if (mesh.vertices.size() != 3 * mesh.facets.size()) lines.fail("the file ends within a facet");
  return mesh;
}

/// The bytes at `at` as a little-endian (or big-endian) number.
template <typename Number>
Number load(const char* at, bool big_endian = false) {
  std::array<char, sizeof(Number)> bytes{};
  std::memcpy(bytes.data(), at, bytes.size());
  if (big_endian == (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Number>(bytes);
}

constexpr std::size_t stl_header = 84;
constexpr std::size_t stl_facet = 50;

bool is_binary_stl(std::string_view content) {
  return content.size() > stl_header &&
         content.size() == stl_header + stl_facet * std::size_t{load<std::uint32_t>(content.data() + 80)};
}

TriangleMesh read_binary_stl(std::string_view content, const std::string& name) {
  TriangleMesh mesh;
  for (std::size_t at = stl_header; at < content.size(); at += stl_facet) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const char* p = content.data() + at + 12 * (corner + 1);  // the normal comes first
      const Vector3 v(static_cast<double>(load<float>(p)), static_cast<double>(load<float>(p + 4)),
                      static_cast<double>(load<float>(p + 8)));
      if (!v.allFinite())
        throw InputError(fmt::format("{}: facet {}: a coordinate is not finite", name, mesh.facets.size() + 1));
      mesh.vertices.push_back(v);
    }
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.facets.push_back({n - 3, n - 2, n - 1});
  }
  return mesh;
}

/// The scalar types of PLY by both of their names.
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

PlyType ply_type(std::string_view word, const Lines& lines) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> names{{{"char", PlyType::int8},
                                                                        {"int8", PlyType::int8},
                                                                        {"uchar", PlyType::uint8},
                                                                        {"uint8", PlyType::uint8},
                                                                        {"short", PlyType::int16},
                                                                        {"int16", PlyType::int16},
                                                                        {"ushort", PlyType::uint16},
                                                                        {"uint16", PlyType::uint16},
                                                                        {"int", PlyType::int32},
                                                                        {"int32", PlyType::int32},
                                                                        {"uint", PlyType::uint32},
                                                                        {"uint32", PlyType::uint32},
                                                                        {"float", PlyType::float32},
                                                                        {"float32", PlyType::float32},
                                                                        {"double", PlyType::float64},
                                                                        {"float64", PlyType::float64}}};
  for (const auto& [name, type] : names) {
    if (name == word) return type;
  }
  lines.fail(fmt::format("'{:.60}' is not a PLY type (char, uchar, short, ushort, int, uint, float, double)", word));
}

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  bool list = false;
  PlyType count_type = PlyType::uint8;
};

struct PlyElement {
  std::string name;
  long long count = 0;
  std::vector<PlyProperty> properties;
};

/// Numbers of a PLY body, one after another.
class PlyBody {
 public:
  enum class Format { ascii, little_endian, big_endian };

  PlyBody(Format format, std::string_view text, const std::string& name) : format_(format), text_(text), name_(name) {}

  double take(PlyType type) {
    if (format_ == Format::ascii) {
      const std::string_view word = take_word(text_);
      if (word.empty()) fail("the file ends before its last element");
      const std::optional<double> value = parse_number(word);
      if (!value) fail(fmt::format("'{:.60}' is not a number", word));
      return *value;
    }
    switch (type) {
      case PlyType::int8:
        return binary<std::int8_t>();
      case PlyType::uint8:
        return binary<std::uint8_t>();
      case PlyType::int16:
        return binary<std::int16_t>();
      case PlyType::uint16:
        return binary<std::uint16_t>();
      case PlyType::int32:
        return binary<std::int32_t>();
      case PlyType::uint32:
        return binary<std::uint32_t>();
      case PlyType::float32:
        return static_cast<double>(binary<float>());
      case PlyType::float64:
        return binary<double>();
    }
    return 0.0;  // not reached: every type is above
  }

  /// A whole number from 0 to below `limit`.
  std::uint32_t take_index(PlyType type, double limit, std::string_view what) {
    const double value = take(type);
    if (!(value >= 0.0 && value < limit && value == std::floor(value))) {
      fail(fmt::format("{} {} is not a whole number from 0 to {}", what, value, limit - 1.0));
    }
    return static_cast<std::uint32_t>(value);
  }

  void set_element(std::string_view element, long long number) {
    element_ = element;
    number_ = number;
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(fmt::format("{}: {} {}: {}", name_, element_, number_ + 1, message));
  }

 private:
  template <typename Number>
  Number binary() {
    if (text_.size() < sizeof(Number)) fail("the file ends before its last element");
    const Number value = load<Number>(text_.data(), format_ == Format::big_endian);
    text_.remove_prefix(sizeof(Number));
    return value;
  }

  Format format_;
  std::string_view text_;
  const std::string& name_;
  std::string_view element_ = "element";
  long long number_ = 0;
};

TriangleMesh read_ply(std::string_view content, const std::string& name) {
  Lines lines(content, name);
  std::vector<std::string_view> words;
  std::optional<PlyBody::Format> format;
  std::vector<PlyElement> elements;
  bool ended = false;
  while (!ended && lines.next(words)) {
    if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      ended = true;
    } else if (words[0] == "format" && words.size() == 3) {
      if (words[1] == "ascii") {
        format = PlyBody::Format::ascii;
      } else if (words[1] == "binary_little_endian") {
        format = PlyBody::Format::little_endian;
      } else if (words[1] == "binary_big_endian") {
        format = PlyBody::Format::big_endian;
      } else {
        lines.fail(fmt::format("format '{:.60}' is none of ascii, binary_little_endian, binary_big_endian", words[1]));
      }
    } else if (words[0] == "element" && words.size() == 3) {
      elements.push_back({std::string(words[1]), lines.integer(words[2]), {}});
      if (elements.back().count < 0) lines.fail("a count is not negative");
    } else if (words[0] == "property" && words.size() == 3 && !elements.empty()) {
      elements.back().properties.push_back({std::string(words[2]), ply_type(words[1], lines)});
    } else if (words[0] == "property" && words.size() == 5 && words[1] == "list" && !elements.empty()) {
      elements.back().properties.push_back(
          {std::string(words[4]), ply_type(words[3], lines), true, ply_type(words[2], lines)});
    } else {
      lines.fail(fmt::format("'{:.60}' cannot stand here in a PLY header", words[0]));
    }
  }
  if (!ended) lines.fail("the PLY header has no end_header");
  if (!format) lines.fail("the PLY header has no format line");

  TriangleMesh mesh;
  PlyBody body(*format, lines.rest(), name);
  std::vector<std::uint32_t> corners;
  for (const PlyElement& element : elements) {
    if (element.properties.empty() && element.count > 0) {
      throw InputError(fmt::format("{}: element '{:.60}' has no properties", name, element.name));
    }
    const bool is_vertex = element.name == "vertex";
    const bool is_face = element.name == "face";
    std::size_t found = 0;
    for (const PlyProperty& p : element.properties) {
      if (is_vertex && !p.list && (p.name == "x" || p.name == "y" || p.name == "z")) ++found;
      if (is_face && p.list && (p.name == "vertex_indices" || p.name == "vertex_index")) ++found;
    }
    if (is_vertex && found != 3) throw InputError(name + ": element 'vertex' must have the properties x, y and z once");
    if (is_face && found != 1) throw InputError(name + ": element 'face' must have one list 'vertex_indices'");
    for (long long i = 0; i < element.count; ++i) {
      body.set_element(element.name, i);
      Vector3 vertex = Vector3::Zero();
      for (const PlyProperty& p : element.properties) {
        if (!p.list) {
          const double value = body.take(p.type);
          if (is_vertex && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z') {
            if (!std::isfinite(value)) body.fail("a coordinate is not finite");
            vertex[p.name[0] - 'x'] = value;
          }
          continue;
        }
        const std::uint32_t length = body.take_index(p.count_type, 4294967296.0, "list length");
        const bool are_corners = is_face && (p.name == "vertex_indices" || p.name == "vertex_index");
        corners.clear();
        for (std::uint32_t k = 0; k < length; ++k) {
          if (are_corners) {
            corners.push_back(body.take_index(p.type, static_cast<double>(mesh.vertices.size()), "corner"));
          } else {
            body.take(p.type);
          }
        }
        if (are_corners && length < 3) body.fail("a face has at least three corners");
        if (are_corners) add_polygon(mesh, corners);
      }
      if (is_vertex) mesh.vertices.push_back(vertex);
    }
  }
  return mesh;
}

/// Whether the first line that says something is two integers, as in shape.txt.
bool is_shape_txt(std::string_view content) {
  while (!content.empty()) {
    const std::vector<std::string_view> words = split_words(take_line(content).substr(0, 4096));
    if (words.empty()) continue;
    return words.size() == 2 && parse_integer(words[0]).value_or(0) > 0 && parse_integer(words[1]).value_or(0) > 0;
  }
  return false;
}

}  // namespace

bool is_mesh(std::string_view content) {
  if (is_binary_stl(content) || content.starts_with("ply\n") || content.starts_with("ply\r") || is_shape_txt(content))
    return true;
  // STL: the first word; OBJ: a vertex before anything that its lines cannot start with.
  constexpr std::size_t enough = 4096;  // of a line
  for (bool first = true; !content.empty();) {
    const std::vector<std::string_view> words = split_words(take_line(content).substr(0, enough));
    if (words.empty() || words[0].starts_with('#')) continue;
    if (first && upper_case(words[0]) == "SOLID") return true;
    first = false;
    if (words[0] == "v" && words.size() >= 4) return true;
    constexpr std::array<std::string_view, 7> other{"mtllib", "o", "g", "s", "usemtl", "vn", "vt"};
    if (std::find(other.begin(), other.end(), words[0]) == other.end()) return false;
  }
  return false;
}

TriangleMesh read_mesh(std::string_view content, const std::string& name) {
  if (is_binary_stl(content)) return read_binary_stl(content, name);
  if (content.starts_with("ply")) return read_ply(content, name);
  if (is_shape_txt(content)) return read_shape_txt(content, name);
  std::string_view rest = content;
  const std::vector<std::string_view> words = split_words(take_line(rest));
  if (!words.empty() && upper_case(words[0]) == "SOLID") return read_ascii_stl(content, name);
  TriangleMesh mesh = read_obj(content, name);
  if (mesh.facets.empty()) {
    throw InputError(name + ": no facets found; known meshes are OBJ, PLY, STL and DAMIT's shape.txt");
  }
  return mesh;
}

Body body_of_mesh(std::string_view content, const std::string& path) {
  Body body;
  body.name = std::filesystem::path(path).stem().string();
  body.source = "shape model, uniform density";
  const TriangleMesh mesh = read_mesh(content, path);
  located({path, 0}, [&] {
    const MassProperties solid = mass_properties(mesh);
    body.inertia = inertia_from_tensor(Matrix3(solid.inertia_about_centre / solid.volume), false);
    body.notes.push_back(describe(solid));
  });
  body.missing = {"an attitude", "an angular velocity"};
  return body;
}

TriangleMesh read_mesh_file(const std::string& path) { return read_mesh(read_text_file(path), path); }

}  // namespace polhode
