#include "polhode/motion/partials.hpp"

#include <vector>

#include "polhode/base/error.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

constexpr std::size_t kMatrix = 54;

/// The same derivatives in the axes that the body's file names: turns and momenta at both times are turned.
void into_named_axes(const Matrix3& named_from_principal, double* matrix) {
  Eigen::Map<PartialsMatrix> J(matrix);
  for (int row = 0; row < 6; row += 3) {
    for (int column = 0; column < 9; column += 3) {
      const Matrix3 block = named_from_principal * J.block<3, 3>(row, column);
      J.block<3, 3>(row, column) = column < 6 ? Matrix3(block * named_from_principal.transpose()) : block;
    }
  }
}

}  // namespace

FloatArray partials_of(const MotionObject& self, const nb::object& t, unsigned threads) {
  if (self.method == nullptr || !self.shape.empty()) throw InputError("the free motion of one body is wanted");
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
    if (self.named) {
      for (std::size_t i = 0; i < count; ++i) into_named_axes(self.named->named_from_principal, matrices + kMatrix * i);
    }
  }
  return {array};
}

}  // namespace polhode::python
