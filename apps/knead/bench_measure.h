// Functions that all parts of `knead bench` use to measure.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "knead/flow.h"

namespace knead::command {

// Returns about `count` of the points, evenly chosen; all if there are fewer.
std::vector<Vec3d> sample_of(const std::vector<Vec3d>& points, std::size_t count);

// Returns the median of three runs; of up to 25 if they take less than 0.05 s in all, of fewer if they take over 2 s.
double median_seconds(const std::function<void()>& run);

// Does the same, and calls `prepare` before each run; its time does not count.
double median_seconds(const std::function<void()>& prepare, const std::function<void()>& run);

// Returns the points at the flow's end, with an error of 1e-12 of `size` for each path line and segment.
std::vector<Vec3d> exact_positions(const Flow& flow, std::vector<Vec3d> points, double size);

// Returns the greatest distance between a[i] and b[i].
double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b);

}  // namespace knead::command
