// How good a fit is. Internal to the fit module.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/fit.h"
#include "knead/mesh.h"

namespace knead::fit_detail {

// A surface, or a cloud, that distances are measured from.
struct MeasuredShape {
  std::span<const Vec3d> positions;
  std::span<const Triangle> triangles;
};

// Returns a tree over its triangles, or over its points if it has none.
SurfaceTree tree_of(const MeasuredShape& shape);

struct Measuring {
  double length = 1;     // that distances are relative to
  std::size_t most = 0;  // vertices of each shape that are looked at, evenly through the list; 0: all
  int threads = 0;
  const Progress* progress = nullptr;
};

// Returns the distance of two shapes. Throws Cancelled.
FitDistance distance_of(const MeasuredShape& a, const MeasuredShape& b, const SurfaceTree& of_b,
                        const Measuring& measuring);

struct StretchOfShape {
  double greatest = 1;  // or the inverse of the least
  double most_99 = 1;
  double rms_log = 0;
};

// Returns how triangles with an area are stretched from `rest` to `now`.
StretchOfShape stretch_of(std::span<const Triangle> triangles, std::span<const Vec3d> rest, std::span<const Vec3d> now);

// Pairs of triangles that cross, sorted.
using Crossings = std::vector<std::array<std::uint32_t, 2>>;

// Returns how many of the pairs are not in `before`.
std::size_t count_new(const Crossings& pairs, const Crossings& before);

}  // namespace knead::fit_detail
