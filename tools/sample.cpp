#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "dates.hpp"
#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/session/sample.hpp"
#include "polhode/write/output_file.hpp"
#include "subcommands.hpp"
#include "utc.hpp"
#include "whole_number.hpp"
#include "write_ephemeris.hpp"

namespace polhode::tools {
namespace {

struct SampleOptions {
  std::vector<std::string> files;
  std::string output, times, part;
  std::size_t count = 0, seed = 0, threads = 0;
  std::vector<std::string> uniform;
  std::string frame = "ICRF";
  std::string scale = "TDB";
  bool frame_given = false, scale_given = false, rows = false, join = false;
};

/// Part files end so; "OUT.part" holds what there is of OUT until it is written.
constexpr std::string_view part_ending = ".part";

SampleState read_part(const std::string& path) {
  return in_file(path, [&] { return SampleState::of_text(read_text_file(path)); });
}

void write_part(const std::string& path, const SampleState& state) {
  OutputBytes file(path);
  file.write(state.text());
  file.commit();
}

SamplePart part_of(const SampleOptions& options) {
  if (options.part.empty()) return {0, options.count};
  return in_option("--part", [&] {
    const std::size_t slash = options.part.find('/');
    const auto number = [&](std::string_view text) {
      const auto value = parse_integer(text);
      if (!value || *value < 1) {
        throw InputError(fmt::format("'{:.60}' is no part; one of 1/K to K/K is wanted", options.part));
      }
      return static_cast<std::uint64_t>(*value);
    };
    if (slash == std::string::npos) number("");
    return part_of_sample(options.count, number(std::string_view(options.part).substr(0, slash)),
                          number(std::string_view(options.part).substr(slash + 1)));
  });
}

std::vector<UniformNumber> uniform_of(const SampleOptions& options) {
  return in_option("--uniform", [&] {
    std::vector<UniformNumber> out;
    for (const std::string& text : options.uniform) {
      const std::size_t equals = text.find('=');
      const auto width = equals == std::string::npos ? std::nullopt : parse_number(text.substr(equals + 1));
      if (!width) throw InputError(fmt::format("'{:.60}' is not NAME=WIDTH", text));
      out.push_back({text.substr(0, equals), *width});
    }
    return out;
  });
}

Sample sample_of(const SampleOptions& options, std::vector<std::string>& inputs) {
  const std::string& path = options.files.front();
  Sample sample;
  std::variant<Scene, BodyAndHistory> input = read_scene_or_body(path, [&](const std::string& file) {
    inputs.push_back(file);
    std::string content = read_text_file(file);
    sample.inputs += content;
    return content;
  });
  const auto* const scene = std::get_if<Scene>(&input);
  sample.scale = in_option("--scale", [&] { return time_scale(options.scale); });
  const Frame frame = in_option("--frame", [&] { return inertial_frame(options.frame); });
  if (scene != nullptr && options.frame_given && frame != scene->frame) {
    throw InputError(fmt::format("--frame is {}, the scene is in another frame; leave --frame away", options.frame));
  }
  sample.moving = scene != nullptr ? planned_motion_of(*scene, false, std::nullopt)
                                   : free_motion_of(std::get<BodyAndHistory>(input).body, frame, method("auto"));
  for (const std::string& warning : sample.moving.body.warnings) warn(path, warning);
  sample.seed = options.seed;
  sample.count = options.count;
  sample.uniform = uniform_of(options);
  UtcDoubts doubts;
  const DateRule rule{sample.scale, options.scale_given ? std::optional(sample.scale) : std::nullopt};
  sample.instants = in_option("--times", [&] { return wanted_dates(options.times, rule, doubts); });
  return sample;
}

/// Goes on from `path` if it is there, and leaves there what is done, every two seconds.
SampleState watched_state(const Sample& sample, SamplePart part, const std::string& path,
                          const SampleOptions& options) {
  SampleState state = empty_state(sample, part);
  if (std::filesystem::exists(path)) {
    SampleState begun = read_part(path);
    if (begun.identity != state.identity || begun.part.first != part.first || begun.part.last != part.last) {
      throw InputError({path, 0}, "is of another sample; remove it, or write elsewhere");
    }
    if (begun.next > begun.part.first) say(fmt::format("{}: {} clones are there", path, begun.next - begun.part.first));
    state = std::move(begun);
  } else {
    write_part(path, state);  // what cannot be written is said now, not when all is done
  }
  const std::uint64_t before = state.next;
  write_watched(
      options.output, static_cast<std::size_t>(part.last - part.first),
      [&](const Progress& progress) {
        auto saved = std::chrono::steady_clock::now();
        continue_sample(sample, state, static_cast<unsigned>(options.threads), [&](const SampleState& now) {
          if (progress) progress(static_cast<std::size_t>(now.next - part.first));
          constexpr auto often = std::chrono::seconds(2);
          if (std::chrono::steady_clock::now() - saved < often) return;
          write_part(path, now);
          saved = std::chrono::steady_clock::now();
        });
      },
      "clones");
  if (before != part.last) write_part(path, state);
  return state;
}

void join_parts(const SampleOptions& options) {
  std::vector<SampleState> parts;
  parts.reserve(options.files.size());
  for (const std::string& file : options.files) parts.push_back(read_part(file));
  write_sample_statistics(options.output, joined(std::move(parts)));
  say(fmt::format("{}: {} parts", options.output, options.files.size()));
}

void sample(const SampleOptions& options) {
  const bool writes_part = options.output.ends_with(part_ending) && !options.rows;
  if (!writes_part) in_option("-o", [&] { check_number_table_path(options.output); });
  if (options.join) {
    if (writes_part) throw OptionError("--join writes the statistics: --output is a table");
    join_parts(options);
    return;
  }
  if (options.files.size() != 1) throw OptionError("one body or scene is wanted; --join takes several parts");
  if (options.count == 0) throw OptionError("--count is missing, how many clones");
  if (options.times.empty()) throw OptionError("--times is missing, when they are wanted");
  const SamplePart part = part_of(options);
  if (!options.part.empty() && !options.rows && !writes_part) {
    throw OptionError(fmt::format("--part without --rows writes what --join takes: --output ends in {}", part_ending));
  }
  if (!writes_part && !options.rows && part.last == part.first) throw OptionError("no clones are wanted");
  std::vector<std::string> inputs{options.times, leap_seconds_file()};
  const Sample what = sample_of(options, inputs);
  OutputOptions output;
  output.path = options.output;
  refuse_overwriting(output, inputs);
  if (options.rows) {
    write_watched(options.output, static_cast<std::size_t>(part.last - part.first) * what.instants.size(),
                  [&](const Progress& progress) {
                    write_sample_rows(options.output, what, part, progress, static_cast<unsigned>(options.threads));
                  });
    return;
  }
  if (writes_part) {
    watched_state(what, part, options.output, options);
    return;
  }
  const std::string begun = options.output + std::string(part_ending);
  write_sample_statistics(options.output, watched_state(what, part, begun, options));
  std::filesystem::remove(begun);
}

}  // namespace

void add_sample(CLI::App& app) {
  const auto options = std::make_shared<SampleOptions>();
  CLI::App* command = app.add_subcommand("sample", "Clones drawn from the uncertainties of a body or scene");
  command->footer(
      "Examples:\n  polhode sample toutatis.toml --count 100000 --seed 1 --times \"2012-12-12 UTC\" -o sample.csv\n"
      "  polhode sample toutatis.toml --count 100000 --seed 1 --times \"2012-12-12 UTC\" --part 3/7 -o sample-3.part\n"
      "  polhode sample --join sample-1.part sample-2.part -o sample.csv");
  command->add_option("FILE", options->files, "Body or scene with uncertainties; with --join the parts")->required();
  command
      ->add_option("-o,--output", options->output,
                   "Output; its ending says the format: " + endings_of_number_tables() + ", .part (what --join takes)")
      ->required();
  add_whole_number(*command, "--count", options->count, 1, 1'000'000'000'000, "How many clones");
  add_whole_number(*command, "--seed", options->seed, 0, 9'007'199'254'740'991,
                   "Seed; clone n depends on it and n alone");
  command->add_option("--times", options->times,
                      "Dates separated by commas, or a file: one date a line, or a table with a column of dates");
  command->add_option("--part", options->part, "I/K: the I-th of K parts of the clones");
  command->add_flag("--rows", options->rows, "Every clone as rows, not statistics");
  command->add_flag("--join", options->join, "The statistics of all parts of a sample");
  command
      ->add_option("--uniform", options->uniform,
                   "NAME=WIDTH: a number with an uncertainty is drawn evenly from this width about its value, as "
                   "psi0=360 of a phase that nobody knows")
      ->allow_extra_args(false);
  command->add_option("--frame", options->frame, "Inertial frame of the attitudes; of a scene its own")
      ->capture_default_str();
  command
      ->add_option("--scale", options->scale, "Time scale of the rows, and where it is given of dates that name none")
      ->capture_default_str();
  add_whole_number(*command, "--threads", options->threads, 0, 4096,
                   "Threads, 0: one per core; the result is the same");
  add_leap_seconds(*command);
  command->callback([options, command] {
    options->frame_given = command->get_option("--frame")->count() > 0;
    options->scale_given = command->get_option("--scale")->count() > 0;
    in_file(options->files.front(), [&] { sample(*options); });
  });
}

}  // namespace polhode::tools
