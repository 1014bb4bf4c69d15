// The camera: orbit, pan, zoom, standard views, and rays through pixels.
#include "gestures/navigation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "gestures/picker.h"

namespace knead::studio::navigation_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kWidth = 800;
constexpr double kHeight = 600;

// Where a point is seen, in pixels: the perspective of knead/editor/render.h, written down once more.
std::array<double, 2> seen(const View& view, const Vec3d& p) {
  const render::Camera camera = camera_of(view);
  const render::CameraFrame frame = render::camera_frame(camera);
  const Vec3d d = p - camera.eye;
  const double distance = norm(camera.target - camera.eye);
  double scale = kHeight / camera.height;
  if (camera.projection == render::Projection::perspective) scale *= distance / dot(d, frame.forward);
  return {0.5 * kWidth * (1 + camera.shift_x) + dot(d, frame.right) * scale,
          0.5 * kHeight * (1 - camera.shift_y) - dot(d, frame.up) * scale};
}

View random_view(std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  View view;
  view.target.x = number(random);
  view.target.y = number(random);
  view.target.z = number(random);
  view.yaw = 3 * number(random);
  view.pitch = 1.5 * number(random);
  view.height = 1.5 + number(random);
  if (number(random) > 0) view.projection = render::Projection::orthographic;
  if (number(random) > 0) view.up = UpAxis::z;
  view.shift_x = 0.4 * number(random);
  view.shift_y = 0.4 * number(random);
  view.field_of_view_deg =
      0.5 * (kSmallestFieldDeg + kLargestFieldDeg) + 0.5 * (kLargestFieldDeg - kSmallestFieldDeg) * number(random);
  return view;
}

class NavigationTest : public testing::Test {
 protected:
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }

  std::mt19937 random_{5};
};

TEST_F(NavigationTest, ZoomingLeavesThePointUnderThePointerWhereItIs) {
  for (int i = 0; i < 200; ++i) {
    const View view = random_view(random_);
    const double x = 400 + 300 * number();
    const double y = 300 + 200 * number();
    const Vec3d focus = under_pointer(view, x, y, kWidth, kHeight);
    const auto before = seen(view, focus);
    EXPECT_NEAR(before[0], x, 1e-8);
    EXPECT_NEAR(before[1], y, 1e-8);
    const View nearer = zoomed(view, 1.7, focus);
    const auto after = seen(nearer, focus);
    EXPECT_NEAR(after[0], x, 1e-8);
    EXPECT_NEAR(after[1], y, 1e-8);
    EXPECT_NEAR(nearer.height, view.height / 1.7, 1e-12);
    // What is not in the plane stays as well.
    const Vec3d off = focus + Vec3d{0.05, 0.1, -0.1};
    const auto old_place = seen(view, off);
    const auto new_place = seen(zoomed(view, 1.2, off), off);
    EXPECT_NEAR(new_place[0], old_place[0], 1e-8);
    EXPECT_NEAR(new_place[1], old_place[1], 1e-8);
  }
}

TEST_F(NavigationTest, PanningCarriesThePointUnderThePointerAlong) {
  for (int i = 0; i < 200; ++i) {
    const View view = random_view(random_);
    const double dx = 100 * number();
    const double dy = 100 * number();
    const auto place = seen(panned(view, dx, dy, kHeight), under_pointer(view, 300, 200, kWidth, kHeight));
    EXPECT_NEAR(place[0], 300 + dx, 1e-8);
    EXPECT_NEAR(place[1], 200 + dy, 1e-8);
  }
}

TEST_F(NavigationTest, OrbitingKeepsTheTargetAndTheDistanceAndUpIsNeverDown) {
  for (int i = 0; i < 200; ++i) {
    const View view = random_view(random_);
    const View turned = orbited(view, 300 * number(), 900 * number(), kHeight);
    EXPECT_EQ(turned.target, view.target);
    const render::Camera camera = camera_of(turned);
    EXPECT_NEAR(norm(camera.eye - camera.target), norm(camera_of(view).eye - view.target), 1e-12);
    const Vec3d up = view.up == UpAxis::y ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
    EXPECT_GE(dot(render::camera_frame(camera).up, up), -1e-12);
    EXPECT_NEAR(dot(render::camera_frame(camera).right, up), 0, 1e-12);
  }
}

TEST_F(NavigationTest, ADragOverTheWholeHeightIsHalfATurn) {
  View view;
  view.yaw = 0;
  const View turned = orbited(view, -kHeight, 0, kHeight);
  EXPECT_NEAR(std::abs(turned.yaw), kPi, 1e-12);
  // The shape turns with the pointer: what was in front goes to the right.
  const auto before = seen(view, {0, 0, 0.5});
  const auto after = seen(orbited(view, 50, 0, kHeight), {0, 0, 0.5});
  EXPECT_GT(after[0], before[0] + 10);
  EXPECT_GT(seen(orbited(view, 0, 50, kHeight), {0, 0, 0.5})[1], before[1] + 10);
}

TEST_F(NavigationTest, StandardViewsLookAlongTheAxes) {
  const auto forward = [](UpAxis up, StandardView side) {
    View view;
    view.up = up;
    return render::camera_frame(camera_of(seen_from(view, side)));
  };
  const auto near = [](const Vec3d& a, const Vec3d& b) { return norm(a - b) < 1e-12; };
  EXPECT_TRUE(near(forward(UpAxis::y, StandardView::front).forward, {0, 0, -1}));
  EXPECT_TRUE(near(forward(UpAxis::y, StandardView::back).forward, {0, 0, 1}));
  EXPECT_TRUE(near(forward(UpAxis::y, StandardView::right).forward, {-1, 0, 0}));
  EXPECT_TRUE(near(forward(UpAxis::y, StandardView::left).forward, {1, 0, 0}));
  EXPECT_TRUE(near(forward(UpAxis::y, StandardView::top).forward, {0, -1, 0}));
  EXPECT_TRUE(near(forward(UpAxis::y, StandardView::bottom).forward, {0, 1, 0}));
  EXPECT_TRUE(near(forward(UpAxis::z, StandardView::front).forward, {0, 1, 0}));
  EXPECT_TRUE(near(forward(UpAxis::z, StandardView::top).up, {0, 1, 0}));
  for (const StandardView side : {StandardView::front, StandardView::top, StandardView::bottom}) {
    EXPECT_TRUE(near(forward(UpAxis::y, side).right, {1, 0, 0}));
  }
}

TEST_F(NavigationTest, RaysAndPixelsAreEachOthersInverse) {
  for (int i = 0; i < 500; ++i) {
    const View view = random_view(random_);
    const Screen screen{camera_of(view), static_cast<int>(kWidth), static_cast<int>(kHeight)};
    const double x = 400 + 400 * number();
    const double y = 300 + 300 * number();
    const Ray ray = ray_through(screen, x, y);
    EXPECT_NEAR(norm(ray.direction), 1, 1e-12);
    // From just before the eye to far behind the target.
    const Vec3d p = ray.origin + ray.direction * (view.height * (1.1 + number()));
    const auto pixel = pixel_of(screen, p);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x, x, 1e-6);
    EXPECT_NEAR(pixel->y, y, 1e-6);
    const auto known = seen(view, p);
    EXPECT_NEAR(known[0], x, 1e-6);
    EXPECT_NEAR(known[1], y, 1e-6);
    // A step of pixel_size across the view is a pixel.
    const Vec3d aside = p + render::camera_frame(screen.camera).right * pixel_size(screen, p);
    EXPECT_NEAR(pixel_of(screen, aside)->x, x + 1, 1e-6);
  }
}

TEST_F(NavigationTest, WhatIsBehindTheEyeHasNoPixelInPerspective) {
  View view;
  const render::Camera camera = camera_of(view);
  const Vec3d behind = camera.eye * 2.0 - camera.target;
  EXPECT_FALSE(pixel_of({camera, 800, 600}, behind));
  view.projection = render::Projection::orthographic;
  EXPECT_TRUE(pixel_of({camera_of(view), 800, 600}, behind));
}

TEST_F(NavigationTest, TheFieldOfViewChangesTheDepthOfThePictureOnly) {
  for (int i = 0; i < 100; ++i) {
    View view = random_view(random_);
    view.projection = render::Projection::perspective;
    const auto before = seen(view, view.target);
    const Vec3d right = render::camera_frame(camera_of(view)).right;
    const auto aside = seen(view, view.target + right * (0.2 * view.height));
    view.field_of_view_deg = 20;
    EXPECT_NEAR(seen(view, view.target)[0], before[0], 1e-8);
    EXPECT_NEAR(seen(view, view.target + right * (0.2 * view.height))[0], aside[0], 1e-8);
    const double distance = norm(camera_of(view).eye - view.target);
    EXPECT_NEAR(2 * distance * std::tan(10 * kPi / 180), view.height, 1e-9);
  }
}

TEST_F(NavigationTest, FramingShowsTheWholeBoxAndNotMuchMore) {
  for (int i = 0; i < 200; ++i) {
    Box box;
    for (int k = 0; k < 3; ++k) {
      const double x = 5 * number();
      const double y = 5 * number();
      box.extend({x, y, 5 * number()});
    }
    const View view = framed(random_view(random_), box, {800, 600});
    double nearest = kWidth;  // to the rim of the picture
    for (int k = 0; k < 8; ++k) {
      const Vec3d corner{(k & 1) != 0 ? box.min.x : box.max.x, (k & 2) != 0 ? box.min.y : box.max.y,
                         (k & 4) != 0 ? box.min.z : box.max.z};
      const auto [x, y] = seen(view, corner);
      nearest = std::min({nearest, x, kWidth - x, y, kHeight - y});
    }
    EXPECT_GT(nearest, 0);
    EXPECT_LT(nearest, 0.25 * kHeight);
  }
  EXPECT_GT(framed({}, {}, {}).height, 0);
}

TEST_F(NavigationTest, FramingKeepsOutOfWhatPanelsCover) {
  const Picture picture{800, 600, {60, 30, 320, 25}};
  for (int i = 0; i < 200; ++i) {
    Box box;
    for (int k = 0; k < 3; ++k) {
      const double x = 5 * number();
      const double y = 5 * number();
      box.extend({x, y, 5 * number()});
    }
    const View view = framed(random_view(random_), box, picture);
    Box filled;
    for (int k = 0; k < 8; ++k) {
      const Vec3d corner{(k & 1) != 0 ? box.min.x : box.max.x, (k & 2) != 0 ? box.min.y : box.max.y,
                         (k & 4) != 0 ? box.min.z : box.max.z};
      const auto [x, y] = seen(view, corner);
      filled.extend({x, y, 0});
    }
    EXPECT_GT(filled.min.x, 60);
    EXPECT_LT(filled.max.x, 800 - 320);
    EXPECT_GT(filled.min.y, 30);
    EXPECT_LT(filled.max.y, 600 - 25);
    EXPECT_NEAR(filled.center().x, 60 + 0.5 * 420, 2);
    EXPECT_NEAR(filled.center().y, 30 + 0.5 * 545, 2);
    const double fills = std::max((filled.max.x - filled.min.x) / 420, (filled.max.y - filled.min.y) / 545);
    EXPECT_NEAR(fills, 0.84, 0.01) << "8% stay free at each side";
  }
}

// The lens is shifted beside panels, and not the eye: the face of a box hides its sides.
TEST_F(NavigationTest, AFrontViewIsFrontalBesidePanels) {
  const Box box{{-1, -2, -0.5}, {3, 1, 0.5}};
  for (const render::Projection projection : {render::Projection::perspective, render::Projection::orthographic}) {
    View view = seen_from({}, StandardView::front);
    view.projection = projection;
    const render::Camera camera = camera_of(framed(view, box, {800, 600, {60, 30, 320, 25}}));
    EXPECT_NEAR(camera.eye.x, 1, 1e-9);
    EXPECT_NEAR(camera.eye.y, -0.5, 1e-9);
    EXPECT_LT(camera.shift_x, -0.2);
  }
}

TEST_F(NavigationTest, WhatIsTurnedAboutStaysWhereItIsSeen) {
  for (int i = 0; i < 200; ++i) {
    const View view = random_view(random_);
    const Vec3d pivot = view.target + Vec3d{0.1, 0.2, -0.15};
    const auto before = seen(view, pivot);
    const auto after = seen(keeping(pivot, view, orbited(view, 300 * number(), 300 * number(), kHeight)), pivot);
    EXPECT_NEAR(after[0], before[0], 1e-8);
    EXPECT_NEAR(after[1], before[1], 1e-8);
  }
}

TEST_F(NavigationTest, PresetsSayWhatAButtonDoes) {
  using enum NavigationDrag;
  const Modifiers shift{true, false, false};
  const Modifiers ctrl{false, true, false};
  const Modifiers alt{false, false, true};
  const auto blender = [](MouseButton button, const Modifiers& held) {
    return drag_of(NavigationPreset::blender, button, held);
  };
  EXPECT_EQ(blender(MouseButton::middle, {}), orbit);
  EXPECT_EQ(blender(MouseButton::middle, shift), pan);
  EXPECT_EQ(blender(MouseButton::middle, ctrl), zoom);
  EXPECT_EQ(blender(MouseButton::left, alt), orbit);
  EXPECT_EQ(blender(MouseButton::left, {}), none);
  EXPECT_EQ(blender(MouseButton::left, ctrl), none);
  EXPECT_EQ(blender(MouseButton::right, {}), none);
  const auto maya = [](MouseButton button, const Modifiers& held) {
    return drag_of(NavigationPreset::maya, button, held);
  };
  EXPECT_EQ(maya(MouseButton::left, alt), orbit);
  EXPECT_EQ(maya(MouseButton::middle, alt), pan);
  EXPECT_EQ(maya(MouseButton::right, alt), zoom);
  EXPECT_EQ(maya(MouseButton::middle, {}), none);
}

TEST_F(NavigationTest, OnlyEventsOfADragThatMovesTheViewAreTaken) {
  Navigation navigation;
  EXPECT_FALSE(navigate(navigation, Resized{800, 600}));
  const View start = navigation.view;
  EXPECT_FALSE(navigate(navigation, PointerMoved{100, 100}));
  EXPECT_FALSE(navigate(navigation, ButtonChanged{MouseButton::left, true, 100, 100}));
  EXPECT_FALSE(navigate(navigation, PointerMoved{150, 100}));
  EXPECT_FALSE(navigate(navigation, ButtonChanged{MouseButton::left, false, 150, 100}));
  EXPECT_EQ(navigation.view, start);
  EXPECT_TRUE(navigate(navigation, ButtonChanged{MouseButton::middle, true, 150, 100}));
  // The button of a tool during the drag is not the drag's end.
  EXPECT_FALSE(navigate(navigation, ButtonChanged{MouseButton::left, false, 150, 100}));
  EXPECT_TRUE(navigate(navigation, PointerMoved{200, 100}));
  EXPECT_EQ(navigation.view, orbited(start, 50, 0, 600));
  EXPECT_TRUE(navigate(navigation, ButtonChanged{MouseButton::middle, false, 200, 100}));
  EXPECT_FALSE(navigate(navigation, PointerMoved{300, 100}));
  EXPECT_FALSE(navigate(navigation, WheelTurned{1, {true, false, false}}));
  const double height = navigation.view.height;
  EXPECT_TRUE(navigate(navigation, WheelTurned{2}));
  EXPECT_LT(navigation.view.height, height);
  EXPECT_FALSE(navigate(navigation, KeyChanged{"Home", true}));
}

}  // namespace
}  // namespace knead::studio::navigation_test
