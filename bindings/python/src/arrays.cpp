// Arrays of numpy as points, faces and numbers of the library, and back.
#include "arrays.h"

#include <fmt/format.h>

#include <cstring>
#include <type_traits>

#include "knead/error.h"

namespace knead::python {
namespace {

static_assert(sizeof(Vec3d) == 3 * sizeof(double) && std::is_trivially_copyable_v<Vec3d>);
static_assert(sizeof(Mat3d) == 9 * sizeof(double) && std::is_trivially_copyable_v<Mat3d>);

std::string type_name(const py::handle& object) { return py::str(py::type::of(object).attr("__name__")); }

std::string shape_of(const py::array& array) { return py::str(array.attr("shape")); }

// By numpy itself: pybind11 before 2.12 reads the sizes of types of numpy 1.
int bytes_of_item(const py::array& array) { return array.attr("itemsize").cast<int>(); }

// What numpy makes of an object, or a TypeError.
py::array as_array(const py::object& object, const std::string& name, const char* kinds, const char* what) {
  py::array array;
  try {
    array = py::module_::import("numpy").attr("asarray")(object);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    throw py::type_error(fmt::format("{} must be an array of {}, got {}: {}", name, what, type_name(object),
                                     std::string(py::str(error.value()))));
  }
  const py::module_ masked = py::module_::import("numpy.ma");
  if (py::isinstance<py::array>(object) && masked.attr("is_masked")(object).cast<bool>()) {
    throw InvalidInput(name + " is a masked array with masked values; fill or remove them");
  }
  const bool is_empty_list = array.size() == 0 && !py::isinstance<py::array>(object);
  if (!is_empty_list && std::strchr(kinds, array.dtype().kind()) == nullptr) {
    throw py::type_error(
        fmt::format("{} must be an array of {}, got dtype {}", name, what, std::string(py::str(array.dtype()))));
  }
  return array;
}

void require_finite_numbers(std::span<const Vec3d> points, const std::string& name) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_finite(points[i])) continue;
    throw InvalidInput(fmt::format("{}[{}] has a coordinate that is not finite; place or remove it", name, i));
  }
}

std::uint32_t vertex_number(long long number, std::size_t face, std::size_t count) {
  if (number < 0 || static_cast<unsigned long long>(number) >= count) {
    throw InvalidInput(fmt::format("faces[{}] names vertex {}, but the vertices are 0 to {}", face, number,
                                   static_cast<long long>(count) - 1));
  }
  return static_cast<std::uint32_t>(number);
}

using Integers = py::array_t<long long, py::array::c_style | py::array::forcecast>;

Integers integers_from(const py::object& object, const std::string& name) {
  const py::array array = as_array(object, name, "iu", "whole numbers");
  if (array.dtype().kind() == 'u' && bytes_of_item(array) == 8) {
    const auto wide = py::array_t<unsigned long long, py::array::c_style | py::array::forcecast>::ensure(array);
    for (py::ssize_t i = 0; i < wide.size(); ++i) {
      if (wide.data()[i] >> 63 != 0) throw InvalidInput(name + " has a number above all vertices");
    }
  }
  return Integers::ensure(array);
}

void add_face(Mesh& mesh, std::span<const long long> corners) {
  for (const long long corner : corners) {
    mesh.corner_vertex.push_back(vertex_number(corner, mesh.face_count(), mesh.vertex_count()));
  }
  mesh.face_begin.push_back(static_cast<std::uint32_t>(mesh.corner_vertex.size()));
}

template <class T>
void copy_rows(Mesh& mesh, const py::array_t<T, py::array::c_style | py::array::forcecast>& rows) {
  const auto corners = static_cast<std::size_t>(rows.shape(1));
  const auto count = static_cast<std::size_t>(rows.shape(0));
  mesh.corner_vertex.resize(count * corners);
  mesh.face_begin.resize(count + 1);
  const std::size_t vertices = mesh.vertex_count();
  for (std::size_t i = 0; i < mesh.corner_vertex.size(); ++i) {
    const auto number = static_cast<std::size_t>(rows.data()[i]);  // a negative one is above all vertices
    if (number >= vertices) vertex_number(static_cast<long long>(rows.data()[i]), i / corners, vertices);
    mesh.corner_vertex[i] = static_cast<std::uint32_t>(number);
  }
  for (std::size_t f = 0; f <= count; ++f) mesh.face_begin[f] = static_cast<std::uint32_t>(f * corners);
}

void add_rows(Mesh& mesh, const py::array& rows) {
  if (rows.size() == 0) return;
  if (rows.ndim() != 2) {
    throw InvalidInput(
        fmt::format("faces must have shape (m, k), or be a list of faces, got shape {}", shape_of(rows)));
  }
  if (py::isinstance<py::array_t<std::uint32_t>>(rows)) {
    copy_rows<std::uint32_t>(mesh, rows);
  } else {
    copy_rows<long long>(mesh, integers_from(rows, "faces"));
  }
}

}  // namespace

std::span<const Vec3d> Points::span() const {
  return {reinterpret_cast<const Vec3d*>(array.data()), static_cast<std::size_t>(array.size()) / 3};
}

Points points_from(py::object object, const std::string& name) {
  if (!py::isinstance<py::array>(object)) {
    for (const char* attribute : {"vertices", "points"}) {
      if (!py::hasattr(object, attribute)) continue;
      object = object.attr(attribute);
      break;
    }
  }
  const py::array given = as_array(object, name, "fiu", "real numbers");
  const bool is_empty = given.size() == 0 && (given.ndim() == 1 || (given.ndim() == 2 && given.shape(1) == 3));
  if (!is_empty && (given.ndim() != 2 || given.shape(1) != 3)) {
    throw InvalidInput(fmt::format("{} must have shape (n, 3), got {}", name, shape_of(given)));
  }
  Points points;
  points.is_float32 = given.dtype().kind() == 'f' && bytes_of_item(given) == 4;
  points.array = DoubleArray::ensure(given);
  if (!points.array) throw py::error_already_set();
  if (points.array.ndim() == 1) points.array = new_points(0);
  require_finite_numbers(points.span(), name);
  return points;
}

DoubleArray new_points(std::size_t count) { return DoubleArray({static_cast<py::ssize_t>(count), py::ssize_t{3}}); }

std::span<Vec3d> span_of(DoubleArray& array) {
  return {reinterpret_cast<Vec3d*>(array.mutable_data()), static_cast<std::size_t>(array.size()) / 3};
}

DoubleArray array_of(std::span<const Vec3d> points) {
  DoubleArray array = new_points(points.size());
  if (!points.empty()) std::memcpy(array.mutable_data(), points.data(), points.size_bytes());
  return array;
}

DoubleArray array_of(std::span<const Mat3d> matrices) {
  DoubleArray array({static_cast<py::ssize_t>(matrices.size()), py::ssize_t{3}, py::ssize_t{3}});
  if (!matrices.empty()) std::memcpy(array.mutable_data(), matrices.data(), matrices.size_bytes());
  return array;
}

void set_faces(Mesh& mesh, const py::object& faces) {
  mesh.face_begin = {0};
  mesh.corner_vertex.clear();
  if (faces.is_none()) return;
  if (py::isinstance<py::array>(faces) && faces.attr("dtype").attr("kind").cast<std::string>() != "O") {
    return add_rows(mesh, as_array(faces, "faces", "iu", "whole numbers"));
  }
  if (!py::isinstance<py::sequence>(faces) || py::isinstance<py::str>(faces)) {
    throw py::type_error("faces must be an array (m, k) of whole numbers, or a sequence of faces, got " +
                         type_name(faces));
  }
  for (const py::handle face : faces) {
    const Integers corners =
        integers_from(py::reinterpret_borrow<py::object>(face), fmt::format("faces[{}]", mesh.face_count()));
    if (corners.ndim() != 1) throw InvalidInput(fmt::format("faces[{}] must be a list of vertices", mesh.face_count()));
    add_face(mesh, {corners.data(), static_cast<std::size_t>(corners.size())});
  }
}

Mesh mesh_from(const Points& points, const py::object& faces) {
  Mesh mesh;
  const std::span<const Vec3d> span = points.span();
  mesh.positions.assign(span.begin(), span.end());
  set_faces(mesh, faces);
  return mesh;
}

py::object faces_of(const Mesh& mesh) {
  const std::size_t count = mesh.face_count();
  bool all_triangles = true;
  for (std::size_t f = 0; f < count && all_triangles; ++f) all_triangles = mesh.face(f).size() == 3;
  if (all_triangles) {
    py::array_t<std::uint32_t> array({static_cast<py::ssize_t>(count), py::ssize_t{3}});
    if (count > 0) std::memcpy(array.mutable_data(), mesh.corner_vertex.data(), 12 * count);
    return array;
  }
  py::list faces;
  for (std::size_t f = 0; f < count; ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    faces.append(py::array_t<std::uint32_t>(static_cast<py::ssize_t>(face.size()), face.data()));
  }
  return faces;
}

}  // namespace knead::python
