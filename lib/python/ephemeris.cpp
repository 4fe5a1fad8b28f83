#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/resample.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/time_list.hpp"
#include "polhode/session/body_report.hpp"
#include "polhode/write/ephemeris_formats.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

/// Ephemeris: rows to be, of a motion or of an attitude history.
struct EphemerisObject {
  /// How many rows there are may depend on what a format's readers do between them; null: as by great circles.
  std::function<std::vector<Ephemeris>(const EphemerisFormat* format)> make;
  bool promises_interpolation = false;
};

/// A wanted time: a date, a span as '+30 d' from `from` in seconds of `scale`, or seconds from `epoch` as TT counts
/// them.
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

/// The instants of a list of times, of a comma-separated text, or of a file.
std::vector<Instant> wanted_list(const nb::object& times, Instant epoch) {
  if (nb::isinstance<nb::str>(times)) return read_time_list(nb::cast<std::string>(times), std::nullopt);
  const Elapsed elapsed = elapsed_of(times, epoch);
  if (elapsed.scalar) return {epoch + Seconds{elapsed.high_s, elapsed.low_s}};
  std::vector<Instant> instants;
  for (std::size_t i = 0; i < elapsed.high.size(); ++i) {
    instants.push_back(epoch + Seconds{elapsed.high.data[i], elapsed.low.empty() ? 0.0 : elapsed.low[i]});
  }
  return instants;
}

struct Spacing {
  std::optional<Given<Duration>> step;
  std::optional<std::size_t> count;
  std::optional<Given<PlaneAngle>> tolerance;
  nb::object times = nb::none();

  void check() const {
    const int given =
        int(step.has_value()) + int(count.has_value()) + int(tolerance.has_value()) + int(!times.is_none());
    if (given > 1) throw InputError("step, count, tolerance and times each say where rows are: one of them is allowed");
    if (step && !((*step)->seconds.high > 0.0)) throw InputError("the step is to be positive");
  }
};

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
  if (!step && !count && !tolerance) throw InputError("one of step, count, tolerance and times is wanted");
  const bool one_row = count == 1U && stop.is_none();
  if (stop.is_none() && !moving->under_torques && !one_row) throw InputError("stop is wanted: the last time");
  const Instant first = start.is_none()
                            ? instant_from_j2000(since_j2000(epoch, scale) + Seconds{moving->first_s, 0.0}, scale)
                            : wanted(start, epoch, epoch, scale);
  const Instant last = one_row ? first
                       : stop.is_none()
                           ? instant_from_j2000(since_j2000(epoch, scale) + Seconds{moving->last_s, 0.0}, scale)
                           : wanted(stop, epoch, first, scale);
  if (!tolerance) {
    const TimeGrid grid = step ? TimeGrid::with_step(first, last, (*step)->seconds, scale)
                               : TimeGrid::with_count(first, last, *count, scale);
    return {[moving, grid, covariance](const EphemerisFormat* format) {
      return std::vector{rows_of(*moving, grid, std::nullopt, format, covariance)};
    }};
  }
  if (!((*tolerance)->rad >= smallest_tolerance_rad)) {
    throw InputError(
        fmt::format("the tolerance is {} rad, {} rad or more is wanted", (*tolerance)->rad, smallest_tolerance_rad));
  }
  return {
      [moving, first, last, scale, covariance, rad = (*tolerance)->rad](const EphemerisFormat* format) {
        const std::size_t rows =
            rows_for_tolerance(*moving, first, last, scale, rad,
                               format != nullptr ? format->interpolation : RowInterpolation::great_circle);
        return std::vector{rows_of(*moving, TimeGrid::with_count(first, last, rows, scale), rad, format, covariance)};
      },
      true};
}

EphemerisObject ephemeris_of_history(const HistoryObject& self, const nb::object& start, const nb::object& stop,
                                     const std::optional<Given<Duration>>& step, std::optional<std::size_t> count,
                                     const nb::object& times, const std::optional<std::string>& scale_name,
                                     const std::optional<std::string>& frame_name) {
  const AttitudeHistory& history = self.history();
  const TimeScale scale = scale_name ? time_scale(*scale_name) : history.scale;
  const std::optional<Frame> to = frame_name ? std::optional(inertial_frame(*frame_name)) : std::nullopt;
  const Spacing spacing{step, count, std::nullopt, times};
  spacing.check();
  const Instant first = history.segments.front().first();
  WantedTimes rows;
  if (step) rows.step = (*step)->seconds;
  rows.count = count.value_or(0);
  if (!times.is_none()) {
    if (!start.is_none() || !stop.is_none()) throw InputError("times stand alone, without start and stop");
    rows.list = wanted_list(times, first);
  }
  if (!start.is_none()) rows.start = wanted(start, first, first, scale);
  if (!stop.is_none()) rows.stop = wanted(stop, first, rows.start.value_or(first), scale);
  return {[segments = resample(history, rows, scale, to)](const EphemerisFormat*) { return segments; }};
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

// --- Histories ------------------------------------------------------------------------------------------------------

struct SegmentObject {
  AttitudeSegment segment;
  TimeScale scale;
};

FloatArray seconds_of(const AttitudeSegment& segment) {
  auto [array, data] = new_array(Shape{segment.samples.size()});
  for (std::size_t i = 0; i < segment.samples.size(); ++i) {
    data[i] = (segment.samples[i].time - segment.samples.front().time).high;
  }
  return {std::move(array)};
}

FloatArray attitudes_of(const AttitudeSegment& segment) {
  auto [array, data] = new_array(Shape{segment.samples.size(), 4});
  for (std::size_t i = 0; i < segment.samples.size(); ++i) {
    Eigen::Map<Eigen::Vector4d>(data + 4 * i) = scalar_first(segment.samples[i].q_frame_from_body);
  }
  return {std::move(array)};
}

std::optional<FloatArray> rates_of(const AttitudeSegment& segment) {
  if (!segment.has_rates()) return std::nullopt;
  auto [array, data] = new_array(Shape{segment.samples.size(), 3});
  for (std::size_t i = 0; i < segment.samples.size(); ++i) {
    Eigen::Map<Vector3>(data + 3 * i) = *segment.samples[i].omega_body_rad_s;
  }
  return FloatArray{std::move(array)};
}

HistoryObject make_history(const std::string& object, const nb::object& times, const Given<Numbers>& q,
                           const std::optional<Given<Rates>>& omega, const std::string& frame_name,
                           const std::string& body_axes, const std::string& scale_name) {
  const std::vector<Instant> instants = instants_of(times);
  if (q->shape != Shape{instants.size(), 4})
    throw InputError(fmt::format("q of shape ({}, 4) is wanted", instants.size()));
  if (omega && (*omega)->shape != Shape{instants.size(), 3}) {
    throw InputError(fmt::format("omega of shape ({}, 3) is wanted", instants.size()));
  }
  AttitudeSegment segment;
  segment.known_frame = inertial_frame(frame_name);
  segment.frame = name(*segment.known_frame);
  segment.body = body_axes;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    AttitudeSample sample;
    sample.time = instants[i];
    sample.q_frame_from_body = from_scalar_first(Eigen::Map<const Eigen::Vector4d>(q->data + 4 * i)).normalized();
    if (omega) sample.omega_body_rad_s = Vector3((*omega)->data + 3 * i);
    segment.samples.push_back(sample);
  }
  segment.choose_method();
  checked(segment);
  AttitudeHistory history;
  history.object = object;
  history.scale = time_scale(scale_name);
  history.segments = {std::move(segment)};
  BodyAndHistory file;
  file.body.name = object;
  file.body.missing = {"an inertia"};
  file.history = std::move(history);
  file.is_table = true;
  return {std::move(file), {}};
}

/// The segment that holds the instant, or that which is nearest.
const AttitudeSegment& segment_at(const AttitudeHistory& history, Instant time) {
  for (const AttitudeSegment& segment : history.segments) {
    if (segment.is_usable_at(time)) return segment;
  }
  const AttitudeSegment &first = history.segments.front(), &last = history.segments.back();
  throw InputError(fmt::format("there is no attitude at {0} {3}: the history lasts from {1} to {2} {3}{4}",
                               format_date(time, history.scale, 3), format_date(first.first(), history.scale, 3),
                               format_date(last.last(), history.scale, 3), name(history.scale),
                               history.segments.size() > 1 ? ", with gaps between its segments" : ""));
}

StateObject history_state(const HistoryObject& self, const nb::object& t) {
  const AttitudeHistory& history = self.history();
  StateObject state;
  state.epoch = history.segments.front().samples.front().time;
  state.frame = history.segments.front().frame;
  const Elapsed times = elapsed_of(t, state.epoch);
  const auto sample_at = [&](Seconds s) {
    const AttitudeSegment& segment = segment_at(history, *state.epoch + s);
    if (segment.frame != state.frame) throw InputError("the segments refer to different frames; take segments apart");
    return interpolate(segment, *state.epoch + s);
  };
  const auto rate = [](const AttitudeSample& sample) {
    return sample.omega_body_rad_s.value_or(Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
  };
  if (times.scalar) {
    const AttitudeSample sample = sample_at({times.high_s, times.low_s});
    state.t_s = times.high_s + times.low_s;
    state.q1 = scalar_first(sample.q_frame_from_body);
    state.omega1 = rate(sample);
    return state;
  }
  state.scalar = false;
  state.t = times.high.array;
  Shape shape = times.high.shape;
  shape.push_back(4);
  auto [q, q_data] = new_array(shape);
  shape.back() = 3;
  auto [omega, omega_data] = new_array(shape);
  {
    const nb::gil_scoped_release others_go_on;
    for (std::size_t i = 0; i < times.high.size(); ++i) {
      const AttitudeSample sample = sample_at({times.high.data[i], times.low.empty() ? 0.0 : times.low[i]});
      Eigen::Map<Eigen::Vector4d>(q_data + 4 * i) = scalar_first(sample.q_frame_from_body);
      Eigen::Map<Vector3>(omega_data + 3 * i) = rate(sample);
    }
  }
  state.q = std::move(q);
  state.omega = std::move(omega);
  return state;
}

AttitudeDifference compare_any(nb::handle a, nb::handle b) {
  const bool first = nb::isinstance<HistoryObject>(a), second = nb::isinstance<HistoryObject>(b);
  if (!first && !second) {
    throw InputError("one of the two must be an AttitudeHistory: its times are those of the comparison");
  }
  const AttitudeHistory& rows = nb::cast<const HistoryObject&>(first ? a : b).history();
  if (first && second) return compare(rows, nb::cast<const HistoryObject&>(b).history());
  const nb::handle other = first ? b : a;
  if (nb::isinstance<MotionObject>(other)) return compare(rows, q_icrf_of(nb::cast<const MotionObject&>(other)));
  if (!nb::isinstance<BodyObject>(other)) throw nb::type_error("an AttitudeHistory, a Body or a Motion is wanted");
  const auto moving = std::make_shared<BodyInMotion>(
      free_motion_of(nb::cast<const BodyObject&>(other).body(), Frame::icrf, method("auto")));
  return compare(rows, q_icrf_of(*motion_object(moving, &method("auto"))));
}

void bind_history(nb::module_& m) {
  nb::class_<SegmentObject>(m, "Segment", "Rows of an attitude history that belong together.")
      .def_prop_ro(
          "frame", [](const SegmentObject& self) { return self.segment.frame; }, "As the file names it.")
      .def_prop_ro(
          "body_axes", [](const SegmentObject& self) { return self.segment.body; }, "As the file names them.")
      .def_prop_ro(
          "epoch", [](const SegmentObject& self) { return self.segment.samples.front().time; },
          "The first row's instant.")
      .def_prop_ro(
          "t", [](const SegmentObject& self) { return seconds_of(self.segment); }, "Seconds from `epoch`: (n,).")
      .def_prop_ro(
          "q", [](const SegmentObject& self) { return attitudes_of(self.segment); },
          "v_frame = q v_body q*, scalar first: (n, 4).")
      .def_prop_ro(
          "omega", [](const SegmentObject& self) { return rates_of(self.segment); },
          "rad/s, body axes: (n, 3); None without rates.")
      .def_prop_ro(
          "usable", [](const SegmentObject& self) { return std::pair(self.segment.first(), self.segment.last()); },
          "First and last instant at which an attitude may be asked for.")
      .def_prop_ro(
          "interpolation",
          [](const SegmentObject& self) {
            return std::pair(std::string(name(self.segment.method)), self.segment.degree);
          },
          "LINEAR, LAGRANGE or HERMITE, and the degree.")
      .def("__len__", [](const SegmentObject& self) { return self.segment.samples.size(); });

  nb::class_<HistoryObject>(m, "AttitudeHistory",
                            "An attitude given by rows: a table, or a CCSDS message. `read` makes one from a file.")
      .def(
          "__init__",
          [](HistoryObject* self, const std::string& object, const nb::object& times, const Given<Numbers>& q,
             const std::optional<Given<Rates>>& omega, const std::string& frame, const std::string& body_axes,
             const std::string& scale) {
            new (self) HistoryObject(make_history(object, times, q, omega, frame, body_axes, scale));
          },
          "object"_a, "times"_a, "q"_a, "omega"_a = nb::none(), nb::kw_only(), "frame"_a = "ICRF",
          "body_axes"_a = "SC_BODY_1", "scale"_a = "UTC",
          "Without a file: instants that increase (an astropy Time, or a list of Instants or dates), attitudes (n, 4) "
          "and "
          "perhaps rates (n, 3). `scale` is that of its rows where it is written. Raises InputError.")
      .def_prop_ro("object", [](const HistoryObject& self) { return self.history().object; })
      .def_prop_ro(
          "scale", [](const HistoryObject& self) { return std::string(name(self.history().scale)); },
          "Time scale of the file.")
      .def_prop_ro("segments",
                   [](const HistoryObject& self) {
                     std::vector<SegmentObject> all;
                     for (const AttitudeSegment& segment : self.history().segments)
                       all.push_back({segment, self.history().scale});
                     return all;
                   })
      .def_prop_ro(
          "epoch", [](const HistoryObject& self) { return self.history().segments.front().samples.front().time; },
          "The first row's instant, from which t counts.")
      .def_prop_ro(
          "rows", [](const HistoryObject& self) { return self.history().rows(); }, "Of all segments.")
      .def_prop_ro("notes", [](const HistoryObject& self) { return self.history().notes; })
      .def_prop_ro("warnings", [](const HistoryObject& self) { return self.history().warnings; })
      .def_prop_ro(
          "body",
          [](const HistoryObject& self) {
            return BodyObject{{self.file.body, std::nullopt, false}, self.path};
          },
          "What the file says of the body; mostly without inertia.")
      .def_prop_ro("path", [](const HistoryObject& self) { return self.path; })
      .def(
          "info", [](const HistoryObject& self) { return from_json(json_text(report_on(self.path, self.file))); },
          nb::sig("def info(self) -> dict[str, typing.Any]"), "What `polhode info --json` prints, as a dict.")
      .def("__call__", &history_state, "t"_a, nb::sig("def __call__(self, t: typing.Any) -> State"),
           "Attitude and rate at t by the history's own interpolation: seconds from `epoch`, Instants, dates, astropy "
           "Times. Raises InputError outside of the rows.")
      .def("ephemeris", &ephemeris_of_history, "start"_a = nb::none(), "stop"_a = nb::none(), nb::kw_only(),
           "step"_a = nb::none(), "count"_a = nb::none(), "times"_a = nb::none(), "scale"_a = nb::none(),
           "frame"_a = nb::none(),
           nb::sig(
               "def ephemeris(self, start: typing.Any = None, stop: typing.Any = None, *, step: float | str | "
               "astropy.units.Quantity | None = None, count: int | None = None, times: typing.Any = None, scale: str | "
               "None = None, frame: str | None = None) -> Ephemeris"),
           "Its rows between two times, or attitudes a step apart, or `count` in each segment, or at these times.")
      .def("__repr__", [](const HistoryObject& self) {
        return fmt::format("<AttitudeHistory of {}: {} rows>", self.history().object, self.history().rows());
      });

  nb::class_<AttitudeDifference>(m, "Difference", "Between two attitudes over time.")
      .def_ro("compared", &AttitudeDifference::compared, "Rows that have a counterpart.")
      .def_ro("outside", &AttitudeDifference::outside, "Rows that have none.")
      .def_ro("largest_rad", &AttitudeDifference::largest_rad)
      .def_ro("root_mean_square_rad", &AttitudeDifference::root_mean_square_rad)
      .def_ro("time_of_largest", &AttitudeDifference::time_of_largest)
      .def("__repr__", [](const AttitudeDifference& self) {
        return fmt::format("<Difference: at most {:.6g} rad in {} rows>", self.largest_rad, self.compared);
      });
  m.def("compare", &compare_any, "a"_a, "b"_a,
        nb::sig("def compare(a: AttitudeHistory | Body | Motion, b: AttitudeHistory | Body | Motion) -> Difference"),
        "The angle between two attitudes: histories, or a history and a Body's free motion or any Motion; at the times "
        "of "
        "the history, a's if both are. Raises InputError where they cannot be related.");
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
      "within a tolerance (rad, or '1 arcsec'); or at `times`. A time is seconds from the epoch (TT), a date, an "
      "Instant, an astropy Time, or '+30 d' from the epoch, for `stop` from the start. `scale` is that of the rows. "
      "covariance: that of the attitude too, of a body with uncertainties. Raises InputError.");
  bind_history(m);
}

}  // namespace polhode::python
