// The parts of the tool "curve": the motion of a stroke, and checks of a shape on it. Internal to the library.
#pragma once

#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/flow.h"
#include "knead/stroke.h"

namespace knead::detail {

// The number of intervals of the splines: for an arc or twist of a line between two points; and for other lines.
inline constexpr int kArcIntervals = 32;
inline constexpr int kPathIntervals = 128;
// The number of these at each end in which the curvature of an arc rises from 0 to its value.
inline constexpr int kArcRamp = 3;

// Returns the line of a stroke whose shape lies between the ramps, as three points tell. Where the stroke has `to`,
// whose ends are then those of the shape, five tell it.
std::vector<Vec3d> line_with_ramps(const Vec3d& center, const Vec3d& half, bool has_aim);

// Returns whether the stroke makes the shape thicker or thinner across the line.
bool changes_thickness(const CurveStroke& stroke);

// Returns the motion of a valid curve stroke that has `from`, an axis if it is an arc, and the thickness before if that
// changes.
CurveMotion motion_of(const CurveStroke& stroke);

// Throws InvalidInput, with a number that works, if the shape would extend too far to the inner side of the curve at
// some time, or meet itself, or if the radius tears the surface. The stroke has `from`; the message names numbers of
// `given`.
void check_curve(const CurveStroke& stroke, const CurveStroke& given, const LiveSurface& surface);

// Throws InvalidInput if the inverse would take an edge of the deformed surface apart: its ends are nearest to places
// of the curve that are too far from each other, as on two turns of a spring.
void check_inverse_of_curve(const CurveStroke& stroke, const LiveSurface& surface);

// Replaces the radius "auto" by that of propose_limit_cylinder about the line. Throws InvalidInput if there is none.
void find_radius(CurveStroke& stroke, const LiveSurface& surface, std::vector<std::string>& remarks);

// Measures `thickness_before` where it is not given: the least width across the line, or the width along the axis, of
// the shape between the ramps; of a taper, at the line's end. Remarks on what the stroke does to it and to the length.
void find_thickness(CurveStroke& stroke, const LiveSurface& surface, std::vector<std::string>& remarks);

}  // namespace knead::detail
