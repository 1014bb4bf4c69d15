#include "view/influence.h"

#include <algorithm>

#include "knead/error.h"
#include "knead/flow.h"

namespace knead::studio {

namespace {

constexpr std::size_t kVerticesAtOnce = 4096;
constexpr double kShadeError = 1e-3;  // of a displacement

bool is_within(const LimitCylinder& limit_cylinder, const Vec3d& p) {
  const Vec3d d = p - limit_cylinder.center;
  return norm2(d - limit_cylinder.axis * dot(d, limit_cylinder.axis)) <= limit_cylinder.radius * limit_cylinder.radius;
}

double weight_at(const Segment& segment, const Vec3d& p) {
  if (segment.limit_cylinder && !is_within(*segment.limit_cylinder, p)) return 0;
  double most = 0;
  for (const Field& field : segment.fields) {
    most = std::max(most, blend_weight(region_value(field, p - field.center).value, field.thresholds).value);
  }
  return most;
}

}  // namespace

std::vector<float> influence_of(std::span<const Flow> flows, const Snapshot& positions, int threads) {
  std::vector<float> result(positions.size());
  parallel_for(positions.size(), kVerticesAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    for (const Flow& flow : flows) {
      if (flow.segments.empty()) continue;
      if (!flow.segments.front().grid.is_empty()) {
        const FlowReach reach(Flow{{flow.segments.front()}});
        for (std::size_t i = begin; i < end; ++i) {
          if (reach.may_move(positions[i], 0)) result[i] = 1;
        }
        continue;
      }
      for (std::size_t i = begin; i < end; ++i) {
        result[i] = std::max(result[i], static_cast<float>(weight_at(flow.segments.front(), positions[i])));
      }
    }
  });
  return result;
}

std::vector<float> influence_of(const PinsStroke& stroke, const Snapshot& positions, int threads) {
  double longest = 0;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    longest = std::max(longest, norm(stroke.to[i] - stroke.points[i]));
  }
  const std::vector<Vec3d> before = positions.copy();
  std::vector<Vec3d> after = before;
  AdvectOptions options;
  options.tolerance = kShadeError * longest;
  options.threads = threads;
  try {
    advect(flow_of(stroke), after, options);
  } catch (const InvalidInput&) {
    return {};
  }
  std::vector<float> result(before.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = static_cast<float>(std::min(norm(after[i] - before[i]) / longest, 1.0));
  }
  return result;
}

}  // namespace knead::studio
