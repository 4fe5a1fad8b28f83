// The program `polhode`: one subcommand per file, no mathematics here.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "polhode/base/error.hpp"
#include "subcommands.hpp"

namespace {

int fail(int status, const std::exception& error) {
  std::fprintf(stderr, "polhode: %s\n", error.what());
  return status;
}

int run(int argc, char** argv) {
  CLI::App app{"Attitude of tumbling bodies: exact free motion, ephemerides, checks"};
  app.name("polhode");
  app.require_subcommand(1);
  polhode::tools::add_compare(app);
  polhode::tools::add_chart(app);
  polhode::tools::add_eval(app);
  polhode::tools::add_info(app);
  polhode::tools::add_convert_time(app);
  polhode::tools::add_convert_frame(app);
  polhode::tools::add_methods(app);
  polhode::tools::add_bench(app);
  polhode::tools::add_plan(app);
  polhode::tools::add_propagate(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const polhode::tools::CheckFailed& error) {
    return fail(1, error);
  } catch (const polhode::ComputationError& error) {
    return fail(1, error);
  } catch (const polhode::InputError& error) {
    return fail(2, error);
  } catch (const polhode::FileError& error) {
    return fail(3, error);
  } catch (const std::bad_alloc&) {
    return fail(3, std::runtime_error("there is not enough memory for this"));
  } catch (const std::exception& error) {
    return fail(3, error);
  }
}
