#include "polhode/motion/partials.hpp"

#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

/// Also where a plan found that no torque counts.
bool is_free(const MotionObject& self) {
  return self.method != nullptr || dynamic_cast<const ThetaMotion*>(self.motions.front().get()) != nullptr;
}

const TorquedMotion& torqued_motion_in(const MotionObject& self) {
  const auto* torqued = dynamic_cast<const TorquedMotion*>(self.motions.front().get());
  if (torqued != nullptr) return *torqued;
  throw InputError("this motion was computed by few kicks, which have no partial derivatives: full=True has them");
}

/// Made when it is first asked for.
const TorquedPartials& torqued_partials_of(const MotionObject& self) {
  const TorquedMotion& motion = torqued_motion_in(self);
  MotionObject::TorquedPartialsOnce& once = *self.torqued_partials;
  std::call_once(once.made, [&] { once.partials = std::make_shared<const TorquedPartials>(motion); });
  return *once.partials;
}

}  // namespace

std::vector<std::string> partial_columns_of(const MotionObject& self) {
  if (!self.shape.empty()) throw InputError("the motion of one body is wanted");
  if (!is_free(self)) {
    const nb::gil_scoped_release others_go_on;
    return torqued_partials_of(self).columns();
  }
  return {"theta0_x", "theta0_y", "theta0_z", "m0_x", "m0_y", "m0_z", "I1", "I2", "I3"};
}

FloatArray partials_of(const MotionObject& self, const nb::object& t, unsigned threads) {
  if (!self.shape.empty()) throw InputError("the motion of one body is wanted");
  constexpr std::size_t kMatrix = PartialsMatrix::SizeAtCompileTime;
  const Elapsed times = elapsed_of(t, self.epoch());
  Shape shape = times.scalar ? Shape{} : times.high.shape;
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  const std::span<const double> high = times.scalar ? std::span(&times.high_s, 1) : std::span(times.high.data, count);
  const std::span<const double> low = times.scalar ? std::span(&times.low_s, 1) : std::span(times.low);
  const std::size_t columns = partial_columns_of(self).size();
  shape.insert(shape.end(), {6, columns});
  auto [array, matrices] = new_array(shape);
  if (!is_free(self)) {
    const nb::gil_scoped_release others_go_on;
    torqued_partials_of(self).batch({high, low}, {matrices, 6 * columns * count});
  } else {
    const nb::gil_scoped_release others_go_on;
    const FreePartials partials(self.bodies.front());
    std::vector<double> q(4 * count), m(3 * count);
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
