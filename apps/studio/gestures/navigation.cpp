#include "gestures/navigation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace knead::studio {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kZoomPerStep = 1.15;
constexpr double kZoomPerHeight = 8;  // of a drag over the whole height
constexpr double kSmallestHeight = 1e-9;
constexpr double kLargestHeight = 1e12;

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
      view = orbited_about(view, navigation.pivot.value_or(view.target), dx, dy, height);
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

View framed(const View& view, const Box& box, double aspect) {
  const Axes axes = axes_of(view);
  const render::FitOptions options{view.projection, view.field_of_view_deg, 0.08};
  const render::Camera camera = render::fit_camera(box, -axes.back, camera_of(view).up, aspect, options);
  View result = view;
  result.target = camera.target;
  result.height = std::clamp(camera.height, kSmallestHeight, kLargestHeight);
  return result;
}

View orbited(const View& view, double dx, double dy, double picture_height) {
  View result = view;
  result.yaw = std::remainder(view.yaw - dx * kPi / picture_height, 2 * kPi);
  result.pitch = std::clamp(view.pitch + dy * kPi / picture_height, -kPi / 2, kPi / 2);
  return result;
}

View orbited_about(const View& view, const Vec3d& pivot, double dx, double dy, double picture_height) {
  View result = orbited(view, dx, dy, picture_height);
  const Axes before = axes_of(view);
  const Axes after = axes_of(result);
  const Vec3d d = view.target - pivot;
  result.target =
      pivot + after.right * dot(d, before.right) + after.up * dot(d, before.up) + after.back * dot(d, before.back);
  return result;
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
