// The rows of v = curl A and its strain over the coefficients of a grid, and the numbering of its nodes. Internal to
// the pose module.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// The number of nodes whose basis functions are not 0 in a cell: 4 along each axis. Node (i, j, k) of them is number
// i + 4 (j + 4 k).
inline constexpr std::size_t kCellNodes = 64;

// A cell of the lattice, named by its lowest corner. Its 64 nodes lie from `cell - 1` to `cell + 2`.
using LatticeCell = std::array<int, 3>;

// Returns the cell that holds a position.
inline LatticeCell cell_of(const Vec3d& place, double spacing) {
  const auto along = [&](std::size_t axis) { return static_cast<int>(std::floor(place[axis] / spacing)); };
  return {along(0), along(1), along(2)};
}

// The values, or the products of derivatives, of the 64 basis functions at a point.
using NodeWeights = std::array<double, kCellNodes>;

// One row over the 64 nodes: the factors of each component of the coefficients.
using SplineRow = std::array<NodeWeights, 3>;

// The derivatives of the basis functions at one point of a lattice with nodes at spacing * (i, j, k).
class SplineBasis {
 public:
  SplineBasis(const Vec3d& place, double spacing) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = place[axis] / spacing;
      const double low = std::floor(at);
      cell_[axis] = static_cast<int>(low);
      find_weights(at - low, spacing, weights_[axis]);
    }
  }

  const LatticeCell& cell() const { return cell_; }

  // The three rows of grad p, over the nodes' numbers of p.
  std::array<NodeWeights, 3> growth_velocity() const { return {product(1, 0, 0), product(0, 1, 0), product(0, 0, 1)}; }

  // The six rows of the strain of grad p, as those of strain().
  std::array<NodeWeights, 6> growth_strain() const {
    return {product(2, 0, 0),       product(0, 2, 0),       product(0, 0, 2),
            root(product(1, 1, 0)), root(product(1, 0, 1)), root(product(0, 1, 1))};
  }

  // The three rows of v = curl A.
  std::array<SplineRow, 3> velocity() const {
    const NodeWeights x = product(1, 0, 0);
    const NodeWeights y = product(0, 1, 0);
    const NodeWeights z = product(0, 0, 1);
    const NodeWeights none{};
    return {{{none, negative(z), y}, {z, none, negative(x)}, {negative(y), x, none}}};
  }

  // The six rows of the strain: xx, yy, zz, and sqrt(2) times xy, xz, yz. The sum of their squares is |sym grad v|^2.
  std::array<SplineRow, 6> strain() const {
    const NodeWeights xx = product(2, 0, 0);
    const NodeWeights yy = product(0, 2, 0);
    const NodeWeights zz = product(0, 0, 2);
    const NodeWeights xy = product(1, 1, 0);
    const NodeWeights xz = product(1, 0, 1);
    const NodeWeights yz = product(0, 1, 1);
    const NodeWeights none{};
    return {{{none, negative(xz), xy},
             {yz, none, negative(xy)},
             {negative(yz), xz, none},
             {half(xz), half(negative(yz)), half(difference(yy, xx))},
             {half(negative(xy)), half(difference(xx, zz)), half(yz)},
             {half(difference(zz, yy)), half(xy), half(negative(xz))}}};
  }

 private:
  using Weights = std::array<std::array<double, 4>, 3>;  // by order of the derivative

  static void find_weights(double u, double spacing, Weights& to) {
    const double q = 1 - u;
    const double by = 1 / spacing;
    to[0] = {q * q * q / 6, ((3 * u - 6) * u * u + 4) / 6, ((3 * q - 6) * q * q + 4) / 6, u * u * u / 6};
    to[1] = {-q * q / 2 * by, u * (9 * u - 12) / 6 * by, -q * (9 * q - 12) / 6 * by, u * u / 2 * by};
    to[2] = {q * by * by, (3 * u - 2) * by * by, (3 * q - 2) * by * by, u * by * by};
  }

  NodeWeights product(std::size_t of_x, std::size_t of_y, std::size_t of_z) const {
    NodeWeights result;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
    std::size_t node = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t j = 0; j < 4; ++j) {
        const double yz = weights_[1][of_y][j] * weights_[2][of_z][k];
        for (std::size_t i = 0; i < 4; ++i) result[node++] = weights_[0][of_x][i] * yz;
      }
    }
    return result;
  }

  static NodeWeights negative(const NodeWeights& a) {
    NodeWeights result;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
    for (std::size_t i = 0; i < kCellNodes; ++i) result[i] = -a[i];
    return result;
  }
  static NodeWeights difference(const NodeWeights& a, const NodeWeights& b) {
    NodeWeights result;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
    for (std::size_t i = 0; i < kCellNodes; ++i) result[i] = a[i] - b[i];
    return result;
  }
  // Times sqrt(2).
  static NodeWeights root(NodeWeights a) {
    for (double& weight : a) weight *= 1.41421356237309505;
    return a;
  }
  // Times sqrt(1 / 2): sqrt(2) times half a sum of two derivatives.
  static NodeWeights half(const NodeWeights& a) {
    NodeWeights result;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
    for (std::size_t i = 0; i < kCellNodes; ++i) result[i] = 0.707106781186547524 * a[i];
    return result;
  }

  LatticeCell cell_{};
  std::array<Weights, 3> weights_{};  // by axis
};

// A point of one list, by its number there.
struct CellPoint {
  LatticeCell cell{};
  std::uint32_t list = 0;
  std::uint32_t number = 0;
};

// Returns points sorted by cells; of one cell, by list and number.
std::vector<CellPoint> sorted_by_cells(std::vector<CellPoint> points);

// The cells of a cube, each by the run of its points.
using CellBlock = std::vector<std::span<const CellPoint>>;

// Divides sorted points into blocks of cells, and these into lists: two blocks of a list have no node in common.
std::array<std::vector<CellBlock>, 8> blocks_of(const std::vector<CellPoint>& points);

// The box of some nodes.
struct NodeBox {
  LatticeCell low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  LatticeCell high{std::numeric_limits<int>::min(), std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};

  void extend(const LatticeCell& node) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], node[axis]);
      high[axis] = std::max(high[axis], node[axis]);
    }
  }
};

// The nodes of some cells, numbered by nested dissection so that a Cholesky factor has few entries: half of a box, the
// other half, then the three layers between them. The numbers depend on the set of cells alone.
class LatticeNodes {
 public:
  LatticeNodes() = default;
  // Keeps the nodes of `cells` that is_kept() accepts; nodes are also neighbours if they share one of `others`. threads
  // as for parallel_for. Throws InvalidInput if the cells are too far apart for a grid.
  explicit LatticeNodes(std::vector<LatticeCell> cells, const std::vector<LatticeCell>& others = {},
                        const std::function<bool(const LatticeCell&)>& is_kept = {}, int threads = 0);

  // Returns the number of nodes that the constructor keeps.
  static std::size_t count(std::vector<LatticeCell> cells, const std::function<bool(const LatticeCell&)>& is_kept);

  std::size_t size() const { return nodes_.size(); }

  // Returns the numbers of the 64 nodes of a cell; -1 for a node that is not kept.
  std::array<int, kCellNodes> of_cell(const LatticeCell& cell) const;

  // Returns the node and the later nodes that share a cell with it, ascending.
  std::span<const int> neighbors_after(int node) const {
    return {neighbors_.data() + begin_[static_cast<std::size_t>(node)],
            neighbors_.data() + begin_[static_cast<std::size_t>(node) + 1]};
  }

  // Returns the index of `to` among neighbors_after() `from`. Both are indices of a cell's 64 nodes; `number` is that
  // of `from`.
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
    result.coefficients = of_grid<Vec3d>(coefficient);
    return result;
  }

  // Returns a list of that grid's nodes, with what value(number) returns.
  template <class T, class Value>
  SharedList<T> of_grid(const Value& value) const {
    std::vector<T> list(number_at_.size());
    for (std::size_t node = 0; node < nodes_.size(); ++node)
      list[index_of(nodes_[node])] = value(static_cast<int>(node));
    return SharedList<T>(std::move(list));
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

  void find_nodes(std::vector<LatticeCell>& cells, const std::function<bool(const LatticeCell&)>& is_kept);
  void find_box(const std::vector<LatticeCell>& cells);
  void set_box(const NodeBox& box);
  void find_neighbors(const std::vector<LatticeCell>& cells, const std::vector<LatticeCell>& others, int threads);
  void rank_neighbors(std::size_t node);

  void add_ranks(const std::array<int, kCellNodes>& numbers);

  LatticeCell low_{};               // of the box of all nodes
  std::array<int, 3> counts_{};     // of nodes in it
  std::vector<int> number_at_;      // of each position in the box; -1: no node
  std::vector<LatticeCell> nodes_;  // by number
  std::vector<std::size_t> begin_;
  std::vector<int> neighbors_;
  std::vector<int> rank_;
};

}  // namespace knead::detail
