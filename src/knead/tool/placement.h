// Finds places on a shape where a twist or bend moves one part and nothing else.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/math/progress.h"
#include "knead/mesh/triangulate.h"
#include "knead/tool/barrel.h"

namespace knead {

// A radius for a barrel. The part is the connected piece of the shape with r < outer at the start of the stroke that
// has the vertex nearest to the barrel's centre.
struct BarrelProposal {
  std::optional<double> radius;  // with it only the part moves; a short number near the middle of the gap
  double part = 0;               // the part's greatest distance from the axis
  double others = std::numeric_limits<double>::infinity();  // least distance of anything else from the axis beyond that
  std::size_t within = 0;  // triangles of other pieces that are entirely nearer than `part`: they move along
  std::string problem;     // if there is no radius, one sentence: why, and what to do
};

// Returns a radius for the barrel; its own radius is ignored. The radius is the geometric mean of `part` and `others`,
// or 1.25 times `part` if there is nothing else. check_barrel counts no crossing triangle for it, and no later one if
// the gap allows. There is no radius if the shape has nothing below outer, or if another piece is partly nearer to the
// axis than the part's farthest point. Time: linear; about 25 times that to explain why there is no radius.
BarrelProposal propose_barrel(const Barrel& barrel, std::span<const Vec3d> positions,
                              std::span<const Triangle> triangles);

// Returns a twist or bend with its radius "auto" replaced by the one of propose_barrel, and any other stroke unchanged.
// Adds notes to `remarks`. Throws InvalidInput if there is no radius; the message begins with the key in quotes.
Stroke with_found_radius(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                         std::vector<std::string>& remarks);

// A line along a part of a shape, such as a finger or an arm.
struct BarrelQuery {
  Vec3d point;           // inside the part
  Vec3d direction;       // along the part, towards its tip; any length but 0
  Vec3d axis{0, 0, 0};   // of a bend whose sweep must reach nothing else, if possible; 0 disables this
  double angle_deg = 0;  // of that bend
};

// The numbers of a twist or bend that moves the part alone; r = normal.(x - center).
struct BarrelPlacement {
  Vec3d center;
  Vec3d normal;  // unit, away from the tip
  double inner = 0;
  double outer = 0;
  double radius = 0;
  double thickness = 0;  // greatest distance of the part from the line, in the plane through the point
  std::string problem;   // why there is no such place, one sentence; the numbers are then undefined
};

// Returns the place nearest to the point, towards the tip, where a barrel holds the part and nothing else: the part is
// joined to the rest in one place only, the plane r = outer cuts it about as thick as it is at the point, and
// everything else is at least 1.1 times as far from the line as the part. The zone from inner to outer is twice as wide
// as the part is thick, or 1.2 times where the part is short; r = 0 is where a bend is symmetric (kCenterFraction).
// check_barrel accepts the radius. Time: linear for each place tried, 5 ms for 100,000 triangles; the places are a
// quarter of the thickness apart. Throws InvalidInput for a direction or axis that is 0 or not finite; Cancelled if
// `progress` is cancelled.
BarrelPlacement place_barrel(const BarrelQuery& query, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles, const Progress* progress = nullptr);

}  // namespace knead
