// What a person reads about the tools.
#pragma once

#include "gestures/tools.h"
#include "keys.h"

namespace knead::studio {

const char* name_of(DragMode mode);
const char* name_of(HandleMode mode);

// One line: what to do with the tool now.
std::string hint_of(const ToolSettings& settings, const Placed& placed);

// The action that takes the tool into the hand.
Action action_of(ToolKind tool);

}  // namespace knead::studio
