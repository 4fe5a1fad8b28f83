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
#include "python/states.hpp"

namespace polhode::python {
namespace {

std::shared_ptr<MotionObject> free_motions(const Given<Numbers>& moments, const Given<Attitudes>& q,
                                           const Given<Numbers>& momentum, const std::string& method_name,
                                           unsigned threads) {
  auto self = std::make_shared<MotionObject>();
  const Shape of_moments = leading(*moments, 3, "moments"), of_q = leading(*q, 4, "q"),
              of_momentum = leading(*momentum, 3, "momentum");
  self->method = &method(method_name);
  self->shape = broadcast(broadcast(of_moments, of_q, "moments and q"), of_momentum, "bodies and momenta");
  const std::size_t count = count_of(self->shape), axes = self->shape.size();
  self->bodies.resize(count);
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
    }
  });
  make_free_motions(*self, threads);
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

void make_free_motions(MotionObject& self, unsigned threads) {
  if (!self.shape.empty() && self.method == &method("auto")) {
    self.side_by_side.emplace(BodyArrays::of_bodies(self.bodies), BodiesOptions{.thread_count = threads});
    return;
  }
  self.motions.resize(self.bodies.size());
  parallel_chunks(self.bodies.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t body = begin; body < end; ++body) self.motions[body] = self.method->make(self.bodies[body]);
  });
}

std::shared_ptr<MotionObject> motion_object(std::shared_ptr<const BodyInMotion> moving, const Method* method) {
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

  nb::class_<MotionObject> motion_class(
      m, "Motion",
      "The motion of a body, built once and answered at any time. `Body.motion` and `Scene.motion` make "
      "it in named axes; FreeMotion and TorquedMotion in principal ones. Several threads may ask.");
  motion_class
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
           "Partial derivatives of the motion at t, an array (..., 6, 9): rows theta (a small turn of the "
           "attitude in body axes, rad) and the momentum; columns the same two at the epoch, and the principal moments "
           "I1 <= I2 <= I3; under torques also their parameters, as partial_columns names them. In the axes of the "
           "states. A derivative by a moment holds attitude and momentum at the epoch, so that the rate changes. Of a "
           "free motion they are exact.")
      .def_prop_ro("partial_columns", &partial_columns_of, nb::sig("def partial_columns(self) -> list[str]"),
                   "Names of the columns of partials().")
      .def(
          "condition_number",
          [](const MotionObject& self, const nb::object& t) {
            if (self.method == nullptr || !self.shape.empty())
              throw InputError("the free motion of one body is wanted");
            return condition_number(self.bodies.front(), seconds_in(self, t));
          },
          "t"_a, nb::sig("def condition_number(self, t: typing.Any) -> float"),
          "How far the attitude moves, in rad, per relative change of a moment or of the momentum, at t.")
      .def("__repr__", [](const MotionObject& self) {
        return fmt::format("<Motion of {}>", self.moving ? self.moving->body.name
                                             : self.shape.empty()
                                                 ? std::string("a body")
                                                 : fmt::format("({}) bodies", fmt::join(self.shape, ", ")));
      });
  bind_observe(motion_class);

  m.def("FreeMotion", &free_motions, "moments"_a, "q"_a, "momentum"_a, nb::kw_only(), "method"_a = "auto",
        "threads"_a = 1U,
        "The free motion of a body, or of an array of them, in their principal axes. moments (..., 3): I1 <= I2 <= I3, "
        "any "
        "unit; q (..., 4): attitude at t = 0, scalar first, body to inertial, any length but 0, or a scipy Rotation; "
        "momentum (..., 3), principal "
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
