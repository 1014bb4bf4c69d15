// What the keys that every stroke may have mean.
#include <algorithm>
#include <cmath>

#include "knead/session/session.h"

namespace knead {

bool is_applied(const SessionStroke& stroke) { return !stroke.off && stroke.strength > 0; }

bool is_plain(const SessionStroke& stroke) {
  return stroke.name.empty() && !stroke.off && stroke.strength == 1 && stroke.duration == 1;
}

Flow flow_of(const SessionStroke& stroke) {
  if (!is_applied(stroke)) return {};
  if (stroke.strength > 1) return flow_of(prolonged(stroke.stroke, stroke.strength));
  Flow flow = flow_of(stroke.stroke);
  return stroke.strength == 1 ? flow : prefix(flow, stroke.strength * static_cast<double>(flow.segments.size()));
}

Session without_off(Session session) {
  std::erase_if(session.strokes, [](const SessionStroke& stroke) { return stroke.off; });
  return session;
}

}  // namespace knead
