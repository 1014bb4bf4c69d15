// Arrays of numpy as points and faces of the library, and back; what else Python gives of a mesh.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::python {

namespace py = pybind11;

using DoubleArray =
    py::array_t<double, py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

// Points that a caller gave. They are read where they lie if that is a C-contiguous array of float64, else from a copy.
struct Points {
  DoubleArray array;        // (n, 3); keeps the memory alive
  bool is_float32 = false;  // what was given

  std::span<const Vec3d> span() const;
};

// Returns points from an array-like of shape (n, 3) and any real type, or from an object that has such `.vertices` or
// `.points`. `name` stands in messages. Throws TypeError for anything else, and InvalidInput for another shape, or with
// the first index for a coordinate that is not finite.
Points points_from(py::object object, const std::string& name);

// Returns a new array (n, 3).
DoubleArray new_points(std::size_t count);
std::span<Vec3d> span_of(DoubleArray& array);
DoubleArray array_of(std::span<const Vec3d> points);

// Returns an array (n, 3, 3).
DoubleArray array_of(std::span<const Mat3d> matrices);

// Gives a mesh the faces of an integer array (m, k), of a sequence of sequences of vertices, or none for None. Throws
// TypeError for other things, and InvalidInput for a number that is no vertex.
void set_faces(Mesh& mesh, const py::object& faces);

// Returns a mesh with these faces; copies the points.
Mesh mesh_from(const Points& points, const py::object& faces);

// Returns (m, 3) of uint32 if all faces are triangles, else a list of arrays.
py::object faces_of(const Mesh& mesh);

// What a volume mesh has besides its points. A file is read when its patches or cells are asked for; the cells once.
struct MeshParts {
  std::function<std::vector<Patch>()> patches;
  std::function<VolumeCells(bool are_needed, std::vector<std::string>& notes)> read_cells;  // as cells_to_judge()
  std::shared_ptr<const VolumeCells> cells{};
};

// Returns a vector of numbers as an array.
template <class T>
py::array_t<T> array_from(const std::vector<T>& numbers) {
  // By its shape: pybind11 2.10 finds no strides for a mere count where numpy is 2 or newer.
  return py::array_t<T>(py::array::ShapeContainer{static_cast<py::ssize_t>(numbers.size())}, numbers.data());
}

}  // namespace knead::python
