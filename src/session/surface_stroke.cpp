#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <utility>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/tools.h"
#include "session/deformed_shape_detail.h"
#include "strokes/pose.h"
#include "strokes/stamp.h"

namespace knead::session_detail {

namespace {

// The points of a set that was given by its vertices.
void look_up(const char* key, std::span<const Vec3d> positions, std::vector<std::uint32_t>& vertices,
             std::vector<Vec3d>& points) {
  for (const std::uint32_t vertex : vertices) {
    require_vertex(key, positions, vertex);
    points.push_back(positions[vertex]);
  }
  vertices.clear();
}

void apply(HandlesStroke stroke, const LiveSurface& surface, std::vector<std::string>& remarks) {
  look_up("full_vertices", surface.positions, stroke.full_vertices, stroke.full);
  look_up("zero_vertices", surface.positions, stroke.zero_vertices, stroke.zero);
  remarks = warnings(stroke);
  surface.apply(stroke);
}

// Masked points, and how much each is masked.
struct MaskedPoints {
  std::vector<Vec3d> points;
  std::vector<double> values;
};

double longest_edge(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return std::sqrt(std::max({norm2(b - a), norm2(c - b), norm2(a - c)}));
}

// Adds points inside the triangles whose three corners are masked, so close that the mask's grid has no gap between
// them: a large face would bend between its corners, which stay. `level`: of each vertex, how much it is masked.
void add_points_between(const LiveSurface& surface, const std::vector<double>& level, double width,
                        MaskedPoints& masked) {
  constexpr double kSpacing = 1.0 / 16;  // of the width: half a cell of the grid
  constexpr double kMax = 4e6;           // with more points, they lie further apart
  std::vector<Triangle> among;
  double squares = 0;
  for (const Triangle& t : surface.triangles) {
    if (std::min({level[t[0]], level[t[1]], level[t[2]]}) == 0) continue;
    among.push_back(t);
    squares += norm2(surface.positions[t[1]] - surface.positions[t[0]]);
  }
  const double spacing = std::max(kSpacing * width, std::sqrt(squares / kMax));
  for (const auto& [i, j, k] : among) {
    const Vec3d& a = surface.positions[i];
    const Vec3d& b = surface.positions[j];
    const Vec3d& c = surface.positions[k];
    const auto pieces = static_cast<int>(std::min(1e3, std::ceil(longest_edge(a, b, c) / spacing)));
    for (int v = 0; v <= pieces && pieces > 1; ++v) {
      for (int w = 0; w + v <= pieces; ++w) {
        const double s = static_cast<double>(v) / pieces;
        const double r = static_cast<double>(w) / pieces;
        if (std::max({s, r, 1 - s - r}) == 1) continue;  // a corner
        masked.points.push_back(a + (b - a) * s + (c - a) * r);
        masked.values.push_back(level[i] + (level[j] - level[i]) * s + (level[k] - level[i]) * r);
      }
    }
  }
}

void apply(const MaskStroke& stroke, const LiveSurface& surface) {
  MaskedPoints masked;
  std::vector<double> level(surface.positions.size(), 0);
  for (std::size_t i = 0; i < stroke.vertices.size(); ++i) {
    const VertexRange& range = stroke.vertices[i];
    require_vertex("vertices", surface.positions, range.last);
    for (std::size_t vertex = range.first; vertex <= range.last; ++vertex) {
      const double value = stroke.values.empty() ? 1 : stroke.values[i];
      masked.points.push_back(surface.positions[vertex]);
      masked.values.push_back(value);
      level[vertex] = std::max(level[vertex], value);
    }
  }
  add_points_between(surface, level, *stroke.width, masked);
  MaskStroke named;
  named.width = stroke.width;
  for (const std::uint32_t i : representative_points(masked.points, masked.values, *stroke.width)) {
    named.points.push_back(masked.points[i]);
    if (!stroke.values.empty()) named.values.push_back(std::clamp(masked.values[i], 0.0, 1.0));
  }
  if (named.points.empty()) named.width.reset();  // all values are 0
  surface.apply(named);
}

}  // namespace

std::shared_ptr<const Mesh> tool_mesh_of(const Stroke& stroke, const std::filesystem::path& folder) {
  const auto* stamp = std::get_if<StampStroke>(&stroke);
  if (stamp == nullptr) return nullptr;
  const std::filesystem::path path = folder / stamp->mesh;
  try {
    return std::make_shared<const Mesh>(read_shape(path).mesh);
  } catch (const std::exception& error) {
    throw InvalidInput(fmt::format("\"mesh\": {}", error.what()));
  }
}

std::size_t expected_segments(const Stroke& stroke, const Mesh* tool) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) return paint_dabs(*paint).aims.size();
  if (const auto* stamp = std::get_if<StampStroke>(&stroke)) return stamp_segments(*stamp, *tool);
  return 1;
}

std::size_t segments_about(const Stroke& stroke) {
  constexpr std::size_t kStepsOfAPiece = 20;  // of a stamp
  constexpr std::size_t kStepsOfAPose = 10;
  constexpr std::size_t kStepsOfAnInflation = 4;
  if (const auto* path = std::get_if<ImplicitStroke>(&stroke)) return path->path.size();
  if (const auto* relax = std::get_if<RelaxStroke>(&stroke)) return relax->points.size();
  if (const auto* stamp = std::get_if<StampStroke>(&stroke)) return kStepsOfAPiece * stamp->path.size();
  if (const auto* points = std::get_if<PointsStroke>(&stroke)) return points->displacements.size();
  if (std::holds_alternative<PoseStroke>(stroke)) return kStepsOfAPose;
  if (std::holds_alternative<InflateStroke>(stroke)) return kStepsOfAnInflation;
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) return paint->samples.size() + 10 * paint->path.size();
  return 1;
}

std::optional<double> apply_on(const Stroke& stroke, const Mesh* tool, int threads, const LiveSurface& surface,
                               std::vector<std::string>& remarks) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) {
    paint_on(*paint, surface);
  } else if (const auto* pressed = std::get_if<StampStroke>(&stroke)) {
    StampResult result = stamp(*pressed, *tool, surface, threads);
    remarks = std::move(result.warnings);
    return result.penetration;
  } else if (const auto* handles = std::get_if<HandlesStroke>(&stroke)) {
    apply(*handles, surface, remarks);
  } else if (const auto* pose = std::get_if<PoseStroke>(&stroke)) {
    remarks = pose_on(*pose, surface, threads).warnings;
  } else if (const auto* inflate = std::get_if<InflateStroke>(&stroke)) {
    inflate_on(*inflate, surface, threads);
  } else if (const auto* mask = std::get_if<MaskStroke>(&stroke)) {
    apply(*mask, surface);
  } else if (const auto* bend = std::get_if<BendStroke>(&stroke); bend != nullptr && bends_body(*bend, surface)) {
    remarks = bend_on(*bend, surface, threads).warnings;
  } else {
    surface.apply(with_found_radius(stroke, surface.positions, surface.triangles, remarks));
  }
  return std::nullopt;
}

}  // namespace knead::session_detail
