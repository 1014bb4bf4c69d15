// The grid of a mask, and its evaluation. Internal to the library.
//
// Nodes lie `spacing` apart; cell i lies between the nodes i and i + 1. A node has a byte, from 0 (free) to 255
// (masked). m is 1 minus the cubic B-spline of the bytes, of which a cell depends on 64. Where all 64 are 0, m is
// exactly 1. Cells lie in bricks of 8 x 8 x 8; a brick has the bytes of all its cells, so that an evaluation reads one
// brick. Evaluation uses + - * in a fixed order: the same bits everywhere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "field/grid.h"
#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

inline constexpr int kBrickCells = 8;                // along an axis
inline constexpr int kBrickNodes = kBrickCells + 3;  // along an axis, with the margin
inline constexpr int kBrickRow = kBrickNodes + 1;    // bytes of a row
inline constexpr int kBrickBytes = kBrickNodes * kBrickNodes * kBrickRow;

struct MaskGrid {
  double width = 0;
  double spacing = 0;
  Vec3d origin;                     // the low corner of brick 0
  std::array<int, 3> bricks{};      // along each axis
  std::vector<std::int32_t> start;  // of each brick's bytes; 0: free, kBrickBytes: masked everywhere
  std::vector<std::uint8_t> bytes;  // of a free brick, a masked one, and all others
  std::vector<std::uint8_t> clear;  // by brick: the distance in bricks to the next one that is not free; at most 255
  std::vector<Vec3d> border;        // a place of the border in each cube of half a brick that contains some

  friend bool operator==(const MaskGrid& a, const MaskGrid& b) {
    return a.spacing == b.spacing && a.origin == b.origin && a.bricks == b.bricks && a.start == b.start &&
           a.bytes == b.bytes;
  }
};

// A mask with its numbers in the scalar S, for positions relative to a centre.
template <class S>
struct MaskView {
  const std::int32_t* start = nullptr;
  const std::uint8_t* bytes = nullptr;
  const std::uint8_t* clear = nullptr;
  int row = 0;    // bricks
  int plane = 0;  // bricks
  S per_spacing{0};
  S width{0};
  Vec3<S> offset{};     // of the centre, in cells
  Vec3<S> last_cell{};  // the greatest index

  bool is_empty() const { return start == nullptr; }
};

template <class S>
MaskView<S> view_of(const MaskGrid& grid, const Vec3d& center) {
  const Vec3d offset = (center - grid.origin) / grid.spacing;
  MaskView<S> view{grid.start.data(),
                   grid.bytes.data(),
                   grid.clear.data(),
                   grid.bricks[0],
                   grid.bricks[0] * grid.bricks[1],
                   static_cast<S>(1 / grid.spacing),
                   static_cast<S>(grid.width),
                   Vec3<S>(offset)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    view.last_cell[axis] = static_cast<S>(grid.bricks[axis] * kBrickCells - 1);
  return view;
}

// Returns an empty view of an empty mask.
template <class S>
MaskView<S> view_of(const Mask& mask, const Vec3d& center) {
  return mask.is_empty() ? MaskView<S>{} : view_of<S>(mask.grid(), center);
}

// The number of lanes of a T: 1 unless it is a pack.
template <class T>
inline constexpr std::size_t kLanesOf = 1;
template <class T>
requires requires { T::kSize; }
inline constexpr std::size_t kLanesOf<T> = T::kSize;

template <class T>
[[gnu::always_inline]] inline void store_lanes(const T& value, int (&to)[kLanesOf<T>]) {
  if constexpr (requires { typename T::Scalar; }) {
    typename T::Scalar numbers[kLanesOf<T>];
    value.store(numbers);
    for (std::size_t k = 0; k < kLanesOf<T>; ++k) to[k] = static_cast<int>(numbers[k]);
  } else if constexpr (requires { value.v; }) {
    to[0] = static_cast<int>(value.v);
  } else {
    to[0] = static_cast<int>(value);
  }
}

// Makes a T of an integer for each lane.
template <class T, class Function>
[[gnu::always_inline]] inline T from_lanes(const Function& of_lane) {
  if constexpr (requires { typename T::Scalar; }) {
    typename T::Scalar numbers[kLanesOf<T>];
    for (std::size_t k = 0; k < kLanesOf<T>; ++k) numbers[k] = static_cast<typename T::Scalar>(of_lane(k));
    return T::load(numbers);
  } else {
    return static_cast<T>(of_lane(0));
  }
}

// The cells of the lanes' places, and the positions in the cells.
template <class T>
struct MaskCells {  // NOLINT(cppcoreguidelines-pro-type-member-init): cells_at writes all
  int index[3][kLanesOf<T>];
  Vec3<T> within;  // from 0 to 1
};

// `y`: relative to the view's centre. NaN lies in the first cell.
template <class T, class S>
[[gnu::always_inline]] inline MaskCells<T> cells_at(const MaskView<S>& mask, const Vec3<T>& y) {
  MaskCells<T> cells;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const T last(mask.last_cell[axis]);
    const T at = mul_add(y[axis], T(mask.per_spacing), T(mask.offset[axis]));
    const T inside = minimum(last + T(1), maximum(T(0), at));
    const T cell = minimum(last, maximum(T(0), round_to_integer(inside - T(S(0.5)))));
    store_lanes(cell, cells.index[axis]);
    cells.within[axis] = inside - cell;
  }
  return cells;
}

template <class T, class S>
[[gnu::always_inline]] inline std::size_t brick_of(const MaskView<S>& mask, const MaskCells<T>& cells, std::size_t k) {
  // NOLINTNEXTLINE(bugprone-misplaced-widening-cast): there are fewer bricks than an int counts
  return static_cast<std::size_t>(cells.index[0][k] / kBrickCells + mask.row * (cells.index[1][k] / kBrickCells) +
                                  mask.plane * (cells.index[2][k] / kBrickCells));
}

// The 64 bytes on which a cell depends, four to a row.
template <class T>
struct MaskRows {
  std::uint32_t row[16][kLanesOf<T>];

  // Returns whether all bytes are 0; of a pack: in all lanes.
  [[gnu::always_inline]] bool are_free() const {
    const std::uint32_t* const words = &row[0][0];
    std::uint32_t any = 0;
    for (std::size_t i = 0; i < 16 * kLanesOf<T>; ++i) any |= words[i];
    return any == 0;
  }

  // Returns whether all bytes are 255.
  [[gnu::always_inline]] bool are_masked() const {
    const std::uint32_t* const words = &row[0][0];
    std::uint32_t all = ~std::uint32_t{0};
    for (std::size_t i = 0; i < 16 * kLanesOf<T>; ++i) all &= words[i];
    return all == ~std::uint32_t{0};
  }
};

// A pack gathers words and converts bytes by its own instructions.
template <class T>
[[gnu::always_inline]] inline void gather_words(const std::uint8_t* from, const std::int32_t (&offset)[kLanesOf<T>],
                                                std::uint32_t (&to)[kLanesOf<T>]) {
  if constexpr (requires { T::gather(from, offset, to); }) {
    T::gather(from, offset, to);
  } else {
    for (std::size_t k = 0; k < kLanesOf<T>; ++k) std::memcpy(&to[k], from + offset[k], 4);
  }
}

template <class T>
[[gnu::always_inline]] inline T byte_of(const std::uint32_t (&row)[kLanesOf<T>], int index) {
  if constexpr (requires { T::from_bytes(row, index); }) {
    return T::from_bytes(row, index);
  } else {
    return from_lanes<T>([&](std::size_t k) { return static_cast<std::int32_t>(row[k] >> (8 * index) & 255U); });
  }
}

template <class T, class S>
[[gnu::always_inline]] inline void read_rows(const MaskView<S>& mask, const MaskCells<T>& cells, MaskRows<T>& rows) {
  std::int32_t offset[kLanesOf<T>];
  for (std::size_t k = 0; k < kLanesOf<T>; ++k) {
    const int row = (cells.index[2][k] % kBrickCells) * kBrickNodes + cells.index[1][k] % kBrickCells;
    offset[k] = mask.start[brick_of(mask, cells, k)] + row * kBrickRow + cells.index[0][k] % kBrickCells;
  }
  for (int z = 0; z < 4; ++z) {
    for (int y = 0; y < 4; ++y) {
      gather_words<T>(mask.bytes + (z * kBrickNodes + y) * kBrickRow, offset, rows.row[4 * z + y]);
    }
  }
}

// Returns the derivatives of the spline's sum along the axes, and sets `value` to the sum.
template <class T>
[[gnu::always_inline]] inline Vec3<T> sum_rows(const MaskRows<T>& rows, const Vec3<T>& within, T& value) {
  const SplineWeights<T> x = spline_weights(within.x);
  const SplineWeights<T> y = spline_weights(within.y);
  const SplineWeights<T> z = spline_weights(within.z);
  T sum(0);
  Vec3<T> slope{T(0), T(0), T(0)};
  for (int i = 0; i < 4; ++i) {
    T plane(0);
    T plane_x(0);
    T plane_y(0);
    for (int j = 0; j < 4; ++j) {
      T line(0);
      T line_x(0);
      for (int k = 0; k < 4; ++k) {
        const T byte = byte_of<T>(rows.row[4 * i + j], k);
        line = mul_add(byte, x.value[k], line);
        line_x = mul_add(byte, x.slope[k], line_x);
      }
      plane = mul_add(line, y.value[j], plane);
      plane_x = mul_add(line_x, y.value[j], plane_x);
      plane_y = mul_add(line, y.slope[j], plane_y);
    }
    sum = mul_add(plane, z.value[i], sum);
    slope.x = mul_add(plane_x, z.value[i], slope.x);
    slope.y = mul_add(plane_y, z.value[i], slope.y);
    slope.z = mul_add(plane, z.slope[i], slope.z);
  }
  value = sum;
  return slope;
}

// Returns m and its gradient at y = x - c. Where all bytes are 255, m and grad m are exactly 0 for a single number, but
// 0 only up to rounding in a pack; no point there gets into a pack.
template <class T, class S>
[[gnu::always_inline]] inline MaskValue<T> evaluate_mask(const MaskView<S>& mask, const Vec3<T>& y) {
  const MaskCells<T> cells = cells_at(mask, y);
  MaskRows<T> rows;  // NOLINT(cppcoreguidelines-pro-type-member-init): read_rows writes all
  read_rows(mask, cells, rows);
  if (rows.are_free()) return {T(1), {T(0), T(0), T(0)}};
  if constexpr (!requires { typename T::Scalar; }) {
    if (rows.are_masked()) return {T(0), {T(0), T(0), T(0)}};
  }
  T sum(0);
  const Vec3<T> slope = sum_rows(rows, cells.within, sum);
  const T scale(S(1.0 / (216.0 * 255.0)));
  const T by = scale * T(mask.per_spacing);
  return {T(1) - sum * scale, {T(0) - slope.x * by, T(0) - slope.y * by, T(0) - slope.z * by}};
}

// Returns a distance within which m is 1 and its gradient 0 around y = x - c; 0 where none is known.
template <class T, class S>
[[gnu::always_inline]] inline T clearance(const MaskView<S>& mask, const Vec3<T>& y) {
  const MaskCells<T> cells = cells_at(mask, y);
  const T bricks = from_lanes<T>([&](std::size_t k) -> std::int32_t { return mask.clear[brick_of(mask, cells, k)]; });
  return maximum(T(0), bricks - T(1)) * T(mask.width);
}

}  // namespace knead::detail
