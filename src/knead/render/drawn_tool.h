// The tool of a stroke, as plain values to be drawn; needs no renderer.
#pragma once

#include <optional>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/vec3.h"
#include "knead/mesh/mesh.h"

namespace knead::render {

// The shape that a stamp presses in, posed but not moved, and the places of its origin.
struct StampTool {
  Mesh mesh;
  std::vector<Vec3d> path;
};

// The tool of a stroke: its whole way, or the place where it is at a moment, given in segments of the stroke.
struct DrawnTool {
  Flow stroke;
  std::optional<StampTool> stamp;
  std::optional<double> moment;
};

}  // namespace knead::render
