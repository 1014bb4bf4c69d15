// Path lines with their Jacobians, velocities at a time, and volume drifts.
#include "flow/path_jacobian.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "field/dual.h"
#include "field/grid.h"
#include "field/mask_grid.h"
#include "flow/closed_form.h"
#include "flow/masked.h"
#include "flow/pins.h"
#include "flow/segment_map.h"
#include "flow/segment_mover.h"
#include "flow/step_rule.h"
#include "knead/error.h"

namespace knead {

namespace {

constexpr std::size_t kPointsAtATime = 256;
constexpr double kPinTolerance = 1e-9;  // of the pins' velocities, by their radius
// Where v depends on the time, steps are short, because the speed may grow within a step.
constexpr double kMaxUnsteadyStep = 1.0 / 16;

bool is_cancelled(const AdvectOptions& options) { return options.progress != nullptr && options.progress->cancel; }

using detail::Slope;
using detail::WantedJacobian;

// The mask at a place, and the offset of a field's potential.
struct MaskThere {
  MaskValue<Dual> value;
  Vec3d offset;
};

// Returns v of one field at d from its centre. mask: null if none acts.
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

// Of a sum of fields. `fields` of a pinned segment: those at the time t, at rest.
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

// Of a grid.
Slope slope_of(const detail::GridNodes<double>& nodes, const Segment& segment, const detail::SegmentMask& mask,
               const Vec3d& x, double t) {
  const Vec3d& center = nodes.cells.center();
  const Vec3<Dual> y = variables(x - center);
  const detail::GridValue<Dual> value = evaluate_grid(nodes.view, y, Dual(t));
  Vec3<Dual> v = value.velocity;
  if (mask.acts) {
    const MaskValue<Dual> m = evaluate_mask(detail::view_of<double>(segment.mask, center), y);
    v = v * m.value + cross(m.gradient, value.potential);
  }
  return {values(v), {v.x.g, v.y.g, v.z.g}};
}

// A kernel for one field whose numbers depend on variables, and the field; null if there is none.
template <template <class> class M, template <class> class R>
std::shared_ptr<const void> own_rated(const M<detail::Varying>& motion, const R<detail::Varying>& region,
                                      const detail::VaryingFields<detail::Varying>& fields) {
  const detail::VaryingField<detail::Varying>& field = fields.fields().front();
  const bool is_blended = fields.part().segment.time_law == TimeLaw::blended;
  return std::make_shared<const detail::RatedField<M, R>>(
      detail::RatedField<M, R>{motion, region, field.thresholds, fields.displacement(), field.center, is_blended});
}

std::shared_ptr<const void> own_rated(const detail::VaryingFields<detail::Varying>& fields) {
  const detail::VaryingField<detail::Varying>& field = fields.fields().front();
  return std::visit(
      [&](const auto& motion, const auto& region) -> std::shared_ptr<const void> {
        if constexpr (
            requires { region.zero; } || requires { region.points; }) {
          return nullptr;
        } else {
          return own_rated(motion, region, fields);
        }
      },
      field.motion, field.region);
}

bool turns(const Segment& segment) {
  return std::any_of(segment.fields.begin(), segment.fields.end(), [](const Field& field) {
    return std::visit(
        [](const auto& region) {
          if constexpr (requires { region.turn_angle; }) return region.turn_angle != 0;
          return false;
        },
        field.region);
  });
}

// Below this part of the reach of a step the error of a step that passes a kink would be seen; below the other one, as
// an error of the Jacobian.
constexpr double kToleranceThatSeesKinks = 1e-5;
constexpr double kJacobianToleranceThatSeesKinks = 1e-6;

bool sees_kinks(double reach, double tolerance, const WantedJacobian& wanted) {
  const bool sees_them = wanted.jacobian_tolerance > 0 && wanted.jacobian_tolerance < kJacobianToleranceThatSeesKinks;
  return std::isfinite(reach) && (sees_them || tolerance < kToleranceThatSeesKinks * reach);
}

// Moves the points through one segment, and multiplies their Jacobians.
void carry_through(const Segment& segment, std::span<Vec3d> points, std::span<Mat3d> jacobians,
                   const AdvectOptions& options, WantedJacobian wanted) {
  const detail::SegmentJacobians segment_jacobians(segment, options, wanted);
  parallel_for(points.size(), kPointsAtATime, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !is_cancelled(options); i += kPointsAtATime) {
      const std::size_t count = std::min(kPointsAtATime, end - i);
      std::vector<detail::JacobianStart> starts;
      for (std::size_t k = i; k < i + count; ++k) {
        if (const std::optional<double> t = segment_jacobians.meet(points[k], jacobians[k])) starts.push_back({k, *t});
      }
      segment_jacobians.move(starts, points, jacobians);
      if (options.progress != nullptr) options.progress->done += count;
    }
  });
  stop_if_cancelled(options.progress);
}

// The same for a sum with limit cylinders, one flow for each set of parts: a point's place at the beginning decides
// which parts move it.
void carry_through_limit_cylinders(const Segment& sum, std::span<Vec3d> points, std::span<Mat3d> jacobians,
                                   const AdvectOptions& options, WantedJacobian wanted) {
  std::vector<std::vector<std::size_t>> members_of(std::size_t{1} << sum.parts.size());
  for (std::size_t i = 0; i < points.size(); ++i) members_of[detail::parts_around(sum.parts, points[i])].push_back(i);
  for (unsigned parts = 0; parts < members_of.size(); ++parts) {
    const std::vector<std::size_t>& members = members_of[parts];
    if (parts == 0 && options.progress != nullptr) options.progress->done += members.size();
    if (parts == 0 || members.empty()) continue;
    std::vector<Vec3d> own_points;
    std::vector<Mat3d> own_jacobians;
    for (const std::size_t i : members) {
      own_points.push_back(points[i]);
      own_jacobians.push_back(jacobians[i]);
    }
    carry_through(detail::chosen_parts(sum, parts), own_points, own_jacobians, options, wanted);
    for (std::size_t k = 0; k < members.size(); ++k) {
      points[members[k]] = own_points[k];
      jacobians[members[k]] = own_jacobians[k];
    }
  }
}

// The same by a map in closed form.
void carry_by_map(const Segment& segment, std::span<Vec3d> points, std::span<Mat3d> jacobians,
                  const AdvectOptions& options) {
  const detail::SegmentMap map(segment);
  parallel_for(points.size(), kPointsAtATime, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !is_cancelled(options); ++i) {
      Mat3d jacobian;
      map.move(points[i], jacobian);
      jacobians[i] = jacobian * jacobians[i];
    }
    if (options.progress != nullptr) options.progress->done += end - begin;
  });
  stop_if_cancelled(options.progress);
}

// Moves the points, and returns the Jacobians.
std::vector<Mat3d> carry(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options,
                         WantedJacobian wanted) {
  validate(flow);
  validate({.tolerance = options.tolerance}, points.size());
  require_finite(points);
  std::vector<Mat3d> result(points.size());
  for (const Segment& segment : flow.segments) {
    if (detail::is_map(segment)) {
      carry_by_map(segment, points, result, options);
      continue;
    }
    detail::has_limit_cylinders(segment) ? carry_through_limit_cylinders(segment, points, result, options, wanted)
                                         : carry_through(segment, points, result, options, wanted);
  }
  return result;
}

}  // namespace

namespace detail {

void refuse_path_line() {
  throw InvalidInput(
      "a path line needs over a million steps, or runs to infinity; give points that the strokes do not take far away");
}

SegmentJacobians::SegmentJacobians(const Segment& segment, const AdvectOptions& options, WantedJacobian wanted,
                                   const SegmentRates& rates)
    : SegmentJacobians(segment, mask_on(segment), options, wanted) {
  take(rates);
}

SegmentJacobians::SegmentJacobians(const Segment& segment, SegmentMask mask, const AdvectOptions& options,
                                   WantedJacobian wanted)
    : segment_(segment),
      options_(options),
      wanted_(wanted),
      mask_(std::move(mask)),
      kernels_(kernels_in_use()),
      bound_(gradient_kernel(segment, mask_, kernels_.jacobians)),
      method_(method_in_double(options.integrator)),
      task_(task_in_double(segment, options.tolerance)),
      stops_at_kinks_(sees_kinks(task_.reach, options.tolerance, wanted)) {
  if (!segment.grid.is_empty()) nodes_ = std::make_unique<const GridNodes<double>>(segment.grid);
  if (!segment.parts.empty()) own_parts_ = parts_of(segment);
  if (!own_parts_.empty()) {
    std::vector<SegmentMask> masks = masks_on(segment, own_parts_);
    for (std::size_t i = 0; i < own_parts_.size(); ++i) {
      parts_.push_back(std::unique_ptr<const SegmentJacobians>(
          new SegmentJacobians(own_parts_[i], std::move(masks[i]), options, wanted)));
    }
  }
  if (segment.time_law == TimeLaw::pinned) pieces_ = solve_pins(segment, options.tolerance);
  task_.method = &method_;
  task_.next_contact = [](const void* of, const Vec3d& x, double t, const void*& /*cell*/) {
    return next_contact(*static_cast<const Segment*>(of), x, t).value_or(2);
  };
  task_.contact_data = &segment;
}

void SegmentJacobians::take(const SegmentRates& rates) {
  while (variables_ < kTangents && !rates[variables_].empty()) ++variables_;
  if (variables_ == 0) return;
  NextRates next(rates);
  for (Varying& end : ends_) end = next(0);
  for (std::size_t k = 0; k < variables_; ++k) {
    varies_in_space_ = varies_in_space_ || std::any_of(rates[k].begin() + ends_.size(), rates[k].end(),
                                                       [](double rate) { return rate != 0; });
    for (const double rate : rates[k]) rounding_[k] = std::max(rounding_[k], kErrorOfRates * std::abs(rate));
  }
  if (!varies_in_space_) return;
  std::vector<SegmentMask> masks{mask_};
  if (!own_parts_.empty()) masks = masks_on(segment_, own_parts_);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    const Segment& part = own_parts_.empty() ? segment_ : own_parts_[i];
    rated_parts_.push_back(std::make_unique<const PartOfSegment>(part, std::move(masks[i]), options_.progress));
    rated_.emplace_back(*rated_parts_.back(), next);
  }
  bind_rated();
}

// Finds a kernel of a single field whose numbers vary.
void SegmentJacobians::bind_rated() {
  const bool is_single =
      parts_.empty() && !mask_.acts && nodes_ == nullptr && pieces_.empty() && rated_.front().fields().size() == 1;
  if (!is_single) return;
  const std::shared_ptr<const void> field = own_rated(rated_.front());
  if (field == nullptr) return;
  const Field& own = segment_.fields.front();
  const auto kernel = [&](const auto& kernels) { return kernels.fields[own.motion.index()][own.region.index()]; };
  rated_by_one_ = {kernel(kernels_.tangents), field};
  rated_by_several_ = {kernel(kernels_.several_tangents), field};
}

Vec3d SegmentJacobians::velocity_at(const Vec3d& x, double t) const {
  return mask_.acts && segment_.mask.holds(x) ? Vec3d{} : slope_in_planes(x, t).velocity;
}

std::optional<double> SegmentJacobians::meet(Vec3d& x, Mat3d& jacobian) const {
  if (is_outside_limit_cylinder(x)) return std::nullopt;
  const std::optional<double> contact = next_contact(segment_, x, segment_.begin);
  if (!contact || (mask_.acts && segment_.mask.holds(x))) return std::nullopt;
  const std::optional<Vec3d> known = known_displacement(x);
  if (!known) return contact;
  jacobian = known_gradient(*known) * jacobian;
  x += *known;
  return std::nullopt;
}

void SegmentJacobians::move(std::span<const JacobianStart> starts, std::span<Vec3d> points, std::span<Mat3d> jacobians,
                            std::span<Vec3d> tangents) const {
  if (starts.empty()) return;
  if (!varies_in_space_) {
    for (const JacobianStart& start : starts) {
      std::fill_n(tangents.begin() + static_cast<std::ptrdiff_t>(start.point * variables_), variables_, Vec3d{});
    }
    move_with(kernels_.jacobians, starts, points, jacobians, {});
  } else if (variables_ == 1) {
    move_with(kernels_.tangents, starts, points, jacobians, tangents);
  } else {
    move_with(kernels_.several_tangents, starts, points, jacobians, tangents);
  }
}

void SegmentJacobians::add_shifts(const Vec3d& from, const Vec3d& to, const Mat3d& jacobian,
                                  std::span<Vec3d> tangents) const {
  for (const std::size_t end : {0U, 1U}) {
    if (ends_[end] == Varying(ends_[end].v)) continue;
    const Vec3d v = end == 0 ? -(jacobian * velocity_at(from, segment_.begin)) : velocity_at(to, segment_.end);
    for (std::size_t k = 0; k < tangents.size(); ++k) tangents[k] += v * ends_[end].g[k];
  }
}

template <std::size_t n>
void SegmentJacobians::move_with(const JacobianKernels<n>& kernels, std::span<const JacobianStart> starts,
                                 std::span<Vec3d> points, std::span<Mat3d> jacobians, std::span<Vec3d> tangents) const {
  JacobianTask<n> task = task_of_kernel<n>();
  task.starts = starts.data();
  task.count = starts.size();
  task.points = points.data();
  task.jacobians = jacobians.data();
  task.tangents = tangents.data();
  task.tangents_of_point = variables_;
  if (!kernels.move(task)) refuse_path_line();
}

void SegmentJacobians::carry_back(std::span<Vec3d> points, std::span<Vec3d> gradients, std::span<double> planes) const {
  std::vector<JacobianStart> starts;
  for (std::size_t i = 0; i < points.size(); ++i) starts.push_back({i, segment_.begin});
  const Vec3d& center = nodes_->cells.center();
  JacobianTask<0> task = task_of_kernel<0>();
  task.starts = starts.data();
  task.count = starts.size();
  task.points = points.data();
  task.gradients = gradients.data();
  task.sums = {nodes_->view, mask_.acts ? view_of<double>(segment_.mask, center) : MaskView<double>{}, center,
               planes.data(), std::ssize(nodes_->cells.used())};
  if (!kernels_.jacobians.carry_back(task)) refuse_path_line();
  stop_if_cancelled(options_.progress);
}

bool SegmentJacobians::is_outside_limit_cylinder(const Vec3d& x) const {
  if (!segment_.limit_cylinder) return false;
  const Vec3d d = x - segment_.limit_cylinder->center;
  return norm(cross(segment_.limit_cylinder->axis, d)) > segment_.limit_cylinder->radius;
}

// The whole Jacobian needs closed forms whose gradient is known too.
std::optional<Vec3d> SegmentJacobians::known_displacement(const Vec3d& x) const {
  if (segment_.fields.empty() || varies_in_space_) return std::nullopt;
  const Field& field = segment_.fields.front();
  const bool is_rigid = std::holds_alternative<Translation<double>>(field.motion) ||
                        std::holds_alternative<Handles<double>>(field.region);
  const bool is_wanted = wanted_.is_determinant || is_rigid;
  return mask_.acts || !is_wanted ? std::nullopt : closed_form(segment_, x);
}

Mat3d SegmentJacobians::known_gradient(const Vec3d& displacement) const {
  const auto* turn = std::get_if<Rotation<double>>(&segment_.fields.front().motion);
  if (wanted_.is_determinant || turn == nullptr || displacement == Vec3d{}) return {};
  const Vec3d w = turn->axis * (turn->rate * (segment_.end - segment_.begin));
  return exp(Mat3d{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}});
}

// Adds in the order of the kernel of sums.
Slope SegmentJacobians::slope_of_parts(const Vec3d& x, double t) const {
  std::vector<Slope> slopes;
  slopes.reserve(parts_.size());
  for (const auto& part : parts_) slopes.push_back(part->slope_at(x, t));
  for (std::size_t stride = 1; stride < slopes.size(); stride *= 2) {
    for (std::size_t k = 0; k + stride < slopes.size(); k += 2 * stride) {
      slopes[k].velocity += slopes[k + stride].velocity;
      slopes[k].gradient = slopes[k].gradient + slopes[k + stride].gradient;
    }
  }
  return slopes[0];
}

// In the planes in which the segment is mirrored, v is exactly parallel to them.
Slope SegmentJacobians::slope_in_planes(const Vec3d& x, double t) const {
  Slope slope = slope_at(x, t);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (segment_.mirrored_at[axis] && x[axis] == *segment_.mirrored_at[axis]) slope.velocity[axis] = 0;
  }
  return slope;
}

Slope SegmentJacobians::slope_at(const Vec3d& x, double t) const {
  if (!parts_.empty()) return slope_of_parts(x, t);
  if (nodes_ != nullptr) return slope_of(*nodes_, segment_, mask_, x, t);
  if (segment_.time_law != TimeLaw::pinned) return slope_of(segment_.fields, segment_, mask_, x, t);
  return slope_of(fields_at(segment_, pieces_, t), segment_, mask_, x, t);
}

void SegmentJacobians::append_kinks(const Vec3d& x, double t, std::vector<Kinks>& to) const {
  for (const auto& part : parts_) part->append_kinks(x, t, to);
  if (parts_.empty()) detail::append_kinks(segment_, nodes_.get(), mask_.acts, x, t, to);
}

// For fields that no kernel evaluates.
template <std::size_t n>
void SegmentJacobians::find_gradients_of_lane(const JacobianBundle<n>& places, double t, std::size_t lane,
                                              JacobianBundle<n>& slopes) const {
  const Vec3d x{places.of[0][lane], places.of[1][lane], places.of[2][lane]};
  const Slope slope = slope_in_planes(x, t);
  const Vec3d rows[4] = {slope.velocity, slope.gradient.row0, slope.gradient.row1, slope.gradient.row2};
  for (std::size_t k = 0; k < 12; ++k) slopes.of[k][lane] = rows[k / 3][k % 3];
  if constexpr (n > 0) {
    VaryingVec3 v;
    for (const VaryingFields<Varying>& fields : rated_) v += fields.velocity(VaryingVec3(x), t);
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) slopes.of[12 + 3 * k + axis][lane] = v[axis].g[k];
    }
  }
}

template <std::size_t n>
void SegmentJacobians::limit_steps(JacobianTask<n>& task) const {
  task.longest_step = std::isfinite(task_.reach) ? 1.0 : 1.0 / 16;
  if (segment_.time_law == TimeLaw::blended) task.longest_step = kMinBlendedStep;
  if (!segment_.grid.end_coefficients.empty()) task.longest_step = kMaxUnsteadyStep;
  for (const Segment& part : segment_.parts) {
    if (part.time_law == TimeLaw::blended || turns(part)) task.longest_step = kMinBlendedStep;
    if (!part.grid.end_coefficients.empty()) task.longest_step = std::min(task.longest_step, kMaxUnsteadyStep);
  }
  for (const Field& field : segment_.fields) {
    if (const auto* space = std::get_if<HalfSpace<double>>(&field.region)) task.turning = std::abs(space->turn_angle);
    if (const auto* handles = std::get_if<Handles<double>>(&field.region)) {
      task.turning = std::abs(handles->turn_angle);
    }
    task.turning_center = field.center;
  }
}

template <std::size_t n>
JacobianTask<n> SegmentJacobians::task_of_kernel() const {
  JacobianTask<n> task;
  task.segment = &task_;
  const BoundGradients<n>* bound = nullptr;
  if constexpr (n == 0) bound = &bound_;
  if constexpr (n == 1) bound = &rated_by_one_;
  if constexpr (n == kTangents) bound = &rated_by_several_;
  if (bound->find != nullptr) {
    task.find_gradients = bound->find;
    task.field = bound->field.get();
  } else {
    task.field = this;
    task.find_gradients = [](const void* data, const JacobianBundle<n>& places, const double* times,
                             std::uint32_t asked, JacobianBundle<n>& slopes) {
      const auto& self = *static_cast<const SegmentJacobians*>(data);
      for (std::size_t lane = 0; lane < kJacobianLanes; ++lane) {
        if ((asked >> lane & 1) == 0 || is_cancelled(self.options_)) continue;
        self.find_gradients_of_lane(places, times[lane], lane, slopes);
      }
    };
  }
  task.jacobian_tolerance = wanted_.jacobian_tolerance;
  std::copy_n(rounding_.begin(), n, task.tangent_rounding);
  limit_steps(task);
  if (stops_at_kinks_) {
    task.kinks = this;
    task.part_before_kink = [](const void* kinks, const Vec3d(&places)[3], double t, double end) {
      thread_local std::vector<Kinks> at[3];
      for (std::size_t k = 0; k < 3; ++k) {
        at[k].clear();
        const double time = t + 0.5 * static_cast<double>(k) * (end - t);
        static_cast<const SegmentJacobians*>(kinks)->append_kinks(places[k], time, at[k]);
      }
      double part = 1;
      for (std::size_t i = 0; i < at[0].size(); ++i) {
        const double of_half = detail::part_before_kink(at[0][i], at[1][i]);
        part = std::min(part, of_half < 1 ? 0.5 * of_half : 0.5 + 0.5 * detail::part_before_kink(at[1][i], at[2][i]));
      }
      return part;
    };
  }
  task.stop.asked = &options_;
  task.stop.ask = [](const void* asked, std::uint64_t /*evaluations*/) {
    return is_cancelled(*static_cast<const AdvectOptions*>(asked));
  };
  return task;
}

}  // namespace detail

std::vector<double> volume_drifts(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
  std::vector<double> drifts;
  for (const Mat3d& jacobian : carry(flow, points, options, {.is_determinant = true})) {
    drifts.push_back(determinant(jacobian) - 1);
  }
  return drifts;
}

std::vector<Mat3d> move_with_jacobians(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options,
                                       double jacobian_tolerance) {
  return carry(flow, points, options, {.jacobian_tolerance = jacobian_tolerance});
}

std::vector<Mat3d> jacobians(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options) {
  std::vector<Vec3d> moved(points.begin(), points.end());
  return carry(flow, moved, options, {});
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
  options.tolerance = segment.time_law != TimeLaw::pinned ? 1 : kPinTolerance * segment.fields.front().thresholds.outer;
  const double rate = segment.end - segment.begin;
  const double t = segment.begin + (time - static_cast<double>(i)) * rate;
  if (detail::is_map(segment)) {
    result = detail::map_velocities(segment, points, t);
    for (Vec3d& v : result) v = v * rate;
    return result;
  }
  const detail::SegmentJacobians line(segment, options, WantedJacobian{});
  parallel_for(points.size(), kPointsAtATime, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) result[k] = line.velocity_at(points[k], t) * rate;
  });
  return result;
}

}  // namespace knead
