// advect() on the CPU: points in blocks of neighbours, and their motion through a flow, a group of blocks at a time.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "flow/block_mover.h"
#include "flow/kernels/kernel.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "math/geometry.h"

namespace knead {

namespace {

using detail::kBlock;
using detail::kBlocksPerGroup;
using detail::kGroup;

// With fewer segments sorting the points takes longer than it saves.
constexpr std::size_t kMinSegmentsToSort = 4;
constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();
// The number of segments that are prepared together. Those of large sets need much memory, so each is done alone.
constexpr std::size_t kSegmentsAtATime = 64;
// A box is fitted again when its points may have moved by this fraction of its size: for culling the block, and for
// finding that its points need not be classified.
constexpr double kSlackToCull = 0.25;
constexpr double kSlackToClassify = 1;

bool is_finite_and_positive(double x) { return x > 0 && std::isfinite(x); }

AdvectResult move_blocks(detail::ReadyFlow& flow, PointBlocks& blocks, std::span<const Vec3d> points,
                         std::uint64_t max_evaluations) {
  const AdvectOptions& options = flow.options();
  const std::vector<std::uint32_t> before = options.steps.empty() ? std::vector<std::uint32_t>{} : blocks.steps();
  const AdvectResult result = detail::BlockMover(blocks, points, options, max_evaluations).run(flow);
  if (!options.steps.empty()) {
    const std::vector<std::uint32_t> after = blocks.steps();
    for (std::size_t i = 0; i < after.size(); ++i) options.steps[i] += after[i] - before[i];
  }
  return result;
}

// Returns whether the segment is prepared fast and in little memory.
bool is_small(const Segment& segment) {
  return segment.parts.empty() ? detail::has_pack_kernel(segment)
                               : std::all_of(segment.parts.begin(), segment.parts.end(), detail::has_pack_kernel);
}

// Returns point i, and throws InvalidInput unless it is finite.
const Vec3d& finite(std::span<const Vec3d> points, std::size_t i) {
  if (is_finite(points[i])) return points[i];
  throw InvalidInput(fmt::format("point {} has a coordinate that is not finite; place or remove it", i));
}

// Finds the middle and half of the extent of a block's numbers.
void fit(std::span<const double> x, double& center, double& half) {
  constexpr std::size_t kSideBySide = 8;  // which the compiler takes at once
  std::array<double, kSideBySide> low{};
  std::array<double, kSideBySide> high{};
  low.fill(x[0]);
  high.fill(x[0]);
  const auto extend = [&](std::size_t k, double at) {
    low[k] = at < low[k] ? at : low[k];
    high[k] = at > high[k] ? at : high[k];
  };
  std::size_t i = 0;
  for (; i + kSideBySide <= x.size(); i += kSideBySide) {
    for (std::size_t k = 0; k < kSideBySide; ++k) extend(k, x[i + k]);
  }
  for (; i < x.size(); ++i) extend(0, x[i]);
  const double least = *std::min_element(low.begin(), low.end());
  const double most = *std::max_element(high.begin(), high.end());
  center = 0.5 * (least + most);
  half = 0.5 * (most - least) * (1 + 1e-12);
}

}  // namespace

double absolute_tolerance(double relative_tolerance, double diagonal) {
  if (!is_finite_and_positive(relative_tolerance)) {
    throw InvalidInput(fmt::format("the tolerance must be a number greater than 0, got {}", relative_tolerance));
  }
  const double tolerance = relative_tolerance * diagonal;
  if (!is_finite_and_positive(tolerance)) {
    throw InvalidInput(
        "the tolerance times the shape's size must be a finite length greater than 0; change the tolerance");
  }
  return tolerance;
}

void validate(const AdvectOptions& options, std::size_t points) {
  if (!is_finite_and_positive(options.tolerance)) {
    throw InvalidInput(
        fmt::format("set the tolerance of the path lines to a length greater than 0, such as 1e-5 times the shape's "
                    "size, not to {}",
                    options.tolerance));
  }
  if (!options.steps.empty() && options.steps.size() != points) {
    throw InvalidInput("steps must be empty or hold one number per point");
  }
}

AdvectResult& AdvectResult::operator+=(const AdvectResult& other) {
  if (status == AdvectStatus::done) status = other.status;
  accepted_steps += other.accepted_steps;
  rejected_steps += other.rejected_steps;
  evaluations += other.evaluations;
  return *this;
}

AdvectResult advect(const Flow& flow, PointBlocks& blocks, std::span<const Vec3d> points,
                    const AdvectOptions& options) {
  detail::ReadyFlow ready(flow, options);
  validate(options, points.size());
  if (points.size() != blocks.size()) throw InvalidInput("the number of points differs from that of the blocks");
  return move_blocks(ready, blocks, points, kUnlimited);
}

AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
  detail::ReadyFlow ready(flow, options);
  return detail::advect_within(ready, points, kUnlimited);
}

AdvectResult detail::advect_within(ReadyFlow& flow, std::span<Vec3d> points, std::uint64_t max_evaluations) {
  validate(flow.options(), points.size());
  const bool sorted = flow.flow().segments.size() >= kMinSegmentsToSort;
  PointBlocks blocks(points, sorted ? PointBlocks::Order::sorted : PointBlocks::Order::given);
  const AdvectResult result = move_blocks(flow, blocks, points, max_evaluations);
  if (result.status == AdvectStatus::done) blocks.update(points);
  return result;
}

}  // namespace knead

namespace knead::detail {

ReadySegment::ReadySegment(const Segment& of, const AdvectOptions& options)
    : segment(&of), culling(of), move(make_segment_mover(of, options)) {
  if (!of.limit_cylinder || of.begin == 0) return;
  auto back = std::make_unique<Segment>(of);
  back->end = 0;
  back->limit_cylinder.reset();
  move_to_start = make_segment_mover(*back, options);
  to_start = std::move(back);
}

struct BlockMover::Work {
  std::size_t group = 0;
  LiveGroup live;
  std::array<std::uint64_t, kBlocksPerGroup> members{};
  std::array<std::uint16_t, kBlocksPerGroup> blocks{};
  std::array<double, kBlocksPerGroup> moved{};
};

ReadyFlow::ReadyFlow(const Flow& flow, const AdvectOptions& options) : flow_(flow), options_(options) {
  validate(flow);
  const std::size_t count = flow.segments.size();
  keeps_ =
      count <= 1 || (count <= kSegmentsAtATime && std::all_of(flow.segments.begin(), flow.segments.end(), is_small));
}

template <class Body>
void ReadyFlow::in_batches(const Body& body) {
  if (!kept_.empty()) {
    body(kept_);
    return;
  }
  std::vector<ReadySegment> ready;
  for (const Segment& segment : flow_.segments) {
    ready.emplace_back(segment, options_);
    const bool is_last = &segment == &flow_.segments.back();
    if (!is_last && is_small(segment) && ready.size() < kSegmentsAtATime) continue;
    if (!body(ready)) break;
    if (keeps_) kept_ = std::move(ready);
    ready.clear();
  }
}

AdvectResult BlockMover::run(ReadyFlow& flow) {
  flow.in_batches([&](const std::vector<ReadySegment>& segments) {
    run(segments);
    return !is_stopped();
  });
  const bool is_done = complete_ && evaluations_ <= max_evaluations_;
  AdvectStatus status = is_done ? AdvectStatus::done : AdvectStatus::step_limit;
  if (options_.progress != nullptr && options_.progress->cancel) status = AdvectStatus::cancelled;
  return {status, accepted_, rejected_, evaluations_};
}

// `evaluations`: of a group that is being moved.
bool BlockMover::is_stopped(std::uint64_t evaluations) const {
  if (!complete_ || evaluations_ + evaluations > max_evaluations_) return true;
  return options_.progress != nullptr && options_.progress->cancel;
}

void BlockMover::run(const std::vector<ReadySegment>& segments) {
  const std::vector<std::size_t> reached = groups_reached(segments);
  parallel_for(reached.size(), 1, options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) move_group(segments, reached[i]);
  });
  if (options_.progress != nullptr && !is_stopped()) {
    std::size_t of_reached = 0;
    for (const std::size_t group : reached) of_reached += std::min(kGroup, blocks_.size() - group * kGroup);
    options_.progress->done += (blocks_.size() - of_reached) * segments.size();
  }
}

// Returns the groups that some segment may move. A group that all segments miss where it lies now never moves.
std::vector<std::size_t> BlockMover::groups_reached(const std::vector<ReadySegment>& segments) const {
  std::vector<std::size_t> reached;
  for (std::size_t group = 0; group < blocks_.groups_.size(); ++group) {
    const Surround ball = ball_of(blocks_.groups_[group]);
    const bool missed = std::all_of(segments.begin(), segments.end(),
                                    [&](const ReadySegment& segment) { return segment.culling.misses(ball); });
    if (!missed) reached.push_back(group);
  }
  return reached;
}

void BlockMover::move_group(const std::vector<ReadySegment>& segments, std::size_t group) {
  blocks_.copy_group(group, points_);
  PointBlocks::Copies& copies = blocks_.copies_[group];
  double* const numbers = copies.numbers.data();
  Work work;
  work.group = group;
  work.live = {{numbers, numbers + kGroup, numbers + 2 * kGroup},
               work.members.data(),
               work.blocks.data(),
               0,
               0,
               copies.steps.data(),
               work.moved.data(),
               {&BlockMover::ask, this}};
  for (const ReadySegment& segment : segments) {
    if (is_stopped()) return;
    move_group(segment, work);
    if (options_.progress != nullptr) options_.progress->done += std::min(kGroup, blocks_.size() - group * kGroup);
  }
}

void BlockMover::move_group(const ReadySegment& segment, Work& work) {
  PointBlocks::Bounds& bounds = blocks_.groups_[work.group];
  if (segment.culling.misses(ball_of(bounds))) return;
  const std::size_t first = work.group * kBlocksPerGroup;
  const std::size_t count = std::min(kBlocksPerGroup, blocks_.blocks_.size() - first);
  work.live.block_count = 0;
  work.live.between = 0;
  for (std::size_t block = 0; block < count; ++block) {
    if (is_missed(segment, first + block)) continue;
    work.blocks[static_cast<std::size_t>(work.live.block_count++)] = static_cast<std::uint16_t>(block);
    const std::size_t points = std::min(kBlock, blocks_.size() - (first + block) * kBlock);
    work.members[block] = points == kBlock ? ~std::uint64_t{0} : (std::uint64_t{1} << points) - 1;
    work.moved[block] = 0;
    if (is_between(segment, first + block)) work.live.between |= std::uint64_t{1} << block;
  }
  if (work.live.block_count == 0) return;
  if (segment.segment->limit_cylinder) choose_members(segment, work);
  const GroupCounts counts = segment.move(work.live);
  accepted_ += counts.accepted;
  rejected_ += counts.rejected;
  evaluations_ += counts.evaluations;
  if (!counts.complete) complete_ = false;
  for (int i = 0; i < work.live.block_count; ++i) {
    const std::size_t block = work.blocks[static_cast<std::size_t>(i)];
    if (work.moved[block] == 0) continue;
    blocks_.blocks_[first + block].slack += work.moved[block] * (1 + 1e-6);
    blocks_.blocks_[first + block].has_changed = true;
    bounds.has_changed = true;
  }
  blocks_.fit_group(work.group);
}

Surround BlockMover::ball_of(const PointBlocks::Bounds& bounds) {
  return {bounds.center, norm(bounds.half + Vec3d{1, 1, 1} * bounds.slack)};
}

bool BlockMover::is_missed(const ReadySegment& segment, std::size_t block) {
  PointBlocks::Bounds& bounds = blocks_.blocks_[block];
  if (segment.culling.misses(ball_of(bounds))) return true;
  if (bounds.slack <= kSlackToCull * norm(bounds.half) || segment.culling.covers(ball_of(bounds), true)) return false;
  blocks_.fit_block(block);
  return segment.culling.misses(ball_of(bounds));
}

// Returns whether all points of the block are known to be in the intermediate region.
bool BlockMover::is_between(const ReadySegment& segment, std::size_t block) {
  PointBlocks::Bounds& bounds = blocks_.blocks_[block];
  if (segment.culling.covers(ball_of(bounds), false)) return true;
  if (bounds.slack <= kSlackToClassify * norm(bounds.half)) return false;
  blocks_.fit_block(block);
  return segment.culling.covers(ball_of(bounds), false);
}

// Limits the members to the points that are in the segment's limit cylinder at t = 0.
void BlockMover::choose_members(const ReadySegment& segment, Work& work) const {
  std::vector<double> numbers;
  Coordinates at_start = work.live.points;
  if (segment.move_to_start) {
    numbers = moved_copy(segment.move_to_start, work.live);
    at_start = {numbers.data(), numbers.data() + kGroup, numbers.data() + 2 * kGroup};
  }
  for (int k = 0; k < work.live.block_count; ++k) {
    const std::size_t block = work.blocks[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < kBlock; ++i) {
      const std::size_t at = block * kBlock + i;
      if (is_within(*segment.segment->limit_cylinder, {at_start.x[at], at_start.y[at], at_start.z[at]})) continue;
      work.members[block] &= ~(std::uint64_t{1} << i);
    }
  }
}

}  // namespace knead::detail

namespace knead {

void require_finite(std::span<const Vec3d> points) {
  for (std::size_t i = 0; i < points.size(); ++i) finite(points, i);
}

PointBlocks::PointBlocks(std::span<const Vec3d> points, Order order) : size_(points.size()) {
  if (points.size() > 0xffffffffU) throw InvalidInput("there are more than 4 billion points; deform them in parts");
  if (order == Order::sorted) sort(points);  // first, because it takes much memory for a while
  blocks_.resize((size_ + kBlock - 1) / kBlock);
  groups_.resize((size_ + kGroup - 1) / kGroup);
  copies_.resize(groups_.size());
  std::array<double, 3 * kBlock> numbers{};
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    const std::size_t first = block * kBlock;
    const std::size_t count = std::min(kBlock, size_ - first);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3d& point = finite(points, original(first + i));
      for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis * kBlock + i] = point[axis];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      fit({numbers.data() + axis * kBlock, count}, blocks_[block].center[axis], blocks_[block].half[axis]);
    }
  }
  for (std::size_t group = 0; group < groups_.size(); ++group) fit_group(group);
}

void PointBlocks::sort(std::span<const Vec3d> points) {
  const Box box = bounding_box(points);
  if (box.empty()) return;
  const ToUnit to_unit(box);
  std::vector<std::uint64_t> keys(points.size());  // the 32 highest bits of a code, then the number
  for (std::size_t i = 0; i < points.size(); ++i) {
    keys[i] = morton_code(to_unit(finite(points, i))) >> 31 << 32 | i;
  }
  sort_by_bits(keys, 31, [](std::uint64_t key) { return key; });
  order_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) order_[i] = static_cast<std::uint32_t>(keys[i]);
}

void PointBlocks::copy_group(std::size_t group, std::span<const Vec3d> points) {
  auto& [numbers, steps] = copies_[group];
  if (!numbers.empty()) return;
  numbers.resize(3 * kGroup);
  steps.resize(kGroup);
  const std::size_t first = group * kGroup;
  for (std::size_t i = 0; i < std::min(kGroup, size_ - first); ++i) {
    const Vec3d& point = points[original(first + i)];
    for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis * kGroup + i] = point[axis];
  }
}

void PointBlocks::fit_block(std::size_t block) {
  const double* const numbers = copies_[block / kBlocksPerGroup].numbers.data() + block % kBlocksPerGroup * kBlock;
  const std::size_t count = std::min(kBlock, size_ - block * kBlock);
  Bounds& bounds = blocks_[block];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fit({numbers + axis * kGroup, count}, bounds.center[axis], bounds.half[axis]);
  }
  bounds.slack = 0;
}

void PointBlocks::fit_group(std::size_t group) {
  Box box;
  const std::size_t first = group * kBlocksPerGroup;
  for (std::size_t block = first; block < std::min(first + kBlocksPerGroup, blocks_.size()); ++block) {
    const Bounds& bounds = blocks_[block];
    const Vec3d extent = bounds.half + Vec3d{1, 1, 1} * bounds.slack;
    box.extend(bounds.center - extent);
    box.extend(bounds.center + extent);
  }
  groups_[group].center = box.center();
  groups_[group].half = (box.max - box.min) * (0.5 * (1 + 1e-12));
}

void PointBlocks::update(std::span<Vec3d> points) {
  if (points.size() != size_) {
    throw InvalidInput("the number of points to update differs from the number of points in the blocks");
  }
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    if (!groups_[group].has_changed) continue;
    groups_[group].has_changed = false;
    const double* const numbers = copies_[group].numbers.data();
    const std::size_t first = group * kBlocksPerGroup;
    for (std::size_t block = first; block < std::min(first + kBlocksPerGroup, blocks_.size()); ++block) {
      if (!blocks_[block].has_changed) continue;
      blocks_[block].has_changed = false;
      const double* const x = numbers + (block - first) * kBlock;
      for (std::size_t i = 0; i < std::min(kBlock, size_ - block * kBlock); ++i) {
        points[original(block * kBlock + i)] = {x[i], x[kGroup + i], x[2 * kGroup + i]};
      }
    }
  }
}

std::vector<std::uint32_t> PointBlocks::steps() const {
  std::vector<std::uint32_t> result(size_);
  for (std::size_t group = 0; group < copies_.size(); ++group) {
    const std::vector<std::uint32_t>& steps = copies_[group].steps;
    const std::size_t first = group * kGroup;
    for (std::size_t i = 0; i < std::min(steps.size(), size_ - first); ++i) result[original(first + i)] = steps[i];
  }
  return result;
}

}  // namespace knead
