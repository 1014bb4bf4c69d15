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

// Returns for each vertex whether the stroke moved it. `deformed`: the positions after the stroke. `inverse_image`: the
// inverse images of these, by the stroke's inverse without the limit cylinder.
// - If the inverse image lies outside the limit cylinder, the vertex was not moved.
// - Otherwise, if the vertex lies in the limit cylinder, where the stroke moves resting points away, it was moved.
// - Otherwise the surface decides, since the limit cylinder extends beyond a bent finger's tip, and its image may cover
//   the thumb. No triangle crossed the limit cylinder where anything moved, so connected vertices have one answer.
// - Vertices without triangles, and pieces that stay undecided, were moved if their inverse images lie within the
//   radius.
// Distances are compared with a slack, a length above the error of the inverse images. Time: linear.
std::vector<bool> limit_cylinder_members(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> deformed,
                                         std::span<const Vec3d> inverse_image, std::span<const Triangle> triangles,
                                         double slack);

}  // namespace knead

// Distances of triangles from a limit cylinder's axis.
namespace knead::detail {

// An interval of distances from the axis: min <= distance < max.
struct DistanceRange {
  double min = 0;
  double max = 0;
};

// Returns the distances from the limit cylinder's axis of the triangle's part with normal.(x - center) <= outer;
// nothing if there is no such part. `normal`: the limit cylinder's normal at some moment. Rounds as advect does when it
// decides whether a point is inside.
std::optional<DistanceRange> range_of(const StrokeCylinder& limit_cylinder, const Vec3d& normal,
                                      std::span<const Vec3d> positions, const Triangle& triangle);

// Returns whether a limit cylinder of that radius would cross the triangle.
inline bool crosses(const std::optional<DistanceRange>& range, double radius) {
  return range && range->min <= radius && radius < range->max;
}

// Returns the union of the intervals, by increasing min, no two touching.
std::vector<DistanceRange> merged(std::vector<DistanceRange> all);

// Returns the union of range_of() all triangles with the normal at the start, by increasing min, no two touching.
std::vector<DistanceRange> merged_ranges(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                         std::span<const Triangle> triangles);

// Returns a number between low and high with few digits, as near the target as these allow: six digits, or more if the
// gap is narrow. Returns nothing if the gap contains no number.
enum class Round { down, nearest, up };
std::optional<double> short_number_between(double low, double high, double target, Round round, int digits = 6);

// The connected pieces of a shape where r < outer at the stroke's start, and their distances from the axis. Two
// triangles are connected by a common vertex there. `part` is the piece with the triangle whose corner is nearest to
// the centre.
struct CylinderPieces {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> piece;  // of each triangle: a number, or kNone if no point has r < outer
  std::uint32_t part = kNone;        // kNone if there are no pieces
  double part_max = 0;               // the part's greatest distance from the axis
  double others = kInfinity;         // the least distance of a piece wholly beyond part_max
  std::size_t blocking = 0;          // triangles of pieces that are partly nearer than part_max
  double blocking_min = kInfinity;   // the least distance of these pieces
  std::size_t within = 0;            // triangles of pieces that are wholly nearer than part_max
  std::vector<DistanceRange> later;  // merged: distances of triangles that r < outer covers when a bend's normal turns
};

// Returns the pieces. Ignores the radius of the limit cylinder. Time: linear.
CylinderPieces limit_cylinder_pieces(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                     std::span<const Triangle> triangles);

// Returns a radius between part_max and others, near the middle, and not in `later` if possible. Returns nothing if
// there is no part, or if a piece lies across.
std::optional<double> radius_in_gap(const CylinderPieces& pieces);

}  // namespace knead::detail
