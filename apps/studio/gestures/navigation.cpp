#include "gestures/navigation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "gestures/screen.h"

namespace knead::studio {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kZoomPerStep = 1.15;
constexpr double kZoomPerHeight = 8;  // of a drag over the whole height
constexpr double kSmallestHeight = 1e-9;
constexpr double kLargestHeight = 1e12;
constexpr double kFramingMargin = 0.08;  // of the free part of the picture, at each side
constexpr double kLeastFree = 0.25;      // of the picture
constexpr int kFramingRounds = 12;       // each halves what is wrong, or better
constexpr Box kUnitCube{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};

// The axes of the turntable.
struct Turntable {
  Vec3d right;
  Vec3d up;
  Vec3d front;  // towards a person who looks from the front
};

Turntable turntable(UpAxis up) {
  if (up == UpAxis::z) return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
  return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

// Unit vectors of the picture.
struct Axes {
  Vec3d right;
  Vec3d up;
  Vec3d back;  // towards the person
};

Axes axes_of(const View& view) {
  const Turntable table = turntable(view.up);
  const Vec3d level = table.front * std::cos(view.yaw) + table.right * std::sin(view.yaw);
  const Vec3d right = table.right * std::cos(view.yaw) - table.front * std::sin(view.yaw);
  const Vec3d back = level * std::cos(view.pitch) + table.up * std::sin(view.pitch);
  const Vec3d up = table.up * std::cos(view.pitch) - level * std::sin(view.pitch);
  return {right, up, back};
}

double distance_of(const View& view) { return view.height / (2 * std::tan(view.field_of_view_deg * kPi / 360)); }

// The rectangle that a box fills in the picture, in pixels: its middle and its size.
struct SeenBox {
  double x;
  double y;
  double width;
  double height;
};

// Nothing where a corner is behind the eye.
std::optional<SeenBox> seen_box(const Screen& screen, const Box& box) {
  Box seen;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                  (corner & 4) != 0 ? box.max.z : box.min.z};
    const std::optional<Pixel> pixel = pixel_of(screen, p);
    if (!pixel) return std::nullopt;
    seen.extend({pixel->x, pixel->y, 0});
  }
  return SeenBox{seen.center().x, seen.center().y, seen.max.x - seen.min.x, seen.max.y - seen.min.y};
}

bool start_drag(Navigation& navigation, const ButtonChanged& event) {
  navigation.x = event.x;
  navigation.y = event.y;
  if (event.down && navigation.drag == NavigationDrag::none) {
    navigation.drag = drag_of(navigation.preset, event.button, event.modifiers);
    navigation.button = event.button;
    return navigation.drag != NavigationDrag::none;
  }
  if (event.down || event.button != navigation.button) return false;
  const bool dragged = navigation.drag != NavigationDrag::none;
  navigation.drag = NavigationDrag::none;
  return dragged;
}

bool move(Navigation& navigation, const PointerMoved& event) {
  const double dx = event.x - navigation.x;
  const double dy = event.y - navigation.y;
  navigation.x = event.x;
  navigation.y = event.y;
  View& view = navigation.view;
  const double height = navigation.height;
  switch (navigation.drag) {
    case NavigationDrag::none:
      return false;
    case NavigationDrag::orbit:
      view = orbited_about(view, navigation.pivot.value_or(navigation.home.value_or(view.target)), dx, dy, height);
      break;
    case NavigationDrag::pan:
      view = panned(view, dx, dy, height);
      break;
    case NavigationDrag::zoom:
      view = zoomed(view, std::pow(kZoomPerHeight, (dx - dy) / height), view.target);
      break;
  }
  return true;
}

bool turn_wheel(Navigation& navigation, const WheelTurned& event) {
  if (!(event.modifiers == Modifiers{})) return false;
  const Vec3d focus = under_pointer(navigation.view, navigation.x, navigation.y, navigation.width, navigation.height);
  navigation.view = zoomed(navigation.view, std::pow(kZoomPerStep, event.steps), focus);
  return true;
}

}  // namespace

render::Camera camera_of(const View& view) {
  const Axes axes = axes_of(view);
  render::Camera camera;
  camera.projection = view.projection;
  camera.target = view.target;
  camera.eye = view.target + axes.back * distance_of(view);
  // Seen straight from above, what is up in the picture is no longer told by what is up in the world.
  camera.up = std::abs(view.pitch) > 0.49 * kPi ? axes.up : turntable(view.up).up;
  camera.height = view.height;
  return camera;
}

View seen_from(const View& view, StandardView side) {
  View result = view;
  result.pitch = 0;
  switch (side) {
    case StandardView::front:
      result.yaw = 0;
      break;
    case StandardView::back:
      result.yaw = kPi;
      break;
    case StandardView::right:
      result.yaw = kPi / 2;
      break;
    case StandardView::left:
      result.yaw = -kPi / 2;
      break;
    case StandardView::top:
      result.yaw = 0;
      result.pitch = kPi / 2;
      break;
    case StandardView::bottom:
      result.yaw = 0;
      result.pitch = -kPi / 2;
      break;
  }
  return result;
}

View toggled_projection(const View& view) {
  View result = view;
  const bool perspective = view.projection == render::Projection::perspective;
  result.projection = perspective ? render::Projection::orthographic : render::Projection::perspective;
  return result;
}

View framed(const View& view, const Box& box, const Picture& picture) {
  const double width = picture.width;
  const double height = picture.height;
  const Margins& covered = picture.covered;
  const double free_width = std::max<double>(width - covered.left - covered.right, kLeastFree * width);
  const double free_height = std::max<double>(height - covered.top - covered.bottom, kLeastFree * height);
  const double x = std::min(covered.left, picture.width) + 0.5 * free_width;
  const double y = std::min(covered.top, picture.height) + 0.5 * free_height;
  const Axes axes = axes_of(view);
  const render::FitOptions options{view.projection, view.field_of_view_deg, kFramingMargin};
  const render::Camera camera = render::fit_camera(box, -axes.back, camera_of(view).up, width / height, options);
  View result = view;
  result.target = camera.target;
  result.height = std::clamp(camera.height, kSmallestHeight, kLargestHeight);
  // Perspective shows a box beside the middle of the picture at another size than in the middle.
  for (int i = 0; i < kFramingRounds; ++i) {
    const Screen screen{camera_of(result), picture.width, picture.height};
    const std::optional<SeenBox> seen = seen_box(screen, box.empty() ? kUnitCube : box);
    if (!seen) {
      result.height = std::min(2 * result.height, kLargestHeight);
      continue;
    }
    result = panned(result, x - seen->x, y - seen->y, height);
    const double free = 1 - 2 * kFramingMargin;
    const double grows = std::min(free * free_width / seen->width, free * free_height / seen->height);
    if (std::isfinite(grows) && grows > 0) {
      result = zoomed(result, grows, under_pointer(result, x, y, width, height));
    }
  }
  return result;
}

View keeping(const Vec3d& point, const View& before, const View& after) {
  const Vec3d from = before.target - point;
  const Axes old = axes_of(before);
  const Axes now = axes_of(after);
  View result = after;
  result.target =
      point + now.right * dot(from, old.right) + now.up * dot(from, old.up) + now.back * dot(from, old.back);
  return result;
}

View orbited(const View& view, double dx, double dy, double picture_height) {
  View result = view;
  result.yaw = std::remainder(view.yaw - dx * kPi / picture_height, 2 * kPi);
  result.pitch = std::clamp(view.pitch + dy * kPi / picture_height, -kPi / 2, kPi / 2);
  return result;
}

View orbited_about(const View& view, const Vec3d& pivot, double dx, double dy, double picture_height) {
  return keeping(pivot, view, orbited(view, dx, dy, picture_height));
}

View panned(const View& view, double dx, double dy, double picture_height) {
  const Axes axes = axes_of(view);
  const double scale = view.height / picture_height;
  View result = view;
  result.target = view.target - axes.right * (dx * scale) + axes.up * (dy * scale);
  return result;
}

View zoomed(const View& view, double factor, const Vec3d& focus) {
  const double height = std::clamp(view.height / factor, kSmallestHeight, kLargestHeight);
  View result = view;
  result.target = focus + (view.target - focus) * (height / view.height);
  result.height = height;
  return result;
}

Vec3d under_pointer(const View& view, double x, double y, double width, double height) {
  const Axes axes = axes_of(view);
  const double scale = view.height / height;
  return view.target + axes.right * ((x - 0.5 * width) * scale) - axes.up * ((y - 0.5 * height) * scale);
}

NavigationDrag drag_of(NavigationPreset preset, MouseButton button, const Modifiers& modifiers) {
  if (preset == NavigationPreset::maya) {
    if (!modifiers.alt) return NavigationDrag::none;
    if (button == MouseButton::left) return NavigationDrag::orbit;
    return button == MouseButton::middle ? NavigationDrag::pan : NavigationDrag::zoom;
  }
  if (button == MouseButton::right || (button == MouseButton::left && !modifiers.alt)) return NavigationDrag::none;
  if (modifiers.shift) return NavigationDrag::pan;
  return modifiers.ctrl ? NavigationDrag::zoom : NavigationDrag::orbit;
}

bool navigate(Navigation& navigation, const Event& event) {
  if (const auto* button = std::get_if<ButtonChanged>(&event)) return start_drag(navigation, *button);
  if (const auto* moved = std::get_if<PointerMoved>(&event)) return move(navigation, *moved);
  if (const auto* wheel = std::get_if<WheelTurned>(&event)) return turn_wheel(navigation, *wheel);
  if (const auto* size = std::get_if<Resized>(&event)) {
    navigation.width = std::max(size->width, 1);
    navigation.height = std::max(size->height, 1);
  }
  return false;
}

}  // namespace knead::studio
