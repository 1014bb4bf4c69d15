// Masks: a number m(x) at each point of space, 0 where the shape stays and 1 where it is free.
//
// A mask multiplies the vector potential, so a masked field is divergence-free as every other one (method, section 10):
// v = curl(m w A) = m w u + (m dw/dr grad r + w grad m) x A. m is C2: it is a cubic B-spline on a regular grid.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "knead/math/box.h"
#include "knead/math/vec3.h"

namespace knead {

namespace detail {
struct MaskGrid;
}

// m and its gradient at one point.
template <class T>
struct MaskValue {
  T value{1};
  Vec3<T> gradient;
};

// A mask that rests in space. A value: copies share memory, which nothing changes.
class Mask {
 public:
  Mask() = default;  // 1 everywhere

  // Makes the mask of some points. `values` says how much each point is masked, from 0: not at all to 1: m = 0 in
  // reach of it; none: 1 for all. They are rounded to 1/255. m falls to 0 towards a point as follows, for one with the
  // value 1: m = 1 beyond 1.5 width, and from 1 width on along the axes of coordinates; m < 0.25 within 0.25 width;
  // m = 0 and grad m = 0 exactly at the point. Of several points the largest value counts, at each node of the grid.
  // Takes about 0.2 ms for 100 points that are apart. threads as for parallel_for. Throws InvalidInput for numbers
  // out of range, and for a width that is too small for the extent of the points.
  Mask(std::span<const Vec3d> points, std::span<const double> values, double width, int threads = 0);

  // Returns whether m is 1 everywhere because there are no masked points.
  bool is_empty() const { return grid_ == nullptr; }
  // Returns the width of the border, 0 if the mask is empty.
  double width() const;
  // Returns a box beyond which m is 1.
  Box box() const;
  // Returns m and its gradient. Costs about 0.1 us.
  MaskValue<double> at(const Vec3d& x) const;
  // Returns whether m is exactly 0 at x and around it, so that x rests for ever.
  bool holds(const Vec3d& x) const;

  // Returns whether one is a copy of the other, or both are empty.
  bool shares(const Mask& other) const { return grid_ == other.grid_; }

  // Returns the grid. The mask must not be empty.
  const detail::MaskGrid& grid() const { return *grid_; }

  friend bool operator==(const Mask& a, const Mask& b);

 private:
  std::shared_ptr<const detail::MaskGrid> grid_;
};

// Returns the indices, in ascending order, of points that give the same mask to the bit as all of them: one for each
// cell of the grid with a masked point in it. Throws as the constructor.
std::vector<std::uint32_t> telling_points(std::span<const Vec3d> points, std::span<const double> values, double width);

}  // namespace knead
