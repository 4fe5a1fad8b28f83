#include "python/states.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"

namespace polhode::python {

std::size_t count_of(std::span<const std::size_t> shape) {
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  return count;
}

Shape broadcast(const Shape& a, const Shape& b, const char* what) {
  Shape out(std::max(a.size(), b.size()));
  for (std::size_t i = 0; i < out.size(); ++i) {  // from the last
    const std::size_t m = i < a.size() ? a[a.size() - 1 - i] : 1, n = i < b.size() ? b[b.size() - 1 - i] : 1;
    if (m != n && m != 1 && n != 1) {
      throw InputError(
          fmt::format("{} of shapes ({}) and ({}) do not go together", what, fmt::join(a, ", "), fmt::join(b, ", ")));
    }
    out[out.size() - 1 - i] = m == 1 ? n : m;
  }
  return out;
}

std::vector<std::ptrdiff_t> strides_in(const Shape& whole, const Shape& shape) {
  std::vector<std::ptrdiff_t> strides(whole.size(), 0);
  std::ptrdiff_t stride = 1;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const std::size_t n = shape[shape.size() - 1 - i];
    if (n != 1) strides[whole.size() - 1 - i] = stride;
    stride *= static_cast<std::ptrdiff_t>(n);
  }
  return strides;
}

Shape leading(const Numbers& numbers, std::size_t last, const char* what) {
  if (numbers.shape.empty() || numbers.shape.back() != last) {
    throw InputError(
        fmt::format("{} has the shape ({}), (…, {}) is wanted", what, fmt::join(numbers.shape, ", "), last));
  }
  return {numbers.shape.begin(), numbers.shape.end() - 1};
}

namespace {

constexpr std::size_t kBlock = 512;  // rows that are turned into named axes while they are in the cache

/// Arrays to write to: rows of 4 and of 3 numbers, or columns (any stride that numpy has).
struct Output {
  nb::object q, m;  ///< as they are given back; `m` may be none
  StateArrays arrays;
};

/// An array of the caller's, and its strides in elements: of rows and of numbers in a row.
struct Rows {
  double* data;
  std::ptrdiff_t row, number;
};

/// Whether two numbers of such an array are at one place.
bool meets_itself(const Rows& rows, std::size_t count, std::size_t width) {
  if (count < 2) return rows.number == 0 && count > 0;
  if (rows.row == 0 || rows.number == 0) return true;
  for (std::ptrdiff_t k = 1; k < static_cast<std::ptrdiff_t>(width); ++k) {
    const std::ptrdiff_t ahead = std::abs(k * rows.number), row = std::abs(rows.row);
    if (ahead % row == 0 && static_cast<std::size_t>(ahead / row) < count) return true;
  }
  return false;
}

Rows rows_of(nb::handle object, const Shape& shape, std::size_t width, const char* what) {
  Shape whole = shape;
  whole.push_back(width);
  const auto refuse = [&] {
    throw InputError(fmt::format(
        "out: {} is to be an array of float64 of the shape ({}), writable, its rows at one distance from each other",
        what, fmt::join(whole, ", ")));
  };
  nb::ndarray<double, nb::device::cpu> view;
  if (!nb::try_cast(object, view, false) || view.ndim() != whole.size()) refuse();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (view.shape(i) != whole[i]) refuse();
  }
  Rows rows{view.data(), static_cast<std::ptrdiff_t>(width), view.stride(whole.size() - 1)};
  if (!shape.empty()) rows.row = view.stride(shape.size() - 1);
  for (std::size_t i = 0; i + 1 < shape.size(); ++i) {
    if (view.stride(i) != view.stride(i + 1) * static_cast<std::ptrdiff_t>(shape[i + 1])) refuse();
  }
  if (meets_itself(rows, count_of(shape), width)) {
    throw InputError(fmt::format("out: elements of {} share memory with each other", what));
  }
  return rows;
}

/// Throws InputError if results would overwrite each other, or the times that are still to be read.
void refuse_overlap(nb::handle q, nb::handle m, nb::handle times) {
  const nb::object share = nb::module_::import_("numpy").attr("shares_memory");
  const auto check = [&](nb::handle a, nb::handle b, const char* which) {
    if (a.is_valid() && b.is_valid() && !a.is_none() && !b.is_none() && nb::cast<bool>(share(a, b))) {
      throw InputError(fmt::format("out: {} share memory", which));
    }
  };
  check(q, m, "the arrays of attitude and momentum");
  check(q, times, "the array of attitudes and the times");
  check(m, times, "the array of momenta and the times");
}

Output output_for(const nb::object& out, const Shape& shape, nb::handle times) {
  Output output;
  Shape whole = shape;
  if (out.is_none()) {
    whole.push_back(4);
    auto [q, q_data] = new_array(whole);
    whole.back() = 3;
    auto [m, m_data] = new_array(whole);
    output.q = std::move(q);
    output.m = std::move(m);
    output.arrays = StateArrays::of_structures(q_data, m_data);
    return output;
  }
  if (!nb::isinstance<nb::sequence>(out) || nb::len(out) != 2) {
    throw InputError("out is to be a pair of arrays: attitude and momentum, or attitude and None");
  }
  output.q = out[0];
  output.m = out[1];
  const Rows q = rows_of(output.q, shape, 4, "q");
  for (int k = 0; k < 4; ++k) output.arrays.q[k] = q.data + k * q.number;
  output.arrays.q_stride = q.row;
  if (!output.m.is_none()) {
    const Rows m = rows_of(output.m, shape, 3, "m");
    for (int k = 0; k < 3; ++k) output.arrays.m[k] = m.data + k * m.number;
    output.arrays.m_stride = m.row;
  }
  refuse_overlap(output.q, output.m, times);
  return output;
}

/// The states of one body in the axes that its file names, computed as an Ephemeris computes its rows.
void named_states(const MotionObject& self, const TimeArrays& times, const StateArrays& out, double* omega,
                  unsigned threads) {
  const MotionObject::NamedAxes& axes = *self.named;
  const Vector3 inverse_moments = self.bodies.front().principal_moments.cwiseInverse();
  parallel_chunks(times.high.size(), kBlock, threads, [&](std::size_t begin, std::size_t end) {
    double q_rows[4 * kBlock], m_rows[3 * kBlock];
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t count = std::min(kBlock, end - first);
      self.motions.front()->batch(part_of(times, first, first + count), StateArrays::of_structures(q_rows, m_rows));
      const StateArrays to = part_of(out, first);
      for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::ptrdiff_t>(i);
        const Eigen::Map<const Eigen::Vector4d> q_row(q_rows + 4 * i);
        const Eigen::Map<const Vector3> m_row(m_rows + 3 * i);
        const Eigen::Vector4d q = scalar_first(from_scalar_first(q_row) * axes.q_principal_from_named);
        for (int k = 0; k < 4; ++k) to.q[k][row * to.q_stride] = q[k];
        if (to.m[0] != nullptr) {
          const Vector3 m = axes.named_from_principal * m_row;
          for (int k = 0; k < 3; ++k) to.m[k][row * to.m_stride] = m[k];
        }
        if (omega != nullptr) {
          Eigen::Map<Vector3>(omega + 3 * (first + i)) =
              axes.named_from_principal * m_row.cwiseProduct(inverse_moments);
        }
      }
    }
  });
}

/// Bodies side by side against times, both broadcast to `whole`: of eight bodies each answers at the same index along
/// the axes along which the bodies do not change.
void broadcast_side_by_side(const MotionObject& self, const Elapsed& times, const Shape& whole, const StateArrays& out,
                            unsigned threads) {
  const std::size_t axes = whole.size();
  const std::vector<std::ptrdiff_t> body_stride = strides_in(whole, self.shape);
  const std::vector<std::ptrdiff_t> time_stride =
      times.scalar ? std::vector<std::ptrdiff_t>(axes, 0) : strides_in(whole, times.high.shape);
  const std::vector<std::ptrdiff_t> row_stride = strides_in(whole, whole);
  std::vector<std::size_t> of_body, free;
  std::size_t rows_of_body = 1;
  for (std::size_t i = 0; i < axes; ++i) {
    (body_stride[i] != 0 ? of_body : free).push_back(i);
    if (body_stride[i] == 0) rows_of_body *= whole[i];
  }
  const auto place = [&](const std::vector<std::size_t>& along, std::size_t number) {  // row and time
    std::ptrdiff_t row = 0, time = 0;
    for (std::size_t k = along.size(); k-- > 0;) {
      const auto index = static_cast<std::ptrdiff_t>(number % whole[along[k]]);
      number /= whole[along[k]];
      row += index * row_stride[along[k]];
      time += index * time_stride[along[k]];
    }
    return std::pair(row, time);
  };
  constexpr std::size_t in_block = FreeBodies::kBlock;
  parallel_chunks(self.side_by_side->blocks(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) {
      std::pair<std::ptrdiff_t, std::ptrdiff_t> of_lane[in_block];
      for (std::size_t lane = 0; lane < in_block; ++lane) {
        of_lane[lane] = place(of_body, std::min(block * in_block + lane, self.bodies.size() - 1));
      }
      for (std::size_t i = 0; i < rows_of_body; ++i) {
        const auto [row, time] = place(free, i);
        theta::BlockTimes at{};
        FreeBodies::BlockRows rows;
        for (std::size_t lane = 0; lane < in_block; ++lane) {
          rows[lane] = row + of_lane[lane].first;
          const std::ptrdiff_t t = time + of_lane[lane].second;
          at.high[lane] = times.scalar ? times.high_s : times.high.data[t];
          at.low[lane] = times.scalar ? times.low_s : times.low.empty() ? 0.0 : times.low[static_cast<std::size_t>(t)];
        }
        self.side_by_side->block(block, at, out, rows);
      }
    }
  });
}

/// Bodies against times, both broadcast to `whole`: each body answers its times in runs.
void broadcast_states(const MotionObject& self, const Elapsed& times, const Shape& whole, const StateArrays& out,
                      unsigned threads) {
  const std::size_t axes = whole.size();
  const std::vector<std::ptrdiff_t> body_stride = strides_in(whole, self.shape);
  const std::vector<std::ptrdiff_t> time_stride =
      times.scalar ? std::vector<std::ptrdiff_t>(axes, 0) : strides_in(whole, times.high.shape);
  const std::vector<std::ptrdiff_t> row_stride = strides_in(whole, whole);
  std::vector<std::size_t> of_body, free;  // the axes along which the body changes, and the others
  for (std::size_t i = 0; i < axes; ++i) (body_stride[i] != 0 ? of_body : free).push_back(i);
  std::size_t outer = 1, run = 1;  // a run is along the last free axis
  if (!free.empty()) run = whole[free.back()];
  for (std::size_t i = 0; i + 1 < free.size(); ++i) outer *= whole[free[i]];
  const std::ptrdiff_t run_row = free.empty() ? 1 : row_stride[free.back()];
  const std::ptrdiff_t run_time = free.empty() ? 0 : time_stride[free.back()];

  parallel_chunks(self.bodies.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> high(run_time == 1 ? 0 : run, times.high_s);
    std::vector<double> low(run_time != 1 && (times.scalar || !times.low.empty()) ? run : 0, times.low_s);
    for (std::size_t body = begin; body < end; ++body) {
      std::ptrdiff_t body_row = 0, body_time = 0;
      std::size_t rest = body;
      for (std::size_t k = of_body.size(); k-- > 0;) {
        const auto index = static_cast<std::ptrdiff_t>(rest % whole[of_body[k]]);
        rest /= whole[of_body[k]];
        body_row += index * row_stride[of_body[k]];
        body_time += index * time_stride[of_body[k]];
      }
      for (std::size_t o = 0; o < outer; ++o) {
        std::ptrdiff_t row = body_row, time = body_time;
        std::size_t left = o;
        for (std::size_t k = free.size() < 2 ? 0 : free.size() - 1; k-- > 0;) {
          const auto index = static_cast<std::ptrdiff_t>(left % whole[free[k]]);
          left /= whole[free[k]];
          row += index * row_stride[free[k]];
          time += index * time_stride[free[k]];
        }
        TimeArrays run_times;
        if (run_time == 1) {
          run_times.high = {times.high.data + time, run};
          if (!times.low.empty()) run_times.low = {times.low.data() + time, run};
        } else {
          for (std::size_t i = 0; !times.scalar && i < run; ++i) {
            const std::ptrdiff_t at = time + static_cast<std::ptrdiff_t>(i) * run_time;
            high[i] = times.high.data[at];
            if (!low.empty()) low[i] = times.low[static_cast<std::size_t>(at)];
          }
          run_times = {high, low};
        }
        StateArrays to = part_of(out, static_cast<std::size_t>(row));
        to.q_stride *= run_row;
        to.m_stride *= run_row;
        if (self.side_by_side) {
          self.side_by_side->batch(body, run_times, to);
        } else {
          self.motions[body]->batch(run_times, to);
        }
      }
    }
  });
}

nb::object array_or_made(nb::object& array, bool scalar, const double* data, std::size_t width) {
  if (!array.is_valid() && scalar) array = array_of(Shape{width}, data).array;
  return array;
}

FloatArray omega_of(StateObject& self) {
  if (!self.omega.is_valid() && !self.scalar) {
    if (self.m.is_none()) throw InputError("the rate follows from the momentum, which was not asked for");
    const MotionObject& motion = *self.motion;
    if (motion.named) {  // the arrays were the caller's
      const nb::object R = array_of(motion.named->named_from_principal).array;
      const nb::object inverse = array_of(Vector3(motion.bodies.front().principal_moments.cwiseInverse())).array;
      self.omega = (self.m.attr("__matmul__")(R) * inverse).attr("__matmul__")(R.attr("T"));
    } else {
      Shape shape = motion.shape;
      shape.push_back(3);
      auto [inverse, data] = new_array(shape);
      for (std::size_t i = 0; i < motion.bodies.size(); ++i) {
        Eigen::Map<Vector3>(data + 3 * i) = motion.bodies[i].principal_moments.cwiseInverse();
      }
      self.omega = self.m * inverse;
    }
  }
  return {array_or_made(self.omega, self.scalar, self.omega1.data(), 3)};
}

nb::object rotation_of(StateObject& self) {
  const nb::object q = array_or_made(self.q, self.scalar, self.q1.data(), 4);
  const nb::object numpy = nb::module_::import_("numpy");
  nb::object last = numpy.attr("roll")(q, -1, "axis"_a = -1);  // scalar last
  const nb::object is_nan = numpy.attr("isnan")(last).attr("any")("axis"_a = -1);
  if (const auto nans = nb::cast<std::size_t>(numpy.attr("count_nonzero")(is_nan)); nans != 0) {
    throw InputError(
        fmt::format("{} of {} attitudes are NaN, since their times are; a Rotation has none: take `q`, or "
                    "leave these times out",
                    nans, nb::cast<std::size_t>(is_nan.attr("size"))));
  }
  if (nb::cast<int>(last.attr("ndim")) > 2) last = last.attr("reshape")(-1, 4);
  return nb::module_::import_("scipy.spatial.transform").attr("Rotation").attr("from_quat")(last);
}

bool has_momentum_unit(const StateObject& self) {
  return self.motion && self.motion->moving && self.motion->moving->body.inertia->absolute;
}

}  // namespace

StateObject state_at_time(const std::shared_ptr<const MotionObject>& self, double high_s, double low_s) {
  StateObject state;
  state.motion = self;
  state.t_s = high_s + low_s;
  const State s = self->motions.front()->at(high_s, low_s);
  const FreeBody& body = self->bodies.front();
  state.m1 = s.momentum_body;
  state.omega1 = s.momentum_body.cwiseProduct(body.principal_moments.cwiseInverse());
  if (self->named) {
    state.q1 = scalar_first(s.q_inertial_from_body * self->named->q_principal_from_named);
    state.m1 = self->named->named_from_principal * state.m1;
    state.omega1 = self->named->named_from_principal * state.omega1;
  } else {
    state.q1 = scalar_first(s.q_inertial_from_body);
  }
  return state;
}

StateObject states_at(const std::shared_ptr<const MotionObject>& self, const nb::object& t, const nb::object& out,
                      unsigned threads) {
  const Elapsed times = elapsed_of(t, self->epoch());
  if (times.scalar && self->shape.empty() && out.is_none()) return state_at_time(self, times.high_s, times.low_s);
  StateObject state;
  state.motion = self;
  state.scalar = false;
  const Shape whole = broadcast(self->shape, times.scalar ? Shape{} : times.high.shape, "bodies and times");
  if (times.scalar) {
    state.t_s = times.high_s + times.low_s;
  } else {
    state.t = times.high.array;
  }
  Output output = output_for(out, whole, times.high.array);
  const std::size_t count = count_of(whole);
  if (self->named) {
    double* omega = nullptr;
    if (out.is_none()) {
      Shape rows = whole;
      rows.push_back(3);
      auto [array, data] = new_array(rows);
      state.omega = std::move(array);
      omega = data;
    }
    const nb::gil_scoped_release others_go_on;
    const std::span<const double> high = times.scalar ? std::span(&times.high_s, 1) : std::span(times.high.data, count);
    const std::span<const double> low = times.scalar ? std::span(&times.low_s, 1) : std::span(times.low);
    named_states(*self, {high, low}, output.arrays, omega, threads);
  } else if (self->shape.empty() && !times.scalar) {
    const nb::gil_scoped_release others_go_on;
    const TimeArrays instants{{times.high.data, count}, times.low};
    if (threads == 1) {
      self->motions.front()->batch(instants, output.arrays);
    } else {
      batch_threads(*self->motions.front(), instants, output.arrays, threads);
    }
  } else {
    const nb::gil_scoped_release others_go_on;
    const bool few_times = count / std::max<std::size_t>(1, self->bodies.size()) < FreeBodies::kManyTimes;
    (self->side_by_side && few_times ? broadcast_side_by_side : broadcast_states)(*self, times, whole, output.arrays,
                                                                                  threads);
  }
  state.q = std::move(output.q);
  state.m = std::move(output.m);
  return state;
}

void bind_state(nb::module_& m) {
  nb::class_<StateObject>(
      m, "State",
      "Attitude, rate and momentum at a time or an array of times: arrays of the shape of the times "
      "(bodies and times broadcast against each other), and one more axis.")
      .def_prop_ro(
          "q", [](StateObject& self) { return FloatArray{array_or_made(self.q, self.scalar, self.q1.data(), 4)}; },
          "Attitude, v_frame = q v_body q*, scalar first: (..., 4). Its sign is continuous in time.")
      .def_prop_ro("omega", &omega_of, "Angular velocity, rad/s, body axes: (..., 3).")
      .def_prop_ro(
          "momentum",
          [](StateObject& self) {
            if (!self.motion) throw InputError("an attitude history has no momentum");
            if (!self.scalar && self.m.is_none()) throw InputError("the momentum was not asked for");
            return FloatArray{array_or_made(self.m, self.scalar, self.m1.data(), 3)};
          },
          "Angular momentum, body axes: (..., 3). `units` says in what.")
      .def_prop_ro(
          "rotation", &rotation_of, nb::sig("def rotation(self) -> scipy.spatial.transform.Rotation"),
          "The attitude as a scipy Rotation from the body to the frame; more than one axis of rows becomes one.")
      .def_prop_ro(
          "t",
          [](const StateObject& self) -> nb::object {
            return self.t.is_valid() ? self.t : nb::object(nb::float_(self.t_s));
          },
          nb::sig("def t(self) -> float | numpy.typing.NDArray[numpy.float64]"),
          "The times, in seconds from the epoch, as TT counts them.")
      .def_prop_ro(
          "epoch", [](const StateObject& self) { return self.motion ? self.motion->epoch() : self.epoch; },
          "From which the times count, or None.")
      .def_prop_ro(
          "frame",
          [](const StateObject& self) -> std::optional<std::string> {
            if (self.motion && self.motion->moving) return std::string(name(self.motion->moving->frame));
            return self.frame.empty() ? std::nullopt : std::optional(self.frame);
          },
          "The inertial frame of the attitude, or None.")
      .def_prop_ro(
          "axes",
          [](const StateObject& self) {
            return std::string(self.motion && !self.motion->moving ? "principal" : "named");
          },
          "The body axes: 'named' in the body's file, or 'principal'.")
      .def_prop_ro(
          "units",
          [](const StateObject& self) {
            nb::dict units;
            units["q"] = "";
            units["omega"] = "rad / s";
            if (self.motion)
              units["momentum"] = has_momentum_unit(self) ? "kg m2 rad / s" : "(unit of inertia) rad / s";
            units["t"] = "s";
            return units;
          },
          nb::sig("def units(self) -> dict[str, str]"))
      .def("__repr__", [](const StateObject& self) {
        if (self.scalar) return fmt::format("<State at {} s>", self.t_s);
        return fmt::format("<State of shape {}>", nb::cast<std::string>(self.q.attr("shape").attr("__repr__")()));
      });
}

}  // namespace polhode::python
