// Moving about the shape with the pointer, as plain functions over events.
#pragma once

#include <optional>

#include "knead/editor/render.h"
#include "knead/vec.h"
#include "platform/window.h"

namespace knead::studio {

// The axis that points up. Seen from the front, x is to the right. y up: z points to the viewer; z up: y away from it.
enum class UpAxis { y, z };

// The place of the viewer. A turntable: up stays up.
struct View {
  Vec3d target;
  double yaw = 0.45;    // radians about up; 0: from the front, positive: from the right
  double pitch = 0.30;  // radians above the horizon, from -pi/2 to pi/2
  double height = 2;    // units from the bottom of the picture to its top, in the plane through the target; > 0
  render::Projection projection = render::Projection::perspective;
  double field_of_view_deg = 30;  // from bottom to top, in perspective; from kSmallestFieldDeg to kLargestFieldDeg
  UpAxis up = UpAxis::y;
  double shift_x = 0;  // render::Camera's: the target is seen in the middle between the panels
  double shift_y = 0;

  friend bool operator==(const View&, const View&) = default;
};

inline constexpr double kSmallestFieldDeg = 5;
inline constexpr double kLargestFieldDeg = 100;

render::Camera camera_of(const View& view);

enum class StandardView { front, back, right, left, top, bottom };
View seen_from(const View& view, StandardView side);

View toggled_projection(const View& view);

// The parts of the picture that panels cover at each side, in pixels.
struct Margins {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;

  friend bool operator==(const Margins&, const Margins&) = default;
};

// A picture and its free part, between the panels.
struct Picture {
  int width = 1;  // pixels
  int height = 1;
  Margins covered{};
};

// Returns the view that shows the whole box in the middle of the free part of the picture, which has at least a quarter
// of its width and height. The lens is shifted there, so that a front view is frontal. An empty box counts as the unit
// cube.
View framed(const View& view, const Box& box, const Picture& picture);

// Returns `after` with its target moved so that the point is seen where `before` shows it. Both have the same height.
View keeping(const Vec3d& point, const View& before, const View& after);

// Returns the view turned by a drag of that many pixels: half a turn for the height of the picture.
View orbited(const View& view, double dx, double dy, double picture_height);

// Returns the view turned about a point, which keeps its place in the picture.
View orbited_about(const View& view, const Vec3d& pivot, double dx, double dy, double picture_height);

// Returns the view moved so that the plane through the target follows the pointer.
View panned(const View& view, double dx, double dy, double picture_height);

// Returns the view nearer by the factor (farther for factor < 1) to `focus`, which keeps its place in the picture.
View zoomed(const View& view, double factor, const Vec3d& focus);

// Returns the point under the pointer in the plane through the target.
Vec3d under_pointer(const View& view, double x, double y, double width, double height);

enum class NavigationPreset { blender, maya };
enum class NavigationDrag { none, orbit, pan, zoom };

// Returns the effect of a drag with this button. Blender: middle orbits, with Shift it pans, with Ctrl it zooms;
// Alt+left orbits, Alt+Shift+left pans, for touchpads. Maya: with Alt, left orbits, middle pans, right zooms.
NavigationDrag drag_of(NavigationPreset preset, MouseButton button, const Modifiers& modifiers);

// The view with the drag that changes it.
struct Navigation {
  NavigationPreset preset = NavigationPreset::blender;
  View view;
  int width = 1;  // of the picture, pixels
  int height = 1;
  Margins covered{};
  std::optional<Vec3d> home{};  // the middle of the box that was framed last
  double x = 0;                 // of the pointer
  double y = 0;
  NavigationDrag drag = NavigationDrag::none;
  MouseButton button = MouseButton::left;  // that drags
  std::optional<Vec3d> pivot{};            // about which the view turns; nothing: home, or the target
};

// Lets a button that was pressed turn the view until it is released, whatever the preset says.
void begin_orbit(Navigation& navigation, const ButtonChanged& button);

// Applies an event to the view. Returns true for events that concern the view alone: buttons and movements of a drag of
// the view, and the wheel without modifiers, which zooms towards the pointer. Also notes the size of a Resized.
bool navigate(Navigation& navigation, const Event& event);

}  // namespace knead::studio
