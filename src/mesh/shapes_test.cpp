// Procedural shapes are closed, manifold and of the promised size.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "knead/error.h"
#include "knead/vec.h"
#include "mesh/manifold_check.h"

namespace knead::shapes_test {
namespace {

using test::closed_manifold_components;
using test::enclosed_volume;
using test::euler_characteristic;
using test::smallest_angle;

constexpr double kPi = std::numbers::pi;

class EveryShape : public testing::TestWithParam<std::string_view> {};

TEST_P(EveryShape, IsAClosedManifoldOfAboutTheWishedSize) {
  const ShapeKind kind = shape_kind(GetParam());
  const std::int64_t euler = kind == ShapeKind::torus || kind == ShapeKind::knot ? 0 : 2;
  const ShapeCounts counts = shape_counts(kind);
  for (const std::size_t wish : {counts.minimum, counts.minimum * 5 / 4, std::size_t{1000}, std::size_t{2777},
                                 std::size_t{12345}, counts.standard, std::size_t{60000}}) {
    if (wish < counts.minimum) continue;
    SCOPED_TRACE(wish);
    const Mesh mesh = make_shape(kind, wish);
    EXPECT_EQ(closed_manifold_components(mesh), 1);
    EXPECT_EQ(euler_characteristic(mesh), euler);
    EXPECT_GT(enclosed_volume(mesh), 0);
    EXPECT_GT(smallest_angle(mesh), 15);  // measured: hand 17, crater 22, letter-y 23, the others above 30
    if (kind == ShapeKind::sphere && wish < 1000) continue;
    EXPECT_NEAR(static_cast<double>(mesh.vertex_count()), static_cast<double>(wish), 0.1 * static_cast<double>(wish));
  }
}

TEST_P(EveryShape, IsTheSameEachTime) {
  const ShapeKind kind = shape_kind(GetParam());
  const Mesh a = make_shape(kind, 5000);
  const Mesh b = make_shape(kind, 5000);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.corner_vertex, b.corner_vertex);
}

TEST_P(EveryShape, RefusesCountsOutOfRange) {
  const ShapeKind kind = shape_kind(GetParam());
  EXPECT_THROW(make_shape(kind, shape_counts(kind).minimum - 1), InvalidInput);
  EXPECT_THROW(make_shape(kind, shape_counts(kind).maximum + 1), InvalidInput);
}

TEST_P(EveryShape, MeetsTheDocumentedExtent) {
  const ShapeKind kind = shape_kind(GetParam());
  constexpr double kKnot = 3.45;
  const Box documented[] = {{{-1, -1, -1}, {1, 1, 1}},
                            {{-3, -0.5, -0.5}, {3, 0.5, 0.5}},
                            {{-0.5, -0.5, -3}, {0.5, 0.5, 3}},
                            {{-1.3, -1.3, -0.3}, {1.3, 1.3, 0.3}},
                            {{-0.5, -0.95, -0.2}, {0.75, 0.95, 0.3}},
                            {{-5, -5, -1.5}, {5, 5, 0.5}},
                            {{-kKnot, -kKnot, -1.45}, {kKnot, kKnot, 1.45}},
                            {{-0.4, -0.4, -0.1}, {0.4, 0.4, 0.1}},
                            {{-0.93, -1, -0.2}, {0.93, 1, 0.25}}};
  const Box outer = documented[static_cast<std::size_t>(kind)];
  const Box box = bounding_box(make_shape(kind).positions);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(box.min[i], outer.min[i] - 1e-9);
    EXPECT_LE(box.max[i], outer.max[i] + 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryShape, testing::ValuesIn(shape_names().begin(), shape_names().end()),
                         [](const auto& shape) {
                           std::string name(shape.param);
                           std::erase(name, '-');
                           return name;
                         });

TEST(Shapes, NamesGiveKinds) {
  EXPECT_EQ(shape_names().size(), 9U);
  EXPECT_EQ(shape_kind("letter-y"), ShapeKind::letter_y);
  EXPECT_EQ(shape_kind("hand"), ShapeKind::hand);
  EXPECT_THROW(shape_kind("teapot"), InvalidInput);
}

TEST(Shapes, SmallSpheresAreTheNearestOnes) {
  EXPECT_EQ(make_shape(ShapeKind::sphere, 12).vertex_count(), 12U);
  EXPECT_EQ(make_shape(ShapeKind::sphere, 40).vertex_count(), 42U);
  EXPECT_EQ(make_shape(ShapeKind::sphere, 999).vertex_count(), 1002U);
}

TEST(Shapes, BarIsExact) { EXPECT_NEAR(enclosed_volume(make_shape(ShapeKind::box, 5000)), 6, 1e-12); }

struct Round {
  ShapeKind kind;
  double volume;
};

// Chords of a curved surface: the volume's relative error is about c h^2, h^2 ~ 1 / vertices. With c from the measured
// error at 4000 vertices (0.0014 sphere, 0.0038 cylinder, 0.0061 torus) within 0.01; four times as many: a quarter.
TEST(Shapes, RoundVolumesConvergeAtSecondOrder) {
  for (const Round& round : {Round{ShapeKind::sphere, 4 * kPi / 3}, Round{ShapeKind::cylinder, 1.5 * kPi},
                             Round{ShapeKind::torus, 2 * kPi * kPi * 0.09}}) {
    SCOPED_TRACE(shape_names()[static_cast<std::size_t>(round.kind)]);
    const Mesh coarse = make_shape(round.kind, 4000);
    const Mesh fine = make_shape(round.kind, 16000);
    const double coarse_error = 1 - enclosed_volume(coarse) / round.volume;
    const double fine_error = 1 - enclosed_volume(fine) / round.volume;
    EXPECT_GT(fine_error, 0);
    EXPECT_LT(coarse_error, 0.01);
    const double ratio = static_cast<double>(fine.vertex_count()) / static_cast<double>(coarse.vertex_count());
    EXPECT_NEAR(coarse_error / fine_error, ratio, 0.2 * ratio);  // rings come in whole numbers: cylinder 4.6 for 4.0
  }
}

// A tube's volume is its cross-section times the length of its curve (Pappus), so an overlap or a kink would show.
TEST(Shapes, KnotDoesNotTouchItself) {
  constexpr int kSamples = 1500;
  std::vector<Vec3d> curve;
  for (int i = 0; i < kSamples; ++i) {
    const double t = 2 * kPi * i / kSamples;
    curve.push_back(
        {(2 + std::cos(3 * t)) * std::cos(2 * t), (2 + std::cos(3 * t)) * std::sin(2 * t), std::sin(3 * t)});
  }
  double length = 0;
  double nearest = 1e9;
  for (int i = 0; i < kSamples; ++i) {
    length += norm(curve[(i + 1) % kSamples] - curve[i]);
    for (int j = i + 1; j < kSamples; ++j) {
      const int apart = std::min(j - i, kSamples - (j - i));
      if (apart > kSamples / 12) nearest = std::min(nearest, norm(curve[j] - curve[i]));
    }
  }
  EXPECT_GT(nearest, 2 * 0.45 + 0.05);
  EXPECT_NEAR(enclosed_volume(make_shape(ShapeKind::knot, 60000)), kPi * 0.45 * 0.45 * length, 0.05);
}

TEST(Shapes, LetterIsFlatInFrontAndBehind) {
  const Mesh mesh = make_shape(ShapeKind::letter_y);
  std::size_t front = 0;
  std::size_t back = 0;
  for (const Vec3d& p : mesh.positions) {
    front += std::abs(p.z - 0.1) < 1e-9 ? 1U : 0U;
    back += std::abs(p.z + 0.1) < 1e-9 ? 1U : 0U;
  }
  EXPECT_GT(front, mesh.vertex_count() / 8);  // measured: a seventh
  EXPECT_GT(back, mesh.vertex_count() / 8);
}

TEST(Shapes, CraterHasABowlARimAndAFlatBottom) {
  const Mesh mesh = make_shape(ShapeKind::crater);
  double bowl = 0;
  double rim = 0;
  for (const Vec3d& p : mesh.positions) {
    if (p.z < -1.4) continue;  // the bottom
    const double r = std::sqrt(p.x * p.x + p.y * p.y);
    if (r < 1.3) bowl = std::min(bowl, p.z);
    if (r > 1.8 && r < 2.4) rim = std::max(rim, p.z);
  }
  EXPECT_LT(bowl, -0.3);
  EXPECT_GT(rim, 0.25);
}

TEST(HandFingers, AreGrippedByTheirCylinders) {
  const Mesh mesh = make_shape(ShapeKind::hand, 60000);
  ASSERT_EQ(hand_fingers().size(), 5U);
  for (const Finger& finger : hand_fingers()) {
    SCOPED_TRACE(finger.name);
    EXPECT_NEAR(norm(finger.axis), 1, 1e-12);
    double farthest = 0;
    for (const Vec3d& p : mesh.positions) {
      const double height = dot(p - finger.base, finger.axis);
      const double distance = norm(p - finger.base - finger.axis * height);
      if (height < 0 || height > finger.length) continue;
      EXPECT_TRUE(distance < finger.radius || distance > finger.radius + 0.02) << "height " << height;
      if (distance < finger.radius) farthest = std::max(farthest, height);
    }
    EXPECT_GT(farthest, finger.length - 0.02);
    EXPECT_LT(farthest, finger.length - 0.001);
  }
}

}  // namespace
}  // namespace knead::shapes_test
