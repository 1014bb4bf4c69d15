// Surfaces of tools, and their cache.
#include "knead/editor/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "knead/mesh.h"
#include "knead/region.h"

namespace knead::render::tool_surface_test {
namespace {

Field field_of(PointSet<double> set) {
  Field field;
  field.region = std::move(set);
  field.thresholds = {0.1, 0.3};
  return field;
}

// Straight, folded back on itself, short, and curves among points.
std::vector<Field> point_sets() {
  std::vector<Vec3d> spiral;
  for (int i = 0; i < 30; ++i) {
    spiral.push_back({0.6 * std::cos(0.4 * i), 0.6 * std::sin(0.4 * i), 0.03 * i});
  }
  std::vector<Field> fields;
  fields.push_back(field_of({.points = {{0, 0, 0}, {0.5, 0.1, 0}, {-0.3, 0.4, 0.2}}, .curves = {}}));
  fields.push_back(field_of({.points = {}, .curves = {spiral}}));
  fields.push_back(field_of({.points = {}, .curves = {{{-1, 0, 0}, {1, 0, 0}, {-1, 0.05, 0}, {1, 0.1, 0}}}}));
  fields.push_back(field_of({.points = {}, .curves = {{{0, 0, 0}, {0.01, 0, 0}}}}));
  fields.push_back(field_of({.points = {{0, 0, 1}}, .curves = {{{0, 0, 0}, {0.4, 0, 0}}, {{0, 1, 0}, {0, 0.2, 0}}}}));
  return fields;
}

double r_at(const Field& field, const Vec3d& p) {
  return evaluate(std::get<PointSet<double>>(field.region), p - field.center, 0.0).value;
}

// The volume of {r < level} by random points in a box twice as large as that of the surface.
double sampled_volume(const Field& field, double level, const Mesh& surface) {
  const Box box = bounding_box(surface.positions);
  const Vec3d size = box.max - box.min;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-0.13, 1.13);
  constexpr int count = 20000;
  int inside = 0;
  for (int i = 0; i < count; ++i) {
    const double x = number(random);
    const double y = number(random);
    const double z = number(random);
    inside += r_at(field, box.min + Vec3d{size.x * x, size.y * y, size.z * z}) < level ? 1 : 0;
  }
  return std::pow(1.26, 3) * size.x * size.y * size.z * inside / count;
}

TEST(ToolSurface, PointSetsAreTheirIsosurfaces) {
  for (Field field : point_sets()) {
    field.center = {3, -2, 1};
    for (const double level : {0.1, 0.3}) {
      const Mesh surface = region_surface(field, field.center, level, {}, {});
      ASSERT_GT(surface.face_count(), 100u);
      for (const Vec3d& p : surface.positions)
        ASSERT_NEAR(r_at(field, p), level, 0.02 * level);  // not smooth where curves bend
      // Nothing is missing: 20,000 samples know a twentieth of the box to about 3%.
      EXPECT_NEAR(measure(surface).volume / sampled_volume(field, level, surface), 1, 0.09);
    }
  }
}

TEST(ToolSurface, LiveSurfacesAreCoarserButTheSame) {
  for (const Field& field : point_sets()) {
    const Mesh fine = region_surface(field, field.center, 0.3, {}, {});
    const Mesh live = region_surface(field, field.center, 0.3, {}, {}, kLiveDetail);
    EXPECT_LT(live.vertex_count(), fine.vertex_count() / 4);
    for (const Vec3d& p : live.positions) ASSERT_NEAR(r_at(field, p), 0.3, 0.05);
    EXPECT_NEAR(measure(live).volume / measure(fine).volume, 1, 0.05);
  }
}

TEST(ToolSurface, ManyMarksAreFewVertices) {
  Handles<double> handles;
  for (int i = 0; i < 5000; ++i) handles.full.points.push_back({0.001 * i, 0, 0});
  Field field;
  field.region = handles;
  const Box around{{0, 0, 0}, {5, 1, 1}};
  const Mesh marks = region_surface(field, field.center, 0, around, {}, kLiveDetail);
  EXPECT_GT(marks.vertex_count(), 200u * 20);
  EXPECT_LT(marks.vertex_count(), 30000u);
}

TEST(SurfaceCache, FollowsWhatIsShiftedAndMakesTheRestAnew) {
  SurfaceCache cache;
  Field field = point_sets()[4];
  const Mesh first = cache.surface(field, 0.3, kLiveDetail);
  EXPECT_EQ(first.positions, region_surface(field, field.center, 0.3, {}, {}, kLiveDetail).positions);
  EXPECT_EQ(cache.made(), 1u);
  const Vec3d by_center{0.1, 0.2, -0.3};
  const Vec3d by_set{0.4, -0.5, 0.6};
  Field shifted = field;
  shifted.center += by_center;
  auto& set = std::get<PointSet<double>>(shifted.region);
  for (Vec3d& p : set.points) p += by_set;
  for (auto& curve : set.curves) {
    for (Vec3d& p : curve) p += by_set;
  }
  const Mesh second = cache.surface(shifted, 0.3, kLiveDetail);
  EXPECT_EQ(cache.made(), 1u);
  ASSERT_EQ(second.positions.size(), first.positions.size());
  for (std::size_t i = 0; i < first.positions.size(); ++i) {
    ASSERT_LT(norm(second.positions[i] - first.positions[i] - by_center - by_set), 1e-12);
  }
  cache.surface(field, 0.1, kLiveDetail);
  cache.surface(field, 0.3, {});
  set.curves[0].back().x += 0.01;
  cache.surface(shifted, 0.3, kLiveDetail);
  EXPECT_EQ(cache.made(), 4u);
  cache.surface(field, 0.3, kLiveDetail);
  EXPECT_EQ(cache.made(), 4u);
}

}  // namespace
}  // namespace knead::render::tool_surface_test
