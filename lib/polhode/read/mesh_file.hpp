#pragma once

#include <string>
#include <string_view>

#include "polhode/body/body.hpp"
#include "polhode/body/mesh_inertia.hpp"

namespace polhode {

/// A mesh in Wavefront OBJ, PLY (ascii, binary of either byte order), STL (ascii, binary) or the `shape.txt` of DAMIT
/// (line 1: numbers of vertices and facets; then x y z; then three corners per facet, from 1). The format is found from
/// the content. Facets with more than three corners are cut into triangles from their first corner. Coordinates are
/// kept in the file's own length unit. Throws InputError with file and line, FileError if the file cannot be read.
TriangleMesh read_mesh_file(const std::string& path);

/// Whether the content looks like one of these.
bool is_mesh(std::string_view content);

/// The same from memory; `name` stands for the file in messages.
TriangleMesh read_mesh(std::string_view content, const std::string& name);

/// A shape alone: ratios of inertia at uniform density, no state.
Body body_of_mesh(std::string_view content, const std::string& path);

}  // namespace polhode
