#include "knead/flow/path_jacobian.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "knead/field/dual.h"
#include "knead/field/mask_grid.h"
#include "knead/flow/closed_form.h"
#include "knead/flow/contact.h"
#include "knead/flow/masked.h"
#include "knead/flow/pins.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/step_rule.h"
#include "knead/math/error.h"
#include "knead/math/parallel.h"

namespace knead {

namespace {

constexpr std::size_t kPointsAtATime = 16;
// Of the pins' velocities, as a part of their radius.
constexpr double kPinTolerance = 1e-9;

bool is_cancelled(const AdvectOptions& options) { return options.progress != nullptr && options.progress->cancel; }

// v and its gradient, whose rows are those of its components.
struct Slope {
  Vec3d velocity{};
  Mat3d gradient{{}, {}, {}};
};

// The mask at a place, and what it takes from a field's potential; null: no mask acts.
struct MaskThere {
  MaskValue<Dual> value;
  Vec3d offset;
};

// v of one field at d from its centre where that rests.
Vec3<Dual> velocity_of(const Field& field, const Vec3<Dual>& d, double t, const MaskThere* mask) {
  return std::visit(
      [&](const auto& motion, const auto& region) -> Vec3<Dual> {
        constexpr bool own = std::is_same_v<std::decay_t<decltype(motion)>, CustomMotion> ||
                             std::is_same_v<std::decay_t<decltype(region)>, CustomRegion>;
        if constexpr (own) {
          throw InvalidInput("the derivatives of a custom motion or region are not known; use another field");
        } else {
          if (mask == nullptr) return velocity(motion, region, field.thresholds, d, Dual(t));
          const RegionValue<Dual> r = evaluate(region, d, Dual(t));
          return masked_velocity_where(r, motion, field.thresholds, d, mask->value, mask->offset);
        }
      },
      field.motion, field.region);
}

// Of a sum of fields. A pinned segment's are those of the time t, and rest.
Slope slope_of(const std::vector<Field>& fields, const Segment& segment, const detail::SegmentMask& mask,
               const Vec3d& x, double t) {
  Vec3<Dual> sum{};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Field& field = fields[i];
    const Vec3<Dual> d = variables(x - field.center);
    MaskThere there;
    if (mask.acts) there = {evaluate_mask(detail::view_of<double>(segment.mask, field.center), d), mask.offsets[i]};
    const MaskThere* const m = mask.acts ? &there : nullptr;
    if (segment.time_law != TimeLaw::blended) {
      sum += velocity_of(field, d - Vec3<Dual>(segment.displacement * t), t, m);
    } else {
      sum += velocity_of(field, d, 0, m) * Dual(1 - t);
      sum += velocity_of(field, d - Vec3<Dual>(segment.displacement), 0, m) * Dual(t);
    }
  }
  return {values(sum), {sum.x.g, sum.y.g, sum.z.g}};
}

// How fast the regions turn past a point.
double turning_speed(const Segment& segment, const Vec3d& x) {
  double angle = 0;
  Vec3d center{};
  for (const Field& field : segment.fields) {
    if (const auto* half_space = std::get_if<HalfSpace<double>>(&field.region)) angle = half_space->turn_angle;
    if (const auto* handles = std::get_if<Handles<double>>(&field.region)) angle = handles->turn_angle;
    center = field.center;
  }
  return std::abs(angle) * norm(x - center);
}

// What is asked for: where a motion is known in closed form, its determinant is 1.
enum class Wanted { determinant, jacobian };

// One point's path line through one segment, and its Jacobian.
class JacobianLine {
 public:
  JacobianLine(const Segment& segment, const AdvectOptions& options, Wanted wanted)
      : segment_(segment),
        wanted_(wanted),
        tableau_(tableau(options.integrator)),
        tolerance_(detail::kErrorShare * options.tolerance),
        direction_(segment.end >= segment.begin ? 1 : -1),
        reach_(detail::reach_of_step(segment)),
        mask_(detail::mask_on(segment)) {
    if (segment.time_law != TimeLaw::pinned) return;
    pieces_ = detail::solve_pins(segment, options.tolerance);
    for (const Field& field : segment.fields) pin_speed_ = std::max(pin_speed_, norm(displacement_of(segment, field)));
  }

  Vec3d velocity_at(const Vec3d& x, double t) const {
    return mask_.acts && segment_.mask.holds(x) ? Vec3d{} : slope_at(x, t).velocity;
  }

  void run(Vec3d& x, Mat3d& jacobian) {
    if (is_outside_barrel(x)) return;
    std::optional<double> contact = next_contact(segment_, x, segment_.begin);
    if (!contact) return;
    if (mask_.acts && segment_.mask.holds(x)) return;
    if (const std::optional<Vec3d> known = known_displacement(x)) {
      jacobian = known_gradient(*known) * jacobian;
      x += *known;
      return;
    }
    x_ = x;
    jacobian_ = jacobian;
    double t = *contact;
    double trial = std::abs(segment_.end - t);
    for (int steps = 0; (segment_.end - t) * direction_ > 0 && steps < kMostSteps; ++steps) {
      if (steps > 0 && slope_at(x_, t).velocity == Vec3d{}) {
        contact = next_contact(segment_, x_, t);
        if (!contact) break;
        t = *contact;
      }
      step(t, trial);
    }
    x = x_;
    jacobian = jacobian_;
  }

 private:
  static constexpr int kMostSteps = 10'000;

  bool is_outside_barrel(const Vec3d& x) const {
    if (!segment_.barrel) return false;
    const Vec3d d = x - segment_.barrel->point;
    return norm(cross(segment_.barrel->direction, d)) > segment_.barrel->radius;
  }

  // For the whole Jacobian, of the motions that are known in closed form only those whose gradient is known too.
  std::optional<Vec3d> known_displacement(const Vec3d& x) const {
    const Field& field = segment_.fields.front();
    const bool is_rigid = std::holds_alternative<Translation<double>>(field.motion) ||
                          std::holds_alternative<Handles<double>>(field.region);
    const bool is_wanted = wanted_ == Wanted::determinant || is_rigid;
    return mask_.acts || !is_wanted ? std::nullopt : closed_form(segment_, x);
  }

  Mat3d known_gradient(const Vec3d& displacement) const {
    const auto* turn = std::get_if<Rotation<double>>(&segment_.fields.front().motion);
    if (wanted_ == Wanted::determinant || turn == nullptr || displacement == Vec3d{}) return {};
    const Vec3d w = turn->axis * (turn->rate * (segment_.end - segment_.begin));
    return exp(Mat3d{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}});
  }

  Slope slope_at(const Vec3d& x, double t) const {
    if (segment_.time_law != TimeLaw::pinned) return slope_of(segment_.fields, segment_, mask_, x, t);
    return slope_of(detail::fields_at(segment_, pieces_, t), segment_, mask_, x, t);
  }

  double longest_step(const Vec3d& velocity) const {
    const Vec3d tool = segment_.time_law == TimeLaw::swept ? segment_.displacement : Vec3d{};
    const double speed = std::max({norm(velocity - tool), norm(tool), pin_speed_}) + turning_speed(segment_, x_);
    const double longest = std::isfinite(reach_) ? detail::step_rule::longest_step(speed, reach_) : 1.0 / 16;
    return segment_.time_law != TimeLaw::blended ? longest : std::min(longest, detail::kLeastBlendedStep);
  }

  void step(double& t, double& trial) {
    evaluate(0, t, {}, jacobian_);
    const double remaining = std::abs(segment_.end - t);
    const double longest = longest_step(slopes_[0]);
    const double shortest = detail::step_rule::shortest_step(longest, detail::kShortestPart<double>);
    for (;;) {
      const double h = detail::step_rule::chosen_step(trial, shortest, longest, remaining);
      const double error = try_step(t, h * direction_);
      const double relative = error / tolerance_;
      trial = h * detail::step_rule::step_factor(relative * relative, tableau_.error_order);
      if (error > tolerance_ && h > shortest) continue;
      const double signed_h = h * direction_;
      x_ += combine(slopes_, tableau_.b) * signed_h;
      jacobian_ = jacobian_ + combine(rates_, tableau_.b) * signed_h;
      t = h >= remaining ? segment_.end : t + signed_h;
      return;
    }
  }

  // The stages of a step; returns the error of x per unit of time.
  double try_step(double t, double h) {
    for (int i = 1; i < tableau_.stages; ++i) {
      evaluate(i, t + h * tableau_.c[i], combine(slopes_, tableau_.a[i], i) * h,
               jacobian_ + combine(rates_, tableau_.a[i], i) * h);
    }
    return norm(combine(slopes_, tableau_.e));
  }

  void evaluate(int stage, double t, const Vec3d& offset, const Mat3d& jacobian) {
    const Slope slope = slope_at(x_ + offset, t);
    slopes_[stage] = slope.velocity;
    rates_[stage] = slope.gradient * jacobian;
  }

  using Weights = std::array<double, Tableau::kMaxStages>;

  Vec3d combine(const std::array<Vec3d, Tableau::kMaxStages>& slopes, const Weights& weights) const {
    return combine(slopes, weights, tableau_.stages);
  }
  static Vec3d combine(const std::array<Vec3d, Tableau::kMaxStages>& slopes, const Weights& weights, int count) {
    Vec3d sum{};
    for (int j = 0; j < count; ++j) sum += slopes[j] * weights[j];
    return sum;
  }
  Mat3d combine(const std::array<Mat3d, Tableau::kMaxStages>& rates, const Weights& weights) const {
    return combine(rates, weights, tableau_.stages);
  }
  static Mat3d combine(const std::array<Mat3d, Tableau::kMaxStages>& rates, const Weights& weights, int count) {
    Mat3d sum{{}, {}, {}};
    for (int j = 0; j < count; ++j) sum = sum + rates[j] * weights[j];
    return sum;
  }

  const Segment& segment_;
  Wanted wanted_;
  const Tableau& tableau_;
  double tolerance_ = 0;
  double direction_ = 1;
  double reach_ = 0;
  detail::SegmentMask mask_;
  std::vector<detail::PinPiece> pieces_;  // of pins
  double pin_speed_ = 0;                  // the greatest
  Vec3d x_{};
  Mat3d jacobian_;
  std::array<Vec3d, Tableau::kMaxStages> slopes_{};
  std::array<Mat3d, Tableau::kMaxStages> rates_{};
};

}  // namespace

namespace {

// Moves the points, and returns the Jacobians. What a segment needs is made ready once.
std::vector<Mat3d> carry(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options, Wanted wanted) {
  validate(flow);
  validate({.tolerance = options.tolerance}, points.size());
  require_finite(points);
  std::vector<Mat3d> result(points.size());
  for (const Segment& segment : flow.segments) {
    const JacobianLine start(segment, options, wanted);
    parallel_for(points.size(), kPointsAtATime, options.threads, [&](std::size_t begin, std::size_t end) {
      JacobianLine line = start;
      for (std::size_t i = begin; i < end && !is_cancelled(options); ++i) {
        line.run(points[i], result[i]);
        if (options.progress != nullptr) ++options.progress->done;
      }
    });
    stop_if_cancelled(options.progress);
  }
  return result;
}

}  // namespace

std::vector<double> volume_drifts(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
  std::vector<double> drifts;
  for (const Mat3d& jacobian : carry(flow, points, options, Wanted::determinant)) {
    drifts.push_back(determinant(jacobian) - 1);
  }
  return drifts;
}

std::vector<Mat3d> jacobians(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options) {
  std::vector<Vec3d> moved(points.begin(), points.end());
  return carry(flow, moved, options, Wanted::jacobian);
}

std::vector<Vec3d> velocities(const Flow& flow, std::span<const Vec3d> points, double time) {
  validate(flow);
  require_finite(points);
  const std::size_t count = flow.segments.size();
  if (!(time >= 0 && time <= static_cast<double>(count))) {
    throw InvalidInput(
        fmt::format("the time must be from 0 to the flow's number of segments ({}), got {}", count, time));
  }
  std::vector<Vec3d> result(points.size());
  if (count == 0) return result;
  const std::size_t i = std::min(count - 1, static_cast<std::size_t>(time));
  const Segment& segment = flow.segments[i];
  AdvectOptions options;
  options.tolerance = kPinTolerance * segment.fields.front().thresholds.outer;
  const JacobianLine line(segment, options, Wanted::jacobian);
  const double rate = segment.end - segment.begin;
  const double t = segment.begin + (time - static_cast<double>(i)) * rate;
  parallel_for(points.size(), kPointsAtATime, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) result[k] = line.velocity_at(points[k], t) * rate;
  });
  return result;
}

}  // namespace knead
