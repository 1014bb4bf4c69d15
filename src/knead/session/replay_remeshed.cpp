#include "knead/session/replay_remeshed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/flow/simd.h"
#include "knead/math/error.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/remeshed_shape.h"
#include "knead/session/replay_shared.h"

namespace knead::session_detail {

namespace {

std::size_t applied_strokes(const Session& session, const ReplayOptions& options) {
  const auto all = static_cast<double>(session.strokes.size());
  const double until = options.until.value_or(all);
  return until >= 0 ? static_cast<std::size_t>(std::ceil(std::min(until, all))) : 0;  // else make_plan refuses it
}

bool has_settings(const Session& session, const ReplayOptions& options) {
  const auto begin = session.strokes.begin();
  return std::any_of(begin, begin + static_cast<std::ptrdiff_t>(applied_strokes(session, options)),
                     [&](const SessionStroke& stroke) { return settings_of(stroke, options).has_value(); });
}

// Carries out a plan, remeshing after each stroke that has settings.
class RemeshingReplayer {
 public:
  RemeshingReplayer(const Mesh& mesh, const Session& session, const ReplayOptions& options, std::uint64_t done_before)
      : mesh_(mesh),
        session_(session),
        options_(options),
        done_before_(done_before),
        plan_(make_plan(session, options)),
        move_(move_options(options, checked_diagonal(mesh, options))) {
    simd_name();  // a wrong KNEAD_SIMD is refused here, as no stroke's fault
    if (!options.normals.empty()) throw InvalidInput("normals are given for a shape without faces only");
    if (!options.face_labels.empty() && options.face_labels.size() != mesh.face_count()) {
      throw InvalidInput("give a label for each face");
    }
    for (const PlannedStroke& stroke : plan_.strokes) remesh_options_.push_back(remesh_options(stroke));
    shape_ = unmoved(mesh);
    triangles_ = triangulate(mesh);
  }

  // Strokes that read the surface find it as these readings say, one for each stroke.
  void take_readings(std::vector<SurfaceReading> readings) {
    readings_ = std::move(readings);
    are_given_ = true;
  }
  std::vector<SurfaceReading> readings() { return std::move(readings_); }

  ReplayResult run() {
    result_.warnings = plan_warnings(session_, options_, plan_);
    if (!are_given_) readings_.resize(plan_.strokes.size());
    std::uint64_t work = 0;
    for (const Task& task : plan_.tasks) {
      carry_out(task);
      work += task.work;
      if (result_.status != AdvectStatus::done) break;
      if (options_.progress != nullptr) options_.progress->done = done_before_ + work * mesh_.vertex_count();
    }
    if (result_.status == AdvectStatus::done) take_result();
    return std::move(result_);
  }

 private:
  std::optional<RemeshOptions> remesh_options(const PlannedStroke& stroke) const {
    const std::optional<RemeshSettings>& settings = settings_of(*stroke.source, options_);
    if (!settings) return std::nullopt;
    RemeshOptions options;
    try {
      options.targets = knead::resolve(*settings, mesh_);
    } catch (const InvalidInput& error) {
      throw InvalidInput(place_of(session_, *stroke.source), error.what());
    }
    options.single_precision = options_.single_precision;
    options.face_labels = options_.face_labels;
    options.threads = options_.threads;
    return options;
  }

  void carry_out(const Task& task) {
    if (task.kind == TaskKind::still) {
      deliver(shape_);
      return;
    }
    PlannedStroke& stroke = plan_.strokes[task.stroke];
    if (task.kind == TaskKind::enter) enter(stroke, task.stroke);
    if (task.kind == TaskKind::frame) deliver_frame(task);
    if (task.kind == TaskKind::leave) leave(task);
    if (options_.progress != nullptr && options_.progress->cancel) result_.status = AdvectStatus::cancelled;
    if (result_.status == AdvectStatus::step_limit) result_.failed_line = stroke.source->line;
  }

  void enter(PlannedStroke& stroke, std::size_t index) {
    if (reads_surface(stroke.source->stroke)) {
      if (!are_given_) readings_[index] = read(stroke);
      const SurfaceReading& reading = readings_[index];
      stroke.flow = reading.flow;
      stroke.barrel = reading.barrel;
      result_.resolved.insert(result_.resolved.end(), reading.parts.begin(), reading.parts.end());
      if (reading.penetration) result_.penetration = std::max(*reading.penetration, result_.penetration.value_or(0));
      for (const std::string& remark : reading.remarks) warn(stroke, remark);
    } else {
      result_.resolved.push_back(*stroke.source);
    }
    if (result_.status != AdvectStatus::done) return;
    const std::optional<std::string> warning = barrel_warning(session_, stroke, shape_.mesh.positions, triangles_);
    if (warning) warn(stroke, *warning);
  }

  SurfaceReading read(const PlannedStroke& stroke) {
    if (shape_.renumbered) require_no_numbers(session_, *stroke.source);
    MovedShape ahead;
    ahead.positions = shape_.mesh.positions;
    SurfaceReading reading = read_surface(session_, stroke, triangles_, {}, move_, ahead);
    result_.status = ahead.counts.status;
    return reading;
  }

  void warn(const PlannedStroke& stroke, const std::string& what) {
    result_.warnings.push_back(to_string(place_of(session_, *stroke.source)) + ": " + what);
  }

  // The flow of a stroke from its beginning to a moment of it, as far as it is to be done.
  Flow flow_until(const PlannedStroke& stroke, double moment) const {
    return prefix(stroke.flow, std::min(moment * static_cast<double>(stroke.flow.segments.size()), stroke.segments()));
  }

  void deliver_frame(const Task& task) {
    RemeshedShape frame = shape_;
    move_and_remesh(flow_until(plan_.strokes[task.stroke], task.at), move_.vertices, remesh_options_[task.stroke],
                    frame);
    result_.status = frame.work.status;
    if (result_.status == AdvectStatus::done) deliver(frame);
  }

  void deliver(const RemeshedShape& shape) {
    if (!options_.on_frame) return;
    options_.on_frame({frame_++, shape.mesh.positions, {}, &shape.mesh, shape.face_source});
  }

  void leave(const Task& task) {
    const PlannedStroke& stroke = plan_.strokes[task.stroke];
    const Flow flow = flow_until(stroke, task.at);
    Mesh before;
    if (options_.on_stroke) before = shape_.mesh;
    const std::optional<Remeshed> remeshed =
        move_and_remesh(flow, move_.vertices, remesh_options_[task.stroke], shape_);
    if (remeshed) triangles_ = triangulate(shape_.mesh);
    result_.status = shape_.work.status;
    result_.segments += static_cast<std::size_t>(std::ceil(stroke.segments()));
    if (!options_.on_stroke || result_.status != AdvectStatus::done) return;
    options_.on_stroke({stroke.source->line,
                        flow,
                        {before, before.positions},
                        {shape_.mesh, shape_.mesh.positions},
                        remeshed ? &*remeshed : nullptr});
  }

  void take_result() {
    result_.positions = shape_.mesh.positions;
    result_.mesh = std::move(shape_.mesh);
    result_.face_source = std::move(shape_.face_source);
    result_.vertex_source = std::move(shape_.vertex_source);
    result_.touched = std::move(shape_.touched);
    result_.remesh = shape_.counts;
    result_.steps = std::move(shape_.steps);
    result_.accepted_steps = shape_.work.accepted_steps;
    result_.rejected_steps = shape_.work.rejected_steps;
    result_.evaluations = shape_.work.evaluations;
    result_.strokes = plan_.strokes.size();
  }

  const Mesh& mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  std::uint64_t done_before_ = 0;  // progress
  Plan plan_;
  MoveOptions move_;
  std::vector<std::optional<RemeshOptions>> remesh_options_;  // for each planned stroke
  std::vector<SurfaceReading> readings_;                      // for each planned stroke; empty where it reads nothing
  bool are_given_ = false;
  RemeshedShape shape_;
  std::vector<Triangle> triangles_;  // of its faces, cut where they came about: a polygon is always cut the same way
  int frame_ = 0;
  ReplayResult result_;
};

}  // namespace

// A vertex's number means nothing once the vertices have other numbers.
void require_no_numbers(const Session& session, const SessionStroke& source) {
  const auto* handles = std::get_if<HandlesStroke>(&source.stroke);
  if (handles == nullptr || (handles->full_vertices.empty() && handles->zero_vertices.empty())) return;
  const bool full = !handles->full_vertices.empty();
  throw InvalidInput(place_of(session, source),
                     fmt::format("\"{}\" names vertices whose numbers the remeshing of an earlier stroke has changed; "
                                 "name points instead, with \"{}\"",
                                 full ? "full_vertices" : "zero_vertices", full ? "full" : "zero"));
}

const std::optional<RemeshSettings>& settings_of(const SessionStroke& stroke, const ReplayOptions& options) {
  return stroke.remesh ? stroke.remesh : options.remesh;
}

bool remeshes(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  return mesh.face_count() > 0 && !options.inverse && has_settings(session, options);
}

std::optional<std::string> ignored_remesh(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  if (!has_settings(session, options)) return std::nullopt;
  if (options.inverse) {
    return "backwards the vertices are taken back and nothing is remeshed: the shape keeps the vertices and faces that "
           "it has";
  }
  if (mesh.face_count() == 0)
    return "a point cloud has no mesh that could be remeshed; its points are moved as they are";
  return std::nullopt;
}

bool reads_first(const Session& session, const ReplayOptions& options) {
  const auto begin = session.strokes.begin();
  return !is_usual(options) &&
         std::any_of(begin, begin + static_cast<std::ptrdiff_t>(applied_strokes(session, options)),
                     [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); });
}

ReplayResult replay_remeshed(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  if (!reads_first(session, options)) return RemeshingReplayer(mesh, session, options, 0).run();
  const ReplayOptions reading_options = usual(options);
  RemeshingReplayer first(mesh, session, reading_options, 0);
  ReplayResult result = first.run();
  if (result.status != AdvectStatus::done) return result;
  RemeshingReplayer second(mesh, session, options, options.progress != nullptr ? options.progress->done.load() : 0);
  second.take_readings(first.readings());
  return second.run();
}

}  // namespace knead::session_detail
