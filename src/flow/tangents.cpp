// The numbers of a segment, v with its derivatives by them, and the integration of path lines with both.
#include "flow/tangents.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "field/grid.h"
#include "field/mask_grid.h"
#include "flow/closed_form.h"
#include "flow/masked.h"
#include "flow/pins.h"
#include "flow/segment_mover.h"
#include "flow/step_rule.h"
#include "flow/varying.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail {
namespace {

bool is_alike(const PointSet<double>& a, const PointSet<double>& b) {
  const auto are_equal = [](const auto& one, const auto& other) { return one.size() == other.size(); };
  return a.points.size() == b.points.size() && a.exponent == b.exponent &&
         std::equal(a.curves.begin(), a.curves.end(), b.curves.begin(), b.curves.end(), are_equal);
}

bool is_alike(const Field& a, const Field& b) {
  if (a.motion.index() != b.motion.index() || a.region.index() != b.region.index()) return false;
  if (a.thresholds.falloff != b.thresholds.falloff) return false;
  if (const auto* turn = std::get_if<Rotation<double>>(&a.motion)) {
    if (turn->zero_gauge != std::get<Rotation<double>>(b.motion).zero_gauge) return false;
  }
  if (const auto* set = std::get_if<PointSet<double>>(&a.region)) {
    return is_alike(*set, std::get<PointSet<double>>(b.region));
  }
  if (const auto* handles = std::get_if<Handles<double>>(&a.region)) {
    const auto& other = std::get<Handles<double>>(b.region);
    return is_alike(handles->full, other.full) && is_alike(handles->zero, other.zero);
  }
  return true;
}

bool is_alike(const Segment& a, const Segment& b) {
  const auto has_same_pin = [](const PinTurn& one, const PinTurn& other) { return one.pin == other.pin; };
  const auto fields = [](const Field& one, const Field& other) { return is_alike(one, other); };
  const auto parts = [](const Segment& one, const Segment& other) { return is_alike(one, other); };
  return std::equal(a.fields.begin(), a.fields.end(), b.fields.begin(), b.fields.end(), fields) &&
         a.time_law == b.time_law && a.limit_cylinder.has_value() == b.limit_cylinder.has_value() && a.mask == b.mask &&
         a.grid == b.grid && std::equal(a.turns.begin(), a.turns.end(), b.turns.begin(), b.turns.end(), has_same_pin) &&
         std::equal(a.parts.begin(), a.parts.end(), b.parts.begin(), b.parts.end(), parts);
}

constexpr double kPinPrecision = 1e-12;  // of the pins' velocities, by the radius
constexpr std::size_t kTimesOfPiece = 9;

std::vector<PinPiece> exact_pins(const Segment& segment, const Progress* progress) {
  std::vector<PinPiece> pieces = solve_pins(segment, kPinPrecision * segment.fields.front().thresholds.outer, progress);
  stop_if_cancelled(progress);
  return pieces;
}

// Chebyshev's nodes of each piece, in its own order.
std::vector<double> times_of(const std::vector<PinPiece>& pieces) {
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

// Calls next(number) for the numbers of a segment's fields, or those of its pins at these times.
template <class Next>
void read_fields(const Segment& segment, const SegmentMask& mask, std::span<const double> pin_times,
                 const Progress* progress, Next& next) {
  const Varied<Next> varied(next);
  if (segment.time_law == TimeLaw::pinned) {
    const std::vector<PinPiece> pieces = exact_pins(segment, progress);
    for (const double t : pin_times) {
      for (const Field& field : fields_at(segment, pieces, t)) varied(field);
    }
  } else {
    varied(segment.displacement);
    for (const Field& field : segment.fields) varied(field);
  }
  if (!mask.acts) return;
  for (const Vec3d& offset : mask.offsets) varied(offset);
}

// Returns the masks of parts_of(segment).
std::vector<SegmentMask> masks_of_parts(const Segment& segment, const std::vector<Segment>& parts) {
  return segment.parts.empty() ? std::vector<SegmentMask>{mask_on(segment)} : masks_on(segment, parts);
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
  const SegmentRates& rates_;
  std::size_t at_ = 0;
};

struct MaskAt {
  MaskValue<Varying> value;
  VaryingVec3 offset;
};

VaryingVec3 velocity_of(const VaryingField& field, const VaryingVec3& d, double t, const MaskAt* mask) {
  return std::visit(
      [&](const auto& motion, const auto& region) -> VaryingVec3 {
        if (mask == nullptr) return velocity(motion, region, field.thresholds, d, Varying(t));
        const RegionValue<Varying> r = evaluate(region, d, Varying(t));
        return masked_velocity_where(r, motion, field.thresholds, d, mask->value, mask->offset);
      },
      field.motion, field.region);
}

// A coordinate along which the second derivatives of v jump at whole numbers; if `at_ends`, at 0 and 1.
struct Kinks {
  double at = 0;
  bool at_ends = false;
};

// Returns the part of the path from one coordinate to another before the first kink; 1 if there is none.
double part_before_kink(const Kinks& from, const Kinks& to) {
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

// The fields of a segment that is no sum, with the derivatives of their numbers.
class VaryingFields {
 public:
  VaryingFields(const Segment& segment, SegmentMask mask, const SegmentRates& rates, NextRates& next,
                const Progress* progress)
      : segment_(segment), mask_(std::move(mask)), rates_(rates) {
    if (!segment.grid.is_empty()) nodes_ = std::make_unique<const GridNodes<double>>(segment.grid);
    const Varied<NextRates> varied(next);
    if (segment.time_law == TimeLaw::pinned) {
      pieces_ = exact_pins(segment, progress);
      count_numbers();
      if (mask_.acts && is_varied()) {
        throw InvalidInput("pins under a mask have no derivative with respect to parameters; leave out the mask");
      }
    } else {
      displacement_ = varied(segment.displacement);
      for (const Field& field : segment.fields) fields_.push_back(varied(field));
    }
    if (!mask_.acts) return;
    for (const Vec3d& offset : mask_.offsets) {
      offsets_.push_back(segment.time_law == TimeLaw::pinned ? VaryingVec3(offset) : varied(offset));
    }
  }

  VaryingVec3 velocity(const VaryingVec3& x, double t) const {
    if (nodes_ != nullptr) return grid_velocity(x, t);
    if (segment_.time_law == TimeLaw::pinned) return pin_velocity(x, t);
    VaryingVec3 sum;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const VaryingField& field = fields_[i];
      const VaryingVec3 d = x - field.center;
      MaskAt there;
      const MaskAt* const mask = mask_at(x, segment_.fields[i].center, i, there);
      if (segment_.time_law != TimeLaw::blended) {
        sum += velocity_of(field, d - displacement_ * Varying(t), t, mask);
      } else {
        sum += velocity_of(field, d, 0, mask) * Varying(1 - t);
        sum += velocity_of(field, d - displacement_, 0, mask) * Varying(t);
      }
    }
    return sum;
  }

  bool holds(const Vec3d& x) const { return mask_.acts && segment_.mask.holds(x); }

  // Appends the coordinates of x along which the second derivatives of v jump.
  void append_kinks(const Vec3d& x, double t, std::vector<Kinks>& to) const {
    if (nodes_ != nullptr) append_cells((x - nodes_->cells.center()) / nodes_->view.spacing, to);
    if (mask_.acts) {
      const MaskGrid& grid = segment_.mask.grid();
      append_cells((x - grid.origin) / grid.spacing, to);
    }
    if (segment_.time_law == TimeLaw::pinned) return;  // smooth
    for (const Field& field : segment_.fields) {
      const Vec3d d = x - field.center;
      if (segment_.time_law != TimeLaw::blended) {
        append_kinks_of(field, d - segment_.displacement * t, t, to);
      } else {
        append_kinks_of(field, d, 0, to);
        append_kinks_of(field, d - segment_.displacement, 0, to);
      }
    }
  }

 private:
  static void append_cells(const Vec3d& at, std::vector<Kinks>& to) {
    for (std::size_t axis = 0; axis < 3; ++axis) to.push_back({at[axis], false});
  }

  static void append_kinks_of(const Field& field, const Vec3d& d, double t, std::vector<Kinks>& to) {
    const auto& [inner, outer, falloff, bump] = field.thresholds;
    const double r = region_value(field, d, t).value;
    to.push_back({(r - inner) / (outer - inner), true});
    if (falloff == kWideFalloff) to.push_back({r / bump, true});
    const auto* capsule = std::get_if<Capsule<double>>(&field.region);
    const double length2 = capsule != nullptr ? norm2(capsule->half_axis) : 0;
    if (length2 > 0) to.push_back({0.5 * (1 + dot(capsule->half_axis, d) / length2), true});
  }

  bool is_varied() const {
    return std::any_of(rates_.begin(), rates_.end(), [](const auto& rates) { return !rates.empty(); });
  }

  // Null if no mask acts. The mask is fixed in space, so only x varies.
  const MaskAt* mask_at(const VaryingVec3& x, const Vec3d& center, std::size_t field, MaskAt& there) const {
    if (!mask_.acts) return nullptr;
    there = {evaluate_mask(view_of<double>(segment_.mask, center), x - VaryingVec3(center)), offsets_[field]};
    return &there;
  }

  VaryingVec3 grid_velocity(const VaryingVec3& x, double t) const {
    const Vec3d center = nodes_->cells.center();
    const VaryingVec3 y = x - VaryingVec3(center);
    const GridValue<Varying> value = evaluate_grid(nodes_->view, y, Varying(t));
    if (!mask_.acts) return value.velocity;
    const MaskValue<Varying> m = evaluate_mask(view_of<double>(segment_.mask, center), y);
    return value.velocity * m.value + cross(m.gradient, value.potential);
  }

  void count_numbers() {
    const auto count = [&](double number) {
      ++numbers_;
      return Varying(number);
    };
    const Varied varied(count);
    for (const Field& field : fields_at(segment_, pieces_, segment_.begin)) varied(field);
  }

  // The derivatives of the fields' numbers at a time: polynomials through those at Chebyshev's nodes.
  std::array<std::vector<double>, kTangents> pin_rates(double t) const {
    auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), t,
                                  [](double time, const PinPiece& next) { return time < next.begin; });
    if (piece != pieces_.begin()) --piece;
    const std::vector<double> times = times_of({*piece});
    std::array<double, kTimesOfPiece> weights{};  // of Lagrange
    for (std::size_t i = 0; i < kTimesOfPiece; ++i) {
      weights[i] = 1;
      for (std::size_t j = 0; j < kTimesOfPiece; ++j) {
        if (j != i) weights[i] *= (t - times[j]) / (times[i] - times[j]);
      }
    }
    constexpr std::size_t kBeginAndEnd = 2;
    const std::size_t first =
        kBeginAndEnd + static_cast<std::size_t>(piece - pieces_.begin()) * kTimesOfPiece * numbers_;
    std::array<std::vector<double>, kTangents> rates;
    for (std::size_t k = 0; k < kTangents; ++k) {
      if (rates_[k].empty()) continue;
      rates[k].assign(numbers_, 0);
      for (std::size_t i = 0; i < kTimesOfPiece; ++i) {
        const std::span<const double> at = rates_[k].subspan(first + i * numbers_, numbers_);
        for (std::size_t n = 0; n < numbers_; ++n) rates[k][n] += weights[i] * at[n];
      }
    }
    return rates;
  }

  VaryingVec3 pin_velocity(const VaryingVec3& x, double t) const {
    const std::array<std::vector<double>, kTangents> at_time = pin_rates(t);
    const SegmentRates rates{at_time[0], at_time[1], at_time[2]};
    NextRates next(rates);
    const Varied<NextRates> varied(next);
    VaryingVec3 sum;
    std::size_t i = 0;
    for (const Field& field : fields_at(segment_, pieces_, t)) {
      MaskAt there;
      const MaskAt* const mask = mask_at(x, field.center, i, there);
      const VaryingField varying = varied(field);
      sum += velocity_of(varying, x - varying.center, t, mask);
      ++i;
    }
    return sum;
  }

  const Segment& segment_;
  SegmentMask mask_;
  const SegmentRates& rates_;
  std::vector<VaryingField> fields_;
  VaryingVec3 displacement_;
  std::vector<VaryingVec3> offsets_;
  std::unique_ptr<const GridNodes<double>> nodes_;  // of a grid
  std::vector<PinPiece> pieces_;                    // of pins
  std::size_t numbers_ = 0;                         // of their fields at one time
};

constexpr std::size_t kPointsOfTask = 64;
constexpr double kMaxTangentStep = kMinBlendedStep;  // a first step does not see all of a blended segment
constexpr double kMinTangentStep = 1e-9;
constexpr double kMaxStepOverKink = 1e-6;
constexpr int kStepsPerCancelCheck = 64;
constexpr double kPartBeforeKink = 0.98;
constexpr double kErrorOfRates = 1e-12;  // of the greatest rate: the error of the differences that give rates

// A place and its derivatives.
using State = std::array<Vec3d, 1 + kTangents>;

void add(State& to, const State& slope, double h) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += slope[i] * h;
}

class TangentLine {
 public:
  TangentLine(const Segment& segment, const SegmentRates& rates, const TangentOptions& options)
      : segment_(segment), options_(options), parts_(parts_of(segment)) {
    constexpr std::size_t kBeginAndEnd = 2;
    NextRates next(rates);
    for (std::size_t k = 0; k < kTangents; ++k) {
      for (const double rate : rates[k]) rounding_[k] = std::max(rounding_[k], kErrorOfRates * std::abs(rate));
    }
    for (std::size_t i = 0; i < kBeginAndEnd; ++i) ends_[i] = next(i == 0 ? segment.begin : segment.end);
    std::vector<SegmentMask> masks = masks_of_parts(segment, parts_);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      fields_.push_back(
          std::make_unique<const VaryingFields>(parts_[i], std::move(masks[i]), rates, next, options.progress));
      const double reach = reach_of_step(parts_[i]);
      if (std::isfinite(reach)) reach_ = std::min(reach_, reach);
      for (const Field& field : parts_[i].fields) {
        tool_speed_ = std::max(tool_speed_, norm(displacement_of(parts_[i], field)));
        turning_ = std::max(turning_, turning_of(field));
        turning_center_ = field.center;
      }
    }
  }

  void move(State& state) const {
    const unsigned chosen = parts_around(parts_, state[0]);
    if (chosen == 0 || fields_.front()->holds(state[0])) return;
    shift(state, ends_[0], segment_.begin, -1, chosen);
    const std::optional<double> contact = next_contact(segment_, state[0], segment_.begin);
    if (contact) integrate(state, *contact, segment_.end, chosen);
    shift(state, ends_[1], segment_.end, 1, chosen);
  }

 private:
  static double turning_of(const Field& field) {
    if (const auto* space = std::get_if<HalfSpace<double>>(&field.region)) return std::abs(space->turn_angle);
    const auto* handles = std::get_if<Handles<double>>(&field.region);
    return handles != nullptr ? std::abs(handles->turn_angle) : 0;
  }

  // Adds the effect of a change of the segment's begin or end.
  void shift(State& state, const Varying& end, double t, double sign, unsigned chosen) const {
    if (end == Varying(end.v)) return;
    const Vec3d v = slope(state, t, chosen)[0];
    for (std::size_t k = 0; k < kTangents; ++k) state[1 + k] += v * (sign * end.g[k]);
  }

  State slope(const State& state, double t, unsigned chosen) const {
    VaryingVec3 x;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      x[axis] = Varying(state[0][axis], {state[1][axis], state[2][axis], state[3][axis]});
    }
    VaryingVec3 v;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if ((chosen >> i & 1U) != 0) v += fields_[i]->velocity(x, t);
    }
    State result{values_of(v)};
    for (std::size_t k = 0; k < kTangents; ++k) result[1 + k] = derivatives_of(v, k);
    for (std::size_t axis = 0; axis < 3; ++axis) {  // exactly parallel to the planes of a mirror
      const std::optional<double>& plane = segment_.mirrored_at[axis];
      if (plane && state[0][axis] == *plane) result[0][axis] = 0;
    }
    return result;
  }

  // Returns the error of a step per unit of time, in units of the allowed error.
  double excess(const State& state, const State& first, const State& error) const {
    double most = norm(error[0]) / options_.tolerance;
    for (std::size_t k = 1; k < state.size(); ++k) {
      const double size = std::max(norm(state[k]), norm(first[k]));
      const double allowed = std::max(options_.relative_tolerance * size, rounding_[k - 1]);
      if (allowed > 0) most = std::max(most, norm(error[k]) / allowed);
    }
    return most;
  }

  void find_kinks(const Vec3d& x, double t, unsigned chosen, std::vector<Kinks>& kinks) const {
    kinks.clear();
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if ((chosen >> i & 1U) != 0) fields_[i]->append_kinks(x, t, kinks);
    }
  }

  double longest_step(const State& state, const State& first) const {
    const double turning = turning_ * norm(state[0] - turning_center_);
    const double speed = norm(first[0]) + tool_speed_ + turning;
    return speed > 0 ? std::min(kMaxTangentStep, reach_ / speed) : kMaxTangentStep;
  }

  void integrate(State& state, double t, double end, unsigned chosen) const {
    const Tableau& method = tableau(Integrator::tsitouras);
    const double direction = end >= t ? 1 : -1;
    std::array<State, Tableau::kMaxStages> k;
    k[0] = slope(state, t, chosen);
    std::vector<Kinks> here;
    std::vector<Kinks> there;
    find_kinks(state[0], t, chosen, here);
    double h = 1e-3;
    for (int steps = 0; direction * (end - t) > 0; ++steps) {
      if (steps == kStepLimit || !std::isfinite(norm2(k[0][0]))) {
        throw InvalidInput(
            "a path line needs over a million steps, or runs to infinity; give points that the strokes do not take far "
            "away");
      }
      if (steps % kStepsPerCancelCheck == 0) stop_if_cancelled(options_.progress);
      const double longest = std::min(longest_step(state, k[0]), direction * (end - t));
      h = std::clamp(h, std::min(kMinTangentStep, longest), longest);
      const bool is_last = h == direction * (end - t);
      for (int i = 1; i < method.stages; ++i) {
        State at = state;
        for (int j = 0; j < i; ++j) add(at, k[j], direction * h * method.a[i][j]);
        k[i] = slope(at, t + direction * h * method.c[i], chosen);
      }
      State next = state;
      State error{};
      for (int i = 0; i < method.stages; ++i) {
        add(next, k[i], direction * h * method.b[i]);
        add(error, k[i], method.e[i]);
      }
      const double ratio = excess(state, k[0], error);
      const bool is_known = std::isfinite(ratio);
      const double factor = is_known ? std::clamp(0.9 / std::sqrt(std::sqrt(std::max(ratio, 1e-10))), 0.2, 4.0) : 0.2;
      if (!(ratio <= 1) && h > kMinTangentStep) {
        h *= factor;
        continue;
      }
      // The estimate does not see a kink that only the last stages have passed: a step ends before it, or is so short
      // that the kink does no harm.
      find_kinks(next[0], t + direction * h, chosen, there);
      double part = 1;
      for (std::size_t i = 0; i < here.size(); ++i) part = std::min(part, part_before_kink(here[i], there[i]));
      if (part < 1 && h > kMaxStepOverKink) {
        h = std::max(kPartBeforeKink * part * h, kMaxStepOverKink);
        continue;
      }
      std::swap(here, there);
      state = next;
      t = is_last ? end : t + direction * h;
      k[0] = method.first_same_as_last ? k[static_cast<std::size_t>(method.stages) - 1] : slope(state, t, chosen);
      h *= factor;
    }
  }

  const Segment& segment_;
  const TangentOptions& options_;
  std::vector<Segment> parts_;
  std::vector<std::unique_ptr<const VaryingFields>> fields_;  // of the parts
  std::array<Varying, 2> ends_;                               // the begin and the end
  std::array<double, kTangents> rounding_{};  // of derivatives: their error where they cancel, as at a pin
  double reach_ = kInfinity;                  // of a step
  double tool_speed_ = 0;
  double turning_ = 0;
  Vec3d turning_center_;
};

}  // namespace

SegmentNumbers::SegmentNumbers(const Segment& segment, const Progress* progress)
    : segment_(segment), progress_(progress) {
  if (segment.time_law != TimeLaw::pinned) return;
  pin_times_ = times_of(exact_pins(segment, progress));
}

std::optional<std::vector<double>> SegmentNumbers::of(const Segment& segment) const {
  if (!is_alike(segment, segment_)) return std::nullopt;
  std::vector<double> numbers{segment.begin, segment.end};
  const auto next = [&](double number) {
    numbers.push_back(number);
    return Varying(number);
  };
  const std::vector<Segment> parts = parts_of(segment);
  const std::vector<SegmentMask> masks = masks_of_parts(segment, parts);
  for (std::size_t i = 0; i < parts.size(); ++i) read_fields(parts[i], masks[i], pin_times_, progress_, next);
  return numbers;
}

void advect_tangents(const Segment& segment, const SegmentRates& rates, const TangentPoints& points,
                     const TangentOptions& options) {
  const TangentLine line(segment, rates, options);
  parallel_for(points.points.size(), kPointsOfTask, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      stop_if_cancelled(options.progress);
      State state{points.points[i], points.tangents[0][i], points.tangents[1][i], points.tangents[2][i]};
      line.move(state);
      points.points[i] = state[0];
      for (std::size_t k = 0; k < kTangents; ++k) points.tangents[k][i] = state[1 + k];
    }
    if (options.progress != nullptr) options.progress->done += end - begin;
  });
}

}  // namespace knead::detail
