// What every mesh needs: its checks, the triangles of its faces, and its edges (edges.h).
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>
#include <utility>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/edges.h"

namespace knead {

namespace {

void check_faces(const Mesh& mesh) {
  const auto& begin = mesh.face_begin;
  if (begin.empty() || begin.front() != 0) throw InvalidInput("a mesh's \"face_begin\" must begin with 0");
  for (std::size_t f = 0; f + 1 < begin.size(); ++f) {
    if (begin[f] > begin[f + 1]) {
      throw InvalidInput(fmt::format("face {} of a mesh begins after it ends; let \"face_begin\" never decrease", f));
    }
  }
  if (begin.back() != mesh.corner_vertex.size()) {
    throw InvalidInput(
        fmt::format("the last face of a mesh ends at corner {} of {}; let \"face_begin\" end with their "
                    "number",
                    begin.back(), mesh.corner_vertex.size()));
  }
  std::uint32_t largest = 0;
  for (const std::uint32_t v : mesh.corner_vertex) largest = std::max(largest, v);
  if (mesh.corner_vertex.empty() || largest < mesh.positions.size()) return;
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    if (mesh.corner_vertex[c] < mesh.positions.size()) continue;
    throw InvalidInput(fmt::format("corner {} of a mesh names vertex {}, but there are only {} vertices; correct it", c,
                                   mesh.corner_vertex[c], mesh.positions.size()));
  }
}

void check_coordinates(std::span<const Vec3d> positions) {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (is_finite(positions[v])) continue;
    throw InvalidInput(fmt::format("vertex {} of a mesh has a coordinate that is not finite; place or remove it", v));
  }
}

struct Point2 {
  double x = 0;
  double y = 0;
  friend bool operator==(const Point2&, const Point2&) = default;
};

// Returns twice the signed area of the triangle a b c.
double orient(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The polygon projected along the largest component of its normal, counter-clockwise.
std::vector<Point2> flatten(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon) {
  const Vec3d n = polygon_normal(positions, polygon);
  const Vec3d size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  const std::size_t u = n[axis] >= 0 ? (axis + 1) % 3 : (axis + 2) % 3;
  const std::size_t v = n[axis] >= 0 ? (axis + 2) % 3 : (axis + 1) % 3;
  std::vector<Point2> points;
  points.reserve(polygon.size());
  for (const std::uint32_t vertex : polygon) points.push_back({positions[vertex][u], positions[vertex][v]});
  return points;
}

bool is_convex(const std::vector<Point2>& points) {
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (orient(points[(i + n - 1) % n], points[i], points[(i + 1) % n]) < 0) return false;
  }
  return true;
}

void add_fan(std::span<const std::uint32_t> polygon, std::vector<Triangle>& triangles) {
  for (std::size_t i = 2; i < polygon.size(); ++i) triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
}

// Ear clipping: repeatedly cuts off a corner whose triangle contains no other corner. The remaining corners form a
// ring.
class EarClipper {
 public:
  EarClipper(std::vector<Point2> points, std::span<const std::uint32_t> polygon)
      : points_(std::move(points)), polygon_(polygon), next_(points_.size()), previous_(points_.size()) {
    const std::size_t n = points_.size();
    for (std::size_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
  }

  void clip(std::vector<Triangle>& triangles) {
    std::size_t left = points_.size();
    std::size_t corner = 1;
    std::size_t refused = 0;  // consecutive corners that are not ears
    while (left > 3) {
      if (refused < left && tests_ < kMaxTests && !is_ear(corner)) {
        ++refused;
        corner = next_[corner];
        continue;
      }
      cut(corner, triangles);
      corner = next_[corner];
      --left;
      refused = 0;
    }
    cut(corner, triangles);
  }

 private:
  static constexpr std::size_t kMaxTests = 10'000'000;

  // Returns true for a convex corner whose triangle contains no other corner. Corners at the position of one of its own
  // are ignored: they come from polygons with a bridge to a hole.
  bool is_ear(std::size_t corner) {
    const Point2& a = points_[previous_[corner]];
    const Point2& b = points_[corner];
    const Point2& c = points_[next_[corner]];
    if (orient(a, b, c) <= 0) return false;
    for (std::size_t i = next_[next_[corner]]; i != previous_[corner]; i = next_[i]) {
      ++tests_;
      const Point2& p = points_[i];
      if (p == a || p == b || p == c) continue;
      if (orient(a, b, p) >= 0 && orient(b, c, p) >= 0 && orient(c, a, p) >= 0) return false;
    }
    return true;
  }

  void cut(std::size_t corner, std::vector<Triangle>& triangles) {
    triangles.push_back({polygon_[previous_[corner]], polygon_[corner], polygon_[next_[corner]]});
    next_[previous_[corner]] = next_[corner];
    previous_[next_[corner]] = previous_[corner];
  }

  std::vector<Point2> points_;
  std::span<const std::uint32_t> polygon_;
  std::vector<std::size_t> next_;
  std::vector<std::size_t> previous_;
  std::size_t tests_ = 0;
};

constexpr std::uint32_t kPartVertices = 4096;  // their corners fit into a cache
constexpr std::size_t kCornerChunks = 32;

// Finds the faces of corners that are asked for in ascending order.
class FaceCursor {
 public:
  explicit FaceCursor(const Mesh& mesh) : begin_(mesh.face_begin) {}

  StarCorner neighbours(const Mesh& mesh, std::uint32_t corner) {
    const std::uint32_t third = corner / 3;
    if (third + 1 < begin_.size() && begin_[third] == 3 * third && begin_[third + 1] == 3 * third + 3) {
      face_ = third;  // the faces before it have three corners each, or on average
    } else if (corner >= begin_[face_ + 1]) {
      advance(corner);
    }
    const std::uint32_t next = corner + 1 < begin_[face_ + 1] ? corner + 1 : begin_[face_];
    const std::uint32_t previous = (corner > begin_[face_] ? corner : begin_[face_ + 1]) - 1;
    return {corner, next, previous, mesh.corner_vertex[next], mesh.corner_vertex[previous]};
  }

 private:
  void advance(std::uint32_t corner) {
    std::size_t low = face_ + 1;  // begins at the corner or before
    std::size_t step = 1;
    for (; low + step < begin_.size() && begin_[low + step] <= corner; step *= 2) low += step;
    const auto begin = begin_.begin() + static_cast<std::ptrdiff_t>(low);
    const auto end = begin_.begin() + static_cast<std::ptrdiff_t>(std::min(low + step, begin_.size()));
    face_ = static_cast<std::size_t>(std::upper_bound(begin, end, corner) - begin_.begin()) - 1;
  }

  std::span<const std::uint32_t> begin_;
  std::size_t face_ = 0;
};

// Appends the uses of the edges from `vertex` to larger vertices.
void add_uses(std::uint32_t vertex, std::span<const StarCorner> star, std::vector<EdgeUse>& uses) {
  for (const StarCorner& at : star) {
    if (vertex < at.next_vertex) uses.push_back({vertex, at.next_vertex, at.corner, at.next, true});
    if (vertex < at.previous_vertex) uses.push_back({vertex, at.previous_vertex, at.previous, at.corner, false});
  }
}

}  // namespace
double color_scale(const Attribute& color) {
  constexpr double kByteScale = 1.0 / 255;
  constexpr double kShortScale = 1.0 / 65535;
  constexpr double kMaxBrightness = 16;  // of light that is brighter than white
  if (color.type == NumberType::uint8) return kByteScale;
  if (color.type == NumberType::uint16) return kShortScale;
  const bool is_real = color.type == NumberType::float32 || color.type == NumberType::float64;
  double greatest = 0;
  bool is_whole = true;
  for (const double c : color.values) {
    greatest = std::max(greatest, c);
    is_whole = is_whole && c == std::floor(c);
  }
  if (is_real && greatest <= (is_whole ? 1 : kMaxBrightness)) return 1;
  return greatest <= 255 ? kByteScale : kShortScale;
}

void require_faces(const Mesh& mesh, std::span<const Vec3d> positions) {
  check_faces(mesh);
  if (positions.size() != mesh.vertex_count()) {
    throw InvalidInput(fmt::format("{} positions for a mesh of {} vertices; give one for each", positions.size(),
                                   mesh.vertex_count()));
  }
}

void require_sound(const Mesh& mesh, std::span<const Vec3d> positions) {
  require_faces(mesh, positions);
  check_coordinates(positions);
}

void validate(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  for (const Attribute& attribute : mesh.attributes) {
    const std::size_t count = mesh.element_count(attribute.domain);
    if (attribute.components > 0 && attribute.values.size() == count * static_cast<std::size_t>(attribute.components)) {
      continue;
    }
    throw InvalidInput(fmt::format("the attribute \"{}\" of a mesh has {} numbers for {} elements of {} components",
                                   attribute.name, attribute.values.size(), count, attribute.components));
  }
}

Vec3d polygon_normal(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon) {
  Vec3d sum;
  if (polygon.size() < 3) return sum;
  const Vec3d& origin = positions[polygon[0]];
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    sum += cross(positions[polygon[i - 1]] - origin, positions[polygon[i]] - origin);
  }
  return sum;
}

void triangulate_polygon(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon,
                         std::vector<Triangle>& triangles) {
  if (polygon.size() == 3) return add_fan(polygon, triangles);
  std::vector<Point2> points = flatten(positions, polygon);
  if (is_convex(points)) return add_fan(polygon, triangles);
  EarClipper(std::move(points), polygon).clip(triangles);
}

std::vector<Triangle> triangulate(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.corner_vertex.size());
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) { triangles.push_back(t); });
  return triangles;
}

std::vector<std::uint32_t> triangle_faces(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  std::vector<std::uint32_t> faces;
  faces.reserve(mesh.corner_vertex.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t i = 2; i < mesh.face(f).size(); ++i) faces.push_back(static_cast<std::uint32_t>(f));
  }
  return faces;
}

void check_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) {
      if (v >= positions.size()) {
        throw InvalidInput("triangle " + std::to_string(t) + " uses vertex " + std::to_string(v) + "; there are " +
                           std::to_string(positions.size()) + ", numbered from 0");
      }
      if (!is_finite(positions[v])) {
        throw InvalidInput("triangle " + std::to_string(t) + " uses vertex " + std::to_string(v) +
                           ", which has a coordinate that is not finite; place or remove it");
      }
    }
  }
}

CornerParts::CornerParts(const Mesh& mesh, int threads) : mesh_(mesh) {
  const std::size_t count = mesh.corner_vertex.size();
  const std::size_t parts = mesh.vertex_count() / kPartVertices + 1;
  const std::size_t grain = count / kCornerChunks + 1;
  std::vector<std::vector<std::uint32_t>> places((count + grain - 1) /
                                                 grain);  // per chunk: its next place in each part
  parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t>& place = places[begin / grain];
    place.assign(parts, 0);
    for (std::size_t c = begin; c < end; ++c) ++place[mesh.corner_vertex[c] / kPartVertices];
  });
  std::uint32_t sum = 0;
  begin_.reserve(parts + 1);
  for (std::size_t part = 0; part < parts; ++part) {
    begin_.push_back(sum);
    for (std::vector<std::uint32_t>& place : places) sum += std::exchange(place[part], sum);
  }
  begin_.push_back(sum);
  corners_.reset(new std::uint32_t[count]);  // make_unique would write zeros first
  parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t>& place = places[begin / grain];
    for (std::size_t c = begin; c < end; ++c) {
      corners_[place[mesh.corner_vertex[c] / kPartVertices]++] = static_cast<std::uint32_t>(c);
    }
  });
}

void CornerParts::visit_stars(std::size_t part,
                              const std::function<void(std::uint32_t, std::span<const StarCorner>)>& visit) const {
  const std::span<const std::uint32_t> corners{corners_.get() + begin_[part], corners_.get() + begin_[part + 1]};
  const std::size_t first = part * kPartVertices;
  const std::size_t last = std::min(first + kPartVertices, mesh_.vertex_count());
  std::vector<std::uint32_t> end(last - first, 0);  // of the corners at each vertex
  for (const std::uint32_t c : corners) ++end[mesh_.corner_vertex[c] - first];
  std::exclusive_scan(end.begin(), end.end(), end.begin(), 0U);
  std::vector<StarCorner> sorted(corners.size());
  FaceCursor faces(mesh_);
  for (const std::uint32_t c : corners) sorted[end[mesh_.corner_vertex[c] - first]++] = faces.neighbours(mesh_, c);
  std::span<const StarCorner> left = sorted;
  for (std::size_t v = first; v < last; ++v) {
    const std::size_t count = end[v - first] - (sorted.size() - left.size());
    visit(static_cast<std::uint32_t>(v), left.first(count));
    left = left.subspan(count);
  }
}

void CornerParts::visit_edges(std::size_t part, const std::function<void(std::span<const EdgeUse>)>& visit) const {
  const auto earlier = [](const EdgeUse& a, const EdgeUse& b) {
    return a.high != b.high ? a.high < b.high : a.corner < b.corner;
  };
  std::vector<EdgeUse> uses;
  visit_stars(part, [&](std::uint32_t vertex, std::span<const StarCorner> star) {
    uses.clear();
    add_uses(vertex, star, uses);
    std::sort(uses.begin(), uses.end(), earlier);
    std::size_t next = 0;
    for (std::size_t begin = 0; begin < uses.size(); begin = next) {
      while (next < uses.size() && uses[next].high == uses[begin].high) ++next;
      visit(std::span(uses).subspan(begin, next - begin));
    }
  });
}

bool is_closed_and_oriented(const Mesh& mesh, int threads) {
  const CornerParts parts(mesh, threads);
  std::atomic<bool> balanced{true};  // no edge is used once; the uses in its two directions differ by at most one
  parallel_for(parts.count(), 1, threads, [&](std::size_t part, std::size_t) {
    if (!balanced) return;
    parts.visit_edges(part, [&](std::span<const EdgeUse> uses) {
      const std::ptrdiff_t upward = std::count_if(uses.begin(), uses.end(), [](const EdgeUse& u) { return u.upward; });
      if (uses.size() == 1 || std::abs(2 * upward - std::ssize(uses)) > 1) balanced = false;
    });
  });
  return balanced && mesh.face_count() > 0;
}

void for_each_edge(const Mesh& mesh, const std::function<void(std::span<const EdgeUse>)>& visit) {
  const CornerParts parts(mesh, 1);
  for (std::size_t part = 0; part < parts.count(); ++part) parts.visit_edges(part, visit);
}

}  // namespace knead
