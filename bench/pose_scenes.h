// Shapes to pose, and their handles and pins. Part of pose_bench.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "knead/stroke.h"

namespace knead {

// A part that turns as a rigid body while another holds, or one of several pins that follows a path.
struct PoseScene {
  std::string name;
  Mesh mesh;
  std::vector<std::uint32_t> moving{};  // vertices: the part, or the one dragged pin
  std::vector<std::uint32_t> fixed{};   // vertices that stay
  std::optional<HandlesRotation> turn{};
  std::vector<Vec3d> path{};         // of the pin
  std::optional<BendStroke> bend{};  // does about the same as the turn
  double least_strain = 0;           // what a beam of this thickness and free length stretches at least; 0: not known

  // Returns where a vertex of `moving` should be after a part of the time, from 0 to 1.
  Vec3d place_of(std::uint32_t vertex, double part = 1) const;
};

// Returns the procedural scenes: a bar, a cylinder, a hand and an animal with a trunk.
std::vector<PoseScene> procedural_scenes();

// Returns the scenes of a closed mesh: the end of its thinnest limb turns, a pin takes its tip there, and one of eight
// ends is dragged.
std::vector<PoseScene> scenes_of(const std::string& name, const Mesh& mesh);

}  // namespace knead
