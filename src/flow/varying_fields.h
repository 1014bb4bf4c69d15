// The fields of a segment in numbers that follow derivatives (Varying or Taped), and where their second derivatives
// jump. Internal to the library.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "field/grid.h"
#include "field/mask_grid.h"
#include "flow/closed_form.h"
#include "flow/masked.h"
#include "flow/pins.h"
#include "flow/segment_mover.h"
#include "flow/tangents.h"
#include "flow/varying.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail {

inline constexpr double kPinPrecision = 1e-12;  // of the pins' velocities, by the radius
inline constexpr std::size_t kTimesOfPiece = 9;
inline constexpr double kErrorOfRates = 1e-12;  // of the greatest rate: the error of the differences that give rates

inline std::vector<PinPiece> exact_pins(const Segment& segment, const Progress* progress) {
  std::vector<PinPiece> pieces = solve_pins(segment, kPinPrecision * segment.fields.front().thresholds.outer, progress);
  stop_if_cancelled(progress);
  return pieces;
}

// Chebyshev's nodes of each piece, in its own order.
inline std::vector<double> times_of(const std::vector<PinPiece>& pieces) {
  std::vector<double> times;
  for (const PinPiece& piece : pieces) {
    for (std::size_t k = 0; k < kTimesOfPiece; ++k) {
      const double angle = 3.14159265358979323846 * (static_cast<double>(k) + 0.5) / static_cast<double>(kTimesOfPiece);
      const double s = -sincos(angle).cos;
      times.push_back(0.5 * (piece.begin + piece.end) + 0.5 * s * (piece.end - piece.begin));
    }
  }
  return times;
}

// Returns the masks of parts_of(segment).
inline std::vector<SegmentMask> masks_of_parts(const Segment& segment, const std::vector<Segment>& parts) {
  return segment.parts.empty() ? std::vector<SegmentMask>{mask_on(segment)} : masks_on(segment, parts);
}

// A coordinate along which the second derivatives of v jump at whole numbers; if `at_ends`, at 0 and 1.
struct Kinks {
  double at = 0;
  bool at_ends = false;
};

// Returns the part of the path from one coordinate to another before the first kink; 1 if there is none.
inline double part_before_kink(const Kinks& from, const Kinks& to) {
  const double a = from.at;
  const double b = to.at;
  double kink = b > a ? std::floor(a) + 1 : std::ceil(a) - 1;
  if (from.at_ends) {
    if (b > a) kink = a < 0 ? 0 : 1;
    if (b < a) kink = a > 1 ? 1 : 0;
  }
  const bool is_between = b > a ? kink > a && kink < b : kink < a && kink > b;
  return is_between ? (kink - a) / (b - a) : 1;
}

inline void append_cells(const Vec3d& at, std::vector<Kinks>& to) {
  for (std::size_t axis = 0; axis < 3; ++axis) to.push_back({at[axis], false});
}

inline void append_kinks_of(const Field& field, const Vec3d& d, double t, std::vector<Kinks>& to) {
  const auto& [inner, outer, falloff, bump] = field.thresholds;
  const double r = region_value(field, d, t).value;
  to.push_back({(r - inner) / (outer - inner), true});
  if (falloff == kWideFalloff) to.push_back({r / bump, true});
  if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) {
    const double length2 = norm2(capsule->half_axis);
    if (length2 > 0) to.push_back({0.5 * (1 + dot(capsule->half_axis, d) / length2), true});
  }
}

// Appends the coordinates of x along which the second derivatives of v of a segment that is no sum jump. nodes: null if
// it is no grid.
inline void append_kinks(const Segment& segment, const GridNodes<double>* nodes, bool mask_acts, const Vec3d& x,
                         double t, std::vector<Kinks>& to) {
  if (nodes != nullptr) append_cells((x - nodes->cells.center()) / nodes->view.spacing, to);
  if (mask_acts) append_cells((x - segment.mask.grid().origin) / segment.mask.grid().spacing, to);
  if (segment.time_law == TimeLaw::pinned) return;  // smooth
  for (const Field& field : segment.fields) {
    const Vec3d d = x - field.center;
    if (segment.time_law != TimeLaw::blended) {
      append_kinks_of(field, d - segment.displacement * t, t, to);
    } else {
      append_kinks_of(field, d, 0, to);
      append_kinks_of(field, d - segment.displacement, 0, to);
    }
  }
}

// A segment that is no sum, with what its evaluation needs besides the numbers of its fields.
struct PartOfSegment {
  const Segment& segment;
  SegmentMask mask;
  std::unique_ptr<const GridNodes<double>> nodes;  // of a grid
  std::vector<PinPiece> pieces;                    // of pins
  std::size_t pin_numbers = 0;                     // of their fields at one time

  // The segment must outlive it.
  PartOfSegment(const Segment& part, SegmentMask mask_on_part, const Progress* progress)
      : segment(part), mask(std::move(mask_on_part)) {
    if (!segment.grid.is_empty()) nodes = std::make_unique<const GridNodes<double>>(segment.grid);
    if (!is_pinned()) return;
    pieces = exact_pins(segment, progress);
    const auto count = [&](double number) {
      ++pin_numbers;
      return Varying(number);
    };
    const Varied varied(count);
    for (const Field& field : fields_at(segment, pieces, segment.begin)) varied(field);
  }

  bool is_pinned() const { return segment.time_law == TimeLaw::pinned; }
  bool holds(const Vec3d& x) const { return mask.acts && segment.mask.holds(x); }

  void append_kinks(const Vec3d& x, double t, std::vector<Kinks>& to) const {
    detail::append_kinks(segment, nodes.get(), mask.acts, x, t, to);
  }
};

// The effect of a mask on one field at a place.
template <class S>
struct MaskAt {
  MaskValue<S> value;
  Vec3<S> offset;
};

template <class S>
Vec3<S> velocity_of(const VaryingField<S>& field, const Vec3<S>& d, double t, const MaskAt<S>* mask) {
  return std::visit(
      [&](const auto& motion, const auto& region) -> Vec3<S> {
        if (mask == nullptr) return velocity(motion, region, field.thresholds, d, S(t));
        const RegionValue<S> r = evaluate(region, d, S(t));
        return masked_velocity_where(r, motion, field.thresholds, d, mask->value, mask->offset);
      },
      field.motion, field.region);
}

// Gives one number after the other its derivatives.
class NextRates {
 public:
  explicit NextRates(const SegmentRates& rates) : rates_(rates) {}

  Varying operator()(double number) {
    Varying result(number);
    for (std::size_t k = 0; k < kTangents; ++k) {
      if (!rates_[k].empty()) result.g[k] = rates_[k][at_];
    }
    ++at_;
    return result;
  }

 private:
  SegmentRates rates_;
  std::size_t at_ = 0;
};

// The fields of a segment that is no sum, in numbers S.
template <class S>
class VaryingFields {
 public:
  // Takes the numbers from next(number) in the order of SegmentNumbers. The part must outlive it. Throws InvalidInput
  // for a custom motion or region, and for varying pins under a mask.
  template <class Next>
  VaryingFields(const PartOfSegment& part, Next& next) : part_(part) {
    const Varied<Next> varied(next);
    if (part.is_pinned()) {
      take_pins(next);
    } else {
      displacement_ = varied(part.segment.displacement);
      for (const Field& field : part.segment.fields) fields_.push_back(varied(field));
    }
    if (!part.mask.acts) return;
    for (const Vec3d& offset : part.mask.offsets) {
      offsets_.push_back(part.is_pinned() ? Vec3<S>(offset) : varied(offset));
    }
  }

  // Lets a grid's coefficients vary with the first variable, at rates that are the coefficients of another grid.
  void vary_grid(const GridNodes<double>* rates) requires std::is_same_v<S, Varying> { grid_rates_ = rates; }

  const std::vector<VaryingField<S>>& fields() const { return fields_; }  // none of a grid or of pins
  const Vec3<S>& displacement() const { return displacement_; }
  const PartOfSegment& part() const { return part_; }

  Vec3<S> velocity(const Vec3<S>& x, double t) const {
    if (part_.nodes != nullptr) return grid_velocity(x, t);
    if (part_.is_pinned()) return pin_velocity(x, t);
    const Segment& segment = part_.segment;
    Vec3<S> sum;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const VaryingField<S>& field = fields_[i];
      const Vec3<S> d = x - field.center;
      MaskAt<S> there;
      const MaskAt<S>* const mask = mask_at(x, segment.fields[i].center, i, there);
      if (segment.time_law != TimeLaw::blended) {
        sum += velocity_of(field, d - displacement_ * S(t), t, mask);
      } else {
        sum += velocity_of(field, d, 0, mask) * S(1 - t);
        sum += velocity_of(field, d - displacement_, 0, mask) * S(t);
      }
    }
    return sum;
  }

 private:
  // The derivatives of pins' numbers at Chebyshev's nodes. Their values are those of the pieces.
  template <class Next>
  void take_pins(Next& next) {
    bool is_varied = false;
    for (std::size_t n = part_.pieces.size() * kTimesOfPiece * part_.pin_numbers; n > 0; --n) {
      at_nodes_.push_back(next(0.0));
      is_varied = is_varied || !(at_nodes_.back() == S(0));
    }
    if (part_.mask.acts && is_varied) {
      throw InvalidInput("pins under a mask have no derivative with respect to parameters; leave out the mask");
    }
  }

  // Null if no mask acts. The mask is fixed in space, so only x varies.
  const MaskAt<S>* mask_at(const Vec3<S>& x, const Vec3d& center, std::size_t field, MaskAt<S>& there) const {
    if (!part_.mask.acts) return nullptr;
    there = {evaluate_mask(view_of<double>(part_.segment.mask, center), x - Vec3<S>(center)), offsets_[field]};
    return &there;
  }

  Vec3<S> grid_velocity(const Vec3<S>& x, double t) const {
    const Vec3d center = part_.nodes->cells.center();
    const Vec3<S> y = x - Vec3<S>(center);
    GridValue<S> value;
    if constexpr (std::is_same_v<S, Varying>) {
      if (part_.mask.acts) {
        value = evaluate_grid(part_.nodes->view, y, S(t));
      } else {
        value.velocity = by_slope(y, t);
      }
      if (grid_rates_ != nullptr) add_rates(evaluate_grid(grid_rates_->view, values_of(y), t), value);
    } else {
      value = evaluate_grid(part_.nodes->view, y, S(t));
    }
    if (!part_.mask.acts) return value.velocity;
    const MaskValue<S> m = evaluate_mask(view_of<double>(part_.segment.mask, center), y);
    return value.velocity * m.value + cross(m.gradient, value.potential);
  }

  // Returns v of a grid by its gradient.
  VaryingVec3 by_slope(const VaryingVec3& y, double t) const {
    const GridSlope<double> slope = slope_at(part_.nodes->view, values_of(y), t);
    VaryingVec3 v{Varying(slope.velocity.x), Varying(slope.velocity.y), Varying(slope.velocity.z)};
    for (std::size_t k = 0; k < kTangents; ++k) {
      const Vec3d along = derivatives_of(y, k);
      for (std::size_t axis = 0; axis < 3; ++axis) v[axis].g[k] = dot(slope.rows[axis], along);
    }
    return v;
  }

  static void add_rates(const GridValue<double>& rates, GridValue<Varying>& to) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to.velocity[axis].g[0] += rates.velocity[axis];
      to.potential[axis].g[0] += rates.potential[axis];
    }
  }

  // The fields' numbers at a time: their derivatives are polynomials through those at Chebyshev's nodes.
  class NextPin {
   public:
    NextPin(const std::vector<PinPiece>& pieces, const std::vector<S>& at_nodes, std::size_t numbers, double t)
        : at_nodes_(at_nodes), numbers_(numbers) {
      auto piece = std::upper_bound(pieces.begin(), pieces.end(), t,
                                    [](double time, const PinPiece& next) { return time < next.begin; });
      if (piece != pieces.begin()) --piece;
      at_ = static_cast<std::size_t>(piece - pieces.begin()) * kTimesOfPiece * numbers;
      const std::vector<double> times = times_of({*piece});
      for (std::size_t i = 0; i < kTimesOfPiece; ++i) {
        weights_[i] = 1;
        for (std::size_t j = 0; j < kTimesOfPiece; ++j) {
          if (j != i) weights_[i] *= (t - times[j]) / (times[i] - times[j]);
        }
      }
    }

    S operator()(double number) {
      S result(number);
      for (std::size_t i = 0; i < kTimesOfPiece; ++i) {
        result = S::chain(number, result, 1, at_nodes_[at_ + i * numbers_], weights_[i]);
      }
      ++at_;
      return result;
    }

   private:
    const std::vector<S>& at_nodes_;
    std::size_t numbers_;
    std::size_t at_ = 0;
    std::array<double, kTimesOfPiece> weights_{};  // of Lagrange
  };

  Vec3<S> pin_velocity(const Vec3<S>& x, double t) const {
    NextPin next(part_.pieces, at_nodes_, part_.pin_numbers, t);
    const Varied<NextPin> varied(next);
    Vec3<S> sum;
    std::size_t i = 0;
    for (const Field& field : fields_at(part_.segment, part_.pieces, t)) {
      MaskAt<S> there;
      const MaskAt<S>* const mask = mask_at(x, field.center, i, there);
      const VaryingField<S> varying = varied(field);
      sum += velocity_of(varying, x - varying.center, t, mask);
      ++i;
    }
    return sum;
  }

  const PartOfSegment& part_;
  std::vector<VaryingField<S>> fields_;
  Vec3<S> displacement_;
  std::vector<Vec3<S>> offsets_;
  std::vector<S> at_nodes_;  // of pins
  const GridNodes<double>* grid_rates_ = nullptr;
};

}  // namespace knead::detail
