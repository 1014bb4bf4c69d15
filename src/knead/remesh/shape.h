// How well shaped triangles are. Internal to the remesh room.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// The tangent of the triangle's smallest angle; 0 where it has no area.
inline double quality(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  double p = norm2(b - a);
  double q = norm2(c - b);
  double r = norm2(a - c);
  if (p > q) std::swap(p, q);
  if (p > r) std::swap(p, r);
  const double twice_cosine = q + r - p;  // times the two longer edges
  return twice_cosine > 0 ? 2 * norm(cross(b - a, c - a)) / twice_cosine : 0.0;
}

inline double quality(const Surface& s, std::size_t face, std::span<const Vec3d> positions) {
  const auto [a, b, c] = s.triangle(face);
  return quality(positions[a], positions[b], positions[c]);
}

// The half-edge of the face's longest edge.
inline std::uint32_t longest_edge(const Surface& s, std::size_t face, std::span<const Vec3d> positions) {
  const auto first = static_cast<std::uint32_t>(3 * face);
  std::uint32_t longest = first;
  double most = -1;
  for (std::uint32_t h = first; h < first + 3; ++h) {
    const double length2 = norm2(positions[s.target(h)] - positions[s.origin(h)]);
    if (length2 > most) {
      most = length2;
      longest = h;
    }
  }
  return longest;
}

// Below this quality (3 degrees) a triangle's normal is chance.
inline const double kThin = std::tan(std::numbers::pi / 60);

// How far faces may turn: by an angle of at most this cosine, from their own normals, or, where these are unsteady
// because their quality is below `steady`, from the mean of their surroundings.
struct TurnLimit {
  double cosine = -1;
  double steady = kThin;
};

// Whether a face of that quality turns too far.
bool turns(const TurnLimit& limit, const Vec3d& was, const Vec3d& is, double quality_was, const Vec3d& mean);

// The least quality of the faces around v, were it at p; negative where one of them would turn too far.
double star_quality(const Surface& s, std::uint32_t v, const Vec3d& p, const TurnLimit& limit);

// How far p is from the planes of the faces around v, at most; thin faces are left out.
double plane_distance(const Surface& s, std::uint32_t v, const Vec3d& p);

// Whether an edge joins the two, or might, outside of the patch, because both are fixed.
bool are_neighbours(const Surface& s, std::uint32_t v, std::uint32_t w);

}  // namespace knead::remesh_detail
