#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/read/case_file.hpp"
#include "polhode/read/quantity.hpp"
#include "rivals/registry.hpp"
#include "rivals/splitting_schemes.hpp"
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
};

std::unique_ptr<Motion> make_free_motion(const FreeBody& body, const EvalOptions& options) {
  const rivals::MeasuredMethod& chosen = in_option(
      "--method", [&]() -> auto& { return rivals::measured_method(options.method); });
  if (options.most_evaluations != 0) throw InputError("--max-evaluations is for torques; the case file has none");
  if (options.step_s != 0.0 && !chosen.fixed_step()) {
    throw InputError(fmt::format("--step is for methods of fixed step, {} is not one of them", chosen.name));
  }
  if (!chosen.make_controlled) return chosen.make(body);
  constexpr std::int64_t most_evaluations = 50'000'000;  // some seconds: what takes longer answers NaN
  return chosen.make_controlled(
      body, {.step_s = options.step_s, .tolerance = options.tolerance_rad, .max_evaluations = most_evaluations});
}

std::unique_ptr<Motion> make_torqued_motion(const CaseFile& wanted, const EvalOptions& options) {
  if (options.step_s != 0.0)
    throw InputError("--step is for free motion; under torques --tolerance says how fine to be");
  const auto [first, last] = std::minmax_element(wanted.times_s.begin(), wanted.times_s.end());
  const std::size_t most_evaluations =
      options.most_evaluations != 0 ? options.most_evaluations : usual_torque_evaluations(wanted.torques);
  TorquedOptions how{options.tolerance_rad, std::min(0.0, *first), std::max(0.0, *last), options.method,
                     most_evaluations};
  const auto own = torqued_motion_methods();
  if (std::find(own.begin(), own.end(), how.method) == own.end()) {
    how.splitting = in_option("--method", [&] { return &rivals::splitting_scheme(options.method); });
  }
  auto motion = std::make_unique<TorquedMotion>(wanted.body, wanted.torques, how);
  if (motion->outcome() == Outcome::stopped) {
    throw CheckFailed(fmt::format(
        "{}: stopped: {} s to {} s were reached after {} torque evaluations (method {}); allow more by "
        "--max-evaluations, or ask for earlier times or a larger --tolerance",
        options.case_file, motion->first_s(), motion->last_s(), motion->torque_evaluations(), motion->method()));
  }
  return motion;
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
  const std::unique_ptr<Motion> motion =
      wanted.torques.empty() ? make_free_motion(wanted.body, options) : make_torqued_motion(wanted, options);
  const auto count = static_cast<Eigen::Index>(wanted.times_s.size());
  Eigen::Matrix4Xd quaternions(4, count);
  Eigen::Matrix3Xd momenta(3, count);
  motion->batch({wanted.times_s}, StateArrays::of_structures(quaternions.data(), momenta.data()));

  fmt::memory_buffer text;
  std::size_t failed = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector4d q = quaternions.col(i);
    const Vector3 m = momenta.col(i);
    if (!(q.allFinite() && m.allFinite())) ++failed;
    fmt::format_to(std::back_inserter(text), "{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", q[0], q[1],
                   q[2], q[3], m[0], m[1], m[2]);
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
      "  polhode eval --tolerance 1e-8 data/truth/torqued/combined-01.case");
  command
      ->add_option("--method", options->method,
                   "Name from `polhode methods`, or auto; under torques series, extrapolation or a splitting scheme")
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
  command->add_option("CASEFILE", options->case_file, "Body at t = 0 and times")->required();
  command->callback([options] { in_file(options->case_file, [&] { eval(*options); }); });
}

}  // namespace polhode::tools
