// Tools in the interactive picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "support/live_view_fixture.h"

namespace knead::render::live_tools_test {
namespace {

class LiveToolsTest : public LiveViewTest {};

TEST_F(LiveToolsTest, InfluenceIsRedWithinAndGreenAround) {
  const Mesh ball = sphere({}, 1, 10242);
  LiveScene scene = scene_of(ball);
  const Image bare = picture_of(ball, scene);
  std::vector<float> influence;
  for (const Vec3d& p : ball.positions) {
    influence.push_back(static_cast<float>(std::clamp(1.6 - 2 * std::hypot(p.x, p.y), 0.0, 1.0)));
  }
  view_->set_influence(influence);
  EXPECT_EQ(picture(scene), bare);
  scene.show_influence = true;
  const Image shown = picture(scene);
  const Pixel middle = at(shown, kWidth / 2, kHeight / 2);
  EXPECT_GT(middle.red, middle.green + 40);
  const Pixel around = at(shown, kWidth / 2 + 45, kHeight / 2);
  EXPECT_GT(around.green, around.red + 10);
  EXPECT_EQ(at(shown, kWidth / 2 + 75, kHeight / 2).red, at(bare, kWidth / 2 + 75, kHeight / 2).red);
  view_->set_influence({});
  EXPECT_EQ(picture(scene), bare);
  EXPECT_THROW(view_->set_influence(std::array{1.0f}), InvalidInput);
}

TEST_F(LiveToolsTest, GlassTintsWhereItIsProjected) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball);
  const Image bare = picture_of(ball, scene);
  scene.surfaces.push_back({sphere({0.4, 0, 1}, 0.3), kInnerRed});
  const Image red = picture(scene);
  const double scale = kHeight / scene.camera.height;
  const int x = kWidth / 2 + static_cast<int>(0.4 * scale);
  EXPECT_GT(at(red, x, 100).red - at(red, x, 100).green, at(bare, x, 100).red - at(bare, x, 100).green + 20);
  EXPECT_EQ(at(red, kWidth / 2 - 40, 100).red, at(bare, kWidth / 2 - 40, 100).red);
  const double disc = std::numbers::pi * 0.3 * 0.3 * scale * scale;
  EXPECT_NEAR(different_pixels(bare, red), disc, 0.08 * disc);
  // It follows when it moves, is hidden by the shape, and is gone when it is taken away.
  scene.surfaces[0].mesh = sphere({-0.4, 0, 1}, 0.3);
  const Image moved = picture(scene);
  EXPECT_EQ(at(moved, x, 100).red, at(bare, x, 100).red);
  EXPECT_NEAR(different_pixels(bare, moved), disc, 0.08 * disc);
  scene.surfaces[0].mesh = sphere({}, 0.5);
  EXPECT_EQ(different_pixels(bare, picture(scene)), 0);
  scene.surfaces.clear();
  EXPECT_EQ(picture(scene), bare);
}

TEST_F(LiveToolsTest, NestedGlassDoesNotDependOnItsOrder) {
  const Mesh ball = sphere({}, 0.3);
  const Mesh frame = sphere({}, 1);
  LiveScene scene = scene_of(frame);
  scene.surfaces = {{sphere({}, 0.5), kInnerRed}, {sphere({}, 0.9), kOuterGreen}};
  const Image image = picture_of(ball, scene);
  std::swap(scene.surfaces[0], scene.surfaces[1]);
  EXPECT_LE(largest_difference(picture(scene), image), 1);
}

TEST_F(LiveToolsTest, RodsShineThroughAndCoverInFront) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball);
  const Pixel bare = at(picture_of(ball, scene), kWidth / 2, 100);
  scene.arrows.push_back({{-0.5, 0, 0}, {0.5, 0, 0}, 0.06, {0, 0, 1, 1}});
  const Pixel hidden = at(picture(scene), kWidth / 2, 100);
  EXPECT_LT(hidden.red, bare.red - 10);
  scene.arrows.clear();
  scene.lines.push_back({{{-0.5, 0, 1.2}, {0.5, 0, 1.2}}, 0.06, false, {0, 0, 1, 1}});
  const Pixel shown = at(picture(scene), kWidth / 2, 100);
  EXPECT_LT(shown.red, hidden.red);
  EXPECT_GT(shown.blue, 120);
  const Image round = picture(scene);
  scene.lines[0].round = false;
  const Image blunt = picture(scene);
  EXPECT_EQ(at(blunt, kWidth / 2, 100).red, shown.red);
  EXPECT_GT(largest_difference(blunt, round), 10) << "at its ends";
}

TEST_F(LiveToolsTest, CutIsClosedAndInItsColor) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball);
  const Image whole = picture_of(ball, scene);
  scene.clip = Clip{{0, 0, 2}, 0, {1, 0, 0, 1}};  // the half before z = 0
  const Image cut = picture(scene);
  const Pixel middle = at(cut, kWidth / 2, 100);
  EXPECT_GT(middle.red, middle.green + 80);
  EXPECT_NEAR(middle.red, at(cut, kWidth / 2 - 40, 100).red, 2);
  EXPECT_TRUE(is_background(at(cut, 3, 3)));
  scene.clip->normal = {0, 0, -1};  // the half behind: the cut is out of sight
  EXPECT_EQ(picture(scene), whole);
  scene.clip = Clip{{0, 0, 1}, 1.5, {}};  // beside the shape
  EXPECT_EQ(picture(scene), whole);
  scene.clip->normal = {0, 0, 0};
  EXPECT_THROW(picture(scene), InvalidInput);
}

TEST_F(LiveToolsTest, CutsLeaveToolsWhole) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball);
  scene.clip = Clip{{0, 0, 1}, 0, {1, 0, 0, 1}};
  scene.surfaces.push_back({sphere({0, 0, 1}, 0.5), {0, 1, 0, 0.5f}});
  const Image image = picture_of(ball, scene);
  const Pixel glass = at(image, kWidth / 2, 90);
  EXPECT_GT(glass.green, glass.blue + 50);
}

}  // namespace
}  // namespace knead::render::live_tools_test
