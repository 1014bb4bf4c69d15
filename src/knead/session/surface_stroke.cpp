#include "knead/session/surface_stroke.h"

#include "knead/tool/paint.h"

namespace knead::session_detail {

std::shared_ptr<const Mesh> tool_mesh_of(const Session& /*session*/, const Stroke& /*stroke*/) { return nullptr; }

std::size_t expected_segments(const Stroke& stroke, const Mesh* /*tool*/) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) return paint_dabs(*paint).aims.size();
  return 1;
}

void apply_on(const Stroke& stroke, const Mesh* /*tool*/, const LiveSurface& surface,
              std::vector<std::string>& /*warnings*/) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) paint_on(*paint, surface);
}

}  // namespace knead::session_detail
