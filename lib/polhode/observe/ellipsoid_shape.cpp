#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/observe/shape.hpp"

namespace polhode {
namespace {

/// Nodes and weights of Gauss's quadrature from -1 to 1 (Newton's iteration on Legendre's polynomial).
constexpr int kGaussPoints = 24;
struct GaussRule {
  std::array<double, kGaussPoints> x{}, weight{};
};

const GaussRule& gauss_rule() {
  static const GaussRule rule = [] {
    GaussRule out;
    for (std::size_t i = 0; i < kGaussPoints; ++i) {
      double x = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (kGaussPoints + 0.5)), slope = 1.0;
      for (int step = 0; step < 8; ++step) {
        double before = 1.0, value = x;
        for (int n = 2; n <= kGaussPoints; ++n) {
          const double next = ((2 * n - 1) * x * value - (n - 1) * before) / n;
          before = value;
          value = next;
        }
        slope = kGaussPoints * (before - x * value) / ((1.0 - x) * (1.0 + x));
        x -= value / slope;
      }
      out.x[i] = x;
      out.weight[i] = 2.0 / ((1.0 - x) * (1.0 + x) * slope * slope);
    }
    return out;
  }();
  return rule;
}

class Ellipsoid final : public Shape {
 public:
  explicit Ellipsoid(const Vector3& semi_axes_m) : axes_m_(semi_axes_m), volume_(semi_axes_m.prod()) {
    if (!((semi_axes_m.array() >= 1e-6).all() && (semi_axes_m.array() <= 1e12).all())) {
      throw InputError(
          fmt::format("the semi-axes of the ellipsoid are {:g}, {:g}, {:g} m; three positive numbers, from 1e-6 to "
                      "1e12 m, are wanted",
                      semi_axes_m[0], semi_axes_m[1], semi_axes_m[2]));
    }
    map_ = axes_m_.cwiseInverse().asDiagonal();
    radius_m_ = axes_m_.maxCoeff();
  }

  void shine(std::size_t count, const brightness::Directions& mapped, const ScatteringLaw& law,
             const brightness::Results& out) const override {
    const brightness::Kernels& kernels = brightness::best_kernels();
    kernels.ellipsoid_area(count, mapped, volume_, out.area);
    if (law.lommel_seeliger != 0.0) {
      kernels.ellipsoid_lommel_seeliger(count, mapped, volume_, out.brightness);
      for (std::size_t i = 0; i < count; ++i) out.brightness[i] *= law.lommel_seeliger;
    } else if (law.lambert == 0.0) {
      std::copy_n(out.area, count, out.brightness);
      return;
    } else {
      std::fill_n(out.brightness, count, 0.0);
    }
    if (law.lambert == 0.0) return;
    for (std::size_t i = 0; i < count; ++i) {
      out.brightness[i] += law.lambert * lambert({mapped.observer[0][i], mapped.observer[1][i], mapped.observer[2][i]},
                                                 {mapped.sun[0][i], mapped.sun[1][i], mapped.sun[2][i]});
    }
  }

  double mean_at_opposition_m2(const ScatteringLaw& law) const override {
    // Mean over directions of mu is 1/4, of mu^2 1/6.
    const double surface = surface_m2();
    if (law.lommel_seeliger == 0.0 && law.lambert == 0.0) return surface / 4.0;
    return surface * (law.lommel_seeliger / 8.0 + law.lambert / 6.0);
  }

  std::string description() const override {
    return fmt::format("an ellipsoid with the semi-axes {:g}, {:g}, {:g} m along x, y, z", axes_m_[0], axes_m_[1],
                       axes_m_[2]);
  }

 private:
  /// The integral of mu mu0 over what is lit and seen. In the stretched space the surface is a sphere with normals n',
  /// mu dA = V n'.e' dA', and mu0 = n'.s' / |n' / axes|. Longitudes are counted in the plane of both directions.
  double lambert(const Vector3& observer, const Vector3& sun) const {
    const double length = observer.norm();
    const Vector3 x = observer / length;
    Vector3 z = observer.cross(sun);
    if (z.norm() <= 1e-14 * length * sun.norm()) z = x.unitOrthogonal();
    z.normalize();
    const Vector3 y = z.cross(x);
    const double angle = std::atan2(sun.dot(y), sun.dot(x));  // 0 to pi
    const double first = angle - 0.5 * std::numbers::pi, half = 0.5 * (std::numbers::pi - angle);
    const GaussRule& rule = gauss_rule();
    double sum = 0.0;
    for (std::size_t i = 0; i < kGaussPoints; ++i) {
      const double longitude = first + half * (1.0 + rule.x[i]);
      const Vector3 across = std::cos(longitude) * x + std::sin(longitude) * y;
      const double lit = std::cos(longitude) * std::cos(longitude - angle);
      for (std::size_t j = 0; j < kGaussPoints; ++j) {
        const double sine = rule.x[j], cosine_squared = (1.0 - sine) * (1.0 + sine);
        const Vector3 normal = std::sqrt(cosine_squared) * across + sine * z;
        sum += rule.weight[i] * rule.weight[j] * lit * cosine_squared / normal.cwiseQuotient(axes_m_).norm();
      }
    }
    return std::max(volume_ * length * sun.norm() * half * sum, 0.0);
  }

  double surface_m2() const {
    // V times the integral of |n' / axes| over the sphere, an even function of each component.
    const GaussRule& rule = gauss_rule();
    double sum = 0.0;
    for (std::size_t i = 0; i < kGaussPoints; ++i) {
      const double longitude = 0.25 * std::numbers::pi * (1.0 + rule.x[i]);
      for (std::size_t j = 0; j < kGaussPoints; ++j) {
        const double sine = 0.5 * (1.0 + rule.x[j]), cosine = std::sqrt((1.0 - sine) * (1.0 + sine));
        const Vector3 normal(cosine * std::cos(longitude), cosine * std::sin(longitude), sine);
        sum += rule.weight[i] * rule.weight[j] * normal.cwiseQuotient(axes_m_).norm();
      }
    }
    return volume_ * std::numbers::pi * sum;  // 8 octants of pi/4 by 1/2
  }

  Vector3 axes_m_;
  double volume_;
};

}  // namespace

Shape::Light Shape::light(const Vector3& observer_named, const Vector3& sun_named, const ScatteringLaw& law) const {
  const Vector3 observer = map_ * observer_named.normalized(), sun = map_ * sun_named.normalized();
  const brightness::Directions at{{&observer.x(), &observer.y(), &observer.z()}, {&sun.x(), &sun.y(), &sun.z()}};
  Light out{};
  shine(1, at, law, {&out.brightness_m2, &out.area_m2});
  return out;
}

std::shared_ptr<const Shape> ellipsoid_shape(const Vector3& semi_axes_m) {
  return std::make_shared<const Ellipsoid>(semi_axes_m);
}

}  // namespace polhode
