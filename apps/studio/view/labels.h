// What is written in the view: the numbers of a gesture at the pointer, and which way is in.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gestures/screen.h"
#include "studio.h"

namespace knead::studio {

// The arrow that shows which vertical movement of the pointer takes the tool into the picture.
struct InArrow {
  Vec3d from;
  Vec3d to;
};

// Returns the arrow for a drag along a line that faces the viewer: of the current gesture, or of the one that would
// begin at the pointer. Nothing for other drags.
std::optional<InArrow> in_arrow(const Studio& studio);

// Returns a number as a person reads it: "12.5 mm", "45\u00b0", "30%".
std::string text_of(const Amount& amount, LengthUnit unit);

// Returns the lines at the pointer: what was typed or dragged, the radius, the change of the volume. Empty without a
// gesture.
std::vector<std::string> numbers_at_pointer(const Studio& studio);

}  // namespace knead::studio
