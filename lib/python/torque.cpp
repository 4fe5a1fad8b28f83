#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/read/trajectory_file.hpp"
#include "polhode/torque/torques.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

Trajectory table_of(const Given<Numbers>& times_s, const Given<Numbers>& positions_m,
                    const std::optional<Given<Numbers>>& velocities_m_s, int degree) {
  const std::size_t count = times_s->size();
  const auto rows = [count](const Given<Numbers>& numbers, const char* what) {
    if (numbers->shape != Shape{count, 3}) throw InputError(fmt::format("{} of shape ({}, 3) are wanted", what, count));
    std::vector<Vector3> vectors;
    for (std::size_t i = 0; i < count; ++i) vectors.emplace_back(numbers->data + 3 * i);
    return vectors;
  };
  OrbitTable table;
  table.times_s.assign(times_s->data, times_s->data + count);
  table.positions_m = rows(positions_m, "positions");
  if (velocities_m_s) table.velocities_m_s = rows(*velocities_m_s, "velocities");
  table.degree = degree;
  return Trajectory(TabulatedOrbit({std::move(table)}));
}

Scene make_scene(const std::string& name, const BodyObject& body, const std::vector<Torque>& torques,
                 const std::string& frame_name, double before_s, double after_s, const Given<PlaneAngle>& accuracy,
                 const std::string& source) {
  Scene scene;
  scene.name = name;
  scene.source = source;
  scene.body = body.body();
  scene.frame = inertial_frame(frame_name);
  free_body(scene.body, scene.frame);  // says what the body lacks
  for (const Torque& torque : torques) {
    const bool needs_absolute =
        std::visit([](const auto& one) { return std::decay_t<decltype(one)>::needs_absolute_inertia; }, torque);
    if (needs_absolute && !scene.body.inertia->absolute) {
      throw InputError(fmt::format("{}: it needs an inertia in kg m2, the body has ratios", torque_name(torque)));
    }
    scene.torque_names.emplace_back(torque_name(torque));
  }
  scene.torques = Torques(torques);
  if (!(before_s >= 0.0 && after_s >= 0.0)) throw InputError("'before' and 'after' are spans of 0 s or more");
  scene.first_s = 0.0 - before_s;
  scene.last_s = after_s;
  scene.accuracy_rad = accuracy->rad;
  return scene;
}

Plan plan_of_scene(const SceneObject& self, bool full) {
  const nb::gil_scoped_release others_go_on;
  return plan_of(self.scene, full);
}

std::shared_ptr<MotionObject> motion_of(const SceneObject& self, bool full,
                                        std::optional<std::size_t> most_evaluations) {
  auto moving = [&] {
    const nb::gil_scoped_release others_go_on;
    return std::make_shared<BodyInMotion>(planned_motion_of(self.scene, full, most_evaluations));
  }();
  auto motion = motion_object(moving, nullptr);
  motion->account = moving->account(moving->first_s, moving->last_s);
  return motion;
}

}  // namespace

void bind_torque(nb::module_& m) {
  nb::class_<Trajectory>(m, "Orbit", "The way of a body about another mass, from that mass, in inertial axes.")
      .def_static(
          "kepler",
          [](double mu, double periapsis_m, double eccentricity, double periapsis_time_s,
             const Given<Numbers>& to_periapsis, const Given<Numbers>& normal) {
            return Trajectory(KeplerElements{mu, periapsis_m, eccentricity, periapsis_time_s,
                                             to_periapsis->vector3("to_periapsis"), normal->vector3("normal")});
          },
          "mu"_a, "periapsis_m"_a, "eccentricity"_a, "periapsis_time_s"_a, "to_periapsis"_a, "normal"_a,
          "Ellipse, parabola or hyperbola: mu in m3/s2, the time of periapsis in seconds from the body's epoch, the "
          "directions of periapsis and of the orbit's normal. Raises InputError.")
      .def_static("table", &table_of, "times_s"_a, "positions_m"_a, "velocities_m_s"_a = nb::none(), "degree"_a = 7,
                  "From positions (n, 3) and perhaps velocities (n, 3) at times in seconds from the body's epoch: "
                  "interpolated by Hermite's polynomials of that degree, without velocities by Lagrange's.")
      .def_static(
          "read",
          [](const Given<FileName>& path, const std::string& centre, const Given<When>& epoch,
             const std::string& frame_name, const std::optional<std::string>& table_frame) {
            TrajectoryRequest request;
            request.centre = centre;
            request.frame = inertial_frame(frame_name);
            if (table_frame) request.table_frame = frame(*table_frame);
            request.zero = epoch->instant;
            return Trajectory(read_trajectory(path->path, request));
          },
          "path"_a, "centre"_a, "epoch"_a, "frame"_a = "ICRF", "table_frame"_a = nb::none(),
          "From a CCSDS OEM or a table: about `centre`, in an inertial frame, for a body with this epoch. "
          "`table_frame` is "
          "that of a table of text, if not `frame`. Raises InputError, FileError.")
      .def(
          "__call__",
          [](const Trajectory& self, double t_s) {
            const auto state = self.state(t_s);
            return std::pair(array_of(state.position_m), array_of(state.velocity_m_s));
          },
          "t_s"_a, "Position (m) and velocity (m/s) at seconds from the body's epoch.");

  nb::class_<Torque>(
      m, "Torque",
      "What turns a body from outside, or loses its energy. Vectors and tensors in \"body axes\" are in the "
      "axes that the body's inertia is named in; times are seconds from its epoch.")
      .def_static(
          "gravity_gradient", [](double mu, const Trajectory& orbit) { return Torque(GravityGradient(mu, orbit)); },
          "mu"_a, "orbit"_a, "Of a point mass (mu in m3/s2) on the body's second moments.")
      .def_static(
          "constant",
          [](const Given<Numbers>& torque, const std::string& axes) {
            if (axes != "body" && axes != "frame") throw InputError("the axes are 'body' or 'frame'");
            return Torque(ConstantTorque{torque->vector3("torque"),
                                         axes == "body" ? ConstantTorque::Axes::body : ConstantTorque::Axes::inertial});
          },
          "torque"_a, "axes"_a = "body", "N m, in 'body' axes or in those of the inertial 'frame'.")
      .def_static(
          "pulse",
          [](double start_s, double duration_s, const Given<Numbers>& torque) {
            return Torque(ThrusterPulse{start_s, duration_s, torque->vector3("torque")});
          },
          "start_s"_a, "duration_s"_a, "torque"_a, "N m in body axes while a thruster fires.")
      .def_static(
          "damping",
          [](const Given<Numbers>& coefficients) {
            if (coefficients->shape == Shape{3, 3}) {
              LinearDamping damping{Vector3(Vector3::Zero())};
              damping.coefficients = coefficients->matrix3("coefficients");
              return Torque(damping);
            }
            if (coefficients->shape.empty())
              return Torque(LinearDamping(Vector3(Vector3::Constant(*coefficients->data))));
            return Torque(LinearDamping(coefficients->vector3("coefficients")));
          },
          "coefficients"_a, "Torque -D omega: D in N m s as one number, three along the body axes, or a matrix.")
      .def_static(
          "eddy_currents",
          [](const Given<Numbers>& magnetic_tensor, const Given<Numbers>& dipole_axis, double dipole_t_m3,
             const Trajectory& orbit) {
            return Torque(EddyCurrents{magnetic_tensor->matrix3("magnetic_tensor"),
                                       dipole_axis->vector3("dipole_axis").normalized(), dipole_t_m3, orbit});
          },
          "magnetic_tensor"_a, "dipole_axis"_a, "dipole_t_m3"_a, "orbit"_a,
          "Of a dipole's field in a conductor: tensor in S m4 (body axes), the dipole's direction (southward for the "
          "Earth), its field on the equator times the distance cubed (Earth 7.8e15 T m3).")
      .def_static(
          "dissipation",
          [](double quality_factor, const Given<Numbers>& moments, double momentum) {
            return Torque(
                InternalDissipation::from_quality_factor(quality_factor, moments->vector3("moments"), momentum));
          },
          "quality_factor"_a, "principal_moments"_a, "momentum"_a,
          "Loss of energy inside a body of these moments and this length of the momentum: by 2 pi/Q of itself per "
          "turn.")
      .def_static(
          "sunlight",
          [](const TriangleMesh& mesh, const Trajectory& orbit, double specular, double diffuse) {
            return Torque(Sunlight(mesh, {specular, diffuse}, orbit));
          },
          "mesh"_a, "orbit"_a, "specular"_a = 0.0, "diffuse"_a = 1.0,
          "Pressure of light and of reflected light and heat on a mesh in metres about the centre of mass; `orbit` "
          "from "
          "the Sun; shares of the light mirrored and scattered.")
      .def_prop_ro("name", [](const Torque& self) { return std::string(torque_name(self)); })
      .def(
          "__call__",
          [](const Torque& self, double t_s, const Given<Attitude>& q, const Given<Rates>& omega,
             const Given<Numbers>& principal_moments) {
            Torques all({self});
            const Torques at_work = all.jumps_s().empty() ? all : all.during(t_s);
            const auto terms = at_work.at(t_s, Quaternion(q->q.normalized()), principal_moments->vector3("moments"));
            return array_of(terms.torque(omega->vector3("omega")));
          },
          "t_s"_a, "q"_a, "omega"_a, "principal_moments"_a,
          "The torque from outside at a time, attitude and rate, body axes being the principal ones. Shape (3,).")
      .def("__repr__", [](const Torque& self) { return fmt::format("<Torque {}>", torque_name(self)); });

  nb::class_<PlannedEffect>(m, "PlannedEffect",
                            "What one torque can do over a span, from above, and what became of it.")
      .def_ro("name", &PlannedEffect::name)
      .def_ro("periodic_rad", &PlannedEffect::periodic_rad, "Swing within a turn; None for a body at rest.")
      .def_ro("secular_rad", &PlannedEffect::secular_rad, "Bound at the end of the span; None for a body at rest.")
      .def_ro("kept", &PlannedEffect::kept)
      .def_ro("why", &PlannedEffect::why)
      .def("__repr__", [](const PlannedEffect& self) {
        return fmt::format("<PlannedEffect {}: {} ({})>", self.name, self.kept ? "kept" : "dropped", self.why);
      });
  nb::class_<Plan>(m, "Plan", "The cheapest sufficient model of a motion, and what is expected of it.")
      .def_ro("effects", &Plan::effects)
      .def_ro("model", &Plan::model)
      .def_ro("why", &Plan::why)
      .def_ro("error_rad", &Plan::error_rad, "At the most, if the propagation succeeds.")
      .def_ro("dropped_rad", &Plan::dropped_rad, "Bound of all dropped effects together.")
      .def_ro("tolerance_rad", &Plan::tolerance_rad, "Of the propagation, if torques are kept.")
      .def_ro("torque_evaluations", &Plan::torque_evaluations,
              "Expected within a factor of 2; None: it cannot be told.")
      .def_ro("cost_why", &Plan::cost_why)
      .def_ro("sensitivity", &Plan::sensitivity, "rad of attitude at the end per relative change of the momentum.")
      .def("__repr__", [](const Plan& self) { return fmt::format("<Plan: {} ({})>", self.model, self.why); });

  nb::class_<SceneObject>(m, "Scene", "A body, what acts on it, over which span, and how well it is wanted.")
      .def(
          "__init__",
          [](SceneObject* self, const std::string& name, const BodyObject& body, const std::vector<Torque>& torques,
             const std::string& frame, const Given<Duration>& before, const Given<Duration>& after,
             const Given<PlaneAngle>& accuracy, const std::string& source) {
            new (self) SceneObject{
                make_scene(name, body, torques, frame, before->seconds.high, after->seconds.high, accuracy, source),
                {}};
          },
          "name"_a, "body"_a, "torques"_a, nb::kw_only(), "frame"_a = "ICRF", "before"_a = 0.0, "after"_a = 0.0,
          "accuracy"_a, "source"_a = "",
          "Without a file: a complete body, torques, the span before and after its epoch (s, or '30 d'), the wanted "
          "accuracy of the attitude (rad, or '0.1 deg'). Raises InputError.")
      .def_prop_ro("name", [](const SceneObject& self) { return self.scene.name; })
      .def_prop_ro("source", [](const SceneObject& self) { return self.scene.source; })
      .def_prop_ro("body",
                   [](const SceneObject& self) {
                     return BodyObject{{self.scene.body, std::nullopt, false}, {}};
                   })
      .def_prop_ro("frame", [](const SceneObject& self) { return std::string(name(self.scene.frame)); })
      .def_prop_ro("torques", [](const SceneObject& self) { return self.scene.torques.list(); })
      .def_prop_ro(
          "torque_names", [](const SceneObject& self) { return self.scene.torque_names; },
          "With the names of their orbits.")
      .def_prop_ro(
          "span", [](const SceneObject& self) { return std::pair(self.scene.first_s, self.scene.last_s); },
          "First and last second, from the epoch.")
      .def_prop_ro("accuracy_rad", [](const SceneObject& self) { return self.scene.accuracy_rad; })
      .def_prop_ro("path", [](const SceneObject& self) { return self.path; })
      .def("plan", &plan_of_scene, "full"_a = false,
           "Which effects matter, by bounds, and which model; `full` keeps every effect, at 1e-9 rad. Raises "
           "InputError.")
      .def("motion", &motion_of, "full"_a = false, "max_evaluations"_a = nb::none(),
           "The motion as planned, over the span. Raises InputError, and ComputationError where the planned error is "
           "not "
           "reached within so many torque evaluations.")
      .def("__repr__", [](const SceneObject& self) { return fmt::format("<Scene {}>", self.scene.name); });
}

}  // namespace polhode::python
