// The joints of a pose. Bones that move alike form a limb, and each limb moves by a screw against the limb before it. A
// stage moves some of the joints by the flow that meets the limbs' rigid rates and strains the body least. Internal to
// the skin module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/skin.h"
#include "pose/near_rigid.h"
#include "pose/sound_steps.h"
#include "skin/rigid.h"

namespace knead::skin_detail {

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

// Points that move with a limb.
struct LimbPoints {
  std::size_t limb = 0;
  bool moves = false;
  std::vector<Vec3d> points;  // at the beginning of the stage
};

// The amount that a stage adds to Progress::done.
inline constexpr std::uint64_t kWorkOfStage = 1000;

// What moves in a stage, and how it is solved for.
struct StageProblem {
  detail::BodySamples body;
  std::vector<LimbPoints> limbs;
  std::function<std::vector<Rigid>(double part)> motions;  // of all limbs, from the shape at rest; part from 0 to 1
  bool rest_gives = false;                                 // resting limbs deform, too, where moving limbs come near
  std::size_t steps = 1;
  double spacing = 0;
  double diagonal = 0;
  int threads = 0;
  Progress* progress = nullptr;
  std::function<std::string(const PotentialGrid&)> judge;  // as that of detail::PoseProblem
};

// Returns the flow of a stage: a grid for each step, and one in which the limbs settle; it ends where the judge lets no
// step pass. Points so near to another limb
// that no smooth field meets both have no wanted rate: the body is flattened between the limbs. Raises `unknowns` to
// that of the largest grid; `reach` says how far the stage came, from 0 to 1. Moves the points of the body and the
// limbs. Throws InvalidInput if the equations cannot be solved, and Cancelled.
Flow stage_flow(StageProblem& problem, std::size_t& unknowns, detail::SoundReach& reach);

// Returns the grid in which the body grows at these rates, one for each of its samples, while the limbs of the problem
// rest. Throws as stage_flow().
PotentialGrid growing_grid(const StageProblem& problem, std::vector<double> growth);

}  // namespace knead::skin_detail
