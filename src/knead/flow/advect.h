// Moving points along the path lines of a flow.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "knead/flow/point_blocks.h"
#include "knead/flow/segment.h"
#include "knead/flow/tableau.h"

namespace knead {

// The scalar in which fields are evaluated. Positions are double in both: evaluation is about the tool's centre, and
// displacements are added.
enum class Precision { float32, float64 };

// Shared with whoever watches: set `cancel` from any thread; `done` counts points times segments.
struct Progress {
  std::atomic<bool> cancel{false};
  std::atomic<std::uint64_t> done{0};
};

// The tolerance relative to the shape's size that everything with such a setting takes by default.
inline constexpr double kDefaultRelativeTolerance = 1e-5;

// Returns relative_tolerance * diagonal, a length for AdvectOptions::tolerance. `diagonal` is that of the shape's
// bounding box. Throws InvalidInput unless relative_tolerance is a finite number above 0 and the product a finite
// length above 0.
double absolute_tolerance(double relative_tolerance, double diagonal);

struct AdvectOptions {
  // Position error of one path line over one segment: a length above 0, which depends on the shape's size and so has no
  // default. absolute_tolerance() gives one.
  double tolerance = 0;
  Integrator integrator = Integrator::tsitouras;
  Precision precision = Precision::float32;
  int threads = 0;  // 0: all
  Progress* progress = nullptr;
  std::span<std::uint32_t> steps{};  // empty, or one per point, to which the accepted steps are added
};

// Throws InvalidInput unless `tolerance` is a finite length above 0, and `steps` empty or of one number for each point.
void validate(const AdvectOptions& options, std::size_t points);

enum class AdvectStatus { done, cancelled, step_limit };

struct AdvectResult {
  AdvectStatus status = AdvectStatus::done;
  std::uint64_t accepted_steps = 0;
  std::uint64_t rejected_steps = 0;
  std::uint64_t evaluations = 0;  // of v, over all path lines

  AdvectResult& operator+=(const AdvectResult& other);
};

// Moves every point along its path line from the flow's begin to its end, in place. The result of a point depends on
// that point alone, to the bit: not on the number of threads nor on the other points. A point that no tool touches
// keeps its bits. Points must be finite. Cost: about 0.2 us a step and field evaluation of the integrator's stages;
// points outside cost a distance. Throws InvalidInput as validate(flow), or for a tolerance that is not positive. On
// `cancelled` and `step_limit` (a path line needed over a million steps, for instance because it runs to infinity far
// out in a bend's slab) the points are left part-way: keep a copy.
AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

// The same for points that are moved again and again: what a tool does not reach costs a test for each group of
// thousands of points.
AdvectResult advect(const Flow& flow, PointBlocks& points, const AdvectOptions& options);

}  // namespace knead
