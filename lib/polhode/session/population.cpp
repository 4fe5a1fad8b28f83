#include "polhode/session/population.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/ephemeris/time_grid.hpp"
#include "polhode/read/date_column.hpp"
#include "polhode/read/fits_table.hpp"
#include "polhode/read/range.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/write/document.hpp"

namespace polhode {
namespace {

constexpr std::array<const char*, 3> moment_names{"I1", "I2", "I3"};
constexpr std::array<const char*, 4> q_names{"q_scalar", "q_x", "q_y", "q_z"};
constexpr std::array<const char*, 3> rate_names{"omega_body_x_rad_s", "omega_body_y_rad_s", "omega_body_z_rad_s"};

template <std::size_t count>
std::array<std::size_t, count> columns_of(const TextTable& table, const std::array<const char*, count>& names) {
  std::array<std::size_t, count> columns;
  for (std::size_t k = 0; k < count; ++k) {
    columns[k] = table.column(names[k]);
    if (columns[k] == table.names().size()) {
      throw table.error(
          fmt::format("the table has no column {}; those of a body are I1, I2, I3, q_x, q_y, q_z, q_scalar, "
                      "omega_body_x_rad_s, omega_body_y_rad_s, omega_body_z_rad_s",
                      names[k]));
    }
  }
  return columns;
}

/// What a table may hold of a row: states that FreeBodies takes, of bodies that are possible.
void check_row(const Population& population) {
  const std::size_t i = population.size() - 1;
  const Vector3 moments(&population.moments[3 * i]), rates(&population.rates[3 * i]);
  FreeBody body;
  body.principal_moments = moments;
  body.q_inertial_from_body = from_scalar_first(Eigen::Vector4d(&population.q[4 * i]));
  body.momentum_body = moments.cwiseProduct(rates);
  checked(body);
  check_triangle(moments);
  check_range_of_rate(rates);
}

Population population_of_text(std::string_view text, const std::string& path, std::optional<Instant> epoch) {
  TextTable table(text, path);
  const auto moments = columns_of(table, moment_names);
  const auto q = columns_of(table, q_names);
  const auto rates = columns_of(table, rate_names);
  const std::optional<DateColumn> dates = epoch ? std::nullopt : DateColumn::in(table);
  if (!dates && !epoch) {
    throw table.error("the table has no column of epochs, as date_tdb or jd_utc; --epoch gives one for all bodies");
  }
  const std::size_t name = table.column("name");
  Population out;
  out.frame = table.header().entry("frame_a");
  while (table.next()) {
    for (const std::size_t column : moments) out.moments.push_back(table.number(column));
    for (const std::size_t column : q) out.q.push_back(table.number(column));
    for (const std::size_t column : rates) out.rates.push_back(table.number(column));
    out.epochs.push_back(epoch ? *epoch : table.located([&] { return dates->date(table); }));
    if (name < table.names().size()) out.names.push_back(table.cell(name));
    table.located([&] { check_row(out); });
  }
  return out;
}

Population population_of_fits(std::string_view bytes, const std::string& path, std::optional<Instant> epoch) {
  const FitsTable table(bytes, "BODIES", path);
  const auto fail = [&path](const std::string& message) { return InputError({path, 0}, message); };
  const auto moments = table.column("MOMENTS", 3), q = table.column("QPARAM", 4), rates = table.column("OMEGA", 3),
             time = table.column("TIME", 1);
  if (!moments || !q || !rates) throw fail("the table BODIES has no column MOMENTS, QPARAM or OMEGA");
  std::optional<Instant> reference;
  TimeScale scale = TimeScale::tdb;
  if (!epoch) {
    const auto day = table.number("MJDREF");
    const auto scale_name = table.text("TIMESYS");
    if (!time || !day || !scale_name) {
      throw fail("the table BODIES has no TIME with MJDREF and TIMESYS; --epoch gives one epoch for all bodies");
    }
    scale = located({path, 0}, [&] { return time_scale(*scale_name); });
    reference = parse_date(fmt::format("MJD {:.17g}", *day), scale);
  }
  Population out;
  out.frame = table.text("REFFRAMA").value_or("");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    out.moments.insert(out.moments.end(), &moments->values[3 * i], &moments->values[3 * i] + 3);
    for (const std::size_t k : {3, 0, 1, 2}) out.q.push_back(q->values[4 * i + k]);
    out.rates.insert(out.rates.end(), &rates->values[3 * i], &rates->values[3 * i] + 3);
    if (epoch) {
      out.epochs.push_back(*epoch);
    } else {
      const double seconds = time->values[i];
      if (!(std::abs(seconds) < 1e12)) throw fail(fmt::format("row {}: TIME is out of range", i + 1));
      out.epochs.push_back(instant_from_j2000(since_j2000(*reference, scale) + Seconds{seconds, 0.0}, scale));
    }
    located({path, 0}, [&] {
      try {
        check_row(out);
      } catch (const InputError& error) {
        throw InputError(fmt::format("row {}: {}", i + 1, error.what()));
      }
    });
  }
  return out;
}

NumberTable table_of(const Population& population, const TimeGrid& times, TimeResolution resolution, bool is_fits) {
  NumberTable table;
  table.extension = "STATES";
  using Kind = NumberColumn::Kind;
  if (is_fits) {
    table.columns.push_back({"TIME", {"time"}, "s"});
  } else {
    std::vector<std::string> dates(times.size());
    for (std::size_t j = 0; j < dates.size(); ++j) {
      dates[j] = format_date(times.instant(times.time(j, resolution)), times.scale(), resolution.decimals);
    }
    table.columns.push_back({"TIME", {"date_" + lower_case(name(times.scale()))}, "", Kind::label, std::move(dates)});
  }
  table.columns.push_back({"BODY", {"body"}, "", Kind::whole});
  if (!population.names.empty()) table.columns.push_back({"NAME", {"name"}, "", Kind::label, population.names});
  table.columns.push_back({"QPARAM", {"q_x", "q_y", "q_z", "q_scalar"}, ""});
  table.columns.push_back({"OMEGA", {rate_names.begin(), rate_names.end()}, "rad / s"});
  const auto text = [&table](const char* keyword, const char* key, const std::string& value, const char* comment) {
    table.entries.push_back({keyword, key, value, 0.0, false, comment});
  };
  text("CREATOR", "creator", creator(), "program that wrote this file");
  text("DATE", "created_utc", creation_date(), "when written, UTC");
  if (is_fits) {
    text("TIMESYS", "scale", std::string(name(times.scale())), "time scale of TIME");
    table.entries.push_back({"MJDREF", "mjdref", "", times.reference_mjd(), true, "[d] TIME counts from this MJD"});
    text("TIMEUNIT", "time_unit", "s", "unit of TIME");
    text("QORDER", "q_order", "XYZS", "order within QPARAM: vector part, scalar last");
    text("QDIR", "q_direction", "A2B", "QPARAM takes components from frame A to frame B");
  }
  if (!population.frame.empty()) text("REFFRAMA", "frame_a", population.frame, "frame A, of the attitudes");
  text("REFFRAMB", "frame_b", "principal axes of each body", "frame B");
  table.comments = {"BODY counts the rows of the table of bodies from 1. The states are those of free bodies."};
  table.rows = times.size() * population.size();
  return table;
}

}  // namespace

Population read_population(const std::string& path, std::optional<Instant> epoch) {
  const std::string text = read_text_file(path);
  Population out =
      text.starts_with("SIMPLE  =") ? population_of_fits(text, path, epoch) : population_of_text(text, path, epoch);
  if (out.size() == 0) throw InputError({path, 0}, "the table has no rows");
  return out;
}

void write_population(const std::string& path, const Population& population, std::span<const Instant> instants,
                      TimeScale scale, const Progress& progress, unsigned thread_count) {
  const bool fits = is_fits_path(path);
  const TimeGrid times = TimeGrid::of_list(instants, scale);
  const TimeResolution resolution = fits ? TimeResolution{TimeResolution::Kind::one_double, 0}
                                         : TimeResolution{TimeResolution::Kind::decimals, times.decimals()};
  const NumberTable table = table_of(population, times, resolution, fits);

  const std::size_t count = population.size();
  std::vector<double> momenta(3 * count), reciprocals(3 * count);
  for (std::size_t k = 0; k < momenta.size(); ++k) {
    momenta[k] = population.moments[k] * population.rates[k];
    reciprocals[k] = 1.0 / population.moments[k];
  }
  const FreeBodies bodies(
      BodyArrays::of_structures(population.moments.data(), population.q.data(), momenta.data(), count),
      {.thread_count = thread_count});
  // TT seconds from the first body's epoch to the instants, and to the other epochs.
  std::vector<Seconds> row_times(times.size()), elapsed(times.size()), epochs(count);
  for (std::size_t j = 0; j < times.size(); ++j) {
    row_times[j] = times.time(j, resolution);
    elapsed[j] = times.instant(row_times[j]) - population.epochs.front();
  }
  for (std::size_t i = 0; i < count; ++i) epochs[i] = population.epochs[i] - population.epochs.front();

  const std::size_t width = table.width(), before_q = population.names.empty() ? 2 : 3;
  const auto fill = [&](std::size_t first, std::span<double> out) {
    constexpr std::size_t in_block = FreeBodies::kBlock;
    const std::size_t rows = out.size() / width;
    for (std::size_t row = first; row < first + rows;) {
      const std::size_t j = row / count, body = row % count, block = body / in_block;
      const std::size_t until = std::min({first + rows - row, count - body, (block + 1) * in_block - body});
      theta::BlockTimes at{};
      FreeBodies::BlockRows places;
      for (std::size_t lane = 0; lane < in_block; ++lane) {
        const Seconds& epoch = epochs[std::min(block * in_block + lane, count - 1)];
        const Seconds high = exact_sum(elapsed[j].high, -epoch.high);
        at.high[lane] = high.high;
        at.low[lane] = high.low + (elapsed[j].low - epoch.low);
        places[lane] = static_cast<std::ptrdiff_t>(lane);
      }
      double q[in_block][4], m[in_block][3];
      bodies.block(block, at, StateArrays::of_structures(q[0], m[0]), places);
      for (std::size_t k = 0; k < until; ++k, ++row) {
        const std::size_t i = body + k, lane = i % in_block;
        double* to = out.data() + (row - first) * width;
        *to++ = fits ? row_times[j].high : static_cast<double>(j);
        *to++ = static_cast<double>(i + 1);
        if (before_q == 3) *to++ = static_cast<double>(i);
        for (const int component : {1, 2, 3, 0}) *to++ = q[lane][component];
        for (std::size_t axis = 0; axis < 3; ++axis) *to++ = m[lane][axis] * reciprocals[3 * i + axis];
      }
    }
  };
  write_number_table(path, table, fill, progress, thread_count);
}

}  // namespace polhode
