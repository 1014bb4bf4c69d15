// Remeshing, and the certificate.
#include <pybind11/stl.h>

#include "arrays.h"
#include "json/json.h"
#include "knead/certify.h"
#include "knead/io.h"
#include "module.h"
#include "options.h"
#include "work.h"

namespace knead::python {
namespace {

// A remeshed shape and what was done, as JSON.
py::tuple result_of(const Mesh& mesh, const std::vector<std::uint32_t>& source, const std::string& report) {
  return py::make_tuple(array_of(mesh.positions), faces_of(mesh), array_from(source), report);
}

py::object remesh_whole(const py::object& vertices, const py::object& faces, const RemeshSettings& settings,
                        double seconds, int threads, const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  Progress progress;
  RemeshOptions options;
  options.threads = threads;
  options.seconds = seconds;
  options.progress = &progress;
  Remeshed result;
  if (!run_watched(callback, progress, [&] { result = remesh(mesh, settings, options); })) return py::none();
  const RemeshCounts& counts = result.counts;
  const Json report{{"vertices", result.mesh.vertex_count()},
                    {"faces", result.mesh.face_count()},
                    {"splits", counts.splits},
                    {"collapses", counts.collapses},
                    {"flips", counts.flips},
                    {"complete", counts.complete},
                    {"out_of_time", counts.out_of_time}};
  return result_of(result.mesh, result.face_source, to_text(report));
}

py::object remesh_moved(const py::object& vertices, const py::object& faces, const Session& session,
                        const RemeshSettings& settings, double seconds, const Accuracy& accuracy,
                        const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  Progress progress;
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.remesh.settings = settings;
  options.remesh.seconds = seconds;
  options.progress = &progress;
  ReplayResult replayed;
  std::string report;
  const bool is_done = run_watched(callback, progress, [&] {
    replayed = replay(borrow(mesh), session, options);
    if (replayed.status == AdvectStatus::done) report = to_json(make_report(mesh, replayed, options, {}));
  });
  if (!is_done) return py::none();
  require_done(replayed.status, session, replayed.failed_line);
  std::vector<std::uint32_t> source(mesh.face_count());
  for (std::size_t f = 0; f < source.size(); ++f) source[f] = static_cast<std::uint32_t>(f);
  if (replayed.shape.is_remeshed()) source = replayed.shape.provenance()->face_source;
  return result_of(replayed.shape.to_mesh(), source, report);
}

py::object certificate(const py::object& before, const py::object& after, const py::object& faces,
                       const Session& session, const Accuracy& accuracy, const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(before, "before"), faces);
  const Points moved = points_from(after, "after");
  Progress progress;
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.progress = &progress;
  std::string json;
  const bool is_done =
      run_watched(callback, progress, [&] { json = to_json(certify(mesh, moved.span(), session, options)); });
  return is_done ? py::object(py::str(json)) : py::object(py::none());
}

py::tuple resolve(const py::object& vertices, const py::object& faces, const Session& session, int threads) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  ReplayOptions options;
  options.motion.threads = threads;
  const ReplayResult replayed = *replay_watched(py::none(), mesh, session, options);
  return py::make_tuple(replayed.resolved, replayed.warnings);
}

RemeshSettings settings_of(std::optional<double> max_edge, std::optional<double> max_angle_deg,
                           std::optional<double> max_chord, std::optional<double> min_edge,
                           std::optional<int> iterations, std::optional<std::size_t> max_vertices) {
  RemeshSettings settings{max_edge, max_angle_deg, max_chord, min_edge, iterations, max_vertices};
  validate(settings);
  return settings;
}

}  // namespace

void add_remesh(py::module_& module) {
  py::class_<RemeshSettings>(module, "RemeshSettings")
      .def(py::init(&settings_of), py::kw_only(), py::arg("max_edge") = py::none(),
           py::arg("max_angle_deg") = py::none(), py::arg("max_chord") = py::none(), py::arg("min_edge") = py::none(),
           py::arg("iterations") = py::none(), py::arg("max_vertices") = py::none());
  module.def("remesh_whole", &remesh_whole);
  module.def("remesh_moved", &remesh_moved);
  module.def("certify", &certificate);
  module.def("resolve", &resolve);
}

}  // namespace knead::python
