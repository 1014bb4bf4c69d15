// Random potential grids, of about unit size.
#pragma once

#include <vector>

#include "knead/flow.h"
#include "support/random_fields.h"

namespace knead::test {

inline SharedVectors random_coefficients(Random& random, std::size_t count, double size, double part = 1) {
  std::vector<Vec3d> list(count);
  for (Vec3d& a : list) {
    const bool counts = random.uniform(0, 1) < part;
    const Vec3d v = random.in_box(size);
    a = counts ? v : Vec3d{0, 0, 0};
  }
  return SharedVectors(std::move(list));
}

// Speeds are some tenths. `part` of the nodes count; with_end: v depends on the time.
inline Segment random_grid(Random& random, bool with_end = false, double part = 1) {
  Segment segment;
  PotentialGrid& grid = segment.grid;
  grid.spacing = 0.23;
  grid.counts = {5, 4, 6};
  grid.origin = random.in_box(0.1) - Vec3d{0.46, 0.3, 0.5};
  grid.coefficients = random_coefficients(random, 120, 0.06, part);
  if (with_end) grid.end_coefficients = random_coefficients(random, 120, 0.06, part);
  return segment;
}

}  // namespace knead::test
