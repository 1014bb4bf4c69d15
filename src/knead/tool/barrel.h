// The barrel that limits a twist or bend: the velocity jumps there, so no triangle may cross it where something moves.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

// The barrel at the start of a stroke. The stroke moves the points within `radius` of the line {center + s normal} that
// have normal.(x - center) < outer. normal is a unit vector.
struct Barrel {
  Vec3d center;
  Vec3d normal;
  double radius = 0;
  double outer = 0;
  Vec3d last_normal;  // a bend's normal at the stroke's end

  friend bool operator==(const Barrel&, const Barrel&) = default;
};

// Returns the barrel of a twist or bend with a radius, else nothing, as for bends that read the surface. The stroke is
// valid.
std::optional<Barrel> barrel_of(const Stroke& stroke);

// The triangles that cross a barrel, and radii that would be crossed by none.
struct BarrelCheck {
  std::size_t crossing = 0;  // triangles that cross the barrel where r < outer
  std::size_t later = 0;     // triangles that cross it only where a bend's turning normal brings r below outer
  // If crossing > 0: the nearest radii that no triangle crosses and within which something moves, rounded to about 6
  // digits and verified. There may be no smaller one.
  std::optional<double> smaller;
  std::optional<double> larger;
};

// Counts the triangles that cross the barrel. A triangle crosses if its part with r < outer has points within the
// radius (or at it) and points beyond it; the deformation would tear exactly these. Time: linear, and a sort of the
// triangles if some cross.
BarrelCheck check_barrel(const Barrel& barrel, std::span<const Vec3d> positions, std::span<const Triangle> triangles);

// Returns the one of the two radii that is nearer to `radius`, or nothing.
std::optional<double> nearest_radius(const BarrelCheck& check, double radius);

}  // namespace knead
