// Which points of two surfaces belong together (knead fit --surface). Internal to the session room.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "knead/math/progress.h"
#include "knead/mesh/surface_tree.h"
#include "knead/mesh/triangulate.h"

namespace knead::session_detail {

// A point of a surface with its unit normal.
struct SurfaceSample {
  Vec3d point;
  Vec3d normal;
};

// A surface that nearest points are looked for on.
class FitSurface {
 public:
  // There is at least one triangle.
  FitSurface(std::vector<Triangle> triangles, std::vector<Vec3d> positions);

  double area() const { return area_; }
  double mean_edge() const { return mean_edge_; }

  // Returns `count` points, evenly by area; always the same ones.
  std::vector<SurfaceSample> samples(std::size_t count) const;

  // Returns the nearest point.
  SurfaceSample closest(const Vec3d& p) const;

 private:
  Vec3d normal_at(std::uint32_t triangle, const std::array<double, 3>& barycentric) const;

  std::vector<Triangle> triangles_;
  std::vector<Vec3d> positions_;
  std::vector<Vec3d> normals_;     // of the vertices
  std::vector<double> area_upto_;  // of the triangles up to each, it included
  double area_ = 0;
  double mean_edge_ = 0;
  SurfaceTree tree_;
};

// A point of the source's surface that shall move by `by` along `direction`; how it moves across that is free.
struct Match {
  Vec3d at;
  Vec3d direction;  // a unit vector
  double by = 0;
  double weight = 1;  // 0 to 1: how sure the match is
};

struct Matches {
  std::vector<Match> all;
  double mean_distance = 0;  // of the samples of both surfaces from the other one
};

// Matches samples of the source to the target's surface, and samples of the target to the source's. A match counts less
// where the normals disagree, and where it is much farther than most.
Matches match(const FitSurface& source, std::span<const SurfaceSample> of_source, const FitSurface& target,
              std::span<const SurfaceSample> of_target, int threads, const Progress* progress);

}  // namespace knead::session_detail
