// Answers of SurfaceTree equal those of a search through all triangles.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "math/geometry.h"
#include "mesh/box_tree.h"
#include "mesh/test_shapes.h"

namespace knead::surface_tree_test {
namespace {

struct Soup {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;

  std::array<Vec3d, 3> corners(std::size_t t) const {
    return {positions[triangles[t][0]], positions[triangles[t][1]], positions[triangles[t][2]]};
  }
};

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3d point(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  std::uint32_t below(std::size_t n) {
    return static_cast<std::uint32_t>(std::uniform_int_distribution<std::size_t>(0, n - 1)(random_));
  }

 private:
  std::mt19937 random_;
};

Soup soup_of(const Mesh& mesh) { return {mesh.positions, triangulate(mesh)}; }

// Small and long triangles, needles, points, and some twice.
Soup random_soup(unsigned seed) {
  Dice dice(seed);
  Soup soup;
  for (int i = 0; i < 300; ++i) soup.positions.push_back(dice.point(1));
  for (int i = 0; i < 200; ++i) soup.positions.push_back(soup.positions[dice.below(300)] + dice.point(0.02));
  for (int i = 0; i < 400; ++i) {
    soup.triangles.push_back({dice.below(500), dice.below(500), dice.below(500)});
    const std::uint32_t v = 300 + dice.below(198);
    soup.triangles.push_back({v, v + 1, v + 2});
    soup.triangles.push_back({v, v + (i % 2), v});
  }
  for (int i = 0; i < 50; ++i) soup.triangles.push_back(soup.triangles[dice.below(soup.triangles.size())]);
  return soup;
}

std::vector<SurfacePoint> nearest_of_all(const Soup& soup, const Vec3d& p, std::size_t count) {
  std::vector<SurfacePoint> all;
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    const NearTriangle near = nearest_on_triangle(soup.corners(t), p);
    all.push_back({t, near.barycentric, near.point, std::sqrt(near.distance2)});
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.distance < b.distance; });
  all.resize(std::min(count, all.size()));
  return all;
}

std::vector<RayHit> hits_of_all(const Soup& soup, const Vec3d& origin, const Vec3d& direction) {
  const TriangleRay ray(origin, direction);
  std::vector<RayHit> all;
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    const auto meeting = ray.meet(soup.corners(t));
    if (meeting && meeting->t >= 0) all.push_back({t, meeting->t, meeting->leaves});
  }
  std::stable_sort(all.begin(), all.end(), [](const RayHit& a, const RayHit& b) { return a.t < b.t; });
  return all;
}

void expect_same(const std::optional<SurfacePoint>& a, const SurfacePoint& b) {
  ASSERT_TRUE(a);
  EXPECT_EQ(a->triangle, b.triangle);
  EXPECT_EQ(a->barycentric, b.barycentric);
  EXPECT_EQ(a->point, b.point);
  EXPECT_EQ(a->distance, b.distance);
}

void expect_answers_of_all(const SurfaceTree& tree, const Soup& soup, unsigned seed) {
  Dice dice(seed);
  for (int i = 0; i < 60; ++i) {
    const Vec3d p = i % 3 == 0 ? soup.positions[dice.below(soup.positions.size())] : dice.point(i % 3 == 1 ? 1 : 30);
    const std::vector<SurfacePoint> nearest = nearest_of_all(soup, p, 8);
    expect_same(tree.closest(p), nearest[0]);
    const std::vector<SurfacePoint> found = tree.nearest(p, 8);
    ASSERT_EQ(found.size(), nearest.size());
    for (std::size_t k = 0; k < found.size(); ++k) expect_same(found[k], nearest[k]);

    const Vec3d direction = i % 2 == 0 ? dice.point(1) : soup.positions[dice.below(soup.positions.size())] - p;
    if (direction == Vec3d{0, 0, 0}) continue;
    const std::vector<RayHit> all = hits_of_all(soup, p, direction);
    const std::vector<RayHit> hits = tree.hits(p, direction);
    ASSERT_EQ(hits.size(), all.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_EQ(hits[k].triangle, all[k].triangle);
      EXPECT_EQ(hits[k].t, all[k].t);
      EXPECT_EQ(hits[k].leaves, all[k].leaves);
    }
    const auto first = tree.first_hit(p, direction);
    ASSERT_EQ(first.has_value(), !all.empty());
    if (first) {
      EXPECT_EQ(first->triangle, all[0].triangle);
    }
  }
}

TEST(SurfaceTree, AnswersAsASearchThroughEveryTriangle) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Soup soup = random_soup(seed);
    expect_answers_of_all(SurfaceTree(soup.triangles, soup.positions), soup, seed);
  }
  const Soup hand = soup_of(make_shape(ShapeKind::hand, 4000));
  expect_answers_of_all(SurfaceTree(hand.triangles, hand.positions), hand, 4);
}

// Whatever the guesses; points on the surface, near it, and far from it.
TEST(NearestPoints, AreThoseOfTheTree) {
  for (const bool is_hand : {true, false}) {
    const Soup soup = is_hand ? soup_of(make_shape(ShapeKind::hand, 4000)) : random_soup(5);
    const SurfaceTree tree(soup.triangles, soup.positions);
    Dice dice(6);
    std::vector<Vec3d> points;
    std::vector<std::uint32_t> guesses;
    std::vector<Vec3d> expected;
    for (int i = 0; i < 3000; ++i) {
      const std::uint32_t t = dice.below(soup.triangles.size());
      const Vec3d corner = soup.corners(t)[dice.below(3)];
      points.push_back(i % 5 == 0 ? dice.point(20) : corner + dice.point(i % 3 == 0 ? 0 : 0.01));
      guesses.push_back(i % 7 == 0 ? dice.below(soup.triangles.size()) : t);
      expected.push_back(tree.closest(points.back())->point);
    }
    for (const int threads : {1, 2}) {
      const std::vector<Vec3d> found =
          nearest_points(soup.triangles, soup.positions, points, guesses, threads, nullptr);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], expected[i]) << i;
    }
  }
}

TEST(SurfaceTree, AnswersTheSameAfterRefit) {
  Soup soup = random_soup(5);
  SurfaceTree tree(soup.triangles, soup.positions);
  Dice dice(6);
  for (Vec3d& p : soup.positions) p += dice.point(0.3);
  tree.refit(soup.positions);
  expect_answers_of_all(tree, soup, 7);
}

TEST(SurfaceTree, AnswersTheSameAfterARefitOfWhatMoved) {
  Soup soup = soup_of(make_shape(ShapeKind::hand, 4000));
  SurfaceTree tree(soup.triangles, soup.positions);
  Dice dice(15);
  for (unsigned round = 0; round < 8; ++round) {
    const Vec3d center = soup.positions[(round * 977) % soup.positions.size()];
    const double reach = 0.05 + 0.05 * round;
    Box moved;
    for (Vec3d& p : soup.positions) {
      if (norm(p - center) > reach) continue;
      moved.extend(p);
      p += dice.point(0.3);  // also out of the box
    }
    tree.refit(soup.positions, moved);
    expect_answers_of_all(tree, soup, 16 + round);
  }
}

TEST(SurfaceTree, ReadsNothingFarFromWhatMoved) {
  Soup soup = soup_of(make_shape(ShapeKind::hand, 4000));
  const SurfaceTree whole(soup.triangles, soup.positions);
  SurfaceTree tree = whole;
  const Vec3d center = soup.positions[0];
  const Vec3d corner{0.01, 0.01, 0.01};
  std::vector<Vec3d> unreadable = soup.positions;
  for (Vec3d& p : unreadable) {
    if (norm(p - center) > 0.4) p = {std::nan(""), std::nan(""), std::nan("")};
  }
  tree.refit(unreadable, {center - corner, center + corner});
  for (int i = 0; i < 100; ++i) {
    const Vec3d p = soup.positions[static_cast<std::size_t>(i) * 37];
    expect_same(tree.closest(p), *whole.closest(p));
  }
}

TEST(SurfaceTree, AnswersFarFromTheOrigin) {
  Soup soup = soup_of(make_shape(ShapeKind::sphere, 642));
  const Vec3d far{1e6, -3e5, 2e6};
  for (Vec3d& p : soup.positions) p += far;
  const SurfaceTree tree(soup.triangles, soup.positions);
  Dice dice(8);
  for (int i = 0; i < 50; ++i) {
    const Vec3d p = far + dice.point(2);
    expect_same(tree.closest(p), nearest_of_all(soup, p, 1)[0]);
    EXPECT_EQ(tree.hits(p, far - p).size(), hits_of_all(soup, p, far - p).size());
  }
}

// A point of the surface, given by barycentric coordinates; no other is nearer than along the normal.
TEST(SurfaceTree, FindsTheNearestPointOfASphere) {
  const Soup sphere = soup_of(make_shape(ShapeKind::sphere, 16000));
  const SurfaceTree tree(sphere.triangles, sphere.positions);
  Dice dice(9);
  for (int i = 0; i < 200; ++i) {
    const Vec3d p = dice.point(2);
    const SurfacePoint found = tree.closest(p).value();
    const auto corners = sphere.corners(found.triangle);
    const auto& b = found.barycentric;
    // The corners lie on the sphere and the triangles' middles up to (edge^2)/6 = 1e-4 below it.
    EXPECT_NEAR(found.distance, std::abs(norm(p) - 1), 2e-4);
    EXPECT_LT(norm(corners[0] * b[0] + corners[1] * b[1] + corners[2] * b[2] - found.point), 1e-14);
    EXPECT_NEAR(b[0] + b[1] + b[2], 1, 1e-14);
    EXPECT_GE(std::min({b[0], b[1], b[2]}), 0);
  }
}

TEST(SurfaceTree, GivesTheLowestNumberOfEquals) {
  const Mesh cube = unit_cube();
  const Soup soup = soup_of(cube);
  const SurfaceTree tree(soup.triangles, soup.positions);
  EXPECT_EQ(tree.closest({0.5, 0.5, 0.5})->triangle, 0u);
  EXPECT_EQ(tree.closest({0.5, 0.5, 0.5})->distance, 0.5);
  EXPECT_EQ(tree.closest({2, 2, 2})->point, Vec3d(1, 1, 1));
  const auto nearest = tree.nearest({0.5, 0.5, 0.5}, 12);
  ASSERT_EQ(nearest.size(), 12u);
  for (std::uint32_t i = 0; i < 12; ++i) EXPECT_EQ(nearest[i].triangle, i);
}

TEST(SurfaceTree, StopsAtTheGivenDistance) {
  const Soup soup = soup_of(unit_cube());
  const SurfaceTree tree(soup.triangles, soup.positions);
  EXPECT_TRUE(tree.closest({0.5, 0.5, 1.25}, 0.25));
  EXPECT_FALSE(tree.closest({0.5, 0.5, 1.25}, 0.2499));
  EXPECT_TRUE(tree.nearest({0.5, 0.5, 1.25}, 3, 0.2499).empty());
  EXPECT_TRUE(tree.nearest({0.5, 0.5, 1.25}, 0).empty());
  EXPECT_TRUE(tree.first_hit({0.5, 0.3, 2}, {0, 0, -2}, 0.5));
  EXPECT_FALSE(tree.first_hit({0.5, 0.3, 2}, {0, 0, -2}, 0.4999));
}

// Rays along edges, along diagonals and through corners: the cases that depend on rounding.
TEST(SurfaceTree, EntersAsOftenAsItLeaves) {
  for (const Mesh& mesh : {unit_cube(), quad_torus(8, 8), make_shape(ShapeKind::sphere, 42)}) {
    const Soup soup = soup_of(mesh);
    const SurfaceTree tree(soup.triangles, soup.positions);
    Dice dice(10);
    for (int i = 0; i < 400; ++i) {
      const Vec3d through = soup.positions[dice.below(soup.positions.size())];
      const Vec3d to = i % 2 == 0 ? soup.positions[dice.below(soup.positions.size())] : dice.point(1);
      if (to == through) continue;
      const Vec3d direction = i % 4 == 3 ? Vec3d{0, 0, 1} : to - through;
      const auto hits = tree.hits(through - direction * 16.0, direction);
      const auto leaving = std::count_if(hits.begin(), hits.end(), [](const RayHit& hit) { return hit.leaves; });
      EXPECT_EQ(2 * static_cast<std::size_t>(leaving), hits.size());
    }
  }
}

TEST(SurfaceTree, KnowsWhichWayARayCrosses) {
  const Soup soup = soup_of(unit_cube());
  const SurfaceTree tree(soup.triangles, soup.positions);
  const auto out = tree.first_hit({0.5, 0.5, 0.25}, {0, 0, 0.5});
  ASSERT_TRUE(out);
  EXPECT_TRUE(out->leaves);
  EXPECT_EQ(out->t, 1.5);
  const auto hits = tree.hits({0.5, 0.5, 3}, {0, 0, -1});
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_FALSE(hits[0].leaves);
  EXPECT_TRUE(hits[1].leaves);
  EXPECT_EQ(hits[0].t, 2);
  EXPECT_EQ(hits[1].t, 3);
}

TEST(SurfaceTree, SearchesPoints) {
  Dice dice(11);
  Soup cloud;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    cloud.positions.push_back(dice.point(1));
    cloud.triangles.push_back({i, i, i});
  }
  const SurfaceTree tree(cloud.triangles, cloud.positions);
  for (int i = 0; i < 50; ++i) {
    const Vec3d p = dice.point(1.5);
    std::vector<std::uint32_t> order(cloud.positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return norm(cloud.positions[a] - p) < norm(cloud.positions[b] - p);
    });
    const auto found = tree.nearest(p, 8);
    ASSERT_EQ(found.size(), 8u);
    for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(found[k].triangle, order[k]);
    EXPECT_EQ(tree.closest(p)->point, cloud.positions[order[0]]);
    EXPECT_TRUE(tree.hits(p, dice.point(1)).empty());
  }
}

TEST(SurfaceTree, MayBeEmptyOrHoldOneTriangle) {
  const SurfaceTree none({}, {});
  EXPECT_FALSE(none.closest({0, 0, 0}));
  EXPECT_TRUE(none.nearest({0, 0, 0}, 4).empty());
  EXPECT_FALSE(none.first_hit({0, 0, 0}, {0, 0, 1}));
  EXPECT_TRUE(none.hits({0, 0, 0}, {0, 0, 1}).empty());
  const std::vector<Vec3d> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const SurfaceTree one(std::vector<Triangle>{{0, 1, 2}}, corners);
  EXPECT_EQ(one.closest({-1, -1, 0})->point, corners[0]);
  EXPECT_EQ(one.nearest({0, 0, 1}, 4).size(), 1u);
  EXPECT_EQ(one.hits({0.25, 0.25, -1}, {0, 0, 1}).size(), 1u);
}

}  // namespace
}  // namespace knead::surface_tree_test
