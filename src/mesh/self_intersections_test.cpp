// Pairs of triangles that intersect, against a search through all pairs.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <random>

#include "knead/io.h"
#include "mesh/predicates.h"
#include "mesh/test_shapes.h"
#include "support/test_meshes.h"

namespace knead::self_intersections_test {
namespace {

using Pair = std::array<std::uint32_t, 2>;

SelfIntersections of(const Mesh& mesh, const SelfIntersectionOptions& options = {}) {
  return self_intersections(triangulate(mesh), mesh.positions, options);
}

// Finds the pairs without a tree.
std::vector<Pair> by_every_pair(const Mesh& mesh) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  const auto corners = [&](const Triangle& t) {
    return Corners{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
  };
  std::vector<Pair> pairs;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (are_collinear(corners(triangles[i]))) {
      pairs.push_back({i, i});
      continue;
    }
    for (std::uint32_t j = i + 1; j < triangles.size(); ++j) {
      if (are_collinear(corners(triangles[j]))) continue;
      if (meet_beyond_shared(triangles[i], corners(triangles[i]), triangles[j], corners(triangles[j]))) {
        pairs.push_back({i, j});
      }
    }
  }
  return pairs;
}

TEST(SelfIntersections, AreThoseCountedByHand) {
  for (const DirtyShape& shape : dirty_shapes()) {
    if (!shape.pairs) continue;
    EXPECT_EQ(of(shape.mesh).count, *shape.pairs) << shape.name;
  }
}

TEST(SelfIntersections, OfMadeShapesAreNone) {
  for (const std::string_view name : shape_names()) {
    const ShapeKind kind = shape_kind(std::string(name));
    EXPECT_EQ(of(make_shape(kind, std::max<std::size_t>(3000, shape_counts(kind).minimum))).count, 0u) << name;
  }
}

TEST(SelfIntersections, FindWhatTheTestOfEveryPairFinds) {
  std::vector<DirtyShape> shapes = dirty_shapes();
  shapes.push_back({"tori", join(quad_torus(24, 12), quad_torus(20, 14), {0.7, 0.3, 0.1}), {}});
  for (const DirtyShape& shape : shapes) {
    if (shape.name == "a corner just above a triangle") continue;  // beyond the range of predicates.h
    EXPECT_EQ(of(shape.mesh).pairs, by_every_pair(shape.mesh)) << shape.name;
  }
  EXPECT_GT(of(shapes.back().mesh).count, 100u);
}

// Fans around vertex 0: flat, folded, without area, and those that go round twice.
TEST(SelfIntersections, OfFansAreFound) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> coordinate(-3, 3);
  std::size_t crossed = 0;
  std::size_t sound = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::uint32_t count = 3 + static_cast<std::uint32_t>(i % 7);
    const double turn = (i % 3 == 0 ? 4 : 2) * std::numbers::pi / count;
    Mesh mesh;
    mesh.positions.push_back({0.1, 0.2, 0});
    for (std::uint32_t k = 0; k < count; ++k) {
      const double z = 0.3 * coordinate(random);
      mesh.positions.push_back(i % 2 == 0 ? Vec3d{3 * std::cos(turn * k), 3 * std::sin(turn * k), z}
                                          : Vec3d{1.0 * coordinate(random), 1.0 * coordinate(random), z});
      mesh.add_face(std::array{0U, k + 1, (k + 1) % count + 1});
    }
    const std::vector<Pair> expected = by_every_pair(mesh);
    EXPECT_EQ(of(mesh).pairs, expected) << i;
    ++(expected.empty() ? sound : crossed);
  }
  EXPECT_GT(crossed, 500U);
  EXPECT_GT(sound, 500U);
}

TEST(SelfIntersections, AreTheSameForEveryNumberOfThreadsAndEveryOrder) {
  const Mesh mesh = pushed_through();
  std::vector<Triangle> triangles = triangulate(mesh);
  const SelfIntersections one = self_intersections(triangles, mesh.positions, {.threads = 1});
  EXPECT_GT(one.count, 20u);
  EXPECT_EQ(one.pairs, self_intersections(triangles, mesh.positions, {.threads = 4}).pairs);
  std::mt19937 random(1);
  std::shuffle(triangles.begin(), triangles.end(), random);
  for (Triangle& t : triangles) std::rotate(t.begin(), t.begin() + t[0] % 3, t.end());
  EXPECT_EQ(one.count, self_intersections(triangles, mesh.positions).count);
}

// Chosen at random: one in three, hardly any, all.
TEST(SelfIntersections, OfChosenTrianglesAreThePairsWithOneOfThem) {
  std::vector<DirtyShape> shapes = dirty_shapes();
  shapes.push_back({"tori", join(quad_torus(24, 12), quad_torus(20, 14), {0.7, 0.3, 0.1}), {}});
  std::mt19937 random(3);
  for (const DirtyShape& shape : shapes) {
    const std::vector<Pair> all = of(shape.mesh).pairs;
    for (const double share : {0.0, 0.02, 0.3, 1.0}) {
      std::vector<bool> chosen(triangulate(shape.mesh).size());
      std::generate(chosen.begin(), chosen.end(), [&] { return std::bernoulli_distribution(share)(random); });
      std::vector<Pair> expected;
      std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
                   [&](const Pair& pair) { return chosen[pair[0]] || chosen[pair[1]]; });
      for (const int threads : {1, 4}) {
        SelfIntersectionOptions options;
        options.threads = threads;
        options.chosen = &chosen;
        EXPECT_EQ(of(shape.mesh, options).pairs, expected) << shape.name << ", " << share;
      }
    }
  }
}

TEST(SelfIntersections, DoNotDependOnTheUnitOfLength) {
  Mesh mesh = pushed_through();
  const std::vector<Pair> pairs = of(mesh).pairs;
  const std::vector<Vec3d> positions = mesh.positions;
  // Powers of two, so that the positions are exact multiples; the last comes near to the largest double.
  for (const int exponent : {-800, -60, 3, 300, 1020}) {
    for (std::size_t v = 0; v < positions.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k) mesh.positions[v][k] = std::scalbn(positions[v][k], exponent);
    }
    EXPECT_EQ(of(mesh).pairs, pairs) << "2 to the " << exponent;
  }
}

TEST(SelfIntersections, EndAtTheLimit) {
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {});
  for (int i = 0; i < 200; ++i) mesh.add_face(std::array{0u, 1u, 2u});
  const std::size_t all = 200 * 199 / 2;
  const SelfIntersections complete = of(mesh, {.limit = all});
  EXPECT_TRUE(complete.complete);
  EXPECT_EQ(complete.count, all);
  EXPECT_EQ(complete.pairs, by_every_pair(mesh));
  const SelfIntersections cut = of(mesh, {.limit = all - 1});
  EXPECT_FALSE(cut.complete);
  EXPECT_EQ(cut.count, all - 1);
  EXPECT_TRUE(cut.pairs.empty());
}

TEST(SelfIntersections, OfManyEqualTrianglesEndSoon) {
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {});
  for (int i = 0; i < 100000; ++i) mesh.add_face(std::array{0u, 1u, 2u});
  EXPECT_FALSE(of(mesh, {.limit = 100000}).complete);  // of 5e9
}

TEST(SelfIntersections, OfNothingAreNone) {
  EXPECT_EQ(of({}).count, 0u);
  EXPECT_EQ(of(make_mesh({{0, 0, 0}, {1, 1, 1}}, {})).count, 0u);
}

TEST(SelfIntersections, AreCancelled) {
  Progress progress;
  progress.cancel = true;
  SelfIntersectionOptions options;
  options.progress = &progress;
  EXPECT_THROW(of(make_shape(ShapeKind::sphere, 642), options), Cancelled);
}

}  // namespace
}  // namespace knead::self_intersections_test
