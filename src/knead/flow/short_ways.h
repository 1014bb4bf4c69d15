// Short ways through point sets, several path lines of one cell at a time. Internal to the flow room.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "knead/flow/path_line.h"
#include "knead/flow/set_cells.h"

namespace knead::detail {

// Path lines that begin in one cell at the same time; unused ones repeat the first.
template <class S>
struct SetPaths {
  std::array<Vec3d, kPlaces> x0{};
  std::array<Vec3<S>, kPlaces> moved{};
  std::array<Vec3<S>, kPlaces> velocity{};
};

// Whether velocities() knows the cell's fields.
template <class S>
bool takes_several(const SetCell<S>& cell) {
  return std::all_of(cell.fields.begin(), cell.fields.end(),
                     [](const SetField<S>& field) { return field.region.curves->empty(); });
}

// The velocity of every path at the time t. One path's bits do not depend on the others. Where sums overflow it is not
// a number.
template <class S>
[[gnu::flatten]] void velocities(const SetCell<S>& cell, double t, SetPaths<S>& paths) {
  paths.velocity = {};
  for (const SetField<S>& field : cell.fields) {
    const PackedSet<S>& set = field.region;
    const Translation<S> motion = field.motion;  // copies: nothing below changes them
    const Thresholds<S> thresholds = field.thresholds;
    const S scale = set.scale;
    const int exponent = set.exponent;
    const Vec3<S> swept = field.displacement * static_cast<S>(t);
    std::array<Vec3<S>, kPlaces> d;
    Places<S> places;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      d[i] = Vec3<S>(paths.x0[i] - field.center) + paths.moved[i] - swept;
      places.x[i] = d[i].x;
      places.y[i] = d[i].y;
      places.z[i] = d[i].z;
      places.scale2[i] = scale * scale;
    }
    if (!(scale > S(0))) least_squared_distances(*set.points, places);
    PlacesSums<S> sums;
    power_sums(*set.points, places, set.exponent / 2, sums);
    for (std::size_t i = 0; i < kPlaces; ++i) {
      RegionValue<S> r{};
      if (places.scale2[i] > S(0)) {
        const PowerSums<S> sum{sums.value[i], {sums.gradient_x[i], sums.gradient_y[i], sums.gradient_z[i]}};
        r = region_of(sum, exponent, scale > S(0) ? scale : std::sqrt(places.scale2[i]));
        if (!(r.value > S(0))) r.value = std::numeric_limits<S>::quiet_NaN();
      }
      paths.velocity[i] += velocity_where(r, motion, thresholds, d[i]);
    }
  }
}

// Indices of points by the cell in which they are.
class CellGroups {
 public:
  explicit CellGroups(int cell_count) : last_(static_cast<std::size_t>(cell_count), kNone) {}

  void add(int cell, std::size_t index) {
    std::size_t& last = last_[static_cast<std::size_t>(cell)];
    if (last == kNone) used_.push_back(cell);
    entries_.push_back({index, last});
    last = entries_.size() - 1;
  }

  const std::vector<int>& used() const { return used_; }

  void indices_of(int cell, std::vector<std::size_t>& result) const {
    result.clear();
    for (std::size_t i = last_[static_cast<std::size_t>(cell)]; i != kNone; i = entries_[i].before) {
      result.push_back(entries_[i].index);
    }
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  struct Entry {
    std::size_t index = 0;
    std::size_t before = kNone;
  };
  std::vector<std::size_t> last_;
  std::vector<Entry> entries_;
  std::vector<int> used_;
};

// The displacements over the segment of up to kPlaces points that begin it in the cell; nothing for those whose way is
// not accurate enough.
template <class S>
std::array<std::optional<Vec3d>, kPlaces> short_ways(const SetCell<S>& cell, const Segment& segment,
                                                     const PathLine<S, SetCells<S>>& line,
                                                     const std::array<Vec3d, kPlaces>& x0) {
  SetPaths<S> paths{x0, {}, {}};
  velocities(cell, segment.begin, paths);
  const std::array<Vec3<S>, kPlaces> first = paths.velocity;
  const S duration = static_cast<S>(segment.end - segment.begin);
  for (std::size_t i = 0; i < kPlaces; ++i) paths.moved[i] = first[i] * duration;
  velocities(cell, segment.end, paths);
  std::array<std::optional<Vec3d>, kPlaces> result;
  for (std::size_t i = 0; i < kPlaces; ++i) result[i] = line.short_way(first[i], paths.velocity[i]);
  return result;
}

// What a chunk of path lines is about.
template <class S>
struct ShortWayTask {
  const SetCells<S>& cells;
  const Segment& segment;
  const PathLine<S, SetCells<S>>& line;
  std::span<Vec3d> points;
  std::span<std::uint32_t> steps;  // empty, or one per point
};

// The points of the indices that begin the segment in the cell; those that do not go a short way are added to `rest`.
template <class S>
void go_short_ways(const ShortWayTask<S>& task, const SetCell<S>& cell, std::span<const std::size_t> indices,
                   PathLineStats& stats, std::vector<std::size_t>& rest) {
  for (std::size_t first = 0; first < indices.size(); first += kPlaces) {
    const auto own = indices.subspan(first, std::min(kPlaces, indices.size() - first));
    std::array<Vec3d, kPlaces> x0;
    for (std::size_t k = 0; k < kPlaces; ++k) x0[k] = task.points[own[k < own.size() ? k : 0]];
    const auto by = short_ways(cell, task.segment, task.line, x0);
    stats.evaluations += 2 * own.size();
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (!by[k]) {
        rest.push_back(own[k]);
        continue;
      }
      if (*by[k] != Vec3d{}) task.points[own[k]] += *by[k];
      if (!task.steps.empty()) ++task.steps[own[k]];
      ++stats.accepted;
    }
  }
}

// Moves those of the points from `begin` to `end` that begin inside and go a short way. Returns the others but for
// those that no tool meets.
template <class S>
std::vector<std::size_t> go_short_ways(const ShortWayTask<S>& task, std::size_t begin, std::size_t end,
                                       PathLineStats& stats) {
  std::vector<std::size_t> rest;
  CellGroups groups(task.cells.cell_count());
  for (std::size_t i = begin; i < end; ++i) {
    typename SetCells<S>::Place place{};
    const double t = task.segment.begin;
    const std::optional<double> contact = task.cells.next_contact(place, task.segment, task.points[i], t);
    if (!contact) continue;
    if (*contact == t && takes_several(*place)) {
      groups.add(place->index, i);
    } else {
      rest.push_back(i);
    }
  }
  std::vector<std::size_t> own;
  for (const int index : groups.used()) {
    groups.indices_of(index, own);
    go_short_ways<S>(task, task.cells.cell(index), own, stats, rest);
  }
  return rest;
}

}  // namespace knead::detail
