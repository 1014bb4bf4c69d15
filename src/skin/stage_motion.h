// One stage of a pose: the flow that meets the limbs' rigid rates and strains the body least. Internal to the skin
// module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/vec.h"
#include "pose/near_rigid.h"
#include "pose/sound_steps.h"
#include "skin/rigid.h"

namespace knead::detail {

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
  BodySamples body;
  std::vector<LimbPoints> limbs;
  std::function<std::vector<Rigid>(double part)> motions;  // of all limbs, from the shape at rest; part from 0 to 1
  bool rest_gives = false;                                 // resting limbs deform, too, where moving limbs come near
  std::size_t steps = 1;
  double spacing = 0;
  double diagonal = 0;
  int threads = 0;
  Progress* progress = nullptr;
  std::function<std::string(const PotentialGrid&)> judge;  // as that of PoseProblem
};

// Returns the flow of a stage: a grid for each step, and one in which the limbs settle; it ends where the judge lets no
// step pass. Points so near to another limb that no smooth field meets both have no wanted rate: the body is flattened
// between the limbs. Raises `unknowns` to that of the largest grid; `reach` says how far the stage came, from 0 to 1.
// Moves the points of the body and the limbs. Throws InvalidInput if the equations cannot be solved, and Cancelled.
Flow stage_flow(StageProblem& problem, std::size_t& unknowns, SoundReach& reach);

// Returns the grid in which the body grows at these rates, one for each of its samples, while the limbs of the problem
// rest. Throws as stage_flow().
PotentialGrid growing_grid(const StageProblem& problem, std::vector<double> growth);

}  // namespace knead::detail
