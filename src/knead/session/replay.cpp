#include "knead/session/replay.h"

#include <algorithm>
#include <cmath>

#include "knead/flow/simd.h"
#include "knead/math/error.h"
#include "knead/math/large_pages.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/companions.h"
#include "knead/session/moved_shape.h"
#include "knead/session/replay_plan.h"
#include "knead/session/replay_remeshed.h"
#include "knead/session/replay_shared.h"
#include "knead/tool/barrel_members.h"

namespace knead {

namespace {

using session_detail::barrel_warning;
using session_detail::checked_diagonal;
using session_detail::flow_between;
using session_detail::is_usual;
using session_detail::make_plan;
using session_detail::move_options;
using session_detail::MovedShape;
using session_detail::MoveOptions;
using session_detail::place_of;
using session_detail::plan_warnings;
using session_detail::PlannedStroke;
using session_detail::read_surface;
using session_detail::SurfaceReading;
using session_detail::Task;
using session_detail::TaskKind;
using session_detail::usual;

// Of the diagonal: how far the companions of a normal are from their point. It leaves about 1e-5 of a normal's
// direction to the rounding of their path lines, and less to the flow's curvature.
constexpr double kCompanionReach = 1e-4;

void require(bool good, const std::string& message) {
  if (!good) throw InvalidInput(message);
}

Flow without_cylinders(Flow flow) {
  for (Segment& segment : flow.segments) segment.cylinder.reset();
  return flow;
}

// Carries out a plan.
class Replayer {
 public:
  Replayer(const Mesh& mesh, const Session& session, const ReplayOptions& options)
      : mesh_(mesh),
        session_(session),
        options_(options),
        plan_(make_plan(session, options)),
        diagonal_(checked_diagonal(mesh, options)),
        move_(move_options(options, diagonal_)) {
    simd_name();  // a wrong KNEAD_SIMD is refused here, as no stroke's fault
    require(options.normals.empty() || options.normals.size() == mesh.positions.size(),
            "give a normal for each vertex");
  }

  ReplayResult run() {
    companions_ = companions_of(mesh_.positions, options_.normals, kCompanionReach * diagonal_);
    reserve_large(shape_.positions, mesh_.positions.size());
    shape_.positions = mesh_.positions;
    shape_.companions = companions_.points;
    if (!reads_own_surface()) shadow_ = shape_;
    result_.warnings = plan_warnings(session_, options_, plan_);
    std::uint64_t work = 0;
    for (const Task& task : plan_.tasks) {
      carry_out(task);
      work += task.work;
      if (!is_done()) break;
      if (options_.progress != nullptr) options_.progress->done = work * points();
    }
    if (is_done()) take_result();
    return std::move(result_);
  }

 private:
  std::size_t points() const { return shape_.positions.size() + shape_.companions.size(); }

  bool is_done() const { return result_.status == AdvectStatus::done; }

  // What a stroke reads does not depend on how accurately the result is asked for, so that a session means the same,
  // and resolves to the same, at every accuracy. Where that is not the default a shadow of the shape goes along that
  // has it.
  bool reads_own_surface() const {
    return is_usual(options_) || options_.inverse ||
           std::none_of(plan_.strokes.begin(), plan_.strokes.end(),
                        [](const PlannedStroke& stroke) { return reads_surface(stroke.source->stroke); });
  }

  MoveOptions shadow_move() const { return move_options(usual(options_), diagonal_); }

  void warn(const PlannedStroke& stroke, const std::string& what) {
    result_.warnings.push_back(to_string(place_of(session_, *stroke.source)) + ": " + what);
  }

  void carry_out(const Task& task) {
    if (task.kind == TaskKind::still) {
      deliver(shape_);
      return;
    }
    PlannedStroke& stroke = plan_.strokes[task.stroke];
    if (task.kind == TaskKind::enter) enter(stroke);
    if (task.kind == TaskKind::frame) deliver_frame(stroke, task.at);
    if (task.kind == TaskKind::leave) leave(stroke, task.at);
    result_.status = shape_.counts.status;
    if (options_.progress != nullptr && options_.progress->cancel) result_.status = AdvectStatus::cancelled;
    if (result_.status == AdvectStatus::step_limit) result_.failed_line = stroke.source->line;
  }

  void take_result() {
    result_.steps = steps_of(shape_);
    result_.positions = std::move(shape_.positions);
    result_.accepted_steps = shape_.counts.accepted_steps;
    result_.rejected_steps = shape_.counts.rejected_steps;
    result_.evaluations = shape_.counts.evaluations;
    result_.normals = carried_normals(companions_, shape_.companions, options_.normals);
    result_.strokes = plan_.strokes.size();
    if (!options_.inverse) return;
    for (const PlannedStroke& stroke : plan_.strokes) result_.resolved.push_back(*stroke.source);
  }

  std::span<const Triangle> triangles() {
    if (triangles_.empty()) triangles_ = triangulate(mesh_);
    return triangles_;
  }

  void enter(PlannedStroke& stroke) {
    if (reads_surface(stroke.source->stroke)) resolve(stroke);
    at_ = options_.inverse ? stroke.segments() : 0;
    if (!options_.inverse) check_barrel_of(stroke);
    if (options_.on_stroke) before_ = shape_.positions;
  }

  // Does the whole stroke ahead of the shape, for the segments that it becomes.
  void resolve(PlannedStroke& stroke) {
    MovedShape ahead = shadow_ ? *shadow_ : shape_;
    std::function<std::vector<Vec3d>()> normals;
    if (!options_.normals.empty()) {
      normals = [&] { return carried_normals(companions_, ahead.companions, options_.normals); };
    }
    SurfaceReading reading =
        read_surface(session_, stroke, triangles(), normals, shadow_ ? shadow_move() : move_, ahead);
    stroke.flow = std::move(reading.flow);
    stroke.barrel = reading.barrel;
    std::move(reading.parts.begin(), reading.parts.end(), std::back_inserter(result_.resolved));
    if (reading.penetration) result_.penetration = std::max(*reading.penetration, result_.penetration.value_or(0));
    for (const std::string& remark : reading.remarks) warn(stroke, remark);
    shape_.counts.status = ahead.counts.status;
    if (stroke.barrel) return;
    (shadow_ ? shadow_ : ahead_) = std::move(ahead);
  }

  void check_barrel_of(const PlannedStroke& stroke) {
    const std::optional<std::string> warning = barrel_warning(session_, stroke, shape_.positions, triangles());
    if (warning) warn(stroke, *warning);
  }

  // Moves a shape from one moment of the stroke to another, in segments.
  void move_between(const PlannedStroke& stroke, double from, double to, MovedShape& shape) {
    Flow flow = flow_between(stroke.flow, from, to);
    if (!options_.inverse || !stroke.barrel) {
      move(flow, move_, shape);
      return;
    }
    const TakenBack& back = taken_back(stroke);
    MovedShape moved = to == 0 ? back.shape : shape;
    if (to != 0) move(without_cylinders(std::move(flow)), move_, moved);
    for (std::size_t i = 0; i < back.members.size(); ++i) {
      if (back.members[i]) shape.positions[i] = moved.positions[i];
    }
    for (std::size_t i = 0; i < moved.companions.size(); ++i) {
      if (back.members[companions_.vertex[i / 4]]) shape.companions[i] = moved.companions[i];
    }
    shape.counts = moved.counts;
    forget_blocks(shape);
    shape.earlier_steps = steps_of(moved);
  }

  // The shape as a stroke with a barrel, of one segment, leaves it backwards if everything moves, and what does.
  struct TakenBack {
    MovedShape shape;
    std::vector<bool> members;
  };

  // Of the stroke that is being undone. A cylinder is left out: which points it holds, barrel_members says.
  const TakenBack& taken_back(const PlannedStroke& stroke) {
    if (taken_back_) return *taken_back_;
    taken_back_ = TakenBack{shape_, {}};
    move(without_cylinders(flow_between(stroke.flow, stroke.segments(), 0)), move_, taken_back_->shape);
    const double slack = 10 * move_.vertices.tolerance + 1e-3 * stroke.barrel->radius;
    taken_back_->members =
        barrel_members(*stroke.barrel, shape_.positions, taken_back_->shape.positions, triangles(), slack);
    return *taken_back_;
  }

  // From one whole segment to the next is the same whether or not the points rest there, so frames in between begin at
  // the last.
  void deliver_frame(const PlannedStroke& stroke, double moment) {
    const double to = std::min(moment * static_cast<double>(stroke.flow.segments.size()), stroke.segments());
    advance(stroke, options_.inverse ? std::min(std::ceil(to), at_) : std::floor(to));
    if (shape_.counts.status != AdvectStatus::done) return;
    MovedShape frame = shape_;
    move_between(stroke, at_, to, frame);
    shape_.counts.status = frame.counts.status;
    if (shape_.counts.status == AdvectStatus::done) deliver(frame);
  }

  void deliver(const MovedShape& shape) {
    if (!options_.on_frame) return;
    const std::vector<Vec3d> normals = carried_normals(companions_, shape.companions, options_.normals);
    options_.on_frame({frame_++, shape.positions, normals});
  }

  void advance(const PlannedStroke& stroke, double to) {
    const bool is_known = ahead_ && at_ == 0 && to == static_cast<double>(stroke.flow.segments.size());
    if (is_known) {
      shape_ = std::move(*ahead_);
      ahead_.reset();
    } else if (shape_.counts.status == AdvectStatus::done) {
      move_between(stroke, at_, to, shape_);
    }
    at_ = to;
  }

  void leave(const PlannedStroke& stroke, double at) {
    advance(stroke, at * static_cast<double>(stroke.flow.segments.size()));
    result_.segments += static_cast<std::size_t>(std::ceil(stroke.segments()));
    ahead_.reset();
    taken_back_.reset();
    const bool shadow_is_behind = stroke.barrel || !reads_surface(stroke.source->stroke);
    if (shadow_ && shadow_is_behind) move(stroke.flow, shadow_move(), *shadow_);
    if (options_.inverse) {
      check_barrel_of(stroke);
    } else if (!reads_surface(stroke.source->stroke)) {
      result_.resolved.push_back(*stroke.source);
    }
    if (options_.on_stroke && shape_.counts.status == AdvectStatus::done) report_stroke(stroke);
  }

  void report_stroke(const PlannedStroke& stroke) const {
    const double segments = stroke.segments();
    const Flow flow = options_.inverse ? flow_between(stroke.flow, segments, 0) : prefix(stroke.flow, segments);
    options_.on_stroke({stroke.source->line, flow, {mesh_, before_}, {mesh_, shape_.positions}, nullptr});
  }

  const Mesh& mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  session_detail::Plan plan_;
  double diagonal_;
  MoveOptions move_;
  NormalCompanions companions_;
  std::vector<Triangle> triangles_;
  MovedShape shape_;
  double at_ = 0;                     // where the shape is within the stroke, in segments
  std::optional<MovedShape> shadow_;  // the shape at the default accuracy, where strokes read that
  std::optional<MovedShape> ahead_;   // after the whole of the stroke, where that is known
  std::optional<TakenBack> taken_back_;
  std::vector<Vec3d> before_;  // the positions at the stroke's beginning, for on_stroke
  int frame_ = 0;
  ReplayResult result_;
};

}  // namespace

namespace {

ReplayOptions without_backend(ReplayOptions options) {
  options.backend = nullptr;
  return options;
}

}  // namespace

ReplayResult replay(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  if (options.remesh) validate(*options.remesh);
  if (session_detail::remeshes(mesh, session, options)) {
    const ReplayOptions on_cpu = without_backend(options);
    ReplayResult result = session_detail::replay_remeshed(mesh, session, on_cpu);
    if (options.backend) result.warnings.push_back("a shape that is remeshed is moved on the CPU");
    return result;
  }
  ReplayResult result = Replayer(mesh, session, options).run();
  const std::optional<std::string> ignored = session_detail::ignored_remesh(mesh, session, options);
  if (ignored) result.warnings.push_back(*ignored);
  return result;
}

std::uint64_t total_work(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  std::uint64_t segments = 0;
  for (const Task& task : make_plan(session, options).tasks) segments += task.work;
  if (session_detail::remeshes(mesh, session, options) &&
      session_detail::reads_first(session, without_backend(options)))
    segments *= 2;
  const auto carried = std::count_if(options.normals.begin(), options.normals.end(), has_direction);
  return segments * (mesh.positions.size() + 4 * static_cast<std::size_t>(carried));
}

}  // namespace knead
