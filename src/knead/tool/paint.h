// Painting along a path on the surface, and under a pointer (paper, section 4.2).
#pragma once

#include <vector>

#include "knead/tool/live_surface.h"
#include "knead/tool/stroke.h"

namespace knead {

// Returns the fraction of `outer` over which a path spreads one dab of full depth: the integral of the blend's weight
// over its own range, 17/35 for the default falloff. Along a straight path the dabs' displacements then add up to the
// depth. The falloff is from 3 to 7.
double dab_length(int falloff);

// The dabs of a stroke with a path: their places before they are moved to the surface, and the depth of each.
struct PaintDabs {
  std::vector<Vec3d> aims;
  double depth = 0;
};

// Returns the dabs of a stroke with a path. A smooth curve (centripetal, third order) goes through the path's points;
// the dabs lie evenly along it, close enough that the result does not depend on their number. Every dab_length * outer
// of the path gets one dab of full depth in all; a shorter path also gets one. Throws InvalidInput for a path that
// needs more than a million dabs.
PaintDabs paint_dabs(const PaintStroke& stroke);

// Applies one dab after the other: each at the point of the current surface that is closest to the dab's place, against
// the normal there. Stops when apply returns false. The stroke is valid and has a path. Throws InvalidInput for a point
// cloud without normals, and at a place where the surface has no normal.
void paint_on(const PaintStroke& stroke, const LiveSurface& surface);

// What a pointer touches while it paints.
struct PaintTouch {
  PaintSample at;       // of the surface as it was before the painting began
  double radius = 0;    // outer threshold of a dab here, above 0
  double pressure = 1;  // how much each length of the way counts, above 0
};

// Painting with a pointer: dabs at even distances along the places that it touches, each where the dabs before it have
// moved that place of the surface. So the result does not depend on the speed of the person or the machine.
struct PaintDrag {
  PaintStroke stroke;                // the dabs with the radius and depth of now
  std::vector<PaintStroke> earlier;  // those with others
  Flow done;                         // of all dabs so far
  double spacing = 0;                // of dabs at full pressure, along the surface
  double travelled = 0;              // since the last dab
  Vec3d last;                        // the place that was touched last

  // Returns the strokes so far; a later call returns more of them, or more samples in the last one.
  std::vector<Stroke> strokes() const;
};

// Begins with a dab. `stroke` has the outer threshold at full pressure, the depth of a whole layer, and no samples.
PaintDrag begin_paint(const PaintStroke& stroke, const PaintTouch& touch);

// Goes on to a place near the last one, and adds a dab where the way since the last dab is long enough.
void drag_paint(PaintDrag& drag, const PaintTouch& touch);

// Ends the painting. One that is a single dab gets the full depth.
void end_paint(PaintDrag& drag);

}  // namespace knead
