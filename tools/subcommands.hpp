#pragma once

#include <CLI/App.hpp>
#include <stdexcept>

namespace polhode::tools {

/// The work was done, but a check or a row of the answer failed (exit status 1).
class CheckFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Each adds its subcommand to the program; the work is done in the callback, which throws InputError (exit status 2),
// FileError (3) or CheckFailed (1).
void add_bench(CLI::App& app);
void add_compare(CLI::App& app);
void add_chart(CLI::App& app);
void add_eval(CLI::App& app);
void add_info(CLI::App& app);
void add_convert_time(CLI::App& app);
void add_convert_frame(CLI::App& app);
void add_methods(CLI::App& app);
void add_observe(CLI::App& app);
void add_plan(CLI::App& app);
void add_population(CLI::App& app);
void add_propagate(CLI::App& app);
void add_sample(CLI::App& app);
void add_python(CLI::App& app);  // animate, fit, look, plot, spice

}  // namespace polhode::tools
