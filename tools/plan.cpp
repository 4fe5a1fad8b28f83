#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/motion/known_until.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/session/body_in_motion.hpp"
#include "polhode/time/duration_text.hpp"
#include "subcommands.hpp"

namespace polhode::tools {
namespace {

struct PlanOptions {
  std::string scene_file;
  bool full = false;
};

std::string angle_text(double rad) {
  constexpr double least_deg = 1e-3, arcsec_in_degree = 3600.0;
  const double deg = rad * degrees;
  return deg >= least_deg ? fmt::format("{:.3g} deg", deg) : fmt::format("{:.3g} arcsec", deg * arcsec_in_degree);
}

void print_plan(const PlanOptions& options) {
  const Scene scene = read_scene(options.scene_file);
  const Plan plan = plan_of(scene, options.full);
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(
      out, "scene      {}\nspan       {:.6g} s to {:.6g} s from the epoch ({} to {})\naccuracy   {:.3g} rad ({})\n",
      printable(scene.name), scene.first_s, scene.last_s, duration_text(scene.first_s), duration_text(scene.last_s),
      scene.accuracy_rad, angle_text(scene.accuracy_rad));
  fmt::format_to(out, "\n{:<26} {:>12} {:>12}  {:<8} {}\n", "effect", "periodic/rad", "secular/rad", "", "why");
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    const PlannedEffect& effect = plan.effects[i];
    const auto angle = [](const std::optional<double>& rad) { return rad ? fmt::format("{:.2e}", *rad) : "-"; };
    fmt::format_to(out, "{:<26} {:>12} {:>12}  {:<8} {}\n", printable(scene.torque_names[i]),
                   angle(effect.periodic_rad), angle(effect.secular_rad), effect.kept ? "kept" : "dropped", effect.why);
  }
  fmt::format_to(out, "\nmodel      {} ({})\nerror      at most {:.2e} rad ({}), of which dropped effects {:.2e} rad\n",
                 plan.model, plan.why, plan.error_rad, angle_text(plan.error_rad), plan.dropped_rad);
  fmt::format_to(out, "cost       {} ({})\n",
                 plan.torque_evaluations ? fmt::format("about {:.2g} torque evaluations", *plan.torque_evaluations)
                                         : "cannot be told before it runs",
                 plan.cost_why);
  const double farthest_s = std::max(-scene.first_s, scene.last_s);
  if (const auto caution = scene_worth_text(scene.body, scene.uncertain != nullptr, farthest_s))
    fmt::format_to(out, "caution    {}\n", *caution);
  write_standard_output({text.data(), text.size()});
}

}  // namespace

void add_plan(CLI::App& app) {
  const auto options = std::make_shared<PlanOptions>();
  CLI::App* command = app.add_subcommand("plan", "Which effects a scene needs, by bounds, and which model");
  command->footer("Examples:\n  polhode plan data/scenes/envisat-month.toml");
  command->add_option("SCENE", options->scene_file, "Scene file")->required();
  command->add_flag("--full", options->full, "Keep every effect");
  command->callback([options] { in_file(options->scene_file, [&] { print_plan(*options); }); });
}

}  // namespace polhode::tools
