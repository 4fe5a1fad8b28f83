// The extension module polhode._core: the library for Python. What users see is named in polhode/__init__.py.
#include <typeinfo>

#include "polhode/base/error.hpp"
#include "polhode/write/document.hpp"
#include "python/python.hpp"

namespace polhode::python {
namespace {

/// Python's exceptions of _errors.py for ours.
void translate(const std::exception_ptr& problem, void*) {
  const auto type = [](const char* name) { return nb::module_::import_("polhode._errors").attr(name); };
  try {
    std::rethrow_exception(problem);
  } catch (const InputError& error) {
    const SourceLocation& where = error.where();
    const nb::object file = where.file.empty() ? nb::none() : nb::object(nb::cast(where.file));
    const nb::object line = where.line == 0 ? nb::none() : nb::object(nb::cast(where.line));
    PyErr_SetObject(type("InputError").ptr(), type("InputError")(error.what(), file, line, error.message()).ptr());
  } catch (const FileError& error) {
    PyErr_SetString(type("FileError").ptr(), error.what());
  } catch (const ComputationError& error) {
    PyErr_SetString(type("ComputationError").ptr(), error.what());
  } catch (const std::bad_cast&) {
    PyErr_SetString(type("InputError").ptr(), "an argument is of a type that is not taken here; help() says which are");
  }
}

}  // namespace
}  // namespace polhode::python

NB_MODULE(_core, m) {
  using namespace polhode::python;
  nanobind::register_exception_translator(translate);
  nanobind::set_leak_warnings(false);  // what Python does not clear at its end, as functions in torques, is no fault
  m.attr("version") = polhode::creator().substr(polhode::creator().find(' ') + 1);
  bind_time(m);
  bind_body(m);
  bind_torque(m);
  bind_motion(m);
  bind_ephemeris(m);
  bind_history(m);
  bind_uncertainty(m);
  bind_pickling(m);
}
