// The joints of a pose: bones that move alike are one limb, and a limb turns about a screw against the one before it. A
// stage moves some of them: at each moment all limbs ask for their rigid rates, met by the flow that strains the body
// least. Internal to the skin module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/skin.h"
#include "pose/near_rigid.h"
#include "skin/rigid.h"

namespace knead::skin_detail {

// Bones that move together, and where they are against the limb before them.
struct SkinLimb {
  std::optional<std::size_t> before;  // the limb that it hangs on; none: the base, which rests
  std::uint32_t bone = 0;             // one of its bones, the one with most of the surface
  Screw screw{};                      // from rest to the pose, against the limb before it
  Vec3d center{0, 0, 0};              // of the flesh that bends, at rest
  Vec3d direction{0, 0, 1};           // along the limb there: a unit vector
  double radius = 0;                  // of the limb there; 0: no flesh bends
  std::size_t stage = 0;              // when it moves

  // How far along the limb the flesh has to bend, so that it is not squeezed to less than 0.6.
  double bending_length() const;
};

// The limbs of a pose, each after the one that it hangs on, and how the vertices hang on them.
struct Joints {
  std::vector<SkinLimb> limbs;
  std::vector<std::size_t> begin;   // as Skin::begin
  std::vector<BoneWeight> weights;  // `bone` is a limb; those of a vertex sum to 1
  Rigid base{};                     // how the whole shape moves besides
  std::size_t stages = 0;
  std::vector<double> spacing;  // of the grids of each stage, a length
  std::vector<bool> is_thin;    // of each stage: it moves fingers and the like
  std::vector<std::string> notes;

  // The motion of each limb at a moment of a stage: limbs of earlier stages have moved, those of later ones have not.
  std::vector<Rigid> motions(std::size_t stage, double part) const;

  // The limb to which a vertex hangs most; the base for one without weights.
  std::size_t main_limb(std::size_t vertex) const;

  // The limb to which a vertex hangs by more than that weight.
  std::optional<std::size_t> rigid_limb(std::size_t vertex, double weight) const;
};

// Returns the joints of a valid pose. `detail`: spacing of the grids over the limbs' radius; 0: the usual one.
Joints find_joints(std::span<const Vec3d> positions, std::span<const Triangle> triangles, const Skin& skin,
                   const SkinPose& pose, double detail);

// Returns the parent of each bone, or -1: those of the skin, or if it names none a tree of bones that share vertices.
std::vector<std::int32_t> parents_of(const Skin& skin, std::size_t vertices);

// Points of a limb that ask for its motion.
struct LimbPoints {
  std::size_t limb = 0;
  bool moves = false;
  std::vector<Vec3d> points;  // where they are when the stage begins
};

// What a stage adds to Progress::done.
inline constexpr std::uint64_t kWorkOfStage = 1000;

struct StageProblem {
  detail::BodySamples body;
  std::vector<LimbPoints> limbs;
  std::function<std::vector<Rigid>(double part)> motions;  // of all limbs, from the shape at rest; part from 0 to 1
  bool rest_gives = false;  // what rests is pressed flat, too, where limbs that move come near
  std::size_t steps = 1;
  double spacing = 0;
  double diagonal = 0;
  int threads = 0;
  Progress* progress = nullptr;
};

// Returns the flow of a stage, a grid for each step and one more in which the limbs settle. Points of limbs that come
// so near to another limb that both cannot be met ask for nothing there: the body is flattened between them. `unknowns`
// becomes the most of a grid, if that is more. Throws InvalidInput where the equations cannot be solved, and Cancelled.
// Afterwards the points of the body and the limbs are where the stage takes them.
Flow stage_flow(StageProblem& problem, std::size_t& unknowns);

// Returns the grid in which the body grows at these rates, one for each of its samples, while the limbs that are given
// rest. Throws as
// stage_flow.
PotentialGrid growing_grid(const StageProblem& problem, std::vector<double> growth);

}  // namespace knead::skin_detail
