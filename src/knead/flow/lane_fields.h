// Fields that are evaluated for one path line at a time. Internal to the flow room.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "knead/flow/closed_form.h"
#include "knead/flow/contact.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/set_cells.h"
#include "knead/flow/single_field.h"
#include "knead/flow/step_rule.h"

namespace knead::detail {

// Where a path line is in a stage of a step: it has moved so far since its origin at the time t.
template <class S>
struct LanePlace {
  Vec3<S> moved;
  S t{0};
};

template <class S>
Vec3<S> lane_of(const Lanes3<S>& numbers, std::size_t lane) {
  return {numbers[0][lane], numbers[1][lane], numbers[2][lane]};
}

// The places of all lanes of a bundle in a stage.
template <class S>
class LanePlaces {
 public:
  LanePlaces(const Bundle<S>& bundle, const Stage<S>& stage) {
    const auto count = static_cast<std::size_t>(bundle.count);
    for (std::size_t lane = 0; lane < count; ++lane) t_[lane] = bundle.t[lane] + bundle.h[lane] * stage.c;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      S* const moved = moved_[axis];
      for (std::size_t lane = 0; lane < count; ++lane) moved[lane] = S(0);
      for (int j = 0; j < stage.count; ++j) {
        const S* const k = bundle.k[stage.slopes[j]][axis];
        const S weight = stage.weights[j];
        for (std::size_t lane = 0; lane < count; ++lane) moved[lane] += k[lane] * weight;
      }
      for (std::size_t lane = 0; lane < count; ++lane) moved[lane] *= bundle.h[lane];
      if (stage.from_start) continue;
      for (std::size_t lane = 0; lane < count; ++lane) moved[lane] += bundle.moved[axis][lane];
    }
  }

  LanePlace<S> operator[](std::size_t lane) const { return {lane_of(moved_, lane), t_[lane]}; }

 private:
  Lanes3<S> moved_;
  S t_[kBundle];
};

template <class S>
void set_slope(Bundle<S>& bundle, int k, std::size_t lane, const Vec3<S>& v) {
  for (std::size_t axis = 0; axis < 3; ++axis) bundle.k[k][axis][lane] = v[axis];
}

// Several fields, summed. Rare (sums of point sets are in set_cells.h), so that an indirect call for each does not
// matter.
template <class S>
struct FieldSum {
  struct Part {
    std::function<Vec3<S>(const Vec3d&, const Vec3<S>&, double)> velocity;
    std::function<S(const Vec3d&, const Vec3<S>&, double)> hidden_speed;
    std::function<S(const Vec3d&, const Vec3<S>&, double)> width;
  };
  std::vector<Part> parts;

  Vec3<S> velocity(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    Vec3<S> sum{};
    for (const Part& part : parts) sum += part.velocity(x0, moved, t);
    return sum;
  }
  S hidden_speed(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    S greatest{0};
    for (const Part& part : parts) greatest = std::max(greatest, part.hidden_speed(x0, moved, t));
    return greatest;
  }
  S width(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    S least = std::numeric_limits<S>::infinity();
    for (const Part& part : parts) least = std::min(least, part.width(x0, moved, t));
    return least;
  }
};

// A segment whose field is the same function everywhere. F: a SingleField or FieldSum.
template <class S, class F>
struct WholeField {
  const Segment& segment;
  double reach = 0;     // reach_of_step
  bool masked = false;  // whether a mask acts
  F field;
  HandlePoints handles{segment};

  std::optional<double> next_contact(const void*& /*cell*/, const Vec3d& x, double t) const {
    return knead::next_contact(segment, x, t);
  }
  std::optional<Vec3d> closed_form(const Vec3d& x) const {
    if (masked) return std::nullopt;
    return handles.are_all() ? handles.closed_form(segment, x) : knead::closed_form(segment, x);
  }

  Vec3<S> velocity(const Origin& origin, const LanePlace<S>& at) const {
    return field.velocity(origin.x0, at.moved, static_cast<double>(at.t));
  }
};

// A segment of point sets, whose field is one function in each cell.
template <class S>
struct CellField {
  const Segment& segment;
  SetCells<S> cells;
  bool is_short;  // one step may cross the whole segment, as far as the tool's own motion goes

  CellField(const Segment& of, double tolerance, const SegmentMask& mask)
      : segment(of),
        cells(of, tolerance, mask),
        is_short(norm(of.displacement) * std::abs(of.end - of.begin) <= kThirdOrderReach * reach_of_step(of)) {}

  using Cell = const SetCell<S>*;

  std::optional<double> next_contact(const void*& cell, const Vec3d& x, double t) const {
    auto place = static_cast<Cell>(cell);
    const std::optional<double> contact = cells.next_contact(place, segment, x, t);
    cell = place;
    return contact;
  }
  static std::optional<Vec3d> closed_form(const Vec3d& /*x*/) { return std::nullopt; }

  Vec3<S> velocity(const Origin& origin, const LanePlace<S>& at) const {
    return cells.velocity(static_cast<Cell>(origin.cell), origin.x0, at.moved, static_cast<double>(at.t));
  }
};

}  // namespace knead::detail
