// Shapes and their files; check.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>

#include "arrays.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
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

constexpr std::array<const char*, 8> kTypeNames{"int8",  "uint8",  "int16",   "uint16",
                                                "int32", "uint32", "float32", "float64"};

// (n) or (n, components), in the type that the file has.
py::object attribute_of(const ShapeFile& file, const std::string& name) {
  const Attribute* const attribute = file.mesh.find_attribute(name);
  if (attribute == nullptr) throw py::key_error(name);
  py::array_t<double> values = array_from(attribute->values);
  const py::object array = values.attr("astype")(kTypeNames.at(static_cast<std::size_t>(attribute->type)));
  return attribute->components == 1 ? array : array.attr("reshape")(-1, attribute->components);
}

std::size_t components_of(const py::array& given) {
  return given.ndim() == 2 ? static_cast<std::size_t>(given.shape(1)) : 1;
}

// Takes the given numbers for those of an attribute, which must have as many.
void set_values(const py::array& given, Attribute& attribute, std::size_t count) {
  const bool fits = (given.ndim() == 1 || given.ndim() == 2) && static_cast<std::size_t>(given.shape(0)) == count &&
                    components_of(given) == static_cast<std::size_t>(attribute.components);
  if (!fits) {
    throw InvalidInput(fmt::format("the attribute \"{}\" must have shape ({}, {}), got {}", attribute.name, count,
                                   attribute.components, py::str(py::tuple(given.attr("shape"))).cast<std::string>()));
  }
  const py::module_ numpy = py::module_::import("numpy");
  const py::object typed = given.attr("astype")(kTypeNames.at(static_cast<std::size_t>(attribute.type)));
  const bool is_real = attribute.type >= NumberType::float32;
  if (!is_real && !numpy.attr("array_equal")(typed, given).cast<bool>()) {
    throw InvalidInput(fmt::format("the attribute \"{}\" has numbers that are no {}", attribute.name,
                                   kTypeNames.at(static_cast<std::size_t>(attribute.type))));
  }
  const py::array_t<double, py::array::c_style | py::array::forcecast> values(typed);
  attribute.values.assign(values.data(), values.data() + values.size());
}

// An attribute that the file lacks, of the elements of which there are as many.
Attribute new_attribute(const py::array& given, const std::string& name, const Mesh& mesh) {
  Attribute attribute{name, Domain::vertex, NumberType::float64, static_cast<int>(components_of(given)), {}};
  const auto rows = static_cast<std::size_t>(given.ndim() > 0 ? given.shape(0) : 0);
  for (const Domain domain : {Domain::face, Domain::corner, Domain::vertex}) {
    if (mesh.element_count(domain) == rows) attribute.domain = domain;
  }
  const auto* const type = std::ranges::find(kTypeNames, given.dtype().attr("name").cast<std::string>());
  if (type != kTypeNames.end()) attribute.type = static_cast<NumberType>(type - kTypeNames.begin());
  return attribute;
}

// The file with its vertices at these places and another attribute, or other numbers of it.
ShapeFile with_attribute(const ShapeFile& file, const std::string& name, const py::array& given,
                         const py::object& vertices) {
  if (given.dtype().kind() != 'f' && given.dtype().kind() != 'i' && given.dtype().kind() != 'u') {
    throw py::type_error("the attribute \"" + name + "\" must be an array of real numbers");
  }
  WriteOptions options;
  options.double_coordinates = true;
  const Points points = points_from(vertices, "vertices");
  ShapeFile moved = parse_shape(serialize_shape(file.format, file, points.span(), options), file.format, "shape");
  Mesh& mesh = moved.mesh;
  const auto found = std::ranges::find(mesh.attributes, name, &Attribute::name);
  const bool is_new = found == mesh.attributes.end();
  if (is_new) mesh.attributes.push_back(new_attribute(given, name, mesh));
  Attribute& attribute = is_new ? mesh.attributes.back() : *found;
  set_values(given, attribute, mesh.element_count(attribute.domain));
  const Attribute wanted = attribute;
  std::string bytes;
  if (is_new || mesh.face_count() == 0) {
    bytes = serialize_mesh(file.format, mesh, options);
  } else {
    std::vector<std::uint32_t> sources(mesh.face_count());
    std::iota(sources.begin(), sources.end(), 0U);
    const Mesh changed = mesh;
    moved = parse_shape(serialize_shape(file.format, file, points.span(), options), file.format, "shape");
    bytes = serialize_remeshed(file.format, moved, changed, sources, options);
  }
  ShapeFile result = parse_shape(std::move(bytes), file.format, "shape");
  const Attribute* const kept = result.mesh.find_attribute(name);
  if (kept == nullptr || kept->values.size() != wanted.values.size()) {
    throw InvalidInput(
        fmt::format("a file of the format {} cannot hold the attribute \"{}\" of this shape; write a PLY "
                    "file, read it and set the attribute there",
                    file.format, name));
  }
  return result;
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

// Points with these columns of numbers, in the types of their arrays, as the PLY file that they would be.
ShapeFile cloud_from(const py::object& points, const std::vector<std::pair<std::string, py::array>>& columns) {
  const Points given = points_from(points, "means");
  Mesh mesh = mesh_from(given, py::none());
  for (const auto& [name, numbers] : columns) {
    Attribute& attribute = mesh.attributes.emplace_back(new_attribute(numbers, name, mesh));
    set_values(numbers, attribute, mesh.vertex_count());
  }
  const py::gil_scoped_release released;
  WriteOptions options;
  options.double_coordinates = !given.is_float32;
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
    const std::vector<Triangle> triangles = triangulate(WeldedMesh(mesh).mesh());
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
      .def("attribute", &attribute_of)
      .def("with_attribute", &with_attribute)
      .def("bytes", [](const ShapeFile& file) { return py::bytes(file.bytes); })
      .def("decimals", &decimals_of)
      .def("are_splats", [](const ShapeFile& file) { return are_splats(file.mesh); })
      .def("holds_splats",  // also beside faces
           [](const ShapeFile& file) { return !splats_among(std::array{&file.mesh}).empty(); })
      .def("write", &write);
  module.def("read_shape", &read);
  module.def("shape_from", &shape_from);
  module.def("cloud_from", &cloud_from);
  module.def("parse_shape", &parse);
  module.def("check", &check);
  module.def("crossings", &crossings);
}

}  // namespace knead::python
