#include <cmath>
#include <cstdio>
#include <memory>
#include <polhode/motion/free_body.hpp>
#include <polhode/motion/torqued_motion.hpp>
#include <polhode/read/body.hpp>

// A brake about the second of the named axes, switched on softly after an hour.
class Brake final : public polhode::TorqueFunction {
 public:
  polhode::Vector3 torque(const polhode::TorqueQuestion& at) const override {
    const double on = 0.5 + 0.5 * std::tanh((at.t_s - 3600.0) / 60.0);
    return {0.0, -30.0 * on * at.omega_rad_s.y(), 0.0};  // N m, named axes
  }
  bool has_kinks() const override { return false; }
};

// Where does the third axis of the body point after two hours?
int main(int, char** argv) {
  const polhode::FreeBody body = polhode::free_body(polhode::read_body(argv[1]), polhode::Frame::eme2000);
  const polhode::Torques torques({polhode::OwnTorque(std::make_shared<Brake>())});
  const polhode::TorquedMotion motion(body, torques, {.tolerance_rad = 1e-8, .last_s = 7200.0});
  const polhode::State state = motion.at(7200.0);
  const polhode::Vector3 third = body.named_from_principal.transpose() * polhode::Vector3::UnitZ();  // principal axes
  const polhode::Vector3 to = state.q_inertial_from_body * third;
  std::printf("%+.6f %+.6f %+.6f, %s\n", to.x(), to.y(), to.z(),
              motion.error_rad() < 1e-8 ? "good to 1e-8 rad" : "not good enough");
}
