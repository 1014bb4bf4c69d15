// The box of a shape leaves out stray vertices.
#include <gtest/gtest.h>

#include <algorithm>

#include "knead/mesh.h"

namespace knead::shape_box_test {
namespace {

Mesh sphere() { return make_shape(ShapeKind::sphere, 642); }

Mesh with_strays(Mesh mesh, std::vector<Vec3d> strays) {
  mesh.positions.insert(mesh.positions.end(), strays.begin(), strays.end());
  return mesh;
}

TEST(ShapeBox, LeavesOutVerticesThatNoFaceUses) {
  const Mesh plain = sphere();
  for (const double far : {6.0, 1e4, 1e6, -1e17}) {
    const Mesh mesh = with_strays(plain, {{far, far, far}});
    EXPECT_EQ(shape_box(mesh).min, shape_box(plain).min);
    EXPECT_EQ(shape_box(mesh).max, shape_box(plain).max);
    const Measures measures = measure(mesh);
    EXPECT_EQ(measures.volume, measure(plain).volume);
    EXPECT_EQ(measures.box.diagonal(), measure(plain).box.diagonal());
    EXPECT_NE(stray_note(mesh).find("vertex " + std::to_string(plain.vertex_count()) + " at"), std::string::npos);
  }
  EXPECT_EQ(stray_note(with_strays(plain, {{0.1, 1.2, 0.3}})), "");
  EXPECT_NE(stray_note(with_strays(plain, {{7, 0, 0}, {8, 0, 0}})).find("2 vertices"), std::string::npos);
}

Mesh cloud_of(std::vector<Vec3d> points) {
  Mesh mesh;
  mesh.positions = std::move(points);
  return mesh;
}

TEST(ShapeBox, LeavesOutAFewPointsFarFromACloud) {
  const std::vector<Vec3d> points = sphere().positions;
  const Box box = bounding_box(points);
  std::vector<Vec3d> strays = points;
  for (int i = 1; i <= 5; ++i) strays.push_back({1e4 * i, 0, i % 2 == 0 ? 1e6 : -300.0});
  const Mesh mesh = cloud_of(strays);
  EXPECT_EQ(shape_box(mesh).min, box.min);
  EXPECT_EQ(shape_box(mesh).max, box.max);
  EXPECT_NE(stray_note(mesh).find("5 vertices"), std::string::npos);
  std::reverse(strays.begin(), strays.end());
  EXPECT_EQ(shape_box(cloud_of(strays)).max, box.max);
  EXPECT_EQ(stray_note(cloud_of(points)), "");
}

TEST(ShapeBox, PointsThatAreNotFarOrNotFewBelongToTheCloud) {
  std::vector<Vec3d> points = sphere().positions;
  points.push_back({9, 0, 0});
  EXPECT_EQ(shape_box(cloud_of(points)).max.x, 9);
  std::vector<Vec3d> halves = sphere().positions;
  for (std::size_t i = 0; i < halves.size(); i += 2) halves[i] *= 1e3;
  EXPECT_EQ(shape_box(cloud_of(halves)).diagonal(), bounding_box(halves).diagonal());
  EXPECT_EQ(shape_box(cloud_of({{0, 0, 0}, {1, 0, 0}, {1e6, 0, 0}})).max.x, 1e6);
  EXPECT_EQ(shape_box(cloud_of(std::vector<Vec3d>(50, Vec3d{1, 2, 3}))).diagonal(), 0);
  EXPECT_TRUE(shape_box(Mesh{}).empty());
}

TEST(CloudBox, IsThatOfAllPiecesTogether) {
  std::vector<Vec3d> points = sphere().positions;
  points.insert(points.begin(), {1e5, 1e5, 1e5});
  CloudBox cloud;
  for (std::size_t i = 0; i < points.size(); i += 7)
    cloud.add(std::span(points).subspan(i, std::min<std::size_t>(7, points.size() - i)));
  EXPECT_EQ(cloud.box().max, shape_box(cloud_of(points)).max);
  EXPECT_EQ(cloud.whole().max.x, 1e5);
}

}  // namespace
}  // namespace knead::shape_box_test
