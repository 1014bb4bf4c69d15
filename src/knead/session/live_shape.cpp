#include "knead/session/live_shape.h"

#include <utility>

#include "knead/math/error.h"
#include "knead/session/replay_plan.h"
#include "knead/session/replay_remeshed.h"
#include "knead/session/replay_shared.h"

namespace knead::session_detail {

namespace {

ShapeState state_of(const std::shared_ptr<const RemeshedShape>& trail, Snapshot positions) {
  return {std::shared_ptr<const Mesh>(trail, &trail->mesh), std::move(positions), trail};
}

}  // namespace

bool are_same(const ShapeState& a, const ShapeState& b) {
  return a.trail == b.trail && a.positions.size() == b.positions.size() &&
         a.positions.changes_since(b.positions).empty();
}

LiveShape::LiveShape(Mesh mesh, const std::filesystem::path& folder, std::vector<std::uint32_t> face_labels,
                     int threads)
    : face_labels_(std::move(face_labels)) {
  if (mesh.vertex_count() == 0) throw InvalidInput("the shape has no vertices; open another one");
  session_.name = (folder / "session").string();
  replay_.threads = threads;
  diagonal_ = checked_diagonal(mesh, replay_);
  trail_ = std::make_shared<const RemeshedShape>(unmoved(mesh));
  base_ = state_of(trail_, Snapshot(mesh.positions, Snapshot(), threads));
  shape_.positions = std::move(mesh.positions);
  at_ = base_;
}

MoveOptions LiveShape::options(Progress* progress) const {
  ReplayOptions options = replay_;
  options.progress = progress;
  return move_options(options, diagonal_);
}

std::span<const Triangle> LiveShape::triangles() {
  if (triangulated_ != trail_) {
    triangles_ = triangulate(trail_->mesh);
    triangulated_ = trail_;
  }
  return triangles_;
}

void LiveShape::rest_at(const ShapeState& state, bool again) {
  if (!at_ || !are_same(*at_, state)) {
    if (kept_ && are_same(kept_->state, state)) {
      shape_ = kept_->shape;
    } else {
      shape_ = {};
      shape_.positions = state.positions.copy();
      if (again) shape_.blocks.emplace(shape_.positions);
    }
    trail_ = state.trail;
    at_ = state;
  }
  if (again && !(kept_ && are_same(kept_->state, state))) kept_ = Kept{state, shape_};
}

ShapeState LiveShape::state(const ShapeState& before) {
  if (!at_) at_ = state_of(trail_, Snapshot(shape_.positions, before.positions, replay_.threads));
  return *at_;
}

void LiveShape::move_by(const Flow& flow, const MoveOptions& options) {
  at_.reset();
  const std::uint64_t before = shape_.counts.accepted_steps;
  move(flow, options, shape_);
  steps_ += shape_.counts.accepted_steps - before;
}

AdvectStatus LiveShape::apply(const Flow& flow, Progress* progress) {
  move_by(flow, options(progress));
  return std::exchange(shape_.counts.status, AdvectStatus::done);
}

AdvectStatus LiveShape::apply(const SessionStroke& stroke, Progress* progress) {
  try {
    apply_planned(stroke, progress);
  } catch (const InvalidInput& error) {
    // Without the name of a file that there is not.
    const std::string message = error.what();
    const std::string prefix = to_string(place_of(session_, stroke)) + ": ";
    throw InvalidInput(message.starts_with(prefix) ? message.substr(prefix.size()) : message);
  }
  return std::exchange(shape_.counts.status, AdvectStatus::done);
}

void LiveShape::apply_planned(const SessionStroke& stroke, Progress* progress) {
  const MoveOptions move = options(progress);
  const bool remeshes = stroke.remesh && trail_->mesh.face_count() > 0;
  for (std::string& warning : knead::warnings(stroke.stroke)) warnings_.push_back(std::move(warning));
  const Flow flow = read(stroke, !remeshes, move);
  if (shape_.counts.status != AdvectStatus::done) return;
  if (remeshes) remesh(stroke, flow, move);
}

Flow LiveShape::read(const SessionStroke& stroke, bool may_move, const MoveOptions& options) {
  PlannedStroke planned = plan_stroke(session_, stroke, 1, false);
  const bool reads = reads_surface(stroke.stroke);
  if (reads) {
    if (trail_->renumbered) require_no_numbers(session_, stroke);
    MovedShape ahead;
    if (!may_move) ahead.positions = shape_.positions;
    MovedShape& shape = may_move ? shape_ : ahead;
    const std::uint64_t before = shape.counts.accepted_steps;
    at_.reset();
    SurfaceReading reading = read_surface(session_, planned, triangles(), {}, options, shape);
    steps_ += shape.counts.accepted_steps - before;
    shape_.counts.status = shape.counts.status;
    planned.flow = std::move(reading.flow);
    planned.barrel = reading.barrel;
    for (std::string& remark : reading.remarks) warnings_.push_back(std::move(remark));
    if (!reading.parts.empty()) part_ = std::move(reading.parts.back().stroke);
  }
  if (planned.barrel) {
    std::optional<std::string> warning = barrel_warning(session_, planned, shape_.positions, triangles());
    if (warning) warnings_.push_back(std::move(*warning));
  }
  if (may_move && (!reads || planned.barrel)) move_by(planned.flow, options);
  return planned.flow;
}

void LiveShape::remesh(const SessionStroke& stroke, const Flow& flow, const MoveOptions& options) {
  RemeshOptions how;
  how.targets = knead::resolve(*stroke.remesh, *base_.mesh);
  how.single_precision = replay_.single_precision;
  how.face_labels = face_labels_;
  how.threads = replay_.threads;
  RemeshedShape shape = *trail_;
  shape.mesh.positions = shape_.positions;
  shape.work = {};
  at_.reset();
  move_and_remesh(flow, options.vertices, how, shape);
  steps_ += shape.work.accepted_steps;
  shape_.counts.status = shape.work.status;
  if (shape.work.status != AdvectStatus::done) return;
  shape_ = {};
  shape_.positions = shape.mesh.positions;
  trail_ = std::make_shared<const RemeshedShape>(std::move(shape));
}

}  // namespace knead::session_detail
