// Measures of a surface with their derivatives with respect to its points.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <vector>

#include "arrays.h"
#include "knead/error.h"
#include "knead/replay.h"
#include "module.h"
#include "work.h"

namespace knead::python {
namespace {

using Vertices = std::vector<std::uint32_t>;

// Returns of(mesh, its triangles).
template <class Of>
SurfaceMeasures measured(const py::object& vertices, const py::object& faces, const Of& of) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  SurfaceMeasures result;
  Progress progress;
  run_watched(py::none(), progress, [&] { result = of(mesh.positions, triangulate(mesh)); });
  return result;
}

py::array_t<double> jvp_of(const SurfaceMeasures& measures, const py::object& tangents) {
  return array_from(measures.jvp(points_from(tangents, "tangents").span()));
}

DoubleArray vjp_of(const SurfaceMeasures& measures, const std::vector<double>& weights) {
  return array_of(measures.vjp(weights));
}

}  // namespace

void add_measures(py::module_& module) {
  py::class_<SurfaceMeasures>(module, "SurfaceMeasures")
      .def_property_readonly("values", [](const SurfaceMeasures& measures) { return array_from(measures.values); })
      .def("jvp", &jvp_of)
      .def("vjp", &vjp_of);
  module.def("volume_of",
             [](const py::object& vertices, const py::object& faces) { return measured(vertices, faces, volume_of); });
  module.def("area_of",
             [](const py::object& vertices, const py::object& faces) { return measured(vertices, faces, area_of); });
  module.def("thickness_at", [](const py::object& vertices, const py::object& faces, const Vertices& at) {
    return measured(vertices, faces,
                    [&](const auto& points, const auto& triangles) { return thickness_at(points, triangles, at); });
  });
  module.def("curvature_at", [](const py::object& vertices, const py::object& faces, const Vertices& at) {
    return measured(vertices, faces,
                    [&](const auto& points, const auto& triangles) { return curvature_at(points, triangles, at); });
  });
  module.def("patch_distance", [](const py::object& vertices, const py::object& patch, const Vertices& at) {
    return measured(vertices, patch,
                    [&](const auto& points, const auto& triangles) { return patch_distance(points, at, triangles); });
  });
}

}  // namespace knead::python
