#include "knead/session/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/flow/simd.h"
#include "knead/io/large_pages.h"
#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/companions.h"
#include "knead/session/moved_shape.h"
#include "knead/session/replay_plan.h"
#include "knead/session/surface_stroke.h"
#include "knead/tool/barrel_members.h"

namespace knead {

namespace {

using session_detail::apply_on;
using session_detail::flow_between;
using session_detail::make_plan;
using session_detail::MovedShape;
using session_detail::MoveOptions;
using session_detail::place_of;
using session_detail::PlannedStroke;
using session_detail::Task;
using session_detail::TaskKind;

// Below it, relative to the diagonal, the rounding of float evaluation is what remains of the error.
constexpr double kFloatNoise = 1e-6;

// Of the diagonal: how far the companions of a normal are from their point, and the error of their path lines. Together
// they leave about 1e-5 of a normal's direction to rounding, and less to the flow's curvature.
constexpr double kCompanionReach = 1e-4;
constexpr double kCompanionTolerance = 1e-9;

void require(bool good, const std::string& message) {
  if (!good) throw InvalidInput(message);
}

std::string describe_refusal(const Barrel& barrel, const BarrelCheck& check) {
  std::string text = fmt::format("{} cross the cylinder of \"radius\" {} and would be torn; ",
                                 check.crossing == 1 ? "1 triangle would" : fmt::format("{} triangles", check.crossing),
                                 barrel.radius);
  const std::optional<double> nearest = nearest_radius(check, barrel.radius);
  if (!nearest) return text + "no other radius works: leave \"radius\" out";
  text += fmt::format("use \"radius\": {}, the nearest that works", *nearest);
  if (!check.smaller) return text + " (no smaller one does)";
  if (!check.larger) return text + " (no larger one does)";
  return text + fmt::format(" (on the other side {})", nearest == check.smaller ? *check.larger : *check.smaller);
}

MoveOptions move_options(const ReplayOptions& options, double diagonal) {
  MoveOptions result;
  result.vertices.tolerance = options.tolerance * diagonal;
  result.vertices.integrator = options.integrator;
  result.vertices.precision = options.precision;
  result.vertices.threads = options.threads;
  result.vertices.progress = options.progress;
  result.companions.tolerance = kCompanionTolerance * diagonal;
  result.companions.precision = Precision::float64;
  result.companions.threads = options.threads;
  result.companions.progress = options.progress;
  return result;
}

// Appends a resolved stroke; dabs of one brush become one stroke.
void append(const Stroke& stroke, std::size_t line, std::vector<SessionStroke>& resolved) {
  const auto* dab = std::get_if<PaintStroke>(&stroke);
  auto* last = resolved.empty() ? nullptr : std::get_if<PaintStroke>(&resolved.back().stroke);
  const bool joins = dab != nullptr && last != nullptr && resolved.back().line == line && last->outer == dab->outer &&
                     last->depth == dab->depth;
  if (joins) {
    last->samples.insert(last->samples.end(), dab->samples.begin(), dab->samples.end());
  } else {
    resolved.push_back({stroke, line});
  }
}

Flow without_cylinders(Flow flow) {
  for (Segment& segment : flow.segments) segment.cylinder.reset();
  return flow;
}

// Carries out a plan.
class Replayer {
 public:
  Replayer(const Mesh& mesh, const Session& session, const ReplayOptions& options)
      : mesh_(mesh), session_(session), options_(options), plan_(make_plan(session, options)) {
    simd_name();  // a wrong KNEAD_SIMD is refused here, as no stroke's fault
    const double diagonal = bounding_box(mesh.positions).diagonal();
    diagonal_ = diagonal > 0 ? diagonal : 1;
    move_ = move_options(options, diagonal_);
    const double tolerance = move_.vertices.tolerance;
    require(tolerance > 0 && std::isfinite(tolerance), "the tolerance and the shape's size leave no positive length");
    require(options.normals.empty() || options.normals.size() == mesh.positions.size(),
            "give a normal for each vertex");
  }

  ReplayResult run() {
    companions_ = companions_of(mesh_.positions, options_.normals, kCompanionReach * diagonal_);
    reserve_large(shape_.positions, mesh_.positions.size());
    shape_.positions = mesh_.positions;
    shape_.companions = companions_.points;
    if (!reads_own_surface()) shadow_ = shape_;
    describe_plan();
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
    const ReplayOptions usual;
    const bool is_usual = options_.tolerance == usual.tolerance && options_.integrator == usual.integrator &&
                          options_.precision == usual.precision;
    return is_usual || options_.inverse ||
           std::none_of(plan_.strokes.begin(), plan_.strokes.end(),
                        [](const PlannedStroke& stroke) { return reads_surface(stroke.source->stroke); });
  }

  MoveOptions shadow_move() const {
    ReplayOptions usual;
    usual.threads = options_.threads;
    usual.progress = options_.progress;
    return move_options(usual, diagonal_);
  }

  void describe_plan() {
    if (options_.precision == Precision::float32 && options_.tolerance < kFloatNoise) {
      result_.warnings.push_back(
          fmt::format("a tolerance of {} is below what single precision resolves ({}); use double precision",
                      options_.tolerance, kFloatNoise));
    }
    for (const PlannedStroke& stroke : plan_.strokes) {
      for (const std::string& warning : warnings(stroke.source->stroke)) warn(stroke, warning);
    }
  }

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
  }

  // Does the whole stroke ahead of the shape, for the segments that it becomes.
  void resolve(PlannedStroke& stroke) {
    MovedShape ahead = shadow_ ? *shadow_ : shape_;
    const MoveOptions move_ahead = shadow_ ? shadow_move() : move_;
    std::vector<SessionStroke>& resolved = result_.resolved;
    LiveSurface surface;
    surface.positions = ahead.positions;
    surface.triangles = triangles();
    if (!options_.normals.empty()) {
      surface.normals = [&] { return carried_normals(companions_, ahead.companions, options_.normals); };
    }
    surface.apply = [&](const Stroke& part) {
      Flow flow = flow_of(part);
      stroke.barrel = barrel_of(part);
      append(part, stroke.source->line, resolved);
      if (!stroke.barrel) move(flow, move_ahead, ahead);  // else after its check
      std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(stroke.flow.segments));
      return ahead.counts.status == AdvectStatus::done;
    };
    std::vector<std::string> remarks;
    try {
      const std::optional<double> penetration =
          apply_on(stroke.source->stroke, stroke.tool.get(), options_.threads, surface, remarks);
      if (penetration) result_.penetration = std::max(*penetration, result_.penetration.value_or(0));
    } catch (const InvalidInput& error) {
      throw InvalidInput(place_of(session_, *stroke.source), error.what());
    }
    for (const std::string& remark : remarks) warn(stroke, remark);
    shape_.counts.status = ahead.counts.status;
    if (stroke.barrel) return;
    (shadow_ ? shadow_ : ahead_) = std::move(ahead);
  }

  void check_barrel_of(const PlannedStroke& stroke) {
    if (!stroke.barrel) return;
    const BarrelCheck found = check_barrel(*stroke.barrel, shape_.positions, triangles());
    if (found.crossing > 0) {
      throw InvalidInput(place_of(session_, *stroke.source), describe_refusal(*stroke.barrel, found));
    }
    if (found.later > 0) {
      warn(stroke, fmt::format("{} triangles cross the cylinder of \"radius\" {} where the bend arrives later, and may "
                               "be torn; look there, or choose another radius",
                               found.later, stroke.barrel->radius));
    }
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
    options_.on_frame(frame_++, shape.positions, carried_normals(companions_, shape.companions, options_.normals));
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
  }

  const Mesh& mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  session_detail::Plan plan_;
  double diagonal_ = 1;
  MoveOptions move_;
  NormalCompanions companions_;
  std::vector<Triangle> triangles_;
  MovedShape shape_;
  double at_ = 0;                     // where the shape is within the stroke, in segments
  std::optional<MovedShape> shadow_;  // the shape at the default accuracy, where strokes read that
  std::optional<MovedShape> ahead_;   // after the whole of the stroke, where that is known
  std::optional<TakenBack> taken_back_;
  int frame_ = 0;
  ReplayResult result_;
};

}  // namespace

ReplayResult replay(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  return Replayer(mesh, session, options).run();
}

std::uint64_t total_work(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  std::uint64_t segments = 0;
  for (const Task& task : make_plan(session, options).tasks) segments += task.work;
  const auto carried = std::count_if(options.normals.begin(), options.normals.end(), has_direction);
  return segments * (mesh.positions.size() + 4 * static_cast<std::size_t>(carried));
}

}  // namespace knead
