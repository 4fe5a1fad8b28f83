// Attitude histories: their rows, states by their own interpolation, and comparisons.
#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>

#include <limits>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/resample.hpp"
#include "polhode/session/body_report.hpp"
#include "python/ephemeris.hpp"

namespace polhode::python {
namespace {

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

HistoryObject make_history(const std::string& object, const nb::object& times, const Given<Attitudes>& q,
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

}  // namespace

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
          [](HistoryObject* self, const std::string& object, const nb::object& times, const Given<Attitudes>& q,
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

}  // namespace polhode::python
