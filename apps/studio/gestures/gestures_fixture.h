// What tests of gestures share.
#pragma once

#include <vector>

#include "studio_fixture.h"

namespace knead::studio {

class GesturesTest : public StudioTest {
 protected:
  // The strokes of the last entry of the history.
  static std::vector<Stroke> last_strokes(const Studio& studio) {
    std::vector<Stroke> strokes;
    if (studio.shown().history.empty()) return strokes;
    for (const SessionStroke& one : studio.shown().history.back()->strokes) strokes.push_back(one.stroke);
    return strokes;
  }

  static double length_of(const Stroke& stroke) {
    const auto& path = std::get<ImplicitStroke>(stroke).path;
    return norm(path.back() - path.front());
  }
};

}  // namespace knead::studio
