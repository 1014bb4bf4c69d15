// The barrel of a cylinder restriction: where the velocity jumps, and which triangles must therefore not cross it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

// The cylinder of a twist or bend at the stroke's start: what lies within `radius` of the line {center + s normal} is
// moved, as far as normal.(x - center) < outer. normal is a unit vector.
struct Barrel {
  Vec3d center;
  Vec3d normal;
  double radius = 0;
  double outer = 0;
  Vec3d last_normal;  // a bend's normal at the stroke's end

  friend bool operator==(const Barrel&, const Barrel&) = default;
};

// The barrel of a stroke that has a cylinder. The stroke is valid.
std::optional<Barrel> barrel_of(const Stroke& stroke);

struct BarrelCheck {
  std::size_t crossing = 0;  // triangles that cross the barrel where r < outer
  std::size_t later = 0;     // triangles that cross it only where a bend's turning normal brings r below outer
  // Where crossing > 0: the nearest radii that no triangle crosses and that hold some triangle's moving part, of about
  // 6 digits and verified. A smaller one need not exist.
  std::optional<double> smaller;
  std::optional<double> larger;
};

// A triangle crosses if its part with r < outer has points within the radius (or at it) as well as points beyond it:
// exactly then the deformation would tear it. Time: linear, and a sort of the triangles if some cross.
BarrelCheck check_barrel(const Barrel& barrel, std::span<const Vec3d> positions, std::span<const Triangle> triangles);

// The nearer of the two radii.
std::optional<double> nearest_radius(const BarrelCheck& check, double radius);

}  // namespace knead
