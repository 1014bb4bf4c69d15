#include <fmt/format.h>

#include <algorithm>

#include "knead/math/error.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

constexpr int kMostIterations = 100;

std::vector<StrokeKey> keys(RelaxStroke& s) {
  return {{"points", Quantity::finite, &s.points},
          {"radius", Quantity::positive, &s.radius, Presence::required, "everything farther from each point stays"},
          {"amount", Quantity::other, &s.amount, Presence::optional, "how far vertices move towards the smooth shape"},
          {"surface", Quantity::other, &s.surface, Presence::optional,
           "of the amount, across the surface; 0 moves the vertices in the surface only"},
          {"iterations", Quantity::other, &s.iterations, Presence::optional, "at each point"}};
}

void validate(const RelaxStroke& stroke) {
  require_count("points", stroke.points.size(), 1, "points");
  if (!(stroke.amount > 0 && stroke.amount <= 1)) {
    throw InvalidInput(fmt::format("\"amount\" must be greater than 0 and at most 1, got {}", stroke.amount));
  }
  if (!(stroke.surface >= 0 && stroke.surface <= 1)) {
    throw InvalidInput(fmt::format("\"surface\" must be from 0 to 1, got {}", stroke.surface));
  }
  if (stroke.iterations < 1 || stroke.iterations > kMostIterations) {
    throw InvalidInput(fmt::format("\"iterations\" must be from 1 to {}, got {}", kMostIterations, stroke.iterations));
  }
}

// More than all of the distance is not smoother.
void prolong(RelaxStroke& stroke, double strength) { stroke.amount = std::min(stroke.amount * strength, 1.0); }

}  // namespace

const Tool& RelaxStroke::tool() {
  static const Tool kTool = [] {
    Tool tool = describe<RelaxStroke>("relax", {keys, validate, nullptr, nullptr, nullptr, nullptr, prolong});
    tool.is_flow = false;
    tool.is_event = true;
    return tool;
  }();
  return kTool;
}

}  // namespace knead
