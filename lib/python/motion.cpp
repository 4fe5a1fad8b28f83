#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/motion/conditioning.hpp"
#include "polhode/motion/events.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/read/case_file.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

constexpr std::size_t kBlock = 512;  // rows that are turned into named axes while they are in the cache

std::size_t count_of(std::span<const std::size_t> shape) {
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  return count;
}

/// What numpy's rules make of two shapes. Throws InputError where they do not go together.
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

/// Strides, in elements, of an array of this shape that is broadcast to `whole`: 0 along the axes that it has not.
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

/// The leading axes of shape + (last,); `last` must be right.
Shape leading(const Numbers& numbers, std::size_t last, const char* what) {
  if (numbers.shape.empty() || numbers.shape.back() != last) {
    throw InputError(
        fmt::format("{} has the shape ({}), (…, {}) is wanted", what, fmt::join(numbers.shape, ", "), last));
  }
  return {numbers.shape.begin(), numbers.shape.end() - 1};
}

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
  return rows;
}

Output output_for(const nb::object& out, const Shape& shape) {
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
  return output;
}

StateArrays from_row(StateArrays arrays, std::ptrdiff_t row) {
  for (double*& q : arrays.q) q += row * arrays.q_stride;
  for (double*& m : arrays.m) m = m == nullptr ? nullptr : m + row * arrays.m_stride;
  return arrays;
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
      self.motions.front()->batch(
          {times.high.subspan(first, count), times.low.empty() ? times.low : times.low.subspan(first, count)},
          StateArrays::of_structures(q_rows, m_rows));
      const StateArrays to = from_row(out, static_cast<std::ptrdiff_t>(first));
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

  parallel_chunks(self.motions.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
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
        StateArrays to = from_row(out, row);
        to.q_stride *= run_row;
        to.m_stride *= run_row;
        self.motions[body]->batch(run_times, to);
      }
    }
  });
}

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
  Output output = output_for(out, whole);
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
    broadcast_states(*self, times, whole, output.arrays, threads);
  }
  state.q = std::move(output.q);
  state.m = std::move(output.m);
  return state;
}

// --- State ----------------------------------------------------------------------------------------------------------

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
  if (nb::cast<int>(last.attr("ndim")) > 2) last = last.attr("reshape")(-1, 4);
  return nb::module_::import_("scipy.spatial.transform").attr("Rotation").attr("from_quat")(last);
}

bool has_momentum_unit(const StateObject& self) {
  return self.motion && self.motion->moving && self.motion->moving->body.inertia->absolute;
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

// --- Motion ---------------------------------------------------------------------------------------------------------

std::shared_ptr<MotionObject> free_motions(const Given<Numbers>& moments, const Given<Numbers>& q,
                                           const Given<Numbers>& momentum, const std::string& method_name,
                                           unsigned threads) {
  auto self = std::make_shared<MotionObject>();
  const Shape of_moments = leading(*moments, 3, "moments"), of_q = leading(*q, 4, "q"),
              of_momentum = leading(*momentum, 3, "momentum");
  self->method = &method(method_name);
  self->shape = broadcast(broadcast(of_moments, of_q, "moments and q"), of_momentum, "bodies and momenta");
  const std::size_t count = count_of(self->shape), axes = self->shape.size();
  self->bodies.resize(count);
  self->motions.resize(count);
  const auto moments_stride = strides_in(self->shape, of_moments), q_stride = strides_in(self->shape, of_q),
             m_stride = strides_in(self->shape, of_momentum);
  const nb::gil_scoped_release others_go_on;
  parallel_chunks(count, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t body = begin; body < end; ++body) {
      std::ptrdiff_t i = 0, j = 0, k = 0;
      std::size_t rest = body;
      for (std::size_t axis = axes; axis-- > 0;) {
        const auto index = static_cast<std::ptrdiff_t>(rest % self->shape[axis]);
        rest /= self->shape[axis];
        i += index * moments_stride[axis];
        j += index * q_stride[axis];
        k += index * m_stride[axis];
      }
      FreeBody& one = self->bodies[body];
      one.principal_moments = Vector3(moments->data + 3 * i);
      one.q_inertial_from_body = from_scalar_first(Eigen::Map<const Eigen::Vector4d>(q->data + 4 * j));
      one.momentum_body = Vector3(momentum->data + 3 * k);
      self->motions[body] = self->method->make(one);
    }
  });
  return self;
}

std::shared_ptr<MotionObject> torqued_motion(const FreeBody& body, const Torques& torques, double first_s,
                                             double last_s, double tolerance_rad, const std::string& method_name,
                                             std::optional<std::size_t> max_evaluations) {
  auto self = std::make_shared<MotionObject>();
  self->bodies = {body};
  const nb::gil_scoped_release others_go_on;
  const TorquedOptions options{tolerance_rad, first_s, last_s, method_name,
                               max_evaluations.value_or(usual_torque_evaluations(torques))};
  auto motion = std::make_shared<TorquedMotion>(body, torques, options);
  if (motion->outcome() == Outcome::stopped) {
    throw ComputationError(
        fmt::format("stopped: {} s to {} s were reached after {} torque evaluations (method {}); allow more by "
                    "max_evaluations, or ask for a shorter span or a larger tolerance",
                    motion->first_s(), motion->last_s(), motion->torque_evaluations(), motion->method()));
  }
  if (motion->outcome() != Outcome::done) {
    throw ComputationError(fmt::format("{}: the estimated error is {:.1e} rad, {:.1e} rad was asked for (method {})",
                                       outcome_name(motion->outcome()), motion->error_rad(), tolerance_rad,
                                       motion->method()));
  }
  self->account = motion->account();
  self->motions = {std::move(motion)};
  return self;
}

const ThetaMotion& theta_of(const MotionObject& self, std::optional<ThetaMotion>& own) {
  if (!self.shape.empty()) throw InputError("one body is wanted, not an array of them");
  if (self.method == nullptr) throw InputError("a free motion is wanted, not one under torques");
  const auto* theta = dynamic_cast<const ThetaMotion*>(self.motions.front().get());
  return theta != nullptr ? *theta : own.emplace(self.bodies.front());
}

double seconds_in(const MotionObject& self, const nb::object& t) {
  const Elapsed elapsed = elapsed_of(t, self.epoch());
  if (!elapsed.scalar) throw InputError("one time is wanted");
  return elapsed.high_s + elapsed.low_s;
}

MotionAccount account_of(const MotionObject& self, const nb::object& first, const nb::object& last) {
  if (self.account) return *self.account;
  if (!self.shape.empty()) throw InputError("one body is wanted, not an array of them");
  return free_motion_account(*self.method, self.bodies.front(), seconds_in(self, first), seconds_in(self, last));
}

std::optional<std::pair<double, double>> pass_of(const MotionObject& self, const Given<Numbers>& axis,
                                                 const Given<Numbers>& direction, const Given<PlaneAngle>& within,
                                                 const nb::object& after, const nb::object& until) {
  std::optional<ThetaMotion> own;
  const ThetaMotion& motion = theta_of(self, own);
  Vector3 principal = axis->vector3("axis").normalized();
  if (self.named) principal = self.named->named_from_principal.transpose() * principal;
  const auto pass = next_pass(motion, self.bodies.front(), principal, direction->vector3("direction").normalized(),
                              within->rad, seconds_in(self, after), seconds_in(self, until));
  if (!pass) return std::nullopt;
  return std::pair(pass->time_s, pass->angle_rad);
}

}  // namespace

std::shared_ptr<MotionObject> motion_object(std::shared_ptr<const tools::BodyInMotion> moving, const Method* method) {
  auto self = std::make_shared<MotionObject>();
  self->bodies = {moving->free};
  self->motions = {moving->motion};
  self->method = method;
  const Inertia& inertia = *moving->body.inertia;
  if (!inertia.named_from_principal.isIdentity(0.0)) {
    self->named = {inertia.q_named_from_principal().conjugate(), inertia.named_from_principal};
  }
  self->moving = std::move(moving);
  return self;
}

std::function<Quaternion(Instant)> q_icrf_of(const MotionObject& self) {
  if (!self.moving) throw InputError("a motion without epoch and frame cannot be compared with dates");
  return [moving = self.moving, q_icrf_from_frame = q_icrf_from(self.moving->frame)](Instant time) {
    const Seconds elapsed = time - moving->body.state->epoch;
    return q_icrf_from_frame *
           named_state(moving->free, moving->motion->at(elapsed.high, elapsed.low)).q_inertial_from_named;
  };
}

void bind_motion(nb::module_& m) {
  bind_state(m);

  nb::class_<MotionAccount>(m, "Account", "What was done to compute a motion, and what it promises.")
      .def_ro("method", &MotionAccount::method)
      .def_ro("max_error_rad", &MotionAccount::max_error_rad, "Promised for the attitude; None: nothing is.")
      .def_ro("error_meaning", &MotionAccount::error_meaning)
      .def_ro("torque_evaluations", &MotionAccount::torque_evaluations)
      .def("__repr__", [](const MotionAccount& self) {
        return fmt::format("<Account: {}, {}>", self.method,
                           self.max_error_rad ? fmt::format("{:.1e} rad", *self.max_error_rad) : "nothing promised");
      });

  nb::class_<MotionObject>(
      m, "Motion",
      "The motion of a body, built once and answered at any time. `Body.motion` and `Scene.motion` make "
      "it in named axes; FreeMotion and TorquedMotion in principal ones. Several threads may ask.")
      .def(
          "__call__",
          [](const std::shared_ptr<MotionObject>& self, double t) {
            if (!self->shape.empty()) throw nb::next_overload();
            return state_at_time(self, t, 0.0);
          },
          nb::arg("t").noconvert(), nb::sig("def __call__(self, t: float, /) -> State"))
      .def("__call__", &states_at, "t"_a, nb::kw_only(), "out"_a = nb::none(), "threads"_a = 1U,
           nb::sig("def __call__(self, t: typing.Any, *, out: tuple[numpy.typing.NDArray[numpy.float64], "
                   "numpy.typing.NDArray[numpy.float64] | None] | None = None, threads: int = 1) -> State"),
           "The state at t: seconds from the epoch (TT), an Instant, a date, an astropy Time, TimeDelta or Quantity, "
           "of any "
           "shape. An array of bodies is broadcast against the times by numpy's rules. `out` is a pair of float64 "
           "arrays "
           "(..., 4) and (..., 3) that attitude and momentum are written to, the second or None. `threads` of the "
           "processor are used, 0: all; the results are the same bits. The attitude is NaN where t is; a motion under "
           "torques raises InputError outside of its span.")
      .def_prop_ro(
          "shape", [](const MotionObject& self) { return nb::tuple(nb::cast(self.shape)); },
          nb::sig("def shape(self) -> tuple[int, ...]"), "Of the array of bodies; (): one body.")
      .def_prop_ro("epoch", &MotionObject::epoch, "Where t = 0, or None.")
      .def_prop_ro(
          "frame",
          [](const MotionObject& self) {
            return self.moving ? std::optional(std::string(name(self.moving->frame))) : std::nullopt;
          },
          "The inertial frame, or None.")
      .def_prop_ro(
          "axes", [](const MotionObject& self) { return std::string(self.moving ? "named" : "principal"); },
          "The body axes of the states: 'named' in the body's file, or 'principal'.")
      .def_prop_ro(
          "span",
          [](const MotionObject& self) {
            return self.moving && self.moving->under_torques
                       ? std::optional(std::pair(self.moving->first_s, self.moving->last_s))
                       : std::nullopt;
          },
          "First and last second that a scene's motion answers; None: any.")
      .def("account", &account_of, "first"_a = 0.0, "last"_a = 0.0,
           nb::sig("def account(self, first: typing.Any = 0.0, last: typing.Any = 0.0) -> Account"),
           "Method, promised error between two times, cost.")
      .def(
          "next_flip",
          [](const MotionObject& self, const nb::object& after) {
            std::optional<ThetaMotion> own;
            return next_flip_s(theta_of(self, own), seconds_in(self, after));
          },
          "after"_a = 0.0, nb::sig("def next_flip(self, after: typing.Any = 0.0) -> float"),
          "The first second after `after` at which the middle axis passes the plane across the momentum; inf: never. "
          "Of a "
          "free motion.")
      .def("next_pass", &pass_of, "axis"_a, "direction"_a, "within"_a, "after"_a, "until"_a,
           nb::sig("def next_pass(self, axis: numpy.typing.ArrayLike, direction: numpy.typing.ArrayLike, within: float "
                   "| str "
                   "| astropy.units.Quantity, after: typing.Any, until: typing.Any) -> tuple[float, float] | None"),
           "When the body axis first comes within an angle of an inertial direction, and the angle then: (s, rad), or "
           "None. Of a free motion.")
      .def(
          "mean_rates",
          [](const MotionObject& self) {
            std::optional<ThetaMotion> own;
            const MeanRates rates = mean_rates(theta_of(self, own));
            nb::dict out;
            out["polhode_period_s"] = rates.polhode_period_s;
            out["long_axis_precession_rad_s"] = rates.long_axis_precession_rad_s;
            out["short_axis_precession_rad_s"] = rates.short_axis_precession_rad_s;
            return out;
          },
          nb::sig("def mean_rates(self) -> dict[str, float]"), "Of a free motion, in closed form.")
      .def("partials", &partials_of, "t"_a, nb::kw_only(), "threads"_a = 1U,
           nb::sig("def partials(self, t: typing.Any, *, threads: int = 1) -> numpy.typing.NDArray[numpy.float64]"),
           "Exact partial derivatives of a free motion at t, an array (..., 6, 9): rows theta (a small turn of the "
           "attitude in body axes, rad) and the momentum; columns the same two at the epoch, and the principal moments "
           "I1 <= I2 <= I3. In the axes of the states. A derivative by a moment holds attitude and momentum at the "
           "epoch, so that the rate changes.")
      .def(
          "condition_number",
          [](const MotionObject& self, const nb::object& t) {
            if (self.method == nullptr || !self.shape.empty())
              throw InputError("the free motion of one body is wanted");
            return condition_number(self.method->make, self.bodies.front(), seconds_in(self, t));
          },
          "t"_a, nb::sig("def condition_number(self, t: typing.Any) -> float"),
          "How far the attitude moves, in rad, per relative change of a moment or of the momentum, at t.")
      .def("__repr__", [](const MotionObject& self) {
        return fmt::format("<Motion of {}>", self.moving ? self.moving->body.name
                                             : self.shape.empty()
                                                 ? std::string("a body")
                                                 : fmt::format("({}) bodies", fmt::join(self.shape, ", ")));
      });

  m.def("FreeMotion", &free_motions, "moments"_a, "q"_a, "momentum"_a, nb::kw_only(), "method"_a = "auto",
        "threads"_a = 1U,
        "The free motion of a body, or of an array of them, in their principal axes. moments (..., 3): I1 <= I2 <= I3, "
        "any "
        "unit; q (..., 4): attitude at t = 0, scalar first, body to inertial, any length but 0; momentum (..., 3), "
        "principal "
        "axes. The leading axes are broadcast. Raises InputError.");
  m.def(
      "TorquedMotion",
      [](const Given<Numbers>& moments, const Given<Attitude>& q, const Given<Numbers>& momentum,
         const std::vector<Torque>& torques, double first_s, double last_s, double tolerance_rad,
         const std::string& method_name, std::optional<std::size_t> max_evaluations) {
        return torqued_motion({moments->vector3("moments"), q->q, momentum->vector3("momentum")}, Torques(torques),
                              first_s, last_s, tolerance_rad, method_name, max_evaluations);
      },
      "moments"_a, "q"_a, "momentum"_a, "torques"_a, "first_s"_a, "last_s"_a, nb::kw_only(), "tolerance_rad"_a = 1e-9,
      "method"_a = "auto", "max_evaluations"_a = nb::none(),
      "The motion of a body under torques in its principal axes over a span that holds 0, to an error of "
      "`tolerance_rad`. "
      "Raises InputError, and ComputationError where that is not reached.");
  m.def(
      "methods",
      [] {
        std::vector<nb::dict> all;
        for (const Method& one : methods()) {
          nb::dict row;
          row["name"] = std::string(one.name);
          row["kind"] = std::string(one.kind);
          row["order"] = std::string(one.order);
          row["conserves"] = std::string(one.conserves.text);
          row["fails"] = std::string(one.fails);
          row["source"] = std::string(one.source);
          all.push_back(row);
        }
        return all;
      },
      nb::sig("def methods() -> list[dict[str, str]]"),
      "The methods of the free motion, the recommended first. (The program's `methods` lists those that they are "
      "measured "
      "against as well.)");

  nb::class_<CaseFile>(m, "Case", "A body in its principal axes at t = 0, torques, and wanted times: a case file.")
      .def_prop_ro("moments", [](const CaseFile& self) { return array_of(self.body.principal_moments); })
      .def_prop_ro("q", [](const CaseFile& self) { return array_of(self.body.q_inertial_from_body); })
      .def_prop_ro("momentum", [](const CaseFile& self) { return array_of(self.body.momentum_body); })
      .def_prop_ro("torques", [](const CaseFile& self) { return self.torques.list(); })
      .def_prop_ro("times",
                   [](const CaseFile& self) { return array_of(Shape{self.times_s.size()}, self.times_s.data()); })
      .def(
          "motion",
          [](const CaseFile& self, double tolerance_rad, const std::string& method_name,
             std::optional<std::size_t> max_evaluations) {
            if (self.torques.empty()) {
              auto motion = std::make_shared<MotionObject>();
              motion->bodies = {self.body};
              motion->method = &method(method_name);
              motion->motions = {motion->method->make(self.body)};
              return motion;
            }
            const auto [first, last] = std::minmax_element(self.times_s.begin(), self.times_s.end());
            return torqued_motion(self.body, self.torques, std::min(0.0, *first), std::max(0.0, *last), tolerance_rad,
                                  method_name, max_evaluations);
          },
          nb::kw_only(), "tolerance_rad"_a = 1e-12, "method"_a = "auto", "max_evaluations"_a = nb::none(),
          "Its motion over the wanted times, as `polhode eval` computes it.");
  m.def(
      "read_case", [](const Given<FileName>& path) { return read_case_file(path->path); }, "path"_a,
      "A case file. Raises InputError with file and line, FileError.");
}

}  // namespace polhode::python
