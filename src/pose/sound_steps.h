// Steps that are taken only if their result is sound: the judge of a surface, a surface that refuses unsound steps, and
// the rule for smaller steps and other grids. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

// What makes a step of a surface unsound.
struct StepProblem {
  std::string text;                    // "3 pairs of triangles would cross near [0, 1, 2]"; empty: the step is sound
  std::vector<std::uint32_t> where{};  // corners of triangles that would cross, or would be stretched most
};

// Judges steps of a surface by their result, compared with the surface at the start.
class SoundJudge {
 public:
  // `max_new_crossings`: pairs of triangles that may cross though they did not at the start. If not 0, pairs of two
  // triangles that both crossed others at the start do not count: they are parts of a tangle. `progress` only cancels.
  SoundJudge(std::span<const Vec3d> start, std::span<const Triangle> triangles, std::size_t max_new_crossings,
             int threads, const Progress* progress);

  // Returns why a step is not sound. `max_stretch`: the greatest stretch or compression of a triangle since the start.
  // Time: a search for crossings of the triangles that move. Throws Cancelled.
  StepProblem problem_of(std::span<const Vec3d> before, std::span<const Vec3d> after, double max_stretch) const;

  // Returns the triangles of new crossing pairs, among pairs with one that moves.
  StepProblem crossing_of(std::span<const Vec3d> next, const std::vector<bool>& moves) const;

 private:
  std::vector<Vec3d> start_;
  std::vector<Triangle> triangles_;
  std::size_t max_new_crossings_;
  int threads_;
  const Progress* progress_;
};

// A surface that is moved grid by grid, and stays sound, without any new crossing.
class SoundSurface {
 public:
  // `options`: of the path lines; its progress only cancels.
  SoundSurface(std::span<const Vec3d> positions, std::span<const Triangle> triangles, double max_stretch,
               const AdvectOptions& options);

  // Moves the surface by a grid and returns an empty text. If the surface would not be sound then, it stays, and the
  // text says why. Time: a path line for each vertex that moves, and that of the judge. Throws Cancelled, and the
  // surface stays.
  std::string take(const PotentialGrid& grid);

  // Returns the positions that the grids taken so far lead to.
  const std::vector<Vec3d>& positions() const { return now_; }

 private:
  SoundJudge judge_;
  double max_stretch_;
  std::vector<Vec3d> now_;
  AdvectOptions options_;
  const Progress* progress_;
};

// A motion that is solved step by step.
struct SteppedMotion {
  // Returns the grid of a step from the present state.
  std::function<PotentialGrid(double from, double to)> solve;
  // Makes the grid's result the present state and returns an empty text, or says why it is not sound and changes
  // nothing.
  std::function<std::string(const PotentialGrid&)> take;
  // Sets the spacing of the next grids, as a factor of the first one.
  std::function<void(double factor)> set_spacing;
};

// Returns the motion with parts of the last grid for shorter steps from the same state: these need no equations, and
// corrections shrink with them.
SteppedMotion in_parts(SteppedMotion motion);

// How far a motion came.
struct SoundReach {
  double time = 0;
  std::string problem;  // of the next step; empty: the motion came to its end
};

// Steps through ascending times. A step that is not sound is halved up to five times, then tried on coarser and finer
// grids; if none is sound, the motion ends. A step of no duration that is not sound is left out.
SoundReach step_soundly(std::span<const double> times, const SteppedMotion& motion);

// Takes a grid, or the first of its half, its quarter and so on that is sound. Returns the part that was taken: 0 to 1.
// `take`: as that of SteppedMotion.
double take_soundly(const PotentialGrid& grid, const std::function<std::string(const PotentialGrid&)>& take);

}  // namespace knead::detail
