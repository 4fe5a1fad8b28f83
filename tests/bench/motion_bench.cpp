// Time per instant of the exact methods on bodies of every kind, with the largest error on the reference corpus beside
// it: attitude_eps and momentum_eps, in units of 2^-52, over the rows whose condition number is at most 1e14.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "rivals/registry.hpp"
#include "support/truth.hpp"

namespace polhode {
namespace {

const char* const kCases[] = {"lam-01",        "sam-01",           "needle-01",  "disc-01",
                              "nearsphere-01", "nearsep-01",       "nearsep-10", "sepexact-01",
                              "nearprin2-02",  "real-toutatis-01", "sym12-01",   "sphere-01"};

void state_errors(benchmark::State& state, const Motion& motion, const test::TruthCase& c) {
  double attitude = 0.0, momentum = 0.0;
  for (const test::TruthRow& row : c.rows) {
    if (row.kappa > 1e14) continue;
    const test::RowError e = test::row_error(motion.at(row.t_s), row);
    attitude = std::max(attitude, e.attitude_eps);
    momentum = std::max(momentum, e.momentum_eps);
  }
  state.counters["attitude_eps"] = attitude;
  state.counters["momentum_eps"] = momentum;
}

std::vector<double> even_times(const test::TruthCase& c, std::size_t count) {
  const auto [first, last] = std::minmax_element(c.question.times_s.begin(), c.question.times_s.end());
  std::vector<double> times(count);
  for (std::size_t i = 0; i < count; ++i) {
    times[i] = *first + (*last - *first) * static_cast<double>(i) / static_cast<double>(count);
  }
  return times;
}

void batch(benchmark::State& state, const Method& method, const test::TruthCase& c) {
  const auto motion = method.make(c.question.body);
  const std::vector<double> times = even_times(c, 4096);
  std::vector<double> q(4 * times.size()), m(3 * times.size());
  for (auto _ : state) {
    motion->batch({times}, StateArrays::of_structures(q.data(), m.data()));
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(times.size()) * static_cast<std::int64_t>(state.iterations()));
  state_errors(state, *motion, c);
}

void single(benchmark::State& state, const Method& method, const test::TruthCase& c) {
  const auto motion = method.make(c.question.body);
  const std::vector<double> times = even_times(c, 4096);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(motion->at(times[i++ % times.size()]));
  state_errors(state, *motion, c);
}

void construct(benchmark::State& state, const Method& method, bool brief, const test::TruthCase& c) {
  const auto make = brief ? method.make_short : method.make;
  for (auto _ : state) benchmark::DoNotOptimize(make(c.question.body));
  state_errors(state, *method.make(c.question.body), c);
}

void register_all() {
  static const std::vector<test::TruthCase> cases = test::truth_cases(POLHODE_DATA_DIR "/truth/dev");
  for (const char* name : kCases) {
    const auto c = std::find_if(cases.begin(), cases.end(), [name](const auto& one) { return one.name == name; });
    if (c == cases.end()) throw std::runtime_error(std::string("no case ") + name);
    for (const rivals::MeasuredMethod& one : rivals::measured_methods()) {
      if (one.kind != "exact") continue;
      const std::string end = fmt::format("/{}/{}", one.name, name);
      benchmark::RegisterBenchmark(fmt::format("batch{}", end).c_str(),
                                   [&one, c](benchmark::State& s) { batch(s, one, *c); });
      benchmark::RegisterBenchmark(fmt::format("single{}", end).c_str(),
                                   [&one, c](benchmark::State& s) { single(s, one, *c); });
      benchmark::RegisterBenchmark(fmt::format("construct{}", end).c_str(),
                                   [&one, c](benchmark::State& s) { construct(s, one, false, *c); });
      if (one.make_short == nullptr) continue;
      benchmark::RegisterBenchmark(fmt::format("construct_short{}", end).c_str(),
                                   [&one, c](benchmark::State& s) { construct(s, one, true, *c); });
    }
  }
}

}  // namespace
}  // namespace polhode

int main(int argc, char** argv) {
  try {
    polhode::register_all();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
