#include "knead/mesh/polygonise_cells.h"

#include <algorithm>
#include <cmath>

namespace knead::polygonise_detail {
namespace {

constexpr std::uint32_t kBlock = 2;  // cells along a side of the smallest blocks

// Returns the parts within the grid of the given blocks, each cut into eight blocks with `size` cells along a side.
std::vector<std::uint64_t> split_blocks(const std::vector<std::uint64_t>& blocks, const Grid& grid,
                                        std::uint32_t size) {
  std::vector<std::uint64_t> halves;
  for (const std::uint64_t block : blocks) {
    const auto [x, y, z] = grid_place(block);
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t hx = 2 * x + (i & 1);
      const std::uint32_t hy = 2 * y + ((i >> 1) & 1);
      const std::uint32_t hz = 2 * z + (i >> 2);
      const bool in_grid = hx * size < grid.cells[0] && hy * size < grid.cells[1] && hz * size < grid.cells[2];
      if (in_grid) halves.push_back(grid_key(hx, hy, hz));
    }
  }
  return halves;
}

// Removes the blocks whose centre is farther from the surface than from their corners.
void drop_empty_blocks(std::vector<std::uint64_t>& blocks, const ScalarFunction& f, const Grid& grid,
                       std::uint32_t size, double lipschitz) {
  const double reach = lipschitz * grid.cell * size * 0.5 * std::sqrt(3.0) * (1 + 1e-9);
  std::erase_if(blocks, [&](std::uint64_t block) {
    const auto [x, y, z] = grid_place(block);
    return std::abs(f(grid.at((x + 0.5) * size, (y + 0.5) * size, (z + 0.5) * size))) > reach;
  });
}

// Returns the smallest blocks that the surface may meet. Begins with the whole grid and halves blocks level by level.
std::vector<std::uint64_t> blocks_near_surface(const ScalarFunction& f, const Grid& grid, double lipschitz) {
  std::uint32_t size = kBlock;
  while (size < *std::max_element(grid.cells.begin(), grid.cells.end())) size *= 2;
  std::vector<std::uint64_t> blocks{grid_key(0, 0, 0)};
  drop_empty_blocks(blocks, f, grid, size, lipschitz);
  while (size > kBlock) {
    size /= 2;
    blocks = split_blocks(blocks, grid, size);
    drop_empty_blocks(blocks, f, grid, size, lipschitz);
  }
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

// The values of f at the corners of three consecutive grid layers. Each value is computed at its first use.
class CornerLayers {
 public:
  CornerLayers(const ScalarFunction& f, const Grid& grid) : f_(f), grid_(grid), row_(grid.cells[0] + 1) {
    const std::size_t layer = row_ * (grid.cells[1] + 1);
    for (Layer& l : layers_) {
      l.values.resize(layer);
      l.height.resize(layer, kNone);
    }
  }

  double operator()(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    Layer& layer = layers_[z % 3];
    const std::size_t i = row_ * y + x;
    if (layer.height[i] != z) {
      layer.height[i] = z;
      layer.values[i] = f_(grid_.at(x, y, z));
    }
    return layer.values[i];
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  struct Layer {
    std::vector<double> values;
    std::vector<std::uint32_t> height;  // the z that each value belongs to
  };

  const ScalarFunction& f_;
  const Grid& grid_;
  std::size_t row_;
  std::array<Layer, 3> layers_;
};

// Appends the cells of one block that have corners on both sides.
void append_surface_cells(std::uint64_t block, const Grid& grid, CornerLayers& corner,
                          std::vector<SurfaceCell>& cells) {
  const auto [bx, by, bz] = grid_place(block);
  for (std::uint32_t i = 0; i < kBlock * kBlock * kBlock; ++i) {
    const std::uint32_t x = kBlock * bx + i % kBlock;
    const std::uint32_t y = kBlock * by + i / kBlock % kBlock;
    const std::uint32_t z = kBlock * bz + i / (kBlock * kBlock);
    if (x >= grid.cells[0] || y >= grid.cells[1] || z >= grid.cells[2]) continue;
    SurfaceCell cell{grid_key(x, y, z), {}};
    int inside = 0;
    for (std::uint32_t c = 0; c < 8; ++c) {
      cell.values[c] = corner(x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2));
      inside += cell.inside(static_cast<int>(c)) ? 1 : 0;
    }
    if (inside > 0 && inside < 8) cells.push_back(cell);
  }
}

std::uint32_t blocks_along(const Grid& grid, std::size_t axis) { return (grid.cells[axis] + kBlock - 1) / kBlock; }

void append_all_blocks(const Grid& grid, CornerLayers& corner, std::vector<SurfaceCell>& cells) {
  for (std::uint32_t z = 0; z < blocks_along(grid, 2); ++z) {
    for (std::uint32_t y = 0; y < blocks_along(grid, 1); ++y) {
      for (std::uint32_t x = 0; x < blocks_along(grid, 0); ++x) {
        append_surface_cells(grid_key(x, y, z), grid, corner, cells);
      }
    }
  }
}

}  // namespace

std::vector<SurfaceCell> surface_cells(const ScalarFunction& f, const Grid& grid, double lipschitz) {
  std::vector<SurfaceCell> cells;
  CornerLayers corner(f, grid);
  if (lipschitz > 0) {
    for (const std::uint64_t block : blocks_near_surface(f, grid, lipschitz)) {
      append_surface_cells(block, grid, corner, cells);
    }
  } else {
    append_all_blocks(grid, corner, cells);
  }
  std::sort(cells.begin(), cells.end(), [](const SurfaceCell& a, const SurfaceCell& b) { return a.key < b.key; });
  return cells;
}

}  // namespace knead::polygonise_detail
