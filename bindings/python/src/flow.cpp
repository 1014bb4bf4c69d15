// Moving points: deform and Flow.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "arrays.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/replay.h"
#include "module.h"
#include "options.h"
#include "work.h"

namespace knead::python {

MotionOptions motion_options(const Accuracy& accuracy) {
  MotionOptions motion;
  motion.relative_tolerance = accuracy.relative_tolerance;
  motion.threads = accuracy.threads;
  motion.diagonal = accuracy.diagonal;
  if (accuracy.diagonal && !(*accuracy.diagonal > 0 && std::isfinite(*accuracy.diagonal))) {
    throw InvalidInput(fmt::format("diagonal must be a length above 0, got {}", *accuracy.diagonal));
  }
  const std::string& precision = accuracy.precision;
  if (precision == "float64" || precision == "double") {
    motion.precision = Precision::float64;
  } else if (precision != "float32" && precision != "float") {
    throw InvalidInput(fmt::format("precision must be \"float32\" or \"float64\", got \"{}\"", precision));
  }
  const std::optional<Integrator> integrator = integrator_named(accuracy.integrator);
  if (!integrator) {
    throw InvalidInput(fmt::format("integrator must be \"tsit5\" or \"rk4\", got \"{}\"", accuracy.integrator));
  }
  motion.integrator = *integrator;
  return motion;
}

namespace {

AdvectOptions advect_options_for(const Accuracy& accuracy, std::span<const Vec3d> points, Progress& progress) {
  const MotionOptions motion = motion_options(accuracy);
  AdvectOptions options = advect_options(motion, motion.diagonal.value_or(reference_length(points)));
  options.progress = &progress;
  return options;
}

// An array that the caller gave for the result.
class Target {
 public:
  Target(py::object out, const Points& points) : out_(std::move(out)) {
    if (out_.is_none()) return;
    if (!py::isinstance<py::array>(out_)) throw py::type_error("out must be an array of numpy");
    const py::array array = out_;
    if (array.dtype().kind() != 'f') throw py::type_error("out must be an array of float64 or float32");
    if (!array.writeable()) throw InvalidInput("out is read-only; give an array that can be written to");
    const auto count = static_cast<py::ssize_t>(points.span().size());
    if (array.ndim() != 2 || array.shape(0) != count || array.shape(1) != 3) {
      throw InvalidInput(fmt::format("out must have shape ({}, 3), as the vertices", count));
    }
    is_in_place_ = py::isinstance<DoubleArray>(array) && array.data() == points.array.data();
  }

  // Whether the points lie in it as doubles, and can be moved there.
  bool is_in_place() const { return is_in_place_; }

  // Returns the caller's array with the result, or the result.
  py::object take(const DoubleArray& result, bool is_float32) const {
    if (!out_.is_none()) {
      if (!is_in_place_ || py::array(out_).data() != result.data()) out_[py::ellipsis()] = result;
      return out_;
    }
    if (is_float32) return result.attr("astype")("float32");
    return result;
  }

 private:
  py::object out_;
  bool is_in_place_ = false;
};

struct Request {
  Points points;
  Target target;
  py::object progress;
};

// Names the first stroke whose path lines run away.
void refuse(std::span<const Vec3d> points, const Session& session, const ReplayOptions& options) {
  Mesh cloud;
  cloud.positions.assign(points.begin(), points.end());
  replay_watched(py::none(), cloud, session, options);
  require_done(AdvectStatus::step_limit, session, 0);
}

// Moves the points where they lie if they are the caller's `out`, else a copy. With a callback always a copy, so that
// nothing is written where it stops the work.
py::object move(const Request& request, const Accuracy& accuracy, const std::function<Flow()>& make_flow,
                const Session& session, const ReplayOptions& options) {
  const bool in_place = request.target.is_in_place() && request.progress.is_none();
  DoubleArray result = in_place ? request.points.array : array_of(request.points.span());
  const std::span<Vec3d> moved = span_of(result);
  Progress progress;
  AdvectStatus status = AdvectStatus::done;
  const bool is_done = run_watched(request.progress, progress, [&] {
    const Flow flow = make_flow();
    if (moved.empty()) return;
    progress.total = flow.segments.size() * moved.size();
    status = advect(flow, moved, advect_options_for(accuracy, moved, progress)).status;
  });
  if (!is_done) return py::none();
  if (status == AdvectStatus::step_limit) refuse(moved, session, options);
  return request.target.take(result, request.points.is_float32);
}

// Applies the session to a mesh, with all checks that need the faces.
py::object replay_on(const Request& request, const Session& session, const py::object& faces,
                     const ReplayOptions& options) {
  const Mesh mesh = mesh_from(request.points, faces);
  if (Replay(borrow(mesh), session, options).remeshes()) {
    throw InvalidInput("the session remeshes, so its result has other vertices and faces; use knead.remesh");
  }
  const std::optional<ReplayResult> replayed = replay_watched(request.progress, mesh, session, options);
  if (!replayed) return py::none();
  if (session.constraint) warn(replayed->warnings);
  return request.target.take(array_of(replayed->shape.positions()), request.points.is_float32);
}

// What Python gives to deform, whatever the session is.
struct Given {
  const py::object& vertices;
  SessionPart part;
  const py::object& progress;
  const py::object& out;
};

SessionPart part_from(bool inverse, std::optional<double> until) {
  return {inverse ? Direction::backwards : Direction::forwards, until};
}

py::object deform(const Given& given, const Session& session, const py::object& faces, const Accuracy& accuracy) {
  Points points = points_from(given.vertices, "vertices");
  Target target(given.out, points);
  const Request request{std::move(points), std::move(target), given.progress};
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.part = given.part;
  if (!faces.is_none() && needs_faces(session)) return replay_on(request, session, faces, options);
  const auto make_flow = [&] { return flow_of(session, options.part, accuracy.threads); };
  return move(request, accuracy, make_flow, session, options);
}

// Applies a session to a file with splats, and with the normals of points; returns the file that it becomes.
std::optional<ShapeFile> deform_file(const Given& given, const ShapeFile& file, const Session& session,
                                     const Accuracy& accuracy, std::optional<std::size_t> max_splats) {
  const Points points = points_from(given.vertices, "vertices");
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.part = given.part;
  ShapeFile whole = file;
  whole.mesh.positions.assign(points.span().begin(), points.span().end());
  if (whole.mesh.positions != file.mesh.positions) {
    whole = parse_shape(serialize_shape(file.format, file, points.span()), file.format, "shape." + file.format);
  }
  Progress progress;
  std::vector<std::string> notes;
  run_watched(py::none(), progress, [&] { split_splats(whole, session, options, max_splats, &notes); });
  warn(notes);
  if (whole.mesh.face_count() == 0) options.normals = vertex_normals_of(whole);
  const std::optional<ReplayResult> replayed = replay_watched(given.progress, whole.mesh, session, options);
  if (!replayed) return std::nullopt;
  const py::gil_scoped_release released;
  return parse_shape(serialize_deformed(file.format, whole, replayed->shape), file.format, "shape." + file.format);
}

// Applies a session to the points of a volume mesh, whose cells are judged, and whose patches may be walls.
py::object deform_volume(const Given& given, const Session& session, const py::object& faces, MeshParts& parts,
                         const Accuracy& accuracy) {
  Points points = points_from(given.vertices, "vertices");
  Target target(given.out, points);
  const Request request{std::move(points), std::move(target), given.progress};
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.part = given.part;
  options.strokes_warn = false;
  Progress progress;
  Session on_mesh;
  std::vector<std::string> notes;
  std::shared_ptr<const VolumeCells> cells = parts.cells;
  const bool has_walls = !session.walls.empty();
  const bool is_done = run_watched(has_walls ? given.progress : py::none(), progress, [&] {
    if (!cells) cells = std::make_shared<const VolumeCells>(parts.read_cells(has_walls, notes));
    on_mesh = on_walls(session, has_walls ? parts.patches() : std::vector<Patch>{}, request.points.span(),
                       {accuracy.threads, &progress, cells});
  });
  if (!is_done) return py::none();
  parts.cells = cells;
  warn(notes);
  if (!on_mesh.constraint) return deform(given, session, faces, accuracy);
  return replay_on(request, on_mesh, needs_faces(session) ? faces : py::none(), options);
}

Flow joined(Flow first, const Flow& second) {
  first.segments.insert(first.segments.end(), second.segments.begin(), second.segments.end());
  return first;
}

py::object move_by(const Flow& flow, const py::object& points, const Accuracy& accuracy, const py::object& progress,
                   const py::object& out) {
  Points given = points_from(points, "points");
  Target target(out, given);
  const Request request{std::move(given), std::move(target), progress};
  Session session;
  session.name = "flow";
  return move(request, accuracy, [&] { return flow; }, session, {});
}

// The places at n moments, evenly spaced in segments, start and end among them; 1: the end only. Whole segments are
// never cut, so that the end has the bits of the whole flow.
DoubleArray path_of(const Flow& flow, const py::object& points, int moments, const Accuracy& accuracy) {
  if (moments < 1) throw InvalidInput(fmt::format("the number of moments must be 1 or more, got {}", moments));
  const Points given = points_from(points, "points");
  const std::size_t count = given.span().size();
  DoubleArray result({static_cast<py::ssize_t>(moments), static_cast<py::ssize_t>(count), py::ssize_t{3}});
  auto* out = reinterpret_cast<Vec3d*>(result.mutable_data());
  Progress progress;
  AdvectStatus status = AdvectStatus::done;
  run_watched(py::none(), progress, [&] {
    if (count == 0) return;
    std::vector<Vec3d> now(given.span().begin(), given.span().end());
    const AdvectOptions options = advect_options_for(accuracy, now, progress);
    const auto length = static_cast<double>(flow.segments.size());
    double at = 0;
    for (int k = 0; k < moments && status == AdvectStatus::done; ++k) {
      const double moment = k + 1 == moments ? length : length * k / (moments - 1);
      const double whole = std::floor(moment);
      status = advect(flow_between(flow, at, whole), now, options).status;
      at = whole;
      const std::span<Vec3d> row(out + static_cast<std::size_t>(k) * count, count);
      std::copy(now.begin(), now.end(), row.begin());
      if (status == AdvectStatus::done) status = advect(flow_between(flow, whole, moment), row, options).status;
    }
  });
  Session session;
  session.name = "flow";
  require_done(status, session, 0);
  return result;
}

DoubleArray velocity_of(const Flow& flow, const py::object& points, double time) {
  const Points given = points_from(points, "points");
  std::vector<Vec3d> result;
  Progress progress;
  run_watched(py::none(), progress, [&] { result = velocities(flow, given.span(), time); });
  return array_of(result);
}

DoubleArray jacobian_of(const Flow& flow, const py::object& points, const Accuracy& accuracy) {
  const Points given = points_from(points, "points");
  std::vector<Mat3d> result;
  Progress progress;
  run_watched(py::none(), progress, [&] {
    if (!given.span().empty()) {
      result = jacobians(flow, given.span(), advect_options_for(accuracy, given.span(), progress));
    }
  });
  return array_of(result);
}

// --- derivatives with respect to parameters

struct DerivativeRequest {
  DerivativeRequest(double relative_tolerance, int threads, std::optional<double> diagonal)
      : options{relative_tolerance, diagonal, threads} {
    if (diagonal && !(*diagonal > 0 && std::isfinite(*diagonal))) {
      throw InvalidInput(fmt::format("diagonal must be a length above 0, got {}", *diagonal));
    }
  }
  DerivativeOptions options;
};

// Calls work(options, progress); returns whether it was not cancelled.
template <class Work>
bool differentiate(const DerivativeRequest& request, const py::object& callback, const Work& work) {
  Progress progress;
  DerivativeOptions options = request.options;
  options.progress = &progress;
  return run_watched(callback, progress, [&] { work(options, progress); });
}

py::object jvp(const Session& session, const py::object& points, const std::vector<double>& direction,
               const DerivativeRequest& request, const py::object& callback) {
  const Points given = points_from(points, "points");
  PointTangents result;
  const bool is_done = differentiate(request, callback, [&](const DerivativeOptions& options, Progress& progress) {
    const SessionDerivatives derivatives(session, {}, options.threads, &progress);
    progress.total = given.span().size() * derivatives.segments();
    result = derivatives.jvp(given.span(), direction, options);
  });
  if (!is_done) return py::none();
  return py::make_tuple(array_of(result.points), array_of(result.tangents));
}

py::object vjp(const Session& session, const py::object& points, const py::object& gradient,
               const DerivativeRequest& request, const py::object& callback) {
  const Points given = points_from(points, "points");
  const Points of_moved = points_from(gradient, "gradient");
  SessionGradient result;
  const bool is_done = differentiate(request, callback, [&](const DerivativeOptions& options, Progress& progress) {
    const SessionDerivatives derivatives(session, {}, options.threads, &progress);
    progress.total = given.span().size() * derivatives.segments();
    result = derivatives.vjp(given.span(), of_moved.span(), options);
  });
  if (!is_done) return py::none();
  return py::make_tuple(array_of(result.points), result.parameters);
}

// The shape of a segment's coefficients as an array; empty if it has none.
std::vector<py::ssize_t> coefficient_shape(const Segment& segment) {
  if (!segment.lattice.is_empty()) {
    const auto& [x, y, z] = segment.lattice.counts;
    return {x, y, z, 3};
  }
  if (segment.grid.is_empty()) return {};
  const auto& [x, y, z] = segment.grid.counts;
  if (segment.grid.end_coefficients.empty()) return {z, y, x, 3};
  return {2, z, y, x, 3};
}

FlowCoefficients coefficients_from(const Flow& flow, const py::object& direction) {
  const py::list given(direction);
  if (given.size() != flow.segments.size()) {
    throw InvalidInput(fmt::format("direction must have an array or None for each of the {} segments, got {}",
                                   flow.segments.size(), given.size()));
  }
  FlowCoefficients result;
  for (std::size_t i = 0; i < flow.segments.size(); ++i) {
    std::vector<Vec3d>& own = result.emplace_back();
    const std::vector<py::ssize_t> shape = coefficient_shape(flow.segments[i]);
    if (shape.empty() && given[i].is_none()) continue;
    const DoubleArray array = given[i].cast<DoubleArray>();
    if (shape != std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim())) {
      throw InvalidInput(
          fmt::format("direction {} must have the shape ({}), as vjp returns it", i, fmt::join(shape, ", ")));
    }
    for (py::ssize_t n = 0; n < array.size(); n += 3) {
      own.push_back({array.data()[n], array.data()[n + 1], array.data()[n + 2]});
    }
  }
  return result;
}

py::object flow_jvp(const Flow& flow, const py::object& points, const py::object& direction,
                    const DerivativeRequest& request, const py::object& callback) {
  const Points given = points_from(points, "points");
  const FlowCoefficients rates = coefficients_from(flow, direction);
  PointTangents result;
  const bool is_done = differentiate(request, callback, [&](const DerivativeOptions& options, Progress& progress) {
    progress.total = given.span().size() * flow.segments.size();
    result = coefficient_jvp(flow, given.span(), rates, options);
  });
  if (!is_done) return py::none();
  return py::make_tuple(array_of(result.points), array_of(result.tangents));
}

py::object flow_vjp(const Flow& flow, const py::object& points, const py::object& gradient,
                    const DerivativeRequest& request, const py::object& callback) {
  const Points given = points_from(points, "points");
  const Points of_moved = points_from(gradient, "gradient");
  CoefficientGradient result;
  const bool is_done = differentiate(request, callback, [&](const DerivativeOptions& options, Progress& progress) {
    progress.total = given.span().size() * flow.segments.size();
    result = coefficient_vjp(flow, given.span(), of_moved.span(), options);
  });
  if (!is_done) return py::none();
  py::list slopes;
  for (std::size_t i = 0; i < flow.segments.size(); ++i) {
    const std::vector<py::ssize_t> shape = coefficient_shape(flow.segments[i]);
    if (shape.empty()) {
      slopes.append(py::none());
    } else {
      slopes.append(array_of(result.coefficients[i]).reshape(shape));
    }
  }
  return py::make_tuple(array_of(result.points), slopes);
}

}  // namespace

void add_flow(py::module_& module) {
  py::class_<Accuracy>(module, "Accuracy")
      .def(py::init<double, std::string, std::string, int, std::optional<double>>());
  py::class_<Flow>(module, "Flow")
      .def(py::init([](const Session& session) { return flow_of(session); }))
      .def("move", &move_by)
      .def("inverse", [](const Flow& flow) { return inverse(flow); })
      .def("between", &flow_between)
      .def("path", &path_of)
      .def("velocity", &velocity_of)
      .def("jacobian", &jacobian_of)
      .def("joined", &joined)
      .def("__len__", [](const Flow& flow) { return flow.segments.size(); })
      .def("__eq__", [](const Flow& a, const Flow& b) { return a == b; });
  module.def("deform",
             [](const py::object& vertices, const Session& session, const py::object& faces, const Accuracy& accuracy,
                bool inverse, std::optional<double> until, const py::object& progress, const py::object& out) {
               return deform({vertices, part_from(inverse, until), progress, out}, session, faces, accuracy);
             });
  module.def("deform_file", [](const py::object& vertices, const ShapeFile& file, const Session& session,
                               const Accuracy& accuracy, bool inverse, std::optional<double> until,
                               const py::object& progress, std::optional<std::size_t> max_splats) {
    return deform_file({vertices, part_from(inverse, until), progress, py::none()}, file, session, accuracy,
                       max_splats);
  });
  module.def("deform_volume", [](const py::object& vertices, const Session& session, const py::object& faces,
                                 MeshParts& parts, const Accuracy& accuracy, bool inverse, std::optional<double> until,
                                 const py::object& progress, const py::object& out) {
    return deform_volume({vertices, part_from(inverse, until), progress, out}, session, faces, parts, accuracy);
  });
  py::class_<DerivativeRequest>(module, "DerivativeRequest").def(py::init<double, int, std::optional<double>>());
  module.def("jvp", &jvp);
  module.def("vjp", &vjp);
  module.def("flow_jvp", &flow_jvp);
  module.def("flow_vjp", &flow_vjp);
}

}  // namespace knead::python
