// The widest transition that fits beside points that are to rest.
#include <gtest/gtest.h>

#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"

namespace knead::widest_outer_test {
namespace {

// Points on the faces of the box from -1 to 1, and on a body in its middle.
std::vector<Vec3d> boundary() {
  std::vector<Vec3d> points;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const double a = i / 20.0;
      const double b = j / 20.0;
      for (const double side : {-1.0, 1.0}) {
        points.push_back({side, a, b});
        points.push_back({a, side, b});
        points.push_back({a, b, side});
        points.push_back(Vec3d{side, a, b} * 0.05);
      }
    }
  }
  return points;
}

std::vector<bool> resting(const Stroke& stroke, const std::vector<Vec3d>& points) {
  std::vector<Vec3d> moved = points;
  AdvectOptions options;
  options.tolerance = 1e-5;
  EXPECT_EQ(advect(flow_of(stroke), moved, options).status, AdvectStatus::done);
  std::vector<bool> rests;
  for (std::size_t i = 0; i < points.size(); ++i) rests.push_back(moved[i] == points[i]);
  return rests;
}

ImplicitStroke pull(double outer) {
  ImplicitStroke stroke;
  stroke.path = {{0, 0, 0}, {0.2, 0, 0}};
  stroke.inner = 0.12;
  stroke.outer = outer;
  return stroke;
}

TEST(WidestOuter, IsTheDistanceFromTheToolToWhatRests) {
  const std::vector<Vec3d> points = boundary();
  EXPECT_EQ(widest_outer(pull(0.3), points), 0.8 - 0.001);  // at 0.8 it touches; three digits
  const RotateStroke turn{{0.25, 0, 0}, {0, 0, 1}, 30, 0.3, 0.4};
  EXPECT_EQ(widest_outer(turn, points), 0.75 - 0.001);
  const StretchStroke stretch{{0, 0, -0.5}, {0, 0, 1}, 1.2, 0.1, 0.2};
  ASSERT_TRUE(widest_outer(stretch, points));
  EXPECT_NEAR(*widest_outer(stretch, points), 0.43, 0.03);  // the body in the middle rests, 0.45 away
}

TEST(WidestOuter, MovesNoPointThatRestsNow) {
  const std::vector<Vec3d> points = boundary();
  PointsStroke set;
  set.points = {{0, 0, 0}, {0.1, 0.05, 0}, {0, 0.1, 0.05}};
  set.outer = 0.3;
  set.inner = 0.05;
  set.displacements = {{0.1, 0, 0}};
  for (const Stroke& stroke : {Stroke(pull(0.3)), Stroke(set)}) {
    const std::optional<double> outer = widest_outer(stroke, points, 1);
    ASSERT_TRUE(outer);
    EXPECT_EQ(outer, widest_outer(stroke, points, 3));
    Stroke wider = stroke;
    std::visit(
        [&](auto& s) {
          if constexpr (requires { s.outer; }) s.outer = *outer;
        },
        wider);
    EXPECT_GT(*outer, 0.35);
    EXPECT_EQ(resting(wider, points), resting(stroke, points));
  }
  EXPECT_NE(resting(pull(0.82), points), resting(pull(0.3), points));
}

TEST(WidestOuter, IsMissingWhereNothingFits) {
  const std::vector<Vec3d> points = boundary();
  EXPECT_FALSE(widest_outer(pull(0.78), points)) << "less than 5%";
  EXPECT_FALSE(widest_outer(pull(3), points)) << "all points move";
  EXPECT_FALSE(widest_outer(pull(0.3), {}));
  EXPECT_FALSE(widest_outer(BendStroke{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 10, BendWidth{0.2}}, points));
  EXPECT_THROW(widest_outer(pull(0.1), points), InvalidInput) << "outer is below inner";
}

}  // namespace
}  // namespace knead::widest_outer_test
