#include <fmt/format.h>
#include <nanobind/stl/map.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/units.hpp"
#include "polhode/read/units.hpp"
#include "polhode/session/sky_request.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

struct ObserveArguments {
  nb::object target, observer, sun, site, shape, directions, surfaces;
  std::string centre, convention, frame, shape_unit, law;
  std::optional<std::string> trajectory_frame;
  EarthOrientation earth;
  double lambert_weight, specular;
  std::optional<double> absolute_magnitude;
  std::optional<std::pair<double, double>> hg1g2, phase_polynomial;
  std::optional<Given<Duration>> exposure;
  bool geometry;
  unsigned threads;
};

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

std::shared_ptr<const polhode::Shape> shape_of(const nb::object& what, const std::string& unit,
                                               const nb::object& given) {
  std::map<std::string, SurfaceShine, std::less<>> surfaces;
  if (!given.is_none()) {
    for (const auto& [name, numbers] : nb::cast<std::map<std::string, std::vector<double>>>(given)) {
      surfaces[name] = surface_shine(numbers);
    }
  }
  if (nb::isinstance<TriangleMesh>(what)) {
    if (unit.empty()) throw InputError("shape_unit is wanted, the unit of the mesh's coordinates: 'm', 'km'");
    return mesh_shape(nb::cast<const TriangleMesh&>(what), length_unit_m(unit), surfaces);
  }
  if (nb::isinstance<nb::str>(what) || nb::hasattr(what, "__fspath__")) {
    return named_shape(kind_of(what, static_cast<FileName*>(nullptr)).path, unit, surfaces);
  }
  if (!surfaces.empty()) throw InputError("surfaces are of a mesh, which gives them names; this is an ellipsoid");
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

/// What is asked for, in the library's terms.
struct Asked {
  const BodyInMotion& moving;
  Shape shape;
  std::vector<Instant> receptions;
  ObservationOptions options;
  Sky sky;
};

Asked asked(const MotionObject& motion, const nb::object& times, const ObserveArguments& arguments) {
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
    photometry.shape = shape_of(arguments.shape, arguments.shape_unit, arguments.surfaces);
    photometry.law = scattering_law(arguments.law, arguments.lambert_weight, arguments.specular);
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
             !arguments.surfaces.is_none() || arguments.law != "lommel-seeliger") {
    throw InputError("shape is missing: laws, phase functions, magnitudes and exposures are of a shape");
  }

  Sky sky;
  if (arguments.target.is_none()) {
    if (arguments.directions.is_none()) throw InputError("a target is wanted, or directions");
    sky = directions_of(arguments.directions, shape, receptions.size());
  } else {
    SkyRequest request;
    request.target = place_of(arguments.target, arguments, moving);
    if (!arguments.site.is_none()) {
      const auto [longitude, latitude, height] =
          nb::cast<std::tuple<double, double, double>>(nb::tuple(arguments.site));
      request.observer = Site{longitude * degree, latitude * degree, height, arguments.earth};
    } else {
      request.observer = place_of(arguments.observer, arguments, moving);
    }
    if (!arguments.sun.is_none()) request.sun = place_of(arguments.sun, arguments, moving);
    sky = std::move(request);
  }
  return {moving, shape, std::move(receptions), std::move(options), std::move(sky)};
}

nb::dict dict_of(const std::vector<ObservedColumn>& columns, const Shape& shape) {
  nb::dict out;
  for (const ObservedColumn& column : columns) out[column.name.c_str()] = array_of(shape, column.values.data()).array;
  return out;
}

nb::dict seen(const Asked& asked, bool covariance) {
  std::vector<ObservedColumn> columns;
  {
    const nb::gil_scoped_release others_go_on;
    columns = observe(asked.moving, asked.sky, asked.receptions, asked.options);
    if (covariance) {
      for (ObservedColumn& sigma : observe_sigmas(asked.moving, asked.sky, asked.receptions, asked.options)) {
        columns.push_back(std::move(sigma));
      }
    }
  }
  return dict_of(columns, asked.shape);
}

nb::tuple partials_seen(const Asked& asked) {
  std::vector<ObservedColumn> columns;
  std::vector<std::string> parameters;
  {
    const nb::gil_scoped_release others_go_on;
    const StatePartialsSource states_by = state_partials_of(*asked.moving.motion, asked.moving.free);
    parameters = observed_parameters(states_by, asked.options);
    columns = observe_partials(asked.moving, asked.sky, asked.receptions, asked.options, states_by);
  }
  Shape shape = asked.shape;
  shape.push_back(parameters.size());
  return nb::make_tuple(parameters, dict_of(columns, shape));
}

constexpr const char* kArguments =
    "(self, times: typing.Any, target: Orbit | str | os.PathLike[str] | None = None, *, "
    "observer: Orbit | str | os.PathLike[str] = 'geocentre', sun: Orbit | str | os.PathLike[str] | None = "
    "None, site: tuple[float, float, float] | None = None, directions: "
    "tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike, numpy.typing.ArrayLike] | None = None, centre: "
    "str = 'Sun', trajectory_frame: str | None = None, ut1_minus_utc_s: float = 0.0, pole_x_arcsec: float "
    "= 0.0, pole_y_arcsec: float = 0.0, convention: str = 'long-axis', frame: str = 'ECLIPJ2000', shape: "
    "Mesh | str | os.PathLike[str] | numpy.typing.ArrayLike | None = None, shape_unit: str | None = None, "
    "surfaces: dict[str, tuple[float, ...]] | None = None, "
    "law: str = 'lommel-seeliger', lambert_weight: float = 0.1, specular: float = 0.0, H: float | None = "
    "None, hg1g2: tuple[float, float] | None = None, phase_polynomial: tuple[float, float] | None = None, exposure: "
    "float | str | astropy.units.Quantity | None = None, geometry: bool = True, threads: int = 0";

/// A method with these arguments and those in `more`, whose types `More` has; `result` makes its result of Asked and of
/// them.
template <class... More, class Result, class... Extra>
void define(nb::class_<MotionObject>& motion, const char* name, const std::string& more, const char* returns,
            const char* text, const Result& result, const Extra&... extra) {
  const std::string signature = fmt::format("def {}{}{}) -> {}", name, kArguments, more, returns);
  motion.def(
      name,
      [result](const MotionObject& self, const nb::object& times, const nb::object& target, const nb::object& observer,
               const nb::object& sun, const nb::object& site, const nb::object& directions, const std::string& centre,
               const std::optional<std::string>& trajectory_frame, double ut1_minus_utc_s, double pole_x_arcsec,
               double pole_y_arcsec, const std::string& convention, const std::string& frame, const nb::object& shape,
               const std::optional<std::string>& shape_unit, const nb::object& surfaces, const std::string& law,
               double lambert_weight, double specular, std::optional<double> absolute_magnitude,
               std::optional<std::pair<double, double>> hg1g2,
               std::optional<std::pair<double, double>> phase_polynomial,
               const std::optional<Given<Duration>>& exposure, bool geometry, unsigned threads, More... others) {
        const ObserveArguments arguments{target,
                                         observer,
                                         sun,
                                         site,
                                         shape,
                                         directions,
                                         surfaces,
                                         centre,
                                         convention,
                                         frame,
                                         shape_unit.value_or(""),
                                         law,
                                         trajectory_frame,
                                         {ut1_minus_utc_s, pole_x_arcsec, pole_y_arcsec},
                                         lambert_weight,
                                         specular,
                                         absolute_magnitude,
                                         hg1g2,
                                         phase_polynomial,
                                         exposure,
                                         geometry,
                                         threads};
        return result(asked(self, times, arguments), others...);
      },
      "times"_a, "target"_a = nb::none(), nb::kw_only(), "observer"_a = "geocentre", "sun"_a = nb::none(),
      "site"_a = nb::none(), "directions"_a = nb::none(), "centre"_a = "Sun", "trajectory_frame"_a = nb::none(),
      "ut1_minus_utc_s"_a = 0.0, "pole_x_arcsec"_a = 0.0, "pole_y_arcsec"_a = 0.0, "convention"_a = "long-axis",
      "frame"_a = "ECLIPJ2000", "shape"_a = nb::none(), "shape_unit"_a = nb::none(), "surfaces"_a = nb::none(),
      "law"_a = "lommel-seeliger", "lambert_weight"_a = 0.1, "specular"_a = 0.0, "H"_a = nb::none(),
      "hg1g2"_a = nb::none(), "phase_polynomial"_a = nb::none(), "exposure"_a = nb::none(), "geometry"_a = true,
      "threads"_a = 0U, extra..., nb::sig(signature.c_str()), text);
}

}  // namespace

void bind_observe(nb::class_<MotionObject>& motion) {
  define<bool>(
      motion, "observe", ", covariance: bool = False", "dict[str, numpy.typing.NDArray[numpy.float64]]",
      "What an observer sees at times of reception: the columns of `polhode observe` as arrays of the times' shape. "
      "`target`, `observer` and `sun` are trajectories, files or Orbits (in the motion's frame, about `centre`, "
      "seconds from its epoch); the observer may be 'geocentre', 'sun', or a `site` (longitude and latitude in deg, "
      "height in m). Instead of a target `directions` may give its astrometric geocentric right ascension and "
      "declination (rad) and distance (m). A `shape` (semi-axes in m along the body's x, y, z, text as on the command "
      "line, or a Mesh or its file with `shape_unit`) adds magnitude and area_m2; `surfaces` has of those that the "
      "mesh names the parts of light "
      "that they scatter by the law and throw on like mirrors, and, of plates, 2 for their sides. `geometry=False` "
      "leaves all else "
      "away. `covariance` adds sigma_... of each column that depends on the attitude, by the body's uncertainties.",
      &seen, "covariance"_a = false);
  define<>(
      motion, "observe_partials", "", "tuple[list[str], dict[str, numpy.typing.NDArray[numpy.float64]]]",
      "Partial derivatives of the columns of observe(), with the same arguments: the names of the parameters, and "
      "of each column an array (..., parameters) in its unit per theirs. The parameters are those of partials(), "
      "then 'axes_x', 'axes_y', 'axes_z', a turn of the principal axes in the body (rad), whose motion stays, and, "
      "with a shape, 'scale', the relative change of its lengths. Differences across 2e-3 rad at most by the "
      "state at emission, exact by the parameters; nan where a column has no derivative, at rest or at a pole.",
      &partials_seen);
}

}  // namespace polhode::python
