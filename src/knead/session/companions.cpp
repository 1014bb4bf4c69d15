#include "knead/session/companions.h"

#include <algorithm>

namespace knead {

bool has_direction(const Vec3d& normal) {
  const double length = norm(normal);
  return length > 0 && std::isfinite(length);
}

NormalCompanions companions_of(std::span<const Vec3d> positions, std::span<const Vec3d> normals, double reach) {
  NormalCompanions companions;
  companions.reach = reach;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!has_direction(normals[i])) continue;
    const Vec3d n = normalized(normals[i]);
    const Vec3d a = any_orthogonal(n) * reach;
    const Vec3d b = cross(n, a);
    const Vec3d& p = positions[i];
    companions.vertex.push_back(static_cast<std::uint32_t>(i));
    companions.points.insert(companions.points.end(), {p + a, p - a, p + b, p - b});
  }
  return companions;
}

std::vector<Vec3d> carried_normals(const NormalCompanions& companions, std::span<const Vec3d> moved,
                                   std::span<const Vec3d> normals) {
  constexpr double torn = 1e3;  // times their distance before: no flow of a tool stretches so much over so little
  std::vector<Vec3d> result(normals.begin(), normals.end());
  for (std::size_t k = 0; k < companions.vertex.size(); ++k) {
    const std::span<const Vec3d> now = moved.subspan(4 * k, 4);
    if (std::equal(now.begin(), now.end(), companions.points.begin() + static_cast<std::ptrdiff_t>(4 * k))) continue;
    const Vec3d a = (now[0] - now[1]) / (2 * companions.reach);
    const Vec3d b = (now[2] - now[3]) / (2 * companions.reach);
    const Vec3d n = cross(a, b);
    if (!(norm(n) > 0) || norm(a) > torn || norm(b) > torn) continue;
    Vec3d& normal = result[companions.vertex[k]];
    normal = n * (norm(normal) / norm(n));
  }
  return result;
}

}  // namespace knead
