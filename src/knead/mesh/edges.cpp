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
  std::vector<std::size_t> end(mesh.vertex_count() + 1, 0);
  for_each_use(mesh, [&](const EdgeUse& use) { ++end[use.low + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<HalfUse> uses(end.back());
  // Filling has moved each begin to the end of its vertex, which is the begin of the next.
  for_each_use(mesh, [&](const EdgeUse& use) { uses[end[use.low]++] = HalfUse{use.high} * 2 + (use.upward ? 1 : 0); });
  std::size_t begin = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!all_balanced({uses.data() + begin, end[v] - begin})) return false;
    begin = end[v];
  }
  return mesh.face_count() > 0;
}

void for_each_edge(const Mesh& mesh, const std::function<void(std::span<const EdgeUse>)>& visit) {
  std::vector<std::size_t> end(mesh.vertex_count(), 0);  // of the uses at each smaller vertex
  for_each_use(mesh, [&](const EdgeUse& use) { ++end[use.low]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  const std::size_t all = end.empty() ? 0 : end.back();
  const std::size_t most = std::max<std::size_t>(all / 8, 1'000'000);
  std::vector<EdgeUse> uses;
  for (std::size_t first = 0, done = 0; done < all;) {
    // The vertices from `first` on whose uses fit into a part, at least one.
    const auto after = std::upper_bound(end.begin() + static_cast<std::ptrdiff_t>(first) + 1, end.end(), done + most);
    const auto last = static_cast<std::size_t>(after - end.begin());  // not among them
    std::vector<std::size_t> cursor(last - first);
    for (std::size_t v = first; v < last; ++v) cursor[v - first] = (v == 0 ? 0 : end[v - 1]) - done;
    uses.resize(end[last - 1] - done);
    for_each_use(mesh, [&](const EdgeUse& use) {
      if (first <= use.low && use.low < last) uses[cursor[use.low - first]++] = use;
    });
    visit_edges(uses, visit);
    done = end[last - 1];
    first = last;
  }
}

}  // namespace knead
