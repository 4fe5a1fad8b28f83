#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "dates.hpp"
#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/base/units.hpp"
#include "polhode/ephemeris/time_grid.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/read/time_table.hpp"
#include "polhode/session/sky_request.hpp"
#include "polhode/write/column_table.hpp"
#include "polhode/write/date_text.hpp"
#include "polhode/write/number_table.hpp"
#include "subcommands.hpp"
#include "utc.hpp"
#include "whole_number.hpp"
#include "write_ephemeris.hpp"

namespace polhode::tools {
namespace {

struct ObserveOptions {
  std::string body_file, output, start, stop, step, times, scale = "TDB";
  std::size_t count = 0;
  bool scale_given = false, covariance = false;
  std::string target, observer = "geocentre", sun, site, centre = "Sun", trajectory_frame;
  EarthOrientation earth;
  std::string convention = "long-axis", frame = "ECLIPJ2000";
  std::string shape, shape_unit, law = "lommel-seeliger", exposure;
  double lambert_weight = 0.1, specular = 0.0;
  std::optional<double> absolute_magnitude;
  std::vector<std::string> surfaces;
  std::vector<double> hg1g2, phase_polynomial;
};

/// The wanted instants, and what stands beside them in a table.
struct WantedRows {
  std::vector<Instant> instants;
  std::vector<std::string> dates;
  int decimals = 3;
  std::optional<TimeTable> table;
};

/// Instants at even distances, at exactly the dates that are written.
WantedRows rows_of_grid(const TimeGrid& grid) {
  WantedRows rows;
  rows.decimals = grid.decimals();
  DateText text(grid, rows.decimals);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const Seconds time = grid.time(i, {TimeResolution::Kind::decimals, rows.decimals});
    rows.instants.push_back(grid.instant(time));
    text.append(rows.dates.emplace_back(), time);
  }
  return rows;
}

WantedRows wanted_rows(const ObserveOptions& options, Instant epoch, TimeScale scale) {
  const DateRule rule{scale, options.scale_given ? std::optional(scale) : std::nullopt};
  UtcDoubts doubts;
  if (!options.times.empty()) {
    if (!options.start.empty() || !options.stop.empty() || !options.step.empty() || options.count != 0) {
      throw OptionError("--times stands alone: without --start, --stop, --step, --count");
    }
    std::error_code not_a_path;
    WantedRows rows;
    if (std::filesystem::exists(options.times, not_a_path)) {
      rows.table = parse_time_table(read_text_file(options.times), options.times);
    }
    if (!rows.table) {
      return rows_of_grid(
          TimeGrid::of_list(in_option("--times", [&] { return wanted_dates(options.times, rule, doubts); }), scale));
    }
    rows.instants = rows.table->instants;
    std::vector<Instant> ascending = rows.instants;
    std::sort(ascending.begin(), ascending.end());
    ascending.erase(std::unique(ascending.begin(), ascending.end()), ascending.end());
    rows.decimals = TimeGrid::of_list(ascending, scale).decimals();
    for (const Instant instant : rows.instants) {
      if (scale == TimeScale::utc) doubts.look_at(instant);
      rows.dates.push_back(format_date(instant, scale, rows.decimals));
    }
    return rows;
  }
  if (options.step.empty() == (options.count == 0)) {
    throw OptionError("one of --step and --count is needed, which say where rows are, or --times");
  }
  const bool one_row = options.count == 1 && options.stop.empty();
  if (options.stop.empty() && !one_row) {
    throw OptionError("--stop is missing, the last time, as --stop \"+1 d\"; only --count 1 needs none");
  }
  const auto date = [&](const char* option, const std::string& text, Instant from) {
    return in_option(option, [&] { return wanted_date(text, from, rule, doubts); });
  };
  const Instant start = options.start.empty() ? epoch : date("--start", options.start, epoch);
  const Instant stop = one_row ? start : date("--stop", options.stop, start);
  if (options.step.empty()) {
    return in_option("--stop", [&] { return rows_of_grid(TimeGrid::with_count(start, stop, options.count, scale)); });
  }
  const Seconds step = in_option("--step", [&] { return parse_duration(options.step); });
  return in_option("--stop", [&] { return rows_of_grid(TimeGrid::with_step(start, stop, step, scale)); });
}

Photometry photometry_of(const ObserveOptions& options) {
  Photometry out;
  std::map<std::string, SurfaceShine, std::less<>> surfaces;
  for (const std::string& text : options.surfaces) {
    in_option("--surface", [&] {
      if (!surfaces.insert(parse_surface(text)).second) throw InputError(fmt::format("'{:.60}' comes twice", text));
    });
  }
  out.shape = in_option("--shape", [&] { return named_shape(options.shape, options.shape_unit, surfaces); });
  out.law = in_option("--law, --specular",
                      [&] { return scattering_law(options.law, options.lambert_weight, options.specular); });
  out.absolute_magnitude = options.absolute_magnitude;
  if (!options.hg1g2.empty() && !options.phase_polynomial.empty()) {
    throw OptionError("--hg1g2 and --phase-polynomial are both phase functions: one of them");
  }
  if (!options.hg1g2.empty()) out.phase = HG1G2Phase{options.hg1g2[0], options.hg1g2[1]};
  if (!options.phase_polynomial.empty()) {
    out.phase = PolynomialPhase{options.phase_polynomial[0], options.phase_polynomial[1]};
  }
  in_option("--shape", [&] { check(out); });
  return out;
}

/// The geometry that the table of times itself gives, where no target is named.
std::vector<KnownDirection> directions_of(const ObserveOptions& options, const WantedRows& rows) {
  constexpr const char* wanted =
      "--target is missing, the trajectory of the body; only a table of --times with the columns ra_deg, dec_deg and "
      "delta_au (astrometric, geocentric) needs none";
  if (!rows.table) throw OptionError(wanted);
  const auto ra = rows.table->numbers("ra_deg"), dec = rows.table->numbers("dec_deg"),
             delta = rows.table->numbers("delta_au");
  if (!ra || !dec || !delta) throw OptionError(wanted);
  if (options.observer != "geocentre" || !options.site.empty() || !options.sun.empty()) {
    throw OptionError("--observer, --site and --sun need a --target: the table's directions are from the geocentre");
  }
  std::vector<KnownDirection> out;
  constexpr double farthest_au = 1e5;
  for (std::size_t i = 0; i < ra->size(); ++i) {
    const auto wrong = [&](const char* column, double value, const char* allowed) {
      return InputError({rows.table->path, rows.table->lines[i]},
                        fmt::format("column {} holds {:g}; allowed are {}", column, value, allowed));
    };
    if (!(std::abs((*ra)[i]) <= 360.0)) throw wrong("ra_deg", (*ra)[i], "-360 to 360 deg");
    if (!(std::abs((*dec)[i]) <= 90.0)) throw wrong("dec_deg", (*dec)[i], "-90 to 90 deg");
    if (!((*delta)[i] > 0.0 && (*delta)[i] <= farthest_au)) {
      throw wrong("delta_au", (*delta)[i], "distances above 0 and up to 1e5 au");
    }
    out.push_back({(*ra)[i] * degree, (*dec)[i] * degree, (*delta)[i] * astronomical_unit_m});
  }
  return out;
}

SkyRequest sky_of(const ObserveOptions& options, Instant epoch) {
  TrajectoryRequest request;
  request.centre = options.centre;
  request.zero = epoch;
  if (!options.trajectory_frame.empty()) {
    request.table_frame = in_option("--trajectory-frame", [&] { return frame(options.trajectory_frame); });
  }
  SkyRequest sky;
  sky.target = in_option("--target", [&] { return named_place(options.target, request); });
  if (!std::holds_alternative<KnownWay>(sky.target)) throw OptionError("--target is the trajectory of a body: a file");
  if (!options.site.empty()) {
    if (options.observer != "geocentre") throw OptionError("--site is an observer on the Earth; leave --observer away");
    sky.observer = in_option("--site", [&] { return parse_site(options.site, options.earth); });
    if (options.earth.ut1_minus_utc_s == 0.0 && options.earth.pole_x_arcsec == 0.0 &&
        options.earth.pole_y_arcsec == 0.0) {
      say("note: UT1 - UTC and polar motion are taken as zero: the site is good to some 400 m");
    }
  } else {
    sky.observer = in_option("--observer", [&] { return named_place(options.observer, request); });
  }
  if (!options.sun.empty()) sky.sun = in_option("--sun", [&] { return named_place(options.sun, request); });
  return sky;
}

AxisConvention convention_of(const std::string& name) {
  if (name == "long-axis") return AxisConvention::long_axis;
  if (name == "short-axis") return AxisConvention::short_axis;
  throw InputError(fmt::format("'{:.40}' is no convention; allowed: long-axis, short-axis", name));
}

void observe_body(const ObserveOptions& options) {
  if (options.output != "-") in_option("-o", [&] { check_number_table_path(options.output); });
  std::vector<std::string> inputs{options.times, options.target, options.observer,
                                  options.sun,   options.shape,  leap_seconds_file()};
  const std::variant<Scene, BodyAndHistory> input = read_scene_or_body(options.body_file, [&](const std::string& path) {
    inputs.push_back(path);
    return read_text_file(path);
  });
  OutputOptions output;
  output.path = options.output;
  refuse_overwriting(output, inputs);
  const auto* const scene = std::get_if<Scene>(&input);
  const Body& body = scene != nullptr ? scene->body : std::get<BodyAndHistory>(input).body;
  for (const std::string& warning : body.warnings) warn(options.body_file, warning);
  const BodyInMotion moving = scene != nullptr ? planned_motion_of(*scene, false, std::nullopt)
                                               : free_motion_of(body, Frame::icrf, method("auto"));
  const TimeScale scale = in_option("--scale", [&] { return time_scale(options.scale); });

  ObservationOptions wanted;
  wanted.convention = in_option("--convention", [&] { return convention_of(options.convention); });
  wanted.angles_frame = in_option("--frame", [&] { return inertial_frame(options.frame); });
  if (!options.exposure.empty()) {
    wanted.exposure_s = in_option("--exposure", [&] { return parse_duration(options.exposure).high; });
  }
  if (!options.shape.empty()) {
    wanted.photometry = photometry_of(options);
  } else if (!options.exposure.empty() || options.absolute_magnitude || !options.shape_unit.empty() ||
             !options.surfaces.empty() || !options.hg1g2.empty() || !options.phase_polynomial.empty() ||
             options.law != "lommel-seeliger") {
    throw OptionError("--shape is missing: laws, phase functions, magnitudes and exposures are of a shape");
  }

  const Instant epoch = body.state->epoch;
  WantedRows rows = wanted_rows(options, epoch, scale);
  const Sky sky = options.target.empty() ? Sky(directions_of(options, rows)) : Sky(sky_of(options, epoch));
  std::vector<ObservedColumn> columns = observe(moving, sky, rows.instants, wanted);
  if (options.covariance) {
    for (ObservedColumn& sigma :
         in_option("--covariance", [&] { return observe_sigmas(moving, sky, rows.instants, wanted); })) {
      columns.push_back(std::move(sigma));
    }
  }
  std::ptrdiff_t dark = 0;
  for (const ObservedColumn& column : columns) {
    if (column.name == "magnitude") {
      dark = std::count(column.values.begin(), column.values.end(), std::numeric_limits<double>::infinity());
    }
  }
  if (!std::all_of(rows.instants.begin(), rows.instants.end(), in_range_of_erfa)) {
    say("note: ERFA's Earth and Sun are known to 13 km from 1900 to 2100; some rows are outside, and less exact");
  }
  if (body.any_inertia) {
    say("note: of a rotation about one axis the long axis and phi, theta, psi are not known: nan");
    for (ObservedColumn& column : columns) {
      const std::string& name = column.name;
      if (name.find("long_axis") != std::string::npos || name.ends_with("phi_deg") || name.ends_with("theta_deg") ||
          name.ends_with("psi_deg")) {
        std::fill(column.values.begin(), column.values.end(), std::numeric_limits<double>::quiet_NaN());
      }
    }
  }

  ColumnTable table;
  table.scale = scale;
  table.decimals = rows.decimals;
  table.dates = std::move(rows.dates);
  table.instants = rows.instants;
  for (ObservedColumn& column : columns) table.numbers.push_back({column.name, std::move(column.values)});
  if (rows.table) {
    for (std::size_t k = 0; k < rows.table->names.size(); ++k) {
      table.kept.push_back({rows.table->names[k], std::move(rows.table->columns[k])});
    }
  }
  table.about = {{"object", body.name},
                 {"source", body.source},
                 {"angles_frame", options.frame},
                 {"convention", options.convention},
                 {"corrected_for", "light time; not for stellar aberration"}};
  if (wanted.photometry) {
    table.about.emplace_back("shape", wanted.photometry->shape->description());
    table.about.emplace_back("law", options.law);
  }
  try {
    write_column_table(options.output == "-" ? "/dev/stdout" : options.output, table);
  } catch (const TimeScaleError& error) {
    throw InputError({"--scale", 0}, error.what());
  }
  say(fmt::format("{}: {} rows", options.output == "-" ? "standard output" : options.output, table.dates.size()));
  if (wanted.photometry) say("brightness of " + wanted.photometry->shape->description() + ", law " + options.law);
  if (dark > 0) say(fmt::format("note: in {} rows nothing is both lit and seen: the magnitude is inf", dark));
  const auto [first, last] = std::minmax_element(rows.instants.begin(), rows.instants.end());
  const double farthest_s = std::max(std::abs((*first - epoch).high), std::abs((*last - epoch).high));
  const bool torques_are_uncertain = moving.uncertainty != body.uncertainty;
  if (const auto caution = scene_worth_text(body, torques_are_uncertain, farthest_s, options.covariance)) {
    say("caution: " + *caution);
  }
  if (options.covariance) {
    if (const auto caution = sigmas_caution(moving, rows.instants)) say("caution: " + *caution);
  }
}

void add_brightness_options(CLI::App& command, ObserveOptions& options) {
  command.add_option(
      "--shape", options.shape,
      "Shape, which adds magnitude and area_m2: \"A B C unit\", an ellipsoid with these semi-axes along x, "
      "y, z, or a mesh (OBJ, PLY, STL, shape.txt)");
  command.add_option("--shape-unit", options.shape_unit, "Unit of a mesh's coordinates: m, km ...");
  command.add_option("--law", options.law, fmt::format("Scattering law: {}", names_of_scattering_laws()))
      ->capture_default_str();
  command.add_option("--lambert-weight", options.lambert_weight, "Of Lambert's law in lommel-seeliger-lambert")
      ->capture_default_str();
  command
      .add_option("--specular", options.specular,
                  "Of a mesh: the part of the light that its facets throw on like mirrors, in which the Sun's disc is "
                  "seen; beside the law's")
      ->capture_default_str();
  command.add_option(
      "--surface", options.surfaces,
      "NAME=DIFFUSE,SPECULAR[,SIDES]: of the facets to which the mesh gives this name, the part of the law's "
      "light and that of the mirror's, and 2 sides for plates; may be given several times");
  command.add_option("-H,--absolute-magnitude", options.absolute_magnitude,
                     "H, of the mean of all directions at phase 0; without it magnitudes are relative, as for H = 0");
  command.add_option("--hg1g2", options.hg1g2, "G1 and G2 of the phase function H, G1, G2")->expected(2);
  command
      .add_option("--phase-polynomial", options.phase_polynomial,
                  "Phase function in magnitudes instead: mag/deg and mag/deg2")
      ->expected(2);
  command.add_option("--exposure", options.exposure,
                     "How long exposures last, whose middles the times are: in s, or with unit");
}

}  // namespace

void add_observe(CLI::App& app) {
  const auto options = std::make_shared<ObserveOptions>();
  CLI::App* command =
      app.add_subcommand("observe", "What an observer sees of a body or scene: geometry and brightness");
  command->footer(
      "Examples:\n  polhode observe apophis.toml --target apophis-vectors.txt -o night.csv --start \"2029-04-13 UTC\" "
      "--stop \"+8 h\" --step \"5 min\" --scale UTC --site \"-17.88 28.76 2326\"\n"
      "  polhode observe toutatis.toml --times photometry.csv -o model.csv --shape \"0.96 1.2 2.3 km\"");
  command->add_option("FILE", options->body_file, "Body or scene")->required();
  command->add_option("--target", options->target,
                      "Trajectory of the body: a CCSDS OEM, a table of x, y, z, a vector table of Horizons, or orbital "
                      "elements in TOML");
  command->add_option("--observer", options->observer, "geocentre, sun, or the trajectory of a spacecraft, as --target")
      ->capture_default_str();
  command->add_option("--site", options->site,
                      "A place on the Earth instead: \"LONGITUDE LATITUDE HEIGHT\", deg east, deg, m (WGS84)");
  command->add_option("--ut1-utc", options->earth.ut1_minus_utc_s, "UT1 - UTC, s, for --site")->capture_default_str();
  command->add_option("--pole-x", options->earth.pole_x_arcsec, "Polar motion, arcsec, for --site")
      ->capture_default_str();
  command->add_option("--pole-y", options->earth.pole_y_arcsec, "Polar motion, arcsec, for --site")
      ->capture_default_str();
  command->add_option("--sun", options->sun, "Trajectory of the Sun; ERFA's (epv00) unless given");
  command
      ->add_option("--centre", options->centre,
                   "What trajectories are about whose files do not say it: Sun, Earth, SSB, or another for all")
      ->capture_default_str();
  command->add_option("--trajectory-frame", options->trajectory_frame,
                      "Frame of trajectories in tables of text, which name none; ICRF unless given");
  command
      ->add_option("-o,--output", options->output,
                   fmt::format("Output: {}, or - for CSV on standard output", endings_of_number_tables()))
      ->required();
  command->add_option("--start", options->start,
                      "First time of reception: a date with its scale, now, or +SPAN or -SPAN from the body's epoch, "
                      "which is the default");
  command->add_option("--stop", options->stop, "Last time, or +SPAN from the first");
  command->add_option("--step", options->step, "Distance of rows, in s, or with unit s, min, h, d");
  add_whole_number(*command, "--count", options->count, 1, TimeGrid::most_rows, "Number of rows, both ends included");
  command->add_option("--times", options->times,
                      "Dates separated by commas, or a file: one date a line, or a table with a column of dates, whose "
                      "rows and other columns are kept");
  command
      ->add_option("--scale", options->scale, "Time scale of the rows, and where it is given of dates that name none")
      ->capture_default_str();
  add_leap_seconds(*command);
  command->add_option("--convention", options->convention, "Of phi, theta, psi: long-axis or short-axis")
      ->capture_default_str();
  command->add_option("--frame", options->frame, "Inertial frame that phi counts in")->capture_default_str();
  command->add_flag("--covariance", options->covariance,
                    "Add one sigma of each column that depends on the attitude, by the body's uncertainties");
  add_brightness_options(*command, *options);
  command->callback([options, command] {
    options->scale_given = command->get_option("--scale")->count() > 0;
    in_file(options->body_file, [&] { observe_body(*options); });
  });
}

}  // namespace polhode::tools
