#include "knead/mesh/edges.h"

#include <algorithm>
#include <cstdlib>

namespace knead {
namespace {

// Calls visit(use) for every use of an edge, in the order of corners.
template <class Visit>
void for_each_use(const Mesh& mesh, Visit visit) {
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::uint32_t begin = mesh.face_begin[f];
    const std::uint32_t end = mesh.face_begin[f + 1];
    for (std::uint32_t corner = begin; corner < end; ++corner) {
      const std::uint32_t next = corner + 1 < end ? corner + 1 : begin;
      const std::uint32_t a = mesh.corner_vertex[corner];
      const std::uint32_t b = mesh.corner_vertex[next];
      if (a != b) visit(EdgeUse{std::min(a, b), std::max(a, b), corner, next, a < b});
    }
  }
}

// A use of an edge at a given smaller vertex: twice the larger vertex, plus 1 if the face runs from small to large.
using HalfUse = std::uint64_t;

// Uses that are sorted together at least; of large meshes an eighth.
constexpr std::size_t kMostHalfUses = std::size_t{1} << 24;  // 134 MB
constexpr std::size_t kMostEdgeUses = 1'000'000;

// Calls visit(uses, ends) for parts of the vertices, as long as it returns true: make(use) for each use at each of them
// as the smaller vertex, in the order of vertices, then of corners; and where the uses of each vertex end.
template <class Use, class Make, class Visit>
void visit_parts(const Mesh& mesh, std::size_t least, const Make& make, const Visit& visit) {
  std::vector<std::uint32_t> end(mesh.vertex_count(), 0);  // of the uses at each smaller vertex
  for_each_use(mesh, [&](const EdgeUse& use) { ++end[use.low]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  const std::size_t all = end.empty() ? 0 : end.back();
  const std::size_t most = std::max(all / 8, least);
  std::vector<Use> uses;
  for (std::size_t first = 0, done = 0; done < all;) {
    // The vertices from `first` on whose uses fit into a part, at least one.
    const auto after = std::upper_bound(end.begin() + static_cast<std::ptrdiff_t>(first) + 1, end.end(), done + most);
    const auto last = static_cast<std::size_t>(after - end.begin());  // not among them
    std::vector<std::uint32_t> cursor(last - first);
    for (std::size_t v = first; v < last; ++v) {
      cursor[v - first] = static_cast<std::uint32_t>((v == 0 ? 0 : end[v - 1]) - done);
    }
    uses.resize(end[last - 1] - done);
    for_each_use(mesh, [&](const EdgeUse& use) {
      if (first <= use.low && use.low < last) uses[cursor[use.low - first]++] = make(use);
    });
    if (!visit(std::span<Use>(uses), std::span<const std::uint32_t>(cursor))) return;
    done = end[last - 1];
    first = last;
  }
}

// Returns true if each edge is used more than once, and its uses in the two directions differ by at most one.
bool all_balanced(std::span<HalfUse> uses) {
  std::sort(uses.begin(), uses.end());
  for (std::size_t begin = 0; begin < uses.size();) {
    std::ptrdiff_t upward = 0;
    std::size_t end = begin;
    for (; end < uses.size() && uses[end] / 2 == uses[begin] / 2; ++end) upward += uses[end] % 2 == 1 ? 1 : -1;
    if (end - begin == 1 || std::abs(upward) > 1) return false;
    begin = end;
  }
  return true;
}

// Sorts the uses at each smaller vertex, which are together, by edge, then by corner; visits each edge.
void visit_edges(std::span<EdgeUse> uses, const std::function<void(std::span<const EdgeUse>)>& visit) {
  const auto earlier = [](const EdgeUse& a, const EdgeUse& b) {
    return a.high != b.high ? a.high < b.high : a.corner < b.corner;
  };
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin;
    while (end < uses.size() && uses[end].low == uses[begin].low) ++end;
    std::sort(uses.begin() + static_cast<std::ptrdiff_t>(begin), uses.begin() + static_cast<std::ptrdiff_t>(end),
              earlier);
    while (begin < end) {
      std::size_t next = begin + 1;
      while (next < end && uses[next].high == uses[begin].high) ++next;
      visit(uses.subspan(begin, next - begin));
      begin = next;
    }
  }
}

}  // namespace

bool is_closed_and_oriented(const Mesh& mesh) {
  bool balanced = true;
  const auto half_use = [](const EdgeUse& use) { return HalfUse{use.high} * 2 + (use.upward ? 1 : 0); };
  visit_parts<HalfUse>(mesh, kMostHalfUses, half_use,
                       [&](std::span<HalfUse> uses, std::span<const std::uint32_t> ends) {
                         std::size_t begin = 0;
                         for (const std::uint32_t end : ends) {
                           balanced = balanced && all_balanced(uses.subspan(begin, end - begin));
                           begin = end;
                         }
                         return balanced;
                       });
  return balanced && mesh.face_count() > 0;
}

void for_each_edge(const Mesh& mesh, const std::function<void(std::span<const EdgeUse>)>& visit) {
  visit_parts<EdgeUse>(
      mesh, kMostEdgeUses, [](const EdgeUse& use) { return use; },
      [&](std::span<EdgeUse> uses, std::span<const std::uint32_t>) {
        visit_edges(uses, visit);
        return true;
      });
}

}  // namespace knead
