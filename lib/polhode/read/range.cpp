#include "polhode/read/range.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

bool in_range(double value) { return kLeastRead <= value && value <= kGreatestRead; }

}  // namespace

void check_range(const Inertia& inertia) {
  const Vector3& I = inertia.principal_moments;
  if (in_range(I[0]) && in_range(I[2])) return;
  throw InputError(
      fmt::format("the principal moments are {:.6g}, {:.6g}, {:.6g}{}; those from {:g} to {:g} can be read", I[0], I[1],
                  I[2], inertia.absolute ? " kg m2" : "", kLeastRead, kGreatestRead));
}

void check_range_of_rate(const Vector3& omega_rad_s) {
  const double rate = omega_rad_s.stableNorm();
  if (rate == 0.0 || in_range(rate)) return;
  throw InputError(fmt::format("the angular velocity is {:.6g} rad/s; 0, and {:g} to {:g} rad/s, can be read", rate,
                               kLeastRead, kGreatestRead));
}

void check_range(const Body& body) {
  if (body.inertia) check_range(*body.inertia);
  if (body.state && body.state->omega_named_rad_s) check_range_of_rate(*body.state->omega_named_rad_s);
  for (const StatedAttitude& attitude : body.attitudes) {
    if (attitude.omega_body_rad_s) check_range_of_rate(*attitude.omega_body_rad_s);
  }
}

}  // namespace polhode
