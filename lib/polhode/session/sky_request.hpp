#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "polhode/observe/observation.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/trajectory_file.hpp"
#include "polhode/session/body_in_motion.hpp"

namespace polhode {

/// Who looks at what, as the program and the Python package are told it.
struct SkyRequest {
  Place target, observer = TheGeocentre{}, sun = TheSun{};
};

/// The motion as observe() wants it.
ObservedMotion observed_motion(const BodyInMotion& moving);

/// The place that a text names: "geocentre" (or "geocenter"), "sun", or a file of a trajectory as
/// read_centred_trajectory() takes it. `request.centre` is that of a file which names none.
Place named_place(const std::string& text, const TrajectoryRequest& request,
                  const ContentOf& content_of = read_text_file);

/// "LONGITUDE LATITUDE HEIGHT" of a place on the Earth in deg, deg and m, between blanks or commas; throws InputError.
Site parse_site(const std::string& text, const EarthOrientation& earth);

/// The shape that a text names: "A B C unit", an ellipsoid with these semi-axes along the body's x, y, z, or a file of
/// a mesh, whose unit of length must be given, and whose `surfaces` may shine otherwise than the rest. Throws
/// InputError, FileError.
std::shared_ptr<const Shape> named_shape(const std::string& text, const std::string& mesh_unit,
                                         const std::map<std::string, SurfaceShine, std::less<>>& surfaces = {},
                                         const ContentOf& content_of = read_text_file);

/// (diffuse, specular) or (diffuse, specular, sides), 1 or 2 sides. Throws InputError.
SurfaceShine surface_shine(std::span<const double> numbers);

/// "NAME=DIFFUSE,SPECULAR" or "NAME=DIFFUSE,SPECULAR,SIDES" of a surface of a mesh, parts from 0 to 1. Throws
/// InputError.
std::pair<std::string, SurfaceShine> parse_surface(const std::string& text);

/// The same, or the astrometric direction from the geocentre and the distance of the target at each instant.
struct KnownDirection {
  double right_ascension_rad, declination_rad, range_m;
};
using Sky = std::variant<SkyRequest, std::vector<KnownDirection>>;

/// What is seen at these instants. Throws InputError where a scene's motion does not hold them, and for another number
/// of directions than of instants, besides what observe() throws.
std::vector<ObservedColumn> observe(const BodyInMotion& moving, const Sky& sky, std::span<const Instant> receptions,
                                    const ObservationOptions& options);

/// The derivatives of what is seen by the parameters of `states_by`, and by the shape's scale: see observe_partials().
std::vector<ObservedColumn> observe_partials(const BodyInMotion& moving, const Sky& sky,
                                             std::span<const Instant> receptions, const ObservationOptions& options,
                                             const StatePartialsSource& states_by);

/// One sigma of each column that depends on the attitude, "sigma_" before its name, by what is not known of the body
/// and of a scene's torques, to first order; NaN where a column has no derivative (has_derivative()). Throws InputError
/// where all numbers are exact.
std::vector<ObservedColumn> observe_sigmas(const BodyInMotion& moving, const Sky& sky,
                                           std::span<const Instant> receptions, const ObservationOptions& options);

/// What to say beside them where the first order does not hold over these instants; of a scene it is not looked at.
std::optional<std::string> sigmas_caution(const BodyInMotion& moving, std::span<const Instant> receptions);

}  // namespace polhode
