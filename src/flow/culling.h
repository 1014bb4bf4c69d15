// Which points a segment can reach, for whole boxes of them.
#pragma once

#include <memory>
#include <vector>

#include "field/grid.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// The ball around a box of points.
struct Surround {
  Vec3d center;
  double radius = 0;
};

// Beyond this true distance from every element of the set, r >= outer.
double support_reach(const PointSet<double>& set, double outer);

// The ball around the points and curves of a set, relative to its field's centre.
Surround surround_of(const PointSet<double>& set);

// A box beyond which a field is 0 from t = 0 to 1, if it moves by the displacement; from -kFar to kFar for regions
// without bounds.
inline constexpr double kFar = 1e300;
Box support_of(const Field& field, const Vec3d& displacement);

// The same for a segment that is no sum.
Box support_of(const Segment& segment);

// What a segment's fields can reach. The segment must outlive it.
class Culling {
 public:
  explicit Culling(const Segment& segment);

  // Whether no resting point of the ball is in the support of a field at any time of the segment. May be false although
  // it is true, where the tool passes near.
  bool misses(const Surround& ball) const;

  // Whether every point of the ball is in the intermediate region at the segment's beginning, or in the inner one if
  // `or_inside`; as far as is easily known.
  bool covers(const Surround& ball, bool or_inside) const;

 private:
  // The path of a field's centre, and bounds for what happens on it.
  struct Sweep {
    const Field* field = nullptr;
    Vec3d from;
    Vec3d to;
    double begin = 0;  // of the time
    double middle = 0.5;
    double half_time = 0;
    double half_length = 0;
    Vec3d path;            // from `from` to `to`
    double per_path2 = 0;  // 1 / |path|^2, or 0
    bool of_ball = false;
    Surround elements;  // of a point set
    double reach = 0;   // of it
  };

  static bool misses(const Sweep& sweep, const Surround& ball);
  static bool ball_misses(const Sweep& sweep, const Surround& ball);
  static double least_value(const Ball<double>& region, const Sweep& sweep, const Surround& ball);
  static double least_value(const Capsule<double>& region, const Sweep& sweep, const Surround& ball);
  static double least_value(const HalfSpace<double>& region, const Sweep& sweep, const Surround& ball);
  static double least_value(const PointSet<double>& region, const Sweep& sweep, const Surround& ball);
  static double least_value(const Handles<double>& region, const Sweep& sweep, const Surround& ball);
  static double least_value(const CustomRegion& region, const Sweep& sweep, const Surround& ball);

  void add(const Segment& segment, double from, double to);

  std::vector<Sweep> sweeps_;
  std::vector<std::shared_ptr<const GridSupport>> grids_;
};

}  // namespace knead::detail
