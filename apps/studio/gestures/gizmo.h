// The handle of a placement: three arrows that move it, three rings that turn it, and its centre.
#pragma once

#include <optional>
#include <vector>

#include "gestures/screen.h"
#include "gestures/tools.h"
#include "knead/render.h"

namespace knead::studio {

enum class GizmoPart { center, move_x, move_y, move_z, turn_x, turn_y, turn_z };

// The length of its arrows: the same on the screen wherever it is.
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
