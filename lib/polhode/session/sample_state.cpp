#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/session/sample.hpp"
#include "polhode/write/document.hpp"

namespace polhode {
namespace {

std::uint64_t whole_of(std::string_view text) {
  const auto value = parse_integer(text);
  if (!value || *value < 0) {
    throw InputError(fmt::format("is no part of a sample: '{}' is no number", plain_text(text.substr(0, 40))));
  }
  return static_cast<std::uint64_t>(*value);
}

double number_of(std::string_view text) {
  const auto value = parse_number(text);
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::string SampleState::text() const {
  std::string out = fmt::format(
      "polhode sample 2\nidentity {}\nobject {}\nframe {}\nscale {}\nseed {}\ncount {}\n"
      "reference_mjd {}\npart {} {} {}\ntimes {}\n",
      identity, object, frame, scale, seed, count, reference_mjd, part.first, part.last, next, dates.size());
  for (std::size_t j = 0; j < dates.size(); ++j) {
    const CloneState& p = published[j];
    const Eigen::Vector4d q = scalar_first(p.q_inertial_from_named);
    out += fmt::format("time {} {} {} {} {} {} {} {} {} {} {} {} {}\n", dates[j], times_s[j], q[0], q[1], q[2], q[3],
                       p.momentum_inertial[0], p.momentum_inertial[1], p.momentum_inertial[2], p.rate_rad_s,
                       static_cast<int>(p.mode), p.polhode_period_s, p.long_axis_precession_period_s);
    out += text_of(at[j]);
  }
  out += fmt::format("digest {:016x}\n", text_digest(out));
  return out + "end\n";
}

SampleState SampleState::of_text(const std::string& text) {
  std::string_view rest = text;
  const auto take = [&rest](std::string_view name) {
    std::string_view line = take_line(rest);
    if (take_word(line) != name)
      throw InputError(fmt::format("is no part of a sample, or a broken one: no '{}'", name));
    return std::string(trimmed(line));
  };
  SampleState state;
  if (take("polhode") != "sample 2") throw InputError("is no part of a sample that this program knows");
  state.identity = take("identity");
  state.object = take("object");
  state.frame = take("frame");
  state.scale = take("scale");
  state.seed = whole_of(take("seed"));
  state.count = whole_of(take("count"));
  state.reference_mjd = number_of(take("reference_mjd"));
  const std::string part_line = take("part");
  const auto part_words = split_words(part_line);
  if (part_words.size() != 3) throw InputError("is no part of a sample, or a broken one: its part");
  state.part = {whole_of(part_words[0]), whole_of(part_words[1])};
  state.next = whole_of(part_words[2]);
  const std::uint64_t times = whole_of(take("times"));
  for (std::uint64_t j = 0; j < times; ++j) {
    const std::string line = take("time");
    const auto words = split_words(line);
    if (words.size() != 13) throw InputError("is no part of a sample, or a broken one: a time");
    double n[13];
    for (std::size_t k = 1; k < 13; ++k) n[k] = number_of(words[k]);
    state.dates.emplace_back(words[0]);
    state.times_s.push_back(n[1]);
    state.published.push_back({Quaternion(n[2], n[3], n[4], n[5]), Vector3(n[6], n[7], n[8]), n[9],
                               static_cast<CloneState::Mode>(std::clamp(static_cast<int>(n[10]), 0, 2)), n[11], n[12]});
    state.at.push_back(take_clones(rest));
  }
  const std::string_view until_here = std::string_view(text).substr(0, text.size() - rest.size());
  if (take("digest") != fmt::format("{:016x}", text_digest(until_here))) {
    throw InputError("is no part of a sample, or a broken one: its digest is that of another text");
  }
  if (rest != "end\n") throw InputError("is no whole part of a sample");
  return state;
}

SampleState joined(std::vector<SampleState> parts) {
  if (parts.empty()) throw InputError("no part is given");
  std::sort(parts.begin(), parts.end(), [](const SampleState& a, const SampleState& b) {
    return std::pair(a.part.first, a.part.last) < std::pair(b.part.first, b.part.last);
  });
  SampleState whole = std::move(parts.front());
  std::uint64_t until = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const SampleState& part = k == 0 ? whole : parts[k];
    if (part.identity != whole.identity) {
      throw InputError("the parts are of different samples: of another body, seed, count, times or version");
    }
    if (part.next != part.part.last) {
      throw InputError(fmt::format("the part of clones {} to {} is not complete", part.part.first, part.part.last));
    }
    if (part.part.first != until) {
      throw InputError(fmt::format("clones {} to {} are {}", std::min(until, part.part.first),
                                   std::max(until, part.part.first),
                                   part.part.first > until ? "missing" : "there twice"));
    }
    until = part.part.last;
    for (std::size_t j = 0; k > 0 && j < whole.at.size(); ++j) whole.at[j].add(part.at[j]);
  }
  if (until != whole.count) throw InputError(fmt::format("clones {} to {} are missing", until, whole.count));
  whole.part = {0, whole.count};
  whole.next = whole.count;
  return whole;
}

void write_sample_statistics(const std::string& path, const SampleState& state) {
  using Kind = NumberColumn::Kind;
  static constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;
  static constexpr double sizes[] = {0.5, 0.682689492137086, 0.954499736103642, 0.997300203936740};
  static constexpr double signed_parts[] = {0.00134989803163, 0.158655253931457, 0.5, 0.841344746068543,
                                            0.99865010196837};
  const bool fits = is_fits_path(path);
  NumberTable table;
  table.extension = "SAMPLE";
  if (fits) {
    table.columns.push_back({"TIME", {"time"}, "s"});
  } else {
    table.columns.push_back({"TIME", {"date_" + lower_case(state.scale)}, "", Kind::label, state.dates});
  }
  const auto quantiles = [&table](const std::string& column, const std::string& text, const std::string& unit,
                                  bool is_size) {
    const std::vector<std::string> ends = is_size ? std::vector<std::string>{"50", "68", "95", "997"}
                                                  : std::vector<std::string>{"m3s", "m1s", "50", "p1s", "p3s"};
    std::vector<std::string> names(ends.size());
    std::transform(ends.begin(), ends.end(), names.begin(),
                   [&](const auto& end) { return fmt::format("{}_{}", text, end); });
    table.columns.push_back({column, std::move(names), unit});
  };
  table.columns.push_back({"QMEAN", {"q_x", "q_y", "q_z", "q_scalar"}, ""});
  table.columns.push_back({"SPREAD", {"attitude_spread_deg"}, "deg"});
  quantiles("ANGLE", "attitude_angle_deg", "deg", true);
  table.columns.push_back({"LDIR", {"momentum_ra_deg", "momentum_dec_deg"}, "deg"});
  table.columns.push_back({"LSPREAD", {"momentum_spread_deg"}, "deg"});
  quantiles("LANGLE", "momentum_angle_deg", "deg", true);
  table.columns.push_back({"PMODE", {"p_short_axis", "p_long_axis", "p_other"}, ""});
  quantiles("RATE", "rate_deviation", "", false);
  quantiles("PPSI", "polhode_period_deviation", "", false);
  quantiles("PPHI", "precession_period_deviation", "", false);
  const auto text = [&table](const char* keyword, const char* key, const std::string& value, const char* comment) {
    table.entries.push_back({keyword, key, value, 0.0, false, comment});
  };
  const auto number = [&table](const char* keyword, const char* key, double value, const char* comment) {
    table.entries.push_back({keyword, key, "", value, true, comment});
  };
  text("OBJECT", "object", state.object, "body");
  text("CREATOR", "creator", creator(), "program that wrote this file");
  text("DATE", "created_utc", creation_date(), "when written, UTC");
  if (fits) {
    text("TIMESYS", "scale", state.scale, "time scale of TIME");
    number("MJDREF", "mjdref", state.reference_mjd, "[d] TIME counts from this MJD");
    text("TIMEUNIT", "time_unit", "s", "unit of TIME");
  }
  text("REFFRAMA", "frame_a", state.frame, "frame A, of the attitudes");
  number("NCLONES", "clones", static_cast<double>(state.count), "how many were drawn");
  text("SEED", "seed", fmt::format("{}", state.seed), "key of Philox4x32-10");
  table.comments = {
      "QMEAN, passive from frame A to the body, scalar last, is the attitude with the least mean square of "
      "sin(angle/2); "
      "SPREAD is 2 asin of the root of that mean. LDIR, LSPREAD: the same of the direction of the angular momentum, in "
      "ICRF.",
      "ANGLE, LANGLE: below which 50, 68.27, 95.45, 99.73 per cent of the clones lie from the published body's.",
      "RATE, PPSI, PPHI: quantiles at -3, -1, 0, 1, 3 normal sigmas of value over published value, less 1, of the "
      "rate, "
      "the period of the polhode and that of the long axis' precession, to a part in 100 of themselves."};
  table.rows = state.at.size();
  const std::size_t width = table.width();
  write_number_table(
      path, table,
      [&](std::size_t first, std::span<double> out) {
        double* to = out.data();
        for (std::size_t j = first; j < first + out.size() / width; ++j) {
          const ClonesAtTime& clones = state.at[j];
          *to++ = fits ? state.times_s[j] : static_cast<double>(j);
          const Eigen::Vector4d q = scalar_first(clones.mean_attitude());
          for (const int k : {1, 2, 3, 0}) *to++ = q[k];
          *to++ = kDegreesPerRad * clones.attitude_spread_rad();
          // A quantile may end at the border of a step of its histogram, beyond the most that there can be.
          const auto angle_deg = [](const Histogram& angles, double part) {
            const double deg = kDegreesPerRad * angles.quantile(part);
            return deg > 180.0 ? 180.0 : deg;
          };
          for (const double part : sizes) *to++ = angle_deg(clones.attitude_angle, part);
          for (const double angle : ra_dec_deg(clones.mean_direction(), frame(state.frame))) *to++ = angle;
          *to++ = kDegreesPerRad * clones.direction_spread_rad();
          for (const double part : sizes) *to++ = angle_deg(clones.direction_angle, part);
          for (const std::uint64_t mode : clones.modes) {
            *to++ = static_cast<double>(mode) / static_cast<double>(clones.count);
          }
          for (const Histogram* histogram : {&clones.rate, &clones.polhode_period, &clones.precession_period}) {
            for (const double part : signed_parts) {
              const double deviation = histogram->quantile(part);
              *to++ = deviation < -1.0 ? -1.0 : deviation;
            }
          }
        }
      },
      {}, 1);
}

}  // namespace polhode
