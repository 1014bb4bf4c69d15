#include "knead/tool/stamp_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/math/error.h"
#include "knead/math/sincos.h"
#include "knead/mesh/measures.h"

namespace knead::tool_detail {

namespace {

void require_solid(const Mesh& mesh) {
  const Measures measures = measure(mesh);
  if (measures.faces == 0) throw InvalidInput("\"mesh\" must be a closed surface, and this has no faces");
  if (!measures.closed()) {
    throw InvalidInput(fmt::format("\"mesh\" must be a closed surface, and this has {} boundary edges; close its holes",
                                   measures.boundary_edges));
  }
  if (!measures.oriented()) {
    throw InvalidInput(
        fmt::format("\"mesh\" must have faces that look outward, and along {} edges they disagree; "
                    "orient them alike",
                    measures.misoriented_edges));
  }
  if (!(measures.volume > 0)) {
    throw InvalidInput(
        "\"mesh\" must have faces that look outward, and these look inward or enclose nothing; "
        "turn them round");
  }
}

std::vector<Vec3d> posed_solid(const Mesh& mesh, const Mat3d& pose) {
  require_solid(mesh);
  std::vector<Vec3d> positions = mesh.positions;
  for (Vec3d& p : positions) p = pose * p;
  return positions;
}

// Unit vectors across a direction, evenly spread over half a turn.
std::vector<Vec3d> directions_across(const Vec3d& direction, int count) {
  const Vec3d a = any_orthogonal(direction);
  const Vec3d b = cross(direction, a);
  std::vector<Vec3d> result;
  for (int k = 0; k < count; ++k) {
    const SinCos<double> turn = sincos(std::numbers::pi * k / count);
    result.push_back(a * turn.cos + b * turn.sin);
  }
  return result;
}

}  // namespace

StampTool::StampTool(const Mesh& mesh, const Mat3d& pose)
    : positions_(posed_solid(mesh, pose)), triangles_(triangulate(mesh)), tree_(triangles_, positions_) {
  for (const Triangle& t : triangles_) {
    for (const std::uint32_t v : t) box_.extend(positions_[v]);
  }
}

Vec3d StampTool::normal_of(std::uint32_t triangle) const {
  const Triangle& t = triangles_[triangle];
  const Vec3d normal = cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
  const double length = norm(normal);
  return length > 0 ? normal / length : Vec3d{0, 0, 0};
}

// A ray that leaves more often than it enters starts inside, and is out where it has left as often as that.
std::optional<StampTool::Front> StampTool::front(const Vec3d& p, const Vec3d& direction) const {
  const std::vector<RayHit> hits = tree_.hits(p, direction);
  int inside = 0;
  for (const RayHit& hit : hits) inside += hit.leaves ? 1 : -1;
  if (inside <= 0) return std::nullopt;
  for (const RayHit& hit : hits) {
    inside -= hit.leaves ? 1 : -1;
    if (inside <= 0) return Front{hit.t, normal_of(hit.triangle)};
  }
  return std::nullopt;
}

Vec3d StampTool::nearest_normal(const Vec3d& p) const { return normal_of(tree_.closest(p)->triangle); }

std::optional<Vec3d> StampTool::way_out(const Vec3d& p) const {
  if (!front(p, {0, 0, 1})) return std::nullopt;
  return tree_.closest(p)->point - p;
}

double StampTool::distance(const Vec3d& p) const { return norm(tree_.closest(p)->point - p); }

double StampTool::depth(const Vec3d& p) const {
  const std::optional<Vec3d> way = way_out(p);
  return way ? norm(*way) : 0.0;
}

double StampTool::half_width(const Vec3d& direction) const {
  double largest = 0;
  for (const Vec3d& across : directions_across(direction, 64)) {
    double low = dot(across, positions_[triangles_[0][0]]);
    double high = low;
    for (const Triangle& t : triangles_) {
      for (const std::uint32_t v : t) {
        low = std::min(low, dot(across, positions_[v]));
        high = std::max(high, dot(across, positions_[v]));
      }
    }
    largest = std::max(largest, high - low);
  }
  return largest / 2;
}

std::optional<double> StampTool::width_at(const Vec3d& p, std::span<const Vec3d> across) const {
  std::vector<double> chords;
  for (const Vec3d& way : across) {
    const std::optional<Front> there = front(p, way);
    const std::optional<Front> back = front(p, -way);
    if (!there || !back) return std::nullopt;
    chords.push_back(there->need + back->need);
  }
  std::nth_element(chords.begin(), chords.begin() + 2, chords.end());
  return chords[2];
}

// Beside a wall the chords along it are short however wide the tool: so of eight chords, evenly turned, the third
// shortest counts, which is at most 1.2 times the width of a bar.
double StampTool::narrowest_width(const Vec3d& direction, double below) const {
  constexpr std::size_t samples = 128;
  constexpr double left_out = 0.05;
  const std::vector<Vec3d> across = directions_across(direction, 8);
  std::vector<std::pair<double, double>> widths;  // and the area that each stands for
  double area = 0;
  const std::size_t stride = std::max<std::size_t>(1, triangles_.size() / samples);
  for (std::size_t t = 0; t < triangles_.size(); t += stride) {
    const std::array<Vec3d, 3> c = {positions_[triangles_[t][0]], positions_[triangles_[t][1]],
                                    positions_[triangles_[t][2]]};
    const double facing = dot(cross(c[1] - c[0], c[2] - c[0]), direction);
    if (!(facing > 0)) continue;
    const Vec3d face = (c[0] + c[1] + c[2]) / 3;
    const std::optional<Front> back = front(face - direction * (1e-6 * below), -direction);
    if (!back) continue;
    const std::optional<double> width = width_at(face - direction * std::min(below, back->need / 2), across);
    if (!width) continue;
    widths.emplace_back(*width, facing);
    area += facing;
  }
  std::sort(widths.begin(), widths.end());
  double counted = 0;
  for (const auto& [width, share] : widths) {
    counted += share;
    if (counted > left_out * area) return width;
  }
  return 2 * half_width(direction);
}

}  // namespace knead::tool_detail
