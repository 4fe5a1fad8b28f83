#include "python/python.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>

#include "polhode/base/error.hpp"
#include "polhode/read/quantity.hpp"

namespace polhode::python {
namespace {

nb::object numpy(const char* name) { return nb::module_::import_("numpy").attr(name); }

Numbers numbers_of_array(nb::object array) {
  Numbers numbers;
  const auto view = nb::cast<nb::ndarray<const double, nb::c_contig, nb::device::cpu>>(array);
  numbers.data = view.data();
  for (std::size_t i = 0; i < view.ndim(); ++i) numbers.shape.push_back(view.shape(i));
  numbers.array = std::move(array);
  return numbers;
}

/// TT seconds from J2000 of a Julian date in TT.
Seconds seconds_of_jd(double jd1, double jd2) {
  constexpr double j2000 = 2451545.0, day_s = 86400.0;
  const Seconds days = exact_sum(jd1 - j2000, 0.0);
  return exact_product(days.high, day_s) + exact_product(jd2, day_s);
}

/// Python's own exception where it is none, or too large.
double number_of(nb::handle object) {
  const double number = PyFloat_AsDouble(object.ptr());
  if (number == -1.0 && PyErr_Occurred() != nullptr) nb::raise_python_error();
  return number;
}

/// Whether it is an array of numpy's own type, no Quantity and not masked, of doubles in C's order: most are, and then
/// there is nothing more to ask, which takes microseconds.
bool is_plain(nb::handle object) {
  static PyObject* const type = numpy("ndarray").release().ptr();  // for ever
  nb::ndarray<const double, nb::c_contig, nb::device::cpu> view;
  return Py_TYPE(object.ptr()) == reinterpret_cast<PyTypeObject*>(type) && nb::try_cast(object, view, false);
}

bool is_time(nb::handle object) { return is_instance_of(object, "astropy.time", "Time"); }
bool is_quantity(nb::handle object) { return is_instance_of(object, "astropy.units", "Quantity"); }

/// The two parts of a Time or TimeDelta, in TT.
std::pair<Numbers, Numbers> julian_date(nb::handle time) {
  if (nb::cast<bool>(time.attr("masked")) && nb::cast<bool>(numpy("any")(time.attr("mask")))) {
    throw InputError("times are masked; times without a mask are wanted");
  }
  const nb::object tt = time.attr("tt");
  return {numbers_of(tt.attr("jd1")), numbers_of(tt.attr("jd2"))};
}

}  // namespace

std::size_t Numbers::size() const {
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  return count;
}

Vector3 Numbers::vector3(const char* what) const {
  if (shape != Shape{3})
    throw InputError(fmt::format("{} has the shape ({}), (3,) is wanted", what, fmt::join(shape, ", ")));
  return Vector3(data[0], data[1], data[2]);
}

Matrix3 Numbers::matrix3(const char* what) const {
  if (shape != Shape{3, 3})
    throw InputError(fmt::format("{} has the shape ({}), (3, 3) is wanted", what, fmt::join(shape, ", ")));
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data);
}

Numbers numbers_of(nb::handle object, const char* unit) {
  if (is_plain(object)) return numbers_of_array(nb::borrow(object));
  if (is_quantity(object)) {
    const auto given = nb::cast<std::string>(object.attr("unit").attr("to_string")());
    if (unit == nullptr && !given.empty()) {
      throw InputError(
          fmt::format("a Quantity in {} is given where plain numbers are wanted; the documentation says in "
                      "which unit, to_value() converts",
                      given));
    }
    return numbers_of(object.attr("to_value")(unit == nullptr ? "" : unit));
  }
  if (is_instance_of(object, "numpy.ma", "MaskedArray") &&
      nb::cast<bool>(nb::module_::import_("numpy.ma").attr("is_masked")(object))) {
    throw InputError("numbers are masked; numbers without a mask are wanted");
  }
  const nb::object array = numpy("asarray")(object);
  const auto kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
  if (kind == "M") {
    throw InputError("datetime64 has no time scale; a date as text with its scale is wanted, or a Time of astropy");
  }
  if (kind == "m" || kind == "c") {
    throw InputError(fmt::format("{} are given where plain numbers are wanted",
                                 kind == "m" ? "lengths of time (timedelta64)" : "complex numbers"));
  }
  return numbers_of_array(numpy("asarray")(array, "dtype"_a = "float64", "order"_a = "C"));
}

std::optional<Instant> instant_of(nb::handle object) {
  if (nb::isinstance<Instant>(object)) return nb::cast<Instant>(object);
  if (nb::isinstance<nb::str>(object)) return parse_date_with_scale(nb::cast<std::string>(object)).instant;
  if (!is_time(object)) return std::nullopt;
  const auto [jd1, jd2] = julian_date(object);
  if (jd1.size() != 1) throw InputError("one instant is wanted, not an array of them");
  return Instant::from_tt_j2000(seconds_of_jd(*jd1.data, *jd2.data));
}

std::vector<Instant> instants_of(nb::handle object) {
  std::vector<Instant> instants;
  if (const auto one = is_time(object) ? std::nullopt : instant_of(object)) return {*one};
  if (is_time(object)) {
    const auto [jd1, jd2] = julian_date(object);
    if (jd1.shape.size() > 1) throw InputError("an array of instants of one dimension is wanted");
    for (std::size_t i = 0; i < jd1.size(); ++i) {
      instants.push_back(Instant::from_tt_j2000(seconds_of_jd(jd1.data[i], jd2.data[i])));
    }
    return instants;
  }
  for (const nb::handle item : nb::iter(object)) {
    const auto instant = instant_of(item);
    if (!instant) throw nb::type_error("a list of Instants or of dates, or an astropy Time, is wanted");
    instants.push_back(*instant);
  }
  return instants;
}

Elapsed elapsed_of(nb::handle times, const std::optional<Instant>& epoch) {
  Elapsed elapsed;
  const auto from_epoch = [&](const Instant& instant) {
    if (!epoch) throw InputError("this motion has no epoch: times are seconds, from where it was started");
    return instant - *epoch;
  };
  const auto scalar = [&](Seconds seconds) {
    elapsed.scalar = true;
    elapsed.high_s = seconds.high;
    elapsed.low_s = seconds.low;
    return elapsed;
  };
  const auto numbers = [&](Numbers values) {
    if (values.shape.empty()) return scalar({*values.data, 0.0});
    elapsed.high = std::move(values);
    return elapsed;
  };
  const auto pairs = [&](std::span<const Seconds> seconds, const Shape& shape) {
    auto [array, high] = new_array(shape);
    elapsed.low.resize(seconds.size());
    for (std::size_t i = 0; i < seconds.size(); ++i) {
      high[i] = seconds[i].high;
      elapsed.low[i] = seconds[i].low;
    }
    elapsed.high = {std::move(array), high, shape};
    return elapsed;
  };
  if (PyFloat_Check(times.ptr()) || PyLong_Check(times.ptr())) return scalar({number_of(times), 0.0});
  if (is_plain(times)) return numbers(numbers_of(times));
  if (is_instance_of(times, "datetime", "timedelta")) return scalar({number_of(times.attr("total_seconds")()), 0.0});
  if (is_instance_of(times, "datetime", "date")) {
    throw InputError("a datetime has no time scale; a date as text with its scale is wanted, or a Time of astropy");
  }
  if (is_time(times)) {
    const auto [jd1, jd2] = julian_date(times);
    std::vector<Seconds> seconds;
    for (std::size_t i = 0; i < jd1.size(); ++i) {
      seconds.push_back(from_epoch(Instant::from_tt_j2000(seconds_of_jd(jd1.data[i], jd2.data[i]))));
    }
    if (jd1.shape.empty()) return scalar(seconds.front());
    return pairs(seconds, jd1.shape);
  }
  if (const auto instant = instant_of(times)) return scalar(from_epoch(*instant));
  if (is_instance_of(times, "astropy.time", "TimeDelta") || is_quantity(times)) {
    return numbers(numbers_of(times.attr("to_value")("s")));
  }
  if (nb::isinstance<nb::list>(times) || nb::isinstance<nb::tuple>(times)) {
    const nb::sequence list = nb::borrow<nb::sequence>(times);
    if (nb::len(list) > 0 && instant_of(list[0])) {
      std::vector<Seconds> seconds;
      for (const Instant& instant : instants_of(times)) seconds.push_back(from_epoch(instant));
      return pairs(seconds, {seconds.size()});
    }
  }
  const nb::object array = numpy("asarray")(times);
  if (nb::cast<std::string>(array.attr("dtype").attr("kind")) == "m") {
    return numbers(numbers_of(array.attr("__truediv__")(numpy("timedelta64")(1, "s"))));
  }
  return numbers(numbers_of(times));
}

std::pair<nb::object, double*> new_array(std::span<const std::size_t> shape) {
  static PyObject* const empty = numpy("empty").release().ptr();  // for ever
  nb::object size = nb::steal(PyTuple_New(static_cast<Py_ssize_t>(shape.size())));
  for (std::size_t i = 0; i < shape.size(); ++i) {
    PyTuple_SetItem(size.ptr(), static_cast<Py_ssize_t>(i), PyLong_FromSize_t(shape[i]));
  }
  nb::object array = nb::steal(PyObject_CallFunctionObjArgs(empty, size.ptr(), nullptr));
  if (!array.is_valid()) nb::raise_python_error();
  double* const data = nb::cast<nb::ndarray<double, nb::c_contig, nb::device::cpu>>(array).data();
  return {std::move(array), data};
}

FloatArray array_of(std::span<const std::size_t> shape, const double* data) {
  auto [array, to] = new_array(shape);
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  if (count != 0) std::memcpy(to, data, count * sizeof(double));
  return {std::move(array)};
}

FloatArray array_of(const Vector3& v) { return array_of(Shape{3}, v.data()); }

FloatArray array_of(const Matrix3& m) {
  const Matrix3 rows = m.transpose();  // Eigen has columns one after the other
  return array_of(Shape{3, 3}, rows.data());
}

FloatArray array_of(const Quaternion& q) {
  const Eigen::Vector4d values = scalar_first(q);
  return array_of(Shape{4}, values.data());
}

nb::object imported(const char* module) {
  const nb::dict modules = nb::cast<nb::dict>(nb::module_::import_("sys").attr("modules"));
  return modules.contains(module) ? nb::object(modules[module]) : nb::object();
}

bool is_instance_of(nb::handle object, const char* module, const char* type) {
  const nb::object found = imported(module);
  return found.is_valid() && nb::isinstance(object, found.attr(type));
}

nb::object from_json(const std::string& text) { return nb::module_::import_("json").attr("loads")(text); }

namespace {

Attitudes attitudes_of(nb::handle object) {
  if (!is_instance_of(object, "scipy.spatial.transform", "Rotation")) return {numbers_of(object)};
  return {numbers_of(numpy("roll")(object.attr("as_quat")(), 1, "axis"_a = -1))};  // scalar first
}

Attitude attitude_of(nb::handle object) {
  const Attitudes q = attitudes_of(object);
  if (q.shape != Shape{4}) {
    throw InputError(
        fmt::format("an attitude has the shape ({}), (4,) is wanted: scalar first", fmt::join(q.shape, ", ")));
  }
  return {Quaternion(q.data[0], q.data[1], q.data[2], q.data[3])};
}

}  // namespace

Numbers kind_of(nb::handle object, Numbers* /*unused*/) { return numbers_of(object); }

Rates kind_of(nb::handle object, Rates* /*unused*/) { return {numbers_of(object, "rad/s")}; }

Angles kind_of(nb::handle object, Angles* /*unused*/) { return {numbers_of(object, "rad")}; }

Attitudes kind_of(nb::handle object, Attitudes* /*unused*/) { return attitudes_of(object); }

Attitude kind_of(nb::handle object, Attitude* /*unused*/) { return attitude_of(object); }

When kind_of(nb::handle object, When* /*unused*/) {
  const auto instant = instant_of(object);
  if (!instant) throw nb::type_error("an Instant, a date with its scale, or an astropy Time is wanted");
  return {*instant};
}

Duration kind_of(nb::handle object, Duration* /*unused*/) {
  if (nb::isinstance<nb::str>(object)) return {parse_duration(nb::cast<std::string>(object))};
  const Elapsed elapsed = elapsed_of(object, {});
  if (!elapsed.scalar) throw InputError("one length of time is wanted");
  return {{elapsed.high_s, elapsed.low_s}};
}

PlaneAngle kind_of(nb::handle object, PlaneAngle* /*unused*/) {
  if (nb::isinstance<nb::str>(object)) return {parse_angle_rad(nb::cast<std::string>(object))};
  return {number_of(is_quantity(object) ? object.attr("to_value")("rad") : nb::borrow(object))};
}

FileName kind_of(nb::handle object, FileName* /*unused*/) {
  const nb::object path = nb::module_::import_("os").attr("fspath")(object);
  if (!nb::isinstance<nb::str>(path)) throw nb::type_error("a file's name is text or a Path");
  return {nb::cast<std::string>(path)};
}

}  // namespace polhode::python
