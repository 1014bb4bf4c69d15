#include "module.h"

#include "knead/flow/simd.h"
#include "knead/math/error.h"
#include "knead/remesh/remesh.h"
#include "work.h"

namespace knead::python {
namespace {

// The message of an error of the library as an exception of Python.
void add_exceptions(py::module_& module) {
  static py::exception<InvalidInput> invalid_input(module, "InvalidInput", PyExc_ValueError);
  static py::exception<IoError> file_error(module, "FileError", PyExc_OSError);
  static py::exception<AccuracyError> accuracy_error(module, "AccuracyError", PyExc_RuntimeError);
  static py::exception<UnavailableError> unavailable(module, "Unavailable", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const RemeshLimit& error) {
      PyErr_SetString(accuracy_error.ptr(), error.what());
    } catch (const InvalidInput& error) {
      PyErr_SetString(invalid_input.ptr(), error.what());
    } catch (const IoError& error) {
      PyErr_SetString(file_error.ptr(), error.what());
    } catch (const AccuracyError& error) {
      PyErr_SetString(accuracy_error.ptr(), error.what());
    } catch (const UnavailableError& error) {
      PyErr_SetString(unavailable.ptr(), error.what());
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
  add_strokes(module);
  add_flow(module);
  add_remesh(module);
  add_render(module);
  add_workbench(module);
}
