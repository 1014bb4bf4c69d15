#include "knead/flow/summed.h"

#include <algorithm>

#include "knead/flow/culling.h"
#include "knead/math/box.h"

namespace knead::detail {

namespace {

// Boxes are computed with rounding of their own, and kernels classify points by theirs.
constexpr double kMargin = 1e-6;

bool are_apart(const Box& a, const Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double gap = std::max(a.min[axis] - b.max[axis], b.min[axis] - a.max[axis]);
    const double size = (a.max[axis] - a.min[axis]) + (b.max[axis] - b.min[axis]) + std::abs(a.min[axis]);
    if (gap > kMargin * size) return true;
  }
  return false;
}

}  // namespace

std::vector<Segment> parts_of(const Segment& segment) {
  if (segment.parts.empty()) return {segment};
  std::vector<Segment> parts = segment.parts;
  for (Segment& part : parts) {
    part.mask = segment.mask;
    part.begin = segment.begin;
    part.end = segment.end;
  }
  return parts;
}

Flow each_part(const Flow& flow) {
  Flow result;
  for (const Segment& segment : flow.segments) {
    for (Segment& part : parts_of(segment)) result.segments.push_back(std::move(part));
  }
  return result;
}

bool act_apart(const Segment& sum) {
  std::vector<Box> boxes;
  for (const Segment& part : sum.parts) {
    const Box box = support_of(part);
    const auto is_apart = [&](const Box& other) { return are_apart(box, other); };
    if (!std::all_of(boxes.begin(), boxes.end(), is_apart)) return false;
    boxes.push_back(box);
  }
  return true;
}

bool has_barrels(const Segment& segment) {
  return std::any_of(segment.parts.begin(), segment.parts.end(), [](const Segment& part) { return !!part.barrel; });
}

Segment chosen_parts(const Segment& sum, unsigned chosen) {
  Segment result = sum;
  result.parts.clear();
  for (std::size_t i = 0; i < sum.parts.size(); ++i) {
    if ((chosen >> i & 1U) == 0) continue;
    result.parts.push_back(sum.parts[i]);
    result.parts.back().barrel.reset();
  }
  if (result.parts.size() > 1) {
    if (result.parts.size() < sum.parts.size()) result.mirrored_at = {};
    return result;
  }
  return parts_of(result).front();
}

}  // namespace knead::detail
