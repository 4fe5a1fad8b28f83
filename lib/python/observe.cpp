#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/units.hpp"
#include "polhode/read/units.hpp"
#include "polhode/session/sky_request.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

Place place_of(const nb::object& what, const ObserveArguments& arguments, const BodyInMotion& moving) {
  const Instant epoch = moving.body.state->epoch;
  if (nb::isinstance<Trajectory>(what)) {
    return KnownWay{nb::cast<const Trajectory&>(what), moving.frame, epoch, arguments.centre, {}};
  }
  TrajectoryRequest request;
  request.centre = arguments.centre;
  request.zero = epoch;
  if (arguments.trajectory_frame) request.table_frame = frame(*arguments.trajectory_frame);
  return named_place(kind_of(what, static_cast<FileName*>(nullptr)).path, request);
}

std::shared_ptr<const polhode::Shape> shape_of(const nb::object& what, const std::string& unit) {
  if (nb::isinstance<TriangleMesh>(what)) {
    if (unit.empty()) throw InputError("shape_unit is wanted, the unit of the mesh's coordinates: 'm', 'km'");
    return mesh_shape(nb::cast<const TriangleMesh&>(what), length_unit_m(unit));
  }
  if (nb::isinstance<nb::str>(what) || nb::hasattr(what, "__fspath__")) {
    return named_shape(kind_of(what, static_cast<FileName*>(nullptr)).path, unit);
  }
  return ellipsoid_shape(numbers_of(what, "m").vector3("the semi-axes"));
}

std::vector<KnownDirection> directions_of(const nb::object& what, const Shape& shape_of_times, std::size_t count) {
  const auto [ra, dec, range] = nb::cast<std::tuple<nb::object, nb::object, nb::object>>(nb::tuple(what));
  const Numbers all[3] = {numbers_of(ra, "rad"), numbers_of(dec, "rad"), numbers_of(range, "m")};
  for (const Numbers& numbers : all) {
    if (numbers.shape != shape_of_times) throw InputError("the directions must have the shape of the times");
  }
  std::vector<KnownDirection> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back({all[0].data[i], all[1].data[i], all[2].data[i]});
  return out;
}

}  // namespace

nb::dict observe_motion(const MotionObject& motion, const nb::object& times, const ObserveArguments& arguments) {
  if (!motion.moving) throw InputError("a motion without epoch and frame is seen by nobody; Body.motion gives one");
  const BodyInMotion& moving = *motion.moving;
  const Instant epoch = moving.body.state->epoch;
  const Elapsed elapsed = elapsed_of(times, epoch);
  const Shape shape = elapsed.scalar ? Shape{} : elapsed.high.shape;
  std::vector<Instant> receptions;
  if (elapsed.scalar) {
    receptions.push_back(epoch + Seconds{elapsed.high_s, elapsed.low_s});
  } else {
    for (std::size_t i = 0; i < elapsed.high.size(); ++i) {
      receptions.push_back(epoch + Seconds{elapsed.high.data[i], elapsed.low.empty() ? 0.0 : elapsed.low[i]});
    }
  }

  ObservationOptions options;
  if (arguments.convention != "long-axis" && arguments.convention != "short-axis") {
    throw InputError(fmt::format("'{:.40}' is no convention; allowed: long-axis, short-axis", arguments.convention));
  }
  options.convention = arguments.convention == "long-axis" ? AxisConvention::long_axis : AxisConvention::short_axis;
  options.angles_frame = inertial_frame(arguments.frame);
  options.geometry = arguments.geometry;
  options.threads = arguments.threads;
  if (arguments.exposure) options.exposure_s = (*arguments.exposure)->seconds.high;
  if (!arguments.shape.is_none()) {
    Photometry photometry;
    photometry.shape = shape_of(arguments.shape, arguments.shape_unit);
    photometry.law = scattering_law(arguments.law, arguments.lambert_weight);
    if (!(arguments.specular >= 0.0 && arguments.specular <= 1.0)) throw InputError("specular is a part from 0 to 1");
    photometry.law.specular = arguments.specular;
    photometry.absolute_magnitude = arguments.absolute_magnitude;
    if (arguments.hg1g2 && arguments.phase_polynomial) {
      throw InputError("hg1g2 and phase_polynomial are both phase functions: one of them");
    }
    if (arguments.hg1g2) photometry.phase = HG1G2Phase{arguments.hg1g2->first, arguments.hg1g2->second};
    if (arguments.phase_polynomial) {
      photometry.phase = PolynomialPhase{arguments.phase_polynomial->first, arguments.phase_polynomial->second};
    }
    options.photometry = std::move(photometry);
  } else if (arguments.exposure || arguments.absolute_magnitude || arguments.hg1g2 || arguments.phase_polynomial ||
             arguments.law != "lommel-seeliger") {
    throw InputError("shape is missing: laws, phase functions, magnitudes and exposures are of a shape");
  }

  std::vector<ObservedColumn> columns;
  if (arguments.target.is_none()) {
    if (arguments.directions.is_none()) throw InputError("a target is wanted, or directions");
    const std::vector<KnownDirection> directions = directions_of(arguments.directions, shape, receptions.size());
    const nb::gil_scoped_release others_go_on;
    columns = observe(moving, directions, receptions, options);
  } else {
    SkyRequest sky;
    sky.target = place_of(arguments.target, arguments, moving);
    if (!arguments.site.is_none()) {
      const auto [longitude, latitude, height] =
          nb::cast<std::tuple<double, double, double>>(nb::tuple(arguments.site));
      sky.observer = Site{longitude * degree, latitude * degree, height, arguments.earth};
    } else {
      sky.observer = place_of(arguments.observer, arguments, moving);
    }
    if (!arguments.sun.is_none()) sky.sun = place_of(arguments.sun, arguments, moving);
    const nb::gil_scoped_release others_go_on;
    columns = observe(moving, sky, receptions, options);
  }
  nb::dict out;
  for (const ObservedColumn& column : columns) out[column.name.c_str()] = array_of(shape, column.values.data()).array;
  return out;
}

}  // namespace polhode::python
