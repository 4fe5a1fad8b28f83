#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "dates.hpp"
#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/ephemeris/resample.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/session/body_in_motion.hpp"
#include "rivals/registry.hpp"
#include "subcommands.hpp"
#include "utc.hpp"
#include "whole_number.hpp"
#include "write_ephemeris.hpp"

namespace polhode::tools {
namespace {

struct PropagateOptions {
  std::string body_file;
  OutputOptions output;
  std::vector<std::string> starts;
  std::vector<std::string> stops;
  std::string step;
  std::size_t count = 0;
  std::string times;
  std::string tolerance;
  std::string frame = "ICRF";
  std::string scale = "TDB";
  std::string method = "auto";
  bool full = false;                            // of a scene
  std::optional<std::size_t> most_evaluations;  // of torques
  bool history = false;                         // of a message that has a body as well
  bool frame_given = false;
  bool scale_given = false;
  std::string scene_end;  // "+30 d" from the epoch: where a scene is, its last time
  bool covariance = false;
};

/// Dates that name no scale have that of --scale, where it is given.
DateRule date_rule(const PropagateOptions& options, TimeScale rows) {
  return {rows, options.scale_given ? std::optional(rows) : std::nullopt};
}

Frame frame_of(const PropagateOptions& options) {
  return in_option("--frame", [&] { return inertial_frame(options.frame); });
}

TimeScale scale_of(const PropagateOptions& options) {
  return in_option("--scale", [&] { return time_scale(options.scale); });
}

Instant date_of(const char* option, const std::string& text, Instant from, const DateRule& rule, UtcDoubts& doubts) {
  return in_option(option, [&] { return wanted_date(text, from, rule, doubts); });
}

Seconds step_of(const PropagateOptions& options) {
  return in_option("--step", [&] {
    const Seconds step = parse_duration(options.step);
    if (!(step.high > 0.0)) throw InputError(fmt::format("the step is {} s; it must be positive", step.high));
    return step;
  });
}

double tolerance_of(const PropagateOptions& options) {
  return in_option("--tolerance", [&] { return parse_tolerance_rad(options.tolerance); });
}

std::vector<Instant> times_of(const PropagateOptions& options, const DateRule& rule, UtcDoubts& doubts) {
  return in_option("--times", [&] { return wanted_dates(options.times, rule, doubts); });
}

/// One grid per pair of --start and --stop, or one of the list.
std::vector<TimeGrid> time_grids(const PropagateOptions& options, Instant epoch, TimeScale scale,
                                 const std::function<std::size_t(Instant start, Instant stop)>& rows_for_tolerance) {
  const DateRule rule = date_rule(options, scale);
  UtcDoubts doubts;
  if (!options.times.empty()) {
    if (!options.starts.empty() || !options.stops.empty() || !options.step.empty() || options.count != 0 ||
        !options.tolerance.empty()) {
      throw OptionError("--times stands alone: without --start, --stop, --step, --count, --tolerance");
    }
    return {TimeGrid::of_list(times_of(options, rule, doubts), scale)};
  }
  const int spacings = int(!options.step.empty()) + int(options.count != 0) + int(!options.tolerance.empty());
  if (spacings == 0) {
    throw OptionError("one of --step and --count and --tolerance is needed, which say where rows are, or --times");
  }
  if (spacings > 1)
    throw OptionError("--step, --count and --tolerance each say where rows are: one of them is allowed");
  const bool one_row = options.count == 1 && options.stops.empty();
  const bool to_scene_end = options.stops.empty() && options.starts.size() <= 1 && !options.scene_end.empty();
  if (options.stops.empty() && !one_row && !to_scene_end) {
    throw OptionError("--stop is missing, the last time, as --stop \"+1 d\"; only --count 1 needs none");
  }
  if (!one_row && !to_scene_end && options.starts.size() != options.stops.size() &&
      !(options.starts.empty() && options.stops.size() == 1)) {
    throw OptionError(
        fmt::format("{} times --start and {} times --stop; they come in pairs (one --stop alone starts at "
                    "the body's epoch)",
                    options.starts.size(), options.stops.size()));
  }
  // "+60 d" counts from the body's epoch for --start, from the start for --stop.
  std::vector<TimeGrid> grids;
  const std::size_t segments = std::max<std::size_t>({options.starts.size(), options.stops.size(), 1});
  for (std::size_t i = 0; i < segments; ++i) {
    const Instant start = options.starts.empty() ? epoch : date_of("--start", options.starts[i], epoch, rule, doubts);
    const Instant stop = one_row        ? start
                         : to_scene_end ? wanted_date(options.scene_end, epoch, rule, doubts)
                                        : date_of("--stop", options.stops[i], start, rule, doubts);
    const bool by_step = !options.step.empty();
    const Seconds step = by_step ? step_of(options) : Seconds{};
    const std::size_t count = by_step || options.count != 0 ? options.count : rows_for_tolerance(start, stop);
    grids.push_back(located({options.scene_end.empty() ? "--stop" : options.body_file, 0}, [&] {
      return by_step ? TimeGrid::with_step(start, stop, step, scale) : TimeGrid::with_count(start, stop, count, scale);
    }));
  }
  return grids;
}

/// What the command line leaves open, from the scene.
void complete(PropagateOptions& options, const Scene& scene) {
  if (options.frame_given && frame_of(options) != scene.frame) {
    throw InputError(fmt::format("--frame is {}, the scene is in another frame; leave --frame away", options.frame));
  }
  if (options.method != "auto") throw InputError("--method is for body files: a scene's method comes from its plan");
  if (!options.times.empty()) return;
  options.scene_end = fmt::format("{:+} s", scene.last_s);
  if (options.starts.empty() && options.stops.empty()) {
    if (scene.first_s != 0.0) options.starts = {fmt::format("{:+} s", scene.first_s)};
    options.stops = {fmt::format("+{} s", scene.last_s - scene.first_s)};
  }
  if (options.step.empty() && options.count == 0 && options.tolerance.empty()) {
    options.tolerance = fmt::format("{} rad", scene.accuracy_rad);
  }
}

/// The rows of an attitude history, or attitudes between them.
void export_history(const PropagateOptions& options, const EphemerisFormat& format, AttitudeHistory history) {
  if (!options.tolerance.empty()) {
    throw InputError("--tolerance is for bodies: an attitude history is as good as its rows; take --step or --count");
  }
  if (options.output.momentum) throw InputError("is taken as an attitude history, and --momentum needs an inertia");
  if (options.method != "auto") throw InputError("--method is for bodies; an attitude history says how to interpolate");
  if (!options.step.empty() && options.count != 0) throw OptionError("one of --step and --count, not both");
  if (history.object.empty()) history.object = std::filesystem::path(options.body_file).stem().string();
  const TimeScale scale = options.scale_given ? scale_of(options) : history.scale;
  const std::optional<Frame> out_frame = options.frame_given ? std::optional(frame_of(options)) : std::nullopt;
  const DateRule rule = date_rule(options, scale);
  UtcDoubts doubts;
  WantedTimes wanted;
  if (!options.step.empty()) wanted.step = step_of(options);
  wanted.count = options.count;
  const auto resampled = [&] { return resample(history, wanted, scale, out_frame); };
  std::vector<Ephemeris> segments;
  if (!options.times.empty()) {
    if (!options.starts.empty() || !options.stops.empty() || wanted.step || wanted.count != 0) {
      throw OptionError("--times stands alone: without --start, --stop, --step, --count");
    }
    wanted.list = times_of(options, rule, doubts);
    segments = resampled();
  }
  const std::size_t spans = std::max<std::size_t>({options.starts.size(), options.stops.size(), 1});
  if (spans > 1 && options.starts.size() != options.stops.size()) {
    throw OptionError(fmt::format("{} times --start and {} times --stop; they come in pairs", options.starts.size(),
                                  options.stops.size()));
  }
  for (std::size_t i = 0; options.times.empty() && i < spans; ++i) {
    // "+60 d" counts from the history's first instant for --start, from the start for --stop.
    const Instant first = history.segments.front().first();
    if (!options.starts.empty()) wanted.start = date_of("--start", options.starts[i], first, rule, doubts);
    if (!options.stops.empty()) {
      wanted.stop = date_of("--stop", options.stops[i], wanted.start.value_or(first), rule, doubts);
    }
    for (Ephemeris& segment : resampled()) segments.push_back(std::move(segment));
  }
  write_watched(options.output, format, segments);
}

/// Whether to write the attitude history instead of the motion of a body: of a file that has one, and no complete body.
bool is_history_wanted(const PropagateOptions& options, const BodyAndHistory& file) {
  if (!file.history) {
    if (options.history) throw InputError("holds no attitude history");
    return false;
  }
  if (file.is_table) return true;
  const std::vector<std::string>& missing = file.body.missing;
  if (missing.empty() && !options.history) {
    say("the motion of the body is computed; --history writes the attitudes of the message");
    return false;
  }
  if (!missing.empty()) {
    say(fmt::format("no motion can be computed, it would need {}; the attitude history is taken",
                    fmt::join(missing, ", ")));
  }
  return true;
}

/// What the rows of an inexact method are worth, by comparison with the exact motion.
void measure_error(const BodyInMotion& moving, Ephemeris& rows) {
  const BodyInMotion exact = free_motion_of(moving.body, moving.frame, method("auto"));
  const Ephemeris exact_rows = rows_of(exact, rows.times(), {}, nullptr);
  const EphemerisDescription& promise = exact_rows.description();
  if (!promise.promised_error_rad) return;
  rows.description().promised_error_rad = largest_difference_rad(rows, exact_rows) + *promise.promised_error_rad;
  rows.description().error_meaning =
      fmt::format("measured: the largest difference from {} at these rows; the numbers of the body are taken as exact",
                  promise.method);
}

/// What ran, what it cost and what it promises.
void print_account(const EphemerisDescription& rows) {
  std::string text = fmt::format("method {}", rows.method);
  if (rows.torque_evaluations) text += fmt::format(", {} torque evaluations", *rows.torque_evaluations);
  if (rows.promised_error_rad) text += fmt::format("; rows good to {:.1e} rad", *rows.promised_error_rad);
  if (!rows.error_meaning.empty()) text += fmt::format(" ({})", rows.error_meaning);
  say(text);
  for (const std::string& caution : rows.cautions) say("caution: " + caution);
}

void propagate(PropagateOptions options) {
  const EphemerisFormat& format = format_of(options.output);
  refuse_meaningless(options.output, format);
  if (options.covariance && !format.has_covariance) {
    throw OptionError(fmt::format("--covariance is for {}: {} holds none",
                                  endings_of_formats(&EphemerisFormat::has_covariance), format.name));
  }
  std::vector<std::string> inputs{options.times, leap_seconds_file()};
  std::variant<Scene, BodyAndHistory> input = read_scene_or_body(options.body_file, [&](const std::string& path) {
    inputs.push_back(path);
    return read_text_file(path);
  });
  refuse_overwriting(options.output, inputs);
  const auto* const scene = std::get_if<Scene>(&input);
  if (scene != nullptr) {
    complete(options, *scene);
  } else if (options.full || options.most_evaluations) {
    throw InputError(
        fmt::format("is no scene: {} means something for scenes only", options.full ? "--full" : "--max-evaluations"));
  }
  BodyAndHistory file =
      scene != nullptr ? BodyAndHistory{scene->body, std::nullopt} : std::get<BodyAndHistory>(std::move(input));
  const Body& body = file.body;
  for (const std::string& warning : body.warnings) warn(options.body_file, warning);
  if (is_history_wanted(options, file)) {
    if (options.covariance) throw InputError("is an attitude history: --covariance is of the motion of a body");
    export_history(options, format, *std::move(file.history));
    return;
  }
  if (options.covariance && !body.uncertainty && !(scene != nullptr && scene->uncertain)) {
    throw InputError(
        "gives no uncertainty, and --covariance needs one: _sigma keys, a table [uncertainty] or period_uncertainty");
  }
  if (options.output.momentum && body.any_inertia) {
    throw InputError("has no inertia, and --momentum needs an inertia");
  }
  const Frame out_frame = scene ? scene->frame : frame_of(options);
  const TimeScale scale = scale_of(options);
  const Method& chosen = in_option(
      "--method", [&]() -> auto& { return rivals::measured_method(options.method); });
  const BodyInMotion moving = scene != nullptr ? planned_motion_of(*scene, options.full, options.most_evaluations)
                                               : free_motion_of(body, out_frame, chosen);
  std::optional<double> tolerance_rad;
  if (!options.tolerance.empty()) tolerance_rad = tolerance_of(options);
  const auto rows_between = [&](Instant start, Instant stop) {
    return rows_for_tolerance(moving, start, stop, scale, *tolerance_rad, format.interpolation);
  };
  std::vector<Ephemeris> segments;
  for (TimeGrid& grid : time_grids(options, body.state->epoch, scale, rows_between)) {
    segments.push_back(rows_of(moving, std::move(grid), tolerance_rad, &format, options.covariance));
    if (!scene && !chosen.exact_everywhere) measure_error(moving, segments.back());
  }
  write_watched(options.output, format, segments);
  for (const Ephemeris& segment : segments) print_account(segment.description());
}

}  // namespace

void add_propagate(CLI::App& app) {
  const auto options = std::make_shared<PropagateOptions>();
  CLI::App* command = app.add_subcommand("propagate", "A body, scene or attitude history to an attitude ephemeris");
  command->footer(
      "Examples:\n  polhode propagate toutatis.toml -o toutatis.fits --stop \"+60 d\" --step \"1 h\"\n"
      "  polhode propagate toutatis.toml -o night.csv --start \"1993-01-01 UTC\" --stop \"+8 h\" --tolerance \"1 "
      "arcsec\"\n"
      "  polhode propagate toutatis.toml -o now.csv --start now --count 1\n"
      "  polhode propagate toutatis.toml -o points.ecsv --times observations.csv --scale UTC\n"
      "  polhode propagate envisat-month.toml -o envisat.aem");
  command
      ->add_option("FILE", options->body_file,
                   fmt::format("Body, scene, or attitude history ({}); `info --help` lists the kinds of file",
                               names_of_histories()))
      ->required();
  command
      ->add_option("-o,--output", options->output.path,
                   "Output, - for standard output; its ending says the format: " + endings_of_formats())
      ->required();
  command->add_option("--format", options->output.format, "One of these endings, without its dot, for another name");
  command
      ->add_option(
          "--start", options->starts,
          "First time: a date with its scale, now, or +SPAN or -SPAN from the body's epoch or the history's begin, "
          "which is the default")
      ->allow_extra_args(false);
  command
      ->add_option("--stop", options->stops,
                   "Last time, or +SPAN from the first; of a scene or history its end unless given; --start and --stop "
                   "again make another segment "
                   "of an AEM")
      ->allow_extra_args(false);
  command->add_option("--step", options->step, "Distance of rows, in s, or with unit s, min, h, d");
  add_whole_number(*command, "--count", options->count, 1, TimeGrid::most_rows, "Number of rows, both ends included");
  command->add_option("--tolerance", options->tolerance,
                      "As few rows as keep what readers interpolate within this angle, in rad, or with unit deg, "
                      "arcmin, arcsec, mas, uas");
  command->add_option("--times", options->times,
                      "Dates separated by commas, or a file: one date a line, or a table with a column of dates");
  command->add_option("--frame", options->frame, "Inertial frame of the attitude; of a history its own unless given")
      ->capture_default_str();
  command
      ->add_option(
          "--scale", options->scale,
          "Time scale of the rows, and where it is given of dates that name none; of a history its own unless given")
      ->capture_default_str();
  add_leap_seconds(*command);
  command->add_option("--method", options->method, "Method of the motion (see polhode methods)")->capture_default_str();
  command->add_flag("--momentum", options->output.momentum,
                    "Write the angular momentum too: " + endings_of_formats(&EphemerisFormat::has_momentum));
  command->add_flag(
      "--covariance", options->covariance,
      "Write the covariance of the attitude too: " + endings_of_formats(&EphemerisFormat::has_covariance));
  command->add_option("--adm", options->output.adm, "Version of the CCSDS message, 1.0 or 2.0 (the default)");
  command->add_option("--attitude-type", options->output.attitude_type,
                      "ATTITUDE_TYPE of an AEM; QUATERNION/ANGVEL unless given, of ADM 1.0 QUATERNION");
  command->add_option("--euler-sequence", options->output.euler_sequence,
                      "Axes of an AEM's Euler angles; ZXZ unless given");
  command->add_flag("--full", options->full, "Of a scene: keep every effect, at 1e-9 rad");
  add_whole_number(*command, "--max-evaluations", options->most_evaluations, 1, most_evaluations_asked,
                   fmt::format("Of a scene: most torque evaluations to spend, {} or with --full {} unless said",
                               kMostTorqueEvaluations, kMostTorqueEvaluationsInFull));
  command->add_flag("--history", options->history,
                    "Of a message with inertia and attitude history: write the history, not the motion");
  command->callback([options, command] {
    options->frame_given = command->get_option("--frame")->count() > 0;
    options->scale_given = command->get_option("--scale")->count() > 0;
    options->output.promises_interpolation = !options->tolerance.empty();
    in_file(options->body_file, [&] { propagate(*options); });
  });
}

}  // namespace polhode::tools
