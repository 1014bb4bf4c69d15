// The connected parts of a set of points and polylines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/vec.h"

namespace knead::detail {

// Elements by their number: the points first, then the curves.
struct Part {
  std::vector<std::uint32_t> points;
  std::vector<std::uint32_t> curves;
};

// Returns the connected components of the elements: two are connected if their distance is below `reach`; that of a
// polyline counts to its nearest point. The parts are in the order of their first elements, and the elements of a part
// in their own order. Curves have two or more points. Time: about n log n for n points and curve segments, for any
// `reach`.
std::vector<Part> connected_parts(std::span<const Vec3d> points, std::span<const std::vector<Vec3d>> curves,
                                  double reach);

// Returns the squared distance of two line segments; a segment's ends may coincide.
double squared_segment_distance(const Vec3d& a0, const Vec3d& a1, const Vec3d& b0, const Vec3d& b1);

}  // namespace knead::detail
