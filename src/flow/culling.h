// The supports of segments, and balls of points that a segment cannot move. Internal to the library.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "field/grid.h"
#include "flow/curve_map.h"
#include "flow/lattice_map.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// The ball around a box of points.
struct Surround {
  Vec3d center;
  double radius = 0;
};

// Returns a true distance from all elements of the set beyond which r >= outer.
double support_radius(const PointSet<double>& set, double outer);

// Returns the ball around the points and curves of a set, relative to its field's centre.
Surround surround_of(const PointSet<double>& set);

// The coordinates of supports without bounds are -kFar and kFar.
inline constexpr double kFar = 1e300;

// Returns a box beyond which a field that moves by the displacement is 0 from t = 0 to 1.
Box support_of(const Field& field, const Vec3d& displacement);

// The same for a segment that is no sum.
Box support_of(const Segment& segment);

// Bounds of a segment's supports over its time. The segment must outlive it.
class Culling {
 public:
  explicit Culling(const Segment& segment);

  // Returns true only if no resting point of the ball is in the support of a field at any time of the segment. May
  // return false for a ball that the tool passes closely.
  bool misses(const Surround& ball) const;

  // Returns true only if every point of the ball is in the intermediate region at the segment's beginning, or in the
  // inner one if `or_inside`. Tests simple regions only.
  bool covers(const Surround& ball, bool or_inside) const;

  // The path of a field's centre, and bounds along it.
  struct Sweep {
    const Field* field = nullptr;
    Vec3d from;
    Vec3d to;
    double begin = 0;  // the time
    double middle = 0.5;
    double half_time = 0;
    double half_length = 0;
    Vec3d path;            // from `from` to `to`
    double per_path2 = 0;  // 1 / |path|^2, or 0
    bool of_ball = false;
    Surround elements;  // of a point set
    double radius = 0;  // its support_radius
  };

 private:
  void add(const Segment& segment, double from, double to);

  std::vector<Sweep> sweeps_;
  std::vector<std::shared_ptr<const GridSupport>> grids_;
  std::optional<CurveSupport> curve_;
  std::optional<LatticeSupport> lattice_;
};

}  // namespace knead::detail
