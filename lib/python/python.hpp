#pragma once

// What the sources of the extension module share: numbers, dates and texts in, arrays out.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/time/scale.hpp"

namespace polhode::python {

namespace nb = nanobind;
using namespace nb::literals;

using Shape = std::vector<std::size_t>;

/// An argument: whatever numpy makes an array of float64 of; an array of them is taken as it is.
struct Numbers {
  nb::object array;
  const double* data = nullptr;
  Shape shape;

  std::size_t size() const;
  /// Throw InputError "`what` has the shape …, … is wanted".
  Vector3 vector3(const char* what) const;
  Matrix3 matrix3(const char* what) const;
};

/// The same in rad/s, and in rad: a Quantity of astropy is converted.
struct Rates : Numbers {};
struct Angles : Numbers {};

/// Quaternions (..., 4), scalar first: numbers, or a Rotation of scipy, of one or more.
struct Attitudes : Numbers {};

/// An argument: unit quaternion, scalar first, or a Rotation of scipy.
struct Attitude {
  Quaternion q;
};

/// An argument: an instant, a date with its scale, or a Time of astropy.
struct When {
  Instant instant;
};

/// A length of time in seconds: a number, a text with its unit, or a Quantity of astropy.
struct Duration {
  Seconds seconds;
};

/// An angle in radians, likewise.
struct PlaneAngle {
  double rad = 0.0;
};

/// A file's name: text or a Path.
struct FileName {
  std::string path;
};

/// An argument of one of these kinds. What was given is looked at when it is asked for: there InputError may be thrown.
template <class Kind>
class Given {
 public:
  nb::object object;

  const Kind& operator*() const {
    if (!kind_) kind_ = kind_of(object, static_cast<Kind*>(nullptr));
    return *kind_;
  }
  const Kind* operator->() const { return &**this; }

 private:
  mutable std::optional<Kind> kind_;
};

Numbers kind_of(nb::handle object, Numbers*);
Rates kind_of(nb::handle object, Rates*);
Angles kind_of(nb::handle object, Angles*);
Attitudes kind_of(nb::handle object, Attitudes*);
Attitude kind_of(nb::handle object, Attitude*);
When kind_of(nb::handle object, When*);
Duration kind_of(nb::handle object, Duration*);
PlaneAngle kind_of(nb::handle object, PlaneAngle*);
FileName kind_of(nb::handle object, FileName*);

/// Throws InputError for what would lose its meaning as plain numbers: a Quantity (unless `unit` says of what unit
/// numbers are wanted), dates, complex numbers, masked elements.
Numbers numbers_of(nb::handle object, const char* unit = nullptr);
std::optional<Instant> instant_of(nb::handle object);  ///< nothing: it is none
std::vector<Instant> instants_of(nb::handle object);   ///< of a list or of an astropy Time of one dimension

/// Times as a motion is asked for: seconds from `epoch`, as TT counts them, in two parts.
struct Elapsed {
  bool scalar = false;
  double high_s = 0.0, low_s = 0.0;  ///< of a scalar
  Numbers high;                      ///< else
  std::vector<double> low;           ///< empty, or as long as `high`
};
Elapsed elapsed_of(nb::handle times, const std::optional<Instant>& epoch);

/// A new array of float64 with this shape, and where its numbers are.
std::pair<nb::object, double*> new_array(std::span<const std::size_t> shape);
struct FloatArray {
  nb::object array;
};  ///< a result: such an array
FloatArray array_of(std::span<const std::size_t> shape, const double* data);
FloatArray array_of(const Vector3& v);
FloatArray array_of(const Matrix3& m);
FloatArray array_of(const Quaternion& q);  ///< scalar first

/// The module of that name if it has been imported, else null: an object of it cannot have been made before.
nb::object imported(const char* module);
bool is_instance_of(nb::handle object, const char* module, const char* type);

/// Of JSON, as Python's own objects.
nb::object from_json(const std::string& text);

void bind_time(nb::module_& m);
void bind_body(nb::module_& m);
void bind_torque(nb::module_& m);
void bind_motion(nb::module_& m);
void bind_ephemeris(nb::module_& m);
void bind_history(nb::module_& m);
void bind_uncertainty(nb::module_& m);
void bind_pickling(nb::module_& m);

}  // namespace polhode::python

namespace nanobind::detail {

// What such an argument is called in signatures.
#define POLHODE_ARGUMENT(Kind, Text)                                                \
  template <>                                                                       \
  struct type_caster<polhode::python::Given<polhode::python::Kind>> {               \
    NB_TYPE_CASTER(polhode::python::Given<polhode::python::Kind>, const_name(Text)) \
    bool from_python(handle src, uint32_t, cleanup_list*) noexcept {                \
      value.object = borrow(src);                                                   \
      return !src.is_none();                                                        \
    }                                                                               \
  }

POLHODE_ARGUMENT(Numbers, "numpy.typing.ArrayLike");
POLHODE_ARGUMENT(Rates, "numpy.typing.ArrayLike | astropy.units.Quantity");
POLHODE_ARGUMENT(Angles, "numpy.typing.ArrayLike | astropy.units.Quantity");
POLHODE_ARGUMENT(Attitudes, "numpy.typing.ArrayLike | scipy.spatial.transform.Rotation");
POLHODE_ARGUMENT(Attitude, "numpy.typing.ArrayLike | scipy.spatial.transform.Rotation");
POLHODE_ARGUMENT(When, "Instant | str | astropy.time.Time");
POLHODE_ARGUMENT(Duration, "float | str | astropy.units.Quantity");
POLHODE_ARGUMENT(PlaneAngle, "float | str | astropy.units.Quantity");
POLHODE_ARGUMENT(FileName, "str | os.PathLike[str]");
#undef POLHODE_ARGUMENT

template <>
struct type_caster<polhode::python::FloatArray> {
  NB_TYPE_CASTER(polhode::python::FloatArray, const_name("numpy.typing.NDArray[numpy.float64]"))
  static handle from_cpp(const polhode::python::FloatArray& array, rv_policy, cleanup_list*) {
    return array.array.inc_ref();
  }
};

}  // namespace nanobind::detail
