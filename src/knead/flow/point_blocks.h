// Points stored so that they can be moved many times at little cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/box.h"

namespace knead {

namespace detail {
class BlockMover;
}

// Throws InvalidInput with the number of the first point that has a coordinate that is not finite.
void require_finite(std::span<const Vec3d> points);

// Points in blocks of 64 neighbours, each with a box, and 64 blocks to a group: a tool costs one test for each group or
// block that it does not reach. Points are numbered as they were given. Copies are independent.
class PointBlocks {
 public:
  // How points are put into blocks:
  //   sorted: along a space-filling curve, which takes about 30 ns a point;
  //   given:  in the given order, for points whose neighbours follow each other.
  enum class Order { sorted, given };

  // Throws InvalidInput, with the number of the point, for a coordinate that is not finite.
  explicit PointBlocks(std::span<const Vec3d> points, Order order = Order::sorted);

  // Returns the number of points.
  std::size_t size() const { return size_; }

  // Copies all points, as they are now, into size() places.
  void copy_to(std::span<Vec3d> points) const;

  // Does the same for the array that the constructor or this function was given last, unchanged since: copies only
  // points that may have moved since then.
  void update(std::span<Vec3d> points);

  // Returns the accepted steps of each point's path line since construction.
  std::vector<std::uint32_t> steps() const;

 private:
  friend class detail::BlockMover;

  // A box of points as it was when last computed.
  struct Bounds {
    Vec3d center{};
    Vec3d half{};              // extents
    double slack = 0;          // how far along an axis a point may have moved since
    bool has_changed = false;  // since the last call of update
  };

  std::size_t original(std::size_t i) const { return order_.empty() ? i : order_[i]; }
  const double* coordinates(int axis) const { return numbers_.data() + static_cast<std::size_t>(axis) * padded_; }
  double* coordinates(int axis) { return numbers_.data() + static_cast<std::size_t>(axis) * padded_; }
  void sort(std::span<const Vec3d> points);
  void fit_block(std::size_t block);
  void fit_group(std::size_t group);
  void copy_block(std::size_t block, std::span<Vec3d> points) const;

  std::size_t size_ = 0;
  std::size_t padded_ = 0;             // to whole groups
  std::vector<double> numbers_;        // x of all points, y of all, z of all
  std::vector<std::uint32_t> order_;   // the points' numbers as they lie; empty: 0, 1, 2...
  std::vector<std::uint32_t> counts_;  // of steps, as the points lie
  std::vector<Bounds> blocks_;
  std::vector<Bounds> groups_;
};

}  // namespace knead
