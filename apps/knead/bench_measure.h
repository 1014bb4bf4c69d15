// What all parts of `knead bench` measure with.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "knead/flow/advect.h"

namespace knead::command {

// About `count` of the points (all, if there are fewer), evenly chosen.
std::vector<Vec3d> sample_of(const std::vector<Vec3d>& points, std::size_t count);

// Of three runs; of up to 25 where these are shorter than 0.05 s together, and of fewer where they take over 2 s.
double median_seconds(const std::function<void()>& run);

// The same, each run after one of `prepare`, whose time does not count.
double median_seconds(const std::function<void()>& prepare, const std::function<void()>& run);

// Where the flow takes the points, to 1e-12 of `size` a path line and segment.
std::vector<Vec3d> exact_positions(const Flow& flow, std::vector<Vec3d> points, double size);

// Between points of the same number.
double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b);

}  // namespace knead::command
