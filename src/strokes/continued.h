// The connected parts of a set of points and polylines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead::tool_detail {

// Elements by their number: the points first, then the curves.
struct Part {
  std::vector<std::uint32_t> points;
  std::vector<std::uint32_t> curves;
};

// The connected components of the elements under distance < reach, where a polyline is as far as its nearest point.
// In the order of each part's first element, and the elements of a part in their own order. Curves have two or more
// points. Time: about n log n for n points and curve segments, whatever the reach.
std::vector<Part> connected_parts(std::span<const Vec3d> points, std::span<const std::vector<Vec3d>> curves,
                                  double reach);

// The distance of two line segments, squared; a segment's ends may coincide.
double squared_segment_distance(const Vec3d& a0, const Vec3d& a1, const Vec3d& b0, const Vec3d& b1);

// The loops in which a plane cuts a shape.

// Triangles that the plane cuts one after the other, across the edges that it cuts. Not closed at a border.
struct SliceLoop {
  double reach = 0;            // the greatest distance from the plane's point
  bool around_point = false;   // whether the loop goes around that point
  std::uint32_t triangle = 0;  // one of its triangles
};

// For the plane through the point across the normal. Time: linear, and a sort of the edges that are cut.
std::vector<SliceLoop> slice(const Vec3d& point, const Vec3d& normal, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles);

// The innermost loop around the point, if there is one.
std::optional<SliceLoop> innermost(const std::vector<SliceLoop>& loops);

// A smooth curve through the points of a path.

// The curve through all points, in order: a cubic Hermite curve with centripetal parameters (Yuksel, Schaefer and
// Keyser 2011) and tangents of the parabolas through three neighbours, so that few points of a smooth curve give nearly
// the curve that many of them give (third order). A point that repeats the one before counts once.
class PathCurve {
 public:
  explicit PathCurve(std::span<const Vec3d> points);  // 1 or more

  double length() const { return lengths_.back(); }

  // The point at that arc length from the beginning, clamped to [0, length()].
  Vec3d at(double length) const;

 private:
  Vec3d on_piece(std::size_t piece, double fraction) const;

  std::vector<Vec3d> points_;
  std::vector<double> knots_;
  std::vector<Vec3d> tangents_;  // per unit of the knots
  std::vector<double> lengths_;  // at the ends of equal parts of every piece
};

}  // namespace knead::tool_detail

// Strokes that continue others: the new part of a growing stroke, and the pieces of one stroke joined.
namespace knead {

// Returns the part of `now` that `before` lacks, if `now` extends `before`: the rest of an implicit stroke's path,
// the new samples of a painted stroke, or the new points of a relax stroke. `before` followed by this part gives the
// same segments as `now`, bit for bit. Returns nothing if the strokes are equal, or `now` does not extend `before`.
std::optional<Stroke> suffix_since(const Stroke& before, const Stroke& now);

// Returns the flow of that part; works also for point sets with more displacements. The strokes are valid. Nothing for
// relax strokes, which are no flow. Both are mirrored.
std::optional<Flow> flow_suffix_since(const Stroke& before, const Stroke& now, const Mirror& mirror = {});

// Returns whether `next` begins where `last` ended, with the same tool and the same numbers: an implicit stroke or a
// stamp whose path continues, a painted stroke of the same brush, or a relax
// stroke that goes on nearby. Painted strokes do not show whether the pointer
// was released between them.
bool continues(const Stroke& last, const Stroke& next);

// Returns one stroke that gives the result of the two, one after the other, bit for bit. Returns nothing if there is
// none, as for stamps, whose contacts are chosen for a whole stroke.
std::optional<Stroke> joined(const Stroke& last, const Stroke& next);

}  // namespace knead
