#include "knead/session/carried_normals.h"

#include <algorithm>
#include <cmath>

namespace knead::session_detail {

bool has_direction(const Vec3d& normal) {
  const double length = norm(normal);
  return length > 0 && std::isfinite(length);
}

CarriedNormals carry_normals(std::span<const Vec3d> positions, std::vector<Vec3d> normals, double reach) {
  CarriedNormals carried;
  carried.reach = reach;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!has_direction(normals[i])) continue;
    const Vec3d n = normalized(normals[i]);
    const Vec3d a = any_orthogonal(n) * reach;
    const Vec3d b = cross(n, a);
    const Vec3d& p = positions[i];
    carried.vertex.push_back(static_cast<std::uint32_t>(i));
    carried.begin.insert(carried.begin.end(), {p + a, p - a, p + b, p - b});
  }
  carried.now = carried.begin;
  carried.normals = std::move(normals);
  return carried;
}

namespace {

// Of the k-th vertex that has points.
Vec3d turned(const CarriedNormals& carried, std::size_t k) {
  constexpr double torn = 1e3;  // times their distance before: no flow of a tool stretches so much over so little
  const Vec3d& normal = carried.normals[carried.vertex[k]];
  const std::span<const Vec3d> now = std::span(carried.now).subspan(4 * k, 4);
  if (std::equal(now.begin(), now.end(), carried.begin.begin() + static_cast<std::ptrdiff_t>(4 * k))) return normal;
  const Vec3d a = (now[0] - now[1]) / (2 * carried.reach);
  const Vec3d b = (now[2] - now[3]) / (2 * carried.reach);
  const Vec3d n = cross(a, b);
  if (!(norm(n) > 0) || norm(a) > torn || norm(b) > torn) return normal;
  return n * (norm(normal) / norm(n));
}

}  // namespace

std::vector<Vec3d> turned_normals(const CarriedNormals& carried) {
  std::vector<Vec3d> result = carried.normals;
  for (std::size_t k = 0; k < carried.vertex.size(); ++k) result[carried.vertex[k]] = turned(carried, k);
  return result;
}

Vec3d turned_normal(const CarriedNormals& carried, std::uint32_t vertex) {
  const auto found = std::lower_bound(carried.vertex.begin(), carried.vertex.end(), vertex);
  if (found == carried.vertex.end() || *found != vertex) return carried.normals[vertex];
  return turned(carried, static_cast<std::size_t>(found - carried.vertex.begin()));
}

}  // namespace knead::session_detail
