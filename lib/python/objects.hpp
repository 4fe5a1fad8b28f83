#pragma once

// The objects of Python that more than one source of the extension module knows.

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "polhode/motion/free_bodies.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/motion/torqued_partials.hpp"
#include "polhode/read/input_formats.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/session/body_in_motion.hpp"
#include "python/python.hpp"

namespace polhode::python {

/// Body and AttitudeHistory: both are what a file says, or was said without one.
struct BodyObject {
  BodyAndHistory file;
  std::string path;

  const Body& body() const { return file.body; }
};
struct HistoryObject {
  BodyAndHistory file;  ///< with a history
  std::string path;

  const AttitudeHistory& history() const { return *file.history; }
};

struct SceneObject {
  Scene scene;
  std::string path;
};

/// Motion: of one body, or of an array of bodies in their principal axes.
struct MotionObject : std::enable_shared_from_this<MotionObject> {
  Shape shape;  ///< of the array; empty: one body
  std::vector<FreeBody> bodies;
  std::vector<std::shared_ptr<const Motion>> motions;  ///< one per body, unless `side_by_side`
  std::optional<const FreeBodies> side_by_side;        ///< of an array of free bodies
  const Method* method = nullptr;                      ///< of a free motion
  std::optional<MotionAccount> account;                ///< of one under torques
  std::shared_ptr<const BodyInMotion> moving;          ///< null: of bodies without epoch and frame
  std::optional<double> accuracy_rad;                  ///< wanted of a scene's

  /// How states come into the axes that the body's file names; absent where they are the principal ones.
  struct NamedAxes {
    Quaternion q_principal_from_named;
    Matrix3 named_from_principal;
  };
  std::optional<NamedAxes> named;

  struct StatePartialsOnce {
    std::once_flag made;
    StatePartialsSource partials;
  };
  std::shared_ptr<StatePartialsOnce> state_partials = std::make_shared<StatePartialsOnce>();

  std::optional<Instant> epoch() const { return moving ? std::optional(moving->body.state->epoch) : std::nullopt; }
};

/// Makes the motions of `bodies`, which are free, by `method`.
void make_free_motions(MotionObject& self, unsigned threads);

/// The motion of a body that is known with its epoch and frame.
std::shared_ptr<MotionObject> motion_object(std::shared_ptr<const BodyInMotion> moving, const Method* method);

/// State: at one time, or at an array of them.
struct StateObject {
  std::shared_ptr<const MotionObject> motion;  ///< null: of an attitude history
  std::optional<Instant> epoch;
  std::string frame;  ///< empty: there is none
  bool scalar = true;
  double t_s = 0.0;
  Eigen::Vector4d q1;  ///< of a scalar
  Vector3 m1, omega1;
  nb::object t, q, m, omega;  ///< arrays; those of a scalar are made when asked for
};

/// Motion.partials(): an array (..., 6, 9) of a free motion, in the axes of its states.
FloatArray partials_of(const MotionObject& motion, const nb::object& t, unsigned threads);
std::vector<std::string> partial_columns_of(const MotionObject& motion);

/// Motion.observe() and Motion.observe_partials().
void bind_observe(nb::class_<MotionObject>& motion);

/// The attitude of anything that has one, v_icrf = q v_body q*, for comparisons.
std::function<Quaternion(Instant)> q_icrf_of(const MotionObject& motion);

}  // namespace polhode::python
