// The shape in an editor.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <utility>

#include "arrays.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "module.h"
#include "work.h"

namespace knead::python {
namespace {

// A workbench, and an array that always holds its vertices.
class Bench {
 public:
  Bench(const py::object& vertices, const py::object& faces, const std::filesystem::path& folder)
      : workbench_(mesh_from(points_from(vertices, "vertices"), faces), folder), array_(new_points(0)) {
    update();
  }

  void set_live(std::vector<SessionStroke> strokes) {
    work([&](Progress* progress) { return workbench_.set_live(std::move(strokes), progress); });
  }
  void finish() {
    work([&](Progress* progress) { return workbench_.finish(progress); });
  }
  bool undo() {
    const bool can = workbench_.can_undo();
    work([&](Progress* progress) { return workbench_.undo(progress); });
    return can;
  }
  bool redo() {
    const bool can = workbench_.can_redo();
    work([&](Progress* progress) { return workbench_.redo(progress); });
    return can;
  }

  // Read-only, and written again by every call above.
  py::object vertices() const {
    py::object view = array_.attr("view")();
    view.attr("flags").attr("writeable") = false;
    return view;
  }
  py::object faces() const { return faces_of(*state_.mesh); }

  // The strokes in effect, the current gesture included.
  std::vector<SessionStroke> strokes() const {
    std::vector<SessionStroke> all;
    for (const auto& entry : workbench_.done()) all.insert(all.end(), entry->strokes.begin(), entry->strokes.end());
    all.insert(all.end(), workbench_.live().begin(), workbench_.live().end());
    return all;
  }

 private:
  template <class Work>
  void work(const Work& work) {
    Progress progress;
    WorkResult result;
    run_watched(py::none(), progress, [&] { result = work(&progress); });
    if (!result.refusal.empty()) throw InvalidInput(result.refusal);
    if (result.status == AdvectStatus::step_limit) throw AccuracyError(kStepLimitAdvice);
    update();
  }

  // Copies what has changed. A remesh makes a new array.
  void update() {
    const ShapeState before = std::exchange(state_, workbench_.state());
    const std::size_t count = state_.positions.size();
    if (static_cast<std::size_t>(array_.shape(0)) != count) {
      array_ = new_points(count);
      state_.positions.copy_to(span_of(array_));
      return;
    }
    const std::span<Vec3d> positions = span_of(array_);
    for (const IndexRange& range : state_.positions.changes_since(before.positions)) {
      for (std::uint32_t i = range.begin; i < range.end; ++i) positions[i] = state_.positions[i];
    }
  }

  Workbench workbench_;
  ShapeState state_;
  DoubleArray array_;
};

}  // namespace

void add_workbench(py::module_& module) {
  py::class_<Bench>(module, "Workbench")
      .def(py::init<const py::object&, const py::object&, const std::filesystem::path&>())
      .def("set_live", &Bench::set_live)
      .def("finish", &Bench::finish)
      .def("undo", &Bench::undo)
      .def("redo", &Bench::redo)
      .def("vertices", &Bench::vertices)
      .def("faces", &Bench::faces)
      .def("strokes", &Bench::strokes);
}

}  // namespace knead::python
