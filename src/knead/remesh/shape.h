// The quality of triangles. Internal to the remesh room.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "knead/math/elementary.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// Returns the tangent of the smallest angle of the triangle; 0 if it has no area.
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

// Returns the half-edge of the longest edge of the face.
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

// Below this quality (3 degrees) the normal of a triangle is unreliable.
inline const double kThin = elementary::tan(std::numbers::pi / 60);

// The largest angle by which a change may turn a face. The angle is measured from the old normal of the face, or, if
// the quality of the face is below `reliable`, from the mean normal around it.
struct TurnLimit {
  double cosine = -1;  // of the largest angle
  double reliable = kThin;
};

// Returns true if a face with normal `was` and quality `quality_was` turns too far when its normal becomes `is`.
bool turns(const TurnLimit& limit, const Vec3d& was, const Vec3d& is, double quality_was, const Vec3d& mean);

// Returns the least quality of the faces around v if v were at p; negative if one of them would turn too far.
double star_quality(const Surface& s, std::uint32_t v, const Vec3d& p, const TurnLimit& limit);

// Returns the largest distance of p from the planes of the faces around v. Thin faces are ignored.
double plane_distance(const Surface& s, std::uint32_t v, const Vec3d& p);

// The faces around a vertex, read once to judge many places of it.
class Star {
 public:
  void read(const Surface& s, std::uint32_t v);

  // Returns star_vector() of the vertex.
  const Vec3d& vector() const { return vector_; }

  // Returns star_quality() of the place if that is above `floor`, else any number that is not.
  double quality_at(const Vec3d& p, const TurnLimit& limit, double floor) const;

  // Returns whether plane_distance() of the place is greater.
  bool is_farther(const Vec3d& p, double distance) const;

 private:
  struct Face {
    Vec3d b;  // the corners beside the vertex
    Vec3d c;
    Vec3d normal;     // the area vector
    double size = 0;  // its length
    double quality = 0;
  };

  Vec3d place_;
  Vec3d vector_;
  std::vector<Face> faces_;
};

// The most faces at a vertex: to look at more of them for every change would take too long.
inline constexpr int kMostFacesOfVertex = 200;

// Returns true if more faces are at v.
bool is_crowded(const Surface& s, std::uint32_t v);

// Returns true if an edge joins the two vertices, or might join them outside the patch because both are fixed.
bool are_neighbours(const Surface& s, std::uint32_t v, std::uint32_t w);

}  // namespace knead::remesh_detail
