#include "knead/gpu/packed_grid.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "knead/field/grid_nodes.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/step_rule.h"
#include "knead/gpu/packed_bounds.h"

namespace knead::gpu {

namespace {

using namespace layout;
using detail::GridCells;

// Segments to a call of a shader: some drivers stop loops after 65535 rounds, and an evaluation takes 16.
constexpr std::size_t kMostGrids = 16;

// Nodes to a call, with the empty ones around the grids: their numbers take 24 bytes each.
constexpr std::size_t kMostNodes = std::size_t{1} << 21;

std::size_t padded_nodes(const PotentialGrid& grid) {
  std::size_t nodes = grid.end_coefficients.empty() ? 1 : 2;
  for (const int count : grid.counts) nodes *= static_cast<std::size_t>(count) + std::size_t{2} * detail::kEmptyNodes;
  return nodes;
}

// Fills one pack.
class GridPacker {
 public:
  GridPacker(std::span<const Segment> segments, const AdvectOptions& options) : segments_(segments), options_(options) {
    packed_.count = static_cast<int>(segments.size());
    packed_.numbers.resize(segments.size() * kSegmentNumbers);
    packed_.places.resize(segments.size() * (kSegmentPlaces + kFieldBounds));
    packed_.table.resize(segments.size() * (kSegmentEntries + kFieldEntries));
  }

  PackedSegments run() {
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const GridCells cells(segments_[i].grid);
      put_segment(i, cells);
      put_grid(i, cells);
    }
    return std::move(packed_);
  }

 private:
  std::size_t table_of(std::size_t i) const { return segments_.size() * kSegmentEntries + i * kFieldEntries; }
  std::size_t bounds_at(std::size_t i) const { return segments_.size() * kSegmentPlaces + i * kFieldBounds; }

  void put_segment(std::size_t i, const GridCells& cells) {
    const Segment& segment = segments_[i];
    double* const numbers = packed_.numbers.data() + i * kSegmentNumbers;
    numbers[kReach] = detail::reach_of_step(segment);
    numbers[kTolerance] = detail::kErrorShare * options_.tolerance;
    numbers[kLeast] = kLeastMotion * segment.grid.spacing;
    numbers[kPerSpacing] = 1 / segment.grid.spacing;
    numbers[kEndOfTime] = segment.end;
    const std::size_t places = i * kSegmentPlaces;
    put(packed_.places, places, cells.center());
    packed_.places[places + 6] = segment.begin;
    packed_.places[places + 7] = segment.end;
    packed_.places[places + 8] = 1 / segment.grid.spacing;
    std::int32_t* const entries = packed_.table.data() + i * kSegmentEntries;
    entries[0] = 1;
    entries[1] = static_cast<std::int32_t>(table_of(i));
    entries[3] = static_cast<std::int32_t>(i * kSegmentNumbers);
  }

  void put_grid(std::size_t i, const GridCells& cells) {
    const PotentialGrid& grid = segments_[i].grid;
    const std::size_t entry = table_of(i);
    const auto set = [&](int at, auto value) {
      packed_.table[entry + static_cast<std::size_t>(at)] = static_cast<std::int32_t>(value);
    };
    set(kFieldBegin, put_numbers(cells, grid.coefficients));
    if (!grid.end_coefficients.empty()) set(kEndNumbers, put_numbers(cells, grid.end_coefficients));
    const auto view = cells.view<double>();
    set(kRow, view.row);
    set(kPlane, view.plane);
    set(kFirstNode, view.first_node);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      set(kFirstCell + static_cast<int>(axis), view.first_cell[axis]);
      set(kLastCell + static_cast<int>(axis), view.last_cell[axis]);
    }
    set(kUsed, put_used(cells.used()));
    set(kBounds, bounds_at(i));
    put_box(bounds_at(i), detail::box_in_use(grid), grid.spacing);
  }

  std::size_t put_numbers(const GridCells& cells, const SharedVectors& coefficients) {
    const std::size_t begin = packed_.numbers.size();
    const std::vector<double> numbers = cells.numbers<double>(coefficients);
    packed_.numbers.insert(packed_.numbers.end(), numbers.begin(), numbers.end());
    return begin;
  }

  // 32 cells to an entry.
  std::size_t put_used(const std::vector<std::uint8_t>& used) {
    const std::size_t begin = packed_.table.size();
    std::vector<std::uint32_t> words((used.size() + 31) / 32);
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i] != 0) words[i / 32] |= std::uint32_t{1} << i % 32;
    }
    packed_.table.insert(packed_.table.end(), words.begin(), words.end());
    return begin;
  }

  // Of the cells in use. Of an empty box nothing is within reach.
  void put_box(std::size_t at, const Box& nodes, double spacing) {
    const double size = nodes.empty() ? 0 : norm(nodes.min) + norm(nodes.max);
    const Vec3d margin = Vec3d{1, 1, 1} * ((2 + 1e-6) * spacing + 1e-12 * size);
    put(packed_.places, at, nodes.min - margin);
    put(packed_.places, at + 3, nodes.max + margin);
  }

  std::span<const Segment> segments_;
  const AdvectOptions& options_;
  PackedSegments packed_;
};

}  // namespace

PackedSegments pack_grids(std::span<const Segment> segments, const AdvectOptions& options) {
  return GridPacker(segments, options).run();
}

std::size_t count_packed_grids(std::span<const Segment> segments) {
  std::size_t nodes = 0;
  std::size_t length = 0;
  while (length < std::min(segments.size(), kMostGrids)) {
    nodes += padded_nodes(segments[length].grid);
    if (length > 0 && nodes > kMostNodes) break;
    ++length;
  }
  return length;
}

}  // namespace knead::gpu
