#include <algorithm>

#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

namespace {

// The half-edges sorted by their smaller vertex: those of v are [begin[v], begin[v + 1]).
struct Buckets {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> halfedges;
};

Buckets bucket_halfedges(const Surface& s) {
  Buckets buckets;
  buckets.begin.assign(s.vertex_count() + 1, 0);
  buckets.halfedges.resize(s.corner.size());
  const auto low = [&](std::uint32_t h) { return std::min(s.origin(h), s.target(h)); };
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) ++buckets.begin[low(h) + std::size_t{1}];
  for (std::size_t v = 0; v < s.vertex_count(); ++v) buckets.begin[v + 1] += buckets.begin[v];
  std::vector<std::uint32_t> at(buckets.begin.begin(), buckets.begin.end() - 1);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) buckets.halfedges[at[low(h)]++] = h;
  return buckets;
}

std::uint32_t add_edge(Surface& s, std::uint8_t flags, std::uint32_t h) {
  s.edge[h] = static_cast<std::uint32_t>(s.halfedge.size());
  s.halfedge.push_back(h);
  s.edge_flags.push_back(flags);
  return s.edge[h];
}

// Makes the edge or edges that these half-edges form.
void join_uses(Surface& s, std::span<const std::uint32_t> uses) {
  if (uses.size() == 2 && s.origin(uses[0]) == s.target(uses[1])) {
    const std::uint32_t edge = add_edge(s, 0, uses[0]);
    s.edge[uses[1]] = edge;
    s.opposite[uses[0]] = uses[1];
    s.opposite[uses[1]] = uses[0];
    return;
  }
  const int flags = uses.size() == 1 ? kFeature | kBoundary : kFeature | kLocked;
  for (const std::uint32_t h : uses) {
    add_edge(s, static_cast<std::uint8_t>(flags), h);
    if (uses.size() == 1) return;
    s.set(s.origin(h), kFixed);
    s.set(s.target(h), kFixed);
  }
}

void join_halfedges(Surface& s, const Progress* progress) {
  const Buckets buckets = bucket_halfedges(s);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sorted;  // larger vertex, half-edge
  std::vector<std::uint32_t> uses;
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    stop_if_cancelled(progress);
    sorted.clear();
    for (std::size_t i = buckets.begin[v]; i < buckets.begin[v + 1]; ++i) {
      const std::uint32_t h = buckets.halfedges[i];
      sorted.emplace_back(std::max(s.origin(h), s.target(h)), h);
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size();) {
      uses.clear();
      const std::uint32_t high = sorted[i].first;
      for (; i < sorted.size() && sorted[i].first == high; ++i) uses.push_back(sorted[i].second);
      join_uses(s, uses);
    }
  }
}

// Fixes the vertices whose faces form more than one fan.
void fix_pinched(Surface& s) {
  std::vector<std::uint32_t> faces(s.vertex_count(), 0);
  for (const std::uint32_t v : s.corner) ++faces[v];
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.outgoing[v] == kNone) continue;
    std::uint32_t in_fan = 0;
    s.for_each_outgoing(v, [&](std::uint32_t) { ++in_fan; });
    if (in_fan != faces[v]) s.set(v, kFixed);
  }
}

}  // namespace

void connect(Surface& s, const Progress* progress) {
  s.opposite.assign(s.corner.size(), kNone);
  s.edge.assign(s.corner.size(), kNone);
  s.halfedge.clear();
  s.edge_flags.clear();
  s.outgoing.assign(s.vertex_count(), kNone);
  s.vertex_flags.resize(s.vertex_count(), 0);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) s.outgoing[s.corner[h]] = h;
  join_halfedges(s, progress);
  stop_if_cancelled(progress);
  fix_pinched(s);
}

}  // namespace knead::remesh_detail
