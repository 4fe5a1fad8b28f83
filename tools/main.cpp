// The program `polhode`: one subcommand per file, no mathematics here.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>

#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/output_file.hpp"
#include "signals.hpp"
#include "subcommands.hpp"

namespace {

int fail(int status, const std::exception& error) {
  polhode::tools::say(error.what());
  return status;
}

/// Says which word is no subcommand, where that is why one is missing.
void refuse_unknown_subcommand(const CLI::App& app) {
  for (const CLI::App* chosen : app.get_subcommands()) refuse_unknown_subcommand(*chosen);
  if (app.get_require_subcommand_min() == 0 || !app.get_subcommands().empty() || app.remaining().empty()) return;
  std::string known;
  for (const CLI::App* one : app.get_subcommands({})) known += (known.empty() ? "" : ", ") + one->get_name();
  throw polhode::InputError("'" + app.remaining().front() + "' is no subcommand; allowed are " + known);
}

int run(int argc, char** argv) {
  CLI::App app{"Attitude of tumbling bodies: exact free motion, ephemerides, checks"};
  app.name("polhode");
  app.set_version_flag("--version", polhode::creator(), "Say the version and end");
  app.require_subcommand(1);
  polhode::tools::add_compare(app);
  polhode::tools::add_chart(app);
  polhode::tools::add_eval(app);
  polhode::tools::add_info(app);
  polhode::tools::add_convert_time(app);
  polhode::tools::add_convert_frame(app);
  polhode::tools::add_methods(app);
  polhode::tools::add_bench(app);
  polhode::tools::add_observe(app);
  polhode::tools::add_plan(app);
  polhode::tools::add_population(app);
  polhode::tools::add_propagate(app);
  polhode::tools::add_sample(app);
  polhode::tools::add_python(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RequiredError& error) {
    refuse_unknown_subcommand(app);
    polhode::tools::say(error.what());
    return 2;
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, complaint;
    const bool asked_for = app.exit(error, out, complaint) == 0;  // --help
    polhode::tools::write_standard_output(out.str());
    std::fputs(complaint.str().c_str(), stderr);
    return asked_for ? 0 : 2;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  polhode::tools::prepare_for_signals_and_closed_streams();
  try {
    return run(argc, argv);
  } catch (const polhode::tools::CheckFailed& error) {
    return fail(1, error);
  } catch (const polhode::ComputationError& error) {
    return fail(1, error);
  } catch (const polhode::InputError& error) {
    return fail(2, error);
  } catch (const polhode::PipeClosed& error) {
    polhode::tools::end_by_broken_pipe();
    return fail(3, error);
  } catch (const polhode::FileError& error) {
    return fail(3, error);
  } catch (const std::bad_alloc&) {
    std::string command = "there is not enough memory for: polhode";
    for (int i = 1; i < argc; ++i) command.append(" ").append(argv[i]);
    return fail(3, std::runtime_error(command));
  } catch (const std::exception& error) {
    return fail(3, error);
  }
}
