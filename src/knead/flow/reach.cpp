#include "knead/flow/reach.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "knead/flow/culling.h"
#include "knead/flow/summed.h"

namespace knead {

namespace {

bool is_beyond(const SegmentBarrel& barrel, const Vec3d& center, double radius) {
  const Vec3d d = center - barrel.point;
  return norm(d - barrel.direction * dot(barrel.direction, d)) > (barrel.radius + radius) * (1 + 1e-12);
}

double feature_of(const Field& field) {
  if (std::holds_alternative<HalfSpace<double>>(field.region)) return field.thresholds.outer - field.thresholds.inner;
  const bool is_distance = std::holds_alternative<Ball<double>>(field.region) ||
                           std::holds_alternative<Capsule<double>>(field.region) ||
                           std::holds_alternative<PointSet<double>>(field.region);
  return is_distance ? field.thresholds.outer : std::numeric_limits<double>::infinity();
}

}  // namespace

struct FlowReach::Parts {
  explicit Parts(const Flow& whole) : flow(detail::each_part(whole)) {
    for (const Segment& segment : flow.segments) segments.emplace_back(segment);
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() = default;

  Flow flow;  // which the segments' bounds refer to
  std::vector<detail::Culling> segments;
};

FlowReach::FlowReach(const Flow& flow) : parts_(std::make_unique<const Parts>(flow)) {}
FlowReach::~FlowReach() = default;
FlowReach::FlowReach(FlowReach&&) noexcept = default;
FlowReach& FlowReach::operator=(FlowReach&&) noexcept = default;

bool FlowReach::may_move(const Vec3d& center, double radius) const {
  for (std::size_t i = 0; i < parts_->segments.size(); ++i) {
    const auto& barrel = parts_->flow.segments[i].barrel;
    if (barrel && is_beyond(*barrel, center, radius)) continue;
    if (!parts_->segments[i].misses({center, radius})) return true;
  }
  return false;
}

double FlowReach::smallest_feature() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Segment& segment : parts_->flow.segments) {
    if (!segment.grid.is_empty()) smallest = std::min(smallest, 2 * segment.grid.spacing);
    for (const Field& field : segment.fields) smallest = std::min(smallest, feature_of(field));
  }
  return smallest;
}

}  // namespace knead
