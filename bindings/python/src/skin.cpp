// Shapes that hang on skeletons.
#include "knead/fit.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <utility>

#include "arrays.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/session.h"
#include "module.h"
#include "work.h"

namespace knead::python {
namespace {

using IntArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

// Matrices (n, 4, 4) whose last row is 0 0 0 1.
std::vector<BoneTransform> transforms_from(const DoubleArray& matrices, const std::string& name) {
  if (matrices.ndim() != 3 || matrices.shape(1) != 4 || matrices.shape(2) != 4) {
    throw InvalidInput(name + " must be matrices, an array (bones, 4, 4)");
  }
  const auto at = matrices.unchecked<3>();
  std::vector<BoneTransform> result;
  for (py::ssize_t b = 0; b < at.shape(0); ++b) {
    if (!(std::abs(at(b, 3, 0)) + std::abs(at(b, 3, 1)) + std::abs(at(b, 3, 2)) + std::abs(at(b, 3, 3) - 1) < 1e-6)) {
      throw InvalidInput(fmt::format("{} holds a matrix of bone {} whose last row is not 0 0 0 1", name, b));
    }
    const auto row = [&](py::ssize_t i) { return Vec3d{at(b, i, 0), at(b, i, 1), at(b, i, 2)}; };
    result.push_back({{row(0), row(1), row(2)}, {at(b, 0, 3), at(b, 1, 3), at(b, 2, 3)}});
  }
  return result;
}

Skin skin_from(const IntArray& begin, const IntArray& bones, const DoubleArray& weights, const IntArray& parents,
               const DoubleArray& rest) {
  Skin skin;
  skin.rest = transforms_from(rest, "rest");
  for (py::ssize_t i = 0; i < parents.size(); ++i) skin.parents.push_back(static_cast<std::int32_t>(parents.at(i)));
  for (py::ssize_t i = 0; i < begin.size(); ++i) skin.begin.push_back(static_cast<std::size_t>(begin.at(i)));
  for (py::ssize_t i = 0; i < bones.size(); ++i) {
    skin.weights.push_back({static_cast<std::uint32_t>(bones.at(i)), weights.at(i)});
  }
  return skin;
}

py::object pose(const py::tuple& shape, const Skin& skin, const DoubleArray& matrices, double rigid_weight,
                double detail, bool measured, int threads, const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(shape[0], "vertices"), shape[1]);
  const SkinPose wanted = transforms_from(matrices, "poses");
  Progress progress;
  SkinOptions options;
  options.rigid_weight = rigid_weight;
  options.detail = detail;
  options.threads = threads;
  options.progress = &progress;
  SkinResult result;
  if (!run_watched(callback, progress, [&] { result = pose_skin(mesh, skin, wanted, options, measured); })) {
    return py::none();
  }
  std::vector<SessionStroke> strokes;
  for (Stroke& stroke : result.strokes) strokes.push_back({std::move(stroke)});
  return py::make_tuple(strokes, array_of(result.positions), to_json(result.report));
}

py::object correctives(const py::tuple& shape, const Skin& skin, const DoubleArray& matrices, double rigid_weight,
                       double detail, int threads, const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(shape[0], "vertices"), shape[1]);
  const SkinPose wanted = transforms_from(matrices, "pose");
  Progress progress;
  SkinOptions options;
  options.rigid_weight = rigid_weight;
  options.detail = detail;
  options.threads = threads;
  options.progress = &progress;
  std::vector<Corrective> made;
  if (!run_watched(callback, progress, [&] { made = make_correctives(mesh, skin, wanted, options); })) {
    return py::none();
  }
  py::list result;
  for (const Corrective& one : made) {
    result.append(py::make_tuple(array_from(one.bones), array_of(one.axes), array_from(one.angles_deg),
                                 array_of(one.offsets), complaint_about(one.flow)));
  }
  return result;
}

}  // namespace

void add_skin(py::module_& module) {
  py::class_<Skin>(module, "Skin").def(py::init(&skin_from));
  module.def("pose_skin", &pose);
  module.def("correctives", &correctives);
  module.def("linear_blend", [](const py::object& vertices, const Skin& skin, const DoubleArray& matrices) {
    const Points points = points_from(vertices, "vertices");
    return array_of(linear_blend(points.span(), skin, transforms_from(matrices, "poses")));
  });
  module.def("dual_quaternion_blend", [](const py::object& vertices, const Skin& skin, const DoubleArray& matrices) {
    const Points points = points_from(vertices, "vertices");
    return array_of(dual_quaternion_blend(points.span(), skin, transforms_from(matrices, "poses")));
  });
  module.def("corrective_shape",
             [](const py::object& vertices, const py::object& posed, const Skin& skin, const DoubleArray& matrices) {
               const Points points = points_from(vertices, "vertices");
               const Points there = points_from(posed, "posed");
               return array_of(corrective_shape(points.span(), there.span(), skin, transforms_from(matrices, "poses")));
             });
}

}  // namespace knead::python
