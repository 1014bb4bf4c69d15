#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "knead/error.h"
#include "knead/tools.h"
#include "strokes/describe.h"
#include "strokes/limit_cylinder.h"
#include "strokes/mirror.h"

#include "math/elementary.h"

namespace knead::tool_detail {

namespace {

constexpr std::size_t kNeighbours = 8;

struct Neighbour {
  double square = 0;  // of the distance
  std::uint32_t point = 0;

  bool operator<(const Neighbour& other) const {
    return std::pair(square, point) < std::pair(other.square, other.point);
  }
};

// For the tree: each point by itself.
std::vector<Triangle> as_triangles(std::size_t points) {
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < points; ++i) triangles.push_back({i, i, i});
  return triangles;
}

// The nearest points to p, nearest first; equally near ones by number.
std::vector<Neighbour> nearest_points(const SurfaceTree& tree, std::span<const Vec3d> points, const Vec3d& p) {
  std::vector<Neighbour> nearest;
  for (const SurfacePoint& found : tree.nearest(p, kNeighbours)) {
    nearest.push_back({norm2(points[found.triangle] - p), found.triangle});
  }
  std::sort(nearest.begin(), nearest.end());
  return nearest;
}

std::optional<Vec3d> unit_or_nothing(const Vec3d& v) {
  const double length = norm(v);
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  return v / length;
}

}  // namespace

SurfaceFinder::SurfaceFinder(const LiveSurface& surface)
    : surface_(surface),
      tree_(surface.triangles.empty() ? SurfaceTree(as_triangles(surface.positions.size()), surface.positions)
                                      : SurfaceTree(surface.triangles, surface.positions)) {
  if (surface.triangles.empty()) return;
  first_.assign(surface.positions.size() + 1, 0);
  for (const Triangle& triangle : surface.triangles) {
    for (const std::uint32_t v : triangle) ++first_[v + 1];
  }
  for (std::size_t v = 0; v < surface.positions.size(); ++v) first_[v + 1] += first_[v];
  around_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const std::uint32_t v : surface.triangles[t]) around_[next[v]++] = static_cast<std::uint32_t>(t);
  }
}

std::optional<PaintSample> SurfaceFinder::closest(const Vec3d& p) const {
  return surface_.triangles.empty() ? closest_in_cloud(p) : closest_on_triangles(p);
}

void SurfaceFinder::follow(const Vec3d& p, double radius) {
  const Vec3d corner{radius, radius, radius};
  tree_.refit(surface_.positions, {p - corner, p + corner});
}

std::optional<PaintSample> SurfaceFinder::closest_on_triangles(const Vec3d& p) const {
  const auto found = tree_.closest(p);
  if (!found) return std::nullopt;
  const Triangle& triangle = surface_.triangles[found->triangle];
  Vec3d sum{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) sum += vertex_normal(triangle[i]) * found->barycentric[i];
  std::optional<Vec3d> normal = unit_or_nothing(sum);
  if (!normal) {  // the two sides of a sheet share their vertices: the triangle's own side counts
    const Vec3d& a = surface_.positions[triangle[0]];
    normal = unit_or_nothing(cross(surface_.positions[triangle[1]] - a, surface_.positions[triangle[2]] - a));
  }
  if (!normal) return std::nullopt;
  return PaintSample{found->point, *normal};
}

std::optional<PaintSample> SurfaceFinder::closest_in_cloud(const Vec3d& p) const {
  if (!surface_.normal || surface_.positions.empty()) return std::nullopt;
  const Vec3d q = surface_.positions[nearest_points(tree_, surface_.positions, p).front().point];
  const std::vector<Neighbour> near = nearest_points(tree_, surface_.positions, q);
  const double reach2 = near.back().square > 0 ? near.back().square : 1;
  Vec3d normal_sum{0, 0, 0};
  Vec3d offset_sum{0, 0, 0};
  double weight_sum = 0;
  for (const Neighbour& neighbour : near) {
    const double weight = std::max(1 - neighbour.square / reach2, 0.0);
    const std::optional<Vec3d> own = unit_or_nothing(surface_.normal(neighbour.point));
    if (!own) continue;
    normal_sum += *own * (weight * weight);
    offset_sum += (surface_.positions[neighbour.point] - q) * (weight * weight);
    weight_sum += weight * weight;
  }
  const std::optional<Vec3d> normal = unit_or_nothing(normal_sum);
  if (!normal) return std::nullopt;
  const Vec3d mean = q + offset_sum / weight_sum;
  const Vec3d foot = p - *normal * dot(*normal, p - mean);
  return PaintSample{norm2(foot - q) <= reach2 ? foot : q, *normal};
}

Vec3d SurfaceFinder::vertex_normal(std::uint32_t vertex) const {
  Vec3d sum{0, 0, 0};
  const Vec3d& p = surface_.positions[vertex];
  for (std::uint32_t k = first_[vertex]; k < first_[vertex + 1]; ++k) {
    const Triangle& triangle = surface_.triangles[around_[k]];
    const auto corner =
        static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), vertex) - triangle.begin());
    const Vec3d a = surface_.positions[triangle[(corner + 1) % 3]] - p;
    const Vec3d b = surface_.positions[triangle[(corner + 2) % 3]] - p;
    const std::optional<Vec3d> normal = unit_or_nothing(cross(a, b));
    if (normal) sum += *normal * elementary::atan2(norm(cross(a, b)), dot(a, b));
  }
  return unit_or_nothing(sum).value_or(Vec3d{0, 0, 0});
}

}  // namespace knead::tool_detail

namespace knead {

namespace {

using tool_detail::CylinderPieces;
using tool_detail::limit_cylinder_pieces;
using tool_detail::radius_in_gap;

// How far the part's triangles go along the axis, away from the outer plane.
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

// How far the centre must at least be moved against the normal for a radius to exist, in 1/24 of the part's length.
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

// The limit cylinder of a twist or bend as if it had a radius.
std::optional<StrokeCylinder> limit_cylinder_to_find(Stroke stroke) {
  const auto any_radius = [](auto& tool) {
    if (!tool.radius_auto) return false;
    tool.radius_auto = false;
    tool.radius = 1;
    return true;
  };
  auto* twist = std::get_if<TwistStroke>(&stroke);
  auto* bend = std::get_if<BendStroke>(&stroke);
  const bool found = (twist != nullptr && any_radius(*twist)) || (bend != nullptr && any_radius(*bend));
  return found ? limit_cylinder_of(stroke) : std::nullopt;
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
  const std::optional<StrokeCylinder> limit_cylinder = limit_cylinder_to_find(stroke);
  if (!limit_cylinder) return stroke;
  const CylinderProposal proposal = propose_limit_cylinder(*limit_cylinder, positions, triangles);
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
