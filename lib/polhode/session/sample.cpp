#include "polhode/session/sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/base/philox.hpp"
#include "polhode/base/text.hpp"
#include "polhode/base/units.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/ephemeris/time_grid.hpp"
#include "polhode/motion/free_bodies.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/write/document.hpp"

namespace polhode {
namespace {

constexpr std::size_t kAtOnce = 512;  // clones that a thread works on; a multiple of a block of bodies
constexpr std::size_t kAtOnceUnderTorques = 4;
constexpr std::chrono::milliseconds kWave{100};  // how long threads go on before their sums are added up
constexpr std::uint32_t kMostAttempts = 1000;

std::vector<double> times_of(const Sample& sample) {
  const TimeGrid grid = TimeGrid::of_list(sample.instants, sample.scale);
  std::vector<double> out(grid.size());
  for (std::size_t j = 0; j < out.size(); ++j) out[j] = grid.time(j, {}).high;
  return out;
}

/// TT seconds from the epoch.
struct ElapsedTimes {
  std::vector<double> high, low;
  explicit ElapsedTimes(const Sample& sample) {
    const TimeGrid grid = TimeGrid::of_list(sample.instants, sample.scale);
    for (std::size_t j = 0; j < grid.size(); ++j) {
      const Seconds elapsed = grid.instant(grid.time(j, {})) - sample.moving.body.state->epoch;
      high.push_back(elapsed.high);
      low.push_back(elapsed.low);
    }
  }
};

/// The clones from `first` on, as many as there are bodies.
struct Clones {
  std::uint64_t first = 0;
  std::vector<FreeBody> bodies;
  std::vector<Eigen::VectorXd> numbers;
};

Clones drawn_clones(const CloneSource& source, std::uint64_t first, std::uint64_t last) {
  Clones clones{first, {}, {}};
  clones.bodies.reserve(last - first);
  clones.numbers.reserve(last - first);
  for (std::uint64_t i = first; i < last; ++i) {
    CloneSource::Clone clone = source.clone(i);
    clones.bodies.push_back(clone.body);
    clones.numbers.push_back(std::move(clone.numbers));
  }
  return clones;
}

/// The states of some clones at all times, times within clones. Under torques each is propagated on its own.
void states_of_clones(const Sample& sample, const Clones& clones, const ElapsedTimes& times, std::vector<double>& q,
                      std::vector<double>& m) {
  const std::vector<FreeBody>& bodies = clones.bodies;
  const std::size_t count = times.high.size();
  q.resize(4 * count * bodies.size());
  m.resize(3 * count * bodies.size());
  const TimeArrays instants{times.high, times.low};
  const StateArrays out = StateArrays::of_structures(q.data(), m.data());
  if (!sample.moving.under_torques) {
    const auto rows = static_cast<std::ptrdiff_t>(count);
    free_body_states(BodyArrays::of_bodies(bodies), instants, out, {rows, 1});
    return;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    try {
      sample.moving.motion_of(bodies[i], clones.numbers[i], kAsPlanned_rad)
          .motion->batch(instants, part_of(out, i * count));
    } catch (const ComputationError& error) {
      throw ComputationError(fmt::format("clone {}: {}", clones.first + i, error.what()));
    }
  }
}

/// What does not change along a free motion.
struct CloneRates {
  CloneState::Mode mode = CloneState::Mode::other;
  double polhode_period_s = std::numeric_limits<double>::quiet_NaN();
  double precession_period_s = std::numeric_limits<double>::quiet_NaN();
};

CloneRates rates_of(const FreeBody& body, const Vector3& momentum) {
  CloneRates out;
  if (!momentum.allFinite()) return out;
  Inertia inertia;
  inertia.principal_moments = body.principal_moments;
  const SpinInvariants spin = spin_invariants(inertia, momentum);
  if (spin.mode == RotationMode::short_axis) out.mode = CloneState::Mode::short_axis;
  if (spin.mode == RotationMode::long_axis) out.mode = CloneState::Mode::long_axis;
  if (spin.polhode_period_s) out.polhode_period_s = *spin.polhode_period_s;
  if (spin.long_axis) out.precession_period_s = spin.long_axis->precession_period_s;
  return out;
}

CloneState clone_state(const FreeBody& body, const double* q, const double* m, const CloneRates& rates) {
  State state{Quaternion(q[0], q[1], q[2], q[3]), Vector3(m)};
  const NamedState named = named_state(body, state);
  return {named.q_inertial_from_named,
          state.q_inertial_from_body * state.momentum_body,
          state.momentum_body.cwiseQuotient(body.principal_moments).norm(),
          rates.mode,
          rates.polhode_period_s,
          rates.precession_period_s,
          named.omega_named_rad_s};
}

template <class Use>
void clone_states(const Sample& sample, const Clones& clones, const ElapsedTimes& times, const Use& use) {
  const std::vector<FreeBody>& bodies = clones.bodies;
  std::vector<double> q, m;
  states_of_clones(sample, clones, times, q, m);
  const std::size_t count = times.high.size();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    CloneRates rates;
    for (std::size_t j = 0; j < count; ++j) {
      const std::size_t row = i * count + j;
      if (j == 0 || sample.moving.under_torques) {
        rates = rates_of(bodies[i], sample.moving.under_torques ? Vector3(&m[3 * row]) : bodies[i].momentum_body);
      }
      use(i, j, clone_state(bodies[i], &q[4 * row], &m[3 * row], rates));
    }
  }
}

}  // namespace

CloneSource::CloneSource(const BodyInMotion& moving, std::uint64_t seed, std::span<const UniformNumber> uniform)
    : frame_(moving.frame), seed_(seed), uncertainty_(moving.uncertainty), published_(moving.free) {
  if (!uncertainty_) {
    throw InputError(
        "has no uncertainties to draw clones from; a sigma beside a number (components_sigma = ...), or "
        "[uncertainty], gives them");
  }
  widths_.assign(uncertainty_->numbers.size(), 0.0);
  Uncertainty normal = *uncertainty_;
  for (const UniformNumber& wanted : uniform) {
    const auto found = std::find_if(normal.numbers.begin(), normal.numbers.end(),
                                    [&](const PublishedNumber& number) { return number.name == wanted.name; });
    if (found == normal.numbers.end()) {
      std::string names;
      for (const PublishedNumber& number : normal.numbers) names += (names.empty() ? "" : ", ") + number.name;
      throw InputError(fmt::format("no number with an uncertainty is called {:.40}; they are {}", wanted.name, names));
    }
    if (!(wanted.width > 0.0 && std::isfinite(wanted.width))) {
      throw InputError(fmt::format("the width of {} is {}; a positive one is wanted", wanted.name, wanted.width));
    }
    const auto i = found - normal.numbers.begin();
    widths_[static_cast<std::size_t>(i)] = wanted.width;
    normal.covariance.row(i).setZero();
    normal.covariance.col(i).setZero();
  }
  root_ = normal.root();
  values_ = normal.values();
}

CloneSource::Clone CloneSource::clone(std::uint64_t number) const {
  const std::size_t count = widths_.size();
  std::string why;
  for (std::uint32_t attempt = 0; attempt < kMostAttempts; ++attempt) {
    Eigen::VectorXd z(static_cast<Eigen::Index>(count)), within = z;
    for (std::size_t i = 0; i < count; ++i) {
      const double p = philox_uniforms(seed_, number, static_cast<std::uint32_t>(i / 2), attempt)[i % 2];
      const auto place = static_cast<Eigen::Index>(i);
      z[place] = normal_quantile(p);
      within[place] = widths_[i] * (p - 0.5);
    }
    try {
      Eigen::VectorXd numbers = values_ + root_ * z + within;
      const FreeBody body = free_body(uncertainty_->body_with(numbers), frame_);
      return {body, std::move(numbers)};
    } catch (const InputError& error) {
      why = error.what();
    }
  }
  throw ComputationError(fmt::format("clone {}: {} draws give no body: {}", number, kMostAttempts, why));
}

SamplePart part_of_sample(std::uint64_t count, std::uint64_t part, std::uint64_t parts) {
  if (!(parts >= 1 && part >= 1 && part <= parts)) {
    throw InputError(fmt::format("part {} of {}; the first is 1/K, the last K/K", part, parts));
  }
  __extension__ using Wide = unsigned __int128;
  const auto border = [&](std::uint64_t i) { return static_cast<std::uint64_t>(Wide{count} * i / parts); };
  return {border(part - 1), border(part)};
}

SampleState empty_state(const Sample& sample, SamplePart part) {
  const TimeGrid grid = TimeGrid::of_list(sample.instants, sample.scale);
  SampleState state;
  state.object = plain_text(sample.moving.body.name);
  state.frame = std::string(name(sample.moving.frame));
  state.scale = std::string(name(sample.scale));
  state.seed = sample.seed;
  state.count = sample.count;
  state.times_s = times_of(sample);
  state.reference_mjd = grid.reference_mjd();
  for (std::size_t j = 0; j < grid.size(); ++j) {
    state.dates.push_back(format_date(grid.instant(grid.time(j, {})), sample.scale, grid.decimals()));
  }
  std::string inputs = sample.inputs;
  for (const UniformNumber& number : sample.uniform) inputs += fmt::format("\n{} {}", number.name, number.width);
  for (const std::string& date : state.dates) inputs += '\n' + date;
  inputs += '\n' + state.frame + state.scale;
  state.identity = fmt::format("{} {} {:016x} {}", sample.seed, sample.count, text_digest(inputs), creator());
  state.part = part;
  state.next = part.first;
  state.at.resize(grid.size());
  state.published.resize(grid.size());
  const CloneSource source(sample.moving, sample.seed, sample.uniform);
  const CloneSource::Clone published = source.published();
  clone_states(sample, Clones{0, {published.body}, {published.numbers}}, ElapsedTimes(sample),
               [&](std::size_t, std::size_t j, const CloneState& clone) { state.published[j] = clone; });
  return state;
}

void continue_sample(const Sample& sample, SampleState& state, unsigned thread_count, const SampleProgress& progress) {
  const CloneSource source(sample.moving, sample.seed, sample.uniform);
  const ElapsedTimes times(sample);
  if (thread_count == 0) thread_count = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t at_once = sample.moving.under_torques ? kAtOnceUnderTorques : kAtOnce;
  std::vector<std::vector<ClonesAtTime>> sums(thread_count);
  while (state.next < state.part.last) {
    // Each thread takes the next few clones when it is done with its last: some take much longer than others. The sums
    // are exact, and do not depend on who takes which.
    std::atomic<std::uint64_t> next = state.next;
    const auto until = std::chrono::steady_clock::now() + kWave;
    parallel_chunks(thread_count, 1, thread_count, [&](std::size_t thread, std::size_t) {
      std::vector<ClonesAtTime>& mine = sums[thread];
      mine.assign(times.high.size(), {});
      do {
        const std::uint64_t first = next.fetch_add(at_once);
        if (first >= state.part.last) break;
        const Clones clones = drawn_clones(source, first, std::min(state.part.last, first + at_once));
        clone_states(sample, clones, times, [&](std::size_t, std::size_t j, const CloneState& clone) {
          mine[j].add(clone, state.published[j]);
        });
      } while (std::chrono::steady_clock::now() < until);
    });
    for (const std::vector<ClonesAtTime>& of_thread : sums) {
      for (std::size_t j = 0; j < of_thread.size(); ++j) state.at[j].add(of_thread[j]);
    }
    state.next = std::min(state.part.last, next.load());
    if (progress) progress(state);
  }
}

void write_sample_rows(const std::string& path, const Sample& sample, SamplePart part, const Progress& progress,
                       unsigned thread_count) {
  const SampleState about = empty_state(sample, part);
  const bool fits = is_fits_path(path);
  NumberTable table;
  table.extension = "CLONES";
  table.columns.push_back({"CLONE", {"clone"}, "", NumberColumn::Kind::whole});
  if (fits) {
    table.columns.push_back({"TIME", {"time"}, "s"});
  } else {
    table.columns.push_back({"TIME", {"date_" + lower_case(about.scale)}, "", NumberColumn::Kind::label, about.dates});
  }
  table.columns.push_back({"QPARAM", {"q_x", "q_y", "q_z", "q_scalar"}, ""});
  table.columns.push_back({"OMEGA", {"omega_body_x_rad_s", "omega_body_y_rad_s", "omega_body_z_rad_s"}, "rad / s"});
  table.columns.push_back({"LDIR", {"momentum_ra_deg", "momentum_dec_deg"}, "deg"});
  table.columns.push_back({"MODE", {"mode"}, "", NumberColumn::Kind::label, {"short-axis", "long-axis", "other"}});
  table.columns.push_back({"PPSI", {"polhode_period_s"}, "s"});
  table.columns.push_back({"PPHI", {"precession_period_s"}, "s"});
  const auto text = [&table](const char* keyword, const char* key, const std::string& value, const char* comment) {
    table.entries.push_back({keyword, key, value, 0.0, false, comment});
  };
  text("OBJECT", "object", about.object, "body");
  text("CREATOR", "creator", creator(), "program that wrote this file");
  if (fits) {
    text("TIMESYS", "scale", about.scale, "time scale of TIME");
    table.entries.push_back({"MJDREF", "mjdref", "", about.reference_mjd, true, "[d] TIME counts from this MJD"});
    text("TIMEUNIT", "time_unit", "s", "unit of TIME");
    text("QORDER", "q_order", "XYZS", "order within QPARAM: vector part, scalar last");
    text("QDIR", "q_direction", "A2B", "QPARAM takes components from frame A to frame B");
  }
  text("REFFRAMA", "frame_a", about.frame, "frame A, of the attitudes");
  text("SEED", "seed", fmt::format("{}", about.seed), "key of Philox4x32-10");
  const std::size_t times = about.dates.size(), width = table.width();
  table.rows = static_cast<std::size_t>(part.last - part.first) * times;
  const CloneSource source(sample.moving, sample.seed, sample.uniform);
  const ElapsedTimes elapsed(sample);
  const auto fill = [&](std::size_t first, std::span<double> out) {
    const std::size_t last = first + out.size() / width;
    const std::size_t first_clone = first / times, last_clone = (last + times - 1) / times;
    for (std::size_t at = first_clone; at < last_clone; at += kAtOnce) {
      const Clones clones = drawn_clones(source, part.first + at, part.first + std::min(last_clone, at + kAtOnce));
      clone_states(sample, clones, elapsed, [&](std::size_t i, std::size_t j, const CloneState& clone) {
        const std::size_t row = (at + i) * times + j;
        if (row < first || row >= last) return;
        double* to = out.data() + (row - first) * width;
        *to++ = static_cast<double>(clones.first + i);
        *to++ = fits ? about.times_s[j] : static_cast<double>(j);
        const Eigen::Vector4d q = scalar_first(clone.q_inertial_from_named);
        for (const int k : {1, 2, 3, 0}) *to++ = q[k];
        for (int k = 0; k < 3; ++k) *to++ = clone.omega_named_rad_s[k];
        for (const double angle_deg : ra_dec_deg(clone.momentum_inertial, sample.moving.frame)) *to++ = angle_deg;
        *to++ = static_cast<double>(clone.mode);
        *to++ = clone.polhode_period_s;
        *to++ = clone.long_axis_precession_period_s;
      });
    }
  };
  write_number_table(path, table, fill, progress, thread_count);
}

}  // namespace polhode
