// Gaussian splats as a surface: their normals, and strokes that read these.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead::splats_test {
namespace {

// Thin discs at the vertices of a mesh; every second one shows its other side.
Mesh discs_on(const Mesh& mesh) {
  Mesh splats;
  splats.positions = mesh.positions;
  const std::vector<Vec3d> normals = vertex_normals(mesh);
  for (const std::string name : {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    Attribute& attribute = splats.attributes.emplace_back(Attribute{name, Domain::vertex, NumberType::float32, 1, {}});
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const Vec3d n = i % 2 == 0 ? normals[i] : -normals[i];
      const std::array<double, 4> turn{1 + n.z + 1e-9, -n.y, n.x, 0};  // takes z to the normal
      const auto axis = static_cast<std::size_t>(name.back() - '0');
      attribute.values.push_back(name.starts_with("rot_") ? turn[axis] : axis == 2 ? -6 : -4);
    }
  }
  return splats;
}

TEST(SplatSurface, TheirNormalsPointOutwards) {
  for (const ShapeKind kind : {ShapeKind::hand, ShapeKind::torus}) {
    const Mesh mesh = make_shape(kind, 20'000);
    const std::vector<Vec3d> found = splat_normals(discs_on(mesh));
    const std::vector<Vec3d> expected = vertex_normals(mesh);
    std::size_t same = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_GT(std::abs(dot(found[i], expected[i])), 1 - 1e-6) << i;
      same += dot(found[i], expected[i]) > 0 ? 1 : 0;
    }
    EXPECT_GT(static_cast<double>(same), 0.99 * static_cast<double>(found.size()));
  }
}

TEST(SplatSurface, ArePaintedAsTheirSurface) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 5000);
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "paint", "outer": 0.4, "depth": 0.06, "path": [[-0.3, 0, 0.95], [0, 0, 1]]}
)",
      "s.knead");
  const std::vector<Vec3d> expected = replay(borrow(mesh), session).shape.positions();
  const std::vector<Vec3d> found = replay(discs_on(mesh), session).shape.positions();
  double moved = 0;
  double error = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    moved = std::max(moved, norm(expected[i] - mesh.positions[i]));
    error = std::max(error, norm(found[i] - expected[i]));
  }
  EXPECT_GT(moved, 0.02);
  EXPECT_LT(error, 0.1 * moved);
}

}  // namespace
}  // namespace knead::splats_test
