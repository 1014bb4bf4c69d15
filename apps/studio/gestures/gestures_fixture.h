// What tests of gestures share.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "knead/flow.h"
#include "studio_fixture.h"

namespace knead::studio {

class GesturesTest : public StudioTest {
 protected:
  // The strokes of the last entry of the history.
  static std::vector<Stroke> last_strokes(const Studio& studio) {
    std::vector<Stroke> strokes;
    if (studio.document().shown().history.empty()) return strokes;
    for (const SessionStroke& one : studio.document().shown().history.back()->strokes) strokes.push_back(one.stroke);
    return strokes;
  }

  static double length_of(const Stroke& stroke) {
    const auto& path = std::get<ImplicitStroke>(stroke).path;
    return norm(path.back() - path.front());
  }
};

// --- what tests of pins share ----------------------------------------------------------------------------------------

class PinsTest : public GesturesTest {
 protected:
  // A ball with three pins; the second is to the right, the third at the top.
  static std::string three_pins(int vertices = 10242) {
    return ball(vertices) + R"({"tool": "pins"}
{"click": [-0.4, 0, 0.9]}
{"click": [0.5, 0, 0.86]}
{"click": [0, 0.5, 0.86]}
)";
  }

  static PinsStroke last_stroke(const Studio& studio) { return std::get<PinsStroke>(last_strokes(studio).front()); }

  static const std::vector<Pin>& pins(const Studio& studio) { return studio.tools().placed().pins; }

  // How far advecting a point may err, twice: as the stroke's own tests.
  static double slack(const Studio& studio) {
    return 2 * kDefaultRelativeTolerance * studio.document().shown().diagonal;
  }

  // The pin is on a vertex of the shape as it is.
  static bool is_on_vertex(const Studio& studio, const Pin& pin) {
    const std::vector<Vec3d> now = positions(studio);
    return std::find(now.begin(), now.end(), pin.place) != now.end();
  }
};

}  // namespace knead::studio
