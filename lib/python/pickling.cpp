// Pickles and copies: what defines an object, as bytes, and the same object again.
#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <concepts>
#include <utility>
#include <variant>

#include "polhode/base/error.hpp"
#include "polhode/write/document.hpp"
#include "python/archive.hpp"

namespace polhode::python {
namespace {

// --- What is no plain struct
// ------------------------------------------------------------------------------------------

void save(Saver& to, const Trajectory& trajectory) {
  const TabulatedOrbit* const table = trajectory.table();
  const KeplerOrbit* const orbit = trajectory.orbit();
  bool is_table = table != nullptr;
  pass(to, is_table);
  if (table != nullptr) {
    auto tables = table->tables();
    pass(to, tables);
  } else if (orbit != nullptr) {
    KeplerElements elements = orbit->elements();
    pass(to, elements);
  }
}

Trajectory load_trajectory(Loader& from) {
  bool is_table = false;
  pass(from, is_table);
  if (is_table) {
    std::vector<OrbitTable> tables;
    pass(from, tables);
    return Trajectory(TabulatedOrbit(std::move(tables)));
  }
  KeplerElements elements;
  pass(from, elements);
  return elements;
}

/// Torques on one body share trajectories: they are told by their places among these.
struct Trajectories {
  std::vector<Trajectory> all;

  std::size_t place(const Trajectory& one) {
    const auto at = std::find(all.begin(), all.end(), one);
    if (at == all.end()) all.push_back(one);
    return static_cast<std::size_t>(std::find(all.begin(), all.end(), one) - all.begin());
  }
};

template <class One>
concept HasTrajectory = requires(One one) {
  { one.trajectory } -> std::same_as<Trajectory&>;
};

/// What a kind of torque is made of, besides its trajectory; the kinds that are not here have no pickle.
template <class A>
void values(A& a, GravityGradient& x) {
  pass(a, x.mu_m3_s2);
}
template <class A>
void values(A& a, ConstantTorque& x) {
  pass_all(a, x.torque, x.axes);
}
template <class A>
void values(A& a, ThrusterPulse& x) {
  pass_all(a, x.start_s, x.duration_s, x.torque_body);
}
template <class A>
void values(A& a, LinearDamping& x) {
  pass(a, x.coefficients);
}
template <class A>
void values(A& a, EddyCurrents& x) {
  pass_all(a, x.magnetic_tensor_s_m4, x.dipole_axis, x.dipole_t_m3);
}
template <class A>
void values(A& a, InternalDissipation& x) {
  pass(a, x.relaxation);
}

/// One to be filled by values().
template <class One>
One blank(const Trajectory* trajectory) {
  if constexpr (std::is_same_v<One, GravityGradient>) {
    return {0.0, *trajectory};
  } else if constexpr (std::is_same_v<One, EddyCurrents>) {
    return {Matrix3::Zero(), Vector3::UnitZ(), 0.0, *trajectory};
  } else if constexpr (std::is_same_v<One, LinearDamping>) {
    return One(Vector3(Vector3::Zero()));
  } else {
    return One{};
  }
}

void save(Saver& to, const Torque& torque, Trajectories& trajectories) {
  std::size_t kind = torque.index();
  pass(to, kind);
  std::visit(
      [&](auto one) {
        using One = decltype(one);
        if constexpr (HasTrajectory<One>) {
          std::size_t place = trajectories.place(one.trajectory);
          pass(to, place);
        }
        if constexpr (std::is_same_v<One, Sunlight>) {
          std::vector<Facet> facets = one.facets();
          double radius_m = one.ball_radius_m();
          bool eclipsed = one.second_trajectory.has_value();
          std::size_t place = eclipsed ? trajectories.place(*one.second_trajectory) : 0;
          pass_all(to, facets, eclipsed, place, radius_m);
        } else if constexpr (std::is_same_v<One, Aerodynamic>) {
          std::vector<Facet> facets = one.facets();
          ExponentialAtmosphere air = one.atmosphere();
          pass_all(to, facets, air.density_kg_m3, air.distance_m, air.scale_height_m, air.turn_rad_s);
        } else if constexpr (requires { values(to, one); }) {
          values(to, one);
        } else {
          throw nb::type_error(fmt::format("a torque '{}' cannot be pickled", One::name).c_str());
        }
      },
      torque);
}

Torque load_torque(Loader& from, const std::vector<Trajectory>& trajectories) {
  std::size_t kind = 0, index = 0;
  pass(from, kind);
  std::optional<Torque> torque;
  for_each_torque_kind([&]<class One>() {
    if (index++ != kind) return;
    const Trajectory* trajectory = nullptr;
    if constexpr (HasTrajectory<One>) {
      std::size_t place = 0;
      pass(from, place);
      trajectory = &trajectories.at(place);
    }
    if constexpr (std::is_same_v<One, Sunlight>) {
      std::vector<Facet> facets;
      double radius_m = 0.0;
      bool eclipsed = false;
      std::size_t place = 0;
      pass_all(from, facets, eclipsed, place, radius_m);
      std::optional<Sunlight::Eclipsing> eclipsing;
      if (eclipsed) eclipsing = {trajectories.at(place), radius_m};
      torque = Sunlight(facets, *trajectory, std::move(eclipsing));
    } else if constexpr (std::is_same_v<One, Aerodynamic>) {
      std::vector<Facet> facets;
      ExponentialAtmosphere air;
      pass_all(from, facets, air.density_kg_m3, air.distance_m, air.scale_height_m, air.turn_rad_s);
      torque = Aerodynamic(facets, air, *trajectory);
    } else if constexpr (requires(One & one) { values(from, one); }) {
      One one = blank<One>(trajectory);
      values(from, one);
      torque = std::move(one);
    }
  });
  return torque.value();
}

/// All of them, with what they share.
void save(Saver& to, const std::vector<Torque>& torques) {
  Trajectories trajectories;
  Saver of_torques;
  std::size_t count = torques.size();
  pass(of_torques, count);
  for (const Torque& torque : torques) save(of_torques, torque, trajectories);
  std::size_t different = trajectories.all.size();
  pass(to, different);
  for (const Trajectory& trajectory : trajectories.all) save(to, trajectory);
  to.bytes += of_torques.bytes;
}

std::vector<Torque> load_torques(Loader& from) {
  std::size_t different = 0, count = 0;
  pass(from, different);
  std::vector<Trajectory> trajectories;
  for (std::size_t i = 0; i < different; ++i) trajectories.push_back(load_trajectory(from));
  pass(from, count);
  std::vector<Torque> torques;
  for (std::size_t i = 0; i < count; ++i) torques.push_back(load_torque(from, trajectories));
  return torques;
}

/// What states know of their motion; the motion itself if it is a free one.
void save(Saver& to, const MotionObject& motion) {
  MotionObject copy = motion;
  std::string method_name(motion.method == nullptr ? "" : motion.method->name);
  bool moving = motion.moving != nullptr;
  pass_all(to, copy.shape, copy.bodies, copy.named, method_name, moving);
  if (!moving) return;
  Body body = motion.moving->body;
  Frame frame = motion.moving->frame;
  pass_all(to, body, frame);
}

std::shared_ptr<MotionObject> load_motion(Loader& from, bool to_be_asked) {
  auto motion = std::make_shared<MotionObject>();
  std::string method_name;
  bool moving = false;
  pass_all(from, motion->shape, motion->bodies, motion->named, method_name, moving);
  if (!method_name.empty()) motion->method = &method(method_name);
  if (moving) {
    auto known = std::make_shared<BodyInMotion>();
    pass_all(from, known->body, known->frame);
    if (to_be_asked) {
      return motion_object(
          std::make_shared<BodyInMotion>(free_motion_of(std::move(known->body), known->frame, *motion->method)),
          motion->method);
    }
    motion->moving = std::move(known);
  }
  if (to_be_asked) make_free_motions(*motion, 1);
  return motion;
}

// --- Pickles
// ----------------------------------------------------------------------------------------------------------

using Pickle = std::pair<std::string, nb::bytes>;  // of this version, and what it means by the bytes

Pickle pickled(const Saver& saver) { return {creator(), nb::bytes(saver.bytes.data(), saver.bytes.size())}; }

Loader loader(const Pickle& pickle) {
  if (pickle.first != creator()) {
    throw InputError(fmt::format("the pickle is of {}, this is {}; files outlast versions, pickles do not",
                                 pickle.first, creator()));
  }
  return {{static_cast<const char*>(pickle.second.data()), pickle.second.size()}};
}

/// Gives a class pickles: `save(saver, object)`, and `load(loader)`, which returns the object.
template <class Object, class Save, class Load>
void give_pickles(nb::module_& m, const char* name, Save save, Load load) {
  auto type = nb::borrow<nb::class_<Object>>(m.attr(name));
  type.def("__getstate__", [save](const Object& self) {
    Saver saver;
    save(saver, self);
    return pickled(saver);
  });
  type.def("__setstate__", [load](Object& self, const Pickle& pickle) {
    Loader from = loader(pickle);
    new (&self) Object(load(from));
  });
}

/// Of a struct that pass() knows.
template <class Object>
void give_pickles(nb::module_& m, const char* name) {
  give_pickles<Object>(
      m, name, [](Saver& to, Object x) { pass(to, x); },
      [](Loader& from) {
        Object x;
        pass(from, x);
        return x;
      });
}

template <class Object>
void give_pickles_of_file(nb::module_& m, const char* name) {
  give_pickles<Object>(
      m, name, [](Saver& to, Object x) { pass_all(to, x.file, x.path); },
      [](Loader& from) {
        Object x;
        pass_all(from, x.file, x.path);
        return x;
      });
}

SceneObject load_scene(Loader& from) {
  SceneObject self;
  Scene& x = self.scene;
  pass_all(from, self.path, x.name, x.source, x.body, x.frame, x.torque_names, x.first_s, x.last_s, x.accuracy_rad);
  x.torques = Torques(load_torques(from));
  return self;
}

/// Arrays go as they are; a state without them has none.
nb::object or_none(const nb::object& array) { return array.is_valid() ? array : nb::none(); }
nb::object if_any(const nb::object& array) { return array.is_none() ? nb::object() : array; }

void give_states_pickles(nb::module_& m) {
  using StatePickle = std::tuple<Pickle, nb::object, nb::object, nb::object, nb::object>;
  auto type = nb::borrow<nb::class_<StateObject>>(m.attr("State"));
  type.def("__getstate__", [](const StateObject& self) {
    Saver to;
    StateObject x = self;
    bool of_motion = x.motion != nullptr, without_momentum = x.m.is_valid() && x.m.is_none();
    pass_all(to, of_motion, without_momentum, x.epoch, x.frame, x.scalar, x.t_s, x.q1, x.m1, x.omega1);
    if (of_motion) save(to, *x.motion);
    return StatePickle{pickled(to), or_none(x.t), or_none(x.q), or_none(x.m), or_none(x.omega)};
  });
  type.def("__setstate__", [](StateObject& self, const StatePickle& pickle) {
    Loader from = loader(std::get<0>(pickle));
    StateObject x;
    bool of_motion = false, without_momentum = false;
    pass_all(from, of_motion, without_momentum, x.epoch, x.frame, x.scalar, x.t_s, x.q1, x.m1, x.omega1);
    if (of_motion) x.motion = load_motion(from, false);
    x.t = if_any(std::get<1>(pickle));
    x.q = if_any(std::get<2>(pickle));
    x.m = without_momentum ? nb::none() : if_any(std::get<3>(pickle));
    x.omega = if_any(std::get<4>(pickle));
    new (&self) StateObject(std::move(x));
  });
}

}  // namespace

void bind_pickling(nb::module_& m) {
  give_pickles<Instant>(m, "Instant");
  give_pickles<Inertia>(m, "Inertia");
  give_pickles<TriangleMesh>(m, "Mesh");
  give_pickles_of_file<BodyObject>(m, "Body");
  give_pickles_of_file<HistoryObject>(m, "AttitudeHistory");
  give_pickles<Trajectory>(
      m, "Orbit", [](Saver& to, const Trajectory& x) { save(to, x); }, &load_trajectory);
  give_pickles<Torque>(
      m, "Torque", [](Saver& to, const Torque& x) { save(to, std::vector{x}); },
      [](Loader& from) { return load_torques(from).front(); });
  give_pickles<SceneObject>(
      m, "Scene",
      [](Saver& to, SceneObject self) {
        Scene& x = self.scene;
        if (x.uncertain) {
          throw nb::type_error(
              "a scene whose torques have uncertainties is not pickled: read its file again where it is wanted");
        }
        pass_all(to, self.path, x.name, x.source, x.body, x.frame, x.torque_names, x.first_s, x.last_s, x.accuracy_rad);
        save(to, x.torques.list());
      },
      &load_scene);
  give_pickles<MotionObject>(
      m, "Motion",
      [](Saver& to, const MotionObject& self) {
        if (self.method == nullptr) {
          throw nb::type_error(
              "a motion under torques is not pickled: pickle the Scene, whose motion() makes it again, or its states");
        }
        save(to, self);
      },
      [](Loader& from) { return MotionObject(*load_motion(from, true)); });
  give_states_pickles(m);
}

}  // namespace polhode::python
