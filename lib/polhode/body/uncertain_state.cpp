#include "polhode/body/uncertain_state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/units.hpp"

namespace polhode {

void set_state_uncertainty(Body& body, const StateSigmas& sigmas) {
  if (!body.state || !body.state->q_frame_from_named) throw InputError("an uncertain turn needs an attitude");
  Uncertainty uncertainty;
  std::vector<double> each;
  const auto add = [&](const char* name, int k, const EpochChange& change, double sigma) {
    uncertainty.numbers.push_back({fmt::format("{}.{}", name, "xyz"[k]), 0.0, change});
    each.push_back(sigma);
  };
  const bool has_rate = sigmas.rate_deg_s && body.state->omega_named_rad_s;
  const Matrix3 axes = degree * sigmas.named_from_axes;
  for (int k = 0; k < 3; ++k) {
    EpochChange change;
    change.turn_rad = axes.col(k);
    add("turn", k, change, sigmas.turn_deg[k]);
  }
  for (int k = 0; k < 3 && has_rate; ++k) {
    EpochChange change;
    change.omega_rad_s = axes.col(k);
    add("rate", k, change, (*sigmas.rate_deg_s)[k]);
  }
  uncertainty.covariance = independent(each);
  uncertainty.check();
  Body exact = body;
  exact.uncertainty.reset();
  uncertainty.body_with = [exact = std::move(exact), axes, has_rate](const Eigen::VectorXd& values) {
    if (values.size() != (has_rate ? 6 : 3)) throw InputError("three values of turns, and of rates, are wanted");
    Body clone = exact;
    const Vector3 turn = axes * values.head<3>();
    const double half = 0.5 * turn.norm();
    Quaternion q(std::cos(half), 0.0, 0.0, 0.0);
    if (half > 0.0) q.vec() = std::sin(half) / (2.0 * half) * turn;
    clone.state->q_frame_from_named = (*clone.state->q_frame_from_named * q).normalized();
    if (has_rate) *clone.state->omega_named_rad_s += axes * values.tail<3>();
    return clone;
  };
  body.uncertainty = std::make_shared<const Uncertainty>(std::move(uncertainty));
}

}  // namespace polhode
