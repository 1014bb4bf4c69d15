#include "knead/session/surface_stroke.h"

#include <fmt/format.h>

#include "knead/math/error.h"
#include "knead/tool/paint.h"

namespace knead::session_detail {

namespace {

// The points of a set that was given by its vertices.
void look_up(const char* key, std::span<const Vec3d> positions, std::vector<std::uint32_t>& vertices,
             std::vector<Vec3d>& points) {
  for (const std::uint32_t vertex : vertices) {
    if (vertex >= positions.size()) {
      throw InvalidInput(
          fmt::format("\"{}\" names vertex {}, but the shape has {}, numbered from 0; was the session "
                      "made for another shape?",
                      key, vertex, positions.size()));
    }
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

}  // namespace

std::shared_ptr<const Mesh> tool_mesh_of(const Session& /*session*/, const Stroke& /*stroke*/) { return nullptr; }

std::size_t expected_segments(const Stroke& stroke, const Mesh* /*tool*/) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) return paint_dabs(*paint).aims.size();
  return 1;
}

void apply_on(const Stroke& stroke, const Mesh* /*tool*/, const LiveSurface& surface,
              std::vector<std::string>& remarks) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) paint_on(*paint, surface);
  if (const auto* handles = std::get_if<HandlesStroke>(&stroke)) apply(*handles, surface, remarks);
}

}  // namespace knead::session_detail
