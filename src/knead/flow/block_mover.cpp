#include "knead/flow/block_mover.h"

#include <algorithm>
#include <array>

#include "knead/math/parallel.h"

namespace knead::detail {

namespace {

// Segments are made ready for so many at a time. Those of large sets have much to keep, so each is done by itself.
constexpr std::size_t kSegmentsAtATime = 64;

bool is_ready_soon(const Segment& segment) {
  return segment.parts.empty() ? has_pack_kernel(segment)
                               : std::all_of(segment.parts.begin(), segment.parts.end(), has_pack_kernel);
}

// Culling is tried again with a new box where the old one has grown to this part of its size.
constexpr double kStale = 0.25;
// And to find that points need not be classified, at this multiple.
constexpr double kVeryStale = 1;

}  // namespace

ReadySegment::ReadySegment(const Segment& of, const AdvectOptions& options)
    : segment(&of), culling(of), move(make_segment_mover(of, options)) {
  if (!of.barrel || of.begin == 0) return;
  auto back = std::make_unique<Segment>(of);
  back->end = 0;
  back->barrel.reset();
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

AdvectResult BlockMover::run(const Flow& flow) {
  std::vector<ReadySegment> ready;
  for (const Segment& segment : flow.segments) {
    ready.emplace_back(segment, options_);
    const bool is_last = &segment == &flow.segments.back();
    if (!is_last && is_ready_soon(segment) && ready.size() < kSegmentsAtATime) continue;
    run(ready);
    ready.clear();
    if (is_stopped()) break;
  }
  const bool is_done = complete_ && evaluations_ <= most_evaluations_;
  AdvectStatus status = is_done ? AdvectStatus::done : AdvectStatus::step_limit;
  if (options_.progress != nullptr && options_.progress->cancel) status = AdvectStatus::cancelled;
  return {status, accepted_, rejected_, evaluations_};
}

// `evaluations`: of a group that is being moved.
bool BlockMover::is_stopped(std::uint64_t evaluations) const {
  if (!complete_ || evaluations_ + evaluations > most_evaluations_) return true;
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

// A group that the segments miss where it lies now is not moved by any of them.
std::vector<std::size_t> BlockMover::groups_reached(const std::vector<ReadySegment>& segments) const {
  std::vector<std::size_t> reached;
  for (std::size_t group = 0; group < blocks_.groups_.size(); ++group) {
    const PointBlocks::Bounds& bounds = blocks_.groups_[group];
    const Surround ball = ball_of(bounds);
    const bool missed = std::all_of(segments.begin(), segments.end(),
                                    [&](const ReadySegment& segment) { return segment.culling.misses(ball); });
    if (!missed) reached.push_back(group);
  }
  return reached;
}

void BlockMover::move_group(const std::vector<ReadySegment>& segments, std::size_t group) {
  const std::size_t first = group * kGroup;
  Work work;
  work.group = group;
  work.live = {{blocks_.coordinates(0) + first, blocks_.coordinates(1) + first, blocks_.coordinates(2) + first},
               work.members.data(),
               work.blocks.data(),
               0,
               0,
               blocks_.counts_.data() + first,
               work.moved.data(),
               {&BlockMover::ask, this}};
  for (const ReadySegment& segment : segments) {
    if (is_stopped()) return;
    move_group(segment, work);
    if (options_.progress != nullptr) options_.progress->done += std::min(kGroup, blocks_.size() - first);
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
  if (segment.segment->barrel) choose_members(segment, work);
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
  if (bounds.slack <= kStale * norm(bounds.half) || segment.culling.covers(ball_of(bounds), true)) return false;
  blocks_.fit_block(block);
  return segment.culling.misses(ball_of(bounds));
}

// Whether all points of the block are known to be in the intermediate region.
bool BlockMover::is_between(const ReadySegment& segment, std::size_t block) {
  PointBlocks::Bounds& bounds = blocks_.blocks_[block];
  if (segment.culling.covers(ball_of(bounds), false)) return true;
  if (bounds.slack <= kVeryStale * norm(bounds.half)) return false;
  blocks_.fit_block(block);
  return segment.culling.covers(ball_of(bounds), false);
}

// Of a segment with a barrel: the points that are in it at t = 0.
void BlockMover::choose_members(const ReadySegment& segment, Work& work) const {
  std::vector<double> copy;
  Coordinates at_start = work.live.points;
  if (segment.move_to_start) {
    for (const double* from : {at_start.x, at_start.y, at_start.z}) copy.insert(copy.end(), from, from + kGroup);
    at_start = {copy.data(), copy.data() + kGroup, copy.data() + 2 * kGroup};
    std::vector<std::uint32_t> steps(kGroup);
    std::array<double, kBlocksPerGroup> moved{};
    segment.move_to_start({at_start, work.live.members, work.live.blocks, work.live.block_count, 0, steps.data(),
                           moved.data(), work.live.stop});
  }
  for (int k = 0; k < work.live.block_count; ++k) {
    const std::size_t block = work.blocks[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < kBlock; ++i) {
      const std::size_t at = block * kBlock + i;
      if (is_within(*segment.segment->barrel, {at_start.x[at], at_start.y[at], at_start.z[at]})) continue;
      work.members[block] &= ~(std::uint64_t{1} << i);
    }
  }
}

}  // namespace knead::detail
