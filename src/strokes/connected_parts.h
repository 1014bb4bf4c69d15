// The connected parts of a set of points and polylines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/vec.h"

namespace knead::tool_detail {

// Elements by their number: the points first, then the curves.
struct Part {
  std::vector<std::uint32_t> points;
  std::vector<std::uint32_t> curves;
};

// Returns the connected components of the elements under distance < reach, where a polyline is as far as its nearest
// point: in the order of each part's first element, and the elements of a part in their own order. Curves have two or
// more points. Time: about n log n for n points and curve segments, whatever the reach.
std::vector<Part> connected_parts(std::span<const Vec3d> points, std::span<const std::vector<Vec3d>> curves,
                                  double reach);

// Returns the distance of two line segments, squared; a segment's ends may coincide.
double squared_segment_distance(const Vec3d& a0, const Vec3d& a1, const Vec3d& b0, const Vec3d& b1);

}  // namespace knead::tool_detail
