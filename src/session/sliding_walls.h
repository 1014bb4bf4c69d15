// Walls that mirroring does not keep: planes that face each other, curved patches, and periodic ones. After each part
// of a stroke their points are put back, and the mesh near them follows. Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "knead/session.h"
#include "knead/vec.h"
#include "session/wall_surface.h"

namespace knead {

// A wall, and how far from it the mesh follows.
struct SlidingWall {
  session_detail::WallSurface surface;
  std::optional<double> width{};  // nothing: a tenth of the diagonal, or 3/4 of how far the mesh goes from it
  bool is_followed = true;        // false: it only keeps its points, and the mesh near it does not follow
};

// What put_back() did.
struct WallCorrection {
  double greatest = 0;   // the greatest distance that a point was put back
  bool is_small = true;  // beside the widths of the walls, and no normal turned by more than 20 degrees
};

// The walls of a mesh. Near a wall a point goes with the place of the wall that it was nearest to: it keeps its place
// beside it, and turns with its normal. Farther away the flow takes over, smoothly.
class SlidingWalls {
 public:
  // `pairs`: two points that move alike; the second one is the first one, shifted. `diagonal`: of the mesh's box.
  // Throws Cancelled.
  SlidingWalls(std::vector<SlidingWall> walls, std::vector<std::array<std::uint32_t, 2>> pairs,
               std::span<const Vec3d> points, double diagonal, const WallOptions& options);

  // Puts the points of the walls back, and moves those near them along. `before`: the points before a part of the
  // stroke, on the walls; `after`: where the flow took them, changed here. What has not moved keeps its bits.
  WallCorrection put_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const;

 private:
  // A point near a wall, and the place of the wall nearest to it.
  struct Link {
    std::uint32_t point = 0;
    std::uint32_t wall = 0;
    Triangle corners{};  // in the surface's numbers()
    std::array<double, 3> weights{};
    double share = 0;
  };
  struct Turns;  // of a wall's normals

  double width_of(const SlidingWall& wall, std::span<const Vec3d> points, const WallOptions& options) const;
  void find_links(std::span<const Vec3d> points, const WallOptions& options);
  std::vector<Turns> turns_of(std::span<const Vec3d> before, std::span<const Vec3d> after) const;
  // Moves the points of the links to where the walls take them, which are at `after`; `flowed`: where the flow took
  // all.
  void follow(const std::vector<Link>& links, std::span<const Vec3d> before, std::span<const Vec3d> flowed,
              std::span<Vec3d> after, int threads) const;
  void put_points_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const;
  void move_pairs(std::span<const Vec3d> before, std::span<Vec3d> after) const;
  Vec3d beside(const Link& link, const Turns& turns, std::span<const Vec3d> before, std::span<const Vec3d> after) const;

  std::vector<SlidingWall> walls_;
  std::vector<std::array<std::uint32_t, 2>> pairs_;
  std::vector<Vec3d> shifts_;           // of the pairs
  std::vector<std::uint32_t> on_wall_;  // points of all walls, ascending
  std::vector<std::uint8_t> kept_;      // for each point of the mesh: how many walls and pairs it belongs to
  std::vector<std::uint8_t> is_fixed_;
  // By their points: of points on no wall, and of points on a wall beside other ones.
  std::vector<Link> links_;
  std::vector<Link> wall_links_;
  double diagonal_ = 0;
};

}  // namespace knead
