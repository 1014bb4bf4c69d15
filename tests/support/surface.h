// A mesh as the tools that ask a surface see it.
#pragma once

#include <vector>

#include "knead/mesh/triangulate.h"

namespace knead::test {

struct Surface {
  explicit Surface(const Mesh& mesh) : positions(mesh.positions), triangles(triangulate(mesh)) {}

  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
};

}  // namespace knead::test
