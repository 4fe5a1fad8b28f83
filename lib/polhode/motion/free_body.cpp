#include "polhode/motion/free_body.hpp"

#include "polhode/base/error.hpp"

namespace polhode {

FreeBody free_body(const Body& body, Frame inertial) {
  const auto missing = [&](const char* what) { return InputError("body '" + body.name + "' has no " + what); };
  if (!body.missing.empty()) {
    std::string lacks;
    for (const std::string& what : body.missing) lacks += (lacks.empty() ? "" : ", and ") + what;
    throw InputError("body '" + body.name + "' cannot be propagated; it lacks " + lacks);
  }
  if (!body.inertia) throw missing("inertia: motion needs it");
  if (!body.state) throw missing("state: motion needs an attitude and a rate at an epoch");
  if (!body.state->q_frame_from_named) throw missing("attitude at its epoch");
  if (!body.state->omega_named_rad_s) throw missing("angular velocity or momentum at its epoch");
  const Inertia& inertia = *body.inertia;
  FreeBody free;
  free.principal_moments = inertia.principal_moments;
  const Quaternion q_frame_from_body = *body.state->q_frame_from_named * inertia.q_named_from_principal();
  free.q_inertial_from_body = inertial == body.state->frame ? q_frame_from_body
                                                            : q_icrf_from(inertial).conjugate() *
                                                                  q_icrf_from(body.state->frame) * q_frame_from_body;
  const Vector3 omega_rad_s = inertia.named_from_principal.transpose() * *body.state->omega_named_rad_s;
  free.momentum_body = inertia.principal_moments.cwiseProduct(omega_rad_s);
  return free;
}

}  // namespace polhode
