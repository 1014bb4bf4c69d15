// Bends by more than 170 degrees, which are poses of the body.
#include "strokes/pose.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <regex>
#include <string>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "support/surface.h"

namespace knead::body_bend_test {
namespace {

struct Bent : test::MovedSurface {
  using MovedSurface::MovedSurface;

  PoseResult bend(const BendStroke& stroke, int threads = 0) { return bend_on(stroke, live(threads), threads); }
};

// A bar along x, 12 long and 1 thick: rings of four corners, an eighth apart.
Mesh bar() {
  constexpr std::uint32_t kRings = 97;
  Mesh mesh;
  for (std::uint32_t i = 0; i < kRings; ++i) {
    const double x = -6 + 0.125 * i;
    for (const auto& [y, z] : {std::pair(-0.5, -0.5), std::pair(0.5, -0.5), std::pair(0.5, 0.5), std::pair(-0.5, 0.5)})
      mesh.positions.push_back({x, y, z});
  }
  for (std::uint32_t i = 0; i + 1 < kRings; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t a = 4 * i + k;
      const std::uint32_t b = 4 * i + (k + 1) % 4;
      mesh.add_face(std::array{a, a + 4, b});
      mesh.add_face(std::array{b, a + 4, b + 4});
    }
  }
  const std::uint32_t end = 4 * (kRings - 1);
  for (const auto& face : {std::array{0U, 1U, 2U}, std::array{0U, 2U, 3U}}) {
    mesh.add_face(face);
    mesh.add_face(std::array{end + face[2], end + face[1], end + face[0]});
  }
  return mesh;
}

BendStroke bend_of(double angle_deg, double width = 12, double center = 0) {
  BendStroke stroke;
  stroke.center = {center, 0, 0};
  stroke.axis = {0, 0, 1};
  stroke.normal = {1, 0, 0};
  stroke.angle_deg = angle_deg;
  stroke.extent = BendWidth{width};
  return stroke;
}

// What a message says after "at most".
double named_angle(const std::string& message) {
  std::smatch match;
  return std::regex_search(message, match, std::regex("at most (-?[0-9.]+) degrees")) ? std::stod(match[1]) : 0;
}

std::string refusal_of(const BendStroke& stroke, Mesh mesh) {
  Bent shape(std::move(mesh));
  const std::vector<Vec3d> before = shape.mesh.positions;
  try {
    shape.bend(stroke);
  } catch (const InvalidInput& error) {
    EXPECT_EQ(shape.mesh.positions, before);
    return error.what();
  }
  return "not refused";
}

class ABarBends : public testing::TestWithParam<double> {};

TEST_P(ABarBends, AsItsLengthAllows) {
  const Mesh before = bar();
  Bent shape(before);
  const PoseResult result = shape.bend(bend_of(GetParam()));
  EXPECT_EQ(result.warnings, std::vector<std::string>{});
  EXPECT_NEAR(measure(shape.mesh).volume / measure(before).volume, 1, 2e-3);
  EXPECT_EQ(self_intersections(shape.triangles, shape.mesh.positions).count, 0U);
  for (const Triangle& t : shape.triangles) {
    const auto corners = [&](const Mesh& mesh) {
      return std::array{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    };
    const double stretch = *triangle_stretch(corners(before), corners(shape.mesh));
    EXPECT_GT(stretch, 0.7);
    EXPECT_LT(stretch, 1.4);
  }
  // One end rests; the other has turned by the angle, and nothing leaves the plane of the bend.
  const auto& p = shape.mesh.positions;
  EXPECT_LT(norm(p[4 * 96] - before.positions[4 * 96]), 0.02);
  const Vec3d along = normalized(p[4 * 3] - p[0]);
  const double angle = GetParam() * std::acos(-1) / 180;
  EXPECT_LT(norm(along - Vec3d{std::cos(angle), std::sin(angle), 0}), 0.02);
  for (std::size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(p[i].z, before.positions[i].z, 0.02);
}

INSTANTIATE_TEST_SUITE_P(BodyBend, ABarBends, testing::Values(172, -180, 270), [](const auto& test) {
  return (test.param < 0 ? "minus_" : "") + std::to_string(std::lround(std::abs(test.param)));
});

TEST(BodyBend, TheBitsDependNotOnThreads) {
  Bent one(bar());
  Bent two(bar());
  one.bend(bend_of(150, 6), 1);
  two.bend(bend_of(150, 6), 2);
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);
}

TEST(BodyBend, AVertexThatNoTriangleUsesDoesNotMatter) {
  Mesh stray = bar();
  stray.positions.push_back({-3, 1e6, 0});
  Bent one(bar());
  Bent two(stray);
  one.bend(bend_of(175, 6));
  two.bend(bend_of(175, 6));
  two.mesh.positions.pop_back();
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);
}

TEST(BodyBend, TheCentreMayLieBesideThePart) {
  Bent one(bar());
  Bent two(bar());
  one.bend(bend_of(150));
  BendStroke beside = bend_of(150);
  beside.center.y = 1.9;
  two.bend(beside);
  for (std::size_t i = 0; i < one.mesh.positions.size(); ++i) {
    EXPECT_LT(norm(one.mesh.positions[i] - two.mesh.positions[i]), 1e-9);
  }
}

TEST(BodyBend, ARingIsRefusedWithAnAngleThatWorks) {
  const double named = named_angle(refusal_of(bend_of(-360), bar()));
  EXPECT_LT(named, -250);
  EXPECT_NO_THROW(Bent(bar()).bend(bend_of(named)));
}

TEST(BodyBend, AShortZoneIsRefusedWithAnAngleThatWorks) {
  const std::string message = refusal_of(bend_of(170, 2), bar());
  EXPECT_NE(message.find("make the zone 3.54 wide"), std::string::npos) << message;
  EXPECT_NO_THROW(Bent(bar()).bend(bend_of(named_angle(message), 2)));
  EXPECT_NO_THROW(Bent(bar()).bend(bend_of(170, 3.54)));
}

// A wider zone holds a thicker part, and the angle of a short one may still be too much.
TEST(BodyBend, AShortZoneOfAWedgeIsRefusedWithNumbersThatWork) {
  Mesh wedge = bar();
  for (Vec3d& p : wedge.positions) p.y *= 1 + 0.3 * std::abs(p.x);
  const std::string message = refusal_of(bend_of(172, 1), wedge);
  std::smatch match;
  ASSERT_TRUE(std::regex_search(message, match, std::regex("make the zone ([0-9.]+) wide"))) << message;
  EXPECT_EQ(refusal_of(bend_of(172, std::stod(match[1])), wedge).find("too short"), std::string::npos) << message;
}

// Twelve triangles, none with a vertex in the zone.
TEST(BodyBend, APartOfFewTrianglesBendsToo) {
  Mesh coarse;
  for (const double x : {-6.0, 6.0}) {
    for (const auto& [y, z] : {std::pair(-0.5, -0.5), std::pair(0.5, -0.5), std::pair(0.5, 0.5), std::pair(-0.5, 0.5)})
      coarse.positions.push_back({x, y, z});
  }
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t next = (k + 1) % 4;
    coarse.add_face(std::array{k, k + 4, next});
    coarse.add_face(std::array{next, k + 4, next + 4});
  }
  for (const auto& face : {std::array{0U, 1U, 2U}, std::array{0U, 2U, 3U}}) {
    coarse.add_face(face);
    coarse.add_face(std::array{4 + face[2], 4 + face[1], 4 + face[0]});
  }
  Bent shape(coarse);
  shape.bend(bend_of(180, 8));
  const auto& p = shape.mesh.positions;
  EXPECT_NEAR(dot(normalized(p[1] - p[0]), normalized(p[5] - p[4])), -1, 0.03);
  for (const std::size_t first : {0, 4}) EXPECT_NEAR(norm(p[first + 2] - p[first]), std::sqrt(2), 0.02);
}

TEST(BodyBend, AZoneBesideTheShapeIsRefused) {
  EXPECT_EQ(refusal_of(bend_of(150, 2, 20), bar()).rfind("\"width\": no vertex", 0), 0U);
  EXPECT_EQ(refusal_of(bend_of(150, 14, -3), bar()).rfind("\"center\": nothing", 0), 0U);
}

// A hook: the end of the bar lies over its middle, where the next joint bends.
TEST(BodyBend, OnlyThePartBeyondTheJointMoves) {
  Bent shape(bar());
  shape.bend(bend_of(190, 6, -2));
  const Mesh hook = shape.mesh;
  BendStroke joint = bend_of(25, 1.6, 2.5);
  joint.radius_auto = true;
  LiveSurface surface = shape.live();
  ASSERT_TRUE(bends_body(joint, surface));
  shape.bend(joint);
  EXPECT_EQ(self_intersections(shape.triangles, shape.mesh.positions).count, 0U);
  const Vec3d axis{0, 0, 1};
  for (std::size_t i = 0; i < hook.positions.size(); ++i) {
    const double x = -6 + 0.125 * static_cast<double>(i / 4);
    const Vec3d moved = shape.mesh.positions[i] - hook.positions[i];
    if (x > 3.4) {
      EXPECT_LT(norm(moved), 0.01);
    } else if (x < 1.6) {
      EXPECT_GT(norm(moved), 0.1);
    }
  }
  // Rigidly: two rings far apart have turned alike.
  const auto direction = [&](const Mesh& mesh, std::size_t ring) {
    return normalized(mesh.positions[4 * ring + 4] - mesh.positions[4 * ring]);
  };
  for (const std::size_t ring : {2, 30, 55}) {
    EXPECT_NEAR(dot(cross(direction(hook, ring), direction(shape.mesh, ring)), axis),
                std::sin(25 * std::acos(-1) / 180), 0.03);
  }
}

TEST(BodyBend, AStraightPartNeedsNoBody) {
  Bent shape(bar());
  BendStroke joint = bend_of(25, 1.6, 2.5);
  joint.radius_auto = true;
  EXPECT_FALSE(bends_body(joint, shape.live()));
  EXPECT_FALSE(bends_body(bend_of(170), shape.live()));
  EXPECT_TRUE(bends_body(bend_of(-171), shape.live()));
}

TEST(BodyBend, APartThatIsJoinedTwiceIsRefused) {
  BendStroke stroke = bend_of(150, 0.6);
  stroke.center = {0, 1, 0};
  stroke.radius_auto = true;
  EXPECT_EQ(
      refusal_of(stroke, make_shape(ShapeKind::torus, 2000)).rfind("\"radius\": the part that would move is also", 0),
      0U);
}

}  // namespace
}  // namespace knead::body_bend_test
