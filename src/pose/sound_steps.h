// Steps that are taken only where what came out is sound: a surface that refuses what would spoil it, and the rule for
// smaller steps and other grids. Internal to the library.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "knead/field.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

// A surface that is moved grid by grid, and stays sound: no pairs of triangles cross that did not at the start, and
// none is stretched or pressed by more than a factor.
class SoundSurface {
 public:
  // `max_stretch`: of a triangle against the start. `options`: of the path lines; its progress only cancels.
  SoundSurface(std::span<const Vec3d> positions, std::span<const Triangle> triangles, double max_stretch,
               const AdvectOptions& options);

  // Moves the surface by a grid and returns an empty text. If the surface would not be sound then, it stays, and the
  // text says why: "3 pairs of triangles would cross near [0, 1, 2]". Time: a path line for each vertex that moves,
  // and a search for crossings of their triangles. Throws Cancelled, and the surface stays.
  std::string take(const PotentialGrid& grid);

  // Returns the positions that the grids taken so far lead to.
  const std::vector<Vec3d>& positions() const { return now_; }

 private:
  std::string problem_of(const std::vector<Vec3d>& next) const;
  std::string crossing_of(const std::vector<Vec3d>& next, const std::vector<bool>& moves) const;

  std::vector<Vec3d> start_;
  std::vector<Vec3d> now_;
  std::vector<Triangle> triangles_;
  double max_stretch_;
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

// How far a motion came.
struct SoundReach {
  double time = 0;
  std::string problem;  // of the next step; empty: the motion came to its end
};

// Steps through ascending times. A step that is not sound is halved up to five times, then tried on coarser and finer
// grids; if none is sound, the motion ends. A step of no duration that is not sound is left out.
SoundReach step_soundly(std::span<const double> times, const SteppedMotion& motion);

}  // namespace knead::detail
