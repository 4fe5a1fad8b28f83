#include "polhode/motion/partials.hpp"

#include <vector>

#include "polhode/base/error.hpp"
#include "python/objects.hpp"

namespace polhode::python {
FloatArray partials_of(const MotionObject& self, const nb::object& t, unsigned threads) {
  if (self.method == nullptr || !self.shape.empty()) throw InputError("the free motion of one body is wanted");
  constexpr std::size_t kMatrix = PartialsMatrix::SizeAtCompileTime;
  const Elapsed times = elapsed_of(t, self.epoch());
  Shape shape = times.scalar ? Shape{} : times.high.shape;
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  shape.insert(shape.end(), {6, 9});
  auto [array, matrices] = new_array(shape);
  {
    const nb::gil_scoped_release others_go_on;
    const FreePartials partials(self.bodies.front());
    std::vector<double> q(4 * count), m(3 * count);
    const std::span<const double> high = times.scalar ? std::span(&times.high_s, 1) : std::span(times.high.data, count);
    const std::span<const double> low = times.scalar ? std::span(&times.low_s, 1) : std::span(times.low);
    batch_threads(partials, {high, low}, StateArrays::of_structures(q.data(), m.data()), {matrices, kMatrix * count},
                  threads);
    for (std::size_t i = 0; self.named && i < count; ++i) {
      Eigen::Map<PartialsMatrix> matrix(matrices + kMatrix * i);
      matrix = named_partials(self.bodies.front(), matrix);
    }
  }
  return {array};
}

}  // namespace polhode::python
