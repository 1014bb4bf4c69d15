#include "knead/session/safe_until.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/math/error.h"
#include "knead/mesh/judged_cells.h"
#include "knead/tool/strain.h"

namespace knead {

namespace {

constexpr double kSamplesPerStroke = 16;
constexpr double kMostSamples = 256;
constexpr int kHalvings = 10;

double sample_count(double most) { return std::max(1.0, std::min(kMostSamples, std::ceil(kSamplesPerStroke * most))); }

// The points of a mesh after any part of a session.
class MovedPoints {
 public:
  MovedPoints(const Session& session, std::span<const Vec3d> points, const SafeCellsOptions& options)
      : session_(session), points_(points), options_(options) {
    advection_ = advect_options(options.motion, options.motion.diagonal.value_or(reference_length(points)));
    advection_.progress = options.progress;
  }

  // After a step limit the points as they were.
  std::vector<Vec3d> at(double until) {
    const Flow flow = flow_of(session_, {options_.part.direction, until}, options_.motion.threads);
    std::vector<Vec3d> moved(points_.begin(), points_.end());
    const AdvectStatus status = advect(flow, moved, advection_).status;
    stop_if_cancelled(options_.progress);
    if (status != AdvectStatus::done) status_ = status;
    return moved;
  }

  AdvectStatus status() const { return status_; }

 private:
  const Session& session_;
  std::span<const Vec3d> points_;
  const SafeCellsOptions& options_;
  AdvectOptions advection_;
  AdvectStatus status_ = AdvectStatus::done;
};

std::optional<double> outer_that_fits(const Session& session, const Cells& cells, MovedPoints& motion,
                                      const SafeUntil& range, const SafeCellsOptions& options) {
  const std::size_t number = strokes_before(range);
  const bool is_forwards = options.part.direction == Direction::forwards;
  const std::vector<Vec3d> points = motion.at(is_forwards ? static_cast<double>(number) : 0);
  std::vector<Vec3d> boundary;
  for (const std::uint32_t v : boundary_points(cells, points.size(), options.motion.threads)) {
    boundary.push_back(points[v]);
  }
  const SessionStroke& stroke = session.strokes[number];
  const double strength = std::max(1.0, stroke.strength);
  return widest_outer(strength > 1 ? prolonged(stroke.stroke, strength) : stroke.stroke, boundary,
                      options.motion.threads);
}

}  // namespace

SafeUntil safe_until(double most, const std::function<bool(double until)>& holds) {
  const double samples = sample_count(most);
  SafeUntil range{0, most};
  double sample = 1;
  for (; sample <= samples; ++sample) {
    const double until = most * (sample / samples);
    if (!holds(until)) {
      range.beyond = until;
      break;
    }
    range.until = until;
  }
  for (int i = 0; i < kHalvings && sample <= samples; ++i) {
    const double middle = range.until + (range.beyond - range.until) / 2;
    (holds(middle) ? range.until : range.beyond) = middle;
  }
  return range;
}

std::size_t strokes_before(const SafeUntil& range) {
  return static_cast<std::size_t>(std::max(0.0, std::ceil(range.beyond) - 1));
}

SafeCells safe_until(const Session& session, const Cells& cells, std::span<const Vec3d> points,
                     const SafeCellsOptions& options) {
  const double bound = options.least_scaled_jacobian;
  if (!(bound >= 0 && bound < 1)) throw InvalidInput("the least scaled Jacobian must be 0 or more, and below 1");
  const Session applied = without_off(session);
  const double most = options.part.until.value_or(static_cast<double>(applied.strokes.size()));
  flow_of(applied, {options.part.direction, most});  // refuses what is no flow, and a part out of range
  SafeCells result;
  if (points.empty()) {
    result.range = {most, most};
    return result;
  }
  if (options.progress != nullptr) {
    const auto calls = static_cast<std::uint64_t>(sample_count(most)) + kHalvings;
    options.progress->total = calls * points.size() * std::max<std::uint64_t>(1, flow_of(applied).segments.size()) / 2;
  }
  MovedPoints motion(applied, points, options);
  const JudgedCells judged(cells, points, options.motion.threads, options.progress);
  const auto spoiled = [&](double until) { return judged.worst_spoiled(motion.at(until), bound); };
  result.range = safe_until(most, [&](double until) {
    const std::optional<WorstCell> worst = spoiled(until);
    if (!worst) return true;
    result.cell = worst->cell;
    result.scaled_jacobian = worst->scaled_jacobian;
    return false;
  });
  result.status = motion.status();
  if (result.cell && result.status == AdvectStatus::done)
    result.outer = outer_that_fits(applied, cells, motion, result.range, options);
  return result;
}

}  // namespace knead
