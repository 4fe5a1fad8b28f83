#pragma once

#include <optional>
#include <string>
#include <vector>

#include "polhode/body/body.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// A body, what acts on it, over which span and how well it is wanted (tools/manual/scenes.md).
struct Scene {
  std::string name;
  std::string source;
  Body body;
  Frame frame = Frame::icrf;                 ///< inertial; of the directions of orbits and torques, and of the result
  Torques torques;                           ///< in the principal axes; seconds from the body's epoch
  std::vector<std::string> torque_names;     ///< of each, its orbit's name included: "gravity gradient, earth"
  double first_s = 0.0, last_s = 0.0;        ///< from the body's epoch
  double accuracy_rad = 0.0;                 ///< wanted of the attitude
  std::optional<double> period_uncertainty;  ///< as a part of the period
};

/// Whether the content, TOML with a line `accuracy = …` before its first table, is a scene and not a body.
bool is_scene_file(const std::string& path);

/// Throws InputError with file and line, FileError if the file or one that it names cannot be read.
Scene read_scene(const std::string& path);

}  // namespace polhode
