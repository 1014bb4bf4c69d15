// The joints of a pose. Bones that move alike form a limb, and each limb moves by a screw against the limb before it. A
// stage moves some of the joints. Internal to the skin module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/fit.h"
#include "knead/mesh.h"
#include "skin/rigid.h"

namespace knead::detail {

// Bones that move together, and their motion against the limb before them.
struct SkinLimb {
  std::optional<std::size_t> before;  // the limb before it; none: the base, which rests
  std::uint32_t bone = 0;             // its bone with most of the surface
  Screw screw{};                      // from rest to the pose, against the limb before it
  Vec3d center{0, 0, 0};              // of the flesh that bends, at rest
  Vec3d direction{0, 0, 1};           // along the limb there: a unit vector
  double radius = 0;                  // of the limb there; 0: no flesh bends
  std::size_t stage = 0;              // in which it moves
  double reached = 1;                 // the part of the screw that was sound

  // Returns the length along the limb over which the flesh must bend to keep at least 0.6 of its length.
  double bending_length() const;
};

// The limbs of a pose, each after the limb before it, and their weights at the vertices.
struct Joints {
  std::vector<SkinLimb> limbs;
  std::vector<std::size_t> begin;   // as Skin::begin
  std::vector<BoneWeight> weights;  // `bone` is a limb; those of a vertex sum to 1
  Rigid base{};                     // the motion of the whole shape
  std::size_t stages = 0;
  std::vector<double> spacing;  // of the grids of each stage, a length
  std::vector<bool> is_thin;    // of each stage: it moves fingers and the like
  std::vector<std::string> notes;

  // Returns the motion of each limb after a part of a stage, from 0 to 1: limbs of earlier stages have moved, those of
  // later ones have not.
  std::vector<Rigid> motions(std::size_t stage, double part) const;

  // Returns the limb with the greatest weight at a vertex; the base for a vertex without weights.
  std::size_t main_limb(std::size_t vertex) const;

  // Returns for each limb the limb with which it moves as one rigid body in a stage: itself if its joint turns then, or
  // else that of the limb before it. With `stages` as the stage, which no joint turns in, that is the base.
  std::vector<std::size_t> bodies(std::size_t stage) const;

  // Returns the body of which the limbs have together more than this weight at a vertex. `bodies`: of each limb.
  std::optional<std::size_t> rigid_body(std::span<const std::size_t> bodies, std::size_t vertex, double weight) const;

  // Returns the limb with more than this weight at a vertex.
  std::optional<std::size_t> rigid_limb(std::size_t vertex, double weight) const;
};

// Returns the joints of a valid pose. `detail`: spacing of the grids in radii of the limbs; 0: 2, and 1.5 for thin
// ones.
Joints find_joints(std::span<const Vec3d> positions, std::span<const Triangle> triangles, const Skin& skin,
                   const SkinPose& pose, double detail);

// Returns the parent of each bone, or -1: that of the skin; if it names none, that in a tree of bones that share
// vertices.
std::vector<std::int32_t> parents_of(const Skin& skin, std::size_t vertices);

}  // namespace knead::detail
