// The steps of a stage: at each moment the rigid rates of all limbs, met by the flow that strains the body least.
// Internal to the skin module.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "pose/near_rigid.h"
#include "skin/rigid.h"

namespace knead::skin_detail {

// Points of a limb that ask for its motion.
struct LimbPoints {
  std::size_t limb = 0;
  bool moves = false;
  std::vector<Vec3d> points;  // where they are when the stage begins
};

struct StageProblem {
  detail::BodySamples body;
  std::vector<LimbPoints> limbs;
  std::function<std::vector<Rigid>(double part)> motions;  // of all limbs, from the shape at rest; part from 0 to 1
  std::size_t steps = 1;
  double spacing = 0;
  double diagonal = 0;
  int threads = 0;
  Progress* progress = nullptr;
};

// Returns the flow of a stage, a grid for each step and one more in which the limbs settle. Points of limbs that come
// so near to another limb that both cannot be met ask for nothing there: the body is flattened between them. `unknowns`
// becomes the most of a grid, if that is more. Throws InvalidInput where the equations cannot be solved, and Cancelled.
Flow stage_flow(StageProblem problem, std::size_t& unknowns);

}  // namespace knead::skin_detail
