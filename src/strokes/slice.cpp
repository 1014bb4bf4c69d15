// Cuts of triangles by a plane, joined into loops.
#include "strokes/slice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "mesh/edges.h"

namespace knead::detail {

namespace {

struct PlanePoint {
  double x = 0;
  double y = 0;
};

// An edge that the plane cuts, as one of the two of a cut triangle.
struct Cut {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t piece = 0;  // the cut triangle, numbered among the cut ones
  PlanePoint at;
};

struct Cutter {
  Vec3d point;
  Vec3d normal;
  Vec3d u;
  Vec3d v;
  std::span<const Vec3d> positions;

  double height(std::uint32_t vertex) const { return dot(normal, positions[vertex] - point); }
  bool is_above(std::uint32_t vertex) const { return height(vertex) > 0; }
  bool cuts(std::uint32_t a, std::uint32_t b) const { return is_above(a) != is_above(b); }

  // Of the edge's two ends in one order, so that both of its triangles have the same point.
  Cut cut(std::uint32_t a, std::uint32_t b, std::uint32_t piece) const {
    const auto [low, high] = std::minmax(a, b);
    const double from = height(low);
    const Vec3d d = positions[low] + (positions[high] - positions[low]) * (from / (from - height(high))) - point;
    return {low, high, piece, {dot(u, d), dot(v, d)}};
  }
};

// Whether a ray from the origin along +x crosses from p to q.
bool crosses_ray(const PlanePoint& p, const PlanePoint& q) {
  if ((p.y > 0) == (q.y > 0)) return false;
  return p.x + (q.x - p.x) * (p.y / (p.y - q.y)) > 0;
}

// Joins the triangles on both sides of every edge that is cut.
DisjointSets joined_across_edges(std::vector<Cut> cuts, std::size_t pieces) {
  std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) {
    return std::tie(a.low, a.high, a.piece) < std::tie(b.low, b.high, b.piece);
  });
  DisjointSets sets(pieces);
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    if (cuts[i].low == cuts[i - 1].low && cuts[i].high == cuts[i - 1].high) sets.join(cuts[i].piece, cuts[i - 1].piece);
  }
  return sets;
}

}  // namespace

std::vector<SliceLoop> slice(const Vec3d& point, const Vec3d& normal, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles) {
  const Vec3d u = any_orthogonal(normal);
  const Cutter cutter{point, normal, u, cross(normal, u), positions};
  std::vector<Cut> cuts;  // two for every triangle that is cut
  std::vector<std::uint32_t> cut_triangles;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const auto piece = static_cast<std::uint32_t>(cut_triangles.size());
    for (std::size_t k = 0; k < 3; ++k) {
      if (cutter.cuts(t[k], t[(k + 1) % 3])) cuts.push_back(cutter.cut(t[k], t[(k + 1) % 3], piece));
    }
    if (cuts.size() > 2 * cut_triangles.size()) cut_triangles.push_back(i);
  }
  DisjointSets sets = joined_across_edges(cuts, cut_triangles.size());
  std::map<std::uint32_t, SliceLoop> loops;
  for (std::uint32_t i = 0; i < cut_triangles.size(); ++i) {
    SliceLoop& loop = loops.try_emplace(sets.find(i), SliceLoop{0, false, cut_triangles[i]}).first->second;
    const PlanePoint& p = cuts[std::size_t{2} * i].at;
    const PlanePoint& q = cuts[std::size_t{2} * i + 1].at;
    loop.extent = std::max({loop.extent, std::sqrt(p.x * p.x + p.y * p.y), std::sqrt(q.x * q.x + q.y * q.y)});
    if (crosses_ray(p, q)) loop.around_point = !loop.around_point;
  }
  std::vector<SliceLoop> result;
  result.reserve(loops.size());
  for (const auto& [set, loop] : loops) result.push_back(loop);
  return result;
}

std::optional<SliceLoop> innermost(const std::vector<SliceLoop>& loops) {
  std::optional<SliceLoop> found;
  for (const SliceLoop& loop : loops) {
    if (loop.around_point && (!found || loop.extent < found->extent)) found = loop;
  }
  return found;
}

}  // namespace knead::detail
