#include "polhode/torque/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polhode/base/error.hpp"

namespace polhode {

TabulatedOrbit::TabulatedOrbit(std::vector<double> times_s, std::vector<Vector3> positions_m, int degree)
    : times_s_(std::move(times_s)), positions_m_(std::move(positions_m)), degree_(degree) {
  if (degree < 1 || degree > 15) {
    throw InputError(fmt::format("the interpolation degree is {}, 1 to 15 is allowed", degree));
  }
  if (times_s_.size() != positions_m_.size() || times_s_.size() <= static_cast<std::size_t>(degree)) {
    throw InputError(
        fmt::format("the trajectory has {} times and {} positions, as many of both and more than {} are wanted",
                    times_s_.size(), positions_m_.size(), degree));
  }
  if (std::adjacent_find(times_s_.begin(), times_s_.end(), [](double a, double b) { return !(a < b); }) !=
      times_s_.end()) {
    throw InputError("the times of the trajectory do not increase");
  }
}

template <class Real>
OrbitState<Real> TabulatedOrbit::state(Real t_s) const {
  if (!(t_s >= Real(first_s()) && t_s <= Real(last_s()))) {
    throw InputError(fmt::format("the trajectory covers {} s to {} s, it was asked for at {} s", first_s(), last_s(),
                                 static_cast<double>(t_s)));
  }
  const auto after = std::upper_bound(times_s_.begin(), times_s_.end(), static_cast<double>(t_s)) - times_s_.begin();
  const std::ptrdiff_t points = degree_ + 1, count = static_cast<std::ptrdiff_t>(times_s_.size());
  const std::ptrdiff_t first = std::clamp<std::ptrdiff_t>(after - points / 2, 0, count - points);
  // Neville's scheme, with its derivative by t beside it.
  Vector3Of<Real> p[16], v[16];
  for (std::ptrdiff_t i = 0; i < points; ++i) {
    p[i] = positions_m_[static_cast<std::size_t>(first + i)].template cast<Real>();
    v[i].setZero();
  }
  for (std::ptrdiff_t k = 1; k < points; ++k) {
    for (std::ptrdiff_t i = 0; i + k < points; ++i) {
      const Real a = times_s_[static_cast<std::size_t>(first + i)],
                 b = times_s_[static_cast<std::size_t>(first + i + k)];
      const Vector3Of<Real> slope = (p[i + 1] - p[i]) / (b - a);
      v[i] += (v[i + 1] - v[i]) * ((t_s - a) / (b - a)) + slope;
      p[i] += slope * (t_s - a);
    }
  }
  return {p[0], v[0]};
}

template OrbitState<double> TabulatedOrbit::state(double) const;
template OrbitState<long double> TabulatedOrbit::state(long double) const;

}  // namespace polhode
