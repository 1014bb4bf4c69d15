// The nodes of a lattice that count in some cells, and which of them meet. Internal to the pose module.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/field/potential_grid.h"
#include "knead/pose/spline_rows.h"

namespace knead::detail {

// Nodes are numbered by nested dissection: half of a box, the other half, then the three layers that separate them, so
// that a Cholesky factor has few entries. The numbers depend on the set of cells alone.
class LatticeNodes {
 public:
  LatticeNodes() = default;
  // The nodes that count in one of the cells; nodes also meet in the others. Throws InvalidInput where the cells are
  // too far apart for a grid.
  explicit LatticeNodes(std::vector<LatticeCell> cells, const std::vector<LatticeCell>& others = {});

  std::size_t size() const { return nodes_.size(); }

  // Returns the numbers of the 64 nodes that count in a cell; -1: not one of these nodes.
  std::array<int, kCellNodes> of_cell(const LatticeCell& cell) const;

  // Returns the numbers of the nodes that share a cell with a node and are not before it, ascending: itself first.
  std::span<const int> neighbors_after(int node) const {
    return {neighbors_.data() + begin_[static_cast<std::size_t>(node)],
            neighbors_.data() + begin_[static_cast<std::size_t>(node) + 1]};
  }

  // Returns where `to` is among the neighbours after `from`, both given as places among a cell's 64 nodes; `number` is
  // that of `from`.
  int rank(std::size_t from, std::size_t to, int number) const {
    return rank_[static_cast<std::size_t>(number) * kOffsets + offset_between(from, to)];
  }

  // Returns the smallest grid that holds all nodes, with the coefficients that coefficient(number) returns.
  template <class Coefficient>
  PotentialGrid grid(const Vec3d& origin, double spacing, const Coefficient& coefficient) const {
    PotentialGrid result;
    result.origin = origin + Vec3d(low_[0], low_[1], low_[2]) * spacing;
    result.spacing = spacing;
    result.counts = counts_;
    std::vector<Vec3d> numbers(number_at_.size());
    for (std::size_t node = 0; node < nodes_.size(); ++node) {
      numbers[index_of(nodes_[node])] = coefficient(static_cast<int>(node));
    }
    result.coefficients = SharedVectors(std::move(numbers));
    return result;
  }

 private:
  static constexpr std::size_t kOffsets = 343;  // -3 to 3 along each axis

  static std::size_t offset_between(std::size_t from, std::size_t to) {
    const auto along = [&](std::size_t by) { return to / by % 4 - from / by % 4 + 3; };
    return along(1) + 7 * (along(4) + 7 * along(16));
  }

  bool contains(const LatticeCell& node) const {
    const auto is_within = [&](std::size_t axis) {
      return node[axis] >= low_[axis] && node[axis] - low_[axis] < counts_[axis];
    };
    return is_within(0) && is_within(1) && is_within(2);
  }

  std::size_t index_of(const LatticeCell& node) const {
    const auto along = [&](std::size_t axis) { return static_cast<std::size_t>(node[axis] - low_[axis]); };
    return along(0) +
           static_cast<std::size_t>(counts_[0]) * (along(1) + static_cast<std::size_t>(counts_[1]) * along(2));
  }

  void find_box(const std::vector<LatticeCell>& cells);
  void find_neighbors(const std::vector<LatticeCell>& cells, const std::vector<LatticeCell>& others);

  void add_ranks(const std::array<int, kCellNodes>& numbers);

  LatticeCell low_{};               // of the box of all nodes
  std::array<int, 3> counts_{};     // of nodes in it
  std::vector<int> number_at_;      // in the box; -1: none
  std::vector<LatticeCell> nodes_;  // by number
  std::vector<std::size_t> begin_;
  std::vector<int> neighbors_;
  std::vector<int> rank_;
};

}  // namespace knead::detail
