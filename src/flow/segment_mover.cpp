// The kernels of segments with their fields, and the functions that move a group's points by them.
#include "flow/segment_mover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "field/grid.h"
#include "flow/closed_form.h"
#include "flow/culling.h"
#include "flow/pins.h"
#include "flow/segment_map.h"
#include "flow/sets.h"
#include "flow/step_rule.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

bool is_for_packs(const Region& region) {
  if (const auto* set = std::get_if<PointSet<double>>(&region)) {
    return set->curves.empty() && set->points.size() < kMinListedPoints;
  }
  return !std::holds_alternative<Handles<double>>(region) && !std::holds_alternative<CustomRegion>(region);
}

double contact_or_never(const void* segment, const Vec3d& x, double t, const void*& /*cell*/) {
  return next_contact(*static_cast<const Segment*>(segment), x, t).value_or(2);
}

template <class S>
Method<S> method_of(Integrator integrator) {
  const Tableau& from = tableau(integrator);
  Method<S> method;
  const auto add = [](Stage<S>& stage, double weight, int slope) {
    if (weight == 0) return;
    stage.weights[stage.count] = static_cast<S>(weight);
    stage.slopes[stage.count++] = static_cast<std::uint8_t>(slope);
  };
  for (int i = 0; i < from.stages; ++i) {
    method.stages[i].c = static_cast<S>(from.c[i]);
    method.stages[i].out = i;
    for (int j = 0; j < i; ++j) add(method.stages[i], from.a[i][j], j);
    add(method.slope, from.b[i], i);
    add(method.error, from.e[i], i);
  }
  method.stage_count = from.stages;
  method.error_order = from.error_order;
  method.extrapolates = from.order > from.error_order;
  method.first_same_as_last = from.first_same_as_last;
  return method;
}

template <class S>
void fill(SetPoints<S>& to, std::vector<S>& numbers, const PointSet<double>& set, double outer) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const Vec3d& p : set.points) numbers.push_back(static_cast<S>(p[axis]));
  }
  to.numbers = numbers.data();
  to.count = static_cast<int>(set.points.size());
  to.exponent = set.exponent;
  to.scale = static_cast<S>(outer);
}

// Finds the ball of SetPoints and its path.
template <class S>
void surround(SetPoints<S>& to, const PointSet<double>& set, const Segment& segment) {
  const Surround elements = surround_of(set);
  const double outer = segment.fields.front().thresholds.outer;
  to.middle = elements.center;
  to.radius = elements.radius + support_radius(set, outer) * (1 + 1e-4);
  to.path = segment.displacement * (segment.end - segment.begin);
  to.per_path2 = norm2(to.path) > 0 ? 1 / norm2(to.path) : 0;
}

// A kernel's field and the numbers of a set that it points to.
template <class S, template <class> class M, template <class> class R>
struct OwnedField {
  MaskedKernelField<S, M, R> field;
  std::vector<S> numbers;
  std::vector<double> exact_numbers;

  OwnedField(const Segment& segment, const SegmentMask& mask, const M<double>& motion, const auto& region) {
    const Field& from = segment.fields.front();
    if (mask.acts) {
      field.mask = view_of<S>(segment.mask, from.center);
      field.offset = Vec3<S>(mask.offsets.front());
    }
    field.motion = static_cast<M<S>>(motion);
    field.exact_motion = motion;
    if constexpr (std::is_same_v<R<S>, SetPoints<S>>) {
      fill(field.region, numbers, region, from.thresholds.outer);
      fill(field.exact_region, exact_numbers, region, from.thresholds.outer);
      surround(field.exact_region, region, segment);
    } else {
      field.region = static_cast<R<S>>(region);
      field.exact_region = region;
    }
    field.thresholds = static_cast<Thresholds<S>>(from.thresholds);
    field.exact_thresholds = from.thresholds;
    field.displacement = Vec3<S>(segment.displacement);
    field.exact_displacement = segment.displacement;
    field.center = from.center;
    field.begin = segment.begin;
    field.end = segment.end;
    if constexpr (std::is_same_v<M<S>, Strain<S>>)
      field.whole_strain = exp(motion.matrix * (segment.end - segment.begin));
  }
  OwnedField(const OwnedField&) = delete;
  OwnedField& operator=(const OwnedField&) = delete;
  ~OwnedField() = default;
};

template <template <class> class R>
struct RegionTag {};

// The region of a kernel's field.
RegionTag<Ball> tag_of(const Ball<double>& /*region*/) { return {}; }
RegionTag<Capsule> tag_of(const Capsule<double>& /*region*/) { return {}; }
RegionTag<HalfSpace> tag_of(const HalfSpace<double>& /*region*/) { return {}; }
RegionTag<SetPoints> tag_of(const PointSet<double>& /*region*/) { return {}; }

// Calls body with the kinds of the motion and the region, which the kernels order as the variants do.
template <class Body>
void with_kinds(const Field& field, const Body& body) {
  const auto motion_kind = static_cast<MotionKind>(field.motion.index());
  const auto region_kind = static_cast<RegionKind>(field.region.index());
  std::visit(
      [&](const auto& motion, const auto& region) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(motion)>, CustomMotion> && requires { tag_of(region); }) {
          body(motion_kind, motion, region_kind, tag_of(region), region);
        }
      },
      field.motion, field.region);
}

template <class S, template <class> class M, template <class> class R>
std::shared_ptr<const void> own_field(const Segment& segment, const SegmentMask& mask, const M<double>& motion,
                                      RegionTag<R> /*kind*/, const auto& region) {
  auto owned = std::make_shared<const OwnedField<S, M, R>>(segment, mask, motion, region);
  if (mask.acts) return {owned, &owned->field};
  return {owned, static_cast<const KernelField<S, M, R>*>(&owned->field)};
}

// A grid's field and the nodes that it points to.
template <class S>
struct OwnedGrid {
  GridNodes<S> nodes;
  GridKernelField<S> field;

  OwnedGrid(const Segment& segment, const SegmentMask& mask) : nodes(segment.grid) {
    field.grid = nodes.view;
    field.exact_grid = nodes.cells.template view<double>();
    field.center = nodes.cells.center();
    field.end = static_cast<S>(segment.end);
    if (mask.acts) field.mask = view_of<S>(segment.mask, field.center);
  }
  OwnedGrid(const OwnedGrid&) = delete;
  OwnedGrid& operator=(const OwnedGrid&) = delete;
  ~OwnedGrid() = default;
};

template <class S>
std::shared_ptr<const void> own_grid(const Segment& segment, const SegmentMask& mask) {
  const auto owned = std::make_shared<const OwnedGrid<S>>(segment, mask);
  return {owned, &owned->field};
}

template <class S>
BoundKernel<S> grid_kernel(const Segment& segment, const SegmentMask& mask, const Kernels<S>& kernels) {
  BoundKernel<S> result;
  result.kernel = mask.acts ? kernels.masked_grid : kernels.grid;
  result.field = own_grid<S>(segment, mask);
  result.next_contact = &contact_or_never;
  result.contact_data = &segment;
  if (segment.grid.end_coefficients.empty() && !mask.acts) result.kernel.limit = nullptr;
  return result;
}

template <class S>
BoundKernel<S> pack_kernel(const Segment& segment, const SegmentMask& mask, const Kernels<S>& kernels) {
  if (!segment.grid.is_empty()) return grid_kernel<S>(segment, mask, kernels);
  BoundKernel<S> result;
  with_kinds(segment.fields.front(), [&](MotionKind motion_kind, const auto& motion, RegionKind region_kind,
                                         auto region_tag, const auto& region) {
    result.kernel = (mask.acts ? kernels.masked : kernels.fields)[motion_kind][region_kind];
    result.field = own_field<S>(segment, mask, motion, region_tag, region);
  });
  result.next_contact = &contact_or_never;
  result.contact_data = &segment;
  const auto* space = std::get_if<HalfSpace<double>>(&segment.fields.front().region);
  if (space != nullptr && space->turn_angle == 0 && !mask.acts) result.kernel.limit = nullptr;
  return result;
}

// The part of a region's width that a step may pass.
double reach_in(const Region& region) {
  if (std::holds_alternative<Handles<double>>(region)) return kHandlesReach;
  return std::holds_alternative<Capsule<double>>(region) ? kCapsuleReach : kReach;
}

// The expected error, by the speed, of a step of third order that passes reach_of_step().
double expected_error(const Segment& segment) {
  double greatest = segment.grid.is_empty() ? 0 : kGridReach;
  for (const Field& field : segment.fields) greatest = std::max(greatest, reach_in(field.region));
  double error = kExpectedThirdOrderError * greatest * greatest * greatest;
  for (const Segment& part : segment.parts) error = std::max(error, expected_error(part));
  return error;
}

// The origin of positions: the first field's centre; the middle of pins and sums, in the planes in which they are
// mirrored; a node of a grid.
Vec3d center_of(const Segment& segment) {
  if (!segment.grid.is_empty()) return middle_node(segment.grid);
  if (segment.parts.empty() && segment.time_law != TimeLaw::pinned) return segment.fields.front().center;
  Box box;
  for (const Field& field : segment.fields) box.extend(field.center);
  for (const Segment& part : segment.parts) box.extend(center_of(part));
  Vec3d center = box.center();
  for (std::size_t axis = 0; axis < 3; ++axis) center[axis] = segment.mirrored_at[axis].value_or(center[axis]);
  return center;
}

template <class S>
SegmentTask<S> task_of(const Segment& segment, double tolerance) {
  const bool swept = segment.time_law == TimeLaw::swept;
  SegmentTask<S> task;
  task.center = center_of(segment);
  task.displacement = segment.displacement;
  if (swept) task.tool_velocity = Vec3<S>(segment.displacement);
  for (const Field& field : segment.fields) {
    const double speed = segment.time_law == TimeLaw::blended ? 0 : norm(displacement_of(segment, field));
    task.tool_speed = std::max(task.tool_speed, static_cast<S>(speed));
  }
  task.reach = static_cast<S>(reach_of_step(segment));
  task.tolerance = static_cast<S>(kErrorShare * tolerance);
  task.expected_error = static_cast<S>(expected_error(segment) / (kErrorShare * tolerance));
  task.begin = static_cast<S>(segment.begin);
  task.end = static_cast<S>(segment.end);
  task.carries = carries(segment);
  return task;
}

// Returns the members of the live blocks that the mask does not hold.
std::array<std::uint64_t, kBlocksPerGroup> without_held(const LiveGroup& group, const Mask& mask) {
  std::array<std::uint64_t, kBlocksPerGroup> members{};
  for (int k = 0; k < group.block_count; ++k) {
    const std::size_t block = group.blocks[k];
    members[block] = group.members[block];
    for (std::uint64_t rest = members[block]; rest != 0; rest &= rest - 1) {
      const auto bit = static_cast<std::size_t>(__builtin_ctzll(rest));
      const std::size_t i = block * kBlock + bit;
      if (mask.holds({group.points.x[i], group.points.y[i], group.points.z[i]})) {
        members[block] &= ~(std::uint64_t{1} << bit);
      }
    }
  }
  return members;
}

// A kernel whose positions are relative to a point of some planes across the axes. Points exactly in a plane stay
// there.
template <class S>
struct InPlanes {
  BoundKernel<S> inner;
  std::array<bool, 3> has_plane{};

  static void stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
    const auto& self = *static_cast<const InPlanes*>(data);
    self.inner.kernel.stage(self.inner.field.get(), bundle, stage);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t lane = 0; self.has_plane[axis] && lane < static_cast<std::size_t>(bundle.count); ++lane) {
        const bool is_in = bundle.base[axis][lane] == S(0) && (stage.from_start || bundle.moved[axis][lane] == S(0));
        if (is_in) bundle.k[stage.out][axis][lane] = S(0);
      }
    }
  }
  static void limit(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
    const auto& self = *static_cast<const InPlanes*>(data);
    self.inner.kernel.limit(self.inner.field.get(), bundle, from_start, limits);
  }
  static Classified classify(const void* data, const BlockTask& task) {
    const auto& self = *static_cast<const InPlanes*>(data);
    return self.inner.kernel.classify(self.inner.field.get(), task);
  }
};

template <class S>
BoundKernel<S> in_planes(BoundKernel<S> kernel, const std::array<std::optional<double>, 3>& planes) {
  if (planes == std::array<std::optional<double>, 3>{}) return kernel;
  BoundKernel<S> result = kernel;
  result.kernel.stage = &InPlanes<S>::stage;
  if (kernel.kernel.limit != nullptr) result.kernel.limit = &InPlanes<S>::limit;
  result.kernel.classify = &InPlanes<S>::classify;
  result.field = std::make_shared<const InPlanes<S>>(
      InPlanes<S>{std::move(kernel), {planes[0].has_value(), planes[1].has_value(), planes[2].has_value()}});
  return result;
}

template <class S>
BoundKernel<S> kernel_of_sum(const Segment& sum, const AdvectOptions& options, const Kernels<S>& kernels) {
  return in_planes<S>(sum_kernel<S>(sum, center_of(sum), options, kernels), sum.mirrored_at);
}

// Moves a segment's points by a kernel.
template <class S>
struct KernelMover {
  BoundKernel<S> bound;
  Method<S> method;
  SegmentTask<S> task;
  GroupCounts (*move)(const SegmentTask<S>&, const GroupTask<S>&);
  Mask mask;  // empty unless it acts

  KernelMover(const Segment& segment, const AdvectOptions& options, const Kernels<S>& kernels)
      : KernelMover(segment, mask_on(segment), options, kernels) {}
  KernelMover(const Segment& segment, const SegmentMask& mask_of, const AdvectOptions& options,
              const Kernels<S>& kernels)
      : KernelMover(segment, mask_of, options, kernels.move,
                    segment.parts.empty() ? kernel_of<S>(segment, options.tolerance, mask_of, kernels)
                                          : kernel_of_sum<S>(segment, options, kernels)) {}
  KernelMover(const Segment& segment, const SegmentMask& mask_of, const AdvectOptions& options,
              GroupCounts (*mover)(const SegmentTask<S>&, const GroupTask<S>&), BoundKernel<S> kernel)
      : bound(std::move(kernel)),
        method(method_of<S>(options.integrator)),
        task(task_of<S>(segment, options.tolerance)),
        move(mover) {
    task.kernel = bound.kernel;
    task.field = bound.field.get();
    task.method = &method;
    task.next_contact = bound.next_contact;
    task.contact_data = bound.contact_data;
    if (!mask_of.acts) return;
    mask = segment.mask;
    task.carries = false;  // the tool may carry a point to the border
  }
  KernelMover(const KernelMover&) = delete;
  KernelMover& operator=(const KernelMover&) = delete;
  ~KernelMover() = default;

  GroupCounts operator()(const LiveGroup& group) const {
    static thread_local const std::unique_ptr<Bundle<S>> bundle = std::make_unique<Bundle<S>>();
    static thread_local const std::unique_ptr<Bundle<S>> of_parts = std::make_unique<Bundle<S>>();
    bundle->own = of_parts.get();
    GroupTask<S> work{group, bundle.get()};
    std::array<std::uint64_t, kBlocksPerGroup> free{};
    if (!mask.is_empty()) {
      free = without_held(group, mask);
      work.members = free.data();
    }
    return move(task, work);
  }
};

// Moves points through the pieces of a pinned segment, one after the other.
template <class S>
class PinMover {
 public:
  PinMover(const Segment& segment, const AdvectOptions& options, const Kernels<S>& kernels) {
    std::vector<PinPiece> pieces = solve_pins(segment, options.tolerance, options.progress);
    const bool backwards = segment.end < segment.begin;
    if (backwards) std::reverse(pieces.begin(), pieces.end());
    const SegmentMask mask = mask_on(segment);
    for (const PinPiece& piece : pieces) {
      parts_.push_back(std::make_unique<Segment>(segment));
      Segment& part = *parts_.back();
      part.begin = backwards ? piece.end : piece.begin;
      part.end = backwards ? piece.begin : piece.end;
      movers_.push_back(std::make_unique<const KernelMover<S>>(part, mask, options, kernels.move,
                                                               kernel_of(part, piece, mask.acts, kernels)));
    }
  }

  GroupCounts operator()(LiveGroup group) const {
    GroupCounts sum;
    double* const moved = group.moved;
    std::array<double, kBlocksPerGroup> of_piece{};
    group.moved = of_piece.data();
    for (const auto& mover : movers_) {
      of_piece.fill(0);
      sum += (*mover)(group);
      for (std::size_t block = 0; block < kBlocksPerGroup; ++block) moved[block] += of_piece[block];
      if (!sum.complete) break;
      group.stop.before = sum.evaluations;
      group.between = 0;  // known at the first piece's beginning only
    }
    return sum;
  }

 private:
  static BoundKernel<S> kernel_of(const Segment& part, const PinPiece& piece, bool masked, const Kernels<S>& kernels) {
    BoundKernel<S> result;
    result.kernel = masked ? kernels.masked_pins : kernels.pins;
    const auto owned = std::make_shared<const OwnedPins<S>>(part, piece, center_of(part), masked);
    result.field = {owned, &owned->field};
    result.next_contact = &contact_or_never;
    result.contact_data = &part;
    return in_planes<S>(std::move(result), part.mirrored_at);
  }

  std::vector<std::unique_ptr<Segment>> parts_;  // the segment, limited to the pieces
  std::vector<std::unique_ptr<const KernelMover<S>>> movers_;
};

template <class Mover, class S>
SegmentMover shared_mover(const Segment& segment, const AdvectOptions& options, const Kernels<S>& kernels) {
  const auto mover = std::make_shared<const Mover>(segment, options, kernels);
  return [mover](const LiveGroup& group) { return (*mover)(group); };
}

template <class S>
SegmentMover kernel_mover(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels) {
  const bool pinned = segment.time_law == TimeLaw::pinned;
  return pinned ? shared_mover<PinMover<S>>(segment, options, kernels.in<S>())
                : shared_mover<KernelMover<S>>(segment, options, kernels.in<S>());
}

}  // namespace

template <class S>
BoundKernel<S> kernel_of(const Segment& segment, double tolerance, const SegmentMask& mask, const Kernels<S>& kernels) {
  return has_pack_kernel(segment) ? pack_kernel<S>(segment, mask, kernels) : lane_kernel<S>(segment, tolerance, mask);
}

template BoundKernel<float> kernel_of<float>(const Segment&, double, const SegmentMask&, const Kernels<float>&);
template BoundKernel<double> kernel_of<double>(const Segment&, double, const SegmentMask&, const Kernels<double>&);

std::vector<double> moved_copy(const SegmentMover& move, LiveGroup group) {
  std::vector<double> numbers;
  for (const double* from : {group.points.x, group.points.y, group.points.z}) {
    numbers.insert(numbers.end(), from, from + kGroup);
  }
  std::vector<std::uint32_t> steps(kGroup);
  std::array<double, kBlocksPerGroup> moved{};
  group.points = {numbers.data(), numbers.data() + kGroup, numbers.data() + 2 * kGroup};
  group.between = 0;
  group.steps = steps.data();
  group.moved = moved.data();
  move(group);
  return numbers;
}

bool is_within(const LimitCylinder& limit_cylinder, const Vec3d& x) {
  const Vec3d d = x - limit_cylinder.center;
  const Vec3d across = d - limit_cylinder.axis * dot(limit_cylinder.axis, d);
  return norm2(across) <= limit_cylinder.radius * limit_cylinder.radius;
}

double reach_of_step(const Segment& segment) {
  if (!segment.grid.is_empty()) return kGridReach * segment.grid.spacing;
  double reach = kInfinity;
  for (const Field& field : segment.fields) {
    if (std::holds_alternative<Handles<double>>(field.region)) continue;  // whose thresholds are no lengths
    reach = std::min(reach, reach_in(field.region) * (field.thresholds.outer - field.thresholds.inner));
  }
  for (const Segment& part : segment.parts) reach = std::min(reach, reach_of_step(part));
  return reach;
}

bool carries(const Segment& segment) {
  if (segment.fields.empty()) return false;
  const auto* motion = std::get_if<Translation<double>>(&segment.fields.front().motion);
  const bool handles = std::holds_alternative<Handles<double>>(segment.fields.front().region);  // have no rigid core
  return segment.fields.size() == 1 && segment.time_law == TimeLaw::swept && motion != nullptr &&
         motion->velocity == segment.displacement && !handles;
}

bool has_pack_kernel(const Segment& segment) {
  if (!segment.parts.empty() || is_map(segment)) return false;
  if (!segment.grid.is_empty()) return true;
  const Field& first = segment.fields.front();
  return segment.fields.size() == 1 && segment.time_law == TimeLaw::swept && is_for_packs(first.region) &&
         !std::holds_alternative<CustomMotion>(first.motion);
}

BoundGradients<0> gradient_kernel(const Segment& segment, const SegmentMask& mask, const JacobianKernels<0>& kernels) {
  BoundGradients<0> result;
  if (mask.acts || !has_pack_kernel(segment)) return result;
  if (!segment.grid.is_empty()) return {kernels.grid, own_grid<double>(segment, mask)};
  with_kinds(segment.fields.front(), [&](MotionKind motion_kind, const auto& motion, RegionKind region_kind,
                                         auto region_tag, const auto& region) {
    result = {kernels.fields[motion_kind][region_kind], own_field<double>(segment, mask, motion, region_tag, region)};
  });
  return result;
}

Method<double> method_in_double(Integrator integrator) { return method_of<double>(integrator); }

SegmentTask<double> task_in_double(const Segment& segment, double tolerance) {
  SegmentTask<double> task = task_of<double>(segment, tolerance);
  // The tools of a sum move differently: |v - u| of each is at most twice the greater of |v| and |u|.
  for (const Segment& part : segment.parts) {
    task.tool_speed = std::max(task.tool_speed, task_of<double>(part, tolerance).tool_speed);
  }
  if (!segment.parts.empty()) task.reach *= 0.5;
  return task;
}

SegmentMover make_segment_mover(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels) {
  if (is_map(segment)) return map_mover(segment);
  SegmentMover mover = mover_of_parts(segment, options, kernels);
  if (!mover) mover = make_kernel_mover(segment, options, kernels);
  return mover;
}

SegmentMover make_kernel_mover(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels) {
  const bool in_float = options.precision == Precision::float32;
  // NOLINTNEXTLINE(clang-analyzer-cplusplus.NewDeleteLeaks): what a std::function owns is taken for lost
  return in_float ? kernel_mover<float>(segment, options, kernels) : kernel_mover<double>(segment, options, kernels);
}

}  // namespace knead::detail
