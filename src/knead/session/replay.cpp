#include "knead/session/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/companions.h"
#include "knead/tool/barrel.h"
#include "knead/tool/barrel_members.h"

namespace knead {

namespace {

// Below it, relative to the diagonal, the rounding of float evaluation is what remains of the error.
constexpr double kFloatNoise = 1e-6;

// Of the diagonal: how far the companions of a normal are from their point, and the error of their path lines. Together
// they leave about 1e-5 of a normal's direction to rounding, and less to the flow's curvature.
constexpr double kCompanionReach = 1e-4;
constexpr double kCompanionTolerance = 1e-9;

void require(bool good, const std::string& message) {
  if (!good) throw InvalidInput(message);
}

double checked_until(const Session& session, const ReplayOptions& options) {
  const auto strokes = static_cast<double>(session.strokes.size());
  const double until = options.until.value_or(strokes);
  require(std::isfinite(options.tolerance) && options.tolerance > 0,
          fmt::format("the tolerance must be a number greater than 0, got {}", options.tolerance));
  require(until >= 0 && until <= strokes,
          fmt::format("\"until\" must be from 0 to the session's number of strokes ({}), got {}", strokes, until));
  require(options.frames >= 0, fmt::format("the number of frames must be 0 or more, got {}", options.frames));
  require(options.threads >= 0, fmt::format("the number of threads must be 0 (all) or more, got {}", options.threads));
  return until;
}

Place place_of(const Session& session, const SessionStroke& stroke) { return {session.name, stroke.line}; }

// A stroke that is applied, wholly or in part.
struct PlannedStroke {
  const SessionStroke* source = nullptr;
  Flow flow;
  double part = 1;  // of its segments, from the first on
  std::optional<Barrel> barrel;

  double segments() const { return part * static_cast<double>(flow.segments.size()); }
};

// What is done one after the other. A frame moves a copy of the points, an advance the points themselves, from one
// moment of the stroke, in segments, to another.
enum class TaskKind { check_barrel, frame, advance };

struct Task {
  TaskKind kind = TaskKind::advance;
  std::size_t stroke = 0;
  double from = 0;
  double to = 0;
};

struct Plan {
  std::vector<PlannedStroke> strokes;
  std::vector<Task> tasks;
};

std::vector<PlannedStroke> plan_strokes(const Session& session, double until) {
  std::vector<PlannedStroke> strokes;
  for (std::size_t i = 0; static_cast<double>(i) < until; ++i) {
    const SessionStroke& source = session.strokes[i];
    try {
      Flow flow = flow_of(source.stroke);
      validate(flow);
      strokes.push_back(
          {&source, std::move(flow), std::min(1.0, until - static_cast<double>(i)), barrel_of(source.stroke)});
    } catch (const InvalidInput& error) {
      throw InvalidInput(place_of(session, source), error.what());
    }
  }
  return strokes;
}

// The moments of the frames in strokes of the session, in the order of their delivery.
std::vector<double> frame_moments(const ReplayOptions& options, double until) {
  std::vector<double> moments;
  for (int k = 0; k < options.frames; ++k) {
    const double done = options.frames == 1 || k + 1 == options.frames ? until : until * k / (options.frames - 1);
    moments.push_back(options.inverse ? until - done : done);
  }
  return moments;
}

// Every frame is reached from the points at an end of its own stroke, never from the frame before it: whether a point
// belongs to a cylinder is known there only, and frames do not change the result.
Plan make_plan(const Session& session, const ReplayOptions& options) {
  const double until = checked_until(session, options);
  Plan plan{plan_strokes(session, until), {}};
  const std::vector<double> moments = frame_moments(options, until);
  auto moment = moments.begin();
  const std::size_t count = plan.strokes.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = options.inverse ? count - 1 - k : k;
    const PlannedStroke& stroke = plan.strokes[i];
    const auto begin = static_cast<double>(i);
    const double from = options.inverse ? stroke.segments() : 0;
    if (!options.inverse) plan.tasks.push_back({TaskKind::check_barrel, i});
    for (; moment != moments.end() && (options.inverse ? *moment > begin : *moment < begin + stroke.part); ++moment) {
      const double to =
          std::min((*moment - begin) * static_cast<double>(stroke.flow.segments.size()), stroke.segments());
      plan.tasks.push_back({TaskKind::frame, i, from, to});
    }
    plan.tasks.push_back({TaskKind::advance, i, from, options.inverse ? 0 : stroke.segments()});
    if (options.inverse) plan.tasks.push_back({TaskKind::check_barrel, i});
  }
  for (; moment != moments.end(); ++moment) plan.tasks.push_back({TaskKind::frame});
  return plan;
}

std::size_t segment_count(const Task& task) {
  const double first = std::floor(std::min(task.from, task.to));
  return task.from == task.to ? 0 : static_cast<std::size_t>(std::ceil(std::max(task.from, task.to)) - first);
}

// The flow from one moment to another, in segments; backwards where to < from. The segments are whole ones.
Flow flow_between(const Flow& flow, double from, double to) {
  if (from == to) return {};
  if (to < from) return inverse(flow_between(flow, to, from));
  Flow part = prefix(flow, to);
  const double whole = std::floor(from);
  part.segments.erase(part.segments.begin(), part.segments.begin() + static_cast<std::ptrdiff_t>(whole));
  part.segments.front().begin = from - whole;
  return part;
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

// Carries out a plan.
class Replayer {
 public:
  Replayer(const Mesh& mesh, const Session& session, const ReplayOptions& options)
      : mesh_(mesh), session_(session), options_(options), plan_(make_plan(session, options)) {
    const double diagonal = bounding_box(mesh.positions).diagonal();
    tolerance_ = options.tolerance * (diagonal > 0 ? diagonal : 1);
    require(tolerance_ > 0 && std::isfinite(tolerance_), "the tolerance and the shape's size leave no positive length");
    require(options.normals.empty() || options.normals.size() == mesh.positions.size(),
            "give a normal for each vertex");
    diagonal_ = diagonal > 0 ? diagonal : 1;
  }

  ReplayResult run() {
    result_.positions = mesh_.positions;
    result_.steps.assign(mesh_.positions.size(), 0);
    companions_ = companions_of(mesh_.positions, options_.normals, kCompanionReach * diagonal_);
    moved_companions_ = companions_.points;
    describe_plan();
    for (const Task& task : plan_.tasks) {
      if (task.kind == TaskKind::check_barrel) check(plan_.strokes[task.stroke]);
      if (task.kind == TaskKind::frame) deliver_frame(task);
      if (task.kind == TaskKind::advance) advance(task);
      if (options_.progress != nullptr && options_.progress->cancel) result_.status = AdvectStatus::cancelled;
      if (result_.status == AdvectStatus::step_limit) result_.failed_line = plan_.strokes[task.stroke].source->line;
      if (result_.status != AdvectStatus::done) break;
    }
    if (result_.status != AdvectStatus::done) {
      result_.positions.clear();
    } else {
      result_.normals = carried_normals(companions_, moved_companions_, options_.normals);
    }
    return std::move(result_);
  }

 private:
  void describe_plan() {
    if (options_.precision == Precision::float32 && options_.tolerance < kFloatNoise) {
      result_.warnings.push_back(
          fmt::format("a tolerance of {} is below what single precision resolves ({}); use double precision",
                      options_.tolerance, kFloatNoise));
    }
    result_.strokes = plan_.strokes.size();
    for (const PlannedStroke& stroke : plan_.strokes) {
      result_.resolved.push_back(*stroke.source);
      for (const std::string& warning : warnings(stroke.source->stroke)) warn(stroke, warning);
    }
  }

  void warn(const PlannedStroke& stroke, const std::string& what) {
    result_.warnings.push_back(to_string(place_of(session_, *stroke.source)) + ": " + what);
  }

  // At the stroke's start.
  void check(const PlannedStroke& stroke) {
    if (!stroke.barrel) return;
    if (triangles_.empty()) triangles_ = triangulate(mesh_);
    const BarrelCheck found = check_barrel(*stroke.barrel, result_.positions, triangles_);
    if (found.crossing > 0) {
      throw InvalidInput(place_of(session_, *stroke.source), describe_refusal(*stroke.barrel, found));
    }
    if (found.later > 0) {
      warn(stroke, fmt::format("{} triangles cross the cylinder of \"radius\" {} where the bend arrives later, and may "
                               "be torn; look there, or choose another radius",
                               found.later, stroke.barrel->radius));
    }
  }

  // Backwards a cylinder is left out: which points it holds, barrel_members says.
  Flow flow_for(const Task& task) const {
    Flow flow = flow_between(plan_.strokes[task.stroke].flow, task.from, task.to);
    if (options_.inverse) {
      for (Segment& segment : flow.segments) segment.cylinder.reset();
    }
    return flow;
  }

  AdvectResult move(const Task& task, std::span<Vec3d> points, std::span<std::uint32_t> steps) const {
    if (plan_.strokes.empty()) return {};
    AdvectOptions options;
    options.tolerance = tolerance_;
    options.integrator = options_.integrator;
    options.precision = options_.precision;
    options.threads = options_.threads;
    options.progress = options_.progress;
    options.steps = steps;
    return advect(flow_for(task), points, options);
  }

  // Backwards, a cylinder's members are those that `members` holds (null: the stroke has none).
  AdvectStatus move_companions(const Task& task, std::span<Vec3d> points, const std::vector<bool>* members) const {
    if (plan_.strokes.empty() || points.empty()) return AdvectStatus::done;
    const std::vector<Vec3d> before(points.begin(), points.end());
    AdvectOptions options;
    options.tolerance = kCompanionTolerance * diagonal_;
    options.precision = Precision::float64;
    options.threads = options_.threads;
    options.progress = options_.progress;
    const AdvectStatus status = advect(flow_for(task), points, options).status;
    for (std::size_t k = 0; members != nullptr && k < companions_.vertex.size(); ++k) {
      if ((*members)[companions_.vertex[k]]) continue;
      for (std::size_t i = 4 * k; i < 4 * k + 4; ++i) points[i] = before[i];
    }
    return status;
  }

  void count(const AdvectResult& moved) {
    result_.status = moved.status;
    result_.accepted_steps += moved.accepted_steps;
    result_.rejected_steps += moved.rejected_steps;
    result_.evaluations += moved.evaluations;
  }

  // A stroke with a barrel, taken back wholly.
  struct TakenBack {
    std::vector<Vec3d> positions;
    std::vector<bool> members;
  };

  bool is_taken_back_within_a_barrel(const Task& task) const {
    return options_.inverse && !plan_.strokes.empty() && plan_.strokes[task.stroke].barrel;
  }

  // Of the task's stroke; kept until the stroke's advance has used it.
  const TakenBack& taken_back(const Task& task) {
    if (taken_back_) return *taken_back_;
    const PlannedStroke& stroke = plan_.strokes[task.stroke];
    taken_back_ = TakenBack{result_.positions, {}};
    const Task whole{TaskKind::advance, task.stroke, stroke.segments(), 0};
    count(move(whole, taken_back_->positions, result_.steps));
    if (triangles_.empty()) triangles_ = triangulate(mesh_);
    const double slack = 10 * tolerance_ + 1e-3 * stroke.barrel->radius;
    taken_back_->members = barrel_members(*stroke.barrel, result_.positions, taken_back_->positions, triangles_, slack);
    return *taken_back_;
  }

  void advance(const Task& task) {
    result_.segments += segment_count(task);
    if (!is_taken_back_within_a_barrel(task)) {
      count(move(task, result_.positions, result_.steps));
      if (result_.status == AdvectStatus::done) result_.status = move_companions(task, moved_companions_, nullptr);
      return;
    }
    const TakenBack& back = taken_back(task);
    for (std::size_t i = 0; i < back.members.size(); ++i) {
      if (back.members[i]) result_.positions[i] = back.positions[i];
    }
    if (result_.status == AdvectStatus::done) result_.status = move_companions(task, moved_companions_, &back.members);
    taken_back_.reset();
  }

  void deliver_frame(const Task& task) {
    std::vector<Vec3d> points = result_.positions;
    std::vector<Vec3d> companions = moved_companions_;
    const std::vector<bool>* members = nullptr;
    if (is_taken_back_within_a_barrel(task)) members = &taken_back(task).members;
    if (result_.status != AdvectStatus::done) return;
    result_.status = move(task, points, {}).status;
    for (std::size_t i = 0; members != nullptr && i < points.size(); ++i) {
      if (!(*members)[i]) points[i] = result_.positions[i];
    }
    if (result_.status == AdvectStatus::done) result_.status = move_companions(task, companions, members);
    if (result_.status != AdvectStatus::done || !options_.on_frame) return;
    options_.on_frame(frame_++, points, carried_normals(companions_, companions, options_.normals));
  }

  const Mesh& mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  Plan plan_;
  double tolerance_ = 0;
  double diagonal_ = 1;
  NormalCompanions companions_;
  std::vector<Vec3d> moved_companions_;
  std::vector<Triangle> triangles_;
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
  for (const Task& task : make_plan(session, options).tasks) segments += segment_count(task);
  const auto carried = std::count_if(options.normals.begin(), options.normals.end(), has_direction);
  return segments * (mesh.positions.size() + 4 * static_cast<std::size_t>(carried));
}

}  // namespace knead
