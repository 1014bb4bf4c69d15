// The beginnings of all gestures, and functions that gestures share. Internal to gesture.cpp and its neighbours.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gestures/gesture.h"
#include "gestures/tools.h"
#include "knead/replay.h"
#include "knead/vec.h"

namespace knead::studio {

// Returns the direction of the view.
Vec3d forward_of(const GestureContext& around);

std::optional<SurfaceHit> hit_at(const Pointer& pointer, const GestureContext& around);

ImplicitGesture begin_implicit(const Pointer& pointer, const GestureContext& around);

// Returns the brush of a tool that paints, without samples, with the depth of a whole layer.
PaintStroke brush_of(const ToolSettings& settings, const Pointer& pointer);
PaintGesture begin_paint(const Pointer& pointer, const GestureContext& around);

std::optional<RelaxGesture> begin_relax(const Pointer& pointer, const GestureContext& around);

std::optional<InflateGesture> begin_inflate(const Pointer& pointer, const GestureContext& around);

std::optional<PrintGesture> begin_print(const Pointer& pointer, const GestureContext& around,
                                        const PlacedTools& placed);

// Begins to drag the handle under the pointer, or to draw a line. Returns nothing for a shape without a line.
std::optional<BendAlongGesture> begin_bend_along(const Pointer& pointer, const GestureContext& around,
                                                 PlacedTools& placed);

// Begins to drag the control point under the pointer and all others that are selected, or to draw a line round those
// that it selects. With Shift it selects or deselects the point only, and returns nothing.
std::optional<Gesture> begin_lattice(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
// Selects the control points within the line; with Ctrl the others stay selected.
void select_control_points(const GestureStep& step, const std::vector<Pixel>& line);

inline constexpr double kClick = 4;  // points that a click may move
inline constexpr double kNear = 12;  // points around a placed thing in which the pointer grabs it

// Returns whether the pointer is on a placed point or curve.
bool is_near(const PlacedTools& placed, const Pointer& pointer, const GestureContext& around);
PointsGesture begin_points(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

std::optional<DrawGesture> begin_draw(const Pointer& pointer, const GestureContext& around);

StampGesture begin_stamp(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

// Adds the pointer's pixel, if it is far enough from the last one.
void extend_line(const Pointer& pointer, std::vector<Pixel>& line);

inline constexpr double kOneImage = 0.125;  // of the radius: an image nearer than this to a pin is no pin of its own

// Moves the end of a path that begins at `start` to a place. Earlier places stay in pieces of at least `step`. If the
// end comes near an earlier place, the path is cut back to that place.
void extend_path(const Vec3d& start, const Vec3d& to, double step, std::vector<Vec3d>& path);

// Begins to drag the pin under the pointer, or a new pin on the surface there. Returns nothing elsewhere.
std::optional<PinsGesture> begin_pins(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);
// Sets pins evenly on vertices within the line, but not near existing ones.
void end_pin_lasso(const GestureContext& around, const std::vector<Pixel>& line, PlacedTools& placed);
// Selects the pins within the line and no others.
void select_pins(const GestureContext& around, const std::vector<Pixel>& line, std::vector<Pin>& pins);

bool is_on_part_gizmo(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);
// Grabs the gizmo of the selected part, or selects the part under the pointer. Returns nothing elsewhere.
std::optional<PartGesture> begin_part(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
// Makes a selected part of the limb under the pointer. If no part or pin holds yet, also makes a holding part of the
// body. The vertices that bend between them become free. Returns the reason if there is no limb, else an empty text.
std::string add_limb(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
// Makes a selected part of the vertices beyond a joint, on the smaller side along its z, and a holding part of all
// others. Returns false, and changes nothing, if the joint does not divide the shape.
bool add_part_beyond(const Placement& joint, const GestureContext& around, PlacedTools& placed);
// Makes a part of the vertices within the line, or frees them; a click selects the part there.
void end_part_lasso(const Pointer& pointer, const GestureContext& around, const LassoGesture& gesture,
                    PlacedTools& placed);
// Paints onto the selected part, or a new one.
std::optional<PartPaintGesture> begin_part_paint(const Pointer& pointer, const GestureContext& around,
                                                 PlacedTools& placed);

// Returns at most `most` of the points, about evenly over space.
std::vector<Vec3d> thinned(const std::vector<Vec3d>& points, std::size_t most);

// Parts of a pose: marked on vertices, followed as the shape changes.

inline constexpr std::size_t kMaxParts = 250;

// Returns whether there is a part on the vertex, and its number from 0.
std::optional<std::size_t> part_of(const PartMarks& parts, std::uint32_t vertex);

// Marks a new part, which holds and is selected; its vertices leave other parts. Returns its number; nothing if there
// are no vertices, or too many parts.
std::optional<std::size_t> add_part(std::span<const std::uint32_t> vertices, const ShapeState& state, PartMarks& parts);

// Adds vertices to a part; std::nullopt removes them from every part.
void mark(std::span<const std::uint32_t> vertices, std::optional<std::size_t> part, const ShapeState& state,
          PartMarks& parts);

void remove_part(std::size_t part, PartMarks& parts);

// Removes the parts that have lost all their vertices.
void remove_empty_parts(PartMarks& parts);

void select_part(std::optional<std::size_t> part, PartMarks& parts);

// Adapts the parts to a later or earlier state of the shape, and moves the gizmo to the selected one. After remeshing a
// vertex keeps its part, and a new vertex belongs to the part of a neighbour.
void follow(PartMarks& parts, const ShapeState& state);

// Returns the vertices of a part.
std::vector<std::uint32_t> vertices_of(const PartMarks& parts, std::size_t part);

// Returns the joint of a part: the middle of its border, with z pointing from there to the middle of the part. A part
// without a border has its joint in its middle, with the axes of the scene. Returns nothing for a part without
// vertices.
std::optional<Placement> joint_of(const PartMarks& parts, std::size_t part, const ShapeState& state);

}  // namespace knead::studio
