// What the keys that every stroke may have mean.
#include <algorithm>
#include <cmath>

#include "knead/session/session.h"
#include "knead/tool/mirror.h"

namespace knead {

bool is_applied(const SessionStroke& stroke) { return !stroke.off && stroke.strength > 0; }

bool is_plain(const SessionStroke& stroke) {
  return stroke.name.empty() && !stroke.off && stroke.strength == 1 && stroke.duration == 1 && stroke.mirror.empty();
}

Flow flow_of(const SessionStroke& stroke) {
  if (!is_applied(stroke)) return {};
  if (stroke.strength > 1) return flow_of(prolonged(stroke.stroke, stroke.strength), stroke.mirror);
  Flow flow = flow_of(stroke.stroke, stroke.mirror);
  return stroke.strength == 1 ? flow : prefix(flow, stroke.strength * static_cast<double>(flow.segments.size()));
}

namespace {

// Whether the stroke does the same without its mirror.
bool is_own_image(const SessionStroke& stroke) {
  if (reads_surface(stroke.stroke)) return false;
  return flow_of(stroke.stroke, stroke.mirror) == flow_of(stroke.stroke);
}

}  // namespace

std::vector<SessionStroke> mirrored_in(std::vector<SessionStroke> strokes, const Mirror& mirror) {
  validate(mirror);
  const std::vector<SymmetryImage> images = images_in(mirror);
  for (SessionStroke& stroke : strokes) {
    if (std::holds_alternative<MaskStroke>(stroke.stroke) || mirror.empty()) continue;
    if (!is_flow(stroke.stroke)) {
      stroke.stroke = symmetric_strokes({{stroke.stroke}}, images, 0, {}).front();
      continue;
    }
    SessionStroke with = stroke;
    for (const MirrorPlane& plane : mirror) {
      if (std::find(with.mirror.begin(), with.mirror.end(), plane) == with.mirror.end()) with.mirror.push_back(plane);
    }
    validate(with.mirror);
    if (!is_own_image(with)) stroke = std::move(with);
  }
  return strokes;
}

Session without_off(Session session) {
  std::erase_if(session.strokes, [](const SessionStroke& stroke) { return stroke.off; });
  return session;
}

}  // namespace knead
