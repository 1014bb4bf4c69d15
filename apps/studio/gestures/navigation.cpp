// The camera: turntable, pan, zoom, standard views.
#include "gestures/navigation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <variant>

#include "gestures/picker.h"

namespace knead::studio {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kZoomPerStep = 1.15;
constexpr double kZoomPerHeight = 8;  // of a drag over the whole height
constexpr double kSmallestHeight = 1e-9;
constexpr double kLargestHeight = 1e12;
constexpr double kFramingMargin = 0.08;  // of the free part of the picture, at each side
constexpr double kMinFree = 0.25;        // of the picture
constexpr int kHalvings = 60;            // of an interval, down to rounding
constexpr Box kUnitCube{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};

// The axes of the turntable.
struct Turntable {
  Vec3d right;
  Vec3d up;
  Vec3d front;  // towards a viewer in front of the shape
};

Turntable turntable(UpAxis up) {
  if (up == UpAxis::z) return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
  return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

// Unit vectors of the picture.
struct Axes {
  Vec3d right;
  Vec3d up;
  Vec3d back;  // towards the viewer
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

// The corners of a box along the axes of the picture.
std::array<Vec3d, 8> corners_along(const Axes& axes, const Box& box) {
  std::array<Vec3d, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3d p = box.corner(i);
    corners[i] = {dot(p, axes.right), dot(p, axes.up), dot(p, axes.back)};
  }
  return corners;
}

// Returns the least distance of the eye, along z, from which all corners are within `reach` of the line of sight, a
// tangent of an angle: a corner at (a, z) appears at (a - eye) / (distance - z).
double distance_to_fit(const std::array<Vec3d, 8>& corners, double Vec3d::*axis, double reach) {
  double most = -HUGE_VAL;
  double least = HUGE_VAL;
  for (const Vec3d& corner : corners) {
    most = std::max(most, corner.*axis + reach * corner.z);
    least = std::min(least, corner.*axis - reach * corner.z);
  }
  return (most - least) / (2 * reach);
}

// Returns the place of the eye along an axis for which all corners are within `reach` on both sides of the line of
// sight.
double eye_in_middle(const std::array<Vec3d, 8>& corners, double Vec3d::*axis, double reach, double distance) {
  const auto [low, high] = std::minmax_element(corners.begin(), corners.end(),
                                               [axis](const Vec3d& a, const Vec3d& b) { return a.*axis < b.*axis; });
  double least = (*low).*axis;
  double most = (*high).*axis;
  for (const Vec3d& corner : corners) {
    least = std::min(least, corner.*axis - reach * (distance - corner.z));
    most = std::max(most, corner.*axis + reach * (distance - corner.z));
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double eye = 0.5 * (least + most);
    double seen_least = HUGE_VAL;
    double seen_most = -HUGE_VAL;
    for (const Vec3d& corner : corners) {
      const double seen = (corner.*axis - eye) / (distance - corner.z);
      seen_least = std::min(seen_least, seen);
      seen_most = std::max(seen_most, seen);
    }
    (seen_least + seen_most > 0 ? least : most) = eye;
  }
  return 0.5 * (least + most);
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
  // In a view straight from above, the world's up axis no longer determines the up direction of the picture.
  camera.up = std::abs(view.pitch) > 0.49 * kPi ? axes.up : turntable(view.up).up;
  camera.height = view.height;
  camera.shift_x = view.shift_x;
  camera.shift_y = view.shift_y;
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
  const double free_width = std::max<double>(width - covered.left - covered.right, kMinFree * width);
  const double free_height = std::max<double>(height - covered.top - covered.bottom, kMinFree * height);
  // From the middle of the picture to the middle of the free part, upwards.
  const double x = std::min(covered.left, picture.width) + 0.5 * (free_width - width);
  const double y = 0.5 * (height - free_height) - std::min(covered.top, picture.height);
  const double half_width = (0.5 - kFramingMargin) * free_width;
  const double half_height = (0.5 - kFramingMargin) * free_height;
  const Axes axes = axes_of(view);
  const Box shown = box.empty() ? kUnitCube : box;
  const std::array<Vec3d, 8> corners = corners_along(axes, shown);
  const Vec3d middle{dot(shown.center(), axes.right), dot(shown.center(), axes.up), dot(shown.center(), axes.back)};
  View result = view;
  result.shift_x = 2 * x / width;
  result.shift_y = 2 * y / height;
  if (view.projection == render::Projection::orthographic) {
    Box seen;
    for (const Vec3d& corner : corners) seen.extend(corner);
    const Vec3d size = seen.max - seen.min;
    const double pixel = std::max(size.x / (2 * half_width), size.y / (2 * half_height));
    result.height = std::clamp(pixel * height, kSmallestHeight, kLargestHeight);
    result.target = shown.center();
    return result;
  }
  const double pixel = 2 * std::tan(0.5 * view.field_of_view_deg * std::numbers::pi / 180) / height;
  const double across = pixel * half_width;
  const double upwards = pixel * half_height;
  const double fits =
      std::max(distance_to_fit(corners, &Vec3d::x, across), distance_to_fit(corners, &Vec3d::y, upwards));
  result.height = std::clamp(pixel * height * (fits - middle.z), kSmallestHeight, kLargestHeight);
  const double distance = middle.z + result.height / (pixel * height);
  result.target = axes.right * eye_in_middle(corners, &Vec3d::x, across, distance) +
                  axes.up * eye_in_middle(corners, &Vec3d::y, upwards, distance) + axes.back * middle.z;
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
  return view.target + axes.right * ((x - 0.5 * width * (1 + view.shift_x)) * scale) -
         axes.up * ((y - 0.5 * height * (1 - view.shift_y)) * scale);
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

void begin_orbit(Navigation& navigation, const ButtonChanged& button) {
  navigation.x = button.x;
  navigation.y = button.y;
  navigation.drag = NavigationDrag::orbit;
  navigation.button = button.button;
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
