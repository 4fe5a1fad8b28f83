#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <string>

#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/read/case_file.hpp"
#include "subcommands.hpp"

namespace polhode::tools {
namespace {

struct EvalOptions {
  std::string case_file;
  std::string method = "auto";
  double tolerance_rad = 1e-12;  // free motion is exact: only propagation under torques will look at it
};

void eval(const EvalOptions& options) {
  if (!(options.tolerance_rad > 0.0)) {
    throw InputError(fmt::format("--tolerance is {}, a positive angle in radians is wanted", options.tolerance_rad));
  }
  const Method& chosen = method(options.method);
  const CaseFile wanted = read_case_file(options.case_file);
  const std::unique_ptr<FreeMotion> motion = chosen.make(wanted.body);

  fmt::memory_buffer text;
  std::size_t failed = 0;
  for (const double t : wanted.times_s) {
    const FreeState state = motion->at(t);
    const Eigen::Vector4d q = scalar_first(state.q_inertial_from_body);
    const Vector3& m = state.momentum_body;
    if (!(q.allFinite() && m.allFinite())) ++failed;
    fmt::format_to(std::back_inserter(text), "{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", q[0], q[1],
                   q[2], q[3], m[0], m[1], m[2]);
  }
  write_standard_output({text.data(), text.size()});
  if (failed != 0) {
    throw CheckFailed(
        fmt::format("{} of {} rows are not finite (method {})", failed, wanted.times_s.size(), chosen.name));
  }
}

}  // namespace

void add_eval(CLI::App& app) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = app.add_subcommand("eval", "States of a case file: a line q0 q1 q2 q3 m1 m2 m3 per time");
  command->add_option("--method", options->method, "Name from `polhode methods`, or auto")->capture_default_str();
  command->add_option("--tolerance", options->tolerance_rad, "Wanted attitude error in radians, under torques")
      ->capture_default_str();
  command->add_option("CASEFILE", options->case_file, "Body at t = 0 and times")->required();
  command->callback([options] { eval(*options); });
}

}  // namespace polhode::tools
