// The barrel of a cylinder restriction: where the velocity jumps, and which triangles must therefore not cross it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

// The cylinder of a twist or bend at the stroke's start: within `radius` of the line {center + s normal}, and moving
// where normal.(x - center) < outer. normal is a unit vector.
struct Barrel {
  Vec3d center;
  Vec3d normal;
  double radius = 0;
  double outer = 0;

  friend bool operator==(const Barrel&, const Barrel&) = default;
};

// The barrel of a stroke that has a cylinder.
std::optional<Barrel> barrel_of(const Stroke& stroke);

struct BarrelCheck {
  std::size_t crossing = 0;       // triangles that cross the barrel where r < outer
  std::optional<double> smaller;  // the nearest radii that no triangle crosses, about 6 digits, verified;
  std::optional<double> larger;   // nothing where crossing is 0; no smaller one may exist

  // The nearer of the two.
  std::optional<double> nearest(double radius) const;
};

// A triangle crosses if the part of it where r < outer comes both nearer to the axis than the radius and farther from
// it. Touching is not crossing. Linear in the triangles; those in the way are sorted.
BarrelCheck check_barrel(const Barrel& barrel, std::span<const Vec3d> positions, std::span<const Triangle> triangles);

}  // namespace knead
