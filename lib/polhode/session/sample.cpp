#include "polhode/session/sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/base/philox.hpp"
#include "polhode/base/text.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/ephemeris/time_grid.hpp"
#include "polhode/motion/free_bodies.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/write/document.hpp"

namespace polhode {
namespace {

constexpr std::size_t kAtOnce = 512;  // clones that a thread works on; a multiple of a block of bodies
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

/// The states of some bodies at all times, times within bodies. Under torques each is propagated on its own.
void states_of_bodies(const Sample& sample, std::span<const FreeBody> bodies, const ElapsedTimes& times,
                      std::vector<double>& q, std::vector<double>& m) {
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
    sample.moving.motion_of(bodies[i])->batch(instants, part_of(out, i * count));
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
          rates.precession_period_s};
}

template <class Use>
void clone_states(const Sample& sample, std::span<const FreeBody> bodies, const ElapsedTimes& times, const Use& use) {
  std::vector<double> q, m;
  states_of_bodies(sample, bodies, times, q, m);
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

/// FNV-1a: whether two inputs are the same; nobody is kept from making others that look so.
std::uint64_t digest(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

std::uint64_t whole_of(std::string_view text) {
  const auto value = parse_integer(text);
  if (!value || *value < 0) throw InputError(fmt::format("is no part of a sample: '{}' is no number", plain_text(text.substr(0, 40))));
  return static_cast<std::uint64_t>(*value);
}

double number_of(std::string_view text) {
  const auto value = parse_number(text);
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

CloneSource::CloneSource(const Body& body, Frame frame, std::uint64_t seed, std::span<const UniformNumber> uniform)
    : frame_(frame), seed_(seed), uncertainty_(body.uncertainty), published_(free_body(body, frame)) {
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
}

FreeBody CloneSource::clone(std::uint64_t number) const {
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
      return free_body(uncertainty_->body_with(uncertainty_->values() + root_ * z + within), frame_);
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
  state.identity = fmt::format("{} {} {:016x} {}", sample.seed, sample.count, digest(inputs), creator());
  state.part = part;
  state.next = part.first;
  state.at.resize(grid.size());
  state.published.resize(grid.size());
  const CloneSource source(sample.moving.body, sample.moving.frame, sample.seed, sample.uniform);
  clone_states(sample, std::span(&source.published(), 1), ElapsedTimes(sample),
               [&](std::size_t, std::size_t j, const CloneState& clone) { state.published[j] = clone; });
  return state;
}

void continue_sample(const Sample& sample, SampleState& state, unsigned thread_count, const SampleProgress& progress) {
  const CloneSource source(sample.moving.body, sample.moving.frame, sample.seed, sample.uniform);
  const ElapsedTimes times(sample);
  if (thread_count == 0) thread_count = std::max(1U, std::thread::hardware_concurrency());
  const std::uint64_t chunk = sample.moving.under_torques ? 16 : 32 * kAtOnce;  // clones of a thread in a wave
  std::vector<std::vector<ClonesAtTime>> sums(thread_count);
  while (state.next < state.part.last) {
    const std::uint64_t first = state.next, last = std::min(state.part.last, first + chunk * thread_count);
    parallel_chunks(thread_count, 1, thread_count, [&](std::size_t begin, std::size_t end) {
      for (std::size_t thread = begin; thread < end; ++thread) {
        std::vector<ClonesAtTime>& mine = sums[thread];
        mine.assign(times.high.size(), {});
        std::vector<FreeBody> bodies;
        const std::uint64_t until = std::min(last, first + chunk * (thread + 1));
        for (std::uint64_t at = first + chunk * thread; at < until; at += kAtOnce) {
          bodies.clear();
          for (std::uint64_t i = at; i < std::min<std::uint64_t>(until, at + kAtOnce); ++i) {
            bodies.push_back(source.clone(i));
          }
          clone_states(sample, bodies, times, [&](std::size_t, std::size_t j, const CloneState& clone) {
            mine[j].add(clone, state.published[j]);
          });
        }
      }
    });
    for (const std::vector<ClonesAtTime>& of_thread : sums) {
      for (std::size_t j = 0; j < of_thread.size(); ++j) state.at[j].add(of_thread[j]);
    }
    state.next = last;
    if (progress) progress(state);
  }
}

std::string SampleState::text() const {
  std::string out = fmt::format(
      "polhode sample 2\nidentity {}\nobject {}\nframe {}\nscale {}\nseed {}\ncount {}\n"
      "reference_mjd {}\npart {} {} {}\ntimes {}\n",
      identity, object, frame, scale, seed, count, reference_mjd, part.first, part.last, next, dates.size());
  for (std::size_t j = 0; j < dates.size(); ++j) {
    const CloneState& p = published[j];
    const Eigen::Vector4d q = scalar_first(p.q_inertial_from_named);
    out += fmt::format("time {} {} {} {} {} {} {} {} {} {} {} {} {}\n", dates[j], times_s[j], q[0], q[1], q[2], q[3],
                       p.momentum_inertial[0], p.momentum_inertial[1], p.momentum_inertial[2], p.rate_rad_s,
                       static_cast<int>(p.mode), p.polhode_period_s, p.long_axis_precession_period_s);
    out += text_of(at[j]);
  }
  out += fmt::format("digest {:016x}\n", digest(out));
  return out + "end\n";
}

SampleState SampleState::of_text(const std::string& text) {
  std::string_view rest = text;
  const auto take = [&rest](std::string_view name) {
    std::string_view line = take_line(rest);
    if (take_word(line) != name)
      throw InputError(fmt::format("is no part of a sample, or a broken one: no '{}'", name));
    return std::string(trimmed(line));
  };
  SampleState state;
  if (take("polhode") != "sample 2") throw InputError("is no part of a sample that this program knows");
  state.identity = take("identity");
  state.object = take("object");
  state.frame = take("frame");
  state.scale = take("scale");
  state.seed = whole_of(take("seed"));
  state.count = whole_of(take("count"));
  state.reference_mjd = number_of(take("reference_mjd"));
  const std::string part_line = take("part");
  const auto part_words = split_words(part_line);
  if (part_words.size() != 3) throw InputError("is no part of a sample, or a broken one: its part");
  state.part = {whole_of(part_words[0]), whole_of(part_words[1])};
  state.next = whole_of(part_words[2]);
  const std::uint64_t times = whole_of(take("times"));
  for (std::uint64_t j = 0; j < times; ++j) {
    const std::string line = take("time");
    const auto words = split_words(line);
    if (words.size() != 13) throw InputError("is no part of a sample, or a broken one: a time");
    double n[13];
    for (std::size_t k = 1; k < 13; ++k) n[k] = number_of(words[k]);
    state.dates.emplace_back(words[0]);
    state.times_s.push_back(n[1]);
    state.published.push_back({Quaternion(n[2], n[3], n[4], n[5]), Vector3(n[6], n[7], n[8]), n[9],
                               static_cast<CloneState::Mode>(std::clamp(static_cast<int>(n[10]), 0, 2)), n[11], n[12]});
    state.at.push_back(take_clones(rest));
  }
  const std::string_view until_here = std::string_view(text).substr(0, text.size() - rest.size());
  if (take("digest") != fmt::format("{:016x}", digest(until_here))) {
    throw InputError("is no part of a sample, or a broken one: its digest is that of another text");
  }
  if (rest != "end\n") throw InputError("is no whole part of a sample");
  return state;
}

SampleState joined(std::vector<SampleState> parts) {
  if (parts.empty()) throw InputError("no part is given");
  std::sort(parts.begin(), parts.end(), [](const SampleState& a, const SampleState& b) {
    return std::pair(a.part.first, a.part.last) < std::pair(b.part.first, b.part.last);
  });
  SampleState whole = std::move(parts.front());
  std::uint64_t until = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const SampleState& part = k == 0 ? whole : parts[k];
    if (part.identity != whole.identity) {
      throw InputError("the parts are of different samples: of another body, seed, count, times or version");
    }
    if (part.next != part.part.last) {
      throw InputError(fmt::format("the part of clones {} to {} is not complete", part.part.first, part.part.last));
    }
    if (part.part.first != until) {
      throw InputError(fmt::format("clones {} to {} are {}", std::min(until, part.part.first),
                                   std::max(until, part.part.first),
                                   part.part.first > until ? "missing" : "there twice"));
    }
    until = part.part.last;
    for (std::size_t j = 0; k > 0 && j < whole.at.size(); ++j) whole.at[j].add(part.at[j]);
  }
  if (until != whole.count) throw InputError(fmt::format("clones {} to {} are missing", until, whole.count));
  whole.part = {0, whole.count};
  whole.next = whole.count;
  return whole;
}

void write_sample_statistics(const std::string& path, const SampleState& state) {
  using Kind = NumberColumn::Kind;
  static constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;
  static constexpr double sizes[] = {0.5, 0.682689492137086, 0.954499736103642, 0.997300203936740};
  static constexpr double signed_parts[] = {0.00134989803163, 0.158655253931457, 0.5, 0.841344746068543,
                                            0.99865010196837};
  const bool fits = is_fits_path(path);
  NumberTable table;
  table.extension = "SAMPLE";
  if (fits) {
    table.columns.push_back({"TIME", {"time"}, "s"});
  } else {
    table.columns.push_back({"TIME", {"date_" + lower_case(state.scale)}, "", Kind::label, state.dates});
  }
  const auto quantiles = [&table](const std::string& column, const std::string& text, const std::string& unit,
                                  bool is_size) {
    const std::vector<std::string> ends = is_size ? std::vector<std::string>{"50", "68", "95", "997"}
                                                  : std::vector<std::string>{"m3s", "m1s", "50", "p1s", "p3s"};
    std::vector<std::string> names(ends.size());
    std::transform(ends.begin(), ends.end(), names.begin(),
                   [&](const auto& end) { return fmt::format("{}_{}", text, end); });
    table.columns.push_back({column, std::move(names), unit});
  };
  table.columns.push_back({"QMEAN", {"q_x", "q_y", "q_z", "q_scalar"}, ""});
  table.columns.push_back({"SPREAD", {"attitude_spread_deg"}, "deg"});
  quantiles("ANGLE", "attitude_angle_deg", "deg", true);
  table.columns.push_back({"LDIR", {"momentum_ra_deg", "momentum_dec_deg"}, "deg"});
  table.columns.push_back({"LSPREAD", {"momentum_spread_deg"}, "deg"});
  quantiles("LANGLE", "momentum_angle_deg", "deg", true);
  table.columns.push_back({"PMODE", {"p_short_axis", "p_long_axis", "p_other"}, ""});
  quantiles("RATE", "rate_deviation", "", false);
  quantiles("PPSI", "polhode_period_deviation", "", false);
  quantiles("PPHI", "precession_period_deviation", "", false);
  const auto text = [&table](const char* keyword, const char* key, const std::string& value, const char* comment) {
    table.entries.push_back({keyword, key, value, 0.0, false, comment});
  };
  const auto number = [&table](const char* keyword, const char* key, double value, const char* comment) {
    table.entries.push_back({keyword, key, "", value, true, comment});
  };
  text("OBJECT", "object", state.object, "body");
  text("CREATOR", "creator", creator(), "program that wrote this file");
  text("DATE", "created_utc", creation_date(), "when written, UTC");
  if (fits) {
    text("TIMESYS", "scale", state.scale, "time scale of TIME");
    number("MJDREF", "mjdref", state.reference_mjd, "[d] TIME counts from this MJD");
    text("TIMEUNIT", "time_unit", "s", "unit of TIME");
  }
  text("REFFRAMA", "frame_a", state.frame, "frame A, of the attitudes");
  number("NCLONES", "clones", static_cast<double>(state.count), "how many were drawn");
  text("SEED", "seed", fmt::format("{}", state.seed), "key of Philox4x32-10");
  table.comments = {
      "QMEAN, passive from frame A to the body, scalar last, is the attitude with the least mean square of "
      "sin(angle/2); "
      "SPREAD is 2 asin of the root of that mean. LDIR, LSPREAD: the same of the direction of the angular momentum, in ICRF.",
      "ANGLE, LANGLE: below which 50, 68.27, 95.45, 99.73 per cent of the clones lie from the published body's.",
      "RATE, PPSI, PPHI: quantiles at -3, -1, 0, 1, 3 normal sigmas of value over published value, less 1, of the "
      "rate, "
      "the period of the polhode and that of the long axis' precession, to a part in 100 of themselves."};
  table.rows = state.at.size();
  const std::size_t width = table.width();
  write_number_table(
      path, table,
      [&](std::size_t first, std::span<double> out) {
        double* to = out.data();
        for (std::size_t j = first; j < first + out.size() / width; ++j) {
          const ClonesAtTime& clones = state.at[j];
          *to++ = fits ? state.times_s[j] : static_cast<double>(j);
          const Eigen::Vector4d q = scalar_first(clones.mean_attitude());
          for (const int k : {1, 2, 3, 0}) *to++ = q[k];
          *to++ = kDegreesPerRad * clones.attitude_spread_rad();
          // A quantile may end at the border of a step of its histogram, beyond the most that there can be.
          const auto angle_deg = [](const Histogram& angles, double part) {
            const double deg = kDegreesPerRad * angles.quantile(part);
            return deg > 180.0 ? 180.0 : deg;
          };
          for (const double part : sizes) *to++ = angle_deg(clones.attitude_angle, part);
          const Vector3 mean = q_icrf_from(frame(state.frame)) * clones.mean_direction();
          const Direction direction = mean.isZero(0.0) ? Direction{} : direction_of(mean);
          *to++ = kDegreesPerRad * direction.longitude_rad;
          *to++ = kDegreesPerRad * direction.latitude_rad;
          *to++ = kDegreesPerRad * clones.direction_spread_rad();
          for (const double part : sizes) *to++ = angle_deg(clones.direction_angle, part);
          for (const std::uint64_t mode : clones.modes) {
            *to++ = static_cast<double>(mode) / static_cast<double>(clones.count);
          }
          for (const Histogram* histogram : {&clones.rate, &clones.polhode_period, &clones.precession_period}) {
            for (const double part : signed_parts) {
              const double deviation = histogram->quantile(part);
              *to++ = deviation < -1.0 ? -1.0 : deviation;
            }
          }
        }
      },
      {}, 1);
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
  const CloneSource source(sample.moving.body, sample.moving.frame, sample.seed, sample.uniform);
  const ElapsedTimes elapsed(sample);
  const auto fill = [&](std::size_t first, std::span<double> out) {
    const std::size_t last = first + out.size() / width;
    const std::size_t first_clone = first / times, last_clone = (last + times - 1) / times;
    std::vector<FreeBody> bodies;
    std::vector<double> q, m;
    for (std::size_t at = first_clone; at < last_clone; at += kAtOnce) {
      bodies.clear();
      for (std::size_t i = at; i < std::min(last_clone, at + kAtOnce); ++i) {
        bodies.push_back(source.clone(part.first + i));
      }
      states_of_bodies(sample, bodies, elapsed, q, m);
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        for (std::size_t j = 0; j < times; ++j) {
          const std::size_t row = (at + i) * times + j, here = i * times + j;
          if (row < first || row >= last) continue;
          const NamedState named = named_state(
              bodies[i],
              {Quaternion(q[4 * here], q[4 * here + 1], q[4 * here + 2], q[4 * here + 3]), Vector3(&m[3 * here])});
          double* to = out.data() + (row - first) * width;
          *to++ = static_cast<double>(part.first + at + i);
          *to++ = fits ? about.times_s[j] : static_cast<double>(j);
          const Eigen::Vector4d q_row = scalar_first(named.q_inertial_from_named);
          for (const int k : {1, 2, 3, 0}) *to++ = q_row[k];
          for (int k = 0; k < 3; ++k) *to++ = named.omega_named_rad_s[k];
        }
      }
    }
  };
  write_number_table(path, table, fill, progress, thread_count);
}

}  // namespace polhode
