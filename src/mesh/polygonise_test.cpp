// Polygonised surfaces are closed, manifold and in place, for smooth and rough functions.
#include "mesh/polygonise.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "knead/error.h"
#include "mesh/manifold_check.h"

namespace knead::polygonise_test {
namespace {

using test::closed_manifold_components;
using test::enclosed_volume;
using test::euler_characteristic;
using test::smallest_angle;

double ball(const Vec3d& p) { return norm(p) - 1; }

double thin_torus(const Vec3d& p) {
  const double q = std::sqrt(p.x * p.x + p.y * p.y) - 1;
  return std::sqrt(q * q + p.z * p.z) - 0.05;
}

Box cube(double half) { return {{-half, -half, -half}, {half, half, half}}; }

// The sum of plane waves of wave numbers up to `highest` along each axis.
ScalarFunction random_waves(std::uint32_t seed, double highest) {
  std::mt19937 generator(seed);
  const auto uniform = [&] { return 2 * static_cast<double>(generator()) / 4294967295.0 - 1; };
  std::vector<std::array<double, 4>> waves(10);
  for (auto& w : waves) w = {highest * uniform(), highest * uniform(), highest * uniform(), 3.2 * uniform()};
  return [waves](const Vec3d& p) {
    double sum = 0;
    for (const auto& w : waves) sum += std::sin(w[0] * p.x + w[1] * p.y + w[2] * p.z + w[3]);
    return sum;
  };
}

// Values between -1 and 1 without any relation between neighbouring points: every case of a cell in every
// neighbourhood.
ScalarFunction white_noise(std::uint64_t seed) {
  return [seed](const Vec3d& p) {
    std::uint64_t h = seed;
    for (std::size_t i = 0; i < 3; ++i) {
      h = (h ^ static_cast<std::uint64_t>(std::llround(p[i] * 1e6))) * 0x9e3779b97f4a7c15U;
      h ^= h >> 29;
    }
    return static_cast<double>(h >> 11) / 4503599627370496.0 - 1;
  };
}

TEST(Polygonise, SphereLiesOnTheSphere) {
  const Mesh mesh = polygonise(ball, cube(1.3), {0.05, 1});
  EXPECT_EQ(closed_manifold_components(mesh), 1);
  EXPECT_EQ(euler_characteristic(mesh), 2);
  for (const Vec3d& p : mesh.positions) EXPECT_NEAR(norm(p), 1, 1e-12);  // Newton steps converge quadratically
  EXPECT_GT(smallest_angle(mesh), 30);                                   // measured 34.1
}

TEST(Polygonise, SphereVolumeConvergesWithTheSquareOfTheCell) {
  double previous = 0;
  for (const double cell : {0.16, 0.08, 0.04}) {
    const Mesh mesh = polygonise(ball, cube(1.3), {cell, 1});
    const double error = 4 * std::numbers::pi / 3 - enclosed_volume(mesh);
    EXPECT_GT(error, 0);  // vertices on a convex surface: the mesh lies inside
    if (previous > 0) {
      EXPECT_NEAR(previous / error, 4, 0.5);
    }
    previous = error;
  }
}

TEST(Polygonise, ThinTorusKeepsItsHandle) {
  const Mesh mesh = polygonise(thin_torus, cube(1.2), {0.03, 1});  // the tube is 3.3 cells thick
  EXPECT_EQ(closed_manifold_components(mesh), 1);
  EXPECT_EQ(euler_characteristic(mesh), 0);
  EXPECT_GT(enclosed_volume(mesh), 0);
  EXPECT_GT(smallest_angle(mesh), 5);
}

TEST(Polygonise, SkippedBlocksChangeNoBit) {
  const Mesh all = polygonise(thin_torus, cube(1.2), {0.031, 0});
  const Mesh near = polygonise(thin_torus, cube(1.2), {0.031, 1});
  EXPECT_EQ(all.positions, near.positions);
  EXPECT_EQ(all.corner_vertex, near.corner_vertex);
}

TEST(Polygonise, LipschitzBoundSavesEvaluations) {
  std::size_t evaluations = 0;
  const ScalarFunction counted = [&](const Vec3d& p) {
    ++evaluations;
    return ball(p);
  };
  const Mesh mesh = polygonise(counted, cube(1.3), {0.02, 1, 0});
  // The grid has 131^3 = 2.2 million corners; the surface passes through about 47,000 cells.
  EXPECT_LT(evaluations, 6 * mesh.vertex_count());
}

TEST(Polygonise, ManifoldForRandomSmoothFunctions) {
  std::size_t vertices = 0;
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    PolygoniseOptions options;
    options.cell = 0.2;
    options.relaxations = static_cast<int>(seed % 3);
    const Mesh mesh = polygonise(random_waves(seed, 12), cube(1), options);
    ASSERT_GE(closed_manifold_components(mesh), 0) << "seed " << seed;
    vertices += mesh.vertex_count();
  }
  EXPECT_GT(vertices, 100000U);
}

TEST(Polygonise, ManifoldForWhiteNoise) {
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const Mesh mesh = polygonise(white_noise(seed), cube(1), {0.25, 0, static_cast<int>(seed % 2)});
    ASSERT_GE(closed_manifold_components(mesh), 1) << "seed " << seed;
    ASSERT_GT(enclosed_volume(polygonise(white_noise(seed), cube(1), {0.25, 0, 0})), 0) << "seed " << seed;
  }
}

TEST(Polygonise, TouchingBlobsStayManifold) {
  for (int i = 0; i < 60; ++i) {
    const Vec3d offset = Vec3d{0.31, 0.29, 0.33} * (1.0 + 0.004 * i);
    const ScalarFunction blobs = [&](const Vec3d& p) {
      return std::min(norm(p - offset) - 0.5, norm(p + offset) - 0.5);
    };
    const Mesh mesh = polygonise(blobs, cube(1.25), {0.1, 1});
    const int components = closed_manifold_components(mesh);
    ASSERT_TRUE(components == 1 || components == 2) << "step " << i;
    EXPECT_EQ(euler_characteristic(mesh), 2 * components) << "step " << i;
  }
}

TEST(Polygonise, SurfaceIsClosedAlongTheBox) {
  const ScalarFunction slab = [](const Vec3d& p) { return std::abs(p.z) - 0.4; };
  const Mesh mesh = polygonise(slab, cube(1), {0.1, 1});
  EXPECT_EQ(closed_manifold_components(mesh), 1);
  EXPECT_EQ(euler_characteristic(mesh), 2);
  EXPECT_NEAR(enclosed_volume(mesh), 3.2, 0.1);  // the edges are cut by up to half a cell
}

TEST(Polygonise, NothingInsideGivesNoFaces) {
  const Mesh mesh = polygonise([](const Vec3d&) { return 1.0; }, cube(1), {0.1, 0});
  EXPECT_EQ(mesh.vertex_count(), 0U);
  EXPECT_EQ(mesh.face_count(), 0U);
}

TEST(Polygonise, NotANumberIsOutside) {
  const ScalarFunction half = [](const Vec3d& p) {
    return p.x > 0 ? std::numeric_limits<double>::quiet_NaN() : norm(p) - 0.7;
  };
  const Mesh mesh = polygonise(half, cube(1), {0.1, 0});
  EXPECT_EQ(closed_manifold_components(mesh), 1);
  for (const Vec3d& p : mesh.positions) EXPECT_TRUE(is_finite(p));
}

TEST(Polygonise, RefusesOptionsOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(polygonise(ball, cube(1), {0, 1}), InvalidInput);
  EXPECT_THROW(polygonise(ball, cube(1), {nan, 1}), InvalidInput);
  EXPECT_THROW(polygonise(ball, cube(1), {0.1, -1}), InvalidInput);
  EXPECT_THROW(polygonise(ball, cube(1), {0.1, nan}), InvalidInput);
  EXPECT_THROW(polygonise(ball, cube(1), {0.1, 1, -1}), InvalidInput);
  EXPECT_THROW(polygonise(ball, cube(1), {0.1, 1, 101}), InvalidInput);
  EXPECT_THROW(polygonise(ball, cube(1), {1e-4, 1}), InvalidInput);
  EXPECT_THROW(polygonise(ball, Box{}, {0.1, 1}), InvalidInput);
  EXPECT_THROW(polygonise(ball, Box{{0, 0, 0}, {1, 1, 0}}, {0.1, 1}), InvalidInput);
}

TEST(Polygonise, NoticesAWrongLipschitzConstant) {
  const ScalarFunction steep = [](const Vec3d& p) { return 3 * ball(p); };
  EXPECT_THROW(polygonise(steep, cube(1.3), {0.05, 1}), InvalidInput);
  EXPECT_EQ(closed_manifold_components(polygonise(steep, cube(1.3), {0.05, 3})), 1);
}

}  // namespace
}  // namespace knead::polygonise_test
