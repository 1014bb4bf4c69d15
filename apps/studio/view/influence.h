// How much of a tool's motion a shape's vertices would have, to be shown as colour before the drag.
#pragma once

#include <span>
#include <vector>

#include "knead/flow.h"
#include "knead/replay.h"

namespace knead::studio {

// For each vertex the weight w = (1 - b)^2 of the inner motion, from 0 (outside) to 1 (inner region), where the flows
// begin; of several the greatest. Evaluated by the fields themselves, in double.
std::vector<float> influence_of(std::span<const Flow> flows, const Snapshot& positions, int threads = 0);

// Returns how far pins take each place, relative to the longest displacement of a pin; empty for an impossible stroke.
std::vector<float> influence_of(const PinsStroke& stroke, const Snapshot& positions, int threads = 0);

}  // namespace knead::studio
