// The velocity of several path lines in one cell of point sets at a time. Internal to the flow room.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "knead/flow/lane_fields.h"

namespace knead::detail {

// Places of path lines in one cell; unused ones repeat the first.
template <class S>
struct SetPlaces {
  std::array<Vec3d, kPlaces> x0{};
  std::array<LanePlace<S>, kPlaces> at{};
  std::array<Vec3<S>, kPlaces> velocity{};
};

// Whether find_velocities knows the cell's fields.
template <class S>
bool takes_several(const SetCell<S>& cell) {
  return std::all_of(cell.fields.begin(), cell.fields.end(),
                     [](const SetField<S>& field) { return field.region.curves->empty() && field.mask.is_empty(); });
}

// For the few places whose sums overflow; not a part of the loop about it.
template <class S>
[[gnu::noinline]] RegionValue<S> evaluate_alone(const PackedSet<S>& set, const Vec3<S>& d) {
  return evaluate(set, d, S(0));
}

// The velocity at every place. One place's bits do not depend on the others.
template <class S>
[[gnu::flatten]] void find_velocities(const SetCell<S>& cell, SetPlaces<S>& paths) {
  paths.velocity = {};
  for (const SetField<S>& field : cell.fields) {
    const PackedSet<S>& set = field.region;
    const Translation<S> motion = field.motion;  // copies: nothing below changes them
    const Thresholds<S> thresholds = field.thresholds;
    const S scale = set.scale;
    const int exponent = set.exponent;
    std::array<Vec3<S>, kPlaces> d;
    Places<S> places;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      d[i] = Vec3<S>(paths.x0[i] - field.center) + paths.at[i].moved - field.displacement * paths.at[i].t;
      places.x[i] = d[i].x;
      places.y[i] = d[i].y;
      places.z[i] = d[i].z;
      places.scale2[i] = scale * scale;
    }
    PlacesSums<S> sums;
    power_sums(*set.points, places, set.exponent / 2, sums);
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const PowerSums<S> sum{sums.value[i], {sums.gradient_x[i], sums.gradient_y[i], sums.gradient_z[i]}};
      RegionValue<S> r = region_of(sum, exponent, scale);
      if (!is_sound(r)) r = evaluate_alone(set, d[i]);
      paths.velocity[i] += velocity_where(r, motion, thresholds, d[i]);
    }
  }
}

// The same for lanes of a bundle in one cell, at most kPlaces.
template <class S>
void evaluate_together(const SetCell<S>& cell, std::span<const std::uint16_t> lanes, const LanePlaces<S>& places,
                       int out, Bundle<S>& bundle) {
  SetPlaces<S> paths;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const std::size_t lane = lanes[i < lanes.size() ? i : 0];
    paths.x0[i] = bundle.origins[lane].x0;
    paths.at[i] = places[lane];
  }
  find_velocities(cell, paths);
  for (std::size_t i = 0; i < lanes.size(); ++i) set_slope(bundle, out, lanes[i], paths.velocity[i]);
}

// A stage of a step over the whole segment. Finds the cells in the first one. In a short segment path lines that begin
// in the same cell are evaluated together, which is faster and has other bits than one by one; so the segment and the
// stage alone decide which of the two is done.
template <class S>
void evaluate_from_start(const CellField<S>& field, Bundle<S>& bundle, const Stage<S>& stage) {
  using Cell = typename CellField<S>::Cell;
  const auto cell_of = [&](std::size_t lane) { return static_cast<Cell>(bundle.origins[lane].cell); };
  const LanePlaces<S> places(bundle, stage);
  std::array<std::uint16_t, kBundle> lanes{};
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    Origin& origin = bundle.origins[lane];
    if (stage.count == 0) origin.cell = field.cells.cell_at(origin.x0, static_cast<double>(bundle.t[lane]));
    const Cell cell = cell_of(lane);
    if (field.is_short && cell != nullptr && takes_several(*cell)) {
      lanes[count++] = static_cast<std::uint16_t>(lane);
    } else {
      set_slope(bundle, stage.out, lane, field.velocity(origin, places[lane]));
    }
  }
  std::sort(lanes.begin(), lanes.begin() + count,
            [&](std::uint16_t a, std::uint16_t b) { return cell_of(a)->index < cell_of(b)->index; });
  for (std::size_t first = 0, last = 0; first < count; first = last) {
    while (last < count && last < first + kPlaces && cell_of(lanes[last]) == cell_of(lanes[first])) ++last;
    evaluate_together(*cell_of(lanes[first]), std::span(lanes).subspan(first, last - first), places, stage.out, bundle);
  }
}

}  // namespace knead::detail
