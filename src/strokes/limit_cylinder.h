// Finds the vertices that a stroke with a limit cylinder has moved, for the inverse of the stroke.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/mesh.h"

namespace knead {

// Returns for each vertex of a shape after the stroke, `deformed`, whether the stroke moved it. `taken_back` is where
// the stroke's inverse without the limit cylinder takes it.
// - A vertex that comes from outside the limit cylinder was not moved. One inside it, where a resting point would have
//   been moved, was.
// - Both may hold: the limit cylinder reaches beyond a bent finger's tip, and its image may cover the thumb. Then the
//   surface decides: no triangle crossed the limit cylinder where anything moved, so neighbours that move are of one
//   kind.
// - Vertices of no triangle, and pieces that could all be either, have moved if they come from within the radius.
// Distances are compared with a slack, a length above the error of taken_back. Time: linear.
std::vector<bool> limit_cylinder_members(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> deformed,
                                         std::span<const Vec3d> taken_back, std::span<const Triangle> triangles,
                                         double slack);

}  // namespace knead

// How far from a limit cylinder's axis triangles lie.
namespace knead::tool_detail {

// Distances from the axis: those from min up to, but not with, max.
struct Reach {
  double min = 0;
  double max = 0;
};

// The distances from the limit cylinder's axis that the triangle's part with normal.(x - center) <= outer covers;
// nothing where it has no such part below outer. `normal` is the limit cylinder's normal at some moment. Rounded as
// advect rounds when it decides whether a point belongs.
std::optional<Reach> reach_of(const StrokeCylinder& limit_cylinder, const Vec3d& normal,
                              std::span<const Vec3d> positions, const Triangle& triangle);

// Whether a limit cylinder of that radius would be crossed.
inline bool crosses(const std::optional<Reach>& reach, double radius) {
  return reach && reach->min <= radius && radius < reach->max;
}

// Their union, by increasing min, no two touching.
std::vector<Reach> merged(std::vector<Reach> all);

// The union of the reaches of all triangles with the normal at the start, by increasing min, no two touching.
std::vector<Reach> merged_reaches(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                  std::span<const Triangle> triangles);

// A short number strictly between low and high, as near the target as its digits let it be: six of them, or more where
// the gap is narrow. Nothing where the gap holds no number.
enum class Round { down, nearest, up };
std::optional<double> short_number_between(double low, double high, double target, Round round, int digits = 6);

// The connected pieces of a shape where r < outer at the stroke's start, and how far from the axis they lie. Two
// triangles are connected by a vertex there. `part` is the piece with the triangle whose corner is nearest to the
// centre.
struct CylinderPieces {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> piece;  // of each triangle: a number, or kNone where it has nothing below
  std::uint32_t part = kNone;        // kNone where nothing is below
  double part_max = 0;               // the part's greatest distance from the axis
  double others = kInfinity;         // the least distance of a piece wholly beyond part_max
  std::size_t blocking = 0;          // triangles of pieces that are partly nearer than that
  double blocking_min = kInfinity;   // and how near
  std::size_t within = 0;            // triangles of pieces that are wholly nearer
  std::vector<Reach> later;          // merged: what triangles cover where a bend's turning normal brings r below outer
};

// The radius of the limit cylinder is not looked at. Time: linear.
CylinderPieces limit_cylinder_pieces(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                     std::span<const Triangle> triangles);

// Between part_max and others, about the middle, off `later` where that can be; nothing where a piece is in the way or
// there is no part.
std::optional<double> radius_in_gap(const CylinderPieces& pieces);

}  // namespace knead::tool_detail
