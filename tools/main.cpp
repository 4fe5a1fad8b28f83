// The program `polhode`: one subcommand per file, no mathematics here.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "polhode/base/error.hpp"
#include "subcommands.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Attitude of tumbling bodies: exact free motion, ephemerides, checks"};
  app.name("polhode");
  app.require_subcommand(1);
  polhode::tools::add_eval(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const polhode::InputError& error) {
    std::fprintf(stderr, "polhode: %s\n", error.what());
    return 2;
  } catch (const polhode::FileError& error) {
    std::fprintf(stderr, "polhode: %s\n", error.what());
    return 3;
  }
  return 0;
}
