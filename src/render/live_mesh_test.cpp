// LiveMesh: normals and changed ranges.
#include "render/live/live.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "support/pictures.h"

namespace knead::render::live_mesh_test {
namespace {

Placement as_it_is() { return {}; }

TEST(LiveMesh, NormalsOfASphereAndOfACube) {
  const Mesh ball = sphere({}, 1, 10242);
  const LiveMesh live(ball, as_it_is(), 0.7);
  ASSERT_EQ(live.vertices().size(), ball.vertex_count());
  for (const LiveVertex& v : live.vertices()) EXPECT_GT(dot(Vec3d(v.normal), Vec3d(v.position)), 0.9999);
  const LiveMesh box(cube(), as_it_is(), 0.7);
  ASSERT_EQ(box.vertices().size(), 24u);
  for (const LiveVertex& v : box.vertices()) {
    EXPECT_NEAR(std::max({std::abs(v.normal.x), std::abs(v.normal.y), std::abs(v.normal.z)}), 1, 1e-6);
    EXPECT_NEAR(dot(v.normal, v.position), 1, 1e-6);
  }
  EXPECT_EQ(box.edges().size(), 24u);  // twelve edges
  EXPECT_EQ(box.triangles().size(), 36u);
}

TEST(LiveMesh, NormalsDoNotDependOnThreads) {
  const Mesh hand = make_shape(ShapeKind::hand, 20000);
  Mesh after = hand;
  for (Vec3d& p : after.positions) p.x += 0.1 * std::sin(5 * p.y);
  std::vector<LiveMesh> live(3, LiveMesh(hand, as_it_is(), 0.7));
  const VertexRange all = all_of(hand);
  std::vector<VertexRange> pieces;
  for (std::uint32_t v = 0; v < hand.vertex_count(); v += 777) pieces.push_back({v, std::min(v + 777, all.end)});
  live[0].move(after.positions, {&all, 1}, 1);
  live[1].move(after.positions, {&all, 1}, 0);
  live[2].move(after.positions, pieces, 0);
  for (std::size_t i = 0; i < live[0].vertices().size(); ++i) {
    const LiveVertex& v = live[0].vertices()[i];
    for (const LiveMesh& other : live) {
      ASSERT_EQ(other.vertices()[i].normal, v.normal);
      ASSERT_EQ(other.vertices()[i].position, v.position);
    }
  }
}

TEST(LiveMesh, ReturnsTheTouchedRangesWithTheirRing) {
  const Mesh ball = sphere({}, 1, 10242);
  LiveMesh live(ball, as_it_is(), 0.7);
  Mesh after = ball;
  const std::vector<VertexRange> ranges = dent(after, 0.3);
  const std::vector<LiveVertex> before = live.vertices();
  const std::vector<VertexRange> drawn = live.move(after.positions, ranges, 0);
  std::vector<bool> listed(before.size(), false);
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    EXPECT_TRUE(i == 0 || drawn[i].begin > drawn[i - 1].end);
    for (std::uint32_t d = drawn[i].begin; d < drawn[i].end; ++d) listed[d] = true;
  }
  const LiveMesh anew(after, as_it_is(), 0.7);
  ASSERT_EQ(anew.vertices().size(), before.size());
  for (std::size_t d = 0; d < before.size(); ++d) {
    const LiveVertex& now = live.vertices()[d];
    EXPECT_TRUE(listed[d] || (now.position == before[d].position && now.normal == before[d].normal));
    EXPECT_TRUE(now.position == anew.vertices()[d].position && now.normal == anew.vertices()[d].normal);
  }
}

}  // namespace
}  // namespace knead::render::live_mesh_test
