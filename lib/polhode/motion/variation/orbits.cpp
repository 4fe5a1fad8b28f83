#include "polhode/motion/variation/orbits.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace polhode::variation {
namespace {

constexpr double kLongerBy = 4.0;  // at most, than the polynomials before

double norm(const double* v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

double point(int i, int n) { return std::cos(std::numbers::pi * i / n); }

/// From values and derivatives at points cos(i pi/n), i = 0 to n: Chebyshev coefficients, of degree up to 2 n + 1.
class Hermite {
 public:
  explicit Hermite(int n) {
    using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
    const int terms = 2 * (n + 1);
    Matrix at_points(terms, terms);
    for (int i = 0; i <= n; ++i) {
      const long double angle = std::numbers::pi_v<long double> * i / n;
      for (int k = 0; k < terms; ++k) {
        const bool first = i == 0, last = i == n;
        at_points(i, k) = std::cos(k * angle);
        at_points(n + 1 + i, k) = first  ? 1.0L * k * k
                                  : last ? (k % 2 == 0 ? -1.0L : 1.0L) * k * k
                                         : k * std::sin(k * angle) / std::sin(angle);
      }
    }
    of_ = at_points.inverse().cast<double>();
  }
  double of_value(int term, int i) const { return of_(term, i); }
  double of_derivative(int term, int i) const { return of_(term, of_.cols() / 2 + i); }

 private:
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> of_;
};

}  // namespace

void Orbits::cover(double from_s, double to_s, double relative) {
  if (trajectories_.empty() || (resolved_ && covers(from_s) && covers(to_s))) return;
  const double least_s = std::abs(to_s - from_s), most_s = std::abs(end_s_ - from_s);
  double length_s = std::clamp(wanted_s_, least_s, std::max(least_s, most_s));
  for (;;) {
    from_s_ = from_s;
    to_s_ = length_s == most_s ? end_s_ : length_s == least_s ? to_s : from_s + std::copysign(length_s, to_s - from_s);
    double excess = 0.0;  // of the last coefficients, which fall about as the degree's power of the length
    for (const int times : {kTimes / 2, kTimes}) {
      interpolate(times);
      excess = tail() / std::max(relative, rounding());
      if (excess <= 1.0) break;
    }
    const double factor = 0.9 * std::pow(std::max(excess, 1e-300), -1.0 / terms_);
    // Where few times are enough, more would serve for a longer stretch, and better.
    wanted_s_ = length_s * std::clamp(terms_ < kTerms ? 3.0 * factor : factor, 0.1, kLongerBy);
    resolved_ = excess <= 1.0;
    if (resolved_ || length_s == least_s) return;
    length_s = std::max(least_s, wanted_s_);
  }
}

void Orbits::interpolate(int times) {
  static const Hermite few(kTimes / 2), all(kTimes);
  const bool every_other_is_known = times == kTimes;  // asked for before
  const Hermite& hermite = every_other_is_known ? all : few;
  const int step = kTimes / times;
  const double half_s = 0.5 * (to_s_ - from_s_);
  terms_ = 2 * (times + 1);
  asked_ += static_cast<std::size_t>(every_other_is_known ? times / 2 : times + 1);
  for (std::size_t l = 0; l < trajectories_.size(); ++l) {
    Series& s = series_[l];
    for (int i = 0; i <= kTimes; i += step) {
      if (every_other_is_known && i % 2 == 0) continue;
      const double t_s = i == 0 ? to_s_ : i == kTimes ? from_s_ : from_s_ + (1.0 + point(i, kTimes)) * half_s;
      const OrbitState<double> state = trajectories_[l].state(t_s);
      for (int k = 0; k < 3; ++k) s.states[i][k] = state.position_m[k], s.states[i][3 + k] = state.velocity_m_s[k];
    }
    for (int term = 0; term < terms_; ++term) {
      double sum[3] = {};
      for (int i = 0; i <= times; ++i) {
        const double of_value = hermite.of_value(term, i), of_derivative = half_s * hermite.of_derivative(term, i);
        const double* state = s.states[i * step];
        for (int k = 0; k < 3; ++k) sum[k] += of_value * state[k] + of_derivative * state[3 + k];
      }
      for (int k = 0; k < 3; ++k) s.coefficients[term][k] = sum[k];
    }
    // The series of the derivative, from the last term.
    for (int k = 0; k < 3; ++k) {
      double above[2] = {};
      for (int term = terms_ - 1; term >= 0; --term) {
        const double next = term + 1 < terms_ ? 2.0 * (term + 1) * s.coefficients[term + 1][k] : 0.0;
        const double here = above[1] + next;
        s.coefficients[term][3 + k] = (term == 0 ? 0.5 : 1.0) / half_s * here;
        above[1] = above[0], above[0] = here;
      }
    }
  }
}

/// The larger of the last two coefficients of positions, relative; or of those of velocities, which are far larger and
/// of less weight, each by its degree.
double Orbits::tail() const {
  double tail = 0.0;
  for (std::size_t l = 0; l < trajectories_.size(); ++l) {
    const auto& c = series_[l].coefficients;
    for (const int part : {0, 3}) {
      const double size = std::max(norm(c[0] + part), norm(c[1] + part));
      const double last = std::max(norm(c[terms_ - 3 + 1] + part), norm(c[terms_ - 3] + part));
      tail = std::max(tail, last / size / (part == 0 ? 1.0 : terms_));
    }
  }
  return tail;
}

/// What a rounding of the time makes of the positions, relative.
double Orbits::rounding() const {
  double rate_1_s = 0.0;
  for (std::size_t l = 0; l < trajectories_.size(); ++l) {
    rate_1_s = std::max(rate_1_s, norm(series_[l].coefficients[0] + 3) / norm(series_[l].coefficients[0]));
  }
  return 4e-16 * (1.0 + rate_1_s * std::max(std::abs(from_s_), std::abs(to_s_)));
}

void Orbits::find(std::size_t trajectory, double base_s, const AtPoints& since_base_s, AtPoints* states) {
  if (resolved_) {
    kernel_.find_series(series_[trajectory].coefficients[0], terms_ - 1, base_s - 0.5 * (from_s_ + to_s_),
                        2.0 / (to_s_ - from_s_), since_base_s, states);
    return;
  }
  for (int i = 0; i < kPoints; ++i) {
    double t_s = base_s + since_base_s[i];
    if ((t_s - end_s_) * (end_s_ - from_s_) > 0.0) t_s = end_s_;  // by a rounding
    const OrbitState<double> state = trajectories_[trajectory].state(t_s);
    for (int k = 0; k < 3; ++k) states[k][i] = state.position_m[k], states[3 + k][i] = state.velocity_m_s[k];
    asked_ += trajectory == 0 ? 1 : 0;
  }
}

}  // namespace polhode::variation
