#include "polhode/read/asteroid_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

double number_in(std::string_view word, const SourceLocation& where, std::string_view what) {
  const std::optional<double> value = parse_number(trimmed(word));
  if (!value) throw InputError(where, fmt::format("{}: '{:.60}' is not a number", what, word));
  return *value;
}

Instant julian_date(std::string_view word, const SourceLocation& where, TimeScale scale) {
  number_in(word, where, "JD");
  return located(where, [&] { return parse_date("JD " + std::string(trimmed(word)), scale); });
}

/// Rotation about a principal axis needs no moments: a sphere turns alike.
void set_any_inertia(Body& body) {
  if (body.inertia) return;
  body.inertia = inertia_from_moments(Vector3(1.0, 1.0, 1.0), false);
  body.any_inertia = true;
  body.notes.emplace_back("the moments of inertia are not known; rotation about a principal axis is the same for any");
}

struct Line {
  std::vector<std::string_view> words;
  std::size_t number = 0;
};

/// The lines that are not blank.
std::vector<Line> lines_of(std::string_view text, std::size_t most) {
  constexpr std::size_t longest = 4096;  // nothing that is wanted stands beyond
  std::vector<Line> lines;
  for (std::size_t number = 1; !text.empty() && lines.size() < most; ++number) {
    std::vector<std::string_view> words = split_words(take_line(text).substr(0, longest));
    if (!words.empty()) lines.push_back({std::move(words), number});
  }
  return lines;
}

std::vector<std::string> lower_cased(std::vector<std::string> names) {
  for (std::string& name : names) name = lower_case(name);
  return names;
}

bool has_all(const std::vector<std::string>& names, std::initializer_list<std::string_view> wanted) {
  return std::all_of(wanted.begin(), wanted.end(),
                     [&](std::string_view w) { return std::find(names.begin(), names.end(), w) != names.end(); });
}

/// One of the motions that have the published periods.
SpinSolution choose(const std::vector<SpinSolution>& motions, const PublishedSpin& spin, Body& body) {
  if (motions.size() == 1) return motions[0];
  const SpinSolution& a = motions[0];
  const SpinSolution& b = motions[1];
  if (spin.energy) return std::abs(a.energy - *spin.energy) <= std::abs(b.energy - *spin.energy) ? a : b;
  const std::string both =
      fmt::format("P_psi / P_phi occurs in short-axis mode with E/E0 = {:.6g} and in long-axis mode with {:.6g}",
                  a.energy, b.energy);
  if (!spin.likelier_mode) throw InputError(both + "; the mode or the energy must be given");
  const SpinSolution& taken = a.separatrix_distance >= b.separatrix_distance ? a : b;
  body.warnings.push_back(both + fmt::format("; {}-axis mode, farther from the separatrix, is assumed",
                                             taken.long_axis_mode ? "long" : "short"));
  return taken;
}

}  // namespace

void set_principal_axis_state(Body& body, const PublishedSpin& spin) {
  set_any_inertia(body);
  SpinState state;
  state.epoch = spin.epoch;
  state.epoch_scale = spin.epoch_scale;
  state.frame = spin.frame;
  state.omega_named_rad_s = Vector3(0.0, 0.0, 2.0 * std::numbers::pi / spin.rotation_period_s);
  if (spin.phi0_deg) {
    state.q_frame_from_named = q_frame_from_momentum(degree * spin.longitude_deg, degree * spin.latitude_deg) *
                               Quaternion(Eigen::AngleAxisd(degree * *spin.phi0_deg, Vector3::UnitZ()));
  } else {
    body.missing.emplace_back("the angle phi0 at its epoch");
  }
  body.state = state;
}

PublishedTumbling set_tumbling_state(Body& body, const PublishedSpin& spin) {
  const AxisConvention convention = spin.short_axis_convention ? AxisConvention::short_axis : AxisConvention::long_axis;
  const Inertia& inertia = body.inertia.value();
  const PublishedPeriods periods{convention, spin.precession_period_s, spin.rotation_period_s, spin.long_axis_mode};
  const SpinSolution motion = choose(solve_periods(inertia, periods), spin, body);
  const PublishedTumbling solved{periods,
                                 motion,
                                 degree * spin.longitude_deg,
                                 degree * spin.latitude_deg,
                                 degree * spin.phi0_deg.value_or(0.0),
                                 degree * spin.psi0_deg.value_or(0.0),
                                 spin.theta0_deg && std::abs(*spin.theta0_deg) > 90.0};
  body.notes.push_back(
      fmt::format("P_psi / P_phi = {:.8g} in the {}-axis convention gives {}-axis mode with E/E0 = {:.7g}",
                  spin.rotation_period_s / spin.precession_period_s, spin.short_axis_convention ? "short" : "long",
                  motion.long_axis_mode ? "long" : "short", motion.energy));
  if (spin.energy) {
    body.notes.push_back(fmt::format("E/E0 is published as {:.7g}{}: residual {:+.2g}", *spin.energy,
                                     spin.energy_sigma > 0.0 ? fmt::format(" +- {:.2g}", spin.energy_sigma) : "",
                                     motion.energy - *spin.energy));
  }
  SpinState state;
  state.epoch = spin.epoch;
  state.epoch_scale = spin.epoch_scale;
  state.frame = spin.frame;
  const auto rate = [&inertia](const Vector3& momentum_principal) {
    return Vector3(inertia.named_from_principal * momentum_principal.cwiseQuotient(inertia.principal_moments));
  };
  if (!spin.phi0_deg || !spin.psi0_deg) {
    state.omega_named_rad_s = rate(motion.momentum_at_psi_zero);
    body.missing.emplace_back("the angles phi0 and psi0 at its epoch");
    body.notes.push_back(fmt::format("the angular momentum is at {:.6g}, {:.6g} deg in {}", spin.longitude_deg,
                                     spin.latitude_deg, name(spin.frame)));
    body.state = state;
    return solved;
  }
  const EulerState at =
      state_at(inertia, convention, motion, solved.phi_rad, solved.psi_rad, solved.theta_above_90_deg);
  if (spin.theta0_deg) {
    const double energy = energy_at(inertia, convention, degree * *spin.theta0_deg, degree * *spin.psi0_deg);
    const double theta_deg = at.theta_rad / degree;
    body.notes.push_back(fmt::format(
        "theta0 and psi0 give E/E0 = {:.7g}: residual {:+.2g}; the periods are followed, theta is {:.6g} deg: "
        "residual {:+.2g} deg",
        energy, motion.energy - energy, theta_deg, theta_deg - std::abs(*spin.theta0_deg)));
  } else {
    body.warnings.emplace_back("theta0 is not given: two angles have this energy, and the one below 90 deg is taken");
  }
  const Quaternion q_frame_from_principal =
      q_frame_from_momentum(solved.longitude_rad, solved.latitude_rad) * at.q_momentum_from_principal;
  state.q_frame_from_named = (q_frame_from_principal * inertia.q_named_from_principal().conjugate()).normalized();
  state.omega_named_rad_s = rate(at.momentum_principal);
  body.state = state;
  return solved;
}

// --- DAMIT ----------------------------------------------------------------------------------------------------------

bool is_damit_spin(std::string_view text) {
  const std::vector<Line> lines = lines_of(text, 2);
  const auto numbers = [](const Line& line, std::size_t count) {
    return line.words.size() == count && std::all_of(line.words.begin(), line.words.end(),
                                                     [](std::string_view w) { return parse_number(w).has_value(); });
  };
  return lines.size() == 2 && numbers(lines[0], 3) && numbers(lines[1], 2);
}

Body parse_damit_spin(std::string_view text, const std::string& path) {
  const std::vector<Line> lines = lines_of(text, 3);
  const auto at = [&](std::size_t line) { return SourceLocation{path, lines[line].number}; };
  PublishedSpin spin;
  spin.longitude_deg = number_in(lines[0].words[0], at(0), "lambda");
  spin.latitude_deg = number_in(lines[0].words[1], at(0), "beta");
  spin.rotation_period_s = hour_s * number_in(lines[0].words[2], at(0), "P");
  spin.epoch = julian_date(lines[1].words[0], at(1), TimeScale::tdb);
  spin.phi0_deg = number_in(lines[1].words[1], at(1), "phi0");
  if (!(spin.rotation_period_s > 0.0)) throw InputError(at(0), "the period must be positive");
  if (std::abs(spin.latitude_deg) > 90.0) throw InputError(at(0), "beta is from -90 to 90 deg");
  Body body;
  body.name = path;
  body.source = "DAMIT spin.txt";
  set_principal_axis_state(body, spin);
  if (lines.size() > 2) body.notes.emplace_back("further lines (scattering) are left out");
  body.warnings.emplace_back("frame assumed: ecliptic of J2000; epoch scale assumed: TDB");
  return body;
}

bool is_damit_table(std::string_view text) {
  constexpr std::size_t longest = 1U << 16U;
  std::string_view rest = without_mark(text);
  std::vector<std::string> names;
  split_cells(take_line(rest).substr(0, longest), true, names);
  return has_all(lower_cased(names), {"lambda", "beta", "jd0"});
}

Body parse_damit_table(std::string_view text, const std::string& path, const std::string& row) {
  TextTable table(text, path);
  const std::vector<std::string> names = lower_cased(table.names());
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end()) {
    throw table.error(fmt::format("there are two columns '{:.40}'", *twice));
  }
  constexpr std::array<std::string_view, 6> of_tumblers{"psi0", "p_phi", "p_psi", "i1", "i2", "i3"};
  const bool tumbler = std::any_of(of_tumblers.begin(), of_tumblers.end(),
                                   [&](std::string_view name) { return has_all(names, {name}); });
  constexpr std::array<std::string_view, 11> known{"lambda", "beta", "phi0", "psi0", "theta0", "p_phi",
                                                   "p_psi",  "i1",   "i2",   "i3",   "jd0"};
  constexpr std::array<std::string_view, 9> bookkeeping{"id",      "asteroid_id",  "created", "modified", "comment",
                                                        "version", "quality_flag", "name",    "number"};
  if (tumbler) {
    for (const std::string& name : names) {
      if (std::find(known.begin(), known.end(), name) == known.end() &&
          std::find(bookkeeping.begin(), bookkeeping.end(), name) == bookkeeping.end()) {
        throw table.error(fmt::format("the column '{:.60}' of a table of tumblers is unknown; known are {} and {}",
                                      name, fmt::join(known, ", "), fmt::join(bookkeeping, ", ")));
      }
    }
  }
  const std::vector<std::string_view> wanted =
      tumbler ? std::vector<std::string_view>{"lambda", "beta", "phi0", "psi0", "p_phi", "p_psi", "i1", "i2", "jd0"}
              : std::vector<std::string_view>{"lambda", "beta", "period", "phi0", "jd0"};
  for (const std::string_view name : wanted) {
    if (!has_all(names, {name})) throw table.error(fmt::format("the column '{:.60}' is missing", name));
  }
  // The row asked for, or the only one.
  std::map<std::string, std::string> cells;
  std::size_t found_line = 0;
  std::size_t rows = 0;
  while (table.next()) {
    ++rows;
    std::map<std::string, std::string> candidate;
    for (std::size_t i = 0; i < names.size(); ++i) candidate[names[i]] = table.cell(i);
    if (!row.empty() && candidate["id"] != row) continue;
    if (found_line != 0) throw table.error("the table has several models; name one by its id, as FILE#ID");
    cells = std::move(candidate);
    found_line = table.here().line;
  }
  if (found_line == 0) {
    throw InputError(
        {path, 0}, row.empty() ? "the table has no rows" : fmt::format("none of the {} rows has the id {}", rows, row));
  }
  const SourceLocation at{path, found_line};
  const auto number = [&](const std::string& name) { return number_in(cells.at(name), at, name); };
  PublishedSpin spin;
  spin.longitude_deg = number("lambda");
  spin.latitude_deg = number("beta");
  spin.phi0_deg = number("phi0");
  spin.epoch = julian_date(cells.at("jd0"), at, TimeScale::tdb);
  if (std::abs(spin.latitude_deg) > 90.0) throw InputError(at, "beta is from -90 to 90 deg");
  Body body;
  body.name = cells.contains("id") ? "DAMIT model " + cells["id"] : path;
  body.source = tumbler ? "DAMIT, table of tumblers" : "DAMIT, table of models";
  body.warnings.emplace_back("frame assumed: ecliptic of J2000; epoch scale assumed: TDB");
  if (!tumbler) {
    spin.rotation_period_s = hour_s * number("period");
    if (!(spin.rotation_period_s > 0.0)) throw InputError(at, "the period must be positive");
    set_principal_axis_state(body, spin);
    if (cells.contains("yorp") && !cells["yorp"].empty() && number("yorp") != 0.0) {
      body.warnings.push_back(
          fmt::format("the change of the rate by YORP ({} rad/day^2) is not part of a free rotation", cells["yorp"]));
    }
    return body;
  }
  const double largest = cells.contains("i3") ? number("i3") : 1.0;
  spin.psi0_deg = number("psi0");
  if (cells.contains("theta0")) spin.theta0_deg = number("theta0");
  spin.likelier_mode = true;
  spin.precession_period_s = hour_s * number("p_phi");
  spin.rotation_period_s = hour_s * number("p_psi");
  body.warnings.emplace_back("axes assumed: I1 <= I2 <= I3, long-axis convention (Kaasalainen 2001)");
  located(at, [&] {
    body.inertia = inertia_from_moments(Vector3(number("i1"), number("i2"), largest), false);
    set_tumbling_state(body, spin);
  });
  return body;
}

// --- SHAPE ----------------------------------------------------------------------------------------------------------

bool is_shape_model(std::string_view text) { return text.find("{SPIN STATE}") != std::string_view::npos; }

Body parse_shape_model(std::string_view text, const std::string& path) {
  // The numbers of each line behind {SPIN STATE}; what stands in braces explains, c and f say whether a fit may vary
  // it.
  std::vector<std::pair<std::vector<std::string_view>, std::size_t>> rows;
  bool inside = false;
  std::size_t block_line = 0;
  for (std::size_t line = 1; !text.empty(); ++line) {
    std::string_view content = take_line(text);
    if (content.find("{SPIN STATE}") != std::string_view::npos) {
      inside = true;
      block_line = line;
      continue;
    }
    if (!inside) continue;
    std::vector<std::string_view> words = split_words(content.substr(0, content.find('{')));
    if (!words.empty() && (words[0] == "c" || words[0] == "f")) words.erase(words.begin());
    if (!words.empty()) rows.emplace_back(std::move(words), line);
  }
  constexpr std::size_t kept = 10;
  if (rows.size() < kept) {
    throw InputError({path, block_line},
                     fmt::format("the spin state ends after {} lines; date, 3 angles, 3 rates and 3 moments are wanted",
                                 rows.size()));
  }
  const auto at = [&](std::size_t row) { return SourceLocation{path, rows[row].second}; };
  const auto value = [&](std::size_t row) {
    if (rows[row].first.size() != 1)
      throw InputError(at(row), fmt::format("{} numbers, one is wanted", rows[row].first.size()));
    return number_in(rows[row].first[0], at(row), "spin state");
  };
  const auto three = [&](std::size_t row) { return Vector3(value(row), value(row + 1), value(row + 2)); };
  if (rows[0].first.size() != 6) throw InputError(at(0), "the date is year, month, day, hour, minute, second");
  std::array<long long, 6> date{};
  for (std::size_t k = 0; k < 6; ++k) {
    const double part = number_in(rows[0].first[k], at(0), "date");
    if (part != std::floor(part) || part < 0.0 || part > 9999.0)
      throw InputError(at(0), "the date is six whole numbers");
    date[k] = static_cast<long long>(part);
  }
  Body body;
  body.name = path;
  body.source = "SHAPE model file";
  SpinState state;
  state.epoch_scale = TimeScale::utc;
  state.epoch = located(at(0), [&] {
    return parse_date(
        fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", date[0], date[1], date[2], date[3], date[4], date[5]),
        TimeScale::utc);
  });
  state.frame = Frame::ecliptic_j2000;
  state.q_frame_from_named = q_frame_from_body(EulerSequence("ZXZ"), degree * three(1));
  state.omega_named_rad_s = degree / day_s * three(4);
  body.inertia = located(at(7), [&] { return inertia_from_moments(three(7), false); });
  body.state = state;
  body.warnings.emplace_back("frame assumed: ecliptic of J2000; epoch scale assumed: UTC");
  for (std::size_t row = kept; row < std::min<std::size_t>(rows.size(), kept + 3); ++row) {
    if (value(row) != 0.0)
      body.warnings.push_back(
          fmt::format("line {}: a change of the rate is not part of a free motion", rows[row].second));
  }
  return body;
}

}  // namespace polhode
