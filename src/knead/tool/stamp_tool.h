// The tool of a stamp: a closed mesh in its pose, and what is asked of it. Internal to the tool room.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "knead/math/box.h"
#include "knead/math/mat3.h"
#include "knead/mesh/mesh.h"
#include "knead/mesh/surface_tree.h"

namespace knead::tool_detail {

// Places are relative to the tool's origin; directions are unit vectors. The tool need not be convex, nor in one piece;
// where it passes through itself, what is inside of any part is inside.
class StampTool {
 public:
  // Throws InvalidInput, beginning with "mesh" in quotes, where the mesh is not closed or does not look outward.
  StampTool(const Mesh& mesh, const Mat3d& pose);

  const Box& box() const { return box_; }

  // From a place inside, the way out along a direction.
  struct Front {
    double need = 0;  // its length
    Vec3d normal;     // of the face where it ends, a unit vector; the zero vector for a face without area
  };
  // Nothing where p is outside.
  std::optional<Front> front(const Vec3d& p, const Vec3d& direction) const;

  // The normal of the face nearest to p, as in Front.
  Vec3d nearest_normal(const Vec3d& p) const;

  // The shortest way out of the tool; nothing where p is outside.
  std::optional<Vec3d> way_out(const Vec3d& p) const;

  // The distance of p from the surface, on either side.
  double distance(const Vec3d& p) const;

  // The distance of p from the surface where p is inside, else 0.
  double depth(const Vec3d& p) const;

  // Half the tool's largest width across a direction, to 0.02%.
  double half_width(const Vec3d& direction) const;

  // How narrow the tool's front gets: on 95% of its area, seen along the direction, the tool is wider than that so much
  // `below` its face, or half way to its back where it is thinner. To about a fifth, from 128 places.
  double narrowest_width(const Vec3d& direction, double below) const;

 private:
  Vec3d normal_of(std::uint32_t triangle) const;
  // The third shortest chord through p; nothing where p is outside.
  std::optional<double> width_at(const Vec3d& p, std::span<const Vec3d> across) const;

  std::vector<Vec3d> positions_;
  std::vector<Triangle> triangles_;
  Box box_;
  SurfaceTree tree_;
};

}  // namespace knead::tool_detail
