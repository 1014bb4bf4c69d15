// What a pose does to a shape: volume, crossings, stretch. Internal to the skin module.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/skin.h"

namespace knead::skin_detail {

// A shape at rest, with which poses of it are compared. The mesh must outlive it.
class RestShape {
 public:
  RestShape(const Mesh& mesh, int threads, const Progress* progress);

  SkinMeasures measure(std::span<const Vec3d> posed) const;

 private:
  SelfIntersections crossings_at(std::span<const Vec3d> positions) const;

  const Mesh& mesh_;
  std::vector<Triangle> triangles_;
  int threads_;
  const Progress* progress_;
  bool has_volume_ = false;
  double volume_ = 0;
  SelfIntersections crossings_;
};

}  // namespace knead::skin_detail
