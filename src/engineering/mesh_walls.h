// The walls of a session on a mesh. Points in planes of mirrors stay there by the flow itself. Points of other walls
// (planes that face each other, curved and periodic patches) are put back after each part of a stroke, and the mesh
// near them follows. Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engineering/wall_surface.h"
#include "knead/cells.h"
#include "knead/remesh.h"
#include "knead/session.h"
#include "knead/vec.h"
#include "session/point_constraint.h"

namespace knead::detail {

// A wall, and the distance to which the mesh near it follows.
struct SlidingWall {
  WallSurface surface;
  std::optional<double> width{};  // nothing: a tenth of the diagonal, at most 3/4 of the mesh's greatest distance
  bool is_followed = true;        // false: it only keeps its points, and the mesh near it does not follow
  bool keeps_layers = false;      // it only keeps the layers beside it
};

// The parts of MeshWalls, besides the mesh.
struct WallParts {
  // A plane in which all strokes are mirrored, and the points in it.
  struct Plane {
    MirrorPlane plane;
    std::vector<std::uint32_t> points;
  };
  std::vector<Plane> planes{};
  std::vector<SlidingWall> walls{};
  std::vector<std::array<std::uint32_t, 2>> pairs{};  // of points that move alike; the second is the first, shifted
};

// The walls of a mesh, and its cells. A point near a wall that is followed moves with the nearest point of that wall,
// and keeps its offset, turned as the normal turns. Farther away the flow takes over, smoothly.
class MeshWalls : public PointConstraint {
 public:
  // `diagonal`: of the mesh's box. Throws Cancelled.
  MeshWalls(WallParts parts, std::span<const Vec3d> points, double diagonal, const WallOptions& options);

  std::size_t points() const override { return kept_.size(); }
  bool is_flow() const override { return walls_.empty(); }
  double put_on_planes(std::span<Vec3d> points) const override;
  // Puts the points of the walls back, and moves those near them along. A correction is small beside the widths of the
  // walls, if no normal turned by more than 20 degrees.
  PointCorrection put_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const override;
  std::shared_ptr<const PointConstraint> without_layers() const override;
  std::vector<Vec3d> no_worse(std::span<const Vec3d> before, std::span<const Vec3d> with_layers,
                              std::span<const Vec3d> without, int threads) const override;
  std::optional<KeptCells> keep_cells(std::span<const Vec3d> before, std::span<const Vec3d> after,
                                      const CarryPoints& carry, const std::string& name, int threads,
                                      const Progress* progress) const override;
  const std::shared_ptr<const VolumeCells>& cells() const override { return cells_; }

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
  // Moves the points of the links with their walls, whose points are at `after`. `flowed`: all points after the flow.
  void follow(const std::vector<Link>& links, std::span<const Vec3d> before, std::span<const Vec3d> flowed,
              std::span<Vec3d> after, int threads) const;
  void put_points_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const;
  void move_pairs(std::span<const Vec3d> before, std::span<Vec3d> after) const;
  Vec3d beside(const Link& link, const Turns& turns, std::span<const Vec3d> before, std::span<const Vec3d> after) const;

  std::vector<WallParts::Plane> planes_;
  std::vector<SlidingWall> walls_;
  std::vector<std::array<std::uint32_t, 2>> pairs_;
  std::shared_ptr<const VolumeCells> cells_;
  std::vector<Vec3d> shifts_;           // of the pairs
  std::vector<std::uint32_t> on_wall_;  // points of all walls, ascending
  std::vector<std::uint8_t> kept_;      // for each point of the mesh: how many walls and pairs it belongs to
  std::vector<std::uint8_t> is_fixed_;
  // By their points: of points on no wall, and of points on a wall beside other ones.
  std::vector<Link> links_;
  std::vector<Link> wall_links_;
  double diagonal_ = 0;
};

}  // namespace knead::detail
