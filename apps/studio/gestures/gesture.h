// Turns the movement of the pointer between press and release into strokes. Needs no window.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gestures/gizmo.h"
#include "gestures/picker.h"
#include "gestures/screen.h"
#include "gestures/tools.h"
#include "platform/event.h"

namespace knead::studio {

// Returns what a ray hits, if there is no picker for it.
using HitTest = std::function<std::optional<SurfaceHit>(const Ray& ray)>;

struct Pointer {
  double x = 0;  // pixels, as in Screen
  double y = 0;
  double pressure = 1;
  Modifiers modifiers{};
};

// What a gesture depends on at one moment.
struct Surroundings {
  Screen screen;
  const ShapeState& state;         // the shape as it was when the gesture began
  const Picker* picker = nullptr;  // fits the state; null: nothing can be hit yet
  const ToolSettings& settings;
  bool is_taken = true;  // the last version of the gesture is being computed; false: it waits, and may change
  HitTest hit_test{};    // if not empty, used instead of the picker
};

// Where a drag takes a point: `start` goes with the pointer.
struct Drag {
  DragMode mode = DragMode::view;
  Vec3d start;
  Vec3d direction;  // of DragMode::normal and axis: along it; else across it, in the plane
  Vec3d offset{};   // from where the pointer was on that plane or line to the start

  Vec3d at(const Pointer& pointer, const Surroundings& around) const;
};
Drag begin_drag(const Pointer& pointer, const Vec3d& start, const Vec3d& normal, const Surroundings& around);

// A ball or capsule along a path.
struct ImplicitGesture {
  Drag drag;
  ImplicitStroke stroke;
};

// Dabs along the pointer's path, each on the surface as the earlier dabs have moved it: the result does not depend on
// the speed of the person or the machine.
struct PaintGesture {
  PaintStroke stroke;
  Flow done;             // of the stroke so far
  double spacing = 0;    // of dabs at full pressure, along the surface
  double travelled = 0;  // since the last dab
  Pointer last;
  Vec3d last_point;
};

// A line drawn on the surface, to be moved later; a click sets a point.
struct DrawGesture {
  std::vector<Vec3d> points;
  bool is_curve = false;
};

// Points and curves moved together.
struct PointsGesture {
  Drag drag;
  PointsStroke stroke;
  Vec3d reached;  // by the displacements so far
};

// A closed tool pressed along a path, from its placement.
struct StampGesture {
  Drag drag;
  StampStroke stroke;  // whole path
  double step = 0;     // shortest piece of it
};

// Rotate, stretch, twist or bend about a placement by how far the pointer goes; a click places instead.
struct TurnGesture {
  Pointer start;
  std::optional<Placement> placement;
  double amount = 0;  // degrees; of stretch: percent, of the logarithm
};

// Handles painted onto vertices.
struct HandlePaintGesture {
  std::uint8_t handle = 0;
};

// The full set moved, the zero set held.
struct HandlesGesture {
  Drag drag;
  HandlesStroke stroke;
};

// A part of the gizmo dragged: changes the placement, not the shape.
struct GizmoGesture {
  GizmoPart part = GizmoPart::center;
  Placement start;
  Pointer from;
};

struct Gesture {
  std::variant<ImplicitGesture, PaintGesture, DrawGesture, PointsGesture, StampGesture, TurnGesture, HandlePaintGesture,
               HandlesGesture, GizmoGesture>
      kind;
  ShapeState start{};     // the shape as it was
  std::string trouble{};  // not empty: why this gesture is impossible, a sentence for the person
};

// Starts a gesture when the left button is pressed. Returns nothing if that has no meaning here.
std::optional<Gesture> begin_gesture(const Pointer& pointer, const Surroundings& around, Placed& placed);
void move_gesture(const Pointer& pointer, const Surroundings& around, Placed& placed, Gesture& gesture);
// Completes the gesture when the button is released.
void end_gesture(const Pointer& pointer, const Surroundings& around, Placed& placed, Gesture& gesture);

// Returns the strokes of the gesture so far, each followed by its mirror images; empty if it does nothing. `image_file`
// returns the file with the mirror image of a stamp's tool in the planes of a bit mask (1: x, 2: y, 4: z).
using ImageFile = std::function<std::string(const std::string& file, unsigned planes)>;
std::vector<Stroke> strokes_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file);

// The stroke of a tool that turns, by an amount as in TurnGesture. Nothing for an amount that does nothing, and for a
// twist or bend with a barrel where none was found.
std::optional<Stroke> turning_stroke(const ToolSettings& settings, const Placement& placement, double amount);

// Returns the stroke of the placed stamp: its pose, size and orientation.
StampStroke stamp_at(const ToolSettings& settings, const StampShape& shape, const Placement& placement);

// Returns the placement that a click gives: a stamp just outside the surface, or a tool that turns.
std::optional<Placement> placement_at(const Pointer& pointer, const Surroundings& around, const Placed& placed);

}  // namespace knead::studio
