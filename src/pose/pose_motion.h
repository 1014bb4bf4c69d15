// Poses: parts and pins move to their targets, and the body follows as rigidly as it can. Contains no mesh. Internal to
// the library.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pose/near_rigid.h"

namespace knead::detail {

// Points that move rigidly at a constant rate: a rotation about an axis and a translation. By default they hold.
struct PosedPart {
  std::vector<Vec3d> points;
  Vec3d axis{0, 0, 1};  // a unit vector
  Vec3d center{0, 0, 0};
  double angle = 0;  // radians
  Vec3d translation{0, 0, 0};
  // Replaces the centre and translation: the position of a point at a time from 0 to 1. `angle` is then the greatest
  // turn.
  std::function<Vec3d(const Vec3d& start, double time)> way{};
  std::vector<Vec3d> checked{};  // more of its points, which only count for PoseOutcome::part_distance

  bool holds() const { return !way && angle == 0 && translation == Vec3d{0, 0, 0}; }
};

// A point that follows a path. Everything within `size` of it moves as a rigid patch.
struct PosedPin {
  std::vector<Vec3d> path;  // 1 or more positions, from that of the point; only one: the pin holds
  double size = 0;
  std::optional<Vec3d> turn;  // of the patch: an axis times radians; std::nullopt: the body determines it
};

// What moves, and how it is solved for.
struct PoseProblem {
  BodySamples body;
  std::vector<PosedPart> parts;
  std::vector<PosedPin> pins;
  std::optional<Vec3d> across{};    // a unit vector along which motion is resisted
  double spacing = 0;               // of the grids
  double most_spacing = 0;          // the widest spacing, if the unknowns would be too many:
  std::size_t max_unknowns = 9000;  // with more, the first step widens the spacing; later steps at a third more
  double diagonal = 0;              // of the shape: accuracy is relative to it
  bool settles = true;              // a last step of no duration moves parts exactly to their targets
  double tolerance = 0;  // up to five more such steps while parts or pins miss their targets by more; 0: none
  // Takes the result of a grid and returns an empty text, or says why it is not sound. Null: everything is.
  std::function<std::string(const PotentialGrid&)> judge{};
  int threads = 0;
  Progress* progress = nullptr;
};

// The result of a pose.
struct PoseOutcome {
  std::size_t segments = 0;
  std::size_t unknowns = 0;           // of the segment with most
  double part_distance = 0;           // the greatest distance of a part's point or of a pin from its target
  bool stopped = false;               // apply returned false
  double reached = 1;                 // the fraction of the pose that was sound; the targets are those of this moment
  std::string problem{};              // what was not sound beyond it
  std::vector<Vec3d> reached_points;  // the final positions of the points of parts and of the pins
  std::vector<Vec3d> places;          // their targets
};

// A pose in progress, with the present positions of the body, parts and pins. No grid turns a part by more than 8
// degrees, or moves it by more than 0.03 of the diagonal, within 0.5 to 1.5 spacings. Extending a path only adds grids.
class PoseRun {
 public:
  explicit PoseRun(PoseProblem problem);
  PoseRun(PoseRun&&) noexcept;
  PoseRun& operator=(PoseRun&&) noexcept;
  PoseRun(const PoseRun&) = delete;
  PoseRun& operator=(const PoseRun&) = delete;
  ~PoseRun();

  // Moves all parts and pins to their targets, or as far as the problem's judge lets them: calls apply(grid) with each
  // grid of the flow, in order, until it returns false. Throws InvalidInput if the equations cannot be solved or
  // need over 2000 grids, and Cancelled. Time: about 0.1 s for each grid of 2000 unknowns.
  PoseOutcome go(const std::function<bool(const PotentialGrid&)>& apply);

  // Gives parts and pins new targets. The lists have the same lengths, and hold the points as they were at the start.
  void set_ways(std::vector<PosedPart> parts, std::vector<PosedPin> pins);

 private:
  class Motion;
  std::unique_ptr<Motion> motion_;
};

// Sets `body.around` for the next step of a motion: to positions near the body's points, near their extrapolation from
// `before`, and near the targets of the rows. Sets `before` (empty at the first step) to the body's points.
void find_surroundings(BodySamples& body, std::vector<Vec3d>& before, std::span<const VelocityRows> rows,
                       double spacing);

// Returns a point and the corners of an icosahedron around it: a patch that moves as one rigid piece.
std::vector<Vec3d> patch_about(const Vec3d& p, double size);

}  // namespace knead::detail
