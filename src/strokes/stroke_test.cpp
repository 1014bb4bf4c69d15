// Strokes as flows: segments, fields and motion of each tool, and checks of their numbers.
#include "knead/stroke.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::stroke_test {
namespace {

constexpr double kPi = std::numbers::pi;
// Formulas written in another way differ by a few roundings of numbers of size 1.
constexpr double kRounding = 1e-14;

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance = kRounding) { EXPECT_LE(norm(a - b), tolerance); }

// Where the flow takes x, to a tolerance of 1e-10.
Vec3d moved(const Stroke& stroke, const Vec3d& x) {
  std::vector<Vec3d> points{x};
  AdvectOptions options;
  options.tolerance = 1e-10;
  options.precision = Precision::float64;
  EXPECT_EQ(advect(flow_of(stroke), points, options).status, AdvectStatus::done);
  return points.front();
}

std::string refusal(const Stroke& stroke) {
  try {
    validate(stroke);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

void expect_refused(const Stroke& stroke, const std::string& begin) {
  EXPECT_TRUE(refusal(stroke).starts_with(begin)) << "got: " << refusal(stroke);
  EXPECT_THROW(flow_of(stroke), InvalidInput);
}

TEST(ImplicitStroke, HasOneSegmentForEachPieceAndSkipsEmptyOnes) {
  const ImplicitStroke stroke{{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 2, 0}}, 0.2, 0.6};
  const Flow flow = flow_of(stroke);
  ASSERT_EQ(flow.segments.size(), 2u);
  EXPECT_EQ(flow.segments[0].displacement, Vec3d(1, 0, 0));
  EXPECT_EQ(flow.segments[1].displacement, Vec3d(0, 2, 0));
  EXPECT_EQ(flow.segments[1].fields.at(0).center, Vec3d(1, 0, 0));
  EXPECT_EQ(flow.segments[1].time_law, TimeLaw::swept);
  const auto motion = std::get<Translation<double>>(flow.segments[1].fields[0].motion);
  EXPECT_EQ(motion.velocity, Vec3d(0, 2, 0));
  EXPECT_EQ(motion.gauge, 1);
  EXPECT_TRUE(std::holds_alternative<Ball<double>>(flow.segments[1].fields[0].region));
  EXPECT_NO_THROW(validate(flow));
}

TEST(ImplicitStroke, OfOnePlaceOnlyHasNoSegment) {
  EXPECT_TRUE(flow_of(ImplicitStroke{{{1, 2, 3}, {1, 2, 3}}, 0.2, 0.6}).segments.empty());
}

TEST(ImplicitStroke, CarriesItsInnerRegionAlongThePath) {
  const ImplicitStroke stroke{{{0, 0, 0}, {1, 0, 0}, {1, 2, 1}}, 0.3, 0.6};
  expect_near(moved(stroke, {0.1, 0.1, 0.05}), {1.1, 2.1, 1.05});
}

TEST(ImplicitStroke, CapsuleHasItsAxisAndGauge) {
  ImplicitStroke stroke{{{0, 0, 0}, {0, 0, 1}}, 0.2, 0.6, ImplicitRegion::capsule, {0, 3, 0}};
  stroke.time = TimeLaw::blended;
  const Segment segment = flow_of(stroke).segments.at(0);
  const auto motion = std::get<Translation<double>>(segment.fields[0].motion);
  EXPECT_EQ(motion.axis, Vec3d(0, 1, 0));
  EXPECT_EQ(motion.gauge, 0);
  EXPECT_EQ(std::get<Capsule<double>>(segment.fields[0].region).half_axis, Vec3d(0, 3, 0));
  EXPECT_EQ(segment.time_law, TimeLaw::blended);
  EXPECT_NO_THROW(validate(flow_of(stroke)));
}

TEST(PaintStroke, PushesAgainstTheNormal) {
  const PaintStroke stroke{0.5, 0.1, {{{1, 2, 3}, {0, 0, 2}}, {{0, 0, 0}, {-3, 0, 0}}}};
  const Flow flow = flow_of(stroke);
  ASSERT_EQ(flow.segments.size(), 2u);
  EXPECT_EQ(flow.segments[0].displacement, Vec3d(0, 0, -0.1));
  EXPECT_EQ(flow.segments[0].fields[0].center, Vec3d(1, 2, 3));
  EXPECT_EQ(flow.segments[0].fields[0].thresholds, (Thresholds<double>{0, 0.5}));
  EXPECT_EQ(flow.segments[1].displacement, Vec3d(0.1, 0, 0));
  expect_near(moved(stroke, {1, 2, 3}), {1, 2, 2.9});  // the centre of the tool goes with it
}

TEST(RotateStroke, TurnsItsInnerRegionByTheAngle) {
  const RotateStroke stroke{{1, 0, 0}, {0, 0, 5}, 90, 0.5, 1};
  expect_near(moved(stroke, {1.3, 0, 0.2}), {1, 0.3, 0.2});
  EXPECT_EQ(moved(stroke, {2.1, 0, 0}), Vec3d(2.1, 0, 0));
  // With gauge 0 a point of the intermediate region turns by w times the angle.
  const double weight = blend_weight(0.75, Thresholds<double>{0.5, 1}).value;
  const double angle = weight * kPi / 2;
  expect_near(moved(stroke, {1.75, 0, 0}), {1 + 0.75 * std::cos(angle), 0.75 * std::sin(angle), 0});
}

TEST(StretchStroke, StretchesAlongAndThinsAcross) {
  const StretchStroke stroke{{0, 0, 1}, {0, 2, 0}, 1.44, 1, 2};
  expect_near(moved(stroke, {0.1, 0.2, 1.3}), {0.1 / 1.2, 0.2 * 1.44, 1 + 0.3 / 1.2});
}

TEST(StretchStroke, OfFactorOneMovesNothing) {
  EXPECT_EQ(moved(StretchStroke{{0, 0, 0}, {0, 1, 1}, 1, 0.5, 2}, {0.9, 0.5, 0}), Vec3d(0.9, 0.5, 0));
}

TEST(TwistStroke, TurnsByTheRateTimesTheHeight) {
  const TwistStroke stroke{{0, 0, 1}, {0, 0, 3}, 30, 4, 5};
  const double angle = kPi / 6 * 2;  // height 2 above the centre
  expect_near(moved(stroke, {1, 0, 3}), {std::cos(angle), std::sin(angle), 3});
  EXPECT_EQ(moved(stroke, {1, 0, 7}), Vec3d(1, 0, 7));
}

TEST(TwistStroke, OfAThinHairTurnsAsThatOfAThickOne) {
  const double scale = 0x1p-20;
  const TwistStroke thick{{0, 0, 1}, {0, 0, 3}, 30, -4, 5};
  const TwistStroke thin{{0, 0, scale}, {0, 0, 3}, 30 / scale, -4 * scale, 5 * scale};
  std::vector<Vec3d> points{Vec3d{1, 0, 3} * scale};
  AdvectOptions options;
  options.tolerance = 1e-10 * scale;
  options.precision = Precision::float64;
  EXPECT_EQ(advect(flow_of(thin), points, options).status, AdvectStatus::done);
  expect_near(points.front() * (1 / scale), moved(thick, {1, 0, 3}), 1e-9);
  expect_refused(TwistStroke{{0, 0, 0}, {0, 0, 1}, 1e12, -1e-6, 1e-6}, "\"rate_deg\" turns by 2e+06 degrees");
}

TEST(TwistStroke, HasItsNormalAndLimitCylinder) {
  TwistStroke stroke{{0, 0, 1}, {0, 0, 3}, 30, -1, 1};
  stroke.normal = Vec3d{0, -2, 0};
  stroke.radius = 0.5;
  const Segment segment = flow_of(stroke).segments.at(0);
  EXPECT_EQ(std::get<HalfSpace<double>>(segment.fields[0].region).normal, Vec3d(0, -1, 0));
  ASSERT_TRUE(segment.limit_cylinder);
  EXPECT_EQ(*segment.limit_cylinder, (LimitCylinder{{0, 0, 1}, {0, -1, 0}, 0.5}));
}

TEST(TwistStroke, WithAnAutomaticRadiusIsValidButNoFlowYet) {
  TwistStroke stroke{{0, 0, 1}, {0, 0, 3}, 30, -1, 1};
  stroke.radius_auto = true;
  EXPECT_NO_THROW(validate(stroke));
  EXPECT_THROW(flow_of(stroke), InvalidInput);
  stroke.radius = 0.5;
  EXPECT_THROW(validate(stroke), InvalidInput);
}

TEST(BendStroke, TurnsItsInnerRegionByTheAngleAndItsNormalByHalf) {
  const BendStroke stroke{{0, 0, 0}, {0, 2, 0}, {3, 0, 0}, 40, BendWidth{2, 0.25}};
  const Segment segment = flow_of(stroke).segments.at(0);
  const auto region = std::get<HalfSpace<double>>(segment.fields[0].region);
  EXPECT_EQ(region.normal, Vec3d(1, 0, 0));
  EXPECT_EQ(region.turn_axis, Vec3d(0, 1, 0));
  EXPECT_NEAR(region.turn_angle, kPi / 9, kRounding);
  EXPECT_EQ(segment.fields[0].thresholds, (Thresholds<double>{-0.5, 1.5}));
  EXPECT_FALSE(segment.limit_cylinder);
  const double angle = kPi / 180 * 40;
  expect_near(moved(stroke, {-4, 1, 0}), {-4 * std::cos(angle), 1, 4 * std::sin(angle)});
}

TEST(BendStroke, HasItsCenterWhereTheWeightIsOneHalf) {
  const BendStroke stroke{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40, BendWidth{1.7}};
  const Thresholds<double> thresholds = flow_of(stroke).segments[0].fields[0].thresholds;
  EXPECT_NEAR(blend_weight(0.0, thresholds).value, 0.5, kRounding);
  EXPECT_NEAR(thresholds.outer - thresholds.inner, 1.7, kRounding);
}

TEST(BendStroke, HasItsCenterWhereTheWeightIsOneHalfForEveryFalloff) {
  for (int falloff = kMinFalloff; falloff <= kGreatestFalloff; ++falloff) {
    BendStroke stroke{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40, BendWidth{1.7}};
    stroke.falloff = falloff;
    const Thresholds<double> thresholds = flow_of(stroke).segments[0].fields[0].thresholds;
    EXPECT_EQ(thresholds.falloff, falloff);
    EXPECT_NEAR(blend_weight(0.0, thresholds).value, 0.5, kRounding) << falloff;
    EXPECT_NEAR(thresholds.outer - thresholds.inner, 1.7, kRounding);
  }
}

// By half the angle there, so that a bend of 90 degrees has its middle at 45.
TEST(BendStroke, TurnsThePlaneThroughItsCenterByHalfTheAngleForEveryFalloff) {
  for (const int falloff : {3, 4, 7}) {
    BendStroke stroke{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 90, BendWidth{2}};
    stroke.falloff = falloff;
    const Vec3d beside = moved(stroke, {0, 0, 1e-4});
    const Vec3d turned = rotate(Vec3d{0, 0, 1e-4}, {0, 1, 0}, sincos(kPi / 4));
    EXPECT_LT(norm(beside - turned), 1e-7) << falloff;  // of second order in the distance
  }
}

TEST(SetFalloff, KeepsTheZoneOfABendAndMovesItsCenter) {
  const BendStroke bend{
      {0, 0, 5}, {0, 1, 0}, {0, 0, -2}, 40, BendThresholds{-2 * kCenterFraction, 2 - 2 * kCenterFraction}};
  const auto ends = [](const Stroke& stroke) {
    const Field field = flow_of(stroke).segments[0].fields[0];
    return std::pair{field.center.z - field.thresholds.inner, field.center.z - field.thresholds.outer};
  };
  for (int falloff = kMinFalloff; falloff <= kGreatestFalloff; ++falloff) {
    Stroke stroke = bend;
    set_falloff(stroke, falloff);
    EXPECT_EQ(falloff_of(stroke), falloff);
    EXPECT_NEAR(ends(stroke).first, ends(bend).first, kRounding);
    EXPECT_NEAR(ends(stroke).second, ends(bend).second, kRounding);
    EXPECT_NEAR(blend_weight(0.0, flow_of(stroke).segments[0].fields[0].thresholds).value, 0.5, kRounding);
    set_falloff(stroke, kDefaultFalloff);
    EXPECT_LT(norm(std::get<BendStroke>(stroke).center - bend.center), kRounding);
  }
  Stroke stroke = bend;
  EXPECT_THROW(set_falloff(stroke, 8), InvalidInput);
}

TEST(Falloff, IsThatOfEveryFieldOfATool) {
  const std::vector<Vec3d> path{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const std::vector<Stroke> strokes{ImplicitStroke{path, 0.1, 0.5},
                                    PaintStroke{0.3, 0.1, {{{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, 1}}}},
                                    PointsStroke{path, {}, 0.4, {{0, 0, 1}}},
                                    HandlesStroke{{{0, 0, 0}}, {{1, 0, 0}}, {}, {}, HandlesTranslation{{0, 1, 0}}},
                                    RotateStroke{{}, {0, 0, 1}, 20, 0.1, 1},
                                    StretchStroke{{}, {0, 0, 1}, 2, 0.1, 1},
                                    TwistStroke{{}, {0, 0, 1}, 20, -1, 1},
                                    BendStroke{{}, {0, 0, 1}, {1, 0, 0}, 20, BendWidth{1}}};
  for (const Stroke& plain : strokes) {
    EXPECT_EQ(falloff_of(plain), 4) << tool_name(plain);
    Stroke stroke = plain;
    set_falloff(stroke, 7);
    EXPECT_NE(stroke, plain) << tool_name(plain);
    const Flow flow = flow_of(stroke);
    ASSERT_FALSE(flow.segments.empty());
    for (const Segment& segment : flow.segments) {
      for (const Field& field : segment.fields) EXPECT_EQ(field.thresholds.falloff, 7) << tool_name(plain);
    }
    EXPECT_EQ(falloff_of(mirrored(stroke, 1)), 7);
  }
  StampStroke stamp;
  EXPECT_FALSE(falloff_of(stamp)) << "it slips";
  stamp.contact = StampContact::stick;
  EXPECT_EQ(falloff_of(stamp), 4);
  EXPECT_FALSE(falloff_of(RelaxStroke{}));
  EXPECT_FALSE(falloff_of(MaskStroke{}));
}

TEST(Falloff, IsRefusedBeyondThreeToSeven) {
  for (const int falloff : {-1, 0, 2, 8}) {
    RotateStroke stroke{{}, {0, 0, 1}, 20, 0.1, 1};
    stroke.falloff = falloff;
    expect_refused(stroke, "\"falloff\" must be a whole number from 3 to 7, got " + std::to_string(falloff));
    Flow flow = flow_of(RotateStroke{{}, {0, 0, 1}, 20, 0.1, 1});
    flow.segments[0].fields[0].thresholds.falloff = falloff;
    EXPECT_THROW(validate(flow), InvalidInput);
  }
}

TEST(BendStroke, TakesThresholdsAsGiven) {
  const BendStroke stroke{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40, BendThresholds{-3, -1}};
  EXPECT_EQ(flow_of(stroke).segments[0].fields[0].thresholds, (Thresholds<double>{-3, -1}));
}

TEST(Stroke, NormalisesAxesOfAnyLength) {
  for (const double length : {1e-300, 1e-9, 1.0, 1e200}) {
    const RotateStroke stroke{{0, 0, 0}, {length, 2 * length, -2 * length}, 90, 0.5, 1};
    const auto motion = std::get<Rotation<double>>(flow_of(stroke).segments[0].fields[0].motion);
    expect_near(motion.axis, {1.0 / 3, 2.0 / 3, -2.0 / 3});
  }
}

TEST(Stroke, IsRefusedForValuesThatMeanNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = kInfinity;
  const std::vector<Vec3d> path{{0, 0, 0}, {1, 0, 0}};
  const Vec3d x{1, 0, 0};
  const Vec3d y{0, 1, 0};
  expect_refused(ImplicitStroke{{x}, 0.2, 0.6}, "\"path\" must hold 2 or more points, got 1");
  expect_refused(ImplicitStroke{{x, {0, nan, 0}}, 0.2, 0.6}, "\"path\" must be three finite numbers");
  expect_refused(ImplicitStroke{path, 0.6, 0.2}, "\"outer\" must be a number greater than \"inner\" (0.6), got 0.2");
  expect_refused(ImplicitStroke{path, 0, 0.2}, "\"inner\" must be a number greater than 0, got 0");
  expect_refused(ImplicitStroke{path, 0.1, infinity}, "\"outer\" must be");
  expect_refused(ImplicitStroke{path, 0.1, 0.2, ImplicitRegion::capsule}, "\"half_axis\" must be a vector");
  expect_refused(ImplicitStroke{path, 0.1, 0.2, ImplicitRegion::ball, x}, "\"half_axis\" and \"gauge\"");
  expect_refused(PaintStroke{0, 1, {{x, y}}}, "\"outer\"");
  expect_refused(PaintStroke{1, 0, {{x, y}}}, "\"depth\" must be a number other than 0");
  expect_refused(PaintStroke{1, 1, {}}, "\"samples\" must hold 1 or more");
  expect_refused(PaintStroke{1, 1, {{x, {0, 0, 0}}}}, "\"normal\"");
  expect_refused(RotateStroke{x, {0, 0, 0}, 1, 0.1, 1}, "\"axis\" must be a vector of any length but 0");
  expect_refused(RotateStroke{x, y, 1e9, 0.1, 1}, "\"angle_deg\"");
  expect_refused(RotateStroke{x, y, 1, -0.1, 1}, "\"inner\" must be a number that is 0 or greater");
  expect_refused(RotateStroke{x, y, 1, 0.1, 1, nan}, "\"gauge\"");
  expect_refused(StretchStroke{x, y, 0, 0.1, 1}, "\"factor\" must be a number greater than 0, from 1e-6 to 1e6, got 0");
  expect_refused(TwistStroke{x, y, 1, 1, 1}, "\"outer\"");
  expect_refused(TwistStroke{x, y, 1, 1, 2, Vec3d{0, 0, 0}}, "\"normal\"");
  expect_refused(TwistStroke{x, y, 1, 1, 2, y, 0, -1}, "\"radius\" must be a number greater than 0, got -1");
  expect_refused(BendStroke{x, y, {0, -2, 0}, 1, BendWidth{1}}, "\"normal\" must not be parallel to \"axis\"");
  expect_refused(BendStroke{x, y, x, 1, BendWidth{0}}, "\"width\"");
  expect_refused(BendStroke{x, y, x, 1, BendThresholds{2, 1}}, "\"outer\"");
}

TEST(Stroke, WarnsOfStrongFlowBack) {
  const std::vector<Vec3d> path{{0, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(warnings(ImplicitStroke{path, 0.9, 1}).empty());
  const std::vector<std::string> found = warnings(ImplicitStroke{path, 0.91, 1});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("times its speed"), std::string::npos);
  EXPECT_TRUE(warnings(RotateStroke{{}, {0, 0, 1}, 10, 0.95, 1}).empty());
  EXPECT_EQ(warnings(RotateStroke{{}, {0, 0, 1}, 10, 0.95, 1, 1}).size(), 1u);
}

TEST(Stroke, WarnsOfASkewedBend) {
  EXPECT_TRUE(warnings(BendStroke{{}, {0, 1, 0}, {1, 0, 0}, 10, BendWidth{1}}).empty());
  EXPECT_EQ(warnings(BendStroke{{}, {0, 1, 0}, {1, 1, 0}, 10, BendWidth{1}}).size(), 1u);
}

TEST(Stroke, HasTheNameOfItsTool) {
  EXPECT_EQ(tool_name(ImplicitStroke{}), "implicit");
  EXPECT_EQ(tool_name(PointsStroke{}), "points");
  EXPECT_EQ(tool_name(BendStroke{}), "bend");
}

}  // namespace
}  // namespace knead::stroke_test
