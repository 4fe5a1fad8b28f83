#include "polhode/read/uncertain_numbers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "polhode/body/body.hpp"
#include "polhode/read/range.hpp"

namespace polhode {
namespace {

std::string sigma_key(std::string_view key) { return std::string(key) + "_sigma"; }

double checked_sigma(const TomlTable& table, std::string_view key, double sigma) {
  if (sigma >= 0.0 && sigma <= kGreatestSigmaRead) return sigma;
  throw table.error(key, fmt::format("found {}, an uncertainty of 0 or more is wanted, up to 1e100", sigma));
}

}  // namespace

std::size_t UncertainNumbers::add(const TomlTable& table, std::string_view key,
                                  std::initializer_list<std::string_view> parts) {
  const std::size_t place = numbers_.size();
  const bool single = parts.size() == 0;
  const std::vector<double> values = single ? std::vector<double>{table.number(key)} : table.numbers(key, parts.size());
  std::vector<double> sigmas(values.size(), 0.0);
  if (const std::string sigma = sigma_key(key); table.has(sigma)) {
    sigmas = single ? std::vector<double>{table.number(sigma)} : table.numbers(sigma, parts.size());
    for (double& s : sigmas) s = checked_sigma(table, sigma, s);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::string name(key);
    if (!single) name.append(1, '.').append(parts.begin()[i]);
    numbers_.push_back({{std::move(name), values[i], {}}, sigmas[i]});
    values_.push_back(values[i]);
  }
  return place;
}

std::size_t UncertainNumbers::add_symmetric(const TomlTable& table, std::string_view key) {
  const std::size_t place = numbers_.size();
  const Matrix3 values = table.matrix3(key);
  Matrix3 sigmas = Matrix3::Zero();
  const std::string sigma = sigma_key(key);
  if (table.has(sigma)) {
    sigmas = table.matrix3(sigma);
    if (sigmas != sigmas.transpose()) {
      throw table.error(sigma, "found a matrix that is not symmetric; its elements are those of a symmetric one");
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int k = i; k < 3; ++k) {
      numbers_.push_back({{fmt::format("{}.{}{}", key, "xyz"[i], "xyz"[k]), values(i, k), {}},
                          checked_sigma(table, sigma, sigmas(i, k))});
      values_.push_back(values(i, k));
    }
  }
  return place;
}

void UncertainNumbers::set_changes(std::size_t place, std::vector<EpochChange> changes) {
  for (EpochChange& change : changes) numbers_[place++].published.change = std::move(change);
}

void UncertainNumbers::make(Body& body, BodyPart part) {
  part(values_, body);
  parts_.push_back(std::move(part));
}

double UncertainNumbers::sigma_beside(const TomlTable& table, std::string_view key) {
  const std::string sigma = sigma_key(key);
  return table.has(sigma) ? checked_sigma(table, sigma, table.number(sigma)) : 0.0;
}

void UncertainNumbers::follow(const std::function<void(EpochChange&)>& effect) {
  for (Number& number : numbers_) effect(number.published.change);
}

std::shared_ptr<const Uncertainty> UncertainNumbers::uncertainty(const TomlTable& root, Body blank) const {
  std::vector<bool> uncertain(numbers_.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i) uncertain[i] = numbers_[i].sigma > 0.0;
  std::vector<std::size_t> listed;
  Eigen::MatrixXd of_listed;
  if (root.has("uncertainty")) {
    const TomlTable table = root.table("uncertainty");
    table.allow_only({"parameters", "covariance"});
    for (const std::string& name : table.texts("parameters")) {
      const auto found = std::find_if(numbers_.begin(), numbers_.end(),
                                      [&](const Number& number) { return number.published.name == name; });
      if (found == numbers_.end()) {
        std::vector<std::string_view> names;
        for (const Number& number : numbers_) names.emplace_back(number.published.name);
        throw table.error("parameters", fmt::format("'{:.60}' is no number of this file; allowed are {}", name,
                                                    fmt::join(names, ", ")));
      }
      const auto i = static_cast<std::size_t>(found - numbers_.begin());
      if (std::find(listed.begin(), listed.end(), i) != listed.end()) {
        throw table.error("parameters", fmt::format("'{:.60}' stands there twice", name));
      }
      listed.push_back(i);
      uncertain[i] = true;
    }
    if (listed.empty()) throw table.error("parameters", "found an empty list, names of parameters are wanted");
    const std::vector<std::vector<double>> rows = table.square("covariance", listed.size());
    of_listed.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.size()));
    Uncertainty alone;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      alone.numbers.push_back(numbers_[listed[i]].published);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        of_listed(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
      }
    }
    alone.covariance = of_listed;
    table.located("covariance", [&] { alone.check(); });
    for (std::size_t i = 0; i < listed.size(); ++i) {
      const Number& number = numbers_[listed[i]];
      const double sigma = alone.sigma(i);
      if (number.sigma > 0.0 && std::abs(number.sigma - sigma) > 0.01 * sigma) {
        throw table.error("covariance", fmt::format("of {} it gives a sigma of {:.6g}, beside the number stands {:.6g}",
                                                    number.published.name, sigma, number.sigma));
      }
    }
  }
  Uncertainty all;
  std::vector<std::size_t> places;
  std::vector<Eigen::Index> row_of(numbers_.size(), -1);
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    if (!uncertain[i]) continue;
    row_of[i] = static_cast<Eigen::Index>(all.numbers.size());
    all.numbers.push_back(numbers_[i].published);
    places.push_back(i);
    sigmas.push_back(numbers_[i].sigma);
  }
  if (all.numbers.empty()) return nullptr;
  all.covariance = independent(sigmas);
  for (std::size_t i = 0; i < listed.size(); ++i) {
    for (std::size_t k = 0; k < listed.size(); ++k) {
      all.covariance(row_of[listed[i]], row_of[listed[k]]) =
          of_listed(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
  }
  all.body_with = [blank = std::move(blank), parts = parts_, published = values_,
                   places = std::move(places)](const Eigen::VectorXd& values) {
    if (values.size() != static_cast<Eigen::Index>(places.size())) {
      throw InputError(fmt::format("{} values for {} uncertain numbers", values.size(), places.size()));
    }
    std::vector<double> numbers = published;
    for (std::size_t i = 0; i < places.size(); ++i) numbers[places[i]] = values[static_cast<Eigen::Index>(i)];
    Body clone = blank;
    for (const BodyPart& part : parts) part(numbers, clone);
    return clone;
  };
  return std::make_shared<const Uncertainty>(std::move(all));
}

}  // namespace polhode
