#include "polhode/read/horizons_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/read/units.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

constexpr int kHorizonsDegree = 7;

/// "A.D. 2029-Apr-13 21:46:00.0000 TDB" as "2029-04-13T21:46:00.0000".
std::string iso_date(std::string_view text, const SourceLocation& where) {
  constexpr std::array<std::string_view, 12> months{"JAN", "FEB", "MAR", "APR", "MAY", "JUN",
                                                    "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"};
  const auto wrong = [&] {
    return InputError(where, fmt::format("'{:.40}' is no date of Horizons, as A.D. 2029-Apr-13 21:46:00.0000", text));
  };
  std::string_view rest = trimmed(text);
  if (!rest.starts_with("A.D.")) throw wrong();
  rest = trimmed(rest.substr(4));
  const std::size_t first = rest.find('-'),
                    second = first == std::string_view::npos ? first : rest.find('-', first + 1);
  if (second == std::string_view::npos) throw wrong();
  const std::string name = upper_case(rest.substr(first + 1, second - first - 1));
  const auto* const month = std::find(months.begin(), months.end(), name);
  if (month == months.end()) throw wrong();
  std::string_view clock = rest.substr(second + 1);
  const std::size_t blank = clock.find(' ');
  if (blank == std::string_view::npos) throw wrong();
  const std::string_view day = clock.substr(0, blank);
  clock = trimmed(clock.substr(blank));
  clock = clock.substr(0, clock.find(' '));
  return fmt::format("{:0>4}-{:02}-{:0>2}T{}", rest.substr(0, first), month - months.begin() + 1, day, clock);
}

/// The numbers of a line, whose labels ("X =", "VX=") are left out.
void add_numbers(std::string_view line, std::vector<double>& numbers, const SourceLocation& where) {
  std::string plain(line);
  for (std::size_t equals = plain.find('='); equals != std::string::npos; equals = plain.find('=', equals)) {
    std::size_t begin = equals;
    while (begin > 0 && plain[begin - 1] == ' ') --begin;
    while (begin > 0 && std::isalpha(static_cast<unsigned char>(plain[begin - 1])) != 0) --begin;
    std::fill(plain.begin() + static_cast<std::ptrdiff_t>(begin),
              plain.begin() + static_cast<std::ptrdiff_t>(equals) + 1, ' ');
  }
  std::vector<std::string> cells;
  split_cells(plain, false, cells);
  for (const std::string& cell : cells) {
    const std::optional<double> number = parse_number(cell);
    if (!number) throw InputError(where, fmt::format("'{:.40}' is not a number", cell));
    numbers.push_back(*number);
  }
}

class HorizonsReader {
 public:
  HorizonsReader(std::string_view text, const std::string& path, const TrajectoryRequest& request)
      : rest_(text), path_(path), request_(request) {}

  CentredTrajectory read() {
    read_header();
    const std::size_t begin = line_;
    if (csv_) {
      read_csv();
    } else {
      read_plain();
    }
    if (table_.times_s.empty()) throw InputError({path_, begin}, "there is no row between $$SOE and $$EOE");
    const int nodes = static_cast<int>(table_.times_s.size()) * (with_velocity_ ? 2 : 1);
    table_.degree = std::clamp(nodes - 1, 1, kHorizonsDegree);
    Trajectory trajectory = located({path_, begin}, [&] { return Trajectory(TabulatedOrbit({std::move(table_)})); });
    return {std::move(trajectory), centre_};
  }

 private:
  SourceLocation here() const { return {path_, line_}; }

  std::string_view next() {
    ++line_;
    return trimmed(take_line(rest_));
  }

  void read_header() {
    std::string_view names, kind;
    while (!rest_.empty()) {
      const std::string_view line = next();
      if (line.starts_with("$$SOE")) break;
      if (line.starts_with("JD")) names = line;
      const std::size_t colon = line.find(':');
      if (colon == std::string_view::npos) continue;
      const std::string_view key = trimmed(line.substr(0, colon));
      std::string_view value = trimmed(line.substr(colon + 1));
      if (key == "Center body name") {
        value = trimmed(value.substr(0, value.find('{')));
        centre_ = upper_case(trimmed(value.substr(0, value.rfind('('))));
      } else if (key == "Center-site name" && value != "BODY CENTER") {
        throw InputError(here(),
                         fmt::format("the vectors are from the site {:.40}; those from a BODY CENTER are read", value));
      } else if (key == "Output units") {
        read_units(value);
      } else if (key == "Output type") {
        kind = value;
        if (!value.starts_with("GEOMETRIC")) {
          throw InputError(here(), fmt::format("the vectors are '{:.40}'; GEOMETRIC ones are wanted", value));
        }
      } else if (key == "Output format") {
        format_ = value.empty() ? '0' : value[0];
      } else if (key == "Reference frame" || key == "Coordinate systm") {
        read_frame(value);
      }
    }
    if (kind.empty() || position_m_ == 0.0 || names.empty() || centre_.empty() || !frame_) {
      throw InputError(
          {path_, 0},
          "is no vector table of Horizons: before $$SOE it has not all of 'Center body name', 'Output units', "
          "'Output type', 'Reference frame' and the line of names that begins with JD (Ephemeris Type: Vector Table)");
    }
    const std::string scale = upper_case(names.substr(2, names.find_first_of(", ", 2) - 2));
    scale_ = located(here(), [&] { return time_scale(scale == "UT" ? std::string_view("UTC") : scale); });
    csv_ = names.find(',') != std::string_view::npos;
    if (csv_) split_cells(names, true, names_);
    q_wanted_from_table_ = q_icrf_from(request_.frame).conjugate() * q_icrf_from(*frame_);
  }

  void read_units(std::string_view value) {
    const std::string units = upper_case(value.substr(0, value.find_first_of(" ,")));
    const std::size_t dash = units.find('-');
    if (units != "AU-D" && units != "KM-S" && units != "KM-D") {
      throw InputError(here(), fmt::format("the units are '{:.20}'; AU-D, KM-S and KM-D are read", value));
    }
    position_m_ = length_unit_m(units[0] == 'A' ? "au" : "km");
    velocity_m_s_ = position_m_ / (units[dash + 1] == 'D' ? 86400.0 : 1.0);
  }

  void read_frame(std::string_view value) {
    const std::string name = upper_case(value);
    const bool of_1950 = name.find("1950") != std::string::npos;
    if (!of_1950 && name.starts_with("ECLIPTIC")) {
      frame_ = Frame::ecliptic_j2000;
    } else if (!of_1950 && (name.starts_with("ICRF") || name.starts_with("EARTH MEAN EQUATOR"))) {
      frame_ = Frame::icrf;
    } else {
      throw InputError(here(), fmt::format("the frame is '{:.60}'; ICRF and the ecliptic of J2000 are read", value));
    }
  }

  void add(std::string_view date, const std::vector<double>& numbers, std::size_t velocity_at) {
    const Instant time = located(here(), [&] { return parse_date(iso_date(date, here()), scale_); });
    const double t_s = (time - request_.zero).high;
    if (!table_.times_s.empty() && !(table_.times_s.back() < t_s)) {
      throw InputError(here(), "this time is not after the one above");
    }
    table_.times_s.push_back(t_s);
    table_.positions_m.emplace_back(q_wanted_from_table_ * (position_m_ * Vector3(numbers[0], numbers[1], numbers[2])));
    if (!with_velocity_) return;
    table_.velocities_m_s.emplace_back(
        q_wanted_from_table_ *
        (velocity_m_s_ * Vector3(numbers[velocity_at], numbers[velocity_at + 1], numbers[velocity_at + 2])));
  }

  void read_csv() {
    const auto column = [this](std::string_view name) {
      return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
    };
    std::array<std::size_t, 6> at{};
    constexpr std::array<std::string_view, 6> wanted{"X", "Y", "Z", "VX", "VY", "VZ"};
    std::transform(wanted.begin(), wanted.end(), at.begin(), column);
    if (std::any_of(at.begin(), at.begin() + 3, [this](std::size_t i) { return i == names_.size(); })) {
      throw InputError(here(), "there are no columns X, Y, Z");
    }
    with_velocity_ = std::all_of(at.begin() + 3, at.end(), [this](std::size_t i) { return i < names_.size(); });
    const std::size_t count = with_velocity_ ? 6 : 3;
    std::vector<std::string> cells;
    std::vector<double> numbers(count);
    while (!rest_.empty()) {
      const std::string_view line = next();
      if (line.starts_with("$$EOE")) return;
      if (line.empty()) continue;
      split_cells(line, true, cells);
      if (cells.size() < names_.size() - (names_.back().empty() ? 1 : 0)) {
        throw InputError(here(), fmt::format("{} cells; {} are wanted", cells.size(), names_.size()));
      }
      for (std::size_t k = 0; k < count; ++k) {
        const std::optional<double> number = parse_number(cells[at[k]]);
        if (!number) throw InputError(here(), fmt::format("'{:.40}' is not a number", cells[at[k]]));
        numbers[k] = *number;
      }
      add(cells[1], numbers, 3);
    }
    throw InputError(here(), "the table ends without $$EOE");
  }

  void read_plain() {
    // Formats: 1 position, 2 state, 3 state and light time, 4 position and light time.
    if (format_ == '5' || format_ == '6') throw InputError(here(), "the table has no positions; type 2 or 3 is wanted");
    with_velocity_ = format_ == '2' || format_ == '3';
    const std::size_t least = with_velocity_ ? 6 : 3;
    std::string date;
    std::vector<double> numbers;
    const auto finish = [&] {
      if (date.empty()) return;
      if (numbers.size() < least) {
        throw InputError(here(), fmt::format("the row above has {} numbers; {} are wanted", numbers.size(), least));
      }
      add(date, numbers, 3);
      numbers.clear();
    };
    while (!rest_.empty()) {
      const std::string_view line = next();
      if (line.starts_with("$$EOE")) {
        finish();
        return;
      }
      const std::size_t era = line.find("A.D.");
      if (era != std::string_view::npos) {
        finish();
        date = line.substr(era);
      } else if (!line.empty()) {
        add_numbers(line, numbers, here());
      }
    }
    throw InputError(here(), "the table ends without $$EOE");
  }

  std::string_view rest_;
  const std::string& path_;
  const TrajectoryRequest& request_;
  std::size_t line_ = 0;
  std::string centre_;
  std::vector<std::string> names_;
  std::optional<Frame> frame_;
  TimeScale scale_ = TimeScale::tdb;
  char format_ = '3';
  bool csv_ = false, with_velocity_ = false;
  double position_m_ = 0.0, velocity_m_s_ = 0.0;
  Quaternion q_wanted_from_table_;
  OrbitTable table_;
};

}  // namespace

bool is_horizons(std::string_view text) {
  return text.starts_with("$$SOE") || text.find("\n$$SOE") != std::string_view::npos;
}

CentredTrajectory parse_horizons(std::string_view text, const std::string& path, const TrajectoryRequest& request) {
  if (request.table_frame) throw InputError({path, 1}, "a table of Horizons names its own frame");
  return HorizonsReader(text, path, request).read();
}

}  // namespace polhode
