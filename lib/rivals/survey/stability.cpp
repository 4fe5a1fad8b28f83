#include "rivals/survey/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polhode::survey {

namespace {

constexpr double free_tolerance = 1e-13;
// Fixed steps per turn that a careful user would take: of high orders fewer do.
constexpr double usual_steps_per_turn = 100.0, steps_per_turn_of_high_order = 25.0;
constexpr int high_order = 6;

double steps_per_turn(const rivals::MeasuredMethod& method) {
  return method.fixed_order < high_order ? usual_steps_per_turn : steps_per_turn_of_high_order;
}

constexpr double fractions_of_span[] = {0.21, 0.47, 0.73, 0.89, 1.0};

Quaternion some_attitude() { return from_scalar_first({0.5, -0.5, 0.5, 0.5}); }

/// From `first` to `last` in powers of ten, `per_decade` of them.
std::vector<double> exponents(double first, double last, double per_decade) {
  const int count = std::max(2, static_cast<int>(std::lround(std::abs(last - first) * per_decade)) + 1);
  std::vector<double> e;
  e.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) e.push_back(first + (last - first) * i / (count - 1));
  return e;
}

/// Rows of one body at spans of several numbers of turns: y is given per span.
struct MapColumn {
  std::string_view map;
  double x = 0.0;
  FreeBody body;
  struct Cell {
    double y = 0.0, turns = 0.0;
  };
  std::vector<Cell> cells;
};

void survey_column(const MapColumn& column, double most_evaluations, std::vector<StabilityRow>& rows) {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  const double turn = turn_s(column.body);
  std::vector<double> times;
  for (const MapColumn::Cell& cell : column.cells) {
    for (const double f : fractions_of_span) times.push_back(f * cell.turns * turn);
  }
  const double last = *std::max_element(times.begin(), times.end());
  const rivals::QuadrupleReference reference(rivals::in_quadruple(column.body), 0.0, last);
  const std::vector<double> kappas = rivals::condition_numbers(column.body, times);
  std::vector<rivals::ScaledState<rivals::Quadruple>> truth;
  truth.reserve(times.size());
  for (const double t : times) truth.push_back(reference.at(t));

  constexpr std::size_t n = std::size(fractions_of_span);
  for (std::size_t c = 0; c < column.cells.size(); ++c) {
    const std::span<const double> instants(&times[c * n], n);
    for (const rivals::MeasuredMethod& method : rivals::measured_methods()) {
      StabilityRow row;
      row.map = column.map;
      row.x = column.x;
      row.y = column.cells[c].y;
      row.method = method.name;
      const rivals::StepControl control{.step_s = turn / steps_per_turn(method),
                                        .tolerance = free_tolerance,
                                        .max_evaluations = static_cast<std::int64_t>(most_evaluations)};
      const Answers answers = answer(method, column.body, control, instants);
      const bool too_long = static_cast<double>(answers.evaluations) > most_evaluations;
      bool determined = false, finite = !answers.failed;
      row.digits_lost = -std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < n; ++i) {
        const double kappa = kappas[c * n + i];
        if (!(eps * kappa < 1.0)) continue;
        determined = true;
        if (!finite) continue;
        const Errors e = errors_of_row(column.body, answers, i, truth[c * n + i]);
        const double error = std::max(e.attitude_rad, e.momentum);
        finite = finite && std::isfinite(e.attitude_rad) && std::isfinite(e.momentum);
        row.error = std::max(row.error, error);
        row.kappa = std::max(row.kappa, kappa);
        row.digits_lost = std::max(row.digits_lost, std::log10(error / (eps * std::max(1.0, kappa))));
      }
      row.outcome = !determined ? "undetermined" : finite ? "answered" : too_long ? "too long" : "failed";
      if (row.outcome != "answered") {
        row.error = std::numeric_limits<double>::quiet_NaN();
        row.digits_lost = row.error;
      }
      rows.push_back(row);
    }
  }
}

/// Moments 1, 2, 2.5; m3 / m1 such that 2 T = |m|^2 / I2 when `excess` is 0, and m1^2 / I1 shrinks with it.
FreeBody beside_the_separatrix(double excess) {
  const double share = std::sqrt((1.0 - 1.0 / 2.0) / (1.0 / 2.0 - 1.0 / 2.5));
  return {{1.0, 2.0, 2.5}, some_attitude(), {0.3, 0.6, 0.3 * share * std::sqrt(1.0 + excess)}};
}

void separatrix(double size, std::vector<MapColumn>& columns) {
  std::vector<MapColumn::Cell> spans;
  for (const double e : exponents(0, 9, size)) spans.push_back({e, std::pow(10.0, e)});
  // x: the exponent of the distance, counted away from the separatrix on either side; 0 is the separatrix.
  for (const double side : {-1.0, 1.0}) {
    for (const double e : exponents(0, -16, size / 2)) {
      const double distance = side < 0 ? -0.9 * std::pow(10.0, e) : std::pow(10.0, e);
      columns.push_back({"separatrix", side * (17.0 + e), beside_the_separatrix(distance), spans});
    }
  }
  columns.push_back({"separatrix", 0.0, beside_the_separatrix(0.0), spans});
}

void near_sphere(double size, std::vector<MapColumn>& columns) {
  // x: asymmetry 1 - I1 / I3; y: where I2 stands, from I1 (negative exponents) to I3 (positive).
  for (const double e : exponents(0, -16, size / 2)) {
    const double asymmetry = 0.5 * std::pow(10.0, e);
    for (const double side : {-1.0, 1.0}) {
      for (const double p : exponents(-1, -16, size / 5)) {
        const double part = std::pow(10.0, p);
        const double i2 = side < 0 ? 1.0 + asymmetry * part : (1.0 + asymmetry) - asymmetry * part;
        const FreeBody body{{1.0, i2, 1.0 + asymmetry}, some_attitude(), {0.48, 0.6, 0.64}};
        columns.push_back({"near-sphere", e, body, {{side * -p, 100.0}}});
      }
    }
  }
}

void needle(double size, std::vector<MapColumn>& columns) {
  // x: I1 / I3; y: (I3 - I2) / I1, at most 1.
  for (const double e : exponents(0, -16, size / 2)) {
    for (const double p : exponents(-0.1, -16, size / 2)) {
      const double least = 0.9 * std::pow(10.0, e);
      const double between = std::max(least, 1.0 - least * std::pow(10.0, p));
      const FreeBody body{{least, between, 1.0}, some_attitude(), {0.48, 0.6, 0.64}};
      columns.push_back({"needle", e, body, {{p, 100.0}}});
    }
  }
}

void axes(double size, std::vector<MapColumn>& columns) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double e : exponents(0, -160, size / 10)) {
      Vector3 m = Vector3::Constant(0.6 * std::pow(10.0, e));
      m[axis] = 1.0;
      const double y = 3.0 * axis;
      columns.push_back(
          {"axis", e, {{1.0, 2.0, 2.5}, some_attitude(), m}, {{y, 1.0}, {y + 1.0, 100.0}, {y + 2.0, 10000.0}}});
    }
  }
}

void spans(double size, std::vector<MapColumn>& columns) {
  const FreeBody bodies[] = {
      {{1.0, 2.0, 2.5}, some_attitude(), {0.2, 0.3, 0.9}},                  // short-axis mode
      {{1.0, 3.08, 3.23}, some_attitude(), {0.6, 0.7, 0.3}},                // long-axis mode
      {{1.0, 1.9, 1.9}, some_attitude(), {0.48, 0.6, 0.64}},                // symmetric top
      {{1e-6, 1.0, 1.0 + 1e-7}, some_attitude(), {0.1, 0.7, 0.7}},          // needle
      {{1.0, 1.0 + 1e-5, 1.0 + 3e-5}, some_attitude(), {0.48, 0.6, 0.64}},  // near-sphere
      beside_the_separatrix(1e-4),
  };
  double y = 0.0;
  for (const FreeBody& body : bodies) {
    for (const double e : exponents(0, 9, size)) columns.push_back({"span", e, body, {{y, std::pow(10.0, e)}}});
    y += 1.0;
  }
}

void units(double size, std::vector<MapColumn>& columns) {
  // Powers of two: the same body in other units, to the last bit. x: of inertia, y: of time.
  constexpr double log2_of_10 = 3.3219280948873623;
  for (const double inertia : exponents(-150, 150, size / 50)) {
    for (const double time : exponents(-150, 150, size / 50)) {
      const int i = static_cast<int>(std::lround(inertia * log2_of_10));
      const int t = static_cast<int>(std::lround(time * log2_of_10));
      FreeBody body{{1.0, 2.0, 2.5}, some_attitude(), {0.48, 0.6, 0.64}};
      for (int k = 0; k < 3; ++k) {
        body.principal_moments[k] = std::ldexp(body.principal_moments[k], i);
        body.momentum_body[k] = std::ldexp(body.momentum_body[k], i - t);
      }
      columns.push_back({"units", inertia, body, {{time, 10.0}}});
    }
  }
}

}  // namespace

const std::vector<StabilityMap>& stability_maps() {
  static const std::vector<StabilityMap> maps{
      {"separatrix", "Distance from the separatrix", "long-axis side | distance | short-axis side", "turns"},
      {"near-sphere", "Near-spheres, 100 turns", "1 - I1/I3",
       "I2 - I1 (below) and I3 - I2 (above) as parts of I3 - I1"},
      {"needle", "Needles, 100 turns", "I1/I3", "(I3 - I2)/I1"},
      {"axis", "Rotation near a principal axis", "tilt", "axis and turns"},
      {"span", "Length of the span", "turns", "body"},
      {"units", "Units, 10 turns", "unit of inertia", "unit of time"},
  };
  return maps;
}

std::vector<StabilityRow> stability(double size, double most_evaluations,
                                    const std::function<void(std::string_view)>& told) {
  std::vector<MapColumn> columns;
  separatrix(size, columns);
  near_sphere(size, columns);
  needle(size, columns);
  axes(size, columns);
  spans(size, columns);
  units(size, columns);
  std::vector<StabilityRow> rows;
  std::string_view map;
  for (const MapColumn& column : columns) {
    if (told && column.map != map) told(column.map);
    map = column.map;
    survey_column(column, most_evaluations, rows);
  }
  return rows;
}

}  // namespace polhode::survey
