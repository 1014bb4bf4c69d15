// Updates the splats of a deformed shape when it moves.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "flow/path_jacobian.h"
#include "knead/editor/shape_state.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "session/deformed_shape_detail.h"

namespace knead {

namespace {

using detail::MovedSplats;

constexpr double kSplatTolerance = 1e-7;           // of the path lines of splats, by the size of the shape
constexpr double kJacobianTolerance = 3e-7;        // of a segment
constexpr double kPinnedJacobianTolerance = 3e-8;  // of one with pins, where errors grow
constexpr std::size_t kPointsPerBlock = 4096;

// The Jacobian of one splat.
using Entry = std::pair<std::uint32_t, Mat3d>;
bool by_splat(const Entry& a, const Entry& b) { return a.first < b.first; }

// Returns the Jacobians of one deformation after another. Both ascend.
SplatJacobians composed(const SplatJacobians& first, const std::vector<Entry>& second) {
  SplatJacobians result;
  const auto add = [&](std::uint32_t splat, const Mat3d& jacobian) {
    if (jacobian == Mat3d{}) return;
    result.splats.push_back(splat);
    result.jacobians.push_back(jacobian);
  };
  std::size_t i = 0;
  for (const auto& [splat, jacobian] : second) {
    for (; i < first.splats.size() && first.splats[i] < splat; ++i) add(first.splats[i], first.jacobians[i]);
    const bool is_in_both = i < first.splats.size() && first.splats[i] == splat;
    add(splat, is_in_both ? jacobian * first.jacobians[i++] : jacobian);
  }
  for (; i < first.splats.size(); ++i) add(first.splats[i], first.jacobians[i]);
  return result;
}

}  // namespace

void DeformedShape::carry_splats(std::vector<IndexRange> splats) {
  splat_ranges_ = std::move(splats);
  splats_ = std::make_shared<const SplatJacobians>();
}

std::vector<std::uint32_t> DeformedShape::splats_in_support(const Flow& flow) const {
  const FlowSupport support(flow);
  const auto is_splat = [&](std::uint32_t vertex) {
    if (provenance_) vertex = provenance_->vertex_source[vertex];
    return std::any_of(splat_ranges_.begin(), splat_ranges_.end(),
                       [&](const IndexRange& r) { return r.begin <= vertex && vertex < r.end; });
  };
  std::vector<std::vector<std::uint32_t>> found((positions_.size() + kPointsPerBlock - 1) / kPointsPerBlock);
  parallel_for(found.size(), 1, motion_.threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t block = first; block < last; ++block) {
      const std::size_t end = std::min(positions_.size(), (block + 1) * kPointsPerBlock);
      for (std::size_t i = block * kPointsPerBlock; i < end; ++i) {
        const auto vertex = static_cast<std::uint32_t>(i);
        if (is_splat(vertex) && support.may_move(positions_[i], 0)) found[block].push_back(vertex);
      }
    }
  });
  std::vector<std::uint32_t> all;
  for (const std::vector<std::uint32_t>& block : found) all.insert(all.end(), block.begin(), block.end());
  return all;
}

MovedSplats DeformedShape::moved_splats(const Flow& flow, AdvectOptions options) const {
  options.tolerance = std::min(options.tolerance, kSplatTolerance * reference_length_);
  MovedSplats moved{splats_in_support(flow), {}, {}};
  moved.centers.reserve(moved.vertices.size());
  for (const std::uint32_t vertex : moved.vertices) moved.centers.push_back(positions_[vertex]);
  const auto is_pinned = [](const Segment& segment) { return segment.time_law == TimeLaw::pinned; };
  const bool has_pins = std::any_of(flow.segments.begin(), flow.segments.end(), is_pinned);
  const double tolerance = has_pins ? kPinnedJacobianTolerance : kJacobianTolerance;
  moved.jacobians = move_with_jacobians(flow, moved.centers, options, std::min(tolerance, motion_.relative_tolerance));
  return moved;
}

// Points with a constraint are no splats.
void DeformedShape::put(const MovedSplats& moved) {
  if (moved.vertices.empty()) return;
  std::vector<Entry> entries;
  entries.reserve(moved.vertices.size());
  for (std::size_t k = 0; k < moved.vertices.size(); ++k) {
    const std::uint32_t vertex = moved.vertices[k];
    if (!constraint_) positions_[vertex] = moved.centers[k];
    entries.emplace_back(provenance_ ? provenance_->vertex_source[vertex] : vertex, moved.jacobians[k]);
  }
  free_layout();  // it has the old places
  if (provenance_) std::sort(entries.begin(), entries.end(), by_splat);
  splats_ = std::make_shared<const SplatJacobians>(composed(*splats_, entries));
}

void DeformedShape::take_splats(const std::vector<bool>& vertices, const DeformedShape& from) {
  std::vector<Entry> entries;
  const auto add = [&](const SplatJacobians& splats, bool are_taken) {
    for (std::size_t k = 0; k < splats.splats.size(); ++k) {
      if (vertices[splats.splats[k]] == are_taken) entries.emplace_back(splats.splats[k], splats.jacobians[k]);
    }
  };
  add(*splats_, false);
  add(*from.splats_, true);
  std::sort(entries.begin(), entries.end(), by_splat);
  splats_ = std::make_shared<const SplatJacobians>(composed({}, entries));
}

}  // namespace knead
