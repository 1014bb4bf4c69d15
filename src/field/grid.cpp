// Potential grids: their nodes in the layout of the evaluation, and their used cells.
#include "field/grid.h"

#include <algorithm>
#include <cmath>

namespace knead::detail {

namespace {

constexpr double kRounding = 1e-9;  // of a cell

template <class T>
bool is_set(const SharedList<T>& list, std::size_t node) {
  return !list.empty() && !(list[node] == T{});
}

bool is_set(const PotentialGrid& grid, std::size_t node) {
  return is_set(grid.growth, node) || is_set(grid.coefficients, node) || is_set(grid.end_coefficients, node);
}

// Combines each byte with the next three, `stride` apart: with the next one, and that pair with the one 2 further on.
void spread(std::vector<std::uint8_t>& bytes, std::size_t stride) {
  for (const std::size_t by : {stride, 2 * stride}) {
    for (std::size_t i = 0; i + by < bytes.size(); ++i) bytes[i] = bytes[i] | bytes[i + by];
  }
}

template <class T>
void multiply(SharedList<T>& coefficients, double factor) {
  if (coefficients.empty()) return;
  std::vector<T> list(coefficients.begin(), coefficients.end());
  for (T& coefficient : list) coefficient *= factor;
  coefficients = SharedList<T>(std::move(list));
}

}  // namespace

std::optional<std::size_t> node_count(const std::array<int, 3>& counts) {
  std::size_t nodes = 1;
  std::size_t padded = 1;
  for (const int count : counts) {
    if (count < 1) return std::nullopt;
    nodes *= static_cast<std::size_t>(count);
    padded *= static_cast<std::size_t>(count) + std::size_t{2} * kEmptyNodes;
    if (nodes > kMaxGridNodes || padded > kMaxPaddedNodes) return std::nullopt;
  }
  return nodes;
}

Vec3d middle_node(const PotentialGrid& grid) {
  Vec3d place = grid.origin;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int middle = grid.counts[axis] / 2;
    place[axis] += middle * grid.spacing;
  }
  return place;
}

Box box_in_use(const PotentialGrid& grid) {
  Box box;
  std::size_t node = 0;
  for (int z = 0; z < grid.counts[2]; ++z) {
    for (int y = 0; y < grid.counts[1]; ++y) {
      for (int x = 0; x < grid.counts[0]; ++x, ++node) {
        if (is_set(grid, node)) box.extend(grid.origin + Vec3d{1.0 * x, 1.0 * y, 1.0 * z} * grid.spacing);
      }
    }
  }
  return box;
}

// Calls body(node, number) for each node of the grid: its numbers without and with the empty nodes.
template <class Body>
void GridCells::for_each_node(const Body& body) const {
  std::size_t node = 0;
  for (int z = 0; z < inner_[2]; ++z) {
    for (int y = 0; y < inner_[1]; ++y) {
      std::size_t number = number_of(kEmptyNodes, y + kEmptyNodes, z + kEmptyNodes);
      for (int x = 0; x < inner_[0]; ++x) body(node++, number++);
    }
  }
}

GridCells::GridCells(const PotentialGrid& grid)
    : inner_(grid.counts), spacing_(grid.spacing), center_(middle_node(grid)) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nodes_[axis] = inner_[axis] + 2 * kEmptyNodes;
    middle_[axis] = inner_[axis] / 2;
  }
  used_.resize(number_of(0, 0, nodes_[2]));
  const auto mark = [&]<class T>(const SharedList<T>& list) {
    if (list.empty()) return;
    for_each_node([items = list.data(), used = used_.data()](std::size_t node, std::size_t number) {
      if (!(items[node] == T{})) used[number] = 1;
    });
  };
  mark(grid.coefficients);
  mark(grid.end_coefficients);
  mark(grid.growth);
  spread(used_, 1);
  spread(used_, number_of(0, 1, 0));
  spread(used_, number_of(0, 0, 1));
}

std::size_t GridCells::number_of(int x, int y, int z) const {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  return at(x) + at(nodes_[0]) * (at(y) + at(nodes_[1]) * at(z));
}

template <class S>
GridView<S> GridCells::view() const {
  GridView<S> view;
  view.used = used_.data();
  view.row = static_cast<std::ptrdiff_t>(number_of(0, 1, 0));
  view.plane = static_cast<std::ptrdiff_t>(number_of(0, 0, 1));
  const auto before = [&](std::size_t axis) { return middle_[axis] + kEmptyNodes - 1; };
  view.first_node = static_cast<std::ptrdiff_t>(number_of(before(0), before(1), before(2)));
  view.spacing = static_cast<S>(spacing_);
  view.per_spacing = static_cast<S>(1 / spacing_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    view.first_cell[axis] = static_cast<S>(1 - kEmptyNodes - middle_[axis]);
    view.last_cell[axis] = static_cast<S>(inner_[axis] + 1 - middle_[axis]);
  }
  return view;
}

template <class S>
std::vector<S> GridCells::numbers(const SharedVectors& coefficients) const {
  std::vector<S> result(3 * used_.size());
  const double scale = 1 / (216 * spacing_);
  for_each_node([&](std::size_t node, std::size_t number) {
    S* const to = result.data() + 3 * number;
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = static_cast<S>(coefficients[node][axis] * scale);
  });
  return result;
}

template <class S>
std::vector<S> GridCells::numbers(const SharedNumbers& growth) const {
  std::vector<S> result(used_.size());
  const double scale = 1 / (216 * spacing_);
  for_each_node([&](std::size_t node, std::size_t number) { result[number] = static_cast<S>(growth[node] * scale); });
  return result;
}

std::vector<double> GridCells::from_planes(std::span<const double> planes) const {
  std::vector<double> result;
  for (std::size_t first = 0; first < planes.size(); first += 3 * used_.size()) {
    for_each_node([&](std::size_t /*node*/, std::size_t number) {
      for (std::size_t axis = 0; axis < 3; ++axis) result.push_back(planes[first + axis * used_.size() + number]);
    });
  }
  return result;
}

template GridView<float> GridCells::view<float>() const;
template GridView<double> GridCells::view<double>() const;
template std::vector<float> GridCells::numbers<float>(const SharedVectors&) const;
template std::vector<double> GridCells::numbers<double>(const SharedVectors&) const;
template std::vector<float> GridCells::numbers<float>(const SharedNumbers&) const;
template std::vector<double> GridCells::numbers<double>(const SharedNumbers&) const;

bool is_used(const PotentialGrid& grid, const Vec3d& x) {
  const Vec3d center = middle_node(grid);
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int count = grid.counts[axis];
    const int middle = count / 2;
    const double at = (x[axis] - center[axis]) * (1 / grid.spacing);
    if (!(at > -3 - middle && at < count + 2 - middle)) return false;
    const int cell = static_cast<int>(round_to_integer(at - 0.5)) + middle;
    first[axis] = std::max(cell - 1, 0);
    last[axis] = std::min(cell + 2, count - 1);
  }
  for (int k = first[2]; k <= last[2]; ++k) {
    for (int j = first[1]; j <= last[1]; ++j) {
      for (int i = first[0]; i <= last[0]; ++i) {
        const auto row =
            static_cast<std::size_t>(j) + static_cast<std::size_t>(grid.counts[1]) * static_cast<std::size_t>(k);
        if (is_set(grid, static_cast<std::size_t>(i) + static_cast<std::size_t>(grid.counts[0]) * row)) return true;
      }
    }
  }
  return false;
}

GridSupport::GridSupport(const PotentialGrid& grid) : spacing_(grid.spacing) {
  const GridCells cells(grid);
  const std::vector<std::uint8_t>& used = cells.used();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells_[axis] = grid.counts[axis] + 2 * kEmptyNodes;
    origin_[axis] = grid.origin[axis] - (kEmptyNodes - 1) * spacing_;
  }
  const auto [nx, ny, nz] = cells_;
  below_.resize((static_cast<std::size_t>(nx) + 1) * (static_cast<std::size_t>(ny) + 1) *
                (static_cast<std::size_t>(nz) + 1));
  std::size_t cell = 0;
  const auto row = static_cast<std::size_t>(nx) + 1;
  const std::size_t plane = row * (static_cast<std::size_t>(ny) + 1);
  std::size_t corner = plane + row;
  for (int z = 0; z < nz; ++z, corner += row) {
    for (int y = 0; y < ny; ++y) {
      std::int32_t in_row = 0;
      ++corner;
      for (int x = 0; x < nx; ++x, ++corner) {
        in_row += used[cell++];
        below_[corner] = in_row + below_[corner - row] + below_[corner - plane] - below_[corner - row - plane];
      }
    }
  }
}

std::int32_t GridSupport::count_below(int x, int y, int z) const {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  return below_[at(x) + (at(cells_[0]) + 1) * (at(y) + (at(cells_[1]) + 1) * at(z))];
}

bool GridSupport::misses(const Box& box) const {
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = std::abs(box.min[axis]) + std::abs(box.max[axis]) + std::abs(origin_[axis]);
    const double slack = kRounding + kRounding * size / spacing_;
    const auto index = [&](double at) {
      return static_cast<int>(std::clamp(std::floor(at), 0.0, static_cast<double>(cells_[axis])));
    };
    first[axis] = index((box.min[axis] - origin_[axis]) / spacing_ - slack);
    last[axis] = index((box.max[axis] - origin_[axis]) / spacing_ + slack + 1);
  }
  const auto planes = [&](int z) {
    return count_below(last[0], last[1], z) - count_below(first[0], last[1], z) - count_below(last[0], first[1], z) +
           count_below(first[0], first[1], z);
  };
  return planes(last[2]) - planes(first[2]) == 0;
}

}  // namespace knead::detail

namespace knead {

PotentialGrid multiplied(PotentialGrid grid, double factor) {
  detail::multiply(grid.coefficients, factor);
  detail::multiply(grid.end_coefficients, factor);
  detail::multiply(grid.growth, factor);
  return grid;
}

}  // namespace knead
