#include "knead/tool/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/barrel_pieces.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using tool_detail::barrel_pieces;
using tool_detail::BarrelPieces;
using tool_detail::radius_in_gap;

// How far the part's triangles go along the axis, away from the outer plane.
double length_of(const Barrel& barrel, const BarrelPieces& pieces, std::span<const Vec3d> positions,
                 std::span<const Triangle> triangles) {
  double length = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (pieces.piece[i] != pieces.part) continue;
    for (const std::uint32_t v : triangles[i]) {
      length = std::max(length, -dot(barrel.normal, positions[v] - barrel.center));
    }
  }
  return length;
}

// How far the centre must at least be moved against the normal for a radius to exist, in 1/24 of the part's length.
std::optional<double> freeing_shift(const Barrel& barrel, double length, std::span<const Vec3d> positions,
                                    std::span<const Triangle> triangles) {
  constexpr int kPlaces = 24;
  for (int i = 1; i < kPlaces; ++i) {
    Barrel moved = barrel;
    const double shift = length * i / kPlaces;
    moved.center -= barrel.normal * shift;
    if (radius_in_gap(barrel_pieces(moved, positions, triangles))) return shift;
  }
  return std::nullopt;
}

std::string describe_block(const Barrel& barrel, const BarrelPieces& pieces, std::span<const Vec3d> positions,
                           std::span<const Triangle> triangles) {
  std::string text = fmt::format(
      "where r < \"outer\" the part at \"center\" reaches {:.4g} from the axis, but {} of another part {} nearer, "
      "down to {:.4g}",
      pieces.part_max, pieces.blocking == 1 ? "1 triangle" : fmt::format("{} triangles", pieces.blocking),
      pieces.blocking == 1 ? "comes" : "come", pieces.blocking_min);
  Barrel tight = barrel;
  tight.radius = pieces.part_max;
  const BarrelCheck check = check_barrel(tight, positions, triangles);
  if (check.larger) text += fmt::format("; \"radius\": {} would cross nothing, but move that too", *check.larger);
  const double length = length_of(barrel, pieces, positions, triangles);
  if (const std::optional<double> shift = freeing_shift(barrel, length, positions, triangles)) {
    return text + fmt::format("; move \"center\" by {:.3g} against \"normal\", towards the part's tip", *shift);
  }
  return text + "; turn \"normal\" so that the line through \"center\" runs along the part's middle";
}

// The barrel of a twist or bend as if it had a radius.
std::optional<Barrel> barrel_to_find(Stroke stroke) {
  const auto any_radius = [](auto& tool) {
    if (!tool.radius_auto) return false;
    tool.radius_auto = false;
    tool.radius = 1;
    return true;
  };
  auto* twist = std::get_if<TwistStroke>(&stroke);
  auto* bend = std::get_if<BendStroke>(&stroke);
  const bool found = (twist != nullptr && any_radius(*twist)) || (bend != nullptr && any_radius(*bend));
  return found ? barrel_of(stroke) : std::nullopt;
}

Stroke with_radius(Stroke stroke, double radius) {
  const auto set = [&](auto& tool) {
    tool.radius_auto = false;
    tool.radius = radius;
  };
  if (auto* twist = std::get_if<TwistStroke>(&stroke)) set(*twist);
  if (auto* bend = std::get_if<BendStroke>(&stroke)) set(*bend);
  return stroke;
}

}  // namespace

BarrelProposal propose_barrel(const Barrel& barrel, std::span<const Vec3d> positions,
                              std::span<const Triangle> triangles) {
  check_triangles(triangles, positions);
  const BarrelPieces pieces = barrel_pieces(barrel, positions, triangles);
  BarrelProposal proposal{radius_in_gap(pieces), pieces.part_max, pieces.others, pieces.within, {}};
  if (proposal.radius) return proposal;
  if (triangles.empty()) {
    proposal.problem = "without triangles there is no part to be told from the rest; give \"radius\" as a number";
  } else if (pieces.part == BarrelPieces::kNone) {
    proposal.problem = "nothing of the shape lies where r < \"outer\", so there is nothing to move";
  } else if (pieces.blocking > 0) {
    proposal.problem = describe_block(barrel, pieces, positions, triangles);
  } else {
    proposal.problem = fmt::format(
        "the part at \"center\" reaches {} from the axis, and something else touches it there", pieces.part_max);
  }
  return proposal;
}

Stroke with_found_radius(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                         std::vector<std::string>& remarks) {
  const std::optional<Barrel> barrel = barrel_to_find(stroke);
  if (!barrel) return stroke;
  const BarrelProposal proposal = propose_barrel(*barrel, positions, triangles);
  if (!proposal.radius) throw InvalidInput("\"radius\": \"auto\" finds none: " + proposal.problem);
  if (std::isinf(proposal.others)) {
    remarks.push_back(fmt::format(
        "\"radius\": \"auto\" is {}: all of the shape where r < \"outer\" lies within it, so that it restricts nothing",
        *proposal.radius));
  } else if (proposal.within > 0) {
    remarks.push_back(fmt::format("\"radius\": \"auto\" is {}: {} triangles of other pieces lie within it and move too",
                                  *proposal.radius, proposal.within));
  }
  return with_radius(stroke, *proposal.radius);
}

}  // namespace knead
