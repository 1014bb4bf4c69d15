#include "knead/flow/advect.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

#include "knead/flow/advect_within.h"
#include "knead/flow/block_mover.h"
#include "knead/math/error.h"

namespace knead {

namespace {

bool is_finite_and_positive(double x) { return x > 0 && std::isfinite(x); }

}  // namespace

double absolute_tolerance(double relative_tolerance, double diagonal) {
  if (!is_finite_and_positive(relative_tolerance)) {
    throw InvalidInput(fmt::format("the tolerance must be a number greater than 0, got {}", relative_tolerance));
  }
  const double tolerance = relative_tolerance * diagonal;
  if (!is_finite_and_positive(tolerance)) {
    throw InvalidInput(
        "the tolerance times the shape's size must be a finite length greater than 0; change the tolerance");
  }
  return tolerance;
}

void validate(const AdvectOptions& options, std::size_t points) {
  if (!is_finite_and_positive(options.tolerance)) {
    throw InvalidInput(
        fmt::format("set the tolerance of the path lines to a length greater than 0, such as 1e-5 times the shape's "
                    "size, not to {}",
                    options.tolerance));
  }
  if (!options.steps.empty() && options.steps.size() != points) {
    throw InvalidInput("steps must be empty or hold one number per point");
  }
}

AdvectResult& AdvectResult::operator+=(const AdvectResult& other) {
  if (status == AdvectStatus::done) status = other.status;
  accepted_steps += other.accepted_steps;
  rejected_steps += other.rejected_steps;
  evaluations += other.evaluations;
  return *this;
}

namespace {

// Fewer segments than this are not worth sorting the points for.
constexpr std::size_t kSegmentsWorthSorting = 4;

void check(const Flow& flow, const AdvectOptions& options, std::size_t points) {
  validate(flow);
  validate(options, points);
}

AdvectResult move(const Flow& flow, PointBlocks& points, const AdvectOptions& options, std::uint64_t most) {
  const std::vector<std::uint32_t> before = options.steps.empty() ? std::vector<std::uint32_t>{} : points.steps();
  const AdvectResult result = detail::BlockMover(points, options, most).run(flow);
  if (!options.steps.empty()) {
    const std::vector<std::uint32_t> after = points.steps();
    for (std::size_t i = 0; i < after.size(); ++i) options.steps[i] += after[i] - before[i];
  }
  return result;
}

constexpr std::uint64_t kAnyNumber = std::numeric_limits<std::uint64_t>::max();

}  // namespace

AdvectResult advect(const Flow& flow, PointBlocks& points, const AdvectOptions& options) {
  check(flow, options, points.size());
  return move(flow, points, options, kAnyNumber);
}

AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
  return detail::advect_within(flow, points, options, kAnyNumber);
}

AdvectResult detail::advect_within(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options,
                                   std::uint64_t most_evaluations) {
  check(flow, options, points.size());
  const bool sorted = flow.segments.size() >= kSegmentsWorthSorting;
  PointBlocks blocks(points, sorted ? PointBlocks::Order::sorted : PointBlocks::Order::given);
  const AdvectResult result = move(flow, blocks, options, most_evaluations);
  if (result.status == AdvectStatus::done) blocks.update(points);
  return result;
}

}  // namespace knead
