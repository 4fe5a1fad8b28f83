#include "python/ephemeris.hpp"

#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/time_list.hpp"

namespace polhode::python {

Instant wanted(const nb::object& time, Instant epoch, Instant from, TimeScale scale) {
  if (nb::isinstance<nb::str>(time)) {
    const auto text = nb::cast<std::string>(time);
    if (text.starts_with('+') || text.starts_with('-')) {
      return instant_from_j2000(since_j2000(from, scale) + parse_duration(text), scale);
    }
  }
  const Elapsed elapsed = elapsed_of(time, epoch);
  if (!elapsed.scalar) throw InputError("one time is wanted, not an array of them");
  return epoch + Seconds{elapsed.high_s, elapsed.low_s};
}

std::vector<Instant> wanted_list(const nb::object& times, Instant epoch) {
  std::vector<Instant> instants;
  if (nb::isinstance<nb::str>(times)) {
    instants = read_time_list(nb::cast<std::string>(times), std::nullopt);
  } else if (const Elapsed elapsed = elapsed_of(times, epoch); elapsed.scalar) {
    instants.push_back(epoch + Seconds{elapsed.high_s, elapsed.low_s});
  } else {
    for (std::size_t i = 0; i < elapsed.high.size(); ++i) {
      instants.push_back(epoch + Seconds{elapsed.high.data[i], elapsed.low.empty() ? 0.0 : elapsed.low[i]});
    }
  }
  std::stable_sort(instants.begin(), instants.end());
  instants.erase(std::unique(instants.begin(), instants.end()), instants.end());
  return instants;
}

void Spacing::check() const {
  const int given = int(step.has_value()) + int(count.has_value()) + int(tolerance.has_value()) + int(!times.is_none());
  if (given > 1) throw InputError("step, count, tolerance and times each say where rows are: one of them is allowed");
  if (step && !((*step)->seconds.high > 0.0)) throw InputError("the step is to be positive");
}

namespace {

EphemerisObject ephemeris_of_motion(const MotionObject& motion, const nb::object& start, const nb::object& stop,
                                    const std::optional<Given<Duration>>& step, std::optional<std::size_t> count,
                                    const std::optional<Given<PlaneAngle>>& tolerance, const nb::object& times,
                                    const std::string& scale_name, bool covariance) {
  if (!motion.moving) throw InputError("a motion without epoch and frame has no ephemeris; Body.motion gives one");
  const std::shared_ptr<const BodyInMotion> moving = motion.moving;
  const Instant epoch = moving->body.state->epoch;
  const TimeScale scale = time_scale(scale_name);
  const Spacing spacing{step, count, tolerance, times};
  spacing.check();
  if (!times.is_none()) {
    if (!start.is_none() || !stop.is_none()) throw InputError("times stand alone, without start and stop");
    const std::vector<Instant> instants = wanted_list(times, epoch);
    return {[moving, covariance, grid = TimeGrid::of_list(instants, scale)](const EphemerisFormat* format) {
      return std::vector{rows_of(*moving, grid, std::nullopt, format, covariance)};
    }};
  }
  std::optional<double> tolerance_rad;
  if (tolerance) {
    tolerance_rad = (*tolerance)->rad;
  } else if (!step && !count) {
    tolerance_rad = motion.accuracy_rad;
    if (!tolerance_rad) throw InputError("one of step, count, tolerance and times is wanted");
  }
  const bool one_row = count == 1U && stop.is_none();
  if (stop.is_none() && !moving->under_torques && !one_row) throw InputError("stop is wanted: the last time");
  const Instant first = start.is_none()
                            ? instant_from_j2000(since_j2000(epoch, scale) + Seconds{moving->first_s, 0.0}, scale)
                            : wanted(start, epoch, epoch, scale);
  const Instant last = one_row ? first
                       : stop.is_none()
                           ? instant_from_j2000(since_j2000(epoch, scale) + Seconds{moving->last_s, 0.0}, scale)
                           : wanted(stop, epoch, first, scale);
  if (!tolerance_rad) {
    const TimeGrid grid = step ? TimeGrid::with_step(first, last, (*step)->seconds, scale)
                               : TimeGrid::with_count(first, last, *count, scale);
    return {[moving, grid, covariance](const EphemerisFormat* format) {
      return std::vector{rows_of(*moving, grid, std::nullopt, format, covariance)};
    }};
  }
  if (!(*tolerance_rad >= smallest_tolerance_rad)) {
    throw InputError(
        fmt::format("the tolerance is {} rad, {} rad or more is wanted", *tolerance_rad, smallest_tolerance_rad));
  }
  return {
      [moving, first, last, scale, covariance, rad = *tolerance_rad](const EphemerisFormat* format) {
        const std::size_t rows =
            rows_for_tolerance(*moving, first, last, scale, rad,
                               format != nullptr ? format->interpolation : RowInterpolation::great_circle);
        return std::vector{rows_of(*moving, TimeGrid::with_count(first, last, rows, scale), rad, format, covariance)};
      },
      true};
}

std::size_t write(const std::vector<const EphemerisObject*>& segments, const Given<FileName>& name,
                  const std::optional<std::string>& format_name, bool momentum, const std::string& adm,
                  const std::string& attitude_type, const std::string& euler_sequence) {
  const std::string path = name->path;
  const EphemerisFormat* format = ephemeris_format_of(format_name ? "." + *format_name : path);
  if (format == nullptr) {
    throw InputError(fmt::format("'{}' names no format; allowed endings are {}", format_name ? *format_name : path,
                                 endings_of_formats()));
  }
  const nb::gil_scoped_release others_go_on;
  std::vector<Ephemeris> all;
  WriteOptions options{momentum, adm, attitude_type, euler_sequence, false};
  std::size_t rows = 0;
  for (const EphemerisObject* segment : segments) {
    options.promises_interpolation |= segment->promises_interpolation;
    for (Ephemeris& one : segment->make(format)) {
      rows += one.times().size();
      all.push_back(std::move(one));
    }
  }
  write_ephemeris(path, *format, all, options, [](std::size_t) {
    const nb::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
  });
  return rows;
}

/// All rows as arrays, of the first ephemeris.
nb::dict arrays_of(const EphemerisObject& self) {
  const std::vector<Ephemeris> all = self.make(nullptr);
  std::size_t count = 0;
  for (const Ephemeris& one : all) count += one.times().size();
  const Shape rows{count};
  auto [time, time_data] = new_array(rows);
  auto [q, q_data] = new_array(Shape{count, 4});
  auto [omega, omega_data] = new_array(Shape{count, 3});
  auto [momentum, momentum_data] = new_array(Shape{count, 3});
  const bool covariance = all.front().has_covariance();
  auto [sigma, sigma_data] = new_array(Shape{covariance ? count : 0});
  auto [six, six_data] = new_array(Shape{covariance ? count : 0, 6});
  {
    const nb::gil_scoped_release others_go_on;
    AttitudeBlock block;
    std::size_t row = 0;
    for (const Ephemeris& one : all) {
      const double from_first_s = (one.times().reference() - all.front().times().reference()).high;
      one.fill(0, one.times().size(), {}, block);
      for (std::size_t i = 0; i < block.rows; ++i) time_data[row + i] = from_first_s + block.time[i].high;
      std::copy_n(block.q_frame_from_named.data(), 4 * block.rows, q_data + 4 * row);
      std::copy_n(block.omega_named_rad_s.data(), 3 * block.rows, omega_data + 3 * row);
      std::copy_n(block.momentum_named.data(), 3 * block.rows, momentum_data + 3 * row);
      if (covariance) {
        std::copy_n(block.sigma_rad.data(), block.rows, sigma_data + row);
        std::copy_n(block.covariance_rad2.data(), 6 * block.rows, six_data + 6 * row);
      }
      row += block.rows;
    }
  }
  nb::dict out;
  if (covariance) {
    out["sigma"] = sigma;
    out["covariance"] = six;
  }
  out["time_s"] = time;
  out["q"] = q;
  out["omega"] = omega;
  out["momentum"] = momentum;
  return out;
}

}  // namespace

void bind_ephemeris(nb::module_& m) {
  nb::class_<EphemerisObject>(m, "Ephemeris", "Rows of attitudes, computed when they are written or asked for.")
      .def(
          "write",
          [](const EphemerisObject& self, const Given<FileName>& path, const std::optional<std::string>& format,
             bool momentum, const std::string& adm, const std::string& attitude_type,
             const std::string& euler_sequence) {
            return write({&self}, path, format, momentum, adm, attitude_type, euler_sequence);
          },
          "path"_a, nb::kw_only(), "format"_a = nb::none(), "momentum"_a = false, "adm"_a = "", "attitude_type"_a = "",
          "euler_sequence"_a = "",
          "Writes a file, whose ending says the format (.fits, .fits.gz, .aem, .xml, .acm, .csv, .ecsv, .jsonl) unless "
          "`format` "
          "does; returns the number of rows. momentum: that too, in tables. adm, attitude_type, euler_sequence: of "
          "CCSDS "
          "messages. The file appears whole or not at all. Raises InputError, FileError, ComputationError.")
      .def("arrays", &arrays_of, nb::sig("def arrays(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]"),
           "The rows as arrays: time_s, seconds of the scale from `reference`; q, scalar first; omega; momentum; in "
           "named axes; if asked for, sigma (rad) and covariance (n, 6; xx, xy, xz, yy, yz, zz). Rows of a tolerance "
           "are spaced for great circles.")
      .def_prop_ro(
          "reference", [](const EphemerisObject& self) { return self.make(nullptr).front().times().reference(); },
          "The instant from which `arrays` counts time_s.")
      .def_prop_ro(
          "description",
          [](const EphemerisObject& self) {
            const Ephemeris first = self.make(nullptr).front();
            const EphemerisDescription& said = first.description();
            nb::dict out;
            out["object"] = said.object;
            out["method"] = said.method;
            out["frame"] = first.frame_name();
            out["rows"] = first.times().size();
            out["promised_error_rad"] = said.promised_error_rad;
            out["error_meaning"] = said.error_meaning;
            out["torque_evaluations"] = said.torque_evaluations;
            out["tolerance_rad"] = said.tolerance_rad;
            out["cautions"] = said.cautions;
            return out;
          },
          nb::sig("def description(self) -> dict[str, typing.Any]"), "What its files say about it.");
  m.def("write", &write, "ephemerides"_a, "path"_a, nb::kw_only(), "format"_a = nb::none(), "momentum"_a = false,
        "adm"_a = "", "attitude_type"_a = "", "euler_sequence"_a = "",
        "As Ephemeris.write, for several as the segments of one CCSDS message.");
  m.def(
      "endings", [] { return endings_of_formats(); }, "The endings of files that `write` knows, in words.");

  nb::class_<MotionObject> motion = nb::borrow<nb::class_<MotionObject>>(m.attr("Motion"));
  motion.def(
      "ephemeris", &ephemeris_of_motion, "start"_a = nb::none(), "stop"_a = nb::none(), nb::kw_only(),
      "step"_a = nb::none(), "count"_a = nb::none(), "tolerance"_a = nb::none(), "times"_a = nb::none(),
      "scale"_a = "TDB", "covariance"_a = false,
      nb::sig("def ephemeris(self, start: typing.Any = None, stop: typing.Any = None, *, step: float | str | "
              "astropy.units.Quantity | None = None, count: int | None = None, tolerance: float | str | "
              "astropy.units.Quantity | None = None, times: typing.Any = None, scale: str = 'TDB', covariance: bool = "
              "False) -> Ephemeris"),
      "Rows from `start` (the epoch, or where the scene begins, unless said) to `stop` (a scene's end unless said): "
      "a step apart (s, or '10 min'), `count` of them, or as few as keep what readers of the file interpolate "
      "within a tolerance (rad, or '1 arcsec'; a scene's accuracy unless said); or at `times`, in any order. A time is "
      "seconds from the epoch (TT), a date, an "
      "Instant, an astropy Time, or '+30 d' from the epoch, for `stop` from the start. `scale` is that of the rows. "
      "covariance: that of the attitude too, of a body with uncertainties. Raises InputError.");
}

}  // namespace polhode::python
