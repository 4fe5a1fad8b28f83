#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/motion/free_bodies.hpp"
#include "polhode/motion/partials.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/read/case_file.hpp"
#include "rivals/registry.hpp"
#include "subcommands.hpp"
#include "whole_number.hpp"

namespace polhode::tools {
namespace {

struct BenchOptions {
  std::string case_file;
  std::string method = "auto";
  std::size_t count = 0;
  double tolerance_rad = 0.0;  // 0: not given
};

constexpr int kRounds = 9;  // every quantity is measured in each round; the median counts
constexpr std::size_t kNeighbours = 64;
constexpr double kLongSolve_ns = 2e7;  // neighbours that take longer are solved in one round only

/// The measurements of one quantity, in nanoseconds per item.
class Quantity {
 public:
  template <class Work>
  void measure(std::size_t items, const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
    ns_.push_back(elapsed.count() / static_cast<double>(items));
  }
  /// Of work on all cores: those that slept are awake when it is measured.
  template <class Work>
  void measure_awake(std::size_t items, const Work& work) {
    work();
    measure(items, work);
  }
  double median() const {
    std::vector<double> sorted = ns_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }

 private:
  std::vector<double> ns_;
};

/// For arrays larger than the caches: asks the system for huge pages (Linux, where it is set to give them), without
/// which a fifth of the time goes into looking up addresses.
template <class T>
struct HugePages {
  using value_type = T;
  static constexpr std::align_val_t page{std::size_t{2} << 20};
  static T* allocate(std::size_t n) {
    constexpr auto whole = static_cast<std::size_t>(page);
    const std::size_t bytes = (n * sizeof(T) + whole - 1) / whole * whole;
    void* p = ::operator new(bytes, page);
#ifdef MADV_HUGEPAGE
    madvise(p, bytes, MADV_HUGEPAGE);  // only advice
#endif
    return static_cast<T*>(p);
  }
  static void deallocate(T* p, std::size_t) { ::operator delete(p, page); }
  bool operator==(const HugePages&) const = default;
};
using Array = std::vector<double, HugePages<double>>;

/// Times drawn evenly over the case's own range; the order is that of the draw, the same in every run.
Array irregular_times(const std::vector<double>& own, std::size_t count) {
  const auto [first, last] = std::minmax_element(own.begin(), own.end());
  std::mt19937_64 random(20200602);
  Array times(count);
  for (double& t : times) {
    const double fraction = std::ldexp(static_cast<double>(random() >> 11), -53);  // std distributions vary by library
    t = std::lerp(*first, *last, fraction);
  }
  return times;
}

/// Bodies whose moments and momenta differ from these by up to a thousandth.
std::vector<FreeBody> neighbours_of(const FreeBody& body) {
  std::mt19937_64 random(20200602);
  std::vector<FreeBody> all(kNeighbours, body);
  for (FreeBody& one : all) {
    for (int k = 0; k < 3; ++k) {
      const auto change = [&] { return 1.0 + 1e-3 * (std::ldexp(static_cast<double>(random() >> 11), -52) - 1.0); };
      one.principal_moments[k] *= change();
      one.momentum_body[k] *= change();
    }
    std::sort(one.principal_moments.begin(), one.principal_moments.end());
  }
  return all;
}

/// The motion under a case's torques: solved over the span of its times, and asked at evenly spaced ones; and that of
/// its neighbours, one after the other.
void bench_torqued(const BenchOptions& options, const CaseFile& wanted) {
  if (!(options.tolerance_rad > 0.0 && std::isfinite(options.tolerance_rad))) {
    throw InputError("has torques ('T' lines): --tolerance is wanted, a positive angle in radians");
  }
  if (options.method != "auto") throw InputError("--method is for free motion; under torques bench takes no other");
  const auto [first, last] = std::minmax_element(wanted.times_s.begin(), wanted.times_s.end());
  TorquedOptions how{options.tolerance_rad, std::min(0.0, *first), std::max(0.0, *last)};
  how.max_torque_evaluations = usual_torque_evaluations(wanted.torques);
  const std::size_t count = options.count;
  Array times(count), q(4 * count), m(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    times[i] = std::lerp(how.first_s, how.last_s, (static_cast<double>(i) + 0.5) / static_cast<double>(count));
  }
  const std::vector<FreeBody> neighbours = neighbours_of(wanted.body);
  Quantity solve, at, bodies;
  double sum = 0.0;
  std::unique_ptr<const TorquedMotion> motion;
  for (int round = 0; round < kRounds; ++round) {
    solve.measure(1, [&] { motion = std::make_unique<const TorquedMotion>(wanted.body, wanted.torques, how); });
    at.measure(count, [&] { motion->batch({times}, StateArrays::of_structures(q.data(), m.data())); });
    if (round > 0 && solve.median() > kLongSolve_ns) continue;
    bodies.measure(kNeighbours, [&] {
      for (const FreeBody& body : neighbours)
        sum += TorquedMotion(body, wanted.torques, how).at(how.last_s).momentum_body[0];
    });
  }
  const double checksum = std::accumulate(q.begin(), q.end(), 0.0) + std::accumulate(m.begin(), m.end(), 0.0) + sum;
  write_standard_output(
      fmt::format("method={}\noutcome={}\ncount={}\nsolve_ns={:.0f}\nat_ns={:.2f}\nbodies_solve_ns={:.0f}\n"
                  "error_rad={:.2e}\nevaluations={}\nsteps={}\nchecksum={:.17g}\n",
                  motion->method(), outcome_name(motion->outcome()), count, solve.median(), at.median(),
                  bodies.median(), motion->error_rad(), motion->torque_evaluations(), motion->steps(), checksum));
  if (motion->outcome() != Outcome::done) {
    throw CheckFailed(fmt::format("{}: the tolerance of {} rad is not kept: {}", options.case_file,
                                  options.tolerance_rad, outcome_name(motion->outcome())));
  }
}

/// The partial derivatives of the free motion: `key=value` lines, and what the results sum up to.
std::string bench_partials(const FreeBody& body, const Array& times, std::size_t builds, double& checksum) {
  const std::size_t count = times.size();
  constexpr std::size_t numbers = 7 + 54;
  Array q(4 * count), m(3 * count), matrices(54 * count), copied(numbers * count), source(numbers * count, 1.0);
  const StateArrays states = StateArrays::of_structures(q.data(), m.data());
  const FreePartials partials(body);
  Quantity construct, single, batch, copy;
  for (int round = 0; round < kRounds; ++round) {
    construct.measure(builds, [&] {
      for (std::size_t i = 0; i < builds; ++i) {
        FreeBody other = body;
        other.momentum_body *= 1.0 + 1e-9 * static_cast<double>(i);  // never the same body twice
        checksum += FreePartials(other).at(0.0).partials(0, 0);
      }
    });
    single.measure(count, [&] {
      for (const double t : times) checksum += partials.at(t).partials(1, 4) != 0.0 ? 1.0 : 0.5;
    });
    batch.measure(count, [&] { partials.batch({times}, states, matrices); });
    copy.measure(count, [&] { std::memcpy(copied.data(), source.data(), numbers * sizeof(double) * count); });
    source[static_cast<std::size_t>(round) % source.size()] += copied[count / 2];
  }
  checksum += std::accumulate(q.begin(), q.end(), 0.0) + copied[0];
  return fmt::format(
      "construct_partials_ns={:.1f}\nsingle_partials_ns={:.2f}\nbatch_partials_ns={:.2f}\ncopy_partials_ns={:.2f}\n",
      construct.median(), single.median(), batch.median(), copy.median());
}

/// Many bodies, neighbours of the case's: each built and answered at the last of its times. The short form is measured
/// over the longest span for which it keeps 1e-9 rad for each of them.
std::string bench_bodies(const FreeBody& body, const std::vector<double>& times, std::size_t count, double& checksum) {
  Array moments(3 * count), q(4 * count), momentum(3 * count), q_out(4 * count), m_out(3 * count);
  std::mt19937_64 random(20200602);
  const auto nearby = [&random] { return 1.0 + 1e-3 * std::ldexp(static_cast<double>(random() >> 11), -53); };
  for (std::size_t i = 0; i < count; ++i) {
    Vector3 varied = body.principal_moments;
    if (varied[0] < varied[1]) varied[0] /= nearby();
    if (varied[1] < varied[2]) varied[2] *= nearby();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      moments[3 * i + k] = varied[row];
      momentum[3 * i + k] = body.momentum_body[row] * nearby();
    }
    for (std::size_t k = 0; k < 4; ++k)
      q[4 * i + k] = scalar_first(body.q_inertial_from_body)[static_cast<Eigen::Index>(k)];
  }
  const BodyArrays bodies = BodyArrays::of_structures(moments.data(), q.data(), momentum.data(), count);
  const std::vector<double> last{times.back()};
  const StateArrays out = StateArrays::of_structures(q_out.data(), m_out.data());
  constexpr double kept_rad = 1e-9;
  // Of the sum of the rates 2 rho + nu, which short_form_error_rad() asks for, three turns a rotation are a bound.
  const double rate_rad_s = body.momentum_body.norm() / body.principal_moments[0] * (1.0 + 3e-3);
  const BodiesOptions brief{kept_rad / 0x1p-52 / 17.0 / (3.0 * rate_rad_s), kept_rad, 1};
  Quantity any_span, short_span, threads;
  for (int round = 0; round < kRounds; ++round) {
    any_span.measure(count, [&] { free_body_states(bodies, {last}, out, {}); });
    short_span.measure(count, [&] { free_body_states(bodies, {last}, out, {}, brief); });
    threads.measure_awake(count, [&] { free_body_states(bodies, {last}, out, {}, {.thread_count = 0}); });
  }
  checksum += std::accumulate(q_out.begin(), q_out.end(), 0.0) + std::accumulate(m_out.begin(), m_out.end(), 0.0);
  const FreeBodies kept(bodies, brief);
  return fmt::format(
      "bodies_ns={:.1f}\nbodies_short_ns={:.1f}\nbodies_threads_ns={:.1f}\nbodies_alone={}\nbodies_short={}\n",
      any_span.median(), short_span.median(), threads.median(), kept.built_alone(), kept.short_forms());
}

void bench(const BenchOptions& options) {
  const Method& chosen = in_option(
      "--method", [&]() -> auto& { return rivals::measured_method(options.method); });
  const CaseFile wanted = read_case_file(options.case_file);
  if (!wanted.torques.empty()) {
    bench_torqued(options, wanted);
    return;
  }
  if (options.tolerance_rad != 0.0) {
    throw InputError("--tolerance is for motion under torques, of which the file has none");
  }
  const auto make_short = chosen.make_short != nullptr ? chosen.make_short : chosen.make;
  const std::unique_ptr<Motion> motion = chosen.make(wanted.body);

  const std::size_t count = options.count;
  const Array times = irregular_times(wanted.times_s, count);
  const TimeArrays instants{times};
  Array q(4 * count), m(3 * count), copied(7 * count), source(7 * count, 1.0);
  const StateArrays both = StateArrays::of_structures(q.data(), m.data());
  const StateArrays attitude = StateArrays::of_structures(q.data(), nullptr);
  const std::size_t builds = std::clamp<std::size_t>(count / 100, 1, 1000);

  Quantity construct, construct_short, single, batch, batch_attitude, copy, threads, copy_threads;
  double checksum = 0.0;
  const auto build = [&](auto make) {
    for (std::size_t i = 0; i < builds; ++i) {
      FreeBody body = wanted.body;
      body.momentum_body *= 1.0 + 1e-9 * static_cast<double>(i);  // never the same body twice
      checksum += make(body)->at(0.0).momentum_body[0];
    }
  };
  const auto copy_items = [&](std::size_t begin, std::size_t end) {
    std::memcpy(copied.data() + 7 * begin, source.data() + 7 * begin, 7 * sizeof(double) * (end - begin));
  };
  for (int round = 0; round < kRounds; ++round) {
    construct.measure(builds, [&] { build(chosen.make); });
    construct_short.measure(builds, [&] { build(make_short); });
    single.measure(count, [&] {
      for (const double t : times) {
        const State s = motion->at(t);
        checksum += s.q_inertial_from_body.w() + s.momentum_body[0];
      }
    });
    batch.measure(count, [&] { motion->batch(instants, both); });
    batch_attitude.measure(count, [&] { motion->batch(instants, attitude); });
    copy.measure(count, [&] { copy_items(0, count); });
    threads.measure_awake(count, [&] { batch_threads(*motion, instants, both); });
    copy_threads.measure_awake(count, [&] { parallel_chunks(count, 512, 0, copy_items); });
    // Each copy differs from the last, so that none can be left out.
    source[static_cast<std::size_t>(round) % source.size()] += copied[count / 2];
  }
  checksum += std::accumulate(q.begin(), q.end(), 0.0) + std::accumulate(m.begin(), m.end(), 0.0) +
              std::accumulate(copied.begin(), copied.end(), 0.0);
  std::string partials;
  if (options.method == "auto") {
    partials = bench_partials(wanted.body, times, builds, checksum);
    partials += bench_bodies(wanted.body, wanted.times_s, count, checksum);
  }

  write_standard_output(fmt::format(
      "method={}\ncount={}\nconstruct_ns={:.1f}\nconstruct_short_ns={:.1f}\nsingle_ns={:.2f}\nbatch_ns={:.2f}\n"
      "batch_attitude_ns={:.2f}\ncopy_ns={:.2f}\nthreads_ns={:.2f}\ncopy_threads_ns={:.2f}\n{}checksum={:.17g}\n",
      chosen.name, count, construct.median(), construct_short.median(), single.median(), batch.median(),
      batch_attitude.median(), copy.median(), threads.median(), copy_threads.median(), partials, checksum));
  if (!std::isfinite(checksum)) throw CheckFailed(fmt::format("method {} gave rows that are not finite", chosen.name));
}

}  // namespace

void add_bench(CLI::App& app) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command =
      app.add_subcommand("bench", "Time a method on a case file: nanoseconds per item, key=value lines");
  command->footer(
      "Examples:\n  polhode bench data/truth/dev/sam-01.case 100000\n"
      "  polhode bench --tolerance 1e-9 data/truth/torqued/envisat-fast-01.case 10000");
  command->add_option("--method", options->method, "Name from `polhode methods`, or auto")->capture_default_str();
  command->add_option("--tolerance", options->tolerance_rad, "Wanted attitude error in radians, under torques");
  command->add_option("CASEFILE", options->case_file, "Body at t = 0; its times give the range")->required();
  add_whole_number(*command, "COUNT", options->count, 1, 100'000'000, "How many times")->required();
  command->callback([options] { in_file(options->case_file, [&] { bench(*options); }); });
}

}  // namespace polhode::tools
