#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/motion/partials.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/motion/torqued_partials.hpp"
#include "polhode/read/case_file.hpp"
#include "polhode/read/quantity.hpp"
#include "rivals/registry.hpp"
#include "rivals/torqued_methods.hpp"
#include "subcommands.hpp"
#include "whole_number.hpp"

namespace polhode::tools {
namespace {

struct EvalOptions {
  std::string case_file;
  std::string method = "auto";
  double tolerance_rad = 1e-12;      // for propagation under torques and for integrators; the exact methods need none
  double step_s = 0.0;               // for integrators of fixed step; 0 is the method's choice
  std::size_t most_evaluations = 0;  // of torques; 0: some seconds of work
  bool partials = false;
};

std::unique_ptr<Motion> make_free_motion(const FreeBody& body, const EvalOptions& options) {
  const rivals::MeasuredMethod& chosen = in_option(
      "--method", [&]() -> auto& { return rivals::measured_method(options.method); });
  if (options.most_evaluations != 0) throw InputError("--max-evaluations is for torques; the case file has none");
  if (options.step_s != 0.0 && !chosen.fixed_step()) {
    throw OptionError(fmt::format("--step is for methods of fixed step, {} is not one of them", chosen.name));
  }
  if (!chosen.make_controlled) return chosen.make(body);
  constexpr std::int64_t most_evaluations = 50'000'000;  // some seconds: what takes longer answers NaN
  return chosen.make_controlled(
      body, {.step_s = options.step_s, .tolerance = options.tolerance_rad, .max_evaluations = most_evaluations});
}

std::unique_ptr<Motion> make_torqued_motion(const CaseFile& wanted, const EvalOptions& options) {
  const auto [first, last] = std::minmax_element(wanted.times_s.begin(), wanted.times_s.end());
  const double first_s = std::min(0.0, *first), last_s = std::max(0.0, *last);
  const std::size_t most_evaluations =
      options.most_evaluations != 0 ? options.most_evaluations : usual_torque_evaluations(wanted.torques);
  const auto own = torqued_motion_methods();
  if (std::find(own.begin(), own.end(), options.method) == own.end()) {
    return in_option("--method", [&] {
      return rivals::make_torqued_motion(options.method, wanted.body, wanted.torques,
                                         {.step_s = options.step_s,
                                          .tolerance = options.tolerance_rad,
                                          .max_evaluations = static_cast<std::int64_t>(most_evaluations)},
                                         first_s, last_s);
    });
  }
  if (options.step_s != 0.0) {
    throw OptionError(fmt::format("--step is for methods of fixed step, {} is not one of them", options.method));
  }
  auto motion = std::make_unique<TorquedMotion>(
      wanted.body, wanted.torques,
      TorquedOptions{options.tolerance_rad, first_s, last_s, options.method, most_evaluations});
  if (motion->outcome() == Outcome::stopped) {
    throw CheckFailed(fmt::format(
        "{}: stopped: {} s to {} s were reached after {} torque evaluations (method {}); allow more by "
        "--max-evaluations, or ask for earlier times or a larger --tolerance",
        options.case_file, motion->first_s(), motion->last_s(), motion->torque_evaluations(), motion->method()));
  }
  return motion;
}

/// Nothing that --partials has no use for.
void check_partials(const EvalOptions& options, const CaseFile& wanted) {
  if (!wanted.torques.empty()) {
    const auto own = torqued_motion_methods();
    if (std::find(own.begin(), own.end(), options.method) == own.end()) {
      throw OptionError(
          fmt::format("--partials of motion under torques is by {}, not by {}", fmt::join(own, ", "), options.method));
    }
    return;
  }
  if (options.method != "auto" || options.step_s != 0.0 || options.most_evaluations != 0) {
    throw OptionError("--partials of free motion is exact; --method, --step and --max-evaluations are not for it");
  }
}

void eval(const EvalOptions& options) {
  if (!(options.tolerance_rad >= smallest_tolerance_rad && std::isfinite(options.tolerance_rad))) {
    throw OptionError(fmt::format("--tolerance is {}, an angle of {} rad or more is wanted: doubles hold no less",
                                  options.tolerance_rad, smallest_tolerance_rad));
  }
  if (!(options.step_s >= 0.0 && std::isfinite(options.step_s))) {
    throw OptionError(fmt::format("--step is {}, a positive number of seconds is wanted", options.step_s));
  }
  const CaseFile wanted = read_case_file(options.case_file);
  const std::size_t count = wanted.times_s.size();
  std::vector<double> q(4 * count), m(3 * count), matrices;
  const StateArrays states = StateArrays::of_structures(q.data(), m.data());
  std::unique_ptr<Motion> motion;
  if (options.partials) {
    check_partials(options, wanted);
    matrices.resize(PartialsMatrix::SizeAtCompileTime * count);
  }
  if (options.partials && wanted.torques.empty()) {
    FreePartials(wanted.body).batch({wanted.times_s}, states, matrices);
  } else {
    motion = wanted.torques.empty() ? make_free_motion(wanted.body, options) : make_torqued_motion(wanted, options);
    motion->batch({wanted.times_s}, states);
    if (options.partials) {
      TorquedPartials(dynamic_cast<const TorquedMotion&>(*motion), {}).batch({wanted.times_s}, matrices);
    }
  }

  fmt::memory_buffer text;
  std::size_t failed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    bool finite = true;
    const char* before = "";
    for (const std::vector<double>* rows : {&q, &m, &matrices}) {
      const std::size_t width = rows->size() / count;
      for (const double value : std::span(*rows).subspan(width * i, width)) {
        finite = finite && std::isfinite(value);
        fmt::format_to(std::back_inserter(text), "{}{:.17g}", before, value);
        before = " ";
      }
    }
    text.push_back('\n');
    if (!finite) ++failed;
  }
  if (failed != 0) {
    throw CheckFailed(
        fmt::format("{}: {} of {} times have no answer by method {} within its limit of work; nothing is written",
                    options.case_file, failed, wanted.times_s.size(), options.method));
  }
  write_standard_output({text.data(), text.size()});
  const auto* torqued = dynamic_cast<const TorquedMotion*>(motion.get());
  if (torqued != nullptr && torqued->outcome() != Outcome::done) {
    throw CheckFailed(fmt::format("{}: {}: the estimated error is {:.1e} rad, {:.1e} rad was asked for (method {})",
                                  options.case_file, outcome_name(torqued->outcome()), torqued->error_rad(),
                                  options.tolerance_rad, torqued->method()));
  }
}

}  // namespace

void add_eval(CLI::App& app) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = app.add_subcommand("eval", "States of a case file: a line q0 q1 q2 q3 m1 m2 m3 per time");
  command->footer(
      "Examples:\n  polhode eval data/truth/dev/sam-01.case\n"
      "  polhode eval --method legendre data/truth/dev/sam-01.case\n"
      "  polhode eval --partials data/truth/dev/sam-01.case\n"
      "  polhode eval --tolerance 1e-8 data/truth/torqued/combined-01.case");
  command
      ->add_option(
          "--method", options->method,
          "Name from `polhode methods`, or auto; under torques series, dormand-prince or a method to compare with")
      ->capture_default_str();
  command
      ->add_option("--tolerance", options->tolerance_rad,
                   "Wanted attitude error in radians, under torques; tolerance of an adaptive integrator")
      ->capture_default_str();
  command->add_option("--step", options->step_s, "Step of a fixed-step integrator in seconds; 0: a hundredth of a turn")
      ->capture_default_str();
  add_whole_number(*command, "--max-evaluations", options->most_evaluations, 1, most_evaluations_asked,
                   "Under torques: most torque evaluations to spend")
      ->default_str("8000000 of one torque, fewer of several");
  command->add_flag("--partials", options->partials,
                    "Go on after m3 with d(theta, m)/d(theta0, m0, I), 6 x 9 row by row");
  command->add_option("CASEFILE", options->case_file, "Body at t = 0 and times")->required();
  command->callback([options] { in_file(options->case_file, [&] { eval(*options); }); });
}

}  // namespace polhode::tools
