// Poses: parts and pins that move to their places, and a body that follows as nearly rigidly as it can. Contains no
// mesh. Internal to the library.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pose/near_rigid.h"

namespace knead::detail {

// Points that move rigidly: by a screw about an axis, and a translation, at a constant rate. They hold by default.
struct PosedPart {
  std::vector<Vec3d> points;
  Vec3d axis{0, 0, 1};  // a unit vector
  Vec3d center{0, 0, 0};
  double angle = 0;  // radians
  Vec3d translation{0, 0, 0};
  // In place of the centre and translation: where a point is at a time from 0 to 1. `angle` is the greatest turn then.
  std::function<Vec3d(const Vec3d& start, double time)> way{};
  std::vector<Vec3d> checked{};  // more of its points, which ask for nothing: PoseOutcome::part_distance sees them, too

  bool holds() const { return !way && angle == 0 && translation == Vec3d{0, 0, 0}; }
};

// A point that follows a path; what is within `size` of it moves as a rigid patch.
struct PosedPin {
  std::vector<Vec3d> path;  // 1 or more places: the first is where the point is; only one: the pin holds
  double size = 0;
  std::optional<Vec3d> turn;  // the patch turns by so much, radians about this axis; std::nullopt: as the body takes it
};

struct PoseProblem {
  BodySamples body;
  std::vector<PosedPart> parts;
  std::vector<PosedPin> pins;
  std::optional<Vec3d> across{};  // a unit vector along which hardly anything flows
  double spacing = 0;             // of the grids
  double most_spacing = 0;        // up to which it grows where the unknowns would be too many
  double diagonal = 0;            // of the shape: what accuracy is measured by
  bool settles = true;            // a last step without time takes parts that moved to their places
  int threads = 0;
  Progress* progress = nullptr;
};

struct PoseOutcome {
  std::size_t segments = 0;
  std::size_t unknowns = 0;    // the most of a segment
  double part_distance = 0;    // greatest of a part's points from its rigid place, and of a pin from its place
  bool stopped = false;        // apply returned false
  std::vector<Vec3d> reached;  // where the points of parts and the pins are at the end
  std::vector<Vec3d> places;   // as many: where they should be
};

// Returns how many grids the pose becomes: none turns a part by more than 8 degrees, or moves it by more than 0.03
// of the diagonal or half the spacing, and never by more than 1.5 spacings. A path that goes on only adds grids. Throws
// InvalidInput if they are more than 2000.
std::size_t pose_segments(const PoseProblem& problem);

// A pose under way: the body, parts and pins where they are by now.
class PoseRun {
 public:
  explicit PoseRun(PoseProblem problem);
  PoseRun(PoseRun&&) noexcept;
  PoseRun& operator=(PoseRun&&) noexcept;
  PoseRun(const PoseRun&) = delete;
  PoseRun& operator=(const PoseRun&) = delete;
  ~PoseRun();

  // Goes the ways of all parts and pins: calls apply(grid) with each grid of the flow, in order, until it returns
  // false. Throws InvalidInput where the equations cannot be solved, and Cancelled. Time: about 0.1 s for each grid of
  // 2000 unknowns.
  PoseOutcome go(const std::function<bool(const PotentialGrid&)>& apply);

  // Gives parts and pins ways to go on from where they are: as many, with their points at the very beginning.
  void set_ways(std::vector<PosedPart> parts, std::vector<PosedPin> pins);

 private:
  class Motion;
  std::unique_ptr<Motion> motion_;
};

// Sets `body.around` for the next step of a motion: to places near the body's points as they are and as they would come
// to if they moved on as since `before`, and near what the rows ask for. `before` (empty at the first step) becomes the
// points as they are.
void find_surroundings(BodySamples& body, std::vector<Vec3d>& before, std::span<const VelocityRows> rows,
                       double spacing);

// Returns a point and the corners of an icosahedron about it: what moves as one rigid piece, such as the patch of a
// pin.
std::vector<Vec3d> patch_about(const Vec3d& p, double size);

}  // namespace knead::detail
