#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/quantity.hpp"
#include "subcommands.hpp"

namespace polhode::tools {
namespace {

constexpr double arcseconds = 3600.0 * degrees;

struct Options {
  std::string first;
  std::string second;
  std::string tolerance;
  bool as_json = false;
};

/// What a file says whose attitude it holds.
struct Object {
  std::string name;
  std::string id;
};

/// Warns of two names that are not one, unless the designations are.
void warn_of_two_objects(const Object& a, const Object& b) {
  if (a.name.empty() || b.name.empty() || upper_case(a.name) == upper_case(b.name)) return;
  if (!a.id.empty() && upper_case(a.id) == upper_case(b.id)) return;
  say(fmt::format("the attitudes are of two objects, by their names: {} and {}", a.name, b.name));
}

/// The free motion of a body file as attitude in ICRF.
std::function<Quaternion(Instant)> motion_of(const std::string& path, const Body& body) {
  const FreeBody free = in_file(path, [&] { return free_body(body, Frame::icrf); });
  const std::shared_ptr<const Motion> motion = method("auto").make(free);
  return [motion, free, epoch = body.state->epoch](Instant time) {
    const Seconds elapsed = time - epoch;
    return named_state(free, motion->at(elapsed.high, elapsed.low)).q_inertial_from_named;
  };
}

void run(const Options& options) {
  const double tolerance_rad = options.tolerance.empty()
                                   ? HUGE_VAL
                                   : in_option("--tolerance", [&] { return parse_angle_rad(options.tolerance); });
  if (!(tolerance_rad >= 0.0)) {
    throw OptionError(fmt::format("--tolerance is '{:.60}', an angle of 0 or more is wanted", options.tolerance));
  }
  const BodyAndHistory first = read_body_and_history(options.first), second = read_body_and_history(options.second);
  const std::optional<AttitudeHistory>&a = first.history, &b = second.history;
  if (!a && !b)
    throw InputError(
        fmt::format("neither {} nor {} is an attitude ephemeris; one must be, its times are those of the comparison",
                    options.first, options.second));
  if (a) in_file(options.first, [&] { refuse_overlaps(*a); });
  if (b) in_file(options.second, [&] { refuse_overlaps(*b); });
  const AttitudeHistory& rows = a ? *a : *b;
  const std::string both = fmt::format("{} and {}", options.first, options.second);
  AttitudeDifference d;
  Object other;
  if (a && b) {
    other = {b->object, b->object_id};
    d = in_file(both, [&] { return compare(*a, *b); });
  } else {
    const Body& body = (a ? second : first).body;
    other = {body.name, body.id};
    const auto motion = motion_of(a ? options.second : options.first, body);
    d = in_file(both, [&] { return compare(rows, motion); });
  }
  warn_of_two_objects({rows.object, rows.object_id}, other);
  const std::string where = format_date(d.time_of_largest, rows.scale, 6);
  if (options.as_json) {
    const nlohmann::ordered_json out{{"first", options.first},
                                     {"second", options.second},
                                     {"times_of", a ? options.first : options.second},
                                     {"rows_compared", d.compared},
                                     {"rows_outside", d.outside},
                                     {"largest_rad", d.largest_rad},
                                     {"root_mean_square_rad", d.root_mean_square_rad},
                                     {"largest_at", where},
                                     {"scale", name(rows.scale)}};
    write_standard_output(out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  } else {
    const auto angle = [](double rad) {
      return fmt::format("{:.6g} rad = {:.6g} deg = {:.6g} arcsec", rad, rad * degrees, rad * arcseconds);
    };
    write_standard_output(fmt::format(
        "angle between attitudes, {} and {}\n  times                         {} rows of {}{}\n"
        "  largest                       {}\n  at                            {} {}\n"
        "  root mean square              {}\n",
        printable(options.first), printable(options.second), d.compared, printable(a ? options.first : options.second),
        d.outside == 0 ? "" : fmt::format(" ({} more lie outside of the other)", d.outside), angle(d.largest_rad),
        where, name(rows.scale), angle(d.root_mean_square_rad)));
  }
  for (const auto& [history, file] : {std::pair(&a, &options.first), std::pair(&b, &options.second)}) {
    if (!*history) continue;
    for (const std::string& warning : (*history)->warnings) warn(*file, warning);
  }
  if (d.largest_rad > tolerance_rad) {
    throw CheckFailed(
        fmt::format("the attitudes differ by {:.6g} rad, more than {}", d.largest_rad, options.tolerance));
  }
}

}  // namespace

void add_compare(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("compare", "The angle between two attitudes: ephemerides, or one and a body's motion");
  command->footer(
      "Examples:\n  polhode compare ours.fits theirs.aem --tolerance \"10 mas\"\n"
      "  polhode compare theirs.aem toutatis.toml --json");
  command
      ->add_option("A", options->first,
                   fmt::format("an ephemeris ({}) or a file that `info` reads", names_of_histories()))
      ->required();
  command->add_option("B", options->second, "the same; at least one is an ephemeris, A's times are used if A is one")
      ->required();
  command->add_option("--tolerance", options->tolerance,
                      "angle, such as \"1e-6 rad\", \"0.1 deg\", \"2 arcsec\": exit status 1 beyond it");
  command->add_flag("--json", options->as_json, "one JSON object");
  command->callback([options] { run(*options); });
}

}  // namespace polhode::tools
