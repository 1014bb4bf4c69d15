// How far the shape has been stretched, and how far the tool would stretch it, for the view.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/tools.h"
#include "studio.h"

namespace knead::studio {

// The stretch that is drawn in the last colour; 1 is drawn in the first, and equal factors are equally far apart.
inline constexpr double kGreatestShown = 8;

// Returns where a stretch lies between the first colour and the last one, from 0 to 1.
float shade_of_stretch(double stretch);

// Returns for each vertex of the shown shape the greatest stretch of its triangles, since the start or by the last
// stroke (the current one during a gesture); nothing if the places that it is stretched from are not known.
std::optional<std::vector<float>> stretches_shown(const DocumentState& shown, StretchView since);

// Estimates what the tool would do to the shape, and remembers it while nothing changes.
class StretchEstimate {
 public:
  // Returns the estimate for the strokes of the current gesture, or for those that a placed tool would begin with;
  // nothing for tools that are not placed and turned.
  const std::optional<GreatestStretch>& update(const Studio& studio);

 private:
  std::vector<Stroke> strokes_;
  ShapeState state_;
  std::vector<Vec3d> positions_;  // of some vertices of state_
  std::optional<GreatestStretch> estimate_;
};

// Returns one line about a zone that was widened for the current gesture or the placed tool; empty: none was.
std::string zone_note(const Studio& studio);

}  // namespace knead::studio
