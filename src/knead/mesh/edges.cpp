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

std::vector<EdgeUse> edge_uses(const Mesh& mesh) {
  std::vector<std::size_t> begin(mesh.vertex_count() + 1, 0);
  for_each_use(mesh, [&](const EdgeUse& use) { ++begin[use.low + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<EdgeUse> uses(begin.back());
  std::vector<std::size_t> cursor(begin.begin(), begin.end() - 1);
  for_each_use(mesh, [&](const EdgeUse& use) { uses[cursor[use.low]++] = use; });
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    std::sort(
        uses.begin() + static_cast<std::ptrdiff_t>(begin[v]), uses.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]),
        [](const EdgeUse& a, const EdgeUse& b) { return a.high != b.high ? a.high < b.high : a.corner < b.corner; });
  }
  return uses;
}

}  // namespace knead
