#include "knead/mesh/polygonise.h"

#include <algorithm>
#include <cmath>

#include "knead/math/error.h"
#include "knead/mesh/polygonise_cells.h"
#include "knead/mesh/polygonise_dual.h"
#include "knead/mesh/polygonise_relax.h"

namespace knead {
namespace {

constexpr double kMostCells = 4096;  // along a side

void check(const Box& box, const PolygoniseOptions& options) {
  if (!(options.cell > 0) || !std::isfinite(options.cell)) {
    throw InvalidInput("the grid cell of a polygonised surface is not a positive number; give a positive number");
  }
  if (!(options.lipschitz >= 0) || !std::isfinite(options.lipschitz)) {
    throw InvalidInput("the Lipschitz constant is negative or not finite; give 0 if it is unknown");
  }
  if (options.relaxations < 0 || options.relaxations > 100) {
    throw InvalidInput("the number of relaxations is out of range; give a number from 0 to 100");
  }
  const Vec3d size = box.max - box.min;
  if (!is_finite(box.min) || !is_finite(box.max) || !(size.x > 0 && size.y > 0 && size.z > 0)) {
    throw InvalidInput("the box of a polygonised surface is empty or not finite; give one with a volume");
  }
  if (std::max({size.x, size.y, size.z}) > kMostCells * options.cell) {
    throw InvalidInput("the grid has more than 4096 cells along a side; give a larger cell");
  }
}

polygonise_detail::Grid make_grid(const Box& box, double cell) {
  const auto count = [&](double size) { return static_cast<std::uint32_t>(std::fmax(1, std::ceil(size / cell))); };
  const Vec3d size = box.max - box.min;
  return {box.min, cell, {count(size.x), count(size.y), count(size.z)}};
}

// Returns a bound of the signed distance from a box: positive outside, 0 on its walls.
double box_distance(const Box& box, const Vec3d& p) {
  const Vec3d below = box.min - p;
  const Vec3d above = p - box.max;
  return std::max({below.x, below.y, below.z, above.x, above.y, above.z});
}

}  // namespace

Mesh polygonise(const ScalarFunction& f, const Box& box, const PolygoniseOptions& options) {
  check(box, options);
  const double slope = options.lipschitz > 0 ? options.lipschitz : 1;
  const ScalarFunction within_box = [&](const Vec3d& p) { return std::max(f(p), slope * box_distance(box, p)); };
  const polygonise_detail::Grid grid = make_grid(box, options.cell);
  const auto cells = polygonise_detail::surface_cells(within_box, grid, options.lipschitz);
  polygonise_detail::QuadSurface surface = polygonise_detail::dual_surface(cells, grid);
  polygonise_detail::relax(surface, within_box, options.cell, options.relaxations);
  return polygonise_detail::split_quads(surface);
}

}  // namespace knead
