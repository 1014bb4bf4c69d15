// The strength of gestures, and which strokes are one.
#include <gtest/gtest.h>

#include "knead/editor/workbench.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::gesture_strength_test {
namespace {

using Entries = std::vector<std::vector<SessionStroke>>;

Mesh ball() { return make_shape(ShapeKind::sphere, 2562); }

SessionStroke pull(double y) { return {ImplicitStroke{{{0, y, 1}, {0.1, y, 1.2}, {0.3, y, 1.3}}, 0.15, 0.5}}; }
SessionStroke turn(double angle) { return {RotateStroke{{0, 0, 1}, {0, 0, 1}, angle, 0.1, 0.6}}; }

std::vector<Vec3d> replayed(const std::vector<SessionStroke>& strokes) {
  Session session;
  session.name = "s.knead";
  session.strokes = strokes;
  return replay(ball(), session).shape.positions();
}

TEST(Groups, NeighboursOfOneNameAreOneGroup) {
  SessionStroke a = pull(0);
  SessionStroke b = turn(20);
  a.name = b.name = "nose";
  SessionStroke c = turn(10);
  c.name = "ear";
  const Entries groups = strokes_of_gestures({a, b, c, turn(5), a});
  ASSERT_EQ(groups.size(), 4u);
  EXPECT_EQ(groups[0].size(), 2u);
  // Pieces of one path that have names of their own were split on purpose.
  SessionStroke first{ImplicitStroke{{{0, 0, 1}, {0, 0.1, 1}}, 0.1, 0.4}};
  SessionStroke second{ImplicitStroke{{{0, 0.1, 1}, {0, 0.2, 1}}, 0.1, 0.4}};
  EXPECT_EQ(strokes_of_gestures({first, second}).size(), 1u);
  first.name = "a";
  second.name = "b";
  EXPECT_EQ(strokes_of_gestures({first, second}).size(), 2u);
  second.name = "a";
  second.strength = 0.5;
  const Entries joined = strokes_of_gestures({first, second});
  ASSERT_EQ(joined.size(), 1u);
  EXPECT_EQ(joined_strokes(joined[0]).size(), 2u) << "keys are kept";
}

// A mirrored drag: both sides, piece by piece.
std::vector<SessionStroke> mirrored_drag(std::size_t pieces) {
  std::vector<SessionStroke> strokes;
  for (std::size_t i = 0; i < pieces; ++i) {
    const auto at = [](std::size_t k) {
      const auto t = static_cast<double>(k);
      return Vec3d{0.3 + 0.1 * t, 0.02 * t * t, 0.9};
    };
    const Stroke piece = ImplicitStroke{{at(i), at(i + 1)}, 0.1, 0.4};
    strokes.push_back({piece});
    strokes.push_back({mirrored(piece, 0)});
  }
  return strokes;
}

TEST(GestureStrength, CutsEachPathAsAWhole) {
  std::vector<SessionStroke> drag = mirrored_drag(4);
  EXPECT_EQ(strength_of(drag), 1);
  set_strength(drag, 0.625);
  EXPECT_DOUBLE_EQ(strength_of(drag), 0.625);
  for (std::size_t side = 0; side < 2; ++side) {
    EXPECT_EQ(drag[side].strength, 1);
    EXPECT_EQ(drag[2 + side].strength, 1);
    EXPECT_EQ(drag[4 + side].strength, 0.5);
    EXPECT_EQ(drag[6 + side].strength, 0);
  }
  set_strength(drag, 0);
  EXPECT_EQ(strength_of(drag), 0);
  EXPECT_TRUE(replayed(drag) == ball().positions);
  set_strength(drag, 1);
  EXPECT_EQ(drag, mirrored_drag(4));
}

TEST(GestureStrength, BeyondOneEachPathGoesOnInItsLastDirection) {
  std::vector<SessionStroke> drag = mirrored_drag(4);
  double length = 0;
  for (std::size_t i = 0; i < 8; i += 2) {
    const auto& path = std::get<ImplicitStroke>(drag[i].stroke).path;
    length += norm(path[1] - path[0]);
  }
  set_strength(drag, 1.2);
  ASSERT_EQ(drag.size(), 10u);
  EXPECT_DOUBLE_EQ(strength_of(drag), 1.2);
  const auto& more = std::get<ImplicitStroke>(drag[8].stroke).path;
  EXPECT_NEAR(norm(more.back() - more.front()) * drag[8].strength, 0.2 * length, 1e-12);
  EXPECT_EQ(more[0], std::get<ImplicitStroke>(drag[6].stroke).path[1]);
  EXPECT_EQ(strokes_of_gestures(drag).size(), 1u);
  // As it comes back from its file.
  Session session;
  session.strokes = drag;
  std::vector<SessionStroke> again = parse_session(serialize_session(session), "s.knead").strokes;
  EXPECT_DOUBLE_EQ(strength_of(again), 1.2);
  set_strength(again, 1.5);
  EXPECT_EQ(again.size(), 10u);
  EXPECT_DOUBLE_EQ(strength_of(again), 1.5);
  set_strength(again, 0.5);
  EXPECT_EQ(again.size(), 8u);
  EXPECT_DOUBLE_EQ(strength_of(again), 0.5);
}

// Pieces drawn at one speed: the third is half as long as the first two.
TEST(GestureStrength, APieceOfTheDragIsNotTakenForWhatLiesBeyond) {
  std::vector<SessionStroke> drag;
  for (int i = 0; i < 4; ++i) {
    drag.push_back({ImplicitStroke{{{0, 0, 1 + 0.05 * i}, {0, 0, 1.05 + 0.05 * i}}, 0.1, 0.4}});
    EXPECT_EQ(strength_of(drag), 1) << i;
  }
  set_strength(drag, 1.5);
  EXPECT_EQ(drag.size(), 5u);
  EXPECT_DOUBLE_EQ(strength_of(drag), 1.5);
}

TEST(GestureStrength, OfOneStrokeIsItsOwn) {
  std::vector<SessionStroke> strokes{pull(0), turn(20)};
  set_strength(strokes, 1.3);
  ASSERT_EQ(strokes.size(), 2u);
  for (const SessionStroke& stroke : strokes) EXPECT_EQ(stroke.strength, 1.3);
  EXPECT_EQ(strength_of(strokes), 1.3);
}

}  // namespace
}  // namespace knead::gesture_strength_test
