#include <algorithm>
#include <cmath>
#include <cstdio>
#include <polhode/motion/free_body.hpp>
#include <polhode/motion/methods.hpp>
#include <polhode/read/body.hpp>
#include <vector>

// The attitude of a body in every minute of a year, by both exact methods: how far do they differ?
int main(int, char** argv) {
  const polhode::FreeBody body = polhode::free_body(polhode::read_body(argv[1]));
  const std::size_t count = 366 * 1440;
  std::vector<double> t(count), theta(4 * count), legendre(4 * count), momentum(3 * count);
  for (std::size_t i = 0; i < count; ++i) t[i] = 60.0 * static_cast<double>(i);  // seconds from the epoch

  const auto states = [&](const char* method, std::vector<double>& q) {
    const auto motion = polhode::method(method).make(body);
    motion->batch({t}, polhode::StateArrays::of_structures(q.data(), momentum.data()));
  };
  states("theta", theta);
  states("legendre", legendre);

  double largest = 0.0;  // both have the sign that follows the motion, so that components may be compared
  for (std::size_t i = 0; i < 4 * count; ++i) largest = std::max(largest, std::abs(theta[i] - legendre[i]));
  std::printf("%zu instants, components of q within 1e-14: %s\n", count, largest < 1e-14 ? "yes" : "no");
}
