// Points laid out for being moved many times.
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

// Points in blocks of neighbours, each with a box, and blocks in groups: what a tool does not reach costs a test for
// each group, or each block, however many points it has. Points keep their numbers: how they lie is not seen from
// outside. Copies are independent.
class PointBlocks {
 public:
  // Along a space-filling curve, which takes about 30 ns a point; or as given, where neighbours should follow each
  // other.
  enum class Order { sorted, given };

  explicit PointBlocks(std::span<const Vec3d> points, Order order = Order::sorted);

  std::size_t size() const { return size_; }

  // All points as they are now, into size() places.
  void copy_to(std::span<Vec3d> points) const;

  // The same where `points` holds what this function, or the constructor, was given last: copies only what may have
  // moved since.
  void update(std::span<Vec3d> points);

  // The accepted steps of each point's path line since the blocks were made.
  std::vector<std::uint32_t> steps() const;

 private:
  friend class detail::BlockMover;

  // The box of points, about as it was when last looked at.
  struct Bounds {
    Vec3d center{};
    Vec3d half{};           // extents
    double slack = 0;       // how far along an axis a point may have moved since
    bool is_ahead = false;  // of what update was last called with
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
