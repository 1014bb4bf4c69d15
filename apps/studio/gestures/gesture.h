// Turns the movement of the pointer between press and release into strokes. Needs no window.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "gestures/picker.h"
#include "gestures/tools.h"
#include "knead/editor/render.h"
#include "knead/editor/tools.h"
#include "knead/session.h"
#include "platform/window.h"

namespace knead::studio {

// Returns what a ray hits, if there is no picker for it.
using HitTest = std::function<std::optional<SurfaceHit>(const Ray& ray)>;

struct Pointer {
  double x = 0;  // pixels, as in Screen
  double y = 0;
  double pressure = 1;
  Modifiers modifiers{};
  std::optional<double> typed{};  // as a person reads it (Amount): instead of what the pointer says
};

// What a gesture depends on at one moment.
struct GestureContext {
  Screen screen;
  const ShapeState& state;         // the shape as it was when the gesture began
  const Picker* picker = nullptr;  // fits the state; null: nothing can be hit yet
  const ToolSettings& settings;
  bool is_taken = true;  // the last version of the gesture is being computed; false: it waits, and may change
  HitTest hit_test{};    // if not empty, used instead of the picker
  double snap = 0;       // lengths are multiples of it while Ctrl is held
};

// Returns the nearest multiple of `step` while Ctrl is held, else the value.
double snapped(double value, double step, const Pointer& pointer);
inline constexpr double kSnapDegrees = 15;

// Where a drag takes a point: `start` goes with the pointer.
//
// Along a line that faces the viewer, the place under the pointer is ill-conditioned: there the pointer's vertical
// movement is depth instead. `depth` blends the two rules by the angle between line and view.
struct Drag {
  DragMode mode = DragMode::view;
  Vec3d start;
  Vec3d direction;   // of DragMode::normal and axis: along it, a unit vector; else across it, in the plane
  Vec3d offset{};    // from where the pointer was on that plane or line to the start
  Pixel from{};      // where the pointer was
  double depth = 0;  // of a line: 0 where it is seen from the side, 1 where it faces the viewer
  double up = 1;     // of a line, with depth: 1 if upwards in the picture is along `direction`, else -1. Upwards is
                     // towards the viewer where depth is 1: all over a face that is looked at.

  bool is_on_line() const { return mode == DragMode::normal || mode == DragMode::axis; }
  Vec3d at(const Pointer& pointer, const GestureContext& around) const;
  // Returns the distance from the start; along a line with its sign.
  double length_of(const Vec3d& to) const;

 private:
  Vec3d pointed_at(const Pointer& pointer, const GestureContext& around) const;
  Vec3d on_its_line(const Pointer& pointer, const GestureContext& around) const;
};
Drag begin_drag(const Pointer& pointer, const Vec3d& start, const Vec3d& normal, const GestureContext& around);

// The number that a person sees at the pointer and may type: a length in the mesh's units, what a shape grows in
// percent of the tool's ball, degrees, or percent.
enum class AmountKind { length, growth, angle, percent };
inline constexpr double kBallOfCube = 4.18879020478639;  // the volume of a ball of radius 1
struct Amount {
  AmountKind kind = AmountKind::length;
  double value = 0;
};

// Returns the stroke if it does something.
inline std::vector<Stroke> strokes_if(bool does_something, const Stroke& stroke) {
  return does_something ? std::vector<Stroke>{stroke} : std::vector<Stroke>{};
}

// One step of a gesture.
struct GestureStep {
  const Pointer& pointer;
  const GestureContext& around;
  PlacedTools& placed;
};

// The parts of the handle of a placement: three arrows that move it, three rings that turn it, and its centre.
enum class GizmoPart { center, move_x, move_y, move_z, turn_x, turn_y, turn_z };

// A ball or capsule along a path.
struct ImplicitGesture {
  Drag drag;
  ImplicitStroke stroke;
  Vec3d touched;  // on the surface, where the pointer began
  Vec3d normal;   // there

  void move(const GestureStep& step);
  std::vector<Stroke> strokes() const { return strokes_if(stroke.path.size() > 1, stroke); }
  Amount number() const { return {AmountKind::length, drag.length_of(stroke.path.back())}; }
};

// Dabs along the pointer's path, from where it meets the shape.
struct PaintGesture {
  PaintStroke brush;                 // without samples
  std::optional<PaintDrag> paint{};  // std::nullopt: the pointer has been beside the shape so far
  Pointer last{};

  void move(const GestureStep& step);
  void end(const GestureStep& /*step*/) {
    if (paint) end_paint(*paint);
  }
  std::vector<Stroke> strokes() const { return paint ? paint->strokes() : std::vector<Stroke>{}; }
};

// Places along the pointer's path where the surface is relaxed.
struct RelaxGesture {
  RelaxStroke stroke;
  Vec3d last_point;

  void move(const GestureStep& step);
  std::vector<Stroke> strokes() const { return {stroke}; }
};

// A line drawn on the surface, along which the shape grows by a volume when the drag ends: that takes a while.
struct InflateGesture {
  InflateStroke stroke;
  Vec3d last_point;
  bool has_ended = false;

  void move(const GestureStep& step);
  void end(const GestureStep& /*step*/) { has_ended = true; }
  std::vector<Stroke> strokes() const { return strokes_if(has_ended && stroke.volume != 0, stroke); }
  // One percent of the tool's ball.
  double percent() const { return 0.01 * kBallOfCube * stroke.radius * stroke.radius * stroke.radius; }
  Amount number() const { return {AmountKind::growth, stroke.volume / percent()}; }
};

// A line drawn on the surface, to be moved later; a click sets a point.
struct DrawGesture {
  std::vector<Vec3d> points;
  bool is_curve = false;

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
};

// Points and curves moved together.
struct PointsGesture {
  Drag drag;
  PointsStroke stroke;
  Vec3d reached;  // by the displacements so far

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
  std::vector<Stroke> strokes() const { return strokes_if(!stroke.displacements.empty(), stroke); }
  Amount number() const { return {AmountKind::length, drag.length_of(reached)}; }
};

// A closed tool pressed along a path, from its placement.
struct StampGesture {
  Drag drag;
  StampStroke stroke;   // whole path
  double shortest = 0;  // piece of it

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
  std::vector<Stroke> strokes() const { return pieces_of(stroke); }
  Amount number() const { return {AmountKind::length, drag.length_of(stroke.path.back())}; }
};

// Rotate, stretch, twist or bend about a placement by how far the pointer goes; a click places instead.
struct TurnGesture {
  Pointer start;
  std::optional<Placement> placement;
  double amount = 0;      // degrees; of stretch: percent, of the logarithm
  bool has_gone = false;  // farther than a click may

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
  std::vector<Stroke> strokes(const ShapeState& start, const ToolSettings& settings) const;
  std::optional<Amount> number(const ToolSettings& settings) const;
};

// A line drawn round a part of a pose, which is made or freed, or round pins, which are set or selected.
struct LassoGesture {
  std::vector<Pixel> line;
  bool selects = false;  // pins
  bool frees = false;    // what is within the line, of every part

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
};

// What of a pose does not depend on where the pointer goes.
struct PosePlan;

// One pin moved, or all that are selected, the others held or carried along.
struct PinsGesture {
  std::shared_ptr<const PosePlan> plan{};  // of a pose; null: not made yet
  Drag drag;
  std::vector<Pin> pins;  // as they were
  PartMarks parts{};      // as they were
  std::size_t dragged = 0;
  Vec3d to;                   // of the dragged pin
  std::vector<Vec3d> path{};  // of the dragged pin, without its start; shortened when the pointer returns along it
  bool has_gone = false;      // farther than a click may
  bool rests = false;         // the pointer does: the pose has all its detail

  static constexpr bool kHasImages = true;
  void move(const GestureStep& step);
  void end(const GestureStep& step);
  // A pose that names vertices of `start`, or points where remeshing has changed the vertices' numbers. While the
  // pointer moves, its detail is coarse.
  std::vector<Stroke> strokes(const ShapeState& start, const ToolSettings& settings) const;
  Amount number() const { return {AmountKind::length, drag.length_of(to)}; }
};

// A rigid motion: a rotation about an axis through a point, and a translation.
struct PartMotion {
  Vec3d center{0, 0, 0};
  Vec3d axis{0, 0, 1};
  double angle_deg = 0;
  Vec3d translation{0, 0, 0};

  bool is_nothing() const { return angle_deg == 0 && translation == Vec3d{0, 0, 0}; }
};

// The selected part of a pose moved by its gizmo, or turned about its joint by the place where it was taken hold of;
// the others and the pins held or carried along.
struct PartGesture {
  std::shared_ptr<const PosePlan> plan{};  // null: not made yet
  PartMarks parts;                         // as they were
  std::vector<Pin> pins;                   // as they were
  Pointer from;
  std::optional<GizmoPart> handle{};  // std::nullopt: it turns about its joint
  Vec3d grabbed{};                    // then: the place that was taken hold of
  PartMotion motion{};
  double amount = 0;      // degrees or a length
  bool has_gone = false;  // farther than a click may
  bool rests = false;     // the pointer does: the pose has all its detail

  static constexpr bool kHasImages = true;
  void move(const GestureStep& step);
  void end(const GestureStep& step);
  std::vector<Stroke> strokes(const ShapeState& start, const ToolSettings& settings) const;
  std::optional<Amount> number() const;
};

// A part of a pose painted onto vertices.
struct PartPaintGesture {
  std::optional<std::size_t> part{};  // std::nullopt: frees them

  void move(const GestureStep& step) const;
  void end(const GestureStep& step) const;
};

// A part of the gizmo dragged: changes the placement, not the shape.
struct GizmoGesture {
  GizmoPart part = GizmoPart::center;
  Placement start;
  Pointer from;
  double amount = 0;  // degrees or a length, of all parts but the centre

  void move(const GestureStep& step);
  std::optional<Amount> number() const;
};

// Every kind has move(). Where they mean something it also has end(), which is called after the last move; strokes(),
// the strokes so far; and number(), what amount_of() returns. kHasImages: the strokes do what their images do, too.
struct Gesture {
  std::variant<ImplicitGesture, PaintGesture, DrawGesture, PointsGesture, StampGesture, TurnGesture, LassoGesture,
               PinsGesture, GizmoGesture, RelaxGesture, InflateGesture, PartGesture, PartPaintGesture>
      kind;
  ShapeState start{};     // the shape as it was
  std::string trouble{};  // not empty: why this gesture is impossible, a sentence for the person
};

// Returns whether the pointer is on what has been placed: a stamp, its gizmo or that of a tool that turns, points,
// curves.
bool is_on_placed(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

// Starts a gesture when the left button is pressed. Returns nothing if that has no meaning here.
std::optional<Gesture> begin_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
void move_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture);
// Completes the gesture when the button is released.
void end_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture);

// Returns the gesture so far as lines of a session; none if it does nothing. If all symmetry is mirrors at right
// angles, the images act at the same time, in the same lines. Otherwise each image is a line of its own, after the
// gesture's.
std::vector<SessionStroke> lines_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file);

// Returns the strokes of the gesture so far, each followed by its images (images_of); empty if it does nothing. To show
// where tools are.
std::vector<Stroke> strokes_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file);

// Returns how far the gesture has gone; nothing for gestures without such a number, as paint.
std::optional<Amount> amount_of(const Gesture& gesture, const ToolSettings& settings);

// Returns the drag of a gesture that has one, or a null pointer.
const Drag* drag_of(const Gesture& gesture);

// Returns how a drag beside the gizmo turns the tool.
TurnDrag turn_drag(const Screen& screen, const ToolSettings& settings, const PlacedTools& placed);

// Returns the placement of a twist or bend with the limit cylinder of the part on which it lies, or why there is none.
// If it may turn, it lies along the part: in the plane of the picture where the part nearly does. Throws Cancelled.
Placement on_part(const Placement& placement, bool bends, bool may_turn, std::span<const Vec3d> positions,
                  std::span<const Triangle> triangles, const Progress* progress);

// The stroke of a tool that turns, by an amount as in TurnGesture. Nothing for an amount that does nothing, and for a
// twist or bend with a limit cylinder where none was found.
std::optional<Stroke> turning_stroke(const ToolSettings& settings, const Placement& placement, double amount);

// Returns the profile of the shape for a placed twist or bend; null for other tools, and where a limit cylinder is
// missing.
std::shared_ptr<const ZoneProfile> profile_at(const ToolSettings& settings, const Placement& placement,
                                              const ShapeState& state);

// Returns the width of the zone of the turning stroke if it was widened.
std::optional<double> widened_zone(const ToolSettings& settings, const Placement& placement, double amount);

// Returns the pin that the pointer is on; none that is hidden behind the shape.
std::optional<std::size_t> pin_at(const Pointer& pointer, const GestureContext& around, const std::vector<Pin>& pins);

// Puts the pins where their vertices are now. A pin on a mesh that is new to it takes the nearest vertex.
void follow(std::vector<Pin>& pins, const ShapeState& state);

// Where a pin goes that is dragged.
struct PinGoal {
  std::size_t pin = 0;
  Vec3d to;
  bool is_image = false;  // the image of another pin takes it there
};

// Returns where the pins go when one is dragged to a place: that one first. If it is selected, the others that are go
// along by the same displacement.
std::vector<PinGoal> pin_goals(const std::vector<Pin>& pins, std::size_t dragged, const Vec3d& to,
                               const ToolSettings& settings);

// Returns the stroke that takes the pins to their goals while those that hold stay, with all images; and the radius
// that it has, or nothing if it is impossible.
PinsStroke pins_stroke(const std::vector<Pin>& pins, std::size_t dragged, const Vec3d& to,
                       const ToolSettings& settings);
std::optional<double> radius_of(const PinsStroke& stroke);

// Returns what holds in the pose of a gesture. Parts leave room: what of them is too near to what moves does not hold.
std::shared_ptr<const PosePlan> plan_pose(const PinsGesture& gesture, const ShapeState& state,
                                          const ToolSettings& settings);
std::shared_ptr<const PosePlan> plan_pose(const PartGesture& gesture, const ShapeState& state,
                                          const ToolSettings& settings);

// Returns the pose with less that holds: of held parts and pins what is nearer to what moves than `room`, or than
// somewhat more than the nearest of them, becomes free. The same pose if nothing would hold then. The positions are
// those before it.
PoseStroke holding_less(PoseStroke pose, std::span<const Vec3d> positions, double room);

// Returns where a motion takes a placement.
Placement moved(const Placement& placement, const PartMotion& motion);

// Returns whether the pose of a gesture has all its detail; null for another gesture.
bool* rests_of(Gesture& gesture);

// Returns the part of the pose that the pointer is on.
std::optional<std::size_t> part_at(const Pointer& pointer, const GestureContext& around, const PartMarks& parts);

// Returns the stroke of the placed stamp: its pose, size and orientation.
StampStroke stamp_at(const ToolSettings& settings, const StampShape& shape, const Placement& placement);

// Returns the placement that a click gives: a stamp just outside the surface, or a tool that turns.
std::optional<Placement> placement_at(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

// Returns the length of the gizmo's arrows: the same on the screen wherever it is.
double gizmo_size(const Screen& screen, const Placement& placement);

// The part within a few pixels of a place; the nearest of several.
std::optional<GizmoPart> gizmo_part_at(const Screen& screen, const Placement& placement, double x, double y);

// Returns whether the part is a ring.
bool turns(GizmoPart part);

// Returns the direction of an arrow, or the axis of a ring.
Vec3d axis_of(const Placement& placement, GizmoPart part);

// Returns how far an arrow (a length) or a ring (degrees) was dragged from one pixel to another.
double dragged_by(const Screen& screen, const Placement& start, GizmoPart part, const Pixel& from, const Pixel& to);

// Returns the placement after an arrow or ring was moved by that amount.
Placement moved_by(const Placement& start, GizmoPart part, double amount);

// Returns the placement after its centre was dragged in the plane of the view.
Placement center_dragged(const Screen& screen, const Placement& start, const Pixel& from, const Pixel& to);

// The angle in radians, from -pi to pi, by which the pointer has gone round a centre, about an axis through it.
double angle_round(const Screen& screen, const Vec3d& center, const Vec3d& axis, const Pixel& from, const Pixel& to);

// Adds what is to be seen of it; the part under the pointer lighter.
void draw_gizmo(const Screen& screen, const Placement& placement, std::optional<GizmoPart> lit,
                std::vector<render::Arrow>& arrows, std::vector<render::Line>& lines);

}  // namespace knead::studio
