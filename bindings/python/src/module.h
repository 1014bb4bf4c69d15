// The parts of the module `_knead`, one for each module of the library. Python's side is in ../knead.
#pragma once

#include <pybind11/pybind11.h>

namespace knead::python {

namespace py = pybind11;

void add_shapes(py::module_& module);
void add_cells(py::module_& module);
void add_strokes(py::module_& module);
void add_flow(py::module_& module);
void add_fit(py::module_& module);
void add_skin(py::module_& module);
void add_remesh(py::module_& module);
void add_render(py::module_& module);
void add_workbench(py::module_& module);
void add_gesture(py::module_& module);
void add_animation(py::module_& module);
void add_measures(py::module_& module);

}  // namespace knead::python
