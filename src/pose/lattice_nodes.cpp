// Numbers the nodes of a lattice by nested dissection, and divides points into blocks for threads.
#include "pose/lattice_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "knead/error.h"

namespace knead::detail {

namespace {

constexpr double kMaxBox = 16e6;         // nodes in the box
constexpr std::size_t kMinDivided = 24;  // sets with at most so many nodes are not divided
constexpr int kSeparator = 3;            // layers: nodes that share a cell are at most 3 apart
constexpr int kCellsOfBlock = 3;         // cells along an axis: a block and the next but one share no node

bool before(const LatticeCell& a, const LatticeCell& b) {
  return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
}

// Returns one of the 64 nodes of a cell.
LatticeCell node_of(const LatticeCell& cell, std::size_t i) {
  return {cell[0] - 1 + static_cast<int>(i % 4), cell[1] - 1 + static_cast<int>(i / 4 % 4),
          cell[2] - 1 + static_cast<int>(i / 16)};
}

// Orders nodes by nested dissection.
void dissect(std::span<LatticeCell> nodes) {
  NodeBox box;
  for (const LatticeCell& node : nodes) box.extend(node);
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other) {
    if (box.high[other] - box.low[other] > box.high[axis] - box.low[axis]) axis = other;
  }
  std::sort(nodes.begin(), nodes.end(), before);
  if (nodes.size() <= kMinDivided || box.high[axis] - box.low[axis] <= kSeparator) return;
  std::stable_sort(nodes.begin(), nodes.end(),
                   [=](const LatticeCell& a, const LatticeCell& b) { return a[axis] < b[axis]; });
  const int middle = std::clamp(nodes[nodes.size() / 2][axis] - 1, box.low[axis] + 1, box.high[axis] - kSeparator);
  const auto side = [=](const LatticeCell& node) {
    return node[axis] < middle ? 0 : node[axis] < middle + kSeparator ? 2 : 1;
  };
  std::stable_sort(nodes.begin(), nodes.end(),
                   [&](const LatticeCell& a, const LatticeCell& b) { return side(a) < side(b); });
  const auto first_of = [&](int wanted) {
    const auto found =
        std::find_if(nodes.begin(), nodes.end(), [&](const LatticeCell& node) { return side(node) >= wanted; });
    return static_cast<std::size_t>(found - nodes.begin());
  };
  const std::size_t right = first_of(1);
  const std::size_t separator = first_of(2);
  dissect(nodes.first(right));
  dissect(nodes.subspan(right, separator - right));
  std::sort(nodes.begin() + static_cast<std::ptrdiff_t>(separator), nodes.end(), before);
}

}  // namespace

LatticeNodes::LatticeNodes(std::vector<LatticeCell> cells, const std::vector<LatticeCell>& others,
                           const std::function<bool(const LatticeCell&)>& is_kept, int threads) {
  find_nodes(cells, is_kept);
  dissect(nodes_);
  for (std::size_t i = 0; i < nodes_.size(); ++i) number_at_[index_of(nodes_[i])] = static_cast<int>(i);
  find_neighbors(cells, others, threads);
}

std::size_t LatticeNodes::count(std::vector<LatticeCell> cells,
                                const std::function<bool(const LatticeCell&)>& is_kept) {
  LatticeNodes nodes;
  nodes.find_nodes(cells, is_kept);
  return nodes.size();
}

// Sorts the cells, and finds the nodes in no order.
void LatticeNodes::find_nodes(std::vector<LatticeCell>& cells, const std::function<bool(const LatticeCell&)>& is_kept) {
  std::sort(cells.begin(), cells.end(), before);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  find_box(cells);
  for (const LatticeCell& cell : cells) {
    for (std::size_t i = 0; i < kCellNodes; ++i) {
      const LatticeCell node = node_of(cell, i);
      int& number = number_at_[index_of(node)];
      if (number < 0 && is_kept && !is_kept(node)) continue;
      if (number < 0) nodes_.push_back(node);
      number = 0;
    }
  }
  if (is_kept) {
    NodeBox box;
    for (const LatticeCell& node : nodes_) box.extend(node);
    set_box(box);
  }
}

void LatticeNodes::find_box(const std::vector<LatticeCell>& cells) {
  NodeBox box;
  for (const LatticeCell& cell : cells) {
    box.extend({cell[0] - 1, cell[1] - 1, cell[2] - 1});
    box.extend({cell[0] + 2, cell[1] + 2, cell[2] + 2});
  }
  set_box(box);
}

void LatticeNodes::set_box(const NodeBox& box) {
  double size = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double count = std::max(0.0, static_cast<double>(box.high[axis]) - box.low[axis] + 1);
    size *= count;
    low_[axis] = box.low[axis];
    counts_[axis] = size <= kMaxBox ? static_cast<int>(count) : 0;
  }
  if (size > kMaxBox) throw InvalidInput("\"detail\" is too fine for a shape of this extent; make it larger");
  number_at_.assign(static_cast<std::size_t>(counts_[0]) * static_cast<std::size_t>(counts_[1]) *
                        static_cast<std::size_t>(counts_[2]),
                    -1);
}

std::array<int, kCellNodes> LatticeNodes::of_cell(const LatticeCell& cell) const {
  std::array<int, kCellNodes> numbers;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
  for (std::size_t i = 0; i < kCellNodes; ++i) {
    const LatticeCell node = node_of(cell, i);
    numbers[i] = contains(node) ? number_at_[index_of(node)] : -1;
  }
  return numbers;
}

void LatticeNodes::find_neighbors(const std::vector<LatticeCell>& cells, const std::vector<LatticeCell>& others,
                                  int threads) {
  rank_.assign(kOffsets * nodes_.size(), -1);
  for (const auto* list : {&cells, &others}) {
    for (const LatticeCell& cell : *list) add_ranks(of_cell(cell));
  }
  begin_.assign(1, 0);
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    const int* const table = rank_.data() + kOffsets * node;
    begin_.push_back(begin_.back() + kOffsets - static_cast<std::size_t>(std::count(table, table + kOffsets, -1)));
  }
  neighbors_.resize(begin_.back());
  constexpr std::size_t kNodesOfThread = 64;
  parallel_for(nodes_.size(), kNodesOfThread, threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t node = from; node < to; ++node) rank_neighbors(node);
  });
}

// Replaces the numbers of a node's neighbours by their ranks.
void LatticeNodes::rank_neighbors(std::size_t node) {
  const std::span<int> table = std::span(rank_).subspan(kOffsets * node, kOffsets);
  const auto begin = neighbors_.begin() + static_cast<std::ptrdiff_t>(begin_[node]);
  const auto end = std::copy_if(table.begin(), table.end(), begin, [](int number) { return number >= 0; });
  std::sort(begin, end);
  for (int& number : table) {
    if (number >= 0) number = static_cast<int>(std::lower_bound(begin, end, number) - begin);
  }
}

// Makes the nodes of a cell neighbours: each of those that are not after it.
void LatticeNodes::add_ranks(const std::array<int, kCellNodes>& numbers) {
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    for (std::size_t b = 0; b < kCellNodes && numbers[a] >= 0; ++b) {
      if (numbers[b] >= numbers[a]) {
        rank_[static_cast<std::size_t>(numbers[a]) * kOffsets + offset_between(a, b)] = numbers[b];
      }
    }
  }
}

std::vector<CellPoint> sorted_by_cells(std::vector<CellPoint> points) {
  std::sort(points.begin(), points.end(), [](const CellPoint& a, const CellPoint& b) {
    if (a.cell != b.cell) return before(a.cell, b.cell);
    return std::pair(a.list, a.number) < std::pair(b.list, b.number);
  });
  return points;
}

std::array<std::vector<CellBlock>, 8> blocks_of(const std::vector<CellPoint>& points) {
  std::array<std::map<LatticeCell, CellBlock>, 8> lists;  // by which numbers of a block are odd
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin + 1;
    while (end < points.size() && points[end].cell == points[begin].cell) ++end;
    LatticeCell block;
    std::size_t list = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block[axis] = static_cast<int>(std::floor(static_cast<double>(points[begin].cell[axis]) / kCellsOfBlock));
      list = 2 * list + static_cast<std::size_t>(block[axis] & 1);
    }
    lists[list][block].emplace_back(points.data() + begin, end - begin);
    begin = end;
  }
  std::array<std::vector<CellBlock>, 8> result;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    for (auto& [place, block] : lists[i]) result[i].push_back(std::move(block));
  }
  return result;
}

}  // namespace knead::detail
