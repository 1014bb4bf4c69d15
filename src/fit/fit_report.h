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

}  // namespace knead::fit_detail
