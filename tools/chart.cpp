#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/case_file.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/ecsv_table.hpp"
#include "rivals/survey/speed_accuracy.hpp"
#include "rivals/survey/stability.hpp"
#include "rivals/survey/torqued_accuracy.hpp"
#include "subcommands.hpp"

namespace polhode::tools {
namespace {

struct ChartOptions {
  std::string folder;
  double size = 1.0;
  std::vector<std::string> bodies;
};

constexpr double kTurnsByDefault = 1000.0;

/// What is charted where no body is named: 20 years, 100 flips, a month, to the flyby of 2029, a thousand turns.
const std::vector<std::string> kStandardBodies{"toutatis.toml@7305d",    "t-handle.toml@166s", "envisat.toml@30d",
                                               "apophis.toml@3024.907d", "needle.toml",        "near-sphere.toml"};
const std::vector<std::string> kStandardTorqued{"truth/torqued/envisat-fast-01.case",
                                                "truth/torqued/envisat-slow-01.case",
                                                "truth/torqued/toutatis-01.case",
                                                "scenes/apophis-2029.toml",
                                                "scenes/librator.toml",
                                                "scenes/relaxing.toml"};

/// The standard ones, where none is given.
std::vector<std::string> or_standard(const std::vector<std::string>& given, const char* folder,
                                     const std::vector<std::string>& standard) {
  if (!given.empty()) return given;
  std::vector<std::string> paths;
  paths.reserve(standard.size());
  for (const std::string& name : standard) paths.push_back(fmt::format("{}{}{}", POLHODE_DATA_DIR, folder, name));
  return paths;
}

/// FILE or FILE@SPAN.
survey::Subject read_subject(const std::string& text) {
  const std::size_t at = text.rfind('@');
  const std::string file = text.substr(0, at);
  survey::Subject subject;
  subject.name = std::filesystem::path(file).stem().string();
  subject.body = file.ends_with(".case") ? read_case_file(file).body : free_body(read_body(file));
  if (subject.body.momentum_body.isZero(0.0)) throw InputError("the body is at rest, nothing to chart");
  subject.span_s = at == std::string::npos ? kTurnsByDefault * survey::turn_s(subject.body)
                                           : parse_duration(std::string_view(text).substr(at + 1)).high;
  if (!(subject.span_s > 0.0)) throw InputError("the span after @ must be positive");
  return subject;
}

void tell(std::string_view what) {
  if (isatty(STDERR_FILENO) != 0) {
    std::fprintf(stderr, "\r\033[K%.*s", static_cast<int>(what.size()), what.data());
    std::fflush(stderr);
  }
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(fmt::format("{}: cannot make the folder: {}", folder, error.message()));
}

std::string machine() {
  std::string model = "unknown processor";
  if (std::FILE* file = std::fopen("/proc/cpuinfo", "r")) {
    char line[256];
    while (std::fgets(line, sizeof line, file) != nullptr) {
      const std::string_view view(line);
      if (!view.starts_with("model name")) continue;
      model = view.substr(view.find(':') + 2);
      model.erase(model.find_last_not_of(" \n") + 1);
      break;
    }
    std::fclose(file);
  }
  return model;
}

std::string compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "gcc " __VERSION__;
#endif
}

std::vector<std::string> provenance(const std::string& what) {
  return {what, fmt::format("{}, {}", creator(), creation_date()), fmt::format("{}; {}", machine(), compiler())};
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

void say_how_to_plot(const std::string& table) {
  std::fprintf(stderr, "polhode: wrote %s; draw it with polhode plot %s\n", table.c_str(), table.c_str());
}

void chart_speed_accuracy(const ChartOptions& options) {
  constexpr int kInstants = 1000;
  constexpr double kEvaluations = 3e6, kEvaluationsPerTurn = 600.0;
  std::vector<survey::Subject> subjects;
  for (const std::string& text : or_standard(options.bodies, "/bodies/", kStandardBodies)) {
    subjects.push_back(in_file(text, [&] { return read_subject(text); }));
  }
  make_folder(options.folder);
  std::vector<std::vector<std::string>> rows;
  for (const survey::Subject& subject : subjects) {
    const int instants = std::max(10, static_cast<int>(kInstants * std::min(1.0, options.size)));
    const double most = std::max(kEvaluations, kEvaluationsPerTurn * subject.span_s / survey::turn_s(subject.body));
    const auto told = [&](std::string_view method) { tell(fmt::format("{}: {}", subject.name, method)); };
    for (const survey::SpeedAccuracyRow& r : survey::speed_accuracy(subject, instants, most * options.size, told)) {
      rows.push_back({subject.name, number(subject.span_s), number(subject.span_s / survey::turn_s(subject.body)),
                      std::string(r.method), std::string(r.family), fmt::format("{}", r.instants), number(r.step_s),
                      number(r.tolerance), number(r.errors.attitude_rad), number(r.errors.momentum),
                      number(r.errors.energy), number(r.errors.orthogonality), number(r.evaluations_per_instant),
                      number(r.ns_per_instant)});
    }
  }
  tell("");
  const std::string path = options.folder + "/speed-accuracy.ecsv";
  write_ecsv_table(path, provenance("speed against accuracy of every method of `polhode methods`"),
                   {{"body", "", "string", "file's name"},
                    {"span", "s", "float64", "length of the span"},
                    {"turns", "", "float64", "span / (2 pi / initial rate)"},
                    {"method", "", "string", "name"},
                    {"family", "", "string", "of the method: what is drawn alike"},
                    {"instants", "", "int64", "answered evenly over the span; 1 is its end alone"},
                    {"step", "s", "float64", "of a fixed-step method, else 0"},
                    {"tolerance", "", "float64", "of an adaptive method, else 0"},
                    {"attitude_error", "rad", "float64", "greatest angle to the reference"},
                    {"momentum_error", "", "float64", "greatest |m - m_true| / |m|"},
                    {"energy_error", "", "float64", "greatest relative error"},
                    {"orthogonality_error", "", "float64", "greatest | |q| - 1 |"},
                    {"evaluations", "", "float64", "per instant: right-hand sides, turns or exact solutions"},
                    {"time", "ns", "float64", "per instant, construction included, one thread"}},
                   rows);
  say_how_to_plot(path);
}

void chart_stability(const ChartOptions& options) {
  constexpr double kEvaluations = 3e5;
  make_folder(options.folder);
  std::vector<std::vector<std::string>> rows;
  for (const survey::StabilityRow& r : survey::stability(options.size, kEvaluations * options.size, tell)) {
    rows.push_back({std::string(r.map), number(r.x), number(r.y), std::string(r.method), std::string(r.outcome),
                    number(r.error), number(r.kappa), number(r.digits_lost)});
  }
  tell("");
  std::vector<std::string> comments = provenance("error of every method of `polhode methods` where methods fail");
  for (const survey::StabilityMap& m : survey::stability_maps()) {
    comments.push_back(fmt::format("{}: {}; x: {}; y: {}", m.name, m.title, m.x_label, m.y_label));
  }
  const std::string path = options.folder + "/stability.ecsv";
  write_ecsv_table(path, comments,
                   {{"map", "", "string", "name"},
                    {"x", "", "float64", "exponent of ten, see comments"},
                    {"y", "", "float64", "exponent of ten or index, see comments"},
                    {"method", "", "string", "name"},
                    {"outcome", "", "string", "answered, failed, too long or undetermined (eps kappa > 1)"},
                    {"error", "", "float64", "greatest of attitude angle in radians and relative momentum"},
                    {"kappa", "", "float64", "greatest condition number of an instant"},
                    {"digits_lost", "", "float64", "log10 of error / (eps max(1, kappa))"}},
                   rows);
  say_how_to_plot(path);
}

/// FILE or FILE@SPAN: a scene, or a case file with torques.
survey::TorquedSubject read_torqued_subject(const std::string& text) {
  const std::size_t at = text.rfind('@');
  const std::string file = text.substr(0, at);
  survey::TorquedSubject subject;
  subject.name = std::filesystem::path(file).stem().string();
  if (file.ends_with(".case")) {
    const CaseFile given = read_case_file(file);
    subject.body = given.body;
    subject.torques = given.torques;
    subject.span_s = *std::max_element(given.times_s.begin(), given.times_s.end());
  } else {
    const Scene scene = read_scene(file);
    subject.body = free_body(scene.body, scene.frame);
    subject.torques = scene.torques;
    subject.span_s = scene.last_s > 0.0 ? scene.last_s : scene.first_s;
  }
  if (at != std::string::npos) subject.span_s = parse_duration(std::string_view(text).substr(at + 1)).high;
  if (subject.torques.empty()) throw InputError("no torque, nothing to chart; see chart speed-accuracy");
  if (subject.body.momentum_body.isZero(0.0)) throw InputError("at rest at first, which has no turn to count by");
  if (subject.span_s == 0.0) throw InputError("the span is 0, another one is wanted, as FILE@SPAN");
  return subject;
}

void chart_torqued(const ChartOptions& options) {
  constexpr int kInstants = 1000;
  constexpr double kEvaluations = 5e4, kEvaluationsPerTurn = 500.0;
  std::vector<survey::TorquedSubject> subjects;
  for (const std::string& text : or_standard(options.bodies, "/", kStandardTorqued)) {
    subjects.push_back(in_file(text, [&] { return read_torqued_subject(text); }));
  }
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> comments =
      provenance("cost against accuracy under torques; the reference is extrapolation in long double");
  for (const survey::TorquedSubject& subject : subjects) {
    const double turns = std::abs(subject.span_s) / survey::turn_s(subject.body);
    const int instants = std::max(10, static_cast<int>(kInstants * std::min(1.0, options.size)));
    const double most = std::max(kEvaluations, kEvaluationsPerTurn * turns) * options.size;
    const auto told = [&](std::string_view method) { tell(fmt::format("{}: {}", subject.name, method)); };
    const survey::TorquedAccuracy result = survey::torqued_accuracy(subject, instants, most, told);
    const survey::TorquedReference& reference = result.reference;
    comments.push_back(fmt::format("{}: reference to {:.0e} rad: {}, estimated error {:.1e} rad, {} torque evaluations",
                                   subject.name, reference.tolerance_rad, reference.outcome, reference.error_rad,
                                   reference.evaluations));
    if (result.rows.empty()) {
      say(fmt::format("{} is left out: its reference did not reach the end within {} torque evaluations", subject.name,
                      reference.evaluations));
    }
    for (const survey::TorquedRow& r : result.rows) {
      rows.push_back({subject.name, number(subject.span_s), number(turns), r.method, std::string(r.kind),
                      fmt::format("{}", r.instants), number(r.step_s), number(r.free_step_s), number(r.tolerance),
                      number(r.attitude_rad), number(r.momentum), number(reference.error_rad), number(r.evaluations),
                      number(r.kept_evaluations), number(r.evaluations / turns), number(r.kept_evaluations / turns),
                      number(r.time_ns), number(r.time_ns / turns), number(r.time_ns / r.instants)});
    }
  }
  tell("");
  if (rows.empty()) {
    throw CheckFailed("no table is written, as everything is left out; take a shorter FILE@SPAN or a larger --size");
  }
  make_folder(options.folder);
  const std::string path = options.folder + "/torqued.ecsv";
  write_ecsv_table(path, comments,
                   {{"body", "", "string", "file's name"},
                    {"span", "s", "float64", "length of the span"},
                    {"turns", "", "float64", "span / (2 pi / initial rate)"},
                    {"method", "", "string", "name; of a splitting: kernel, scheme"},
                    {"kind", "", "string", "to an accuracy, exact kernel, other kernel or general"},
                    {"instants", "", "int64", "answered evenly over the span; 1 is its end alone"},
                    {"step", "s", "float64", "of a fixed-step method, else 0"},
                    {"free_step", "s", "float64", "longest of the free motion between kicks, where not exact, else 0"},
                    {"tolerance", "", "float64", "of an adaptive method, else 0"},
                    {"attitude_error", "rad", "float64", "greatest angle to the reference"},
                    {"momentum_error", "", "float64", "greatest |m - m_true| / |m_true|"},
                    {"reference_error", "rad", "float64", "the reference's own estimate"},
                    {"evaluations", "", "float64", "of the torques, all runs and answers together"},
                    {"kept_evaluations", "", "float64", "without runs that only chose steps or told the error"},
                    {"evaluations_per_turn", "", "float64", "evaluations / turns"},
                    {"kept_evaluations_per_turn", "", "float64", "kept_evaluations / turns"},
                    {"time", "ns", "float64", "of the processor, one thread, in all"},
                    {"time_per_turn", "ns", "float64", "time / turns"},
                    {"time_per_instant", "ns", "float64", "time / instants"}},
                   rows);
  say_how_to_plot(path);
}

}  // namespace

void add_chart(CLI::App& app) {
  auto options = std::make_shared<ChartOptions>();
  CLI::App* command = app.add_subcommand("chart", "Measure every method: speed against accuracy, and stability");
  command->footer(
      "Examples:\n  polhode chart speed-accuracy data/bodies/toutatis.toml -o charts\n"
      "  polhode chart stability -o charts");
  command->require_subcommand(1);
  const auto common = [&](CLI::App* kind) {
    kind->add_option("-o,--output", options->folder, "Folder for the table")->required();
    kind->add_option("--size", options->size, "1 takes minutes; more is finer and longer, less is quicker")
        ->check([](const std::string& text) {  // (CLI::Range takes NaN)
          double size = 0.0;
          const bool is_one = CLI::detail::lexical_cast(text, size) && size >= 0.01 && size <= 100.0;
          return is_one ? std::string() : "found " + text + ", a number from 0.01 to 100 is wanted";
        })
        ->capture_default_str();
  };
  CLI::App* speed = command->add_subcommand("speed-accuracy", "Error against cost, on bodies of your choice");
  common(speed);
  speed->add_option("BODY", options->bodies,
                    "Body or case file, with @SPAN if other than a thousand turns: toutatis.toml@7305d; without any, "
                    "six standard bodies of the source tree");
  speed->callback([options] { chart_speed_accuracy(*options); });
  CLI::App* torqued = command->add_subcommand("torqued", "Error against cost under torques");
  common(torqued);
  torqued->add_option("FILE", options->bodies,
                      "Scene file, or case file with torques, with @SPAN if other than its own: envisat-month.toml@3d; "
                      "without any, six standard ones of the source tree");
  torqued->callback([options] { chart_torqued(*options); });
  CLI::App* stability = command->add_subcommand("stability", "Error on maps of the places where methods fail");
  common(stability);
  stability->callback([options] { chart_stability(*options); });
}

}  // namespace polhode::tools
