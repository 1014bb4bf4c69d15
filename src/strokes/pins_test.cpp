// Strokes of pins. Their flow has tests of its own (flow/pins_test.cpp).
#include <gtest/gtest.h>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/stroke.h"
#include "support/random_segments.h"

namespace knead::pins_test {
namespace {

using test::moved;
using test::precisely;

PinsStroke held_corners() {
  PinsStroke stroke;
  stroke.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  stroke.to = stroke.points;
  stroke.to[0] = {0.1, 0.1, 0.1};
  stroke.radius_auto = true;
  return stroke;
}

double radius_of(const PinsStroke& stroke) { return flow_of(stroke).segments[0].fields[0].thresholds.outer; }

std::string refusal(const PinsStroke& stroke) {
  try {
    validate(Stroke(stroke));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(PinsTool, MovesEachPointToItsPlace) {
  const PinsStroke stroke = held_corners();
  const auto after = moved(flow_of(stroke), stroke.points, precisely(1e-10));
  EXPECT_LE(test::greatest_distance(after, stroke.to), 2e-10);
}

// The third nearest pin of each of five: 1.41, 1.41, 1.41, 1.41 and 1.73.
TEST(PinsTool, FindsItsRadius) {
  PinsStroke stroke = held_corners();
  EXPECT_NEAR(radius_of(stroke), 2 * std::sqrt(2.0), 1e-12);
  stroke.to[0] = {3, 0, 4};
  EXPECT_NEAR(radius_of(stroke), 10, 1e-12) << "twice the longest way";
  stroke.points = {{0, 0, 0}, {1, 0, 0}};
  stroke.to = {{0, 0.1, 0}, {1, 0, 0}};
  EXPECT_NEAR(radius_of(stroke), 2, 1e-12) << "twice the distance of the farthest";
  stroke.radius_auto = false;
  stroke.radius = 0.7;
  EXPECT_EQ(radius_of(stroke), 0.7);
}

TEST(PinsTool, RefusesWhatContradictsItself) {
  PinsStroke stroke = held_corners();
  EXPECT_EQ(refusal(stroke), "");
  stroke.to[2] = {2, 1, 0};
  stroke.points[4] = {1.5, 1, 0};
  stroke.to[4] = {1.5, 3, 0};
  EXPECT_EQ(refusal(stroke), "") << "their ways cross, but not at one time";
  stroke.points[4] = {2, 1, 0};
  stroke.to[4] = {0, 1, 0};
  EXPECT_EQ(
      refusal(stroke),
      "\"to\": pins 2 and 4 meet at the time 0.5 of the stroke's 0 to 1, and move apart; move one of them another "
      "way, or remove it");
  stroke = held_corners();
  stroke.points.push_back(stroke.points[3]);
  stroke.to.push_back(stroke.to[3]);
  EXPECT_EQ(refusal(stroke), "\"points\": pins 3 and 5 are at the same place; remove one");
  stroke.to.pop_back();
  EXPECT_EQ(refusal(stroke), "\"to\" must hold as many places as \"points\", 6, got 5");
  PinsStroke none;
  none.radius = 1;
  EXPECT_NE(refusal(none), "");
  PinsStroke one{{{0, 0, 0}}, {{0, 0, 0}}, std::nullopt, true};
  EXPECT_NE(refusal(one), "");
  one.radius_auto = false;
  EXPECT_NE(refusal(one), "");
  one.radius = -1;
  EXPECT_NE(refusal(one), "");
  one.radius = 1;
  one.points.assign(2001, {0, 0, 0});
  one.to = one.points;
  EXPECT_EQ(refusal(one), "\"points\" must hold at most 2000 pins, got 2001");
}

TEST(PinsTool, RefusesMorePairsThanCanBeSolved) {
  PinsStroke stroke;
  for (int i = 0; i < 640; ++i) stroke.points.push_back({i / 640.0, 0, 0});
  stroke.to = stroke.points;
  stroke.radius = 2;
  EXPECT_EQ(
      refusal(stroke),
      "\"radius\": 204480 pairs of pins are nearer than 2 to each other, and 200000 at most can be solved; make it "
      "smaller, or give fewer pins");
  stroke.radius = 0.02;
  EXPECT_EQ(refusal(stroke), "");
}

// A pin that turns by 90 degrees about z, its neighbourhood with it.
TEST(PinsTool, TurnsTheShapeAboutAPin) {
  PinsStroke stroke = held_corners();
  stroke.turn = {std::nullopt, PinRotation{{0, 0, 2}, 90}, PinRotation{{1, 0, 0}, 0}, std::nullopt, std::nullopt};
  EXPECT_EQ(refusal(stroke), "");
  const double h = 1e-4;
  const std::vector<Vec3d> points{{1, 0, 0}, {1 + h, 0, 0}, {1, 0, h}, {0, 1, 0}, {h, 1, 0}};
  const auto after = moved(flow_of(stroke), points, precisely(1e-10));
  EXPECT_LE(norm(after[0] - Vec3d{1, 0, 0}), 1e-9);
  EXPECT_LE(norm((after[1] - after[0]) - Vec3d{0, h, 0}), 1e-2 * h);
  EXPECT_LE(norm((after[2] - after[0]) - Vec3d{0, 0, h}), 1e-2 * h);
  EXPECT_LE(norm((after[4] - after[3]) - Vec3d{h, 0, 0}), 1e-2 * h) << "held";
  const auto twice = std::get<PinsStroke>(prolonged(stroke, 2));
  EXPECT_EQ(twice.turn[1], (PinRotation{{0, 0, 2}, 180}));
  EXPECT_EQ(twice.turn[0], std::nullopt);
}

TEST(PinsTool, RefusesTurnsThatAreNone) {
  PinsStroke stroke = held_corners();
  stroke.turn = {std::nullopt};
  EXPECT_EQ(refusal(stroke), "\"turn\" must hold as many rotations or nulls as \"points\", 5, got 1");
  stroke.turn.assign(5, PinRotation{{0, 0, 0}, 10});
  EXPECT_EQ(refusal(stroke), "\"axis\" must be a vector of any length but 0, got [0, 0, 0]");
  stroke.turn.assign(5, PinRotation{{0, 0, 1}, 1e9});
  EXPECT_NE(refusal(stroke), "");
}

// The mirror image of the shape is where the mirror image of the stroke takes it.
TEST(PinsTool, HasMirrorImagesOfItsTurns) {
  PinsStroke stroke = held_corners();
  stroke.turn = {PinRotation{{0.3, 0.2, 1}, 70}, std::nullopt, std::nullopt, std::nullopt, std::nullopt};
  std::vector<Vec3d> points;
  std::vector<Vec3d> images;
  for (int i = 0; i < 50; ++i) {
    points.push_back({std::sin(1.0 * i) * 0.5, std::sin(2.0 * i) * 0.5, std::sin(3.0 * i) * 0.5});
    images.push_back({-points.back().x, points.back().y, points.back().z});
  }
  const auto after = moved(flow_of(stroke), points, precisely(1e-10));
  const auto mirror = moved(flow_of(mirrored(stroke, 0)), images, precisely(1e-10));
  double farthest = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_LE(norm(mirror[i] - Vec3d{-after[i].x, after[i].y, after[i].z}), 1e-8);
    farthest = std::max(farthest, norm(after[i] - points[i]));
  }
  EXPECT_GT(farthest, 0.1);
}

TEST(PinsTool, GoesOnInItsDirections) {
  const PinsStroke stroke = held_corners();
  const auto twice = std::get<PinsStroke>(prolonged(stroke, 2));
  EXPECT_EQ(twice.to[0], (Vec3d{0.2, 0.2, 0.2}));
  EXPECT_EQ(twice.to[3], stroke.to[3]);
}

// The warning's figure is that of the flow, and comes above 10 times only.
TEST(PinsTool, WarnsOfAStrongStretch) {
  PinsStroke stroke{{{0, 0, 0}, {0.3, 0, 0}}, {{0, 0, 0}, {0.3, 0.05, 0}}, 1.0};
  EXPECT_TRUE(warnings(stroke).empty());
  stroke.to[1] = {0.02, 0.01, 0};
  ASSERT_EQ(warnings(stroke).size(), 1U);
  std::vector<Vec3d> points;
  for (int k = 0; k <= 100; ++k) points.push_back({0.003 * k, 0, 0});
  const GreatestStretch found = greatest_stretch(flow_of(stroke), points, {.length = 1});
  EXPECT_GT(std::max(found.greatest, 1 / found.least), 10);
}

// Pins of a sphere that move along a smooth field.
PinsStroke pins_of_sphere(int count) {
  PinsStroke stroke;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count;
    const double across = std::sqrt(1 - z * z);
    const Vec3d p{across * std::cos(2.4 * i), across * std::sin(2.4 * i), z};
    stroke.points.push_back(p);
    stroke.to.push_back(p + Vec3d{std::sin(3 * p.y), std::cos(2 * p.z), p.x * p.y} * 0.02);
  }
  stroke.radius_auto = true;
  return stroke;
}

// The pin that differs most, with those around it, shows it.
TEST(PinsTool, WarnsOfAStrongStretchOfManyPins) {
  for (const int count : {600, 2000}) {
    PinsStroke stroke = pins_of_sphere(count);
    EXPECT_TRUE(warnings(stroke).empty()) << count;
    const std::size_t pin = static_cast<std::size_t>(count) / 3;
    std::size_t other = 0;
    for (std::size_t i = 0; i < stroke.points.size(); ++i) {
      if (i != pin && norm2(stroke.points[i] - stroke.points[pin]) < norm2(stroke.points[other] - stroke.points[pin]))
        other = i;
    }
    stroke.to[pin] = stroke.points[pin] + (stroke.to[other] - stroke.points[pin]) * 0.9;
    const std::vector<std::string> found = warnings(stroke);
    ASSERT_EQ(found.size(), 1U) << count;
    const std::size_t at = found[0].find("about ");
    ASSERT_NE(at, std::string::npos);
    const double told = std::stod(found[0].substr(at + 6));
    if (count > 600) continue;  // the whole flow takes seconds
    std::vector<Vec3d> points;
    for (int k = 0; k <= 100; ++k) {
      points.push_back(stroke.points[pin] + (stroke.points[other] - stroke.points[pin]) * (0.01 * k));
    }
    const GreatestStretch whole = greatest_stretch(flow_of(stroke), points, {.length = 1});
    const double stretch = std::max(whole.greatest, 1 / whole.least);
    EXPECT_NEAR(told, stretch, 0.2 * stretch) << count;  // 8% at other places of the same flow
  }
}

TEST(PinsStroke, ThatGoBeyondAllBoundsAreRefusedAtOnce) {
  PinsStroke stroke;
  stroke.points = {{0, 0, 1}, {0, 0, -1}};
  stroke.to = {{0, 0, 1e30}, {0, 0, -1}};
  stroke.radius = 0.5;
  EXPECT_TRUE(refusal(stroke).starts_with("\"to\": pin 0 moves by 1e+30")) << refusal(stroke);
}

}  // namespace
}  // namespace knead::pins_test
