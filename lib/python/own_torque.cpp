#include "python/own_torque.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <string>

#include "polhode/base/error.hpp"

namespace polhode::python {
namespace {

constexpr std::size_t kCallsBetweenSignals = 1u << 16;
constexpr const char* kSignature =
    "void f(double t_s, const double *q, const double *omega, const double *position_m, double *torque)";

[[noreturn]] void throw_wrong_signature(const std::string& found) {
  throw InputError(fmt::format("a compiled torque has the signature {}, {} is wanted", found, kSignature));
}

void release(nb::object& object) {
  if (!nb::is_alive()) {  // the interpreter has gone
    object.release();
    return;
  }
  const nb::gil_scoped_acquire lock;
  object.reset();
}

std::string text_of(const nb::object& object) { return nb::cast<std::string>(nb::str(object)); }

/// Of a ctypes function pointer, whose argument types must have been said.
std::uintptr_t address_of_ctypes(const nb::object& function) {
  const nb::module_ ctypes = nb::module_::import_("ctypes");
  const nb::object pointer = ctypes.attr("POINTER")(ctypes.attr("c_double"));
  const nb::object wanted = nb::make_tuple(ctypes.attr("c_double"), pointer, pointer, pointer, pointer);
  const nb::object types = function.attr("argtypes");
  if (types.is_none() || !nb::tuple(types).equal(wanted) || !function.attr("restype").is_none()) {
    throw_wrong_signature(fmt::format("restype {}, argtypes {}", text_of(function.attr("restype")), text_of(types)));
  }
  return nb::cast<std::uintptr_t>(ctypes.attr("cast")(function, ctypes.attr("c_void_p")).attr("value"));
}

/// Of a numba cfunc: its signature, if it says it.
std::uintptr_t address_of_numba(const nb::object& function) {
  const nb::object signature = nb::getattr(function, "_sig", nb::none());
  if (!signature.is_none()) {
    const std::string found = text_of(signature);
    if (found != "(float64, float64*, float64*, float64*, float64*) -> none") throw_wrong_signature(found);
  }
  return nb::cast<std::uintptr_t>(function.attr("address"));
}

/// Of a LowLevelCallable of scipy: its first element is a capsule that is named by the signature.
std::uintptr_t address_of_capsule(const nb::object& callable) {
  const nb::object capsule = nb::borrow(PyTuple_GetItem(callable.ptr(), 0));  // its own [] refuses
  const char* name = PyCapsule_GetName(capsule.ptr());
  std::string signature = name == nullptr ? "" : name;
  std::erase(signature, ' ');
  if (signature != "void(double,double*,double*,double*,double*)")
    throw_wrong_signature(name == nullptr ? "none" : name);
  void* pointer = PyCapsule_GetPointer(capsule.ptr(), name);
  if (pointer == nullptr) nb::raise_python_error();
  return reinterpret_cast<std::uintptr_t>(pointer);
}

std::uintptr_t address_of(const nb::object& function) {
  if (nb::isinstance<nb::int_>(function)) return nb::cast<std::uintptr_t>(function);
  if (nb::hasattr(function, "argtypes")) return address_of_ctypes(function);
  if (nb::hasattr(function, "address")) return address_of_numba(function);
  if (is_instance_of(function, "scipy", "LowLevelCallable")) return address_of_capsule(function);
  throw InputError(
      fmt::format("a compiled torque is a numba cfunc, a ctypes function pointer, a LowLevelCallable of scipy or an "
                  "address, found {}; Torque.function takes functions of Python",
                  text_of(nb::object(function.type().attr("__name__")))));
}

}  // namespace

DescribedTorque::DescribedTorque(bool kinks, std::optional<double> largest) : kinks_(kinks), largest_(largest) {
  if (largest && !(*largest >= 0.0)) {
    throw InputError(fmt::format("the largest torque is {}, a number of 0 or more is wanted", *largest));
  }
}

PythonTorque::~PythonTorque() { release(function_); }

Vector3 PythonTorque::torque(const TorqueQuestion& at) const {
  const nb::gil_scoped_acquire lock;
  const FloatArray q = array_of(at.q_inertial_from_body), omega = array_of(at.omega_rad_s);
  const nb::object answer =
      with_orbit_ ? function_(at.t_s, q, omega, array_of(Vector3(at.orbit->position_m))) : function_(at.t_s, q, omega);
  const Numbers numbers = numbers_of(answer);
  if (numbers.shape != Shape{3}) {
    throw InputError(fmt::format("the function of a torque gave an array of the shape ({}), (3,) is wanted",
                                 fmt::join(numbers.shape, ", ")));
  }
  return Vector3(numbers.data);
}

CompiledTorque::CompiledTorque(nb::object function, bool kinks, std::optional<double> largest)
    : DescribedTorque(kinks, largest),
      kept_(std::move(function)),
      function_(reinterpret_cast<Function>(address_of(kept_))) {  // NOLINT(performance-no-int-to-ptr)
  if (function_ == nullptr) throw InputError("the address of a compiled torque is 0");
}

CompiledTorque::~CompiledTorque() { release(kept_); }

Vector3 CompiledTorque::torque(const TorqueQuestion& at) const {
  if (calls_.fetch_add(1, std::memory_order_relaxed) % kCallsBetweenSignals == kCallsBetweenSignals - 1) {
    const nb::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
  }
  const Eigen::Vector4d q = scalar_first(at.q_inertial_from_body);
  Vector3 torque = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
  function_(at.t_s, q.data(), at.omega_rad_s.data(), at.orbit == nullptr ? nullptr : at.orbit->position_m.data(),
            torque.data());
  return torque;
}

}  // namespace polhode::python
