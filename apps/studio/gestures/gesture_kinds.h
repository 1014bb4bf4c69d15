// How each gesture begins, and what gestures share. Internal to gesture.cpp and its neighbours.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gestures/gesture.h"
#include "gestures/tools.h"
#include "knead/replay.h"
#include "knead/vec.h"

namespace knead::studio {

std::optional<SurfaceHit> hit_at(const Pointer& pointer, const GestureContext& around);

ImplicitGesture begin_implicit(const Pointer& pointer, const GestureContext& around);

// The brush of a tool that paints, without samples: what a whole layer does.
PaintStroke brush_of(const ToolSettings& settings, const Pointer& pointer);
PaintGesture begin_paint(const Pointer& pointer, const GestureContext& around);

std::optional<RelaxGesture> begin_relax(const Pointer& pointer, const GestureContext& around);

std::optional<InflateGesture> begin_inflate(const Pointer& pointer, const GestureContext& around);

std::optional<PrintGesture> begin_print(const Pointer& pointer, const GestureContext& around,
                                        const PlacedTools& placed);

inline constexpr double kClick = 4;  // pixels that a click may move
inline constexpr double kNear = 12;  // pixels from what is placed, to take hold of it

// Whether the pointer is on a placed point or curve.
bool is_near(const PlacedTools& placed, const Pointer& pointer, const GestureContext& around);
PointsGesture begin_points(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

std::optional<DrawGesture> begin_draw(const Pointer& pointer, const GestureContext& around);

StampGesture begin_stamp(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);

// Adds the pointer's pixel, if it has gone some way since the last one.
void extend_line(const Pointer& pointer, std::vector<Pixel>& line);

inline constexpr double kOneImage = 0.125;  // of the radius: images that are nearer to a pin are no pins of their own

// Lets a path that begins at `start` go to another place than its last one. It keeps what is before that in pieces of
// `step` or more; where it comes near an earlier place it goes back there.
void extend_path(const Vec3d& start, const Vec3d& to, double step, std::vector<Vec3d>& path);

// Nothing where the pointer is neither on a pin nor on the surface, where it sets one.
std::optional<PinsGesture> begin_pins(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);
// Sets pins on vertices within the line, evenly and not where there are some already.
void end_pin_lasso(const GestureContext& around, const std::vector<Pixel>& line, PlacedTools& placed);
// Selects the pins within the line and no others.
void select_pins(const GestureContext& around, const std::vector<Pixel>& line, std::vector<Pin>& pins);

bool is_on_part_gizmo(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed);
// Takes hold of the gizmo of the selected part, or of the part under the pointer, which it selects. Nothing elsewhere.
std::optional<PartGesture> begin_part(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
// Makes a part of the limb that the pointer is on, which is selected, and where no part and no pin holds yet
// one of the body, which holds. What bends between them becomes free. Returns why there is no limb; empty: there is
// one.
std::string add_limb(const Pointer& pointer, const GestureContext& around, PlacedTools& placed);
// Makes a part of what lies beyond a joint, on the side of its z that is smaller, selected, and one of all else, which
// holds. Returns false, and changes nothing, where the joint does not divide the shape.
bool add_part_beyond(const Placement& joint, const GestureContext& around, PlacedTools& placed);
// Makes a part of the vertices within the line, or frees them; the line of a click selects the part there.
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

// Marks a new part, which holds and is selected; what it takes away from others they lose. Returns its number; nothing
// where there are no vertices, or too many parts.
std::optional<std::size_t> add_part(std::span<const std::uint32_t> vertices, const ShapeState& state, PartMarks& parts);

// Adds vertices to a part, or with nothing frees them of any.
void mark(std::span<const std::uint32_t> vertices, std::optional<std::size_t> part, const ShapeState& state,
          PartMarks& parts);

void remove_part(std::size_t part, PartMarks& parts);

// Removes the parts that have lost all their vertices.
void remove_empty_parts(PartMarks& parts);

void select_part(std::optional<std::size_t> part, PartMarks& parts);

// Takes the parts over to a later or earlier state of the shape, and puts the gizmo where the selected one is now. On a
// mesh that is new to them, a vertex keeps its part; one that remeshing has made is of the part of a neighbour.
void follow(PartMarks& parts, const ShapeState& state);

// Returns the vertices of a part.
std::vector<std::uint32_t> vertices_of(const PartMarks& parts, std::size_t part);

// Returns the joint of a part: the middle of its border, z pointing from there to its middle. Without a border that is
// its middle, with the axes of the scene. Nothing for a part without vertices.
std::optional<Placement> joint_of(const PartMarks& parts, std::size_t part, const ShapeState& state);

}  // namespace knead::studio
