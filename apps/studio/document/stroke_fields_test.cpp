#include "document/stroke_fields.h"

#include <gtest/gtest.h>

namespace knead::studio {
namespace {

SessionStroke implicit(double inner, double outer) {
  ImplicitStroke stroke;
  stroke.path = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  stroke.inner = inner;
  stroke.outer = outer;
  return {stroke};
}

SessionStroke bend(double angle) {
  BendStroke stroke;
  stroke.angle_deg = angle;
  stroke.extent = BendWidth{0.5};
  return {stroke};
}

TEST(StrokeFields, EachNumberIsNamedOnceWithTheFirstValue) {
  const std::vector<SessionStroke> strokes{implicit(0.1, 0.4), implicit(0.2, 0.6)};
  const auto fields = fields_of(strokes);
  ASSERT_EQ(fields.size(), 2U);
  EXPECT_EQ(fields[0].name, "inner");
  EXPECT_EQ(fields[0].value, 0.1);
  EXPECT_EQ(fields[1].name, "outer");
  EXPECT_EQ(fields[1].value, 0.4);
}

TEST(StrokeFields, MirrorImagesKeepTheirSigns) {
  std::vector<SessionStroke> strokes{bend(30), bend(-30)};
  set_field(strokes, "angle_deg", 45);
  EXPECT_EQ(std::get<BendStroke>(strokes[0].stroke).angle_deg, 45);
  EXPECT_EQ(std::get<BendStroke>(strokes[1].stroke).angle_deg, -45);
  set_field(strokes, "width", 0.25);
  EXPECT_EQ(std::get<BendWidth>(std::get<BendStroke>(strokes[1].stroke).extent).width, 0.25);
  const std::vector<SessionStroke> before = strokes;
  set_field(strokes, "depth", 7);
  EXPECT_EQ(strokes, before);
}

TEST(StrokeFields, AllStrokesOfAnEntryHaveOneFalloff) {
  std::vector<SessionStroke> strokes{{MaskStroke{}}, implicit(0.1, 0.4), bend(30)};
  EXPECT_EQ(falloff_of(strokes), 4);
  set_falloff(strokes, 6);
  EXPECT_EQ(falloff_of(strokes), 6);
  EXPECT_EQ(std::get<ImplicitStroke>(strokes[1].stroke).falloff, 6);
  EXPECT_EQ(std::get<BendStroke>(strokes[2].stroke).falloff, 6);
  EXPECT_EQ(falloff_of(std::span(strokes).first(1)), std::nullopt);
}

}  // namespace
}  // namespace knead::studio
