// Floats at their places in a binary file, for formats that hold coordinates as floats alone.
#pragma once

#include <bit>
#include <cstring>
#include <span>
#include <string>

#include "knead/io/cursor.h"
#include "knead/io/text.h"
#include "knead/math/error.h"
#include "knead/math/vec3.h"

namespace knead::io_detail {

inline bool fits_floats(const Vec3d& p) { return fits_float(p.x) && fits_float(p.y) && fits_float(p.z); }

// Throws InvalidInput for the first position that is beyond the range of float.
inline void check_fits_floats(std::span<const Vec3d> positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (fits_floats(positions[i])) continue;
    throw InvalidInput(
        "vertex " + std::to_string(i) +
        " has coordinates beyond the range of float, the type of this binary format; write another format");
  }
}

// Replaces four bytes. The value is within the range of float.
inline void put_float(std::string& bytes, std::size_t at, double value, std::endian order) {
  const float rounded = static_cast<float>(value);
  const float stored = order == std::endian::native ? rounded : swap_bytes(rounded);
  std::memcpy(bytes.data() + at, &stored, sizeof stored);
}

// Replaces those of three floats that differ from what they were.
inline void replace_floats(std::string& bytes, std::size_t at, const Vec3d& from, const Vec3d& to, std::endian order) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (from[axis] != to[axis]) put_float(bytes, at + axis * sizeof(float), to[axis], order);
  }
}

}  // namespace knead::io_detail
