// Judges what a step did to a surface, and chooses the next step.
#include "pose/sound_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "knead/error.h"

namespace knead::detail {

namespace {

constexpr double kMaxStepStretch = 2;  // of a triangle in one step: neighbours that move apart faster are torn
constexpr int kMaxHalvings = 5;
constexpr std::array kSpacings{1.0, 1.5, 0.7};  // in the order in which they are tried
constexpr int kMaxFailures = 24;                // of all steps together

// Takes a step and returns an empty text, or says why it is not sound. Only the first spacing must give equations that
// can be solved.
std::string tried(const SteppedMotion& motion, double from, double to, bool must_solve) {
  try {
    return motion.take(motion.solve(from, to));
  } catch (const InvalidInput& error) {
    if (must_solve) throw;
    return error.what();
  }
}

std::string at(const Vec3d& p) { return fmt::format("near [{:.4g}, {:.4g}, {:.4g}]", p.x, p.y, p.z); }

}  // namespace

SoundJudge::SoundJudge(std::span<const Vec3d> start, std::span<const Triangle> triangles, std::size_t max_new_crossings,
                       int threads, const Progress* progress)
    : start_(start.begin(), start.end()),
      triangles_(triangles.begin(), triangles.end()),
      max_new_crossings_(max_new_crossings),
      threads_(threads),
      progress_(progress) {}

StepProblem SoundJudge::problem_of(std::span<const Vec3d> before, std::span<const Vec3d> after,
                                   double max_stretch) const {
  std::vector<Triangle> moving;
  std::vector<bool> moves(triangles_.size(), false);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& t = triangles_[i];
    moves[i] = std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return after[v] != before[v]; });
    if (moves[i]) moving.push_back(t);
  }
  const SurfaceStretch whole = surface_stretch(moving, start_, after);
  const SurfaceStretch step = surface_stretch(moving, before, after);
  const bool is_torn = step.worst() > kMaxStepStretch;
  if (is_torn || whole.worst() > max_stretch) {
    const Triangle& worst = moving[is_torn ? step.worst_triangle : whole.worst_triangle];
    std::string text = is_torn ? "the shape would be torn "
                               : fmt::format("a triangle would be stretched or pressed {:.3g} times ", whole.worst());
    return {text + at(after[worst[0]]), {worst.begin(), worst.end()}};
  }
  return crossing_of(after, moves);
}

StepProblem SoundJudge::crossing_of(std::span<const Vec3d> next, const std::vector<bool>& moves) const {
  SelfIntersectionOptions options;
  options.threads = threads_;
  options.progress = progress_;
  options.chosen = &moves;
  const SelfIntersections found = self_intersections(triangles_, next, options);
  if (found.count == 0) return {};
  // Few triangles cross: only these are looked at as they were at the start.
  std::vector<bool> crosses(triangles_.size(), !found.complete);
  for (const auto& pair : found.pairs) crosses[pair[0]] = crosses[pair[1]] = true;
  options.chosen = &crosses;
  const SelfIntersections before = self_intersections(triangles_, start_, options);
  std::vector<bool> is_tangled(triangles_.size(), false);
  if (max_new_crossings_ > 0) {
    for (const auto& pair : before.pairs) is_tangled[pair[0]] = is_tangled[pair[1]] = true;
  }
  StepProblem problem;
  std::size_t count = found.complete && before.complete ? 0 : found.count;
  for (const auto& pair : found.pairs) {
    const bool is_old = std::binary_search(before.pairs.begin(), before.pairs.end(), pair);
    if (is_old || (is_tangled[pair[0]] && is_tangled[pair[1]])) continue;
    if (++count == 1) problem.text = ' ' + at(next[triangles_[pair[0]][0]]);
    for (const std::uint32_t t : pair) {
      problem.where.insert(problem.where.end(), triangles_[t].begin(), triangles_[t].end());
    }
  }
  if (count <= max_new_crossings_) return {};
  problem.text =
      fmt::format("{} would cross{}", count == 1 ? "1 pair of triangles" : fmt::format("{} pairs of triangles", count),
                  problem.text);
  return problem;
}

SoundSurface::SoundSurface(std::span<const Vec3d> positions, std::span<const Triangle> triangles, double max_stretch,
                           const AdvectOptions& options)
    : judge_(positions, triangles, 0, options.threads, options.progress),
      max_stretch_(max_stretch),
      now_(positions.begin(), positions.end()),
      options_(options),
      progress_(options.progress) {
  options_.progress = nullptr;
}

std::string SoundSurface::take(const PotentialGrid& grid) {
  stop_if_cancelled(progress_);
  Flow flow;
  flow.segments.emplace_back().grid = grid;
  std::vector<Vec3d> next = now_;
  if (advect(flow, next, options_).status != AdvectStatus::done) return "the flow would be too strong to follow";
  StepProblem problem = judge_.problem_of(now_, next, max_stretch_);
  if (problem.text.empty()) now_ = std::move(next);
  return std::move(problem.text);
}

SteppedMotion in_parts(SteppedMotion motion) {
  struct Solved {
    double from = 0;
    double to = 0;
    PotentialGrid grid;
  };
  const auto last = std::make_shared<std::optional<Solved>>();
  SteppedMotion result;
  result.solve = [last, solve = std::move(motion.solve)](double from, double to) {
    const bool is_part = *last && (*last)->from == from && from < to && to <= (*last)->to;
    if (!is_part) *last = Solved{from, to, solve(from, to)};
    return to < (*last)->to ? multiplied((*last)->grid, (to - from) / ((*last)->to - from)) : (*last)->grid;
  };
  result.take = std::move(motion.take);
  result.set_spacing = [last, set = std::move(motion.set_spacing)](double factor) {
    last->reset();
    set(factor);
  };
  return result;
}

SoundReach step_soundly(std::span<const double> times, const SteppedMotion& motion) {
  SoundReach reach{times.front(), {}};
  std::size_t next = 1;
  std::size_t spacing = 0;
  int halvings = 0;
  int failures = 0;
  while (next < times.size()) {
    const double planned = times[next] - times[next - 1];
    const double size = std::ldexp(planned, -halvings);
    const double to = times[next] - reach.time > 1.5 * size ? reach.time + size : times[next];
    std::string problem = tried(motion, reach.time, to, spacing == 0);
    if (problem.empty()) {
      reach.time = to;
      if (to != times[next]) continue;
      ++next;
      halvings = std::max(0, halvings - 1);
    } else if (planned == 0) {
      ++next;
    } else if (++failures < kMaxFailures && halvings < kMaxHalvings) {
      ++halvings;
    } else if (failures < kMaxFailures && spacing + 1 < kSpacings.size()) {
      motion.set_spacing(kSpacings[++spacing]);
      halvings = 0;
    } else {
      reach.problem = std::move(problem);
      return reach;
    }
  }
  return reach;
}

double take_soundly(const PotentialGrid& grid, const std::function<std::string(const PotentialGrid&)>& take) {
  for (int halvings = 0; halvings <= kMaxHalvings; ++halvings) {
    const double part = std::ldexp(1.0, -halvings);
    if (take(multiplied(grid, part)).empty()) return part;
  }
  return 0;
}

}  // namespace knead::detail
