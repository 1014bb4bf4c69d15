// The nodes of a potential grid as they are evaluated, and where they count. Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "knead/field/grid_view.h"
#include "knead/field/potential_grid.h"
#include "knead/math/box.h"

namespace knead::detail {

// So many empty nodes lie on each side of the grid.
inline constexpr int kEmptyNodes = 4;

// Grids have at most so many nodes; and with the empty ones.
inline constexpr std::size_t kMostGridNodes = std::size_t{1} << 24;
inline constexpr std::size_t kMostPaddedNodes = std::size_t{1} << 25;

// Returns the number of a grid's nodes; nothing if there are none or too many.
std::optional<std::size_t> node_count(const std::array<int, 3>& counts);

// Returns the node that positions are relative to.
Vec3d middle_node(const PotentialGrid& grid);

// Returns the box of the nodes that count, at any time; empty if none does. v is 0 from 2 spacings beyond it on.
Box box_in_use(const PotentialGrid& grid);

// Which cells of a grid are used: those with a node that counts, at the beginning or at the end. A valid grid's.
class GridCells {
 public:
  explicit GridCells(const PotentialGrid& grid);

  Vec3d center() const { return center_; }  // middle_node

  // Returns the grid without its numbers.
  template <class S>
  GridView<S> view() const;

  // Returns the nodes' numbers, as GridView has them.
  template <class S>
  std::vector<S> numbers(const SharedVectors& coefficients) const;

  const std::vector<std::uint8_t>& used() const { return used_; }

 private:
  std::size_t number_of(int x, int y, int z) const;

  std::array<int, 3> inner_{};  // nodes
  std::array<int, 3> nodes_{};  // with the empty ones
  std::array<int, 3> middle_{};
  double spacing_ = 1;
  Vec3d center_;
  std::vector<std::uint8_t> used_;
};

// Returns whether v may be other than 0 at x, at any time. For one place: GridCells answers for many.
bool is_used(const PotentialGrid& grid, const Vec3d& x);

// The numbers of a grid, and everything that its view points to.
template <class S>
struct GridNodes {
  GridCells cells;
  std::vector<S> numbers;
  std::vector<S> end_numbers;
  GridView<S> view;

  explicit GridNodes(const PotentialGrid& grid)
      : cells(grid), numbers(cells.numbers<S>(grid.coefficients)), view(cells.view<S>()) {
    view.numbers = numbers.data();
    if (grid.end_coefficients.empty()) return;
    end_numbers = cells.numbers<S>(grid.end_coefficients);
    view.end_numbers = end_numbers.data();
  }
  GridNodes(const GridNodes&) = delete;
  GridNodes& operator=(const GridNodes&) = delete;
  ~GridNodes() = default;
};

// Where a grid's v is not 0, for boxes.
class GridSupport {
 public:
  explicit GridSupport(const PotentialGrid& grid);

  // Returns whether v is 0 everywhere in the box, up to some rounding of its sides.
  bool misses(const Box& box) const;

 private:
  std::int32_t count_below(int x, int y, int z) const;

  Vec3d origin_;  // where the first cell begins
  double spacing_ = 1;
  std::array<int, 3> cells_{};
  std::vector<std::int32_t> below_;  // how many used cells there are below each corner, in all three axes
};

}  // namespace knead::detail
