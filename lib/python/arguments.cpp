// What is said of calls with wrong arguments. nanobind lists every signature and type; _errors.py finds what is wrong.
#include <array>
#include <utility>

#include "python/python.hpp"

namespace polhode::python {
namespace {

/// As nanobind calls its functions. Its own calls, of which there are a few kinds, stand here when these are in their
/// place.
constexpr std::size_t kKinds = 8;
std::array<vectorcallfunc, kKinds> own_calls{};

/// Leaves the exception as it is, but for the text of what nanobind says of arguments.
void put_into_words() {
  nb::python_error error;
  try {
    const nb::str text(error.value());
    if (nb::cast<std::string>(text).find("(): incompatible function arguments.") != std::string::npos) {
      PyErr_SetObject(PyExc_TypeError, nb::module_::import_("polhode._errors").attr("of_call")(text).ptr());
      return;
    }
  } catch (nb::python_error& fault) {
    fault.restore();
    return;
  }
  error.restore();
}

template <std::size_t kind>
PyObject* call(PyObject* self, PyObject* const* arguments, std::size_t count, PyObject* names) {
  PyObject* const result = own_calls[kind](self, arguments, count, names);
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError) != 0) put_into_words();
  return result;
}

constexpr auto calls = []<std::size_t... kind>(std::index_sequence<kind...>) {
  return std::array<vectorcallfunc, kKinds>{&call<kind>...};
}
(std::make_index_sequence<kKinds>{});

/// Whether that is where a function of nanobind's says how it is called.
bool is_place_of_call(const vectorcallfunc* place, [[maybe_unused]] nb::handle function) {
  if (NB_VERSION_MAJOR != 3 || *place == nullptr) return false;
#ifndef Py_LIMITED_API  // which lacks the means to ask
  if (*place != PyVectorcall_Function(function.ptr())) return false;
#endif
  return true;
}

void take_over(nb::handle function) {
  vectorcallfunc* const place =
      reinterpret_cast<vectorcallfunc*>(reinterpret_cast<char*>(function.ptr()) + sizeof(PyVarObject));
  if (!is_place_of_call(place, function)) return;
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    if (*place == calls[kind]) return;
    if (own_calls[kind] == nullptr) own_calls[kind] = *place;
    if (own_calls[kind] == *place) {
      *place = calls[kind];
      return;
    }
  }
}

bool is_function(nb::handle object) {
  const auto name = nb::cast<std::string>(object.type().attr("__name__"));
  return name == "nb_func" || name == "nb_method";
}

}  // namespace

void tell_wrong_arguments(nb::module_& m) {
  const auto members = [](nb::handle owner) { return nb::list(owner.attr("__dict__").attr("values")()); };
  for (const nb::handle object : members(m)) {
    if (is_function(object)) take_over(object);
    if (!PyType_Check(object.ptr())) continue;
    for (const nb::handle member : members(object)) {
      if (is_function(member)) take_over(member);
    }
  }
}

}  // namespace polhode::python
