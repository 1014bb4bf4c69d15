#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/field/region.h"
#include "knead/tool/barrel_pieces.h"
#include "knead/tool/check.h"
#include "knead/tool/placement.h"
#include "knead/tool/slice.h"

namespace knead {

namespace {

using namespace tool_detail;

constexpr double kSpread = 1.6;   // times the thickness: the farthest that the part may reach in the plane r = outer
constexpr double kMargin = 1.1;   // distance of everything else over that of the part
constexpr double kStride = 0.25;  // of the thickness: from place to place
constexpr int kMostPlaces = 200;

struct Shape {
  std::span<const Vec3d> positions;
  std::span<const Triangle> triangles;
};

// Checks that the part is joined to the rest in one place only, about as thick there as at the point. Returns the
// problem, or nothing.
std::string root_problem(const Barrel& barrel, const BarrelPieces& pieces, double thickness, const Shape& shape) {
  const auto loops =
      slice(barrel.center + barrel.normal * barrel.outer, barrel.normal, shape.positions, shape.triangles);
  const std::optional<SliceLoop> root = innermost(loops);
  if (!root || pieces.piece[root->triangle] != pieces.part) return "its root does not go around the line";
  if (root->reach > kSpread * thickness) {
    return fmt::format("it is {:.3g} thick at its root, against {:.3g} at the point", root->reach, thickness);
  }
  const auto roots = std::count_if(loops.begin(), loops.end(),
                                   [&](const SliceLoop& loop) { return pieces.piece[loop.triangle] == pieces.part; });
  return roots == 1 ? "" : fmt::format("it is joined to the rest in {} places", roots);
}

// Returns the part's height over the centre, towards the tip.
double length_of(const Barrel& barrel, const BarrelPieces& pieces, const Shape& shape) {
  double length = 0;
  for (std::size_t i = 0; i < shape.triangles.size(); ++i) {
    if (pieces.piece[i] != pieces.part) continue;
    for (const std::uint32_t v : shape.triangles[i]) {
      length = std::max(length, -dot(barrel.normal, shape.positions[v] - barrel.center));
    }
  }
  return length;
}

// Completes the proposal at its centre, or says what is wrong there.
void try_place(BarrelPlacement& proposal, const Vec3d& last_normal, const Shape& shape) {
  const Barrel barrel{proposal.center, proposal.normal, 0, proposal.outer, last_normal};
  const BarrelPieces pieces = barrel_pieces(barrel, shape.positions, shape.triangles);
  const std::optional<double> radius = radius_in_gap(pieces);
  if (!radius || pieces.others < kMargin * pieces.part_max) {
    proposal.problem = "something else is as near to the line as the part's farthest point";
  } else if (length_of(barrel, pieces, shape) <= -proposal.inner) {
    proposal.problem = "it ends before the motion's inner region begins";
  } else {
    proposal.problem = root_problem(barrel, pieces, proposal.thickness, shape);
    proposal.radius = *radius;
  }
}

// With a zone of that width: from the point towards the tip, to the first place that will do.
BarrelPlacement first_place(const BarrelQuery& query, const Vec3d& direction, double thickness, double width,
                            const Shape& shape, const Progress* progress) {
  BarrelPlacement proposal{query.point, -direction, -kCenterFraction * width, (1 - kCenterFraction) * width, 0,
                           thickness,   {}};
  Vec3d last_normal = proposal.normal;
  if (query.axis != Vec3d{0, 0, 0}) {
    last_normal = rotate(proposal.normal, unit(query.axis), sincos(0.5 * query.angle_deg * kRadiansPerDegree));
  }
  std::string first_problem;
  for (int i = 0; i < kMostPlaces; ++i) {
    stop_if_cancelled(progress);
    proposal.center = query.point + direction * (kStride * thickness * i);
    if (!innermost(slice(proposal.center, proposal.normal, shape.positions, shape.triangles))) break;  // past the tip
    try_place(proposal, last_normal, shape);
    if (proposal.problem.empty()) return proposal;
    if (i == 0) first_problem = proposal.problem;
  }
  proposal.problem = first_problem;
  return proposal;
}

}  // namespace

BarrelPlacement place_barrel(const BarrelQuery& query, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles, const Progress* progress) {
  check_triangles(triangles, positions);
  require_finite("point", query.point);
  require_direction("direction", query.direction);
  require_finite("axis", query.axis);
  require_angle("angle_deg", query.angle_deg);
  const Shape shape{positions, triangles};
  const Vec3d direction = unit(query.direction);
  const std::optional<SliceLoop> around = innermost(slice(query.point, direction, positions, triangles));
  BarrelPlacement proposal;
  if (!around) {
    proposal.problem =
        "there is no limb at this point: nothing goes around it across the direction; choose a part such as a finger, "
        "an arm or a neck, between its ends";
    return proposal;
  }
  for (const double zone : {2.0, 1.2}) {
    proposal = first_place(query, direction, around->reach, zone * around->reach, shape, progress);
    if (proposal.problem.empty()) return proposal;
  }
  proposal.problem = fmt::format(
      "from the point to the tip there is no place where the part can be moved alone: at the point {}; choose a "
      "point nearer to the tip, or a direction along the middle of the part",
      proposal.problem);
  return proposal;
}

}  // namespace knead
