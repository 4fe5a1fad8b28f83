#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "python/objects.hpp"

namespace polhode::python {

std::size_t count_of(std::span<const std::size_t> shape);

/// What numpy's rules make of two shapes. Throws InputError where they do not go together.
Shape broadcast(const Shape& a, const Shape& b, const char* what);

/// Strides, in elements, of an array of this shape that is broadcast to `whole`: 0 along the axes that it has not.
std::vector<std::ptrdiff_t> strides_in(const Shape& whole, const Shape& shape);

/// The leading axes of shape + (last,); `last` must be right.
Shape leading(const Numbers& numbers, std::size_t last, const char* what);

/// The state of one body at one time, and of all bodies at all times, written to `out` if that is not None.
StateObject state_at_time(const std::shared_ptr<const MotionObject>& self, double high_s, double low_s);
StateObject states_at(const std::shared_ptr<const MotionObject>& self, const nb::object& t, const nb::object& out,
                      unsigned threads);

void bind_state(nb::module_& m);

}  // namespace polhode::python
