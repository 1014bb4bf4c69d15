// Sums of segments: the parts that can move a point, and the kernel that adds the parts' velocities.
#include "flow/segment_mover.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <utility>

#include "flow/culling.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

static_assert(kMaxSummed == static_cast<int>(kMaxParts));

// Zones are enlarged by their rounding, which is greater in kernels, as these may compute in float.
constexpr double kMargin = 1e-6;
constexpr double kMarginInKernels = 1e-3;

using Chosen = std::uint8_t;  // parts, as bits

// The support of a part, a ball that moves along with it or a half-space; and bounds of the motion of a point that no
// other part moves.
struct Zone {
  bool in_space = false;
  Vec3d middle;  // of the ball at t = 0; the normal of the half-space
  Vec3d by;      // over the unit of time
  double extent = kInfinity;
  double longest_path = kInfinity;
  std::optional<Vec3d> axis{};  // of circles about `pivot` on which such a point moves
  Vec3d pivot{};
  double turn = kInfinity;  // the greatest angle of its motion in radians; infinity: not known
  SinCos<double> of_turn{};
};

// In the field of a ball, |v| is at most |w + dw/dr r / 2| of the tool's speed, across d.
double longest_path(const Field& field, double duration) {
  const auto* motion = std::get_if<Translation<double>>(&field.motion);
  const Thresholds<double>& between = field.thresholds;
  if (motion == nullptr || motion->gauge != 1 || between.falloff < kMinFalloff) return kInfinity;
  if (between.falloff == kWideFalloff) return norm(motion->velocity) * duration * (1 + kMargin);
  const double steepest = falloff_facts(between.falloff).slope / (between.outer - between.inner);
  return norm(motion->velocity) * duration * std::max(1.0, 0.5 * steepest * between.outer) * (1 + kMargin);
}

// The axis about which a field at rest turns every point by a constant angle (closed_form.h).
std::optional<Vec3d> axis_of(const Field& field) {
  const auto* rotation = std::get_if<Rotation<double>>(&field.motion);
  const auto* twist = std::get_if<Twist<double>>(&field.motion);
  const auto* space = std::get_if<HalfSpace<double>>(&field.region);
  if (rotation != nullptr && std::holds_alternative<Ball<double>>(field.region) &&
      rotation->zero_gauge == RotationGauge::radial) {
    return rotation->axis;
  }
  const bool is_along = twist != nullptr && space != nullptr && norm2(cross(space->normal, twist->axis)) <= 1e-24;
  return is_along && space->turn_angle == 0 ? std::optional(twist->axis) : std::nullopt;
}

Zone zone_of(const Segment& part) {
  Zone zone;
  Segment resting = part;  // its box moves along
  if (part.time_law == TimeLaw::swept) {
    zone.by = part.displacement;
    resting.displacement = {};
  }
  const Box box = support_of(resting);
  if (box.empty()) zone.extent = 0;
  if (!box.empty() && box.max.x < kFar) {
    zone.middle = box.center();
    zone.extent = 0.5 * box.diagonal() * (1 + kMargin);
  }
  if (part.fields.size() != 1 || part.time_law != TimeLaw::swept) return zone;
  const Field& field = part.fields.front();
  if (std::holds_alternative<Ball<double>>(field.region)) {
    zone.extent = field.thresholds.outer * (1 + kMargin);
    zone.longest_path = longest_path(field, std::abs(part.end - part.begin));
  }
  if (part.displacement != Vec3d{}) return zone;
  zone.axis = axis_of(field);
  zone.pivot = field.center;
  const auto* rotation = std::get_if<Rotation<double>>(&field.motion);
  if (rotation != nullptr && rotation->gauge == 0) {
    zone.turn = rotation->rate * (part.end - part.begin);
    zone.of_turn = sincos(zone.turn);
  }
  const auto* space = std::get_if<HalfSpace<double>>(&field.region);
  if (space != nullptr && space->turn_angle == 0) {
    zone.in_space = true;
    zone.middle = space->normal;
    zone.extent = dot(space->normal, field.center) + field.thresholds.outer;
    zone.extent += kMargin * (std::abs(zone.extent) + field.thresholds.outer - field.thresholds.inner);
  }
  return zone;
}

// Returns, as bits, the points of a block that come nearer to a zone than the margin at some time.
std::uint64_t near_zone(const Zone& zone, const Coordinates& points, double margin) {
  const double extent = zone.extent + margin;
  if (!(extent < kInfinity)) return ~std::uint64_t{0};
  std::array<double, kBlock> excess{};
  const Vec3d m = zone.middle;
  const double per_by2 = zone.by == Vec3d{} ? 0 : 1 / norm2(zone.by);
  for (std::size_t i = 0; i < kBlock; ++i) {
    const Vec3d x{points.x[i], points.y[i], points.z[i]};
    const double along = std::min(std::max(dot(x - m, zone.by) * per_by2, 0.0), 1.0);
    excess[i] = zone.in_space ? dot(m, x) - extent : norm2(x - m - zone.by * along) - extent * extent;
  }
  std::uint64_t near = 0;
  for (std::size_t i = 0; i < kBlock; ++i) near |= std::uint64_t{excess[i] < 0} << i;
  return near;
}

// Returns whether a point that turns about the axis of `own` may enter another zone.
bool turn_meets(const Zone& own, const Vec3d& x, const Zone& other) {
  const Vec3d& axis = *own.axis;
  const double height = dot(axis, x - own.pivot);
  const Vec3d arm = x - own.pivot - axis * height;
  if (other.in_space) {
    const double level = dot(axis, other.middle);
    const double nearest =
        dot(other.middle, own.pivot) + height * level - norm(arm) * norm(other.middle - axis * level);
    return nearest < other.extent;
  }
  if (other.by != Vec3d{} || !(other.extent < kInfinity)) return true;
  const Vec3d to = other.middle - own.pivot;
  const double along = dot(axis, to);
  const Vec3d across = to - axis * along;
  const double apart = norm(arm) - norm(across);
  if ((height - along) * (height - along) + apart * apart >= other.extent * other.extent) return false;
  if (!(std::abs(own.turn) <= std::numbers::pi)) return true;
  // The nearest place to the other zone lies within the arc, or is an end of it.
  const double sign = own.turn < 0 ? -1 : 1;
  const Vec3d end = arm * own.of_turn.cos + cross(axis, arm) * own.of_turn.sin;
  if (dot(axis, cross(arm, across)) * sign >= 0 && dot(axis, cross(across, end)) * sign >= 0) return true;
  return norm(end + axis * height - to) < other.extent;
}

// Returns whether a point can be in both zones, or move from one to the other.
bool may_meet(const Zone& a, const Zone& b) {
  if (a.in_space || b.in_space || !(a.extent + b.extent < kInfinity)) return true;
  const Vec3d d = (b.middle + b.by * 0.5) - (a.middle + a.by * 0.5);
  return norm(d) < a.extent + b.extent + 0.5 * (norm(a.by) + norm(b.by));
}

// Finds the parts of a sum that a point can meet.
class PartsNearby {
 public:
  explicit PartsNearby(const std::vector<Segment>& parts) {
    for (const Segment& part : parts) zones_.push_back(zone_of(part));
    const std::size_t count = zones_.size();
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < count; ++k) {
        if (may_meet(zones_[i], zones_[k])) neighbours_[i] |= static_cast<Chosen>(1U << k);
      }
    }
  }

  // Limits the parts of each point of a block to those that it can meet.
  void choose(const Coordinates& points, std::uint64_t members, Chosen* parts) const {
    std::array<std::uint64_t, kMaxParts> near{};
    std::uint64_t any = 0;
    std::uint64_t several = 0;
    for (std::size_t i = 0; i < zones_.size(); ++i) {
      near[i] = near_zone(zones_[i], points, 0);
      several |= any & near[i];
      any |= near[i];
    }
    std::uint64_t alone = 0;
    for (std::size_t i = 0; i < zones_.size(); ++i) {
      const std::uint64_t own = near[i] & ~several & members;
      if (own != 0) alone |= own & ~meets_others(i, points, own);
    }
    for (std::size_t k = 0; k < kBlock; ++k) {
      Chosen own = 0;
      for (std::size_t i = 0; i < zones_.size(); ++i) own |= static_cast<Chosen>((near[i] >> k & 1) << i);
      parts[k] &= (alone >> k & 1) != 0 ? own : connected(own);
    }
  }

 private:
  // Returns which of the points that part i alone moves at first may enter another zone.
  std::uint64_t meets_others(std::size_t i, const Coordinates& points, std::uint64_t own) const {
    const Zone& zone = zones_[i];
    std::uint64_t meets = 0;
    for (std::size_t k = 0; k < zones_.size(); ++k) {
      if (k == i || (neighbours_[i] >> k & 1) == 0) continue;
      if (!zone.axis) {
        meets |= near_zone(zones_[k], points, zone.longest_path);
        continue;
      }
      for (std::uint64_t rest = own; rest != 0; rest &= rest - 1) {
        const auto at = static_cast<std::size_t>(__builtin_ctzll(rest));
        const bool is_met = turn_meets(zone, {points.x[at], points.y[at], points.z[at]}, zones_[k]);
        meets |= std::uint64_t{is_met} << at;
      }
    }
    return meets;
  }

  // Returns these parts, and all whose zones a point may enter from them.
  Chosen connected(Chosen parts) const {
    for (Chosen before = 0; parts != before;) {
      before = parts;
      for (std::size_t i = 0; i < zones_.size(); ++i) {
        if ((before >> i & 1) != 0) parts |= neighbours_[i];
      }
    }
    return parts;
  }

  std::vector<Zone> zones_;
  std::array<Chosen, kMaxParts> neighbours_{};
};

// Movers of some of the parts, from the sum's beginning to a time; made on demand.
class ChosenMovers {
 public:
  ChosenMovers(const Segment& sum, double end, const AdvectOptions& options, const KernelTable& kernels)
      : sum_(sum), end_(end), options_(options), kernels_(kernels) {}

  const SegmentMover& of(unsigned parts) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::unique_ptr<Mover>& mover = movers_[parts];
    if (mover == nullptr) {
      mover = std::make_unique<Mover>(Mover{chosen_parts(sum_, parts), {}});
      mover->segment.end = end_;
      mover->move = make_kernel_mover(mover->segment, options_, kernels_);
    }
    return mover->move;
  }

 private:
  struct Mover {
    Segment segment;
    SegmentMover move;
  };
  const Segment& sum_;
  double end_;
  AdvectOptions options_;
  const KernelTable& kernels_;
  mutable std::mutex mutex_;
  mutable std::array<std::unique_ptr<Mover>, 1U << kMaxParts> movers_;
};

class SumMover {
 public:
  SumMover(const Segment& sum, const AdvectOptions& options, const KernelTable& kernels)
      : sum_(sum), movers_(sum, sum.end, options, kernels), to_start_(sum, 0, options, kernels) {
    if (sum.mask.is_empty()) in_reach_.emplace(parts_of(sum));
  }

  GroupCounts operator()(LiveGroup group) const {
    GroupParts chosen;
    chosen.fill(static_cast<Chosen>((1U << sum_.parts.size()) - 1));
    if (has_limit_cylinders(sum_)) chosen = parts_by_limit_cylinders(group);
    std::bitset<1U << kMaxParts> used;
    for (int k = 0; k < group.block_count; ++k) {
      const std::size_t first = group.blocks[k] * kBlock;
      if (in_reach_) in_reach_->choose(block_at(group.points, first), group.members[group.blocks[k]], &chosen[first]);
      for (std::size_t i = first; i < first + kBlock; ++i) used.set(chosen[i]);
    }
    GroupCounts sum;
    for (unsigned parts = 1; parts < used.size() && sum.complete; ++parts) {
      if (used.test(parts)) move(parts, chosen, group, sum);
    }
    return sum;
  }

 private:
  using GroupParts = std::array<Chosen, kGroup>;

  static Coordinates block_at(const Coordinates& points, std::size_t first) {
    return {points.x + first, points.y + first, points.z + first};
  }

  // Moves the points that these parts move together, and adds the counts.
  void move(unsigned parts, const GroupParts& chosen, LiveGroup& group, GroupCounts& sum) const {
    std::array<std::uint64_t, kBlocksPerGroup> members{};
    std::uint64_t any = 0;
    for (int k = 0; k < group.block_count; ++k) {
      const std::size_t block = group.blocks[k];
      for (std::size_t i = 0; i < kBlock; ++i) {
        members[block] |= std::uint64_t{chosen[block * kBlock + i] == parts} << i;
      }
      members[block] &= group.members[block];
      any |= members[block];
    }
    if (any == 0) return;
    LiveGroup own = group;
    own.members = members.data();
    own.between = 0;  // known for the sum of all parts only
    sum += movers_.of(parts)(own);
    group.stop.before = sum.evaluations;
  }

  // Returns the parts that move each point of the group: those that would move it back to a place at t = 0 in the limit
  // cylinders of the same parts.
  GroupParts parts_by_limit_cylinders(const LiveGroup& group) const {
    GroupParts chosen{};
    const auto choose = [&](const Coordinates& at, unsigned parts) {
      for (int k = 0; k < group.block_count; ++k) {
        for (std::uint64_t rest = group.members[group.blocks[k]]; rest != 0; rest &= rest - 1) {
          const std::size_t i = group.blocks[k] * kBlock + static_cast<std::size_t>(__builtin_ctzll(rest));
          const auto there = static_cast<Chosen>(parts_around(sum_.parts, {at.x[i], at.y[i], at.z[i]}));
          if (chosen[i] == 0 && (parts == 0 || there == parts)) chosen[i] = there;
        }
      }
    };
    if (sum_.begin == 0) choose(group.points, 0);
    for (unsigned parts = 1; sum_.begin != 0 && parts < 1U << sum_.parts.size(); ++parts) {
      std::vector<double> numbers = moved_copy(to_start_.of(parts), group);
      choose({numbers.data(), numbers.data() + kGroup, numbers.data() + 2 * kGroup}, parts);
    }
    return chosen;
  }

  const Segment& sum_;
  ChosenMovers movers_;
  ChosenMovers to_start_;
  std::optional<PartsNearby> in_reach_;  // nothing under a mask, whose offsets are those of all parts together
};

// The field of a sum's kernel, and the data that it points to.
template <class S>
struct OwnedSum : SumKernelField<S> {
  std::vector<Segment> segments;
  std::vector<BoundKernel<S>> bound;
  double begin = 0;
  double end = 1;

  OwnedSum(const Segment& sum, const Vec3d& center, const AdvectOptions& options, const Kernels<S>& kernels)
      : segments(parts_of(sum)), begin(sum.begin), end(sum.end) {
    const std::vector<SegmentMask> masks = masks_on(sum, segments);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      bound.push_back(kernel_of<S>(segments[i], options.tolerance, masks[i], kernels));
      this->parts[this->count++] = part_of(segments[i], bound.back(), center, options.tolerance);
    }
  }
  OwnedSum(const OwnedSum&) = delete;
  OwnedSum& operator=(const OwnedSum&) = delete;
  ~OwnedSum() = default;

  static SumPart<S> part_of(const Segment& segment, const BoundKernel<S>& bound, const Vec3d& center,
                            double tolerance) {
    const SegmentTask<double> task = task_in_double(segment, tolerance);
    const Zone zone = zone_of(segment);
    SumPart<S> part;
    part.kernel = bound.kernel;
    part.field = bound.field.get();
    part.center = Vec3<S>(task.center - center);
    part.tool_velocity = Vec3<S>(task.tool_velocity);
    part.tool_speed = static_cast<S>(task.tool_speed);
    part.reach = static_cast<S>(std::min(task.reach, static_cast<double>(std::numeric_limits<S>::max())));
    part.finds_width =
        !segment.fields.empty() && std::holds_alternative<Handles<double>>(segment.fields.front().region);
    part.in_space = zone.in_space;
    part.middle = Vec3<S>(zone.in_space ? zone.middle : zone.middle - center);
    part.by = Vec3<S>(zone.by);
    const double extent = zone.in_space ? zone.extent - dot(zone.middle, center) : zone.extent;
    const double size = zone.in_space ? task.reach + std::abs(extent) : extent + norm(zone.middle - center);
    part.extent = static_cast<S>(extent + kMarginInKernels * size);
    return part;
  }

  // Over 1 means never.
  double next_contact(const Vec3d& x, double t) const {
    double first = 2;
    for (const BoundKernel<S>& part : bound) {
      const void* cell = nullptr;
      const double contact = part.next_contact(part.contact_data, x, t, cell);
      if (contact <= 1 && (first > 1 || is_earlier(contact, first))) first = contact;
    }
    return first;
  }

  bool is_earlier(double a, double b) const { return end >= begin ? a < b : a > b; }

  static double contact_or_never(const void* data, const Vec3d& x, double t, const void*& /*cell*/) {
    return static_cast<const OwnedSum*>(static_cast<const SumKernelField<S>*>(data))->next_contact(x, t);
  }

  // Moves no point in closed form, because another part may move it at the same time.
  static Classified classify(const void* data, const BlockTask& task) {
    const auto& self = *static_cast<const OwnedSum*>(static_cast<const SumKernelField<S>*>(data));
    Classified result;
    for (const BoundKernel<S>& part : self.bound) {
      std::array<double, kBlock> start{};
      const Classified found = part.kernel.classify(part.field.get(), {task.points, task.members, start.data(), false});
      for (std::uint64_t rest = found.later; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<std::size_t>(__builtin_ctzll(rest));
        const bool is_first = (result.later >> i & 1) == 0;
        if (is_first || self.is_earlier(start[i], task.start[i])) task.start[i] = start[i];
      }
      result.inside |= found.inside;
      result.later |= found.later;
      result.pending |= found.pending;
    }
    result.pending &= ~result.inside;
    result.later &= ~(result.inside | result.pending);
    return result;
  }
};

}  // namespace

std::vector<Segment> parts_of(const Segment& segment) {
  if (segment.parts.empty()) return {segment};
  std::vector<Segment> parts = segment.parts;
  for (Segment& part : parts) {
    part.mask = segment.mask;
    part.begin = segment.begin;
    part.end = segment.end;
  }
  return parts;
}

unsigned parts_around(std::span<const Segment> parts, const Vec3d& x) {
  unsigned chosen = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!parts[i].limit_cylinder || is_within(*parts[i].limit_cylinder, x)) chosen |= 1U << i;
  }
  return chosen;
}

Flow each_part(const Flow& flow) {
  Flow result;
  for (const Segment& segment : flow.segments) {
    for (Segment& part : parts_of(segment)) result.segments.push_back(std::move(part));
  }
  return result;
}

bool has_limit_cylinders(const Segment& segment) {
  return std::any_of(segment.parts.begin(), segment.parts.end(),
                     [](const Segment& part) { return !!part.limit_cylinder; });
}

Segment chosen_parts(const Segment& sum, unsigned chosen) {
  Segment result = sum;
  result.parts.clear();
  for (std::size_t i = 0; i < sum.parts.size(); ++i) {
    if ((chosen >> i & 1U) == 0) continue;
    result.parts.push_back(sum.parts[i]);
    result.parts.back().limit_cylinder.reset();
  }
  return result.parts.size() > 1 ? result : parts_of(result).front();
}

template <class S>
BoundKernel<S> sum_kernel(const Segment& sum, const Vec3d& center, const AdvectOptions& options,
                          const Kernels<S>& kernels) {
  const auto owned = std::make_shared<const OwnedSum<S>>(sum, center, options, kernels);
  BoundKernel<S> result;
  result.kernel = kernels.sum;
  result.kernel.classify = &OwnedSum<S>::classify;
  result.kernel.by_lanes = std::any_of(owned->bound.begin(), owned->bound.end(),
                                       [](const BoundKernel<S>& part) { return part.kernel.by_lanes; });
  result.field = {owned, static_cast<const SumKernelField<S>*>(owned.get())};
  result.next_contact = &OwnedSum<S>::contact_or_never;
  result.contact_data = result.field.get();
  return result;
}

template BoundKernel<float> sum_kernel<float>(const Segment&, const Vec3d&, const AdvectOptions&,
                                              const Kernels<float>&);
template BoundKernel<double> sum_kernel<double>(const Segment&, const Vec3d&, const AdvectOptions&,
                                                const Kernels<double>&);

SegmentMover mover_of_parts(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels) {
  if (segment.parts.empty() || (!segment.mask.is_empty() && !has_limit_cylinders(segment))) return nullptr;
  const auto mover = std::make_shared<const SumMover>(segment, options, kernels);
  return [mover](const LiveGroup& group) { return (*mover)(group); };
}

}  // namespace knead::detail
