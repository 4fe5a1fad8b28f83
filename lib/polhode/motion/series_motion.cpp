#include "polhode/motion/series_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/motion/taylor/legs.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {
namespace taylor {

extern const Kernel k_kernel_baseline;
#ifdef POLHODE_X86_TARGETS
extern const Kernel k_kernel_avx2;
extern const Kernel k_kernel_avx512;
#endif

std::vector<const Kernel*> kernels() {
  std::vector<const Kernel*> all{&k_kernel_baseline};
#ifdef POLHODE_X86_TARGETS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) all.push_back(&k_kernel_avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) all.push_back(&k_kernel_avx512);
#endif
  return all;
}

const Kernel& best_kernel() {
  static const Kernel* const best = [] {
    const std::string_view wanted = ThetaMotion::best_target().name;
    for (const Kernel* kernel : kernels()) {
      if (kernel->name == wanted) return kernel;
    }
    return &k_kernel_baseline;
  }();
  return *best;
}

}  // namespace taylor

namespace {

using Extended = long double;
using ExtendedQuaternion = Eigen::Quaternion<Extended>;

/// How steps are chosen, found on the torqued bodies of data/truth and on 2000 random ones.
struct SteppingTuning {
  static constexpr double order_per_digit = 0.75;  // of the natural logarithm of the local error
  static constexpr int least_order = 14;
  static constexpr int at_once = 16;     // steps between looks at the error
  static constexpr double safety = 8.0;  // the error claimed, of the difference carried along
  static constexpr double aim = 0.4;     // of the tolerance, at the end
  static constexpr int most_runs = 6;
};

int order_for(double local_error) {
  return std::clamp(static_cast<int>(std::lround(-SteppingTuning::order_per_digit * std::log(local_error))),
                    SteppingTuning::least_order, taylor::kMostOrder);
}

/// A step that is not taken, of a span without length.
taylor::StepStart start_of_step(const taylor::Front& front, int order) {
  taylor::StepStart start{front.t_high, front.t_low, {}, {}, order, 1};
  for (int k = 0; k < taylor::kMostVectors; ++k) std::copy_n(front.high[k], 3, start.state[k]);
  for (int i = 0; i < 3; ++i) start.orbit[i] = static_cast<double>(front.orbit[i]);
  return start;
}

/// A power of two, in which the body turns by about one.
double unit_of_time_s(const FreeBody& body, const Torques& torques, double span_s) {
  double rate = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
  for (const Torque& torque : torques.list()) {
    const double largest = std::visit(
        [&](const auto& one) { return one.largest(0.0, body.principal_moments, body.momentum_body.norm()); }, torque);
    rate = std::max(rate, std::sqrt(largest / body.principal_moments[0]));
  }
  if (!(rate > 0.0)) rate = span_s > 0.0 ? 1.0 / span_s : 1.0;
  return std::exp2(std::round(-std::log2(rate)));
}

/// From two of the fixed axes seen from the body: unit to a few roundings.
Quaternion attitude(const Quaternion& inertial_from_fixed, const double* first, const double* second) {
  double a[3], b[3], c[3];
  const double shrink = 1.0 / std::sqrt(first[0] * first[0] + first[1] * first[1] + first[2] * first[2]);
  for (int i = 0; i < 3; ++i) a[i] = first[i] * shrink;
  const double along = a[0] * second[0] + a[1] * second[1] + a[2] * second[2];
  for (int i = 0; i < 3; ++i) b[i] = second[i] - along * a[i];
  const double stretch = 1.0 / std::sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
  for (int i = 0; i < 3; ++i) b[i] *= stretch;
  for (int i = 0; i < 3; ++i) c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
  // The rows a, b, c are the matrix that takes vectors of the body to the fixed axes; Shepperd's method.
  const double t[4] = {a[0] + b[1] + c[2], a[0] - b[1] - c[2], b[1] - a[0] - c[2], c[2] - a[0] - b[1]};
  const auto largest = static_cast<std::size_t>(std::max_element(t, t + 4) - t);
  const double w = std::sqrt(1.0 + t[largest]), half = 0.5 / w;
  const double x = (c[1] - b[2]) * half, y = (a[2] - c[0]) * half, z = (b[0] - a[1]) * half;
  const double xy = (a[1] + b[0]) * half, yz = (b[2] + c[1]) * half, zx = (c[0] + a[2]) * half;
  const double q[4][4] = {{0.5 * w, x, y, z}, {x, 0.5 * w, xy, zx}, {y, xy, 0.5 * w, yz}, {z, zx, yz, 0.5 * w}};
  return inertial_from_fixed * from_scalar_first(Eigen::Map<const Eigen::Vector4d>(q[largest]));
}

}  // namespace

/// One direction after the other; what both share.
class SeriesMotion::Builder {
 public:
  Builder(const FreeBody& body, const Torques& torques, const Options& options, std::size_t most)
      : body_(body),
        options_(options),
        axes_(taylor::fixed_axes(torques)),
        unit_s_(unit_of_time_s(body, torques, options.last_s - options.first_s)),
        left_(most) {
    const double rate = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
    phase_rad_ = rate * std::max(options.last_s, -options.first_s);
    for (std::vector<Leg>* legs : {&forward_, &backward_}) {
      for (TorqueStretch& one : stretches(torques, legs == &forward_ ? options.last_s : options.first_s)) {
        Leg leg{{},
                std::make_shared<const Torques>(std::move(one.torques)),
                Quaternion(ExtendedQuaternion(axes_).cast<double>()),
                {},
                one.to_s};
        leg.equations = taylor::equations_of(body.principal_moments.cast<Extended>(), *leg.torques, unit_s_);
        legs->push_back(std::move(leg));
      }
    }
  }

  double first_local_error() const { return 0.02 * options_.tolerance_rad / (1.0 + phase_rad_); }

  /// False if the limit of coefficients ended it.
  bool run(double local_error, double most_local_error, bool precise, std::vector<Leg>& legs, bool is_forward) {
    legs = is_forward ? forward_ : backward_;
    taylor::Front front = start();
    const double end = legs.back().end_s / unit_s_;
    for (std::size_t l = 0; l < legs.size(); ++l) {
      Leg& leg = legs[l];
      leg.equations.torques = leg.torques.get();
      front.until_exact_orbit = 0;
      front.longest = std::numeric_limits<double>::max();
      const double leg_end = leg.end_s / unit_s_;
      while (front.t_high != leg_end) {
        const taylor::Stepping stepping{leg_end, local_error, order_for(local_error), precise};
        const auto order = static_cast<std::size_t>(stepping.order);
        if (left_ < order * SteppingTuning::at_once) {
          legs.resize(l + 1);
          leg.end_s = front.t_high * unit_s_;
          if (leg.steps.empty()) leg.steps.push_back(start_of_step(front, order_for(local_error)));
          return false;
        }
        const std::size_t before = leg.steps.size();
        leg.steps.resize(before + SteppingTuning::at_once);
        const int taken = kernel_.advance(leg.equations, stepping, SteppingTuning::at_once, front, &leg.steps[before]);
        leg.steps.resize(before + static_cast<std::size_t>(taken));
        left_ -= order * static_cast<std::size_t>(taken);
        coefficients_ += order * static_cast<std::size_t>(taken);
        largest_local_error_ = std::max(largest_local_error_, local_error);
        local_error = std::min(most_local_error, next_local_error(local_error, front, end));
      }
      if (leg.steps.empty()) leg.steps.push_back(start_of_step(front, order_for(local_error)));
    }
    worst_rad_ = std::max(worst_rad_, front.worst_rad);
    return true;
  }

  double worst_rad() const { return worst_rad_; }
  /// Since forget().
  double largest_local_error() const { return largest_local_error_; }
  void forget() { worst_rad_ = largest_local_error_ = 0.0; }
  std::size_t coefficients() const { return coefficients_; }
  double phase_rad() const { return phase_rad_; }

 private:
  taylor::Front start() const {
    taylor::Front front;
    const ExtendedQuaternion q = body_.q_inertial_from_body.cast<Extended>().normalized();
    Vector3Of<Extended> vectors[taylor::kMostVectors];
    vectors[0] = body_.momentum_body.cast<Extended>().cwiseQuotient(body_.principal_moments.cast<Extended>()) *
                 static_cast<Extended>(unit_s_);
    for (int k = 0; k < 3; ++k) vectors[1 + k] = q.conjugate() * Vector3Of<Extended>(axes_.col(k));
    for (int k = 0; k < taylor::kMostVectors; ++k) {
      for (int i = 0; i < 3; ++i) {
        front.high[k][i] = static_cast<double>(vectors[k][i]);
        front.low[k][i] = static_cast<double>(vectors[k][i] - front.high[k][i]);
      }
    }
    return front;
  }

  /// What the difference will have become at the end, if the steps leave out as much as so far, and what they left out
  /// of the rate goes on turning the body: from that, how much they may leave out.
  double next_local_error(double local_error, const taylor::Front& front, double end) const {
    const double gone = std::abs(front.t_high), left = std::abs(end - front.t_high);
    // Of the rate's error, what changes energy and angular momentum counts: the rest swings.
    const Vector3 rate = Eigen::Map<const Vector3>(front.rate_error), I = body_.principal_moments;
    const Vector3 momentum = Eigen::Map<const Vector3>(front.high[0]).cwiseProduct(I);
    const double secular = std::abs(rate.dot(momentum.stableNormalized())) +
                           std::abs(rate.dot(momentum.cwiseProduct(I).stableNormalized()));
    const double expected =
        Eigen::Map<const Vector3>(front.turn_error_rad).norm() + secular * left * (1.0 + 0.5 * left / gone);
    const double aim = SteppingTuning::aim * options_.tolerance_rad / SteppingTuning::safety;
    const double factor = std::clamp(std::sqrt(aim / expected), 0.25, 2.0);
    return std::clamp(local_error * factor, 1e-19, 0.1 * options_.tolerance_rad);
  }

  const FreeBody& body_;
  const Options& options_;
  Matrix3Of<Extended> axes_;
  double unit_s_, phase_rad_ = 0.0;
  std::vector<Leg> forward_, backward_;  // without steps
  const taylor::Kernel& kernel_ = taylor::best_kernel();
  std::size_t left_, coefficients_ = 0;
  double worst_rad_ = 0.0, largest_local_error_ = 0.0;
};

bool SeriesMotion::serves(const Torques& torques) { return taylor::have_series(torques); }

SeriesMotion::SeriesMotion(const FreeBody& body, const Torques& torques, const Options& options)
    : moments_(body.principal_moments) {
  Builder builder(body, torques, options, options.most_evaluations);
  std::vector<Leg> forward, backward;
  double local_error = builder.first_local_error(), most_local_error = options.tolerance_rad;
  bool precise = 2e-16 * std::sqrt(builder.phase_rad()) * (1.0 + builder.phase_rad()) > options.tolerance_rad;
  for (int run = 0; run < SteppingTuning::most_runs; ++run) {
    const std::size_t before = builder.coefficients();
    builder.forget();
    whole_ = builder.run(local_error, most_local_error, precise, forward, true);
    whole_ = builder.run(local_error, most_local_error, precise, backward, false) && whole_;
    kept_evaluations_ = builder.coefficients() - before;
    const double before_rad = error_rad_;
    error_rad_ = SteppingTuning::safety * builder.worst_rad();
    if (!whole_ || error_rad_ <= options.tolerance_rad) break;
    if (run > 1 && precise && error_rad_ > 0.3 * before_rad) break;  // roundings that grow: finer steps change nothing
    most_local_error = local_error = 0.1 * builder.largest_local_error() * options.tolerance_rad / error_rad_;
    if (local_error < 1e-17) precise = true;
  }
  evaluations_ = builder.coefficients();
  first_s_ = backward.back().end_s;
  last_s_ = forward.back().end_s;
  std::size_t steps_before = 0;
  for (std::vector<Leg>* legs : {&forward, &backward}) {
    Quaternion before = body.q_inertial_from_body;
    for (Leg& leg : *legs) {
      leg.steps_before = steps_before;
      steps_before += leg.steps.size();
      for (taylor::StepStart& start : leg.steps) {
        const Quaternion q = attitude(leg.inertial_from_fixed, start.state[1], start.state[2]);
        start.sign = q.dot(before) < 0.0 ? -1 : 1;
        before.coeffs() = start.sign * q.coeffs();
      }
    }
  }
  forward_ = std::make_shared<const std::vector<Leg>>(std::move(forward));
  backward_ = std::make_shared<const std::vector<Leg>>(std::move(backward));
  memory_ = std::make_shared<Memory>(steps_before);
  steps_ = steps_before;
}

/// The state of one step as series.
struct SeriesMotion::Expansion {
  Place place;
  Quaternion q_at_start;
  const double (*coefficients)[taylor::kMostVectors][4];
};
struct SeriesMotion::Series {
  Place place;
  Quaternion q_at_start;
  double coefficients[taylor::kMostOrder + 1][taylor::kMostVectors][4];
};

/// The series of steps that at() was asked for. Several threads may come to a step at the same time: the first one's
/// series is kept, and theirs have the same bits.
struct SeriesMotion::Memory {
  using Coefficients = double[taylor::kMostVectors][4];
  static constexpr std::size_t kMostBytes = 64U << 20U;

  explicit Memory(std::size_t steps) : series(steps) {}
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() {
    for (std::atomic<Coefficients*>& one : series) delete[] one.load();
  }

  void keep(std::size_t step, const Coefficients* coefficients, int order) {
    const auto rows = static_cast<std::size_t>(order) + 1, size = rows * sizeof(Coefficients);
    if (bytes.fetch_add(size) + size <= kMostBytes) {
      auto* const copy = new Coefficients[rows];
      std::copy_n(&coefficients[0][0][0], size / sizeof(double), &copy[0][0][0]);
      Coefficients* none = nullptr;
      if (series[step].compare_exchange_strong(none, copy)) return;
      delete[] copy;
    }
    bytes.fetch_sub(size);
  }

  std::vector<std::atomic<Coefficients*>> series;  // of the steps of all legs, null: not kept
  std::atomic<std::size_t> bytes{0};
};

bool SeriesMotion::is_in(const Place& place, double t_s) const {
  if (place.leg == nullptr || t_s == 0.0) return false;
  const std::vector<taylor::StepStart>& steps = place.leg->steps;
  const double t = t_s / place.leg->equations.unit_s, from = steps[place.step].t_high;
  const double to =
      place.step + 1 < steps.size() ? steps[place.step + 1].t_high : place.leg->end_s / place.leg->equations.unit_s;
  return from < to ? from <= t && t < to : to < t && t <= from;
}

SeriesMotion::Place SeriesMotion::place(double t_s) const {
  const std::vector<Leg>& legs = is_forward(t_s) ? *forward_ : *backward_;
  const double away_s = std::abs(t_s);
  const Leg& leg =
      *std::find_if(legs.begin(), legs.end() - 1, [&](const Leg& l) { return away_s <= std::abs(l.end_s); });
  const double away = away_s / leg.equations.unit_s;
  const auto after =
      std::upper_bound(leg.steps.begin(), leg.steps.end(), away,
                       [](double t, const taylor::StepStart& start) { return t < std::abs(start.t_high); });
  return {&leg, static_cast<std::size_t>(after == leg.steps.begin() ? 0 : after - leg.steps.begin() - 1)};
}

Quaternion SeriesMotion::q_at_start(const Place& place) {
  const taylor::StepStart& start = place.leg->steps[place.step];
  Quaternion q = attitude(place.leg->inertial_from_fixed, start.state[1], start.state[2]);
  q.coeffs() *= start.sign;
  return q;
}

void SeriesMotion::expand(const Place& place, Series& series) const {
  const Leg& leg = *place.leg;
  const taylor::StepStart& start = leg.steps[place.step];
  series.place = place;
  series.q_at_start = q_at_start(place);
  taylor::best_kernel().coefficients(leg.equations, start, start.order, std::abs(leg.length(place.step)),
                                     series.coefficients);
}

State SeriesMotion::state(const Expansion& expansion, double t_high_s, double t_low_s) const {
  const Leg& leg = *expansion.place.leg;
  const taylor::StepStart& start = leg.steps[expansion.place.step];
  const double unit_s = leg.equations.unit_s;
  const double t = (t_high_s / unit_s - start.t_high) + (t_low_s / unit_s - start.t_low);
  double vectors[3][4];
  taylor::best_kernel().evaluate(expansion.coefficients, start.order, t, vectors);
  State state;
  state.q_inertial_from_body = attitude(leg.inertial_from_fixed, vectors[1], vectors[2]).normalized();
  if (state.q_inertial_from_body.dot(expansion.q_at_start) < 0.0) state.q_inertial_from_body.coeffs() *= -1.0;
  for (int i = 0; i < 3; ++i) state.momentum_body[i] = moments_[i] * vectors[0][i] / unit_s;
  return state;
}

State SeriesMotion::at(double t_high_s, double t_low_s) const {
  if (std::isnan(t_high_s + t_low_s)) return nan_state();
  const Place here = place(t_high_s);
  const std::size_t step = here.leg->steps_before + here.step;
  const Memory::Coefficients* kept = memory_->series[step].load();
  if (kept != nullptr) return state({here, q_at_start(here), kept}, t_high_s, t_low_s);
  Series series;
  expand(here, series);
  memory_->keep(step, series.coefficients, here.leg->steps[here.step].order);
  return state({here, series.q_at_start, series.coefficients}, t_high_s, t_low_s);
}

void SeriesMotion::batch(const TimeArrays& times, const StateArrays& out) const {
  check_lengths(times);
  Series series;
  for (std::size_t i = 0; i < times.high.size(); ++i) {
    const double t_high_s = times.high[i], t_low_s = times.low.empty() ? 0.0 : times.low[i];
    State at_i = nan_state();
    if (!std::isnan(t_high_s + t_low_s)) {
      if (!is_in(series.place, t_high_s)) {
        const Place next{series.place.leg, series.place.step + 1};
        const bool is_next = next.leg != nullptr && next.step < next.leg->steps.size() && is_in(next, t_high_s);
        expand(is_next ? next : place(t_high_s), series);
      }
      at_i = state({series.place, series.q_at_start, series.coefficients}, t_high_s, t_low_s);
    }
    out.put(i, at_i);
  }
}

}  // namespace polhode
