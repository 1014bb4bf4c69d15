// Bounds of supports: for culling blocks of points, and for FlowSupport.
#include "flow/culling.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <variant>
#include <vector>

#include "flow/segment_mover.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

constexpr double kRoundingOfBox = 1e-9;  // of the bounds themselves

double rounding(const Field& field, const Surround& ball) {
  return kRoundingOfBox * (std::abs(field.thresholds.outer) + norm(ball.center - field.center) + ball.radius);
}

// The following return less than r anywhere in the ball during the sweep.
double least_value(const Ball<double>& /*region*/, const Culling::Sweep& sweep, const Surround& ball) {
  return distance_to_segment(ball.center, sweep.from, sweep.to) - ball.radius;
}

double least_value(const Capsule<double>& region, const Culling::Sweep& sweep, const Surround& ball) {
  const Vec3d d = ball.center - (sweep.from + sweep.to) * 0.5;
  return distance_to_segment(d, -region.half_axis, region.half_axis) - ball.radius - sweep.half_length;
}

double least_value(const HalfSpace<double>& region, const Culling::Sweep& sweep, const Surround& ball) {
  const Vec3d d = ball.center - (sweep.from + sweep.to) * 0.5;
  const double lever = region.turn_angle == 0 ? 0 : norm(cross(region.turn_axis, d)) + ball.radius;
  const double turned = std::abs(region.turn_angle) * sweep.half_time * lever;
  return dot(normal_at(region, sweep.middle), d) - ball.radius - sweep.half_length - turned;
}

double least_value(const CustomRegion& region, const Culling::Sweep& sweep, const Surround& ball) {
  const Vec3d d = ball.center - (sweep.from + sweep.to) * 0.5;
  return evaluate(region, d, sweep.middle).value - region.slope * (ball.radius + sweep.half_length) -
         region.speed * sweep.half_time;
}

// Not r: exceeds outer by the distance of the ball from the support.
double least_value(const PointSet<double>& /*region*/, const Culling::Sweep& sweep, const Surround& ball) {
  const Vec3d d = ball.center - sweep.elements.center;
  const double away = distance_to_segment(d, sweep.from, sweep.to) - sweep.elements.radius - sweep.radius;
  return sweep.field->thresholds.outer + away - ball.radius;
}

// The support of handles has no bounds.
double least_value(const Handles<double>& /*region*/, const Culling::Sweep& /*sweep*/, const Surround& /*ball*/) {
  return -kInfinity;
}

// For brushes, which are tested against many balls: without roots and divisions.
bool ball_misses(const Culling::Sweep& sweep, const Surround& ball) {
  const Vec3d d = ball.center - sweep.from;
  const double along = std::clamp(dot(d, sweep.path) * sweep.per_path2, 0.0, 1.0);
  const double reach = sweep.field->thresholds.outer + ball.radius;
  const double with_rounding = reach + 2 * kRoundingOfBox * (reach + sweep.half_length);
  return norm2(d - sweep.path * along) > with_rounding * with_rounding;
}

bool sweep_misses(const Culling::Sweep& sweep, const Surround& ball) {
  if (sweep.of_ball) return ball_misses(sweep, ball);
  const Field& field = *sweep.field;
  const double least = std::visit([&](const auto& region) { return least_value(region, sweep, ball); }, field.region);
  return least > field.thresholds.outer + rounding(field, ball);
}

bool is_beyond(const LimitCylinder& limit_cylinder, const Vec3d& center, double radius) {
  const Vec3d d = center - limit_cylinder.center;
  return norm(d - limit_cylinder.axis * dot(limit_cylinder.axis, d)) > (limit_cylinder.radius + radius) * (1 + 1e-12);
}

// The least radius of curvature, or an eighth of the length if that is less.
double feature_of(const CurveMotion& curve) {
  double most = 8 / curve.length;
  for (const CurveNode& node : curve.nodes) {
    for (const auto& [x, y] : {node.rest, node.bent}) most = std::max(most, std::sqrt(x * x + y * y));
  }
  return 1 / most;
}

// The least distance of control points.
double feature_of(const LatticeMotion& lattice) {
  double least = kInfinity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    least = std::min(least, lattice.lengths[axis] / (lattice.counts[axis] - 1));
  }
  return least;
}

double feature_of(const Field& field) {
  if (std::holds_alternative<HalfSpace<double>>(field.region)) return field.thresholds.outer - field.thresholds.inner;
  if (field.thresholds.falloff == kWideFalloff) return field.thresholds.bump;
  const bool is_distance = std::holds_alternative<Ball<double>>(field.region) ||
                           std::holds_alternative<Capsule<double>>(field.region) ||
                           std::holds_alternative<PointSet<double>>(field.region);
  return is_distance ? field.thresholds.outer : kInfinity;
}

}  // namespace

double support_radius(const PointSet<double>& set, double outer) {
  double copies = static_cast<double>(set.points.size());  // r >= copies^(-1/m) times the true distance
  for (const auto& curve : set.curves) {
    copies += integer_power(std::sqrt(std::sqrt(static_cast<double>(curve.size() - 1))), set.exponent);
  }
  return outer / inverse_root(copies, set.exponent);
}

Surround surround_of(const PointSet<double>& set) {
  Box box = bounding_box(set.points);
  for (const auto& curve : set.curves) {
    for (const Vec3d& p : curve) box.extend(p);
  }
  return {box.center(), 0.5 * box.diagonal()};
}

Box support_of(const Field& field, const Vec3d& displacement) {
  Box box;
  double radius = field.thresholds.outer;
  if (std::holds_alternative<Ball<double>>(field.region)) {
    box.extend({0, 0, 0});
  } else if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) {
    box.extend(capsule->half_axis);
    box.extend(-capsule->half_axis);
  } else if (const auto* set = std::get_if<PointSet<double>>(&field.region)) {
    const Surround elements = surround_of(*set);
    box.extend(elements.center);
    radius = elements.radius + support_radius(*set, field.thresholds.outer);
  } else {
    return {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  }
  const Vec3d by{radius, radius, radius};
  box = {box.min + field.center - by, box.max + field.center + by};
  Box moved = box;
  moved.extend(box.min + displacement);
  moved.extend(box.max + displacement);
  return moved;
}

Box support_of(const Segment& segment) {
  if (!segment.grid.is_empty()) {
    const Box used = box_in_use(segment.grid);
    const Vec3d by = Vec3d{1, 1, 1} * (2 * segment.grid.spacing);
    return {used.min - by, used.max + by};
  }
  if (!segment.curve.is_empty()) return {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  if (!segment.lattice.is_empty()) return bounding_box(segment.lattice);
  Box box;
  for (const Field& field : segment.fields) {
    const Box own = support_of(field, displacement_of(segment, field));
    box.extend(own.min);
    box.extend(own.max);
  }
  return box;
}

Culling::Culling(const Segment& segment) {
  for (const Segment& part : segment.parts) add(part, segment.begin, segment.end);
  if (segment.parts.empty()) add(segment, segment.begin, segment.end);
}

void Culling::add(const Segment& segment, double from, double to) {
  if (!segment.grid.is_empty()) grids_.push_back(std::make_shared<const GridSupport>(segment.grid));
  if (!segment.curve.is_empty()) curve_.emplace(segment);
  if (!segment.lattice.is_empty()) lattice_.emplace(segment);
  const bool blended = segment.time_law == TimeLaw::blended;  // both of its fields act all the time
  const double begin = blended ? 0 : from;
  const double end = blended ? 1 : to;
  for (const Field& field : segment.fields) {
    Sweep sweep;
    sweep.field = &field;
    const Vec3d by = displacement_of(segment, field);
    sweep.from = field.center + by * begin;
    sweep.to = field.center + by * end;
    sweep.begin = begin;
    sweep.middle = 0.5 * (begin + end);
    sweep.half_time = 0.5 * std::abs(end - begin);
    sweep.half_length = norm(by) * sweep.half_time;
    sweep.path = sweep.to - sweep.from;
    sweep.per_path2 = norm2(sweep.path) > 0 ? 1 / norm2(sweep.path) : 0;
    sweep.of_ball = std::holds_alternative<Ball<double>>(field.region);
    if (const auto* set = std::get_if<PointSet<double>>(&field.region)) {
      sweep.elements = surround_of(*set);
      sweep.radius = support_radius(*set, field.thresholds.outer) * (1 + 1e-4);
    }
    sweeps_.push_back(sweep);
  }
}

bool Culling::covers(const Surround& ball, bool or_inside) const {
  const auto covered = [&](const Sweep& sweep) {
    const bool is_distance = std::holds_alternative<Ball<double>>(sweep.field->region) ||
                             std::holds_alternative<Capsule<double>>(sweep.field->region) ||
                             std::holds_alternative<HalfSpace<double>>(sweep.field->region);
    if (!is_distance) return false;
    const bool turns = std::holds_alternative<Rotation<double>>(sweep.field->motion) ||
                       std::holds_alternative<Twist<double>>(sweep.field->motion);
    if (turns && !or_inside) return false;  // closed forms exist there too
    const double at_center = region_value(*sweep.field, ball.center - sweep.from, sweep.begin).value;
    const Thresholds<double>& thresholds = sweep.field->thresholds;
    // With a margin: single points may be rounded to the other side of a threshold.
    const double radius = ball.radius + rounding(*sweep.field, ball);
    return at_center + radius < thresholds.outer && (or_inside || at_center - radius >= thresholds.inner);
  };
  return std::any_of(sweeps_.begin(), sweeps_.end(), covered);
}

bool Culling::misses(const Surround& ball) const {
  if (curve_ && !curve_->misses(ball.center, ball.radius)) return false;
  if (lattice_ && !lattice_->misses(ball.center, ball.radius)) return false;
  const Vec3d half = Vec3d{1, 1, 1} * ball.radius;
  const Box box{ball.center - half, ball.center + half};
  const auto misses_box = [&](const auto& grid) { return grid->misses(box); };
  if (!std::all_of(grids_.begin(), grids_.end(), misses_box)) return false;
  return std::all_of(sweeps_.begin(), sweeps_.end(), [&](const Sweep& sweep) { return sweep_misses(sweep, ball); });
}

}  // namespace knead::detail

namespace knead {

struct FlowSupport::Parts {
  explicit Parts(const Flow& whole) : flow(detail::each_part(whole)) {
    for (const Segment& segment : flow.segments) {
      segments.emplace_back(segment);
      double& feature = features.emplace_back(segment.grid.is_empty() ? kInfinity : 2 * segment.grid.spacing);
      if (!segment.curve.is_empty()) feature = detail::feature_of(segment.curve);
      if (!segment.lattice.is_empty()) feature = detail::feature_of(segment.lattice);
      for (const Field& field : segment.fields) feature = std::min(feature, detail::feature_of(field));
    }
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() = default;

  bool may_move(std::size_t i, const Vec3d& center, double radius) const {
    const auto& limit_cylinder = flow.segments[i].limit_cylinder;
    if (limit_cylinder && detail::is_beyond(*limit_cylinder, center, radius)) return false;
    return !segments[i].misses({center, radius});
  }

  Flow flow;  // the bounds refer to its segments
  std::vector<detail::Culling> segments;
  std::vector<double> features;  // of the segments
};

FlowSupport::FlowSupport(const Flow& flow) : parts_(std::make_unique<const Parts>(flow)) {}
FlowSupport::~FlowSupport() = default;
FlowSupport::FlowSupport(FlowSupport&&) noexcept = default;
FlowSupport& FlowSupport::operator=(FlowSupport&&) noexcept = default;

bool FlowSupport::may_move(const Vec3d& center, double radius) const {
  for (std::size_t i = 0; i < parts_->segments.size(); ++i) {
    if (parts_->may_move(i, center, radius)) return true;
  }
  return false;
}

double FlowSupport::smallest_feature() const {
  return std::accumulate(parts_->features.begin(), parts_->features.end(), kInfinity,
                         [](double a, double b) { return std::min(a, b); });
}

double FlowSupport::smallest_feature(const Vec3d& center, double radius) const {
  double smallest = kInfinity;
  for (std::size_t i = 0; i < parts_->segments.size(); ++i) {
    if (parts_->features[i] < smallest && parts_->may_move(i, center, radius)) smallest = parts_->features[i];
  }
  return smallest;
}

}  // namespace knead
