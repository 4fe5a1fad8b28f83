#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dates.hpp"
#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/session/population.hpp"
#include "subcommands.hpp"
#include "utc.hpp"
#include "write_ephemeris.hpp"

namespace polhode::tools {
namespace {

struct PopulationOptions {
  std::string table, output, times, epoch;
  std::string scale = "TDB";
  bool scale_given = false;
};

void propagate_population(const PopulationOptions& options) {
  check_number_table_path(options.output);
  const TimeScale scale = in_option("--scale", [&] { return time_scale(options.scale); });
  const DateRule rule{scale, options.scale_given ? std::optional(scale) : std::nullopt};
  UtcDoubts doubts;
  std::optional<Instant> epoch;
  if (!options.epoch.empty()) {
    epoch = in_option("--epoch", [&] { return date_or_now(options.epoch, rule.unsaid).instant; });
    doubts.look_at(*epoch);
  }
  const std::vector<Instant> instants = in_option("--times", [&] { return wanted_dates(options.times, rule, doubts); });
  OutputOptions output;
  output.path = options.output;
  const std::vector<std::string> inputs{options.table, options.times, leap_seconds_file()};
  refuse_overwriting(output, inputs);
  const Population population = read_population(options.table, epoch);
  write_watched(options.output, population.size() * instants.size(), [&](const Progress& progress) {
    write_population(options.output, population, instants, scale, progress);
  });
}

}  // namespace

void add_population(CLI::App& app) {
  const auto options = std::make_shared<PopulationOptions>();
  CLI::App* command = app.add_subcommand("population", "A table of free bodies to their states at given times");
  command->footer(
      "Columns of the table: I1, I2, I3 (principal moments, ascending), q_x, q_y, q_z, q_scalar, omega_body_x_rad_s, "
      "_y_, "
      "_z_, and a date of the epoch (date_tdb, jd_utc ...); name. FITS, table BODIES: MOMENTS, QPARAM, OMEGA, TIME.\n"
      "Example:\n  polhode population debris.csv --epoch \"2027-01-01 UTC\" --times \"2027-02-01 UTC\" -o states.fits");
  command->add_option("TABLE", options->table, "Bodies, one a row: CSV, ECSV, FITS")->required();
  command
      ->add_option("-o,--output", options->output, "Output; its ending says the format: " + endings_of_number_tables())
      ->required();
  command
      ->add_option("--times", options->times,
                   "Dates separated by commas, or a file: one date a line, or a table with a column of dates")
      ->required();
  command->add_option("--epoch", options->epoch, "Epoch of all bodies, in place of a column of dates");
  command
      ->add_option("--scale", options->scale, "Time scale of the rows, and where it is given of dates that name none")
      ->capture_default_str();
  add_leap_seconds(*command);
  command->callback([options, command] {
    options->scale_given = command->get_option("--scale")->count() > 0;
    in_file(options->table, [&] { propagate_population(*options); });
  });
}

}  // namespace polhode::tools
