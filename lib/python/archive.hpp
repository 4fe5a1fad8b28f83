#pragma once

// Structs as bytes, for pickles: pass() hands each member on, one way or the other.

#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "python/objects.hpp"

namespace polhode::python {

/// Takes values in turn, and gives their bytes.
struct Saver {
  static constexpr bool saves = true;
  std::string bytes;

  void raw(const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); }
};

/// Gives the values back in the same order.
struct Loader {
  static constexpr bool saves = false;
  std::string_view bytes;

  void raw(void* data, std::size_t size) {
    if (size > bytes.size()) throw InputError("the pickle is cut short");
    if (size != 0) std::memcpy(data, bytes.data(), size);
    bytes.remove_prefix(size);
  }
};

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class A, Plain T>
void pass(A& a, T& x) {
  a.raw(&x, sizeof x);
}
template <class A, int Rows, int Columns>
void pass(A& a, Eigen::Matrix<double, Rows, Columns>& x) {
  a.raw(x.data(), sizeof(double) * static_cast<std::size_t>(x.size()));
}
template <class A>
void pass(A& a, Quaternion& q) {
  pass(a, q.coeffs());
}
template <class A>
void pass(A& a, std::string& text) {
  std::size_t size = text.size();
  pass(a, size);
  if constexpr (!A::saves) {
    if (size > a.bytes.size()) throw InputError("the pickle is cut short");
    text.resize(size);
  }
  a.raw(text.data(), size);
}
template <class A>
void pass(A& a, Instant& time) {
  Seconds s = time.tt_since_j2000();
  pass(a, s.high);
  pass(a, s.low);
  if constexpr (!A::saves) time = Instant::from_tt_j2000(s);
}
template <class A, class T, std::size_t N>
void pass(A& a, std::array<T, N>& all);
template <class A, class T>
void pass(A& a, std::optional<T>& x);
template <class A, class T>
void pass(A& a, std::vector<T>& all);

template <class A, class... T>
void pass_all(A& a, T&... x) {
  (pass(a, x), ...);
}

template <class A>
void pass(A& a, Inertia& x) {
  pass_all(a, x.principal_moments, x.named_from_principal, x.absolute);
}
template <class A>
void pass(A& a, SpinState& x) {
  pass_all(a, x.epoch, x.epoch_scale, x.frame, x.q_frame_from_named, x.omega_named_rad_s);
}
template <class A>
void pass(A& a, StatedAttitude& x) {
  pass_all(a, x.block, x.frame, x.body, x.known_frame, x.q_frame_from_body, x.omega_body_rad_s);
}
template <class A>
void pass(A& a, EpochChange& x) {
  pass_all(a, x.turn_rad, x.omega_rad_s, x.tensor);
}
template <class A>
void pass(A& a, PublishedNumber& x) {
  pass_all(a, x.name, x.value, x.change);
}
template <class A>
void pass(A& a, Uncertainty& x) {
  pass(a, x.numbers);
  if constexpr (!A::saves) {
    const auto n = static_cast<Eigen::Index>(x.numbers.size());
    x.covariance.resize(n, n);
    x.body_with = [](const Eigen::VectorXd&) -> Body {
      throw InputError("this body came as a pickle; clones are drawn from a body that is read from its file");
    };
  }
  a.raw(x.covariance.data(), sizeof(double) * static_cast<std::size_t>(x.covariance.size()));
}
template <class A>
void pass(A& a, Body& x) {
  pass_all(a, x.name, x.id, x.source, x.inertia, x.any_inertia, x.state, x.attitudes, x.missing, x.notes, x.warnings);
  bool uncertain = x.uncertainty != nullptr;
  pass(a, uncertain);
  if (!uncertain) return;
  Uncertainty uncertainty;
  if constexpr (A::saves) uncertainty = *x.uncertainty;
  pass(a, uncertainty);
  if constexpr (!A::saves) x.uncertainty = std::make_shared<const Uncertainty>(std::move(uncertainty));
}
template <class A>
void pass(A& a, AttitudeSample& x) {
  pass_all(a, x.time, x.q_frame_from_body, x.omega_body_rad_s);
}
template <class A>
void pass(A& a, AttitudeSegment& x) {
  pass_all(a, x.frame, x.body, x.known_frame, x.method, x.degree, x.method_stated, x.usable_start, x.usable_stop,
           x.samples);
}
template <class A>
void pass(A& a, AttitudeHistory& x) {
  pass_all(a, x.object, x.object_id, x.source, x.scale, x.absolute_time, x.segments, x.inertia, x.notes, x.warnings);
}
template <class A>
void pass(A& a, BodyAndHistory& x) {
  pass_all(a, x.body, x.history, x.is_table);
}
template <class A>
void pass(A& a, FreeBody& x) {
  pass_all(a, x.principal_moments, x.q_inertial_from_body, x.momentum_body, x.named_from_principal);
}
template <class A>
void pass(A& a, MotionObject::NamedAxes& x) {
  pass_all(a, x.q_principal_from_named, x.named_from_principal);
}
template <class A>
void pass(A& a, TriangleMesh& x) {
  pass_all(a, x.vertices, x.facets, x.surface_names, x.surface_of_facet);
}
template <class A>
void pass(A& a, Facet& x) {
  pass_all(a, x.area_m2, x.centre_m, x.rebound.along, x.rebound.square, x.rebound.linear);
}
template <class A>
void pass(A& a, KeplerElements& x) {
  pass_all(a, x.mu_m3_s2, x.periapsis_m, x.eccentricity, x.periapsis_time_s, x.to_periapsis, x.along_normal);
}
template <class A>
void pass(A& a, OrbitTable& x) {
  pass_all(a, x.times_s, x.positions_m, x.velocities_m_s, x.degree, x.useable_from_s, x.useable_to_s);
}

template <class A, class T, std::size_t N>
void pass(A& a, std::array<T, N>& all) {
  for (T& x : all) pass(a, x);
}
template <class A, class T>
void pass(A& a, std::optional<T>& x) {
  bool there = x.has_value();
  pass(a, there);
  if (!there) return;
  if constexpr (!A::saves) x.emplace();
  pass(a, *x);
}
template <class A, class T>
void pass(A& a, std::vector<T>& all) {
  std::size_t count = all.size();
  pass(a, count);
  if constexpr (!A::saves) {
    if (count > a.bytes.size()) throw InputError("the pickle is cut short");  // each has a byte, at least
    all.resize(count);
  }
  for (T& x : all) pass(a, x);
}

}  // namespace polhode::python
