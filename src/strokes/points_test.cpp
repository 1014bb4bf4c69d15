// The tool "points": centres, weights of curves, and exact motion of its points.
#include <gtest/gtest.h>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/stroke.h"

namespace knead::points_test {
namespace {

// Sums of a few numbers of size 1 to 10.
constexpr double kRounding = 1e-14;

PointsStroke two_eyes() {
  PointsStroke stroke;
  stroke.points = {{-3, 0, 0}, {3, 0, 0}, {-3, 0.5, 0}, {3, -0.5, 0}};
  stroke.outer = 1;
  stroke.displacements = {{0, 0, 0.3}, {0.1, 0, 0}};
  return stroke;
}

const PointSet<double>& set_of(const Field& field) { return std::get<PointSet<double>>(field.region); }

TEST(PointsStroke, HasAFieldForEachPartAboutItsOwnBarycentre) {
  const Flow flow = flow_of(two_eyes());
  ASSERT_EQ(flow.segments.size(), 2u);
  const Segment& first = flow.segments[0];
  ASSERT_EQ(first.fields.size(), 2u);
  EXPECT_LE(norm(first.fields[0].center - Vec3d{-3, 0.25, 0}), kRounding);
  EXPECT_LE(norm(first.fields[1].center - Vec3d{3, -0.25, 0}), kRounding);
  ASSERT_EQ(set_of(first.fields[0]).points.size(), 2u);
  EXPECT_LE(norm(set_of(first.fields[0]).points[1] - Vec3d{0, 0.25, 0}), kRounding);
  EXPECT_EQ(set_of(first.fields[0]).exponent, 8);
  EXPECT_EQ(first.fields[0].thresholds, (Thresholds<double>{0, 1}));
  const auto motion = std::get<Translation<double>>(first.fields[1].motion);
  EXPECT_EQ(motion.velocity, Vec3d(0, 0, 0.3));
  EXPECT_EQ(motion.gauge, 1);
  EXPECT_NO_THROW(validate(flow));
}

TEST(PointsStroke, MovesAlongWithItsDisplacements) {
  const Flow flow = flow_of(two_eyes());
  EXPECT_EQ(flow.segments[1].displacement, Vec3d(0.1, 0, 0));
  EXPECT_LE(norm(flow.segments[1].fields[0].center - Vec3d{-3, 0.25, 0.3}), kRounding);
  EXPECT_EQ(set_of(flow.segments[1].fields[0]), set_of(flow.segments[0].fields[0]));
}

TEST(PointsStroke, CarriesItsPointsExactly) {
  std::vector<Vec3d> points = two_eyes().points;
  AdvectOptions options;
  options.tolerance = 1e-9;
  options.precision = Precision::float64;
  advect(flow_of(two_eyes()), points, options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LE(norm(points[i] - two_eyes().points[i] - Vec3d{0.1, 0, 0.3}), 1e-8) << i;
  }
}

TEST(PointsStroke, AboutTheBarycentreIsOneField) {
  PointsStroke stroke = two_eyes();
  stroke.center = PointsCenter::barycentre;
  const Segment segment = flow_of(stroke).segments.at(0);
  ASSERT_EQ(segment.fields.size(), 1u);
  EXPECT_LE(norm(segment.fields[0].center), kRounding);
  EXPECT_EQ(set_of(segment.fields[0]).points.size(), 4u);
  EXPECT_EQ(warnings(stroke).size(), 1u);
  EXPECT_TRUE(warnings(two_eyes()).empty());
}

TEST(PointsStroke, CurvesHaveTheSameCentreHoweverTheyAreCut) {
  PointsStroke coarse;
  coarse.curves = {{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}}};
  coarse.outer = 0.5;
  coarse.displacements = {{0, 0, 1}};
  PointsStroke fine = coarse;
  fine.curves = {{{0, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0}, {2, 0, 0}, {2, 0.1, 0}, {2, 1, 0}}};
  const Field a = flow_of(coarse).segments[0].fields.at(0);
  const Field b = flow_of(fine).segments[0].fields.at(0);
  EXPECT_LE(norm(a.center - Vec3d{4.0 / 3, 1.0 / 6, 0}), kRounding);
  EXPECT_LE(norm(a.center - b.center), kRounding);
  EXPECT_EQ(set_of(b).curves[0].size(), 5u);  // the repeated point is left out
  EXPECT_NO_THROW(validate(flow_of(fine)));
}

TEST(PointsStroke, LeavesOutPiecesThatSinglePrecisionCannotTell) {
  PointsStroke stroke;
  stroke.curves = {{{-0.5, 0.1, 1}, {0.3, 0.3, 1}, {0.3, 0.3 + 1e-12, 1}, {0.6, -0.2, 1}}};
  stroke.outer = 0.5;
  stroke.displacements = {{0, 0, 0.2}};
  std::vector<Vec3d> points{{0.35, 0.35, 1.1}};
  EXPECT_EQ(advect(flow_of(stroke), points, {.tolerance = 1e-5}).status, AdvectStatus::done);
  EXPECT_TRUE(is_finite(points[0]));
}

TEST(PointsStroke, WeighsACurveByItsLengthInUnitsOfOuter) {
  PointsStroke stroke;
  stroke.points = {{0, 0, 0}};
  stroke.curves = {{{0, -1, 0.1}, {0, 1, 0.1}}};
  stroke.outer = 0.5;
  stroke.displacements = {{0, 0, 1}};
  const Segment segment = flow_of(stroke).segments.at(0);
  ASSERT_EQ(segment.fields.size(), 1u);
  EXPECT_LE(norm(segment.fields[0].center - Vec3d{0, 0, 0.1 * 4 / 5}), kRounding);
}

TEST(PointsStroke, MayRestForADisplacement) {
  PointsStroke stroke = two_eyes();
  stroke.displacements = {{0, 0, 0}};
  std::vector<Vec3d> points{{-3, 0, 0}, {-3, 0.7, 0}, {0, 0, 0}};
  const std::vector<Vec3d> before = points;
  EXPECT_EQ(advect(flow_of(stroke), points, {.tolerance = 1e-5}).status, AdvectStatus::done);
  EXPECT_EQ(points, before);
}

TEST(PointsStroke, WarnsOfAWideSet) {
  PointsStroke stroke;
  for (int i = 0; i <= 20; ++i) stroke.points.push_back({0.9 * i, 0, 0});
  stroke.outer = 1;
  stroke.displacements = {{0, 0, 1}};
  EXPECT_EQ(warnings(stroke).size(), 1u);
  stroke.points.resize(17);
  EXPECT_TRUE(warnings(stroke).empty());
}

TEST(PointsStroke, IsRefusedForValuesThatMeanNothing) {
  const auto refusal = [](const auto& change) -> std::string {
    PointsStroke stroke = two_eyes();
    change(stroke);
    try {
      validate(stroke);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal([](PointsStroke&) {}), "");
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.points.clear(); }).starts_with("\"points\" and \"curves\""));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.curves = {{{0, 0, 0}}}; }).starts_with("\"curves\" must hold 2"));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.curves = {{{1, 0, 0}, {1, 0, 0}}}; }).starts_with("\"curves\""));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.displacements.clear(); }).starts_with("\"displacements\""));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.exponent = 7; }).starts_with("\"exponent\" must be an even number"));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.exponent = 0; }).starts_with("\"exponent\""));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.inner = 1; }).starts_with("\"outer\""));
  EXPECT_TRUE(refusal([](PointsStroke& s) { s.outer = -1; }).starts_with("\"outer\""));
}

}  // namespace
}  // namespace knead::points_test
