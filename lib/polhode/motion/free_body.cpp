#include "polhode/motion/free_body.hpp"

#include "polhode/base/error.hpp"
#include "polhode/body/invariants.hpp"

namespace polhode {

FreeBody free_body(const Body& body, Frame inertial) {
  if (!body.missing.empty()) {
    std::string lacks;
    for (const std::string& what : body.missing) lacks += (lacks.empty() ? "" : ", and ") + what;
    throw InputError("body '" + body.name + "' cannot be propagated; it lacks " + lacks);
  }
  const Quaternion q_icrf_from_inertial = q_icrf_from(inertial);  // refuses a frame that turns
  FreeBody free;
  free.momentum_body = momentum_principal(body);
  if (!body.state->q_frame_from_named) throw InputError("body '" + body.name + "' has no attitude at its epoch");
  const Inertia& inertia = *body.inertia;
  free.named_from_principal = inertia.named_from_principal;
  free.principal_moments = inertia.principal_moments;
  const Quaternion q_frame_from_body = *body.state->q_frame_from_named * inertia.q_named_from_principal();
  free.q_inertial_from_body =
      inertial == body.state->frame
          ? q_frame_from_body
          : q_icrf_from_inertial.conjugate() * q_icrf_from(body.state->frame, body.state->epoch) * q_frame_from_body;
  return checked(free);
}

NamedState named_state(const FreeBody& body, const State& state) {
  const Matrix3& named_from_principal = body.named_from_principal;
  return {state.q_inertial_from_body * Quaternion(named_from_principal).normalized().conjugate(),
          named_from_principal * state.momentum_body.cwiseQuotient(body.principal_moments),
          named_from_principal * state.momentum_body};
}

}  // namespace polhode
