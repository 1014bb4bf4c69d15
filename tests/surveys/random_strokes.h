// Random strokes of every tool, of the sizes that people use, for a shape.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "knead/stroke.h"

namespace knead::surveys {

// The tools whose strokes are flows, by the names of session files.
const std::vector<std::string>& tool_names();

// A random stroke of the tool for the shape. Lengths are parts of its box's diagonal; places lie on its surface or near
// it. A stamp presses `stamp_mesh`, the file of a shape within the unit ball about its origin.
Stroke random_stroke(const std::string& tool, const Mesh& mesh, const std::vector<Vec3d>& normals,
                     const std::string& stamp_mesh, std::mt19937_64& random);

}  // namespace knead::surveys
