// How strongly a flow or a deformation stretches a shape, and how wide the zone of a bend or twist must be to keep that
// small (method, section 10).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/mat3.h"
#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

// The singular values of a deformation gradient. A small ball becomes an ellipsoid with half axes of so many times its
// radius. Their product is 1 where volume is kept.
struct Stretches {
  double greatest = 1;
  double middle = 1;
  double least = 1;

  friend bool operator==(const Stretches&, const Stretches&) = default;
};

// A stretch above this, or below its inverse, is worth a warning.
inline constexpr double kStrongStretch = 4;

// Returns the singular values of a matrix, the greatest first. Relative error about 1e-15 for well-conditioned
// matrices. Method: one-sided Jacobi rotations (Hestenes 1958).
Stretches stretches_of(const Mat3d& gradient);

// How stretches of a flow are measured.
struct StrainOptions {
  double length = 0;          // that distances refer to, such as the diagonal of the shape's box; above 0
  double step = 1e-4;         // of the length, between the path lines that are compared; above 0
  std::size_t samples = 512;  // at most so many points
  int threads = 0;            // 0: as many as the machine has
};

// Returns the stretches of the map that moves points from the flow's beginning to its end, at each of the points.
// Differences of seven path lines at each point, 1e-4 of the length apart by default, are right to about 1e-5. At a
// barrel's border, where the map is torn, the side counts that is stretched less. Throws InvalidInput where
// validate(flow) does, or if the length is not above 0. A point whose path line cannot be followed gets infinity and 0.
std::vector<Stretches> stretches_of(const Flow& flow, std::span<const Vec3d> points, const StrainOptions& options);

// The greatest and the least stretch of a sample of points; they need not be at the same point.
struct GreatestStretch {
  double greatest = 1;
  double least = 1;
  Vec3d where;              // the point that is deformed most, before the flow
  std::size_t samples = 0;  // points that were looked at; 0: the flow deforms none

  // Returns whether a warning is due.
  bool is_strong() const { return greatest > kStrongStretch || least * kStrongStretch < 1; }
};

// Estimates the greatest stretch of a flow on a shape: the greatest of at most options.samples of its vertices. The
// candidates are the vertices that a segment deforms and not only moves, at its beginning or where it passes; of more
// candidates than samples, evenly spaced ones of the list are taken. The result is the same for every number of
// threads. Cost: about a weight for each vertex and segment, at most 4 million of these (then only every n-th vertex is
// a candidate), and seven path lines for each sample. Throws as stretches_of.
GreatestStretch greatest_stretch(const Flow& flow, std::span<const Vec3d> positions, const StrainOptions& options);

// Returns how many times as fast as the translation of its first field the flow is at its beginning: the greatest speed
// at 2000 evenly spaced ones of the points; 0 for other inner motions. Beside handles that leave little room between
// them the flow runs aside and back faster than they move, and shreds what lies there. Throws where validate(flow)
// does.
double relative_speed(const Flow& flow, std::span<const Vec3d> points, int threads = 0);

// A flow that is faster than so many times its tool moves a shape more beside the tool than with it.
inline constexpr double kStrongSpeed = 2;

// Returns the greatest singular value of the linear map from one triangle to another; nothing if the first has no area.
std::optional<double> triangle_stretch(const std::array<Vec3d, 3>& rest, const std::array<Vec3d, 3>& now);

// Returns for each vertex the greatest stretch of its triangles from `rest` to `now`, which have a position for each
// vertex; 1 for a vertex without triangles that have an area. Time: linear, about 20 ns a triangle.
std::vector<float> vertex_stretches(std::span<const Triangle> triangles, std::span<const Vec3d> rest,
                                    std::span<const Vec3d> now);

// How far a shape reaches from the line {center + s normal} of a bend or twist, in slices of equal height.
struct ZoneProfile {
  Vec3d center;
  Vec3d normal;                    // a unit vector
  Vec3d side{0, 0, 0};             // of a bend: distances count along it, across its axis; zero: all around the line
  std::optional<double> radius{};  // of the barrel beyond which nothing counts
  double first = 0;                // r = normal.(x - center) where the first slice begins
  double height = 0;               // of a slice
  std::vector<double> reach{};     // for each slice the greatest distance; below 0: the slice is empty

  friend bool operator==(const ZoneProfile&, const ZoneProfile&) = default;
};

// Returns the profile of a shape for a bend or twist; an empty one for other strokes. The stroke is valid. Without
// triangles the points count alone. Time: linear, about 10 ns a triangle.
ZoneProfile zone_profile(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles);

// The zone of a bend or twist between its inner and its outer region, and the zone that the shape wants.
// A bend by phi radians of a part that reaches rho from its axis wants a width of 2.4 phi rho; it stretches the part
// about 2 times then. Below 1.6 phi rho it stretches it 3 times and more. A twist of tau radians per length shears the
// part by gamma = tau rho, and stretches it by gamma / 2 + sqrt(1 + gamma^2 / 4).
struct ZoneCheck {
  double reach = 0;          // rho: of what is in the zone, or enters it while a bend turns
  double width = 0;          // outer - inner
  double safe = 0;           // the least width that the stroke wants; of a twist by the same angle over the zone
  double stretch = 0;        // of a twist; 0 for a bend
  bool is_too_thin = false;  // a warning is due: a bend of less than 1.6 phi rho, a twist that stretches over 4 times
};

// Returns the check, or nothing for strokes without such a zone, and where the profile is empty or of another line.
std::optional<ZoneCheck> check_zone(const Stroke& stroke, const ZoneProfile& profile);

// Returns the stroke with its zone widened to ZoneCheck::safe if it is thinner; a twist turns the same angle over it. A
// zone with a barrel keeps its outer border and grows away from it; other zones grow about the centre.
Stroke with_safe_zone(const Stroke& stroke, const ZoneProfile& profile);

// Returns the most degrees of a bend or twist that one edge of the triangles reaches over; 0 for other strokes. The
// flow turns the ends of an edge, which stays straight: from 30 degrees on the triangles may lose a fifth of the
// volume. Time: linear, about 10 ns a triangle.
double most_turn_of_an_edge_deg(const Stroke& stroke, std::span<const Vec3d> positions,
                                std::span<const Triangle> triangles);

// Returns one sentence with the figure that would do if is_too_thin, else nothing.
std::optional<std::string> zone_warning(const Stroke& stroke, const ZoneProfile& profile);

// Returns the greatest `outer` with which an implicit, points, rotate or stretch stroke moves none of the points that
// it leaves at rest now, to three digits: with the points on the boundary of a volume mesh, the widest transition that
// fits into it. Strain falls with the width. Returns nothing for other tools, where no point rests, and where less than
// 5% can be gained. Cost: about 20 times that of FlowReach for each point. Throws InvalidInput as flow_of(stroke).
std::optional<double> widest_outer(const Stroke& stroke, std::span<const Vec3d> boundary, int threads = 0);

}  // namespace knead
