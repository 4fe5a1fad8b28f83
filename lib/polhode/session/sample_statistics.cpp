#include "polhode/session/sample_statistics.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/base/units.hpp"
#include "polhode/write/document.hpp"

namespace polhode {
namespace {

constexpr double kUnit = 0x1p62;

InputError broken_part(const std::string& what) {
  return InputError("is no part of a sample, or a broken one: " + plain_text(what));
}

std::uint64_t unsigned_of(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size()) {
    throw broken_part(fmt::format("'{:.40}' is no number", text));
  }
  return value;
}

Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> axes_of(const ClonesAtTime& clones) {
  Eigen::Matrix4d products;
  std::size_t place = 0;
  for (int i = 0; i < 4; ++i) {
    for (int k = i; k < 4; ++k) products(i, k) = products(k, i) = clones.attitude[place++].value();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(products / static_cast<double>(clones.count));
}

// One line: a name, and numbers.
std::string_view take_fields(std::string_view& text, std::string_view name) {
  std::string_view line = take_line(text);
  if (!line.starts_with(name) || line.size() == name.size() || line[name.size()] != ' ') {
    throw broken_part(fmt::format("'{:.40}' stands where '{}' is wanted", line, name));
  }
  line.remove_prefix(name.size() + 1);
  return line;
}

std::string_view take_field(std::string_view& line) {
  const std::size_t end = std::min(line.find(' '), line.size());
  const std::string_view field = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  return field;
}

template <class Clones>
auto histograms(Clones& clones) {
  return std::array{std::pair("attitude_angle", &clones.attitude_angle),
                    std::pair("direction_angle", &clones.direction_angle), std::pair("rate", &clones.rate),
                    std::pair("polhode_period", &clones.polhode_period),
                    std::pair("precession_period", &clones.precession_period)};
}

}  // namespace

void ExactSum::add(double x) { sum_ += static_cast<Integer>(std::llrint(std::clamp(x, -1.0, 1.0) * kUnit)); }

double ExactSum::value() const { return static_cast<double>(sum_) / kUnit; }

std::string ExactSum::text() const {
  const auto low = static_cast<std::uint64_t>(sum_);
  const auto high = static_cast<std::uint64_t>(sum_ >> 64);
  return fmt::format("{}:{}", high, low);
}

ExactSum ExactSum::of_text(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) throw broken_part(fmt::format("'{:.40}' is no sum", text));
  ExactSum sum;
  sum.sum_ = static_cast<Integer>(unsigned_of(text.substr(0, colon))) << 64;
  sum.sum_ += static_cast<Integer>(unsigned_of(text.substr(colon + 1)));
  return sum;
}

void Histogram::add(double x) {
  if (std::isnan(x)) return;
  int step = -1;
  const double size = std::abs(x);
  if (size >= std::ldexp(1.0, kLeast)) {
    int exponent = 0;
    const double fraction = std::frexp(size, &exponent);  // 1/2 to 1
    const int within = static_cast<int>((fraction - 0.5) * (2.0 * kSteps));
    step = std::isinf(x) ? kHalf - 1 : std::min(kHalf - 1, (exponent - 1 - kLeast) * kSteps + within);
  }
  const int place = kHalf + (x < 0.0 ? -1 - step : 1 + step);
  ++counts_[static_cast<std::size_t>(place)];
}

void Histogram::add(const Histogram& other) {
  std::transform(counts_.begin(), counts_.end(), other.counts_.begin(), counts_.begin(), std::plus<>());
}

std::uint64_t Histogram::total() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }

double Histogram::quantile(double part) const {
  const std::uint64_t all = total();
  if (all == 0) return std::numeric_limits<double>::quiet_NaN();
  const double wanted = part * static_cast<double>(all);
  const auto border = [](int step) {  // the least size of a step
    const int octave = step / kSteps, within = step % kSteps;
    return std::ldexp(1.0 + static_cast<double>(within) / kSteps, kLeast + octave);
  };
  double below = 0.0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const auto here = static_cast<double>(counts_[i]);
    if (here == 0.0 || below + here < wanted) {
      below += here;
      continue;
    }
    const int place = static_cast<int>(i) - kHalf;
    if (place == 0) return 0.0;
    const int step = std::abs(place) - 1;
    if (step == kHalf - 1) return std::copysign(std::numeric_limits<double>::infinity(), place);
    const double within = std::clamp((wanted - below) / here, 0.0, 1.0);
    const double low = border(step), high = border(step + 1);
    return place > 0 ? low + within * (high - low) : -(high - within * (high - low));
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::array<double, 2> ra_dec_deg(const Vector3& direction, Frame frame) {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (direction.isZero(0.0)) return {kNone, kNone};
  const Direction icrf = direction_of(q_icrf_from(frame) * direction);
  return {icrf.longitude_rad / degree, icrf.latitude_rad / degree};
}

void ClonesAtTime::add(const CloneState& clone, const CloneState& published) {
  ++count;
  ++modes[static_cast<std::size_t>(clone.mode)];
  const Eigen::Vector4d q = scalar_first(clone.q_inertial_from_named);
  std::size_t place = 0;
  for (int i = 0; i < 4; ++i) {
    for (int k = i; k < 4; ++k) attitude[place++].add(q[i] * q[k]);
  }
  const Vector3 unit = clone.momentum_inertial.stableNormalized();
  for (std::size_t k = 0; k < 3; ++k) direction[k].add(unit[static_cast<Eigen::Index>(k)]);
  attitude_angle.add(rotation_angle_rad(published.q_inertial_from_named, clone.q_inertial_from_named));
  const Vector3 from = published.momentum_inertial.stableNormalized();
  if (!from.isZero(0.0) && !unit.isZero(0.0)) {
    direction_angle.add(std::atan2(from.cross(unit).norm(), from.dot(unit)));
  }
  rate.add(clone.rate_rad_s / published.rate_rad_s - 1.0);
  polhode_period.add(clone.polhode_period_s / published.polhode_period_s - 1.0);
  precession_period.add(clone.long_axis_precession_period_s / published.long_axis_precession_period_s - 1.0);
}

void ClonesAtTime::add(const ClonesAtTime& other) {
  count += other.count;
  for (std::size_t k = 0; k < modes.size(); ++k) modes[k] += other.modes[k];
  for (std::size_t k = 0; k < attitude.size(); ++k) attitude[k].add(other.attitude[k]);
  for (std::size_t k = 0; k < direction.size(); ++k) direction[k].add(other.direction[k]);
  const auto mine = histograms(*this);
  const auto others = histograms(other);
  for (std::size_t k = 0; k < mine.size(); ++k) mine[k].second->add(*others[k].second);
}

Quaternion ClonesAtTime::mean_attitude() const {
  Eigen::Vector4d q = axes_of(*this).eigenvectors().col(3);
  int largest = 0;
  q.cwiseAbs().maxCoeff(&largest);
  if (q[largest] < 0.0) q = -q;
  return from_scalar_first(q);
}

double ClonesAtTime::attitude_spread_rad() const {
  // The three smaller eigenvalues are the mean square of sin(angle/2): their sum does not cancel.
  const Eigen::Vector4d parts = axes_of(*this).eigenvalues();
  return 2.0 * std::asin(std::sqrt(std::clamp(parts[0] + parts[1] + parts[2], 0.0, 1.0)));
}

Vector3 ClonesAtTime::mean_direction() const {
  return Vector3(direction[0].value(), direction[1].value(), direction[2].value()).stableNormalized();
}

double ClonesAtTime::direction_spread_rad() const {
  const double length =
      Vector3(direction[0].value(), direction[1].value(), direction[2].value()).norm() / static_cast<double>(count);
  return 2.0 * std::asin(std::sqrt(std::clamp(0.5 * (1.0 - length), 0.0, 1.0)));
}

std::string text_of(const ClonesAtTime& clones) {
  std::string out =
      fmt::format("clones {} {} {} {}\nattitude", clones.count, clones.modes[0], clones.modes[1], clones.modes[2]);
  for (const ExactSum& sum : clones.attitude) out += ' ' + sum.text();
  out += "\ndirection";
  for (const ExactSum& sum : clones.direction) out += ' ' + sum.text();
  out += '\n';
  for (const auto& [name, histogram] : histograms(clones)) {
    out += name;
    out += " from";
    const auto& counts = histogram->counts();
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] != 0) out += fmt::format(" {}:{}", i, counts[i]);
    }
    out += '\n';
  }
  return out;
}

ClonesAtTime take_clones(std::string_view& text) {
  ClonesAtTime clones;
  std::string_view line = take_fields(text, "clones");
  clones.count = unsigned_of(take_field(line));
  for (std::uint64_t& mode : clones.modes) mode = unsigned_of(take_field(line));
  line = take_fields(text, "attitude");
  for (ExactSum& sum : clones.attitude) sum = ExactSum::of_text(take_field(line));
  line = take_fields(text, "direction");
  for (ExactSum& sum : clones.direction) sum = ExactSum::of_text(take_field(line));
  for (const auto& [name, histogram] : histograms(clones)) {
    line = take_fields(text, name);
    take_field(line);
    while (!line.empty()) {
      const std::string_view field = take_field(line);
      const std::size_t colon = std::min(field.find(':'), field.size() - 1);
      const std::uint64_t place = unsigned_of(field.substr(0, colon));
      if (place >= histogram->counts().size()) throw broken_part("a step of a histogram that there is not");
      histogram->counts()[place] = unsigned_of(field.substr(colon + 1));
    }
  }
  return clones;
}

}  // namespace polhode
