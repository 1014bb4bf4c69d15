// Corners of triangles become vertices: equal positions are one.
#pragma once

#include <cstdint>
#include <vector>

#include "knead/math/vec3.h"

namespace knead::io_detail {

// A hash table with open addressing over positions that are kept elsewhere. 0 and -0 are equal; a vertex has the sign
// of the corner that came first.
class Welder {
 public:
  // Adds to `positions`, which must outlive this, be empty, and change in no other way.
  explicit Welder(std::vector<Vec3d>& positions) : positions_(positions), slots_(kFirstSlots, kEmpty) {}

  // The vertex at a finite position, a new one where there is none. The caller keeps their number below 2^32 - 1.
  std::uint32_t vertex_at(const Vec3d& p);

 private:
  static constexpr std::size_t kFirstSlots = 1024;  // a power of two, as every size
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  void grow();

  std::vector<Vec3d>& positions_;
  std::vector<std::uint64_t> slots_;  // half of the position's hash, then its vertex
};

}  // namespace knead::io_detail
