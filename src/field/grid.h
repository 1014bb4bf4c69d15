// The cubic B-spline, and potential grids: their evaluation, and the cells in which v is not 0. Internal to the
// library.
//
// Cell i lies between the nodes i and i + 1 and depends on the 64 nodes from i - 1 to i + 2. Empty nodes surround the
// grid, so that every place lies in a cell: places far away lie in an outermost one, which is empty. v is exactly 0 in
// a cell whose nodes are all 0. Evaluation uses + - * in a fixed order: the same bits everywhere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// Six times the cubic B-spline's weights of the four nodes around a place, and their slopes.
template <class T>
struct SplineWeights {
  T value[4];
  T slope[4];
};

template <class T>
[[gnu::always_inline]] inline SplineWeights<T> spline_weights(const T& u) {
  const T q = T(1) - u;
  const T u2 = u * u;
  const T q2 = q * q;
  SplineWeights<T> w;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
  w.value[0] = q2 * q;
  w.value[1] = mul_add(u2, mul_add(T(3), u, T(-6)), T(4));
  w.value[2] = mul_add(q2, mul_add(T(3), q, T(-6)), T(4));
  w.value[3] = u2 * u;
  w.slope[0] = T(-3) * q2;
  w.slope[1] = u * mul_add(T(9), u, T(-12));
  w.slope[2] = q * mul_add(T(-9), q, T(12));
  w.slope[3] = T(3) * u2;
  return w;
}

// Six times the second derivatives of the weights.
template <class T>
[[gnu::always_inline]] inline void spline_curvatures(const T& u, T (&curvature)[4]) {
  const T q = T(1) - u;
  curvature[0] = T(6) * q;
  curvature[1] = mul_add(T(18), u, T(-12));
  curvature[2] = mul_add(T(18), q, T(-12));
  curvature[3] = T(6) * u;
}

// A potential grid with its numbers in the scalar S, for positions relative to its middle node. GridNodes owns them.
template <class S>
struct GridView {
  const S* numbers = nullptr;          // x, y, z of each node: its coefficient / (216 spacing)
  const S* end_numbers = nullptr;      // at t = 1; null: the coefficients are constant
  const S* growth = nullptr;           // p of each node: its number / (216 spacing); null: p = 0
  const std::uint8_t* used = nullptr;  // of each cell, at its first node: whether any of its nodes is not 0
  std::ptrdiff_t row = 0;              // nodes
  std::ptrdiff_t plane = 0;            // nodes
  std::ptrdiff_t first_node = 0;       // of the cell 0
  S spacing{1};
  S per_spacing{1};
  Vec3<S> first_cell{};  // the least index
  Vec3<S> last_cell{};   // the greatest
};

// The cell of a place, and the position in the cell.
template <class T>
struct GridPlace {
  Vec3<T> cell;
  Vec3<T> within;  // from 0 to 1, where the cell is used
};

// `y`: relative to the middle node. NaN lies in the first cell.
template <class T, class S>
[[gnu::always_inline]] inline GridPlace<T> place_in(const GridView<S>& grid, const Vec3<T>& y) {
  GridPlace<T> place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const T first(grid.first_cell[axis]);
    const T last(grid.last_cell[axis]);
    const T per_spacing(grid.per_spacing);
    const T inside = minimum(last + T(1), maximum(first, y[axis] * per_spacing));
    place.cell[axis] = minimum(last, maximum(first, round_to_integer(inside - T(S(0.5)))));
    place.within[axis] = mul_sub(y[axis], per_spacing, place.cell[axis]);
  }
  return place;
}

// The number of a cell's first node, from its indices.
template <class S>
[[gnu::always_inline]] inline std::ptrdiff_t node_of(const GridView<S>& grid, int x, int y, int z) {
  return grid.first_node + x + grid.row * y + grid.plane * z;
}

template <class T>
struct GridWeights {
  SplineWeights<T> along[3];
};

template <class T>
[[gnu::always_inline]] inline GridWeights<T> weights_at(const Vec3<T>& within) {
  return {{spline_weights(within.x), spline_weights(within.y), spline_weights(within.z)}};
}

// v = curl A, plus grad p with `growth`; and A / spacing if requested.
template <class T>
struct GridValue {
  Vec3<T> velocity{T(0), T(0), T(0)};
  Vec3<T> potential{T(0), T(0), T(0)};
};

// Adds the contribution of one component of A to v = curl A and to A. The component is first summed along its own axis,
// along which v needs no derivative of it.
template <std::size_t axis, bool with_potential, class T, class S>
[[gnu::always_inline]] inline void add_component(const S* first, const std::ptrdiff_t (&stride)[3],
                                                 const GridWeights<T>& weights, GridValue<T>& to) {
  constexpr std::size_t kNext = (axis + 1) % 3;
  constexpr std::size_t kLast = (axis + 2) % 3;
  const SplineWeights<T>& own = weights.along[axis];
  const SplineWeights<T>& next = weights.along[kNext];
  const SplineWeights<T>& last = weights.along[kLast];
  T value(0);
  T by_next(0);
  T by_last(0);
  for (int k = 0; k < 4; ++k) {
    T plane(0);
    T plane_slope(0);
    for (int j = 0; j < 4; ++j) {
      const S* const node = first + axis + k * stride[kLast] + j * stride[kNext];
      T line = T(node[0]) * own.value[0];
      for (int i = 1; i < 4; ++i) line = mul_add(T(node[i * stride[axis]]), own.value[i], line);
      plane = mul_add(line, next.value[j], plane);
      plane_slope = mul_add(line, next.slope[j], plane_slope);
    }
    by_next = mul_add(plane_slope, last.value[k], by_next);
    by_last = mul_add(plane, last.slope[k], by_last);
    if constexpr (with_potential) value = mul_add(plane, last.value[k], value);
  }
  to.velocity[kNext] = to.velocity[kNext] + by_last;
  to.velocity[kLast] = to.velocity[kLast] - by_next;
  if constexpr (with_potential) to.potential[axis] = value;
}

// The sums of a cell, from the numbers of its first node on. All lanes of a T are evaluated as if in this cell.
template <bool with_potential, class T, class S>
[[gnu::always_inline]] inline GridValue<T> sum_cell(const GridView<S>& grid, const S* first,
                                                    const GridWeights<T>& weights) {
  const std::ptrdiff_t stride[3] = {3, 3 * grid.row, 3 * grid.plane};
  GridValue<T> sum;
  add_component<0, with_potential>(first, stride, weights, sum);
  add_component<1, with_potential>(first, stride, weights, sum);
  add_component<2, with_potential>(first, stride, weights, sum);
  return sum;
}

// Adds grad p of a cell, from the number of its first node on, to v.
template <class T, class S>
[[gnu::always_inline]] inline void add_growth(const GridView<S>& grid, const S* first, const GridWeights<T>& weights,
                                              GridValue<T>& to) {
  const SplineWeights<T>& x = weights.along[0];
  const SplineWeights<T>& y = weights.along[1];
  const SplineWeights<T>& z = weights.along[2];
  for (int k = 0; k < 4; ++k) {
    T plane(0);
    T by_x(0);
    T by_y(0);
    for (int j = 0; j < 4; ++j) {
      const S* const node = first + k * grid.plane + j * grid.row;
      T line = T(node[0]) * x.value[0];
      T line_slope = T(node[0]) * x.slope[0];
      for (int i = 1; i < 4; ++i) {
        line = mul_add(T(node[i]), x.value[i], line);
        line_slope = mul_add(T(node[i]), x.slope[i], line_slope);
      }
      plane = mul_add(line, y.value[j], plane);
      by_x = mul_add(line_slope, y.value[j], by_x);
      by_y = mul_add(line, y.slope[j], by_y);
    }
    to.velocity.x = mul_add(by_x, z.value[k], to.velocity.x);
    to.velocity.y = mul_add(by_y, z.value[k], to.velocity.y);
    to.velocity.z = mul_add(plane, z.slope[k], to.velocity.z);
  }
}

// v and its gradient, by rows.
template <class T>
struct GridSlope {
  Vec3<T> velocity{T(0), T(0), T(0)};
  Vec3<T> rows[3]{{T(0), T(0), T(0)}, {T(0), T(0), T(0)}, {T(0), T(0), T(0)}};
};

template <class T>
struct GridCurvatures {
  T along[3][4];
};

// Adds the contribution of one component of A to v and its gradient, in units of 1 / spacing.
template <std::size_t axis, class T, class S>
[[gnu::always_inline]] inline void add_component(const S* first, const std::ptrdiff_t (&stride)[3],
                                                 const GridWeights<T>& weights, const GridCurvatures<T>& curvatures,
                                                 GridSlope<T>& to) {
  constexpr std::size_t kNext = (axis + 1) % 3;
  constexpr std::size_t kLast = (axis + 2) % 3;
  const SplineWeights<T>& own = weights.along[axis];
  const SplineWeights<T>& next = weights.along[kNext];
  const SplineWeights<T>& last = weights.along[kLast];
  const T zero(0);
  Vec3<T> by_next{zero, zero, zero};  // the derivatives of dA/dnext along own, next and last axis
  Vec3<T> by_last{zero, zero, zero};  // the derivatives of dA/dlast
  T next_slope(0);
  T last_slope(0);
  for (int k = 0; k < 4; ++k) {
    T plane[3]{zero, zero, zero};  // the sum, and its two derivatives along the next axis
    T slope[2]{zero, zero};        // its derivative along its own axis, and the derivative of this along the next
    for (int j = 0; j < 4; ++j) {
      const S* const node = first + axis + k * stride[kLast] + j * stride[kNext];
      T line(0);
      T line_slope(0);
      for (int i = 0; i < 4; ++i) {
        const T number(node[i * stride[axis]]);
        line = mul_add(number, own.value[i], line);
        line_slope = mul_add(number, own.slope[i], line_slope);
      }
      plane[0] = mul_add(line, next.value[j], plane[0]);
      plane[1] = mul_add(line, next.slope[j], plane[1]);
      plane[2] = mul_add(line, curvatures.along[kNext][j], plane[2]);
      slope[0] = mul_add(line_slope, next.value[j], slope[0]);
      slope[1] = mul_add(line_slope, next.slope[j], slope[1]);
    }
    next_slope = mul_add(plane[1], last.value[k], next_slope);
    last_slope = mul_add(plane[0], last.slope[k], last_slope);
    by_next = {mul_add(slope[1], last.value[k], by_next.x), mul_add(plane[2], last.value[k], by_next.y),
               mul_add(plane[1], last.slope[k], by_next.z)};
    by_last = {mul_add(slope[0], last.slope[k], by_last.x), by_next.z,
               mul_add(plane[0], curvatures.along[kLast][k], by_last.z)};
  }
  to.velocity[kNext] = to.velocity[kNext] + last_slope;
  to.velocity[kLast] = to.velocity[kLast] - next_slope;
  const std::size_t axes[3] = {axis, kNext, kLast};
  for (std::size_t i = 0; i < 3; ++i) {
    to.rows[kNext][axes[i]] = to.rows[kNext][axes[i]] + by_last[i];
    to.rows[kLast][axes[i]] = to.rows[kLast][axes[i]] - by_next[i];
  }
}

// Adds grad p and its gradient, in units of 1 / spacing.
template <class T, class S>
[[gnu::always_inline]] inline void add_growth(const GridView<S>& grid, const S* first, const GridWeights<T>& weights,
                                              const GridCurvatures<T>& curvatures, GridSlope<T>& to) {
  const auto& [x, y, z] = weights.along;
  for (int k = 0; k < 4; ++k) {
    T sum[3][3]{};  // of a plane, by the orders of the derivatives along x and y, together at most 2
    for (int j = 0; j < 4; ++j) {
      const S* const node = first + k * grid.plane + j * grid.row;
      T line[3]{T(0), T(0), T(0)};
      for (int i = 0; i < 4; ++i) {
        const T number(node[i]);
        line[0] = mul_add(number, x.value[i], line[0]);
        line[1] = mul_add(number, x.slope[i], line[1]);
        line[2] = mul_add(number, curvatures.along[0][i], line[2]);
      }
      for (int d = 0; d < 3; ++d) sum[d][0] = mul_add(line[d], y.value[j], sum[d][0]);
      for (int d = 0; d < 2; ++d) sum[d][1] = mul_add(line[d], y.slope[j], sum[d][1]);
      sum[0][2] = mul_add(line[0], curvatures.along[1][j], sum[0][2]);
    }
    const T& value = z.value[k];
    const T& slope = z.slope[k];
    to.velocity = mul_add(Vec3<T>{sum[1][0], sum[0][1], T(0)}, value, to.velocity);
    to.velocity.z = mul_add(sum[0][0], slope, to.velocity.z);
    const Vec3<T> along_z = Vec3<T>{sum[1][0], sum[0][1], T(0)} * slope;
    to.rows[0] = mul_add(Vec3<T>{sum[2][0], sum[1][1], T(0)}, value, to.rows[0]);
    to.rows[1] = mul_add(Vec3<T>{sum[1][1], sum[0][2], T(0)}, value, to.rows[1]);
    to.rows[0].z = to.rows[0].z + along_z.x;
    to.rows[1].z = to.rows[1].z + along_z.y;
    to.rows[2] = to.rows[2] + Vec3<T>{along_z.x, along_z.y, sum[0][0] * curvatures.along[2][k]};
  }
}

template <class T, class S>
[[gnu::always_inline]] inline GridSlope<T> sum_slopes(const GridView<S>& grid, const S* first, const S* growth,
                                                      const Vec3<T>& within) {
  const std::ptrdiff_t stride[3] = {3, 3 * grid.row, 3 * grid.plane};
  const GridWeights<T> weights = weights_at(within);
  GridCurvatures<T> curvatures;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
  for (std::size_t axis = 0; axis < 3; ++axis) spline_curvatures(within[axis], curvatures.along[axis]);
  GridSlope<T> sum;
  add_component<0>(first, stride, weights, curvatures, sum);
  add_component<1>(first, stride, weights, curvatures, sum);
  add_component<2>(first, stride, weights, curvatures, sum);
  if (growth != nullptr) add_growth(grid, growth, weights, curvatures, sum);
  for (Vec3<T>& row : sum.rows) row = row * T(grid.per_spacing);
  return sum;
}

// v and its gradient at the time t in the cell with this first node.
template <class T, class S>
[[gnu::always_inline]] inline GridSlope<T> slope_in_cell(const GridView<S>& grid, std::ptrdiff_t node,
                                                         const Vec3<T>& within, const T& t) {
  const S* const growth = grid.growth == nullptr ? nullptr : grid.growth + node;
  GridSlope<T> slope = sum_slopes(grid, grid.numbers + 3 * node, growth, within);
  if (grid.end_numbers == nullptr) return slope;
  const GridSlope<T> end = sum_slopes(grid, grid.end_numbers + 3 * node, growth, within);
  slope.velocity = mul_add(end.velocity - slope.velocity, t, slope.velocity);
  for (std::size_t row = 0; row < 3; ++row) {
    slope.rows[row] = mul_add(end.rows[row] - slope.rows[row], t, slope.rows[row]);
  }
  return slope;
}

// The number of the first node of a single place's cell, for any scalar.
template <class T, class S>
[[gnu::always_inline]] inline std::ptrdiff_t node_at(const GridView<S>& grid, const GridPlace<T>& place) {
  const auto number = [](const T& index) {
    if constexpr (requires { index.v; }) {
      return static_cast<int>(index.v);
    } else {
      return static_cast<int>(index);
    }
  };
  return node_of(grid, number(place.cell.x), number(place.cell.y), number(place.cell.z));
}

// Returns v and A at y and the time t, for numbers and dual numbers.
template <class T, class S>
GridValue<T> evaluate_grid(const GridView<S>& grid, const Vec3<T>& y, const T& t) {
  const GridPlace<T> place = place_in(grid, y);
  const std::ptrdiff_t node = node_at(grid, place);
  if (grid.used[node] == 0) return {};
  const GridWeights<T> weights = weights_at(place.within);
  GridValue<T> value = sum_cell<true>(grid, grid.numbers + 3 * node, weights);
  if (grid.end_numbers != nullptr) {
    const GridValue<T> end = sum_cell<true>(grid, grid.end_numbers + 3 * node, weights);
    value.velocity = mul_add(end.velocity - value.velocity, t, value.velocity);
    value.potential = mul_add(end.potential - value.potential, t, value.potential);
  }
  if (grid.growth != nullptr) add_growth(grid, grid.growth + node, weights, value);
  value.potential = value.potential * T(grid.spacing);
  return value;
}

// Returns v and its gradient at y and the time t.
inline GridSlope<double> slope_at(const GridView<double>& grid, const Vec3d& y, double t) {
  const GridPlace<double> place = place_in(grid, y);
  const std::ptrdiff_t node = node_at(grid, place);
  return grid.used[node] == 0 ? GridSlope<double>{} : slope_in_cell(grid, node, place.within, t);
}

// Adds the gradient of by_curl . (the curl of A) + by_value . A at a place with respect to the coefficients to three
// planes of numbers, each of the length `plane`: x of all nodes, y and z. A is 216 times the sum of the splines, the
// unit of its curl is 1 / spacing.
[[gnu::always_inline]] inline void add_by_coefficients(const GridView<double>& grid, const GridPlace<double>& place,
                                                       const Vec3d& by_curl, const Vec3d& by_value, double* planes,
                                                       std::ptrdiff_t plane) {
  const GridWeights<double> weights = weights_at(place.within);
  const auto& [wx, wy, wz] = weights.along;
  double* const first = planes + node_at(grid, place);
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      const double both = wy.value[j] * wz.value[k];
      const double by_y = wy.slope[j] * wz.value[k];
      const double by_z = wy.value[j] * wz.slope[k];
      const Vec3d of_value{by_curl.y * by_z - by_curl.z * by_y + by_value.x * both,
                           by_value.y * both - by_curl.x * by_z, by_curl.x * by_y + by_value.z * both};
      double* const to = first + k * grid.plane + j * grid.row;
      for (int i = 0; i < 4; ++i) {
        to[i] += wx.value[i] * of_value.x;
        to[plane + i] += wx.value[i] * of_value.y + wx.slope[i] * (by_curl.z * both);
        to[2 * plane + i] += wx.value[i] * of_value.z - wx.slope[i] * (by_curl.y * both);
      }
    }
  }
}

inline constexpr int kEmptyNodes = 4;  // on each side of a grid

// The limits of a grid's nodes, without and with the empty ones.
inline constexpr std::size_t kMaxGridNodes = std::size_t{1} << 24;
inline constexpr std::size_t kMaxPaddedNodes = std::size_t{1} << 25;

// Returns the number of a grid's nodes; nothing if there are none or too many.
std::optional<std::size_t> node_count(const std::array<int, 3>& counts);

// Returns the node that positions are relative to.
Vec3d middle_node(const PotentialGrid& grid);

// Returns the box of the nodes that are not 0 at some time; empty if there are none. v is 0 beyond 2 spacings from it.
Box box_in_use(const PotentialGrid& grid);

// Which cells of a valid grid are used: those with a node that is not 0, at the beginning or at the end.
class GridCells {
 public:
  explicit GridCells(const PotentialGrid& grid);

  Vec3d center() const { return center_; }  // middle_node

  // Returns the grid without its numbers.
  template <class S>
  GridView<S> view() const;

  // Returns the nodes' numbers in the order of GridView.
  template <class S>
  std::vector<S> numbers(const SharedVectors& coefficients) const;
  template <class S>
  std::vector<S> numbers(const SharedNumbers& growth) const;

  // Returns three numbers for each node of the grid, from three planes in the order of GridView; from six planes those
  // of the second three after them.
  std::vector<double> from_planes(std::span<const double> planes) const;

  const std::vector<std::uint8_t>& used() const { return used_; }

 private:
  std::size_t number_of(int x, int y, int z) const;
  template <class Body>
  void for_each_node(const Body& body) const;

  std::array<int, 3> inner_{};  // nodes
  std::array<int, 3> nodes_{};  // with the empty ones
  std::array<int, 3> middle_{};
  double spacing_ = 1;
  Vec3d center_;
  std::vector<std::uint8_t> used_;
};

// Returns whether v may be other than 0 at x at some time. For a single place; GridCells answers for many.
bool is_used(const PotentialGrid& grid, const Vec3d& x);

// The numbers of a grid, and the view that points to them.
template <class S>
struct GridNodes {
  GridCells cells;
  std::vector<S> numbers;
  std::vector<S> end_numbers;
  std::vector<S> growth;
  GridView<S> view;

  explicit GridNodes(const PotentialGrid& grid)
      : cells(grid), numbers(cells.numbers<S>(grid.coefficients)), view(cells.view<S>()) {
    view.numbers = numbers.data();
    if (!grid.growth.empty()) {
      growth = cells.numbers<S>(grid.growth);
      view.growth = growth.data();
    }
    if (grid.end_coefficients.empty()) return;
    end_numbers = cells.numbers<S>(grid.end_coefficients);
    view.end_numbers = end_numbers.data();
  }
  GridNodes(const GridNodes&) = delete;
  GridNodes& operator=(const GridNodes&) = delete;
  ~GridNodes() = default;
};

// Tests whether a grid's v is 0 in a box.
class GridSupport {
 public:
  explicit GridSupport(const PotentialGrid& grid);

  // Returns whether v is 0 everywhere in the box, with a margin for rounding.
  bool misses(const Box& box) const;

 private:
  std::int32_t count_below(int x, int y, int z) const;

  Vec3d origin_;  // the low corner of the first cell
  double spacing_ = 1;
  std::array<int, 3> cells_{};
  std::vector<std::int32_t> below_;  // the number of used cells below each corner along all axes
};

}  // namespace knead::detail
