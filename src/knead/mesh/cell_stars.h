// Which cells lie around each point of a volume mesh. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/measures.h"

namespace knead {

// The cells around each point.
struct CellStars {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> cells;

  // Returns the cells that have this point as a corner, ascending.
  std::span<const std::uint32_t> of(std::uint32_t point) const {
    return std::span(cells).subspan(first[point], first[point + 1] - first[point]);
  }
};

// Returns the stars of cells whose corners are below `points`; below 2^32 cells.
CellStars stars_of(const Cells& cells, std::size_t points);

// Returns whether a face at the point belongs to one cell only, or to more than two.
bool is_on_boundary(const Cells& cells, const CellStars& stars, std::uint32_t point);

}  // namespace knead
