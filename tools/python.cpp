#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "polhode/base/error.hpp"
#include "subcommands.hpp"

namespace polhode::tools {
namespace {

/// The Python that has the package: the one that started this program, that of the source tree, or that on the PATH.
std::string python() {
  if (const char* const named = std::getenv("POLHODE_PYTHON")) return named;
  std::error_code none;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path beside = program.parent_path().parent_path() / "venv/bin/python";
  return std::filesystem::exists(beside, none) ? beside.string() : "python3";
}

/// Goes on as that Python; `arguments` are of the subcommand.
void go_on(const std::string& subcommand, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{python(), "-m", "polhode", subcommand};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execvp(argv.front(), argv.data());
  throw FileError(words.front() + " cannot be started, which '" + subcommand +
                  "' needs with the Python package: " + std::strerror(errno));
}

void add(CLI::App& app, const std::string& name, const std::string& description) {
  CLI::App* command = app.add_subcommand(name, description);
  command->set_help_flag();  // Python has the options
  command->prefix_command();
  command->callback([command, name] { go_on(name, command->remaining()); });
}

}  // namespace

void add_python(CLI::App& app) {
  add(app, "fit", "A spin state and ratios of inertia from measurements (needs the Python package)");
  add(app, "animate", "A film of a body's motion, or a glTF file of it (needs the Python package)");
  add(app, "look", "A picture of a body as an observer sees it, or a strip of them (needs the Python package)");
  add(app, "plot", "Pictures of a body's motion, and the figures of a chart (needs the Python package)");
  add(app, "spice", "SPICE kernels of an attitude ephemeris in FITS (needs the Python package)");
}

}  // namespace polhode::tools
