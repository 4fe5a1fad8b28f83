// Includes from, links with and calls the installed library: a motion of its own, at rest, through the default batch.
#include <cstdio>

#include "polhode/motion/motion.hpp"

class AtRest : public polhode::FreeMotion {
 public:
  polhode::FreeState at(double, double) const override {
    return {polhode::Quaternion::Identity(), polhode::Vector3::Zero()};
  }
};

int main() {
  const double times_s[] = {0.0, 1.0};
  double q[8] = {};
  AtRest().batch({times_s}, polhode::StateArrays::of_structures(q, nullptr));
  std::printf("%g %g\n", q[0], q[4]);
  return q[0] == 1.0 && q[4] == 1.0 ? 0 : 1;
}
