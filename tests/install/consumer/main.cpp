#include <cstdio>
#include <polhode/motion/free_body.hpp>
#include <polhode/motion/methods.hpp>
#include <polhode/read/body.hpp>

// Where does the long axis of a body point, one day after the epoch of its state?
int main(int, char** argv) {
  const polhode::Body body = polhode::read_body(argv[1]);
  const auto motion = polhode::method("auto").make(polhode::free_body(body, polhode::Frame::ecliptic_j2000));
  const polhode::State state = motion->at(86400.0);  // seconds from the epoch
  const polhode::Vector3 axis = state.q_inertial_from_body * polhode::Vector3::UnitX();
  std::printf("%+.6f %+.6f %+.6f\n", axis.x(), axis.y(), axis.z());
}
