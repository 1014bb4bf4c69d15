// The limb of a surface at a vertex: its vertices, its neck, and the body.
#include "knead/editor/tools.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <random>
#include <stdexcept>

#include "knead/mesh.h"
#include "mesh/polygonise.h"
#include "support/surface.h"

namespace knead::limb_test {
namespace {

using test::Surface;

std::uint32_t nearest_to(const Vec3d& p, const Surface& surface) {
  const auto nearer = [&](const Vec3d& a, const Vec3d& b) { return norm2(a - p) < norm2(b - p); };
  return static_cast<std::uint32_t>(std::min_element(surface.positions.begin(), surface.positions.end(), nearer) -
                                    surface.positions.begin());
}

TEST(FindLimb, FindsEachFingerFromItsKnuckle) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  for (const Finger& finger : hand_fingers()) {
    for (const double at : {0.5, 0.8}) {
      const Limb limb =
          find_limb(hand.positions, hand.triangles, nearest_to(finger.base + finger.axis * (at * finger.length), hand));
      EXPECT_TRUE(limb.has_neck) << finger.name;
      EXPECT_GT(dot(limb.direction, finger.axis), 0.85) << finger.name;
      const double along = dot(limb.joint - finger.base, finger.axis);
      EXPECT_LT(std::abs(along), 0.35 * finger.length) << finger.name;
      EXPECT_LT(norm(limb.joint - finger.base - finger.axis * along), 0.6 * finger.radius) << "inside it";
      // Most of the finger beyond the joint, the rest of which bends, and nothing of the others.
      std::size_t beyond = 0;
      for (std::uint32_t v = 0; v < hand.positions.size(); ++v) {
        const Vec3d& p = hand.positions[v];
        const double s = dot(p - finger.base, finger.axis);
        const bool is_finger =
            s > std::max(along, 0.0) + 0.1 * finger.length && norm(p - finger.base - finger.axis * s) < finger.radius;
        beyond += is_finger ? 1 : 0;
        EXPECT_FALSE(is_finger && std::binary_search(limb.body.begin(), limb.body.end(), v)) << finger.name;
      }
      EXPECT_GT(static_cast<double>(limb.vertices.size()), 0.7 * static_cast<double>(beyond)) << finger.name;
      for (const std::uint32_t v : limb.vertices) {
        const double s = dot(hand.positions[v] - finger.base, finger.axis);
        EXPECT_LT(norm(hand.positions[v] - finger.base - finger.axis * s), finger.radius + 0.05) << finger.name;
      }
    }
  }
}

TEST(FindLimb, LimbAndBodyShareNothingAndTheBodyHasTheWrist) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  const Finger& finger = hand_fingers()[2];
  const Limb limb =
      find_limb(hand.positions, hand.triangles, nearest_to(finger.base + finger.axis * (0.6 * finger.length), hand));
  std::vector<std::uint32_t> both;
  std::set_intersection(limb.vertices.begin(), limb.vertices.end(), limb.body.begin(), limb.body.end(),
                        std::back_inserter(both));
  EXPECT_TRUE(both.empty());
  for (std::uint32_t v = 0; v < hand.positions.size(); ++v) {
    if (hand.positions[v].y > -0.6) continue;
    EXPECT_TRUE(std::binary_search(limb.body.begin(), limb.body.end(), v));
  }
  for (const std::uint32_t v : limb.body) {
    EXPECT_GT(norm(hand.positions[v] - limb.joint), 0.5 * limb.girth / std::numbers::pi);
  }
}

// Three rods on a ball: two side by side, and one apart.
double fork(const Vec3d& p) {
  const auto rod = [&](const Vec3d& foot, const Vec3d& tip) {
    const Vec3d along = tip - foot;
    const double t = std::clamp(dot(p - foot, along) / norm2(along), 0.0, 1.0);
    return norm(p - foot - along * t) - 0.2;
  };
  const double ball = norm(p) - 1;
  return std::min({ball, rod({0.25, 0, 0.7}, {0.25, 0, 2.5}), rod({-0.25, 0, 0.7}, {-0.25, 0, 2.5}),
                   rod({0, 0, -0.7}, {0, 0, -2.5})});
}

TEST(FindLimb, WhatRunsBesideALimbHoldsButForItsFoot) {
  const Surface shape(polygonise(fork, {{-1.5, -1.5, -3}, {1.5, 1.5, 3}}, {.cell = 0.07}));
  const Limb limb = find_limb(shape.positions, shape.triangles, nearest_to({0.45, 0, 2}, shape));
  ASSERT_TRUE(limb.has_neck);
  for (std::uint32_t v = 0; v < shape.positions.size(); ++v) {
    const Vec3d& p = shape.positions[v];
    const auto is_in = [&](const std::vector<std::uint32_t>& list) {
      return std::binary_search(list.begin(), list.end(), v);
    };
    EXPECT_EQ(is_in(limb.vertices) + is_in(limb.bending) + is_in(limb.body), 1) << p.x << p.z;
    EXPECT_TRUE(is_in(limb.vertices) || p.z < 1.6 || p.x < 0);
    EXPECT_TRUE(is_in(limb.body) || p.z < 1.6 || p.x > 0);
    EXPECT_TRUE(is_in(limb.body) || p.z > -0.3);
  }
  EXPECT_EQ(limb.bending, bending_about(shape.positions, shape.triangles, limb.vertices));
  EXPECT_TRUE(bending_about(shape.positions, shape.triangles, {}).empty());
  // A vertex that no triangle uses does not make the shape larger.
  std::vector<Vec3d> more = shape.positions;
  more.push_back({0, 0, 1e6});
  EXPECT_EQ(find_limb(more, shape.triangles, nearest_to({0.45, 0, 2}, shape)).body, limb.body);
}

TEST(FindLimb, WithoutANeckItBeginsAtTheGivenVertex) {
  const Surface cylinder(make_shape(ShapeKind::cylinder, 4000));
  for (const double z : {1.5, -2.0}) {
    const Limb limb = find_limb(cylinder.positions, cylinder.triangles, nearest_to({0.5, 0, z}, cylinder));
    EXPECT_FALSE(limb.has_neck);
    EXPECT_NEAR(limb.joint.z, z, 0.6);
    EXPECT_LT(std::hypot(limb.joint.x, limb.joint.y), 0.15);
    EXPECT_GT(limb.direction.z * (z > 0 ? 1 : -1), 0.7);
    EXPECT_NEAR(limb.girth, std::numbers::pi, 0.35 * std::numbers::pi);
    for (const std::uint32_t v : limb.vertices) EXPECT_GT(std::abs(cylinder.positions[v].z), std::abs(z) - 0.2);
    EXPECT_FALSE(limb.body.empty());
  }
}

TEST(FindLimb, IsTheSameForVerticesInAnotherOrder) {
  const Surface hand(make_shape(ShapeKind::hand, 4000));
  std::vector<std::uint32_t> order(hand.positions.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  Surface mixed = hand;
  for (std::uint32_t v = 0; v < order.size(); ++v) mixed.positions[order[v]] = hand.positions[v];
  for (Triangle& t : mixed.triangles) {
    for (std::uint32_t& v : t) v = order[v];
  }
  const Finger& finger = hand_fingers()[1];
  const std::uint32_t vertex = nearest_to(finger.base + finger.axis * (0.6 * finger.length), hand);
  const Limb first = find_limb(hand.positions, hand.triangles, vertex);
  const Limb second = find_limb(mixed.positions, mixed.triangles, order[vertex]);
  EXPECT_LT(norm(first.joint - second.joint), 1e-12);
  std::vector<std::uint32_t> expected;
  for (const std::uint32_t v : first.vertices) expected.push_back(order[v]);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(expected, second.vertices);
}

TEST(FindLimb, ALoneVertexHasNone) {
  std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  const std::vector<Triangle> triangles{{0, 1, 2}};
  EXPECT_TRUE(find_limb(positions, triangles, 3).vertices.empty());
  EXPECT_THROW(find_limb(positions, triangles, 4), std::out_of_range);
}

}  // namespace
}  // namespace knead::limb_test
