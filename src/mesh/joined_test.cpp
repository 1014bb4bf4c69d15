// Several meshes as one, and the way back; several vertices as one.
#include <gtest/gtest.h>

#include <vector>

#include "knead/mesh.h"
#include "support/unwelded.h"

namespace knead::joined_test {
namespace {

Mesh coloured(Mesh mesh, double value) {
  std::vector<double> colors(3 * mesh.vertex_count(), value);
  std::vector<double> labels(mesh.face_count(), value);
  std::vector<double> uv(2 * mesh.corner_vertex.size(), value);
  mesh.attributes = {{"color", Domain::vertex, NumberType::uint8, 3, colors},
                     {"label", Domain::face, NumberType::int32, 1, labels},
                     {"uv", Domain::corner, NumberType::float32, 2, uv}};
  return mesh;
}

struct Three {
  Mesh sphere = coloured(make_shape(ShapeKind::sphere, 42), 7);
  Mesh cloud{{{5, 0, 0}, {6, 0, 0}}, {0}, {}, {}};
  Mesh box = make_shape(ShapeKind::box, 200);
  JoinedMeshes joined{std::vector<const Mesh*>{&sphere, &cloud, &box}};
};

std::vector<std::uint32_t> counted_up(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<std::uint32_t>(i);
  return numbers;
}

TEST(JoinedMeshes, HoldsAllOneAfterTheOther) {
  const Three three;
  const Mesh& all = three.joined.mesh();
  validate(all);
  EXPECT_EQ(all.vertex_count(), three.sphere.vertex_count() + 2 + three.box.vertex_count());
  EXPECT_EQ(all.face_count(), three.sphere.face_count() + three.box.face_count());
  EXPECT_EQ(measure(all).components, 2);
  const std::span<const Vec3d> box = three.joined.vertices_of(2, std::span<const Vec3d>(all.positions));
  EXPECT_TRUE(std::equal(box.begin(), box.end(), three.box.positions.begin(), three.box.positions.end()));
  EXPECT_EQ(three.joined.part_of_face(0), 0U);
  EXPECT_EQ(three.joined.part_of_face(static_cast<std::uint32_t>(three.sphere.face_count())), 2U);
}

TEST(JoinedMeshes, GivesEachMeshBack) {
  const Three three;
  const Mesh& all = three.joined.mesh();
  const auto faces = counted_up(all.face_count());
  const auto vertices = counted_up(all.vertex_count());
  const Mesh* const meshes[] = {&three.sphere, &three.cloud, &three.box};
  for (std::size_t i = 0; i < 3; ++i) {
    const MeshPart part = three.joined.part_of(i, all, faces, vertices);
    EXPECT_EQ(part.mesh.positions, meshes[i]->positions) << i;
    EXPECT_EQ(part.mesh.face_begin, meshes[i]->face_begin) << i;
    EXPECT_EQ(part.mesh.corner_vertex, meshes[i]->corner_vertex) << i;
    EXPECT_EQ(part.mesh.attributes, meshes[i]->attributes) << i;
    EXPECT_EQ(part.face_source, counted_up(meshes[i]->face_count())) << i;
  }
}

TEST(JoinedMeshes, FollowsARemeshThatMixesThem) {
  // Faces in reverse order, vertices too, and one new vertex in the middle of a face of the sphere.
  const Three three;
  const Mesh& all = three.joined.mesh();
  const auto count = static_cast<std::uint32_t>(all.vertex_count());
  Mesh mixed;
  std::vector<std::uint32_t> face_source;
  std::vector<std::uint32_t> vertex_source;
  for (std::uint32_t v = count; v-- > 0;) {
    mixed.positions.push_back(all.positions[v]);
    vertex_source.push_back(v);
  }
  for (auto f = static_cast<std::uint32_t>(all.face_count()); f-- > 1;) {
    std::vector<std::uint32_t> corners;
    for (const std::uint32_t v : all.face(f)) corners.push_back(count - 1 - v);
    mixed.add_face(corners);
    face_source.push_back(f);
  }
  mixed.positions.push_back({0, 0, 0});
  vertex_source.push_back(0xffffffffu);
  const std::span<const std::uint32_t> first = all.face(0);
  for (std::size_t k = 0; k < 3; ++k) {
    mixed.add_face(std::vector<std::uint32_t>{count - 1 - first[k], count - 1 - first[(k + 1) % 3], count});
    face_source.push_back(0);
  }
  mixed.attributes = all.attributes;
  mixed.attributes[0].values.resize(3 * mixed.vertex_count(), 7);
  mixed.attributes[1].values.assign(mixed.face_count(), 7);
  mixed.attributes[2].values.assign(2 * mixed.corner_vertex.size(), 7);

  const MeshPart sphere = three.joined.part_of(0, mixed, face_source, vertex_source);
  validate(sphere.mesh);
  EXPECT_EQ(sphere.mesh.vertex_count(), three.sphere.vertex_count() + 1);
  EXPECT_EQ(sphere.mesh.face_count(), three.sphere.face_count() + 2);
  EXPECT_NEAR(measure(sphere.mesh).area, measure(three.sphere).area, 0.7 * measure(three.sphere).area);
  const MeshPart cloud = three.joined.part_of(1, mixed, face_source, vertex_source);
  EXPECT_EQ(cloud.mesh.vertex_count(), 2U);
  EXPECT_EQ(cloud.mesh.face_count(), 0U);
  const MeshPart box = three.joined.part_of(2, mixed, face_source, vertex_source);
  validate(box.mesh);
  EXPECT_NEAR(measure(box.mesh).volume, measure(three.box).volume, 1e-12);
  EXPECT_THROW(three.joined.part_of(0, mixed, {}, vertex_source), InvalidInput);
}

TEST(JoinedMeshes, CountsCrossingsOfDifferentMeshesOnly) {
  const Mesh big = make_shape(ShapeKind::sphere, 162);
  Mesh aside = big;
  for (Vec3d& p : aside.positions) p.x += 1.5;
  const JoinedMeshes folded{std::vector<const Mesh*>{&big, &aside}};
  for (Vec3d& p : aside.positions) p.x += 9;
  const JoinedMeshes far{std::vector<const Mesh*>{&folded.mesh(), &aside}};
  const auto between = [](const JoinedMeshes& joined) {
    const Mesh& mesh = joined.mesh();
    return count_between(self_intersections(triangulate(mesh), mesh.positions), joined, triangle_faces(mesh));
  };
  EXPECT_GT(between(folded), 20U);
  EXPECT_EQ(between(far), 0U);
  EXPECT_GT(self_intersections(triangulate(far.mesh()), far.mesh().positions).count, 20U);
}

TEST(WeldedMesh, EachPlaceIsOneVertex) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 642);
  Mesh soup = test::unwelded(sphere);
  soup.positions[4].x = -0.0 + soup.positions[4].x;
  const WeldedMesh welded(soup);
  EXPECT_EQ(welded.count(), soup.vertex_count() - sphere.vertex_count());
  EXPECT_TRUE(measure(welded.mesh()).closed());
  EXPECT_EQ(measure(welded.mesh()).euler, 2);
  EXPECT_EQ(measure(soup).components, sphere.face_count());
  EXPECT_EQ(welded.mesh().vertex_count(), soup.vertex_count());
  for (std::uint32_t v = 0; v < soup.vertex_count(); ++v) {
    EXPECT_LE(welded.first(v), v);
    EXPECT_EQ(soup.positions[welded.first(v)], soup.positions[v]);
  }
  std::vector<Vec3d> moved = soup.positions;
  for (std::uint32_t v = 0; v < moved.size(); ++v) moved[v].x += welded.first(v) == v ? 1 : 5;
  welded.share(moved);
  EXPECT_EQ(moved[17], soup.positions[17] + Vec3d(1, 0, 0));
}

// Two closed parts that touch in a vertex have no border.
TEST(WeldedMesh, WhatOnlyTouchesStaysApart) {
  const Mesh ball = make_shape(ShapeKind::sphere, 42);
  Mesh other = ball;
  for (Vec3d& p : other.positions) p = ball.positions[7] * 2 - p;
  const JoinedMeshes both{std::vector<const Mesh*>{&ball, &other}};
  const WeldedMesh welded(both.mesh());
  EXPECT_EQ(welded.count(), 0U);
  EXPECT_EQ(&welded.mesh(), &both.mesh());
}

}  // namespace
}  // namespace knead::joined_test
