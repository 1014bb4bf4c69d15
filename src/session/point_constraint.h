// The interface of constraints on points besides the flow: walls and the quality of cells (module engineering)
// implement it. Internal to the library.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/remesh.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead {

// What PointConstraint::put_back() did.
struct PointCorrection {
  double greatest = 0;   // the greatest distance by which a point was put back
  bool is_small = true;  // false: correct shorter parts of the stroke
};

// What PointConstraint::keep_cells() did.
struct KeptCells {
  std::vector<Vec3d> points;
  std::size_t freed = 0;  // how many points inside have left the flow
};

// A constraint on the points of one mesh. Any thread may use it.
class PointConstraint {
 public:
  virtual ~PointConstraint() = default;

  // Returns the number of the mesh's points.
  virtual std::size_t points() const = 0;

  // --- after each part of a stroke

  // Returns whether no points are put back, so that the result is that of the flow.
  virtual bool is_flow() const = 0;

  // Puts the points of mirror planes exactly into these planes; rounding, the mask of a held wall, or another wall may
  // have moved them out. Returns the greatest distance.
  virtual double put_on_planes(std::span<Vec3d> points) const = 0;

  // Puts points back. `before`: the points before a part of the stroke, which meet the constraint; `after`: the points
  // that the flow has moved, changed here. Points that have not moved keep their bits.
  virtual PointCorrection put_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const = 0;

  // --- after the session

  // Returns the constraint without walls that keep layers; null if there are none, or no cells to judge them by.
  virtual std::shared_ptr<const PointConstraint> without_layers() const = 0;

  // Returns the points with layers kept if their cells are no worse than `without`; otherwise the farthest points
  // between `without` and `with_layers`, in eighths, whose cells are no worse. Worse: more inverted cells, or a greater
  // non-orthogonality.
  virtual std::vector<Vec3d> no_worse(std::span<const Vec3d> before, std::span<const Vec3d> with_layers,
                                      std::span<const Vec3d> without, int threads) const = 0;

  // Returns nothing if no cell is inverted at `after` that was not `before` (count_inverted_since()). Otherwise returns
  // points without such cells, by deform_cells(): points on the boundary and on surfaces stay at `after`. `carry` moves
  // points by a part of the flow. Throws QualityLimit, with the session's name, if cells stay inverted; Cancelled.
  virtual std::optional<KeptCells> keep_cells(std::span<const Vec3d> before, std::span<const Vec3d> after,
                                              const CarryPoints& carry, const std::string& name, int threads,
                                              const Progress* progress) const = 0;

  // Returns the cells; null if there are none.
  virtual const std::shared_ptr<const VolumeCells>& cells() const = 0;

 protected:
  PointConstraint() = default;
  PointConstraint(const PointConstraint&) = default;
  PointConstraint& operator=(const PointConstraint&) = default;
};

}  // namespace knead
