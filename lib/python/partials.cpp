#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "python/objects.hpp"

namespace polhode::python {
namespace {

/// Made when they are first asked for.
const StatePartialsSource& state_partials_in(const MotionObject& self) {
  if (!self.shape.empty()) throw InputError("the motion of one body is wanted");
  const nb::gil_scoped_release others_go_on;
  MotionObject::StatePartialsOnce& once = *self.state_partials;
  std::call_once(once.made, [&] { once.partials = state_partials_of(*self.motions.front(), self.bodies.front()); });
  return once.partials;
}

}  // namespace

std::vector<std::string> partial_columns_of(const MotionObject& self) { return state_partials_in(self).parameters; }

FloatArray partials_of(const MotionObject& self, const nb::object& t, unsigned threads) {
  const StatePartialsSource& source = state_partials_in(self);
  const Elapsed times = elapsed_of(t, self.epoch());
  Shape shape = times.scalar ? Shape{} : times.high.shape;
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  const TimeArrays instants{times.scalar ? std::span(&times.high_s, 1) : std::span(times.high.data, count),
                            times.scalar ? std::span(&times.low_s, 1) : std::span(times.low)};
  const std::size_t each = 6 * source.parameters.size();
  shape.insert(shape.end(), {6, source.parameters.size()});
  auto [array, matrices] = new_array(shape);
  const nb::gil_scoped_release others_go_on;
  constexpr std::size_t grain = 512;  // batches work in blocks of a divisor of this
  parallel_chunks(count, grain, threads, [&, to = matrices](std::size_t begin, std::size_t end) {
    source.batch(part_of(instants, begin, end), {to + each * begin, each * (end - begin)});
  });
  return {array};
}

}  // namespace polhode::python
