#include <cstdio>
#include <polhode/motion/free_body.hpp>
#include <polhode/motion/partials.hpp>
#include <polhode/read/body.hpp>

// By how much does an error of one part in a thousand in I3 turn a body within ten days?
int main(int, char** argv) {
  const polhode::FreeBody body = polhode::free_body(polhode::read_body(argv[1]));
  const polhode::FreePartials motion(body);
  const polhode::StatePartials s = motion.at(10.0 * 86400.0);
  const double turn_rad = 1e-3 * body.principal_moments[2] * s.partials.block<3, 1>(0, 8).norm();
  std::printf("%.5f rad\n", turn_rad);
}
