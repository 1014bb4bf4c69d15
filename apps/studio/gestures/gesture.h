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
  std::optional<double> typed{};  // a typed number, as shown (Amount), in the place of the pointer's motion
};

// What a gesture depends on at one moment.
struct GestureContext {
  Screen screen;
  const ShapeState& state;         // the shape as it was when the gesture began
  const Picker* picker = nullptr;  // fits the state; null: nothing can be hit yet
  const ToolSettings& settings;
  bool is_taken = true;  // the worker computes the last version of the gesture; false: that waits, and may be replaced
  HitTest hit_test{};    // if not empty, used instead of the picker
  double snap = 0;       // lengths are multiples of it while Ctrl is held
};

// Returns the nearest multiple of `step` while Ctrl is held, else the value.
double snapped(double value, double step, const Pointer& pointer);
inline constexpr double kSnapDegrees = 15;

// The rule by which a drag moves a point: `start` follows the pointer.
//
// Along a line that faces the viewer, the place under the pointer is ill-conditioned. There the vertical movement of
// the pointer is depth instead. `depth` blends the two rules by the angle between line and view.
struct Drag {
  DragMode mode = DragMode::view;
  Vec3d start;
  Vec3d direction;   // a unit vector: the line of DragMode::normal and axis, else the normal of the plane
  Vec3d offset{};    // from the pointer's first place on that plane or line to the start
  Pixel from{};      // the pointer's first pixel
  double depth = 0;  // of a line: 0 where it is seen from the side, 1 where it faces the viewer
  double up = 1;     // of a line, with depth: 1 if upwards in the picture is along `direction`, else -1. Upwards is
                     // towards the viewer where depth is 1: everywhere on a face that is seen from the front.

  bool is_on_line() const { return mode == DragMode::normal || mode == DragMode::axis; }
  Vec3d at(const Pointer& pointer, const GestureContext& around) const;
  // Returns the distance from the start; along a line with its sign.
  double length_of(const Vec3d& to) const;

 private:
  Vec3d pointed_at(const Pointer& pointer, const GestureContext& around) const;
  Vec3d on_its_line(const Pointer& pointer, const GestureContext& around) const;
};
Drag begin_drag(const Pointer& pointer, const Vec3d& start, const Vec3d& normal, const GestureContext& around);

// The number that is shown at the pointer and can be typed: a length in the mesh's units, degrees, or percent.
enum class AmountKind { length, angle, percent };
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
  Vec3d touched;  // the place on the surface where the pointer began
  Vec3d normal;   // of the surface there

  void move(const GestureStep& step);
  std::vector<Stroke> strokes() const { return strokes_if(stroke.path.size() > 1, stroke); }
  Amount number() const { return {AmountKind::length, drag.length_of(stroke.path.back())}; }
};

// Dabs along the pointer's path, once it meets the shape.
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

// A line drawn on the surface, along which the shape grows when the drag ends, because that takes time.
struct InflateGesture {
  InflateStroke stroke;
  Vec3d last_point;
  bool has_ended = false;

  void move(const GestureStep& step);
  void end(const GestureStep& /*step*/) { has_ended = true; }
  std::vector<Stroke> strokes() const { return strokes_if(has_ended && stroke.depth != 0, stroke); }
  Amount number() const { return {AmountKind::length, stroke.depth.value_or(0)}; }
};

// A text or picture that follows the pointer on the surface, and is printed when the drag ends: that takes a while.
struct PrintGesture {
  PrintStroke stroke;
  bool has_ended = false;

  void move(const GestureStep& step);
  void end(const GestureStep& /*step*/) { has_ended = true; }
  std::vector<Stroke> strokes() const { return strokes_if(has_ended, stroke); }
};

// The line through the shape becomes another one, and the shape follows: by a handle of it, at once; or by a line drawn
// in the picture, in the plane through the line's middle that faces the viewer, when the drag ends.
struct BendAlongGesture {
  std::vector<Vec3d> line;  // at the start
  std::size_t stride = 1;   // from one handle of it to the next
  CurveLength length = CurveLength::keep;
  CurveKeeps keep = CurveKeeps::volume;
  std::optional<std::size_t> handle{};  // std::nullopt: a line is drawn
  Drag drag{};                          // of the handle
  std::vector<Vec3d> drawn{};           // so far
  std::vector<Vec3d> to{};              // where the line goes; empty: nowhere yet

  void move(const GestureStep& step);
  void end(const GestureStep& step);
  std::vector<Stroke> strokes() const;
  std::optional<Amount> number() const;
};

// Selected control points of the lattice about the shape move alike.
struct LatticeGesture {
  PlacedLattice lattice;  // at the start
  Drag drag;              // of one of them
  Vec3d by{0, 0, 0};
  bool has_ended = false;

  void move(const GestureStep& step);
  void end(const GestureStep& step);
  LatticeStroke moved() const;
  std::vector<Stroke> strokes() const { return strokes_if(by != Vec3d{0, 0, 0}, moved()); }
  Amount number() const { return {AmountKind::length, drag.length_of(drag.start + by)}; }
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
  Vec3d reached;  // the end of the displacements so far

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
  std::vector<Stroke> strokes() const { return strokes_if(!stroke.displacements.empty(), stroke); }
  Amount number() const { return {AmountKind::length, drag.length_of(reached)}; }
};

// A closed tool pressed along a path, from its placement.
struct StampGesture {
  Drag drag;
  StampStroke stroke;   // with the whole path
  double shortest = 0;  // the least length of a piece of the path

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
  std::vector<Stroke> strokes() const { return pieces_of(stroke); }
  Amount number() const { return {AmountKind::length, drag.length_of(stroke.path.back())}; }
};

// Rotates, stretches, twists or bends about a placement, by an amount from the pointer's motion. A click places the
// tool.
struct TurnGesture {
  Pointer start;
  std::optional<Placement> placement;
  double amount = 0;      // degrees; of stretch: percent, of the logarithm
  bool has_gone = false;  // the pointer has moved farther than in a click

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
  std::vector<Stroke> strokes(const ShapeState& start, const ToolSettings& settings) const;
  std::optional<Amount> number(const ToolSettings& settings) const;
};

// A lasso: makes or frees a part of a pose, or sets or selects pins or control points.
struct LassoGesture {
  std::vector<Pixel> line;
  bool selects = false;  // selects pins or control points
  bool frees = false;    // frees the vertices within the line from every part

  void move(const GestureStep& step);
  void end(const GestureStep& step) const;
};

// The parts of a pose that do not depend on the pointer.
struct PosePlan;

// Drags one pin, or all selected pins; the others hold or are carried along.
struct PinsGesture {
  std::shared_ptr<const PosePlan> plan{};  // of a pose; null: not made yet
  Drag drag;
  std::vector<Pin> pins;  // at the start
  PartMarks parts{};      // at the start
  std::size_t dragged = 0;
  Vec3d to;                   // the place of the dragged pin
  std::vector<Vec3d> path{};  // of the dragged pin, without its start; shortened when the pointer returns along it
  bool has_gone = false;      // the pointer has moved farther than in a click
  bool rests = false;         // the pointer rests: the pose has all its detail

  static constexpr bool kHasImages = true;
  void move(const GestureStep& step);
  void end(const GestureStep& step);
  // Returns a pose that names vertices of `start`, or points if remeshing has changed the vertices' numbers. Its detail
  // is coarse while the pointer moves.
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

// Moves the selected part of a pose by its gizmo, or turns it about its joint by the grabbed place. The other parts and
// the pins hold or are carried along.
struct PartGesture {
  std::shared_ptr<const PosePlan> plan{};  // null: not made yet
  PartMarks parts;                         // at the start
  std::vector<Pin> pins;                   // at the start
  Pointer from;
  std::optional<GizmoPart> handle{};  // std::nullopt: it turns about its joint
  Vec3d grabbed{};                    // the grabbed place, if it turns about its joint
  PartMotion motion{};
  double amount = 0;      // degrees or a length
  bool has_gone = false;  // the pointer has moved farther than in a click
  bool rests = false;     // the pointer rests: the pose has all its detail

  static constexpr bool kHasImages = true;
  void move(const GestureStep& step);
  void end(const GestureStep& step);
  std::vector<Stroke> strokes(const ShapeState& start, const ToolSettings& settings) const;
  std::optional<Amount> number() const;
};

// Paints a part of a pose onto vertices.
struct PartPaintGesture {
  std::optional<std::size_t> part{};  // std::nullopt: frees the vertices

  void move(const GestureStep& step) const;
  void end(const GestureStep& step) const;
};

// Drags a part of the gizmo: changes the placement, not the shape.
struct GizmoGesture {
  GizmoPart part = GizmoPart::center;
  Placement start;
  Pointer from;
  double amount = 0;  // degrees or a length, of all parts but the centre

  void move(const GestureStep& step);
  std::optional<Amount> number() const;
};

// Every kind has move(). Some also have end(), which is called after the last move; strokes(), the strokes so far; and
// number(), which amount_of() returns. kHasImages: the strokes already contain their images.
struct Gesture {
  std::variant<ImplicitGesture, PaintGesture, DrawGesture, PointsGesture, StampGesture, TurnGesture, LassoGesture,
               PinsGesture, GizmoGesture, RelaxGesture, InflateGesture, PrintGesture, PartGesture, PartPaintGesture,
               BendAlongGesture, LatticeGesture>
      kind;
  ShapeState start{};     // the shape at the start
  std::string trouble{};  // not empty: a sentence that says why this gesture is impossible
};

// Returns whether the pointer is on a placed stamp, a gizmo, or placed points and curves.
bool is_on_placed(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

// Starts a gesture when the left button is pressed. Returns nothing if the tool does nothing there.
std::optional<Gesture> begin_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
void move_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture);
// Completes the gesture when the button is released.
void end_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture);

// Returns the session's lines for the gesture up to now; no lines if it does nothing. Mirrors at right angles to each
// other act at the same time, in the same lines. Every other image has a line of its own, after the gesture's.
std::vector<SessionStroke> lines_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file);

// Returns the strokes of the gesture so far, each followed by its images (images_of); empty if it does nothing. For
// drawing the tools.
std::vector<Stroke> strokes_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file);

// Returns the amount of the gesture so far; nothing for gestures without such a number, as paint.
std::optional<Amount> amount_of(const Gesture& gesture, const ToolSettings& settings);

// Returns the drag of a gesture that has one, or a null pointer.
const Drag* drag_of(const Gesture& gesture);

// Returns how a drag beside the gizmo turns the tool.
TurnDrag turn_drag(const Screen& screen, const ToolSettings& settings, const PlacedTools& placed);

// Returns the placement of a twist or bend with the limit cylinder of the part on which it lies, or with the reason why
// there is none. If it may turn, it is turned along the part, and into the plane of the picture if the part nearly lies
// there. Throws Cancelled.
Placement on_part(const Placement& placement, bool bends, bool may_turn, std::span<const Vec3d> positions,
                  std::span<const Triangle> triangles, const Progress* progress);

// Returns the stroke of a tool that turns, by an amount as in TurnGesture. Returns nothing for an amount without
// effect, and for a twist or bend with a limit cylinder that was not found.
std::optional<Stroke> turning_stroke(const ToolSettings& settings, const Placement& placement, double amount);

// Returns the profile of the shape for a placed twist or bend; null for other tools, and without a limit cylinder.
std::shared_ptr<const ZoneProfile> profile_at(const ToolSettings& settings, const Placement& placement,
                                              const ShapeState& state);

// Returns the width of the zone of the turning stroke if it was widened.
std::optional<double> widened_zone(const ToolSettings& settings, const Placement& placement, double amount);

// Returns the number of the handle of a line that the pointer is on.
std::optional<std::size_t> handle_at(const Pointer& pointer, const Screen& screen, const std::vector<Vec3d>& line,
                                     std::size_t stride);

// Returns the number of the control point that the pointer is on: of points on each other the one nearest to the eye.
std::optional<std::size_t> control_point_at(const Pointer& pointer, const Screen& screen,
                                            const std::vector<Vec3d>& points);

// Returns the pin that the pointer is on; none that is hidden behind the shape.
std::optional<std::size_t> pin_at(const Pointer& pointer, const GestureContext& around, const std::vector<Pin>& pins);

// Moves the pins to the current places of their vertices. After remeshing a pin takes the nearest vertex.
void follow(std::vector<Pin>& pins, const ShapeState& state);

// The target of a pin during a drag.
struct PinGoal {
  std::size_t pin = 0;
  Vec3d to;
  bool is_image = false;  // it moves as the image of another pin
};

// Returns the targets of the pins when one is dragged to a place, that one first. If it is selected, the other selected
// pins move by the same displacement.
std::vector<PinGoal> pin_goals(const std::vector<Pin>& pins, std::size_t dragged, const Vec3d& to,
                               const ToolSettings& settings);

// Returns the stroke that moves the pins to their targets and holds the others, with all images (pins_stroke); and its
// radius, or nothing if the stroke is impossible (radius_of).
PinsStroke pins_stroke(const std::vector<Pin>& pins, std::size_t dragged, const Vec3d& to,
                       const ToolSettings& settings);
std::optional<double> radius_of(const PinsStroke& stroke);

// Returns the holding parts and pins of a gesture's pose. Points of parts that are too near to a moving one do not
// hold.
std::shared_ptr<const PosePlan> plan_pose(const PinsGesture& gesture, const ShapeState& state,
                                          const ToolSettings& settings);
std::shared_ptr<const PosePlan> plan_pose(const PartGesture& gesture, const ShapeState& state,
                                          const ToolSettings& settings);

// Returns the pose with fewer holding points: those of parts and pins become free that are nearer than `room` to a
// moving one, or not much farther than the nearest of them. Returns the same pose if nothing would hold then.
// `positions`: those before the pose.
PoseStroke holding_less(PoseStroke pose, std::span<const Vec3d> positions, double room);

// Returns the placement after the motion.
Placement moved(const Placement& placement, const PartMotion& motion);

// Returns whether the pose of a gesture has all its detail; null for another gesture.
bool* rests_of(Gesture& gesture);

// Returns the part of the pose that the pointer is on.
std::optional<std::size_t> part_at(const Pointer& pointer, const GestureContext& around, const PartMarks& parts);

// Returns the direction in which a print is upright on a surface with this normal: up in the picture, or away from the
// viewer.
Vec3d print_up(const Screen& screen, const Vec3d& normal);

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

// Returns the amount by which an arrow (a length) or a ring (degrees) was dragged from one pixel to another.
double dragged_by(const Screen& screen, const Placement& start, GizmoPart part, const Pixel& from, const Pixel& to);

// Returns the placement after an arrow or ring was moved by that amount.
Placement moved_by(const Placement& start, GizmoPart part, double amount);

// Returns the placement after its centre was dragged in the plane of the view.
Placement center_dragged(const Screen& screen, const Placement& start, const Pixel& from, const Pixel& to);

// Returns the angle in radians, from -pi to pi, by which the pointer has moved round a centre, about an axis through
// it.
double angle_round(const Screen& screen, const Vec3d& center, const Vec3d& axis, const Pixel& from, const Pixel& to);

// Adds the arrows and lines of the gizmo; the part under the pointer is lighter.
void draw_gizmo(const Screen& screen, const Placement& placement, std::optional<GizmoPart> lit,
                std::vector<render::Arrow>& arrows, std::vector<render::Line>& lines);

}  // namespace knead::studio
