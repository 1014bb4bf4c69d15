// A vector potential on a regular grid of nodes.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "knead/math/vec3.h"

namespace knead {

// A list of vectors. A value: copies share memory, which nothing changes.
class SharedVectors {
 public:
  SharedVectors() = default;  // no vectors
  explicit SharedVectors(std::vector<Vec3d> vectors)
      : vectors_(std::make_shared<const std::vector<Vec3d>>(std::move(vectors))) {}

  // Returns whether there are none.
  bool empty() const { return size() == 0; }
  // Returns how many there are.
  std::size_t size() const { return vectors_ == nullptr ? 0 : vectors_->size(); }
  // Returns the first of them, which lie side by side; null if there are none.
  const Vec3d* data() const { return vectors_ == nullptr ? nullptr : vectors_->data(); }
  const Vec3d& operator[](std::size_t i) const { return (*vectors_)[i]; }
  // Returns the first.
  const Vec3d* begin() const { return data(); }
  // Returns what comes after the last.
  const Vec3d* end() const { return data() + size(); }

  friend bool operator==(const SharedVectors& a, const SharedVectors& b) {
    if (a.vectors_ == b.vectors_ || a.size() != b.size()) return a.size() == b.size();
    return a.empty() || *a.vectors_ == *b.vectors_;
  }

 private:
  std::shared_ptr<const std::vector<Vec3d>> vectors_;
};

// The vector potential A(x, t) = sum over the nodes k of a_k(t) B((x - origin) / spacing - k), where B is the tensor
// product of cubic B-splines: 0 from 2 spacings on along an axis. A is C2, so v = curl A is C1, its divergence is
// exactly 0, and v is exactly 0 beyond 2 spacings from the nodes with a_k other than 0. a_k(t) is coefficients[k], or
// (1 - t) coefficients[k] + t end_coefficients[k] where there are some.
struct PotentialGrid {
  Vec3d origin{0, 0, 0};             // of the node (0, 0, 0)
  double spacing = 1;                // a length above 0
  std::array<int, 3> counts{};       // of nodes along x, y and z: 1 or more
  SharedVectors coefficients;        // of all nodes: node (i, j, k) is number i + counts[0] (j + counts[1] k)
  SharedVectors end_coefficients{};  // none, or as many: those at t = 1

  // Returns whether there are no coefficients, so that nothing moves.
  bool is_empty() const { return coefficients.empty(); }

  friend bool operator==(const PotentialGrid&, const PotentialGrid&) = default;
};

}  // namespace knead
