#include "knead/session/surface_stroke.h"

#include <fmt/format.h>

#include <exception>
#include <filesystem>

#include "knead/io/shape_file.h"
#include "knead/math/error.h"
#include "knead/tool/paint.h"
#include "knead/tool/placement.h"
#include "knead/tool/pose.h"
#include "knead/tool/stamp.h"

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

void apply(const MaskStroke& stroke, const LiveSurface& surface) {
  std::vector<Vec3d> points;
  std::vector<double> values;
  for (std::size_t i = 0; i < stroke.vertices.size(); ++i) {
    const VertexRange& range = stroke.vertices[i];
    require_vertex("vertices", surface.positions, range.last);
    for (std::size_t vertex = range.first; vertex <= range.last; ++vertex) {
      points.push_back(surface.positions[vertex]);
      if (!stroke.values.empty()) values.push_back(stroke.values[i]);
    }
  }
  MaskStroke named;
  named.width = stroke.width;
  for (const std::uint32_t i : telling_points(points, values, *stroke.width)) {
    named.points.push_back(points[i]);
    if (!values.empty()) named.values.push_back(values[i]);
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
  if (const auto* path = std::get_if<ImplicitStroke>(&stroke)) return path->path.size();
  if (const auto* relax = std::get_if<RelaxStroke>(&stroke)) return relax->points.size();
  if (const auto* stamp = std::get_if<StampStroke>(&stroke)) return kStepsOfAPiece * stamp->path.size();
  if (const auto* points = std::get_if<PointsStroke>(&stroke)) return points->displacements.size();
  if (std::holds_alternative<PoseStroke>(stroke)) return kStepsOfAPose;
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
  } else if (const auto* mask = std::get_if<MaskStroke>(&stroke)) {
    apply(*mask, surface);
  } else {
    surface.apply(with_found_radius(stroke, surface.positions, surface.triangles, remarks));
  }
  return std::nullopt;
}

}  // namespace knead::session_detail
