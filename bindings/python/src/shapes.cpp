// Shapes and their files; check.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>

#include "arrays.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "module.h"
#include "work.h"

namespace knead::python {
namespace {

py::array_t<std::uint32_t> triangles_of(const Mesh& mesh) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  py::array_t<std::uint32_t> array({static_cast<py::ssize_t>(triangles.size()), py::ssize_t{3}});
  std::uint32_t* out = array.mutable_data();
  for (const Triangle& t : triangles) {
    for (int corner = 0; corner < 3; ++corner) *out++ = t[corner];
  }
  return array;
}

std::vector<std::string> attribute_names(const ShapeFile& file) {
  std::vector<std::string> names;
  for (const Attribute& attribute : file.mesh.attributes) names.push_back(attribute.name);
  return names;
}

ShapeFile read(const std::filesystem::path& path) {
  Progress progress;
  ShapeFile file;
  run_watched(py::none(), progress, [&] { file = read_shape(path); });
  return file;
}

// A shape that no file holds yet, as the PLY file that it would be.
ShapeFile shape_from(const py::object& vertices, const py::object& faces) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  const py::gil_scoped_release released;
  validate(mesh);
  WriteOptions options;
  options.double_coordinates = true;
  return parse_shape(serialize_mesh("ply", mesh, options), "ply", "shape.ply");
}

ShapeFile parse(const py::bytes& bytes, const std::string& format) {
  std::string text = bytes;
  const py::gil_scoped_release released;
  return parse_shape(std::move(text), format, "shape." + format);
}

void write(const ShapeFile& file, const std::filesystem::path& path, const py::object& vertices, bool as_double,
           std::optional<int> decimals) {
  const Points points = points_from(vertices, "vertices");
  WriteOptions options;
  options.double_coordinates = as_double;
  options.decimals = decimals;
  const py::gil_scoped_release released;
  write_shape(path, file, points.span(), options);
}

std::string check(const py::object& vertices, const py::object& faces) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  Progress progress;
  std::string json;
  run_watched(py::none(), progress, [&] {
    validate(mesh);
    json = to_json(check_surface(mesh, describe(mesh), &progress));
  });
  return json;
}

// Faces that cross, in pairs.
py::array_t<std::uint32_t> crossings(const py::object& vertices, const py::object& faces) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  Progress progress;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  run_watched(py::none(), progress, [&] {
    validate(mesh);
    std::vector<std::uint32_t> face_of;  // of each triangle
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
      face_of.insert(face_of.end(), std::max<std::size_t>(mesh.face(f).size(), 2) - 2, f);
    }
    const std::vector<Triangle> triangles = triangulate(mesh);
    const SelfIntersections found = self_intersections(triangles, mesh.positions, {.progress = &progress});
    for (const auto& [a, b] : found.pairs) pairs.push_back({face_of.at(a), face_of.at(b)});
  });
  py::array_t<std::uint32_t> array({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}});
  if (!pairs.empty()) std::memcpy(array.mutable_data(), pairs.data(), pairs.size() * sizeof pairs[0]);
  return array;
}

}  // namespace

void add_shapes(py::module_& module) {
  py::class_<ShapeFile>(module, "ShapeFile")
      .def_readonly("format", &ShapeFile::format)
      .def_readonly("notes", &ShapeFile::notes)
      .def("vertices", [](const ShapeFile& file) { return array_of(file.mesh.positions); })
      .def("faces", [](const ShapeFile& file) { return faces_of(file.mesh); })
      .def("triangles", [](const ShapeFile& file) { return triangles_of(file.mesh); })
      .def("attributes", &attribute_names)
      .def("bytes", [](const ShapeFile& file) { return py::bytes(file.bytes); })
      .def("decimals", &decimals_of)
      .def("write", &write);
  module.def("read_shape", &read);
  module.def("shape_from", &shape_from);
  module.def("parse_shape", &parse);
  module.def("check", &check);
  module.def("crossings", &crossings);
}

}  // namespace knead::python
