// The module: exceptions, and what the other files add.
#include "module.h"

#include <cstring>
#include <utility>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/knead.h"
#include "work.h"

namespace knead::python {
namespace {

// A message may name a file whose name is no UTF-8; its bytes are then written as \x80.
void raise(const py::handle& type, const char* message) {
  const auto length = static_cast<py::ssize_t>(std::strlen(message));
  const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(message, length, "backslashreplace"));
  if (text) PyErr_SetObject(type.ptr(), text.ptr());
}

// The message of an error of the library as an exception of Python.
void add_exceptions(py::module_& module) {
  static py::exception<InvalidInput> invalid_input(module, "InvalidInput", PyExc_ValueError);
  static py::exception<IoError> file_error(module, "FileError", PyExc_OSError);
  static py::exception<AccuracyError> accuracy_error(module, "AccuracyError", PyExc_RuntimeError);
  static py::exception<UnavailableError> unavailable(module, "Unavailable", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const QualityLimit& error) {
      raise(accuracy_error, error.what());
    } catch (const InvalidInput& error) {
      raise(invalid_input, error.what());
    } catch (const IoError& error) {
      raise(file_error, error.what());
    } catch (const AccuracyError& error) {
      raise(accuracy_error, error.what());
    } catch (const UnavailableError& error) {
      raise(unavailable, error.what());
    }
  });
}

}  // namespace
}  // namespace knead::python

PYBIND11_MODULE(_knead, module) {
  using namespace knead::python;
  module.attr("__version__") = KNEAD_VERSION;
  module.attr("simd") = std::string(knead::simd_name());
  add_exceptions(module);
  add_shapes(module);
  add_cells(module);
  add_strokes(module);
  add_flow(module);
  add_fit(module);
  add_skin(module);
  add_remesh(module);
  add_render(module);
  add_workbench(module);
  add_gesture(module);
  add_animation(module);
  add_measures(module);
}
