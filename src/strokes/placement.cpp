// Finds the radius of a limit cylinder that holds one part of a shape and nothing else.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "strokes/describe.h"
#include "strokes/limit_cylinder.h"

namespace knead {

namespace {

using namespace detail;

// Returns the extent of the part's triangles along the axis, from the outer plane.
double length_of(const StrokeCylinder& limit_cylinder, const CylinderPieces& pieces, std::span<const Vec3d> positions,
                 std::span<const Triangle> triangles) {
  double length = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (pieces.piece[i] != pieces.part) continue;
    for (const std::uint32_t v : triangles[i]) {
      length = std::max(length, -dot(limit_cylinder.normal, positions[v] - limit_cylinder.center));
    }
  }
  return length;
}

// Returns the least displacement of the centre against the normal for which a radius exists, in steps of 1/24 of the
// part's length.
std::optional<double> freeing_shift(const StrokeCylinder& limit_cylinder, double length,
                                    std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  constexpr int kPlaces = 24;
  for (int i = 1; i < kPlaces; ++i) {
    StrokeCylinder moved = limit_cylinder;
    const double shift = length * i / kPlaces;
    moved.center -= limit_cylinder.normal * shift;
    if (radius_in_gap(limit_cylinder_pieces(moved, positions, triangles))) return shift;
  }
  return std::nullopt;
}

std::string describe_block(const StrokeCylinder& limit_cylinder, const CylinderPieces& pieces,
                           std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  std::string text = fmt::format(
      "where r < \"outer\" the part at \"center\" reaches {:.4g} from the axis, but {} of another part {} nearer, "
      "down to {:.4g}",
      pieces.part_max, pieces.blocking == 1 ? "1 triangle" : fmt::format("{} triangles", pieces.blocking),
      pieces.blocking == 1 ? "comes" : "come", pieces.blocking_min);
  StrokeCylinder tight = limit_cylinder;
  tight.radius = pieces.part_max;
  const CylinderCheck check = check_limit_cylinder(tight, positions, triangles);
  if (check.larger) text += fmt::format("; \"radius\": {} would cross nothing, but move that too", *check.larger);
  const double length = length_of(limit_cylinder, pieces, positions, triangles);
  if (const std::optional<double> shift = freeing_shift(limit_cylinder, length, positions, triangles)) {
    return text + fmt::format("; move \"center\" by {:.3g} against \"normal\", towards the part's tip", *shift);
  }
  return text + "; turn \"normal\" so that the line through \"center\" runs along the part's middle";
}

// The radius of the limit cylinder of a twist or bend, if it is automatic.
std::optional<AutoNumber> automatic_radius(Stroke& stroke) {
  if (!has_zone(stroke)) return std::nullopt;
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    const auto* radius = std::get_if<AutoNumber>(&key.value);
    if (radius != nullptr && *radius->is_auto) return *radius;
  }
  return std::nullopt;
}

}  // namespace

CylinderProposal propose_limit_cylinder(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                        std::span<const Triangle> triangles) {
  check_triangles(triangles, positions);
  const CylinderPieces pieces = limit_cylinder_pieces(limit_cylinder, positions, triangles);
  CylinderProposal proposal{radius_in_gap(pieces), pieces.part_max, pieces.others, pieces.within, {}};
  if (proposal.radius) return proposal;
  if (triangles.empty()) {
    proposal.problem = "without triangles there is no part to be told from the rest; give \"radius\" as a number";
  } else if (pieces.part == CylinderPieces::kNone) {
    proposal.problem = "nothing of the shape lies where r < \"outer\", so there is nothing to move";
  } else if (pieces.blocking > 0) {
    proposal.problem = describe_block(limit_cylinder, pieces, positions, triangles);
  } else {
    proposal.problem = fmt::format(
        "the part at \"center\" reaches {} from the axis, and something else touches it there", pieces.part_max);
  }
  return proposal;
}

Stroke with_found_radius(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                         std::vector<std::string>& remarks) {
  Stroke result = stroke;
  const std::optional<AutoNumber> radius = automatic_radius(result);
  if (!radius) return result;
  *radius->is_auto = false;
  *radius->value = 1;  // any
  const CylinderProposal proposal = propose_limit_cylinder(*limit_cylinder_of(result), positions, triangles);
  if (!proposal.radius) throw InvalidInput("\"radius\": \"auto\" finds none: " + proposal.problem);
  if (std::isinf(proposal.others)) {
    remarks.push_back(fmt::format(
        "\"radius\": \"auto\" is {}: all of the shape where r < \"outer\" lies within it, so that it restricts nothing",
        *proposal.radius));
  } else if (proposal.within > 0) {
    remarks.push_back(fmt::format("\"radius\": \"auto\" is {}: {} triangles of other pieces lie within it and move too",
                                  *proposal.radius, proposal.within));
  }
  *radius->value = *proposal.radius;
  return result;
}

void detail::resolve_radius(const Stroke& stroke, SurfaceRun& run) {
  run.surface.apply(with_found_radius(stroke, run.surface.positions, run.surface.triangles, run.remarks));
}

}  // namespace knead
