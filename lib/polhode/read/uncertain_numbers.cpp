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

/// Lets the principal axes of a clone point as those of the published body do: of each axis either end would serve.
void point_axes(Body& clone, const Matrix3& published) {
  if (!clone.inertia) return;
  Matrix3& axes = clone.inertia->named_from_principal;
  const Vector3 along = (axes.transpose() * published).diagonal();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (along[k] < 0.0) axes.col(k) = -axes.col(k);
  }
  if (axes.determinant() > 0.0) return;
  Eigen::Index least = 0;
  along.cwiseAbs().minCoeff(&least);
  axes.col(least) = -axes.col(least);
}

}  // namespace

Eigen::MatrixXd covariance_in_file(const TomlTable& root, std::span<const PublishedNumber> numbers,
                                   std::span<const double> sigmas, std::string_view which) {
  Eigen::MatrixXd covariance = independent(sigmas);
  if (!root.has("uncertainty")) return covariance;
  const TomlTable table = root.table("uncertainty");
  table.allow_only({"parameters", "covariance"});
  std::vector<std::size_t> listed;
  Uncertainty alone;  // of those that are listed
  for (const std::string& name : table.texts("parameters")) {
    const auto found = std::find_if(numbers.begin(), numbers.end(),
                                    [&](const PublishedNumber& number) { return number.name == name; });
    if (found == numbers.end()) {
      std::vector<std::string_view> names;
      for (const PublishedNumber& number : numbers) names.emplace_back(number.name);
      throw table.error("parameters", fmt::format("'{:.60}' is no {}; allowed are {}", name, which,
                                                  names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
    const auto i = static_cast<std::size_t>(found - numbers.begin());
    if (std::find(listed.begin(), listed.end(), i) != listed.end()) {
      throw table.error("parameters", fmt::format("'{:.60}' stands there twice", name));
    }
    listed.push_back(i);
    alone.numbers.push_back(*found);
  }
  if (listed.empty()) throw table.error("parameters", "found an empty list, names of parameters are wanted");
  const std::vector<std::vector<double>> rows = table.square("covariance", listed.size());
  const auto size = static_cast<Eigen::Index>(listed.size());
  alone.covariance.resize(size, size);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      alone.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
    }
  }
  table.located("covariance", [&] { alone.check(); });
  for (std::size_t i = 0; i < listed.size(); ++i) {
    const double sigma = alone.sigma(i), beside = sigmas[listed[i]];
    if (beside > 0.0 && std::abs(beside - sigma) > 0.01 * sigma) {
      throw table.error("covariance", fmt::format("of {} it gives a sigma of {:.6g}, beside the number stands {:.6g}",
                                                  alone.numbers[i].name, sigma, beside));
    }
  }
  covariance(listed, listed) = alone.covariance;
  return covariance;
}

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
    numbers_.push_back({std::move(name), values[i], {}});
    sigmas_.push_back(sigmas[i]);
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
      numbers_.push_back({fmt::format("{}.{}{}", key, "xyz"[i], "xyz"[k]), values(i, k), {}});
      sigmas_.push_back(checked_sigma(table, sigma, sigmas(i, k)));
      values_.push_back(values(i, k));
    }
  }
  return place;
}

void UncertainNumbers::set_changes(std::size_t place, std::vector<EpochChange> changes) {
  for (EpochChange& change : changes) numbers_[place++].change = std::move(change);
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
  for (PublishedNumber& number : numbers_) effect(number.change);
}

std::shared_ptr<const Uncertainty> UncertainNumbers::uncertainty(const TomlTable& root, Body blank) const {
  const Eigen::MatrixXd covariance = covariance_in_file(root, numbers_, sigmas_, "number of this file");
  Uncertainty all;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    if (!(covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) > 0.0)) continue;
    all.numbers.push_back(numbers_[i]);
    places.push_back(i);
  }
  if (all.numbers.empty()) return nullptr;
  all.covariance = covariance(places, places);
  Body published_body = blank;
  for (const BodyPart& part : parts_) part(values_, published_body);
  const Matrix3 axes = published_body.inertia ? published_body.inertia->named_from_principal : Matrix3::Identity();
  all.body_with = [blank = std::move(blank), parts = parts_, published = values_, places = std::move(places),
                   axes](const Eigen::VectorXd& values) {
    if (values.size() != static_cast<Eigen::Index>(places.size())) {
      throw InputError(fmt::format("{} values for {} uncertain numbers", values.size(), places.size()));
    }
    std::vector<double> numbers = published;
    for (std::size_t i = 0; i < places.size(); ++i) numbers[places[i]] = values[static_cast<Eigen::Index>(i)];
    Body clone = blank;
    for (const BodyPart& part : parts) {
      part(numbers, clone);
      point_axes(clone, axes);  // before the state is read, which may count from them
    }
    return clone;
  };
  return std::make_shared<const Uncertainty>(std::move(all));
}

}  // namespace polhode
