// Fits of one shape to another.
#include "knead/fit.h"

#include <pybind11/stl.h>

#include <utility>

#include "arrays.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "module.h"
#include "work.h"

namespace knead::python {
namespace {

// Rows of a source's point, its place and a tolerance: (n, 7).
std::vector<FitPair> pairs_from(const DoubleArray& rows) {
  std::vector<FitPair> pairs;
  if (rows.ndim() != 2 || rows.shape(1) != 7) throw InvalidInput("pairs must be an array (n, 7)");
  const auto at = rows.unchecked<2>();
  for (py::ssize_t i = 0; i < at.shape(0); ++i) {
    pairs.push_back({{at(i, 0), at(i, 1), at(i, 2)}, {at(i, 3), at(i, 4), at(i, 5)}, at(i, 6)});
  }
  return pairs;
}

FitAlign align_named(const std::string& name) {
  if (name == "auto") return FitAlign::automatic;
  if (name == "always") return FitAlign::always;
  if (name == "never") return FitAlign::never;
  throw InvalidInput("align must be True, False or \"always\", got \"" + name + "\"");
}

FitVolume volume_named(const std::string& name) {
  if (name == "keep") return FitVolume::keep;
  if (name == "total") return FitVolume::total;
  if (name == "free") return FitVolume::free;
  throw InvalidInput("volume must be \"keep\", \"total\" or \"free\", got \"" + name + "\"");
}

// How a fit is asked for.
struct FitRequest {
  DoubleArray landmarks;
  DoubleArray map;
  bool surface = true;
  bool partial = false;
  std::string align;
  std::string volume;
  double max_stretch = 5;
  int threads = 0;
};

py::object fit(const py::tuple& source, const py::tuple& target, const FitRequest& request,
               const py::object& callback) {
  const Mesh from = mesh_from(points_from(source[0], "the source's vertices"), source[1]);
  const Mesh to = mesh_from(points_from(target[0], "the target's vertices"), target[1]);
  Progress progress;
  BodyFitOptions options;
  options.landmarks = pairs_from(request.landmarks);
  options.map = pairs_from(request.map);
  options.surface = request.surface;
  options.partial = request.partial;
  options.align = align_named(request.align);
  options.volume = volume_named(request.volume);
  options.max_stretch = request.max_stretch;
  options.threads = request.threads;
  options.progress = &progress;
  BodyFit result;
  if (!run_watched(callback, progress, [&] { result = fit_body(from, to, options); })) return py::none();
  std::vector<SessionStroke> strokes;
  for (Stroke& stroke : result.strokes) strokes.push_back({std::move(stroke)});
  return py::make_tuple(strokes, array_of(result.positions), to_json(result.report),
                        complaint_about(result.report, options));
}

}  // namespace

void add_fit(py::module_& module) {
  py::class_<FitRequest>(module, "FitRequest")
      .def(py::init([](DoubleArray landmarks, DoubleArray map, bool surface, bool partial, std::string align,
                       std::string volume, double max_stretch, int threads) {
        return FitRequest{std::move(landmarks), std::move(map),    surface,     partial,
                          std::move(align),     std::move(volume), max_stretch, threads};
      }));
  module.def("fit", &fit);
}

}  // namespace knead::python
