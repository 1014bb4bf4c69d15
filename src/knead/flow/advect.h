// Moving points along the path lines of a flow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "knead/flow/point_blocks.h"
#include "knead/flow/segment.h"
#include "knead/flow/tableau.h"
#include "knead/math/mat3.h"
#include "knead/math/progress.h"

namespace knead {

// The scalar in which fields are evaluated. Positions are double in both cases: fields are evaluated relative to the
// tool's centre, and the displacement is added.
enum class Precision { float32, float64 };

// The tolerance relative to the shape's size that everything with such a setting takes by default.
inline constexpr double kDefaultRelativeTolerance = 1e-5;

// Returns relative_tolerance * diagonal, a length for AdvectOptions::tolerance. `diagonal` is that of the shape's
// bounding box. Throws InvalidInput unless relative_tolerance is a finite number above 0 and the product a finite
// length above 0.
double absolute_tolerance(double relative_tolerance, double diagonal);

// How points are moved.
struct AdvectOptions {
  // Position error of one path line over one segment: a length above 0, which depends on the shape's size and so has no
  // default. absolute_tolerance() gives one.
  double tolerance = 0;
  Integrator integrator = Integrator::tsitouras;
  Precision precision = Precision::float32;
  int threads = 0;  // 0: as many as the machine has
  Progress* progress = nullptr;
  std::span<std::uint32_t> steps{};  // empty, or a number for each point, to which its accepted steps are added
};

// Throws InvalidInput unless `tolerance` is a finite length above 0, and `steps` empty or of one number for each point.
void validate(const AdvectOptions& options, std::size_t points);

// How advect() ended.
enum class AdvectStatus { done, cancelled, step_limit };

// How advect() ended, and how much work it was, over all path lines.
struct AdvectResult {
  AdvectStatus status = AdvectStatus::done;
  std::uint64_t accepted_steps = 0;
  std::uint64_t rejected_steps = 0;
  std::uint64_t evaluations = 0;  // of v, for all path lines together

  AdvectResult& operator+=(const AdvectResult& other);
};

// Moves every point along its path line from the flow's beginning to its end, in place.
// The bits of a result depend on its point alone: not on the other points, the number of threads or the instruction
// set. A point that no tool reaches keeps its bits. Cost: a few ns for each evaluation of a field; a point that no tool
// reaches costs a distance. Throws InvalidInput where validate(flow) or validate(options) does, and with its number
// for a point that is not finite. Leaves the points as they were if the status is `cancelled`, or `step_limit`: a path
// line needed over a million steps, for example because it runs to infinity far out in the slab of a bend.
AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

// Does the same for points that are moved many times: a tool costs one test for each group of 4096 points that it does
// not reach. Leaves the points part-way unless the status is `done`.
AdvectResult advect(const Flow& flow, PointBlocks& points, const AdvectOptions& options);

// Returns v at each of the points at a time of the flow, in segments from its beginning: 1.25 is a quarter into the
// second segment. A segment that is a part or an inverse takes one unit of time, too. Barrels do not limit v, because
// they limit path lines by where these begin. Throws InvalidInput where validate(flow) does, for a time that is not
// from 0 to the number of segments, and for a motion or region of the caller's own.
std::vector<Vec3d> velocities(const Flow& flow, std::span<const Vec3d> points, double time);

// Returns the Jacobian at each of the points of the map that advect() applies: row i holds the derivatives of
// coordinate i. Integrates dJ/dt = grad v J along the path lines in double, in the steps that the tolerance of
// `options` asks for, several points at a time where advect() does so. The bits of a result depend on its point alone.
// Throws as velocities() and advect(), and Cancelled.
std::vector<Mat3d> jacobians(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options);

}  // namespace knead
