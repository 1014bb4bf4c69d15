// Volumes and rays on the GPU against the mesh's.
#include "knead/editor/gpu.h"

#include <gtest/gtest.h>

#include "knead/editor/gl.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/test_shapes.h"
#include "support/gpu_fixture.h"
#include "support/random_segments.h"

namespace knead::gpu::gpu_surface_test {
namespace {

using test::Random;

class GpuSurfaceTest : public GpuTest {};

std::vector<DirtyShape> shapes() {
  return {{"sphere", make_shape(ShapeKind::sphere, 10000), {}},
          {"box", make_shape(ShapeKind::box, 500), {}},
          {"torus", make_shape(ShapeKind::torus, 3000), {}},
          {"hand", make_shape(ShapeKind::hand, 8000), {}},
          {"knot", make_shape(ShapeKind::knot, 20000), {}},
          {"squares", quad_torus(40, 20), {}},
          {"two spheres that cross",
           join(make_shape(ShapeKind::sphere, 642), make_shape(ShapeKind::sphere, 642), {0.5, 0.1, 0.2}),
           {}}};
}

Flow stirring(const Box& box) {
  const double d = box.diagonal();
  Flow flow{{test::translating(Ball<double>{}, box.center(), Vec3d{0.1, 0.05, -0.02} * d, {0.05 * d, 0.3 * d})}};
  flow.segments.push_back(test::resting(Rotation<double>{{0, 0, 1}, 0.7, 1, RotationGauge::radial}, Ball<double>{},
                                        box.center() + Vec3d{0.1, 0, 0} * d, {0.1 * d, 0.4 * d}));
  return flow;
}

// The volume of the box, to which the rounding of tetrahedra with an apex at one of its corners is relative.
double volume_scale(const Mesh& mesh) {
  const Vec3d size = bounding_box(mesh.positions).max - bounding_box(mesh.positions).min;
  return size.x * size.y * size.z;
}

// The rounding of some 40,000 terms in another order: far below 1e-12 of the box.
TEST_F(GpuSurfaceTest, VolumeIsThatOfTheMesh) {
  for (const DirtyShape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    const Mesh& mesh = shape.mesh;
    const Box box = bounding_box(mesh.positions);
    const GpuSurface surface(gpu(), triangulate(mesh));
    GpuPoints points = gpu().upload(mesh.positions);
    const double expected = measure(mesh).volume;
    EXPECT_NEAR(surface.volume(points, box.center()), expected, 1e-12 * std::abs(expected));
    EXPECT_NEAR(surface.volume(points, box.max), expected, 1e-12 * volume_scale(mesh));
    gpu().advect(stirring(box), points, default_options(box.diagonal()));
    const std::vector<Vec3d> moved = downloaded(gpu(), points);
    const double after = measure_volume_and_area(mesh, moved).volume;
    EXPECT_NEAR(surface.volume(points, bounding_box(moved).center()), after, 1e-12 * std::abs(after));
  }
}

TEST_F(GpuSurfaceTest, VolumeHasTheSameBitsInBuffersOfAnySize) {
  const Mesh mesh = make_shape(ShapeKind::knot, 20000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const GpuPoints points = gpu().upload(mesh.positions);
  const GpuSurface surface(gpu(), triangles);
  const double volume = surface.volume(points, {0.1, 0.2, 0.3});
  for (int i = 0; i < 20; ++i) EXPECT_EQ(surface.volume(points, {0.1, 0.2, 0.3}), volume);
  for (const std::size_t ranges : {2U, 3U, 4U}) {
    GpuOptions options;
    options.most_points = (mesh.positions.size() / ranges / 64 + 1) * 64;
    Gpu other(options);
    const GpuPoints in_ranges = other.upload(mesh.positions);
    EXPECT_EQ(Gpu::buffers(in_ranges).size(), ranges);
    EXPECT_EQ(GpuSurface(other, triangles).volume(in_ranges, {0.1, 0.2, 0.3}), volume);
  }
}

// As first_hit says where it leaves.
std::optional<double> first_leaving(const std::vector<RayHit>& hits) {
  for (const RayHit& hit : hits) {
    if (hit.leaves) return hit.t;
  }
  return std::nullopt;
}

bool expect_same_hit(const GpuSurface& surface, const GpuPoints& points, const SurfaceTree& tree, const Vec3d& origin,
                     const Vec3d& direction) {
  const std::optional<GpuHit> found = surface.first_hit(points, origin, direction);
  const std::optional<RayHit> expected = tree.first_hit(origin, direction);
  EXPECT_EQ(found.has_value(), expected.has_value());
  if (!found || !expected) return false;
  EXPECT_EQ(found->triangle, expected->triangle);
  EXPECT_EQ(found->t, expected->t);
  EXPECT_EQ(found->leaves_at, first_leaving(tree.hits(origin, direction)));
  return true;
}

// Rays from anywhere, inside too, to anywhere; half of them through vertices or from one to another, where all
// triangles about them are met or missed by no more than rounding.
int expect_same_hits(Random& random, const GpuSurface& surface, const GpuPoints& points, const SurfaceTree& tree,
                     const std::vector<Vec3d>& positions) {
  const Box box = bounding_box(positions);
  const auto vertex = [&] {
    return positions[static_cast<std::size_t>(random.integer(0, 1 << 30)) % positions.size()];
  };
  const auto beside = [&] { return box.center() + random.in_box(box.diagonal()); };
  int hits = 0;
  for (int i = 0; i < 60; ++i) {
    const Vec3d to = i % 2 == 0 ? box.center() + random.in_box(0.3 * box.diagonal()) : vertex();
    const Vec3d from = i % 4 == 3 ? vertex() : beside();
    if (from == to) continue;
    const Vec3d direction = i % 5 == 0 ? Vec3d{0, 0, -1} : (to - from) * random.uniform(0.1, 2);
    const Vec3d origin = i % 5 == 0 ? to + Vec3d{0, 0, 2} : from;
    if (expect_same_hit(surface, points, tree, origin, direction)) ++hits;
  }
  return hits;
}

TEST_F(GpuSurfaceTest, RaysMeetTheTrianglesThatTheTreeFinds) {
  Random random(821);
  for (const DirtyShape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    const Mesh& mesh = shape.mesh;
    const std::vector<Triangle> triangles = triangulate(mesh);
    const GpuSurface surface(gpu(), triangles);
    GpuPoints points = gpu().upload(mesh.positions);
    SurfaceTree tree(triangles, mesh.positions);
    EXPECT_GE(expect_same_hits(random, surface, points, tree, mesh.positions), 20);
    const Box box = bounding_box(mesh.positions);
    gpu().advect(stirring(box), points, default_options(box.diagonal()));
    const std::vector<Vec3d> moved = downloaded(gpu(), points);
    EXPECT_GT(test::greatest_distance(moved, mesh.positions), 0.01 * box.diagonal());
    tree.refit(moved);
    EXPECT_GE(expect_same_hits(random, surface, points, tree, moved), 20);
  }
}

TEST_F(GpuSurfaceTest, RaysInBuffersOfAnySize) {
  Random random(822);
  const Mesh mesh = make_shape(ShapeKind::hand, 8000);
  GpuOptions options;
  options.most_points = (mesh.positions.size() / 4 / 64 + 1) * 64;
  Gpu other(options);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const GpuSurface surface(other, triangles);
  const GpuPoints points = other.upload(mesh.positions);
  EXPECT_EQ(Gpu::buffers(points).size(), 4U);
  EXPECT_GE(expect_same_hits(random, surface, points, SurfaceTree(triangles, mesh.positions), mesh.positions), 20);
}

TEST_F(GpuSurfaceTest, RaysSeeFromInsideAndFindNothingOutside) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 642);
  const GpuSurface surface(gpu(), triangulate(mesh));
  const GpuPoints points = gpu().upload(mesh.positions);
  const auto from_inside = surface.first_hit(points, {0.1, 0.2, 0.1}, {1, 2, 3});
  ASSERT_TRUE(from_inside);
  EXPECT_EQ(from_inside->leaves_at, from_inside->t);
  const auto through = surface.first_hit(points, {0.1, 0.2, 5}, {0, 0, -2});
  ASSERT_TRUE(through);
  EXPECT_NEAR(through->t, 2.0, 0.1);
  EXPECT_NEAR(through->leaves_at.value(), 3.0, 0.1);
  EXPECT_EQ(bits({through->corners.begin(), through->corners.end()}),
            bits({mesh.positions[mesh.face(through->triangle)[0]], mesh.positions[mesh.face(through->triangle)[1]],
                  mesh.positions[mesh.face(through->triangle)[2]]}));
  EXPECT_FALSE(surface.first_hit(points, {0, 0, 5}, {0, 0, 1}));
  EXPECT_FALSE(surface.first_hit(points, {0, 1.5, 5}, {0, 0, -1}));
}

// A thousand sheets of paper, of which two lie in one place: more than are read at once, and than there is room for.
TEST_F(GpuSurfaceTest, RaysThroughManyTriangles) {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const double height = i == 700 ? 999 : i;
    for (const Vec3d& corner : {Vec3d{0, 0, height}, Vec3d{1, 0, height}, Vec3d{0, 1, height}}) {
      positions.push_back(corner);
    }
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const GpuPoints points = gpu().upload(positions);
  for (const std::size_t sheets : {10U, 100U, 1000U}) {
    const std::span<const Triangle> some(triangles.data() + 1000 - sheets, sheets);
    const GpuSurface surface(gpu(), some);
    const auto hit = surface.first_hit(points, {0.2, 0.3, 2000}, {0, 0, -1});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle, sheets == 1000 ? 700U : sheets - 1);
    EXPECT_EQ(hit->t, 1001);
    EXPECT_FALSE(hit->leaves_at);
  }
}

TEST_F(GpuSurfaceTest, ReadsLittleAndSendsNothing) {
  const Mesh mesh = make_shape(ShapeKind::torus, 3000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const GpuPoints points = gpu().upload(mesh.positions);
  const std::uint64_t sent = gpu().transfers().bytes_sent;
  const GpuSurface surface(gpu(), triangles);
  const Transfers before = gpu().transfers();
  EXPECT_EQ(before.bytes_sent - sent, triangles.size() * 12);
  surface.volume(points, {});
  const Transfers between = gpu().transfers();
  EXPECT_EQ(between.read - before.read, 1U);
  EXPECT_EQ(between.bytes_read - before.bytes_read, 8U);
  ASSERT_TRUE(surface.first_hit(points, {5, 0.1, 0.2}, {-1, 0, 0}));
  const Transfers after = gpu().transfers();
  EXPECT_EQ(after.read - between.read, 1U);
  EXPECT_LE(after.bytes_read - between.bytes_read, 2048U);
  EXPECT_EQ(after.sent, before.sent);
}

TEST_F(GpuSurfaceTest, RefusesWhatItCannotDo) {
  const std::vector<Triangle> triangles{{0, 1, 300}};
  const GpuSurface surface(gpu(), triangles);
  const GpuPoints few = gpu().upload(std::vector<Vec3d>(300));
  EXPECT_THROW(surface.volume(few, {}), InvalidInput);
  EXPECT_THROW(surface.first_hit(few, {}, {0, 0, 1}), InvalidInput);
  GpuOptions options;
  options.most_points = 64;
  Gpu other(options);
  const GpuPoints in_ranges = other.upload(std::vector<Vec3d>(301));
  EXPECT_THROW(GpuSurface(other, triangles).volume(in_ranges, {}), GpuError);
  const GpuSurface nothing(gpu(), {});
  EXPECT_EQ(nothing.volume(few, {}), 0);
  EXPECT_FALSE(nothing.first_hit(few, {}, {0, 0, 1}));
}

TEST_F(GpuSurfaceTest, InTheContextThatIsCurrent) {
  Random random(823);
  const Mesh mesh = make_shape(ShapeKind::torus, 3000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const GpuSurface own(gpu(), triangles);
  const double volume = own.volume(gpu().upload(mesh.positions), {});
  const gl::OffscreenContext context(43);
  GpuOptions options;
  options.in_current_context = true;
  Gpu adopting(options);
  const GpuSurface surface(adopting, triangles);
  const GpuPoints points = adopting.upload(mesh.positions);
  EXPECT_EQ(surface.volume(points, {}), volume);
  EXPECT_GE(expect_same_hits(random, surface, points, SurfaceTree(triangles, mesh.positions), mesh.positions), 20);
}

}  // namespace
}  // namespace knead::gpu::gpu_surface_test
