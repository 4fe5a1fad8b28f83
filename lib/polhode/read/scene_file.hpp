#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "polhode/body/body.hpp"
#include "polhode/body/uncertainty.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// The numbers of a scene's orbits, surfaces and torques that are not exact.
struct UncertainTorques {
  std::vector<PublishedNumber> numbers;  ///< "torque.2.quality_factor", "orbit.earth.mu_m3_s2"; they change no body
  Eigen::MatrixXd covariance;            ///< of the values, in their units
  std::vector<bool> acts_on;             ///< which of the scene's torques have any of them
  /// The torques with these values in the place of the scene's; an orbit's normal is taken at a right angle to its
  /// direction to periapsis. Throws InputError where there are none.
  std::function<Torques(const Eigen::VectorXd& values)> torques_with;
};

/// A body, what acts on it, over which span and how well it is wanted (tools/manual/scenes.md).
struct Scene {
  std::string name;
  std::string source;
  Body body;
  Frame frame = Frame::icrf;              ///< inertial; of the directions of orbits and torques, and of the result
  Torques torques;                        ///< in the axes that the body's file names; seconds from its epoch
  std::vector<std::string> torque_names;  ///< of each, its orbit's name included: "gravity gradient, earth"
  std::shared_ptr<const UncertainTorques> uncertain;  ///< null: all that acts is known exactly
  double first_s = 0.0, last_s = 0.0;                 ///< from the body's epoch
  double accuracy_rad = 0.0;                          ///< wanted of the attitude
};

/// Whether the content, TOML with a line `accuracy = …` before its first table, is a scene and not a body.
bool is_scene(std::string_view text);

/// Throws InputError with file and line, FileError if the file or one that it names cannot be read.
Scene read_scene(const std::string& path);

/// The scene that a file holds, or else its body; the file is read once, it may be a pipe.
std::variant<Scene, BodyAndHistory> read_scene_or_body(const std::string& path,
                                                       const ContentOf& content_of = read_text_file);

/// The same from memory. `path` is for messages, and where the files that it names are looked for; `content_of` opens
/// these.
Scene parse_scene(std::string_view content, const std::string& path, const ContentOf& content_of);

}  // namespace polhode
