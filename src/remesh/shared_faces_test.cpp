// remesh() where faces share edges or lie on each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/vec.h"
#include "support/deformed.h"

namespace knead::shared_faces_test {
namespace {

using test::crossings_as_float;
using test::Deformed;
using test::pull;

TEST(Remesh, EdgesOfThreeFacesAreSplitForAllOfThem) {
  Mesh mesh = make_shape(ShapeKind::sphere, 500);
  // A fin on one edge.
  const auto face = mesh.face(0);
  const std::uint32_t a = face[0];
  const std::uint32_t b = face[1];
  mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.75);
  mesh.add_face(std::array{a, b, static_cast<std::uint32_t>(mesh.positions.size() - 1)});
  const Vec3d at = mesh.positions[a];
  const Remeshed result = Deformed(mesh, pull(at, at * 1.5, 0.1, 0.8)).remeshed();
  EXPECT_GT(measure(result.mesh).nonmanifold_edges, 1U);
  EXPECT_EQ(crossings_as_float(result.mesh), 0U);
  EXPECT_EQ(measure(result.mesh).euler, measure(mesh).euler);
}

// The second face of a pair may have other values at its corners, and run the other way.
TEST(Remesh, EqualFacesAreDividedInOneWay) {
  Mesh mesh = make_shape(ShapeKind::sphere, 500);
  const std::size_t faces = mesh.face_count();
  for (std::uint32_t f = 0; f < faces; f += 2) {
    const auto face = mesh.face(f);
    mesh.add_face(f % 4 == 0 ? std::array{face[0], face[1], face[2]} : std::array{face[0], face[2], face[1]});
  }
  Attribute along{"along", Domain::corner, NumberType::float64, 1, {}};
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    along.values.push_back(mesh.positions[mesh.corner_vertex[c]].x + (c < 3 * faces ? 0 : 5));
  }
  mesh.attributes = {along};
  const Remeshed result = Deformed(mesh, pull({0, 0, 1}, {0, 0, 1.8}, 0.2, 0.9)).remeshed();
  Mesh once;  // without the second faces
  once.positions = result.mesh.positions;
  std::map<std::set<std::uint32_t>, double> sums;  // of the values, seconds minus firsts
  for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
    const auto face = result.mesh.face(f);
    const std::uint32_t source = result.face_source[f];
    if (source < faces) once.add_face(face);
    if (source < faces && source % 2 == 1) continue;
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += result.mesh.attributes[0].values[3 * f + i];
    sums[{face.begin(), face.end()}] += source < faces ? -sum : sum;
  }
  EXPECT_GT(sums.size(), faces);
  for (const auto& [face, sum] : sums) EXPECT_NEAR(sum, 15, 1e-12);
  EXPECT_TRUE(measure(once).closed() && measure(once).manifold());
  EXPECT_EQ(crossings_as_float(once), 0U);
}

// Quadrilaterals of a dome; each is there once or twice, the second time beginning at its next corner.
Mesh dome(std::size_t times) {
  constexpr std::uint32_t kSide = 12;
  Mesh mesh;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const Vec3d p{2.0 * (i % kSide) / (kSide - 1) - 1, 2.0 * (i / kSide) / (kSide - 1) - 1, 0};
    mesh.positions.push_back({p.x, p.y, 0.3 * std::sin(2 * p.x + p.y) - 0.2 * p.x * p.y});
  }
  for (std::size_t time = 0; time < times; ++time) {
    for (std::uint32_t i = 0; i + kSide + 1 < kSide * kSide; ++i) {
      std::array face{i, i + 1, i + kSide + 1, i + kSide};
      std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(time), face.end());
      if (i % kSide != kSide - 1) mesh.add_face(face);
    }
  }
  return mesh;
}

TEST(Remesh, ASheetThatIsThereTwiceIsRemeshedAsOnce) {
  const auto move = pull({0, 0, 0}, {0.1, 0, 0.8}, 0.1, 0.7);
  const Remeshed once = Deformed(dome(1), move).remeshed();
  const Remeshed twice = Deformed(dome(2), move).remeshed();
  EXPECT_GT(once.mesh.vertex_count(), 1000U);
  EXPECT_EQ(twice.mesh.positions, once.mesh.positions);
  // The first remesh leaves quadrilaterals that it does not touch as they are, the second those that are there twice.
  EXPECT_EQ(triangulate(twice.mesh).size(), 2 * triangulate(once.mesh).size());
  EXPECT_EQ(crossings_as_float(once.mesh), 0U);
}

TEST(Remesh, FacesThatLieOnOthersInAnotherWayAreRefused) {
  for (const std::size_t first : {0U, 1U}) {  // the diagonal of the quadrilateral, and the other one
    Mesh mesh = dome(1);
    const auto face = mesh.face(60);
    std::array<std::uint32_t, 4> corners{};
    std::copy(face.begin(), face.end(), corners.begin());
    const auto at = [&](std::size_t i) { return corners[(first + i) % 4]; };
    mesh.add_face(std::array{at(0), at(1), at(2)});
    mesh.add_face(std::array{at(0), at(2), at(3)});
    const Deformed deformed(mesh, pull({0, 0, 0}, {0, 0, 0.8}, 0.1, 0.7));
    EXPECT_THROW(deformed.remeshed(), InvalidInput);
  }
}

}  // namespace
}  // namespace knead::shared_faces_test
