#include "knead/remesh/limit_edges.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace knead::remesh_detail {

namespace {

constexpr int kMostRounds = 40;

using LongEdge = std::pair<double, std::uint32_t>;  // the square of its length below 0, and its number

double length2(const Surface& s, std::uint32_t h) { return norm2(s.after[s.target(h)] - s.after[s.origin(h)]); }

// Returns the edge that is longest in a face of the edge, or the edge itself. To split a shorter one leads nowhere.
std::uint32_t longest_around(const Surface& s, std::uint32_t e) {
  std::uint32_t longest = s.halfedge[e];
  const std::uint32_t first = longest;
  for (const std::uint32_t side : {first, s.opposite[first]}) {
    if (side == kNone) continue;
    for (const std::uint32_t h : {Surface::next(side), Surface::previous(side)}) {
      if (length2(s, h) > length2(s, longest)) longest = h;
    }
  }
  return s.edge[longest];
}

// Returns the edges to split for those that are too long, the longest first.
std::vector<LongEdge> long_edges(const Surface& s, double limit, bool whole, bool& has_locked) {
  std::vector<LongEdge> found;
  for (std::uint32_t e = 0; e < s.halfedge.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone || !s.is_alive(h / 3)) continue;
    const std::uint32_t a = s.origin(h);
    const std::uint32_t b = s.target(h);
    if (!(length2(s, h) > limit * limit) || !(whole || s.has(a, kMoved) || s.has(b, kMoved))) continue;
    const std::uint32_t longest = longest_around(s, e);
    if ((s.edge_flags[longest] & kLocked) != 0) {
      has_locked = true;
    } else {
      found.emplace_back(-length2(s, s.halfedge[longest]), longest);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

LimitedEdges limit_edges(Surface& s, const RemeshTargets& targets, bool whole, std::size_t outside,
                         const Progress* progress) {
  LimitedEdges result;
  for (int round = 0;; ++round) {
    stop_if_cancelled(progress);
    bool has_locked = false;
    const std::vector<LongEdge> edges = long_edges(s, targets.max_edge, whole, has_locked);
    const bool has_room = s.vertex_count() + outside + edges.size() <= targets.max_vertices && round < kMostRounds;
    if (edges.empty() || !has_room) {
      result.met = edges.empty() && !has_locked;
      return result;
    }
    for (const auto& [length, e] : edges) {
      const std::uint32_t h = s.halfedge[e];
      const std::uint32_t a = s.origin(h);
      const std::uint32_t b = s.target(h);
      const std::uint32_t m = split(s, h, (s.before[a] + s.before[b]) * 0.5, (s.after[a] + s.after[b]) * 0.5);
      if (s.has(a, kMoved) || s.has(b, kMoved)) s.set(m, kMoved);
      ++result.splits;
    }
  }
}

}  // namespace knead::remesh_detail
