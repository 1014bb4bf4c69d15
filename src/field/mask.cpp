// Makes the grid of a mask from its points, and evaluates masks at single points.
#include "knead/field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "field/mask_grid.h"
#include "knead/error.h"
#include "math/elementary.h"

namespace knead {

namespace {

using namespace detail;

// A cell with a masked point masks the four nodes along each axis on which it depends as much as the point, and further
// nodes by these parts of 256. A Gaussian, so that the product over three axes is round. It is 0 from the fifth node
// on, so a point masks cells up to 7 away from its own, less than a brick.
constexpr std::array<int, 5> kNodeFalloff{256, 205, 105, 35, 7};
constexpr int kTaps = 12;                            // cells along an axis that mask a node
constexpr int kBrickTaps = kBrickNodes + kTaps - 1;  // cells along an axis that mask a brick
constexpr std::size_t kBricksAtOnce = 32;
constexpr int kCellsPerWidth = 8;
constexpr double kMaxBricks = 8e6;
constexpr double kMaxCells = 1e12;  // from the origin of coordinates

using Index = std::array<std::int64_t, 3>;
using Bytes = std::array<std::uint8_t, kBrickCells * kBrickCells * kBrickCells>;

std::int64_t floor_of_eighth(std::int64_t cell) { return cell >> 3; }

void check(std::span<const Vec3d> points, std::span<const double> values, double width) {
  if (!(width > 0 && std::isfinite(width))) {
    throw InvalidInput(fmt::format("\"width\" must be a number greater than 0, got {}", width));
  }
  if (points.empty()) throw InvalidInput("a mask needs 1 or more points");
  if (!values.empty() && values.size() != points.size()) {
    throw InvalidInput("a mask's values must be none, or one for each point");
  }
  for (const double value : values) {
    if (!(value >= 0 && value <= 1)) throw InvalidInput(fmt::format("a mask's values lie from 0 to 1, got {}", value));
  }
  for (const Vec3d& p : points) {
    const double size = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (!(size * kCellsPerWidth / width < kMaxCells)) {
      throw InvalidInput(fmt::format("\"width\" {} is too small for points as far from the origin as {}", width, size));
    }
  }
}

int byte_of(double value) { return static_cast<int>(std::floor(value * 255 + 0.5)); }

Index cell_of(const Vec3d& p, double spacing) {
  return {static_cast<std::int64_t>(std::floor(p.x / spacing)), static_cast<std::int64_t>(std::floor(p.y / spacing)),
          static_cast<std::int64_t>(std::floor(p.z / spacing))};
}

// Calls visit(cell) for the cell of a point and for those on whose border it lies, because the rounding of floats can
// put it into any of them. 1/64 of a cell is the rounding of places 10^5 cells from the centre of a block of points.
template <class Visit>
void for_each_cell(const Vec3d& p, double spacing, const Visit& visit) {
  constexpr double kBorderWidth = 1.0 / 64;
  const Index cell = cell_of(p, spacing);
  Index first = cell;
  Index last = cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double within = p[axis] / spacing - static_cast<double>(cell[axis]);
    if (within < kBorderWidth) --first[axis];
    if (within > 1 - kBorderWidth) ++last[axis];
  }
  Index at = first;
  for (at[2] = first[2]; at[2] <= last[2]; ++at[2]) {
    for (at[1] = first[1]; at[1] <= last[1]; ++at[1]) {
      for (at[0] = first[0]; at[0] <= last[0]; ++at[0]) visit(at);
    }
  }
}

// The bricks of a grid; their numbers are those of the table.
struct Bricks {
  Index first{};
  std::array<int, 3> count{};

  std::size_t number(const Index& brick) const {
    return static_cast<std::size_t>((brick[0] - first[0]) +
                                    count[0] * ((brick[1] - first[1]) + count[1] * (brick[2] - first[2])));
  }
  std::size_t size() const {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(count[2]);
  }
};

// Finds the bricks of the box and two more on every side: one that points can mask, and one that is free. Returns their
// number, with which the counts may be too large to be right.
double size_around(const Box& box, double width, Bricks& bricks) {
  const double spacing = width / kCellsPerWidth;
  const Index low = cell_of(box.min, spacing);
  const Index high = cell_of(box.max, spacing);
  double size = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bricks.first[axis] = floor_of_eighth(low[axis]) - 2;
    const std::int64_t count = floor_of_eighth(high[axis]) + 3 - bricks.first[axis];
    size *= static_cast<double>(count);
    bricks.count[axis] = static_cast<int>(std::min<std::int64_t>(count, 1 << 24));
  }
  return size;
}

Bricks bricks_around(std::span<const Vec3d> points, double width) {
  const Box box = bounding_box(points);
  Bricks bricks;
  if (size_around(box, width, bricks) <= kMaxBricks) return bricks;
  double enough = width;
  while (size_around(box, enough, bricks) > kMaxBricks) {  // the next number of two digits
    const double scale = elementary::power_of_ten(1 - elementary::decimal_exponent(enough));
    enough = (std::floor(enough * scale * (1 + 1e-9)) + 1) / scale;
  }
  throw InvalidInput(fmt::format("\"width\" must be at least {:.2g} for masked points that lie {:.3g} apart, got {}",
                                 enough, box.diagonal(), width));
}

// The masking of cells, in the bricks with masked points.
struct Cells {
  std::vector<std::int32_t> of_brick;  // the index of its bytes, or -1
  std::vector<Bytes> bytes;

  void raise(const Bricks& bricks, const Index& cell, int value) {
    std::int32_t& at =
        of_brick[bricks.number({floor_of_eighth(cell[0]), floor_of_eighth(cell[1]), floor_of_eighth(cell[2])})];
    if (at < 0) {
      at = static_cast<std::int32_t>(bytes.size());
      bytes.push_back({});
    }
    const auto place = static_cast<std::size_t>((cell[0] & 7) + 8 * ((cell[1] & 7) + 8 * (cell[2] & 7)));
    std::uint8_t& byte = bytes[static_cast<std::size_t>(at)][place];
    byte = static_cast<std::uint8_t>(std::max<int>(byte, value));
  }
};

Cells masked_cells(std::span<const Vec3d> points, std::span<const double> values, double spacing,
                   const Bricks& bricks) {
  Cells cells{std::vector<std::int32_t>(bricks.size(), -1), {}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int value = values.empty() ? 255 : byte_of(values[i]);
    if (value == 0) continue;
    for_each_cell(points[i], spacing, [&](const Index& cell) { cells.raise(bricks, cell, value); });
  }
  return cells;
}

int falloff(int tap) { return kNodeFalloff[static_cast<std::size_t>(std::max({0, 4 - tap, tap - 7}))]; }

// to[i] = max(to[i], from[i] f / 256).
void raise(const std::uint8_t* from, int f, std::uint8_t* to, int count) {
  for (int i = 0; i < count; ++i) {
    const auto value = static_cast<std::uint8_t>((from[i] * f) >> 8);
    to[i] = value > to[i] ? value : to[i];
  }
}

// The nodes of one brick, from the cells around it. Falls off along one axis after the other.
class BrickNodes {
 public:
  void read(const Cells& cells, const Bricks& bricks, int x, int y, int z) {
    around_.fill(0);
    for (int k = -1; k <= 1; ++k) {
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) read_brick(cells, bricks, {x + i, y + j, z + k}, {i, j, k});
      }
    }
  }

  // Returns kBrickBytes bytes.
  const std::uint8_t* spread() {
    along_z_.fill(0);
    along_y_.fill(0);
    along_x_.fill(0);
    for (int tap = 0; tap < kTaps; ++tap) {
      for (int z = 0; z < kBrickNodes; ++z) {
        raise(&around_[index((z + tap) * kPlane)], falloff(tap), &along_z_[index(z * kPlane)], kPlane);
      }
    }
    for (int tap = 0; tap < kTaps; ++tap) {
      for (int z = 0; z < kBrickNodes; ++z) {
        for (int y = 0; y < kBrickNodes; ++y) {
          raise(&along_z_[index(z * kPlane + (y + tap) * kBrickTaps)], falloff(tap),
                &along_y_[index((z * kBrickNodes + y) * kBrickTaps)], kBrickTaps);
        }
      }
    }
    for (int tap = 0; tap < kTaps; ++tap) {
      for (int row = 0; row < kBrickNodes * kBrickNodes; ++row) {
        raise(&along_y_[index(row * kBrickTaps + tap)], falloff(tap), &along_x_[index(row * kBrickRow)], kBrickNodes);
      }
    }
    return along_x_.data();
  }

 private:
  static constexpr int kPlane = kBrickTaps * kBrickTaps;
  static constexpr int kBegin = 7;  // cells before the brick's own

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  void read_brick(const Cells& cells, const Bricks& bricks, const std::array<int, 3>& brick,
                  const std::array<int, 3>& offset) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (brick[axis] < 0 || brick[axis] >= bricks.count[axis]) return;
    }
    const std::int32_t at = cells.of_brick[index(brick[0] + bricks.count[0] * (brick[1] + bricks.count[1] * brick[2]))];
    if (at < 0) return;
    const Bytes& bytes = cells.bytes[index(at)];
    for (int k = 0; k < kBrickCells; ++k) {
      for (int j = 0; j < kBrickCells; ++j) {
        for (int i = 0; i < kBrickCells; ++i) {
          const int x = kBegin + kBrickCells * offset[0] + i;
          const int y = kBegin + kBrickCells * offset[1] + j;
          const int z = kBegin + kBrickCells * offset[2] + k;
          if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= kBrickTaps) continue;
          around_[index(x + kBrickTaps * (y + kBrickTaps * z))] = bytes[index(i + 8 * (j + 8 * k))];
        }
      }
    }
  }

  std::array<std::uint8_t, kBrickTaps * kBrickTaps * kBrickTaps> around_{};
  std::array<std::uint8_t, kBrickNodes * kBrickTaps * kBrickTaps> along_z_{};
  std::array<std::uint8_t, kBrickNodes * kBrickNodes * kBrickTaps> along_y_{};
  std::array<std::uint8_t, kBrickBytes> along_x_{};
};

// Returns whether all nodes have this byte; the last byte of a row is padding.
bool all_are(const std::uint8_t* nodes, std::uint8_t byte) {
  for (int row = 0; row < kBrickNodes * kBrickNodes; ++row) {
    const std::uint8_t* const begin = nodes + row * kBrickRow;
    if (std::any_of(begin, begin + kBrickNodes, [&](std::uint8_t node) { return node != byte; })) return false;
  }
  return true;
}

// Returns the ascending bricks with masked cells, and their neighbours.
std::vector<std::uint32_t> maskable_bricks(const Cells& cells, const Bricks& bricks) {
  std::vector<bool> reached(bricks.size());
  const auto [nx, ny, nz] = bricks.count;
  for (int z = 1; z + 1 < nz; ++z) {
    for (int y = 1; y + 1 < ny; ++y) {
      for (int x = 1; x + 1 < nx; ++x) {
        if (cells.of_brick[static_cast<std::size_t>(x + nx * (y + ny * z))] < 0) continue;
        for (int k = z - 1; k <= z + 1; ++k) {
          for (int j = y - 1; j <= y + 1; ++j) {
            for (int i = x - 1; i <= x + 1; ++i) reached[static_cast<std::size_t>(i + nx * (j + ny * k))] = true;
          }
        }
      }
    }
  }
  std::vector<std::uint32_t> result;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i]) result.push_back(static_cast<std::uint32_t>(i));
  }
  return result;
}

void make_nodes(const Cells& cells, const Bricks& bricks, int threads, MaskGrid& grid) {
  const std::vector<std::uint32_t> reached = maskable_bricks(cells, bricks);
  std::vector<std::array<std::uint8_t, kBrickBytes>> nodes(reached.size());
  const int nx = bricks.count[0];
  const int ny = bricks.count[1];
  parallel_for(reached.size(), kBricksAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    BrickNodes brick;
    for (std::size_t i = begin; i < end; ++i) {
      const auto number = static_cast<int>(reached[i]);
      brick.read(cells, bricks, number % nx, number / nx % ny, number / (nx * ny));
      std::copy_n(brick.spread(), kBrickBytes, nodes[i].begin());
    }
  });
  grid.start.assign(bricks.size(), 0);
  grid.bytes.assign(2 * kBrickBytes, 0);
  std::fill(grid.bytes.begin() + kBrickBytes, grid.bytes.end(), std::uint8_t{255});
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (all_are(nodes[i].data(), 0)) continue;
    const bool is_masked = all_are(nodes[i].data(), 255);
    grid.start[reached[i]] = is_masked ? kBrickBytes : static_cast<std::int32_t>(grid.bytes.size());
    if (!is_masked) grid.bytes.insert(grid.bytes.end(), nodes[i].begin(), nodes[i].end());
  }
}

// Passes over the bricks forwards and backwards: the distance of neighbours to a brick that is not free differs by at
// most 1.
void measure_clearance(MaskGrid& grid) {
  const int nx = grid.bricks[0];
  const int ny = grid.bricks[1];
  const int nz = grid.bricks[2];
  grid.clear.resize(grid.start.size());
  for (std::size_t i = 0; i < grid.start.size(); ++i) grid.clear[i] = grid.start[i] == 0 ? 255 : 0;
  const auto lower = [&](int x, int y, int z, int sign) {
    std::uint8_t& here = grid.clear[static_cast<std::size_t>(x + nx * (y + ny * z))];
    for (int n = 1; n <= 13; ++n) {  // half of the neighbours
      const int i = x - sign * ((n + 13) % 3 - 1);
      const int j = y - sign * ((n + 13) / 3 % 3 - 1);
      const int k = z - sign * ((n + 13) / 9 - 1);
      if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz) continue;
      const int there = grid.clear[static_cast<std::size_t>(i + nx * (j + ny * k))];
      here = static_cast<std::uint8_t>(std::min<int>(here, there + 1));
    }
  };
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) lower(x, y, z, 1);
    }
  }
  for (int z = nz - 1; z >= 0; --z) {
    for (int y = ny - 1; y >= 0; --y) {
      for (int x = nx - 1; x >= 0; --x) lower(x, y, z, -1);
    }
  }
}

// Finds a place of the border in a cube of half a brick: the mean of every second cell's place along each axis,
// weighted by |grad m|^2. Returns false if the cube contains no border.
bool border_in(const MaskView<double>& view, const Vec3d& corner, double spacing, Vec3d& place) {
  double weight = 0;
  place = {0, 0, 0};
  for (int n = 0; n < 8; ++n) {
    const Vec3d at = corner + Vec3d{1.0 + 2 * (n & 1), 1.0 + 2 * (n >> 1 & 1), 1.0 + 2 * (n >> 2)} * spacing;
    const double square = norm2(evaluate_mask(view, at).gradient);
    weight += square;
    place += at * square;
  }
  if (!(weight > 0)) return false;
  place = place / weight;
  return true;
}

void find_border(int threads, MaskGrid& grid) {
  std::vector<std::size_t> bricks;
  for (std::size_t i = 0; i < grid.start.size(); ++i) {
    if (grid.start[i] > kBrickBytes) bricks.push_back(i);
  }
  std::vector<Vec3d> places(8 * bricks.size());
  std::vector<std::uint8_t> found(places.size());
  const int nx = grid.bricks[0];
  const int ny = grid.bricks[1];
  const double size = grid.spacing * kBrickCells;
  const MaskView<double> view = view_of<double>(grid, grid.origin);
  parallel_for(bricks.size(), kBricksAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto number = static_cast<int>(bricks[i]);
      const Vec3d corner = Vec3d{1.0 * (number % nx), 1.0 * (number / nx % ny), 1.0 * (number / (nx * ny))} * size;
      for (int n = 0; n < 8; ++n) {
        const Vec3d half{1.0 * (n & 1), 1.0 * (n >> 1 & 1), 1.0 * (n >> 2)};
        const std::size_t part = 8 * i + static_cast<std::size_t>(n);
        found[part] = border_in(view, corner + half * (size / 2), grid.spacing, places[part]) ? 1 : 0;
      }
    }
  });
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (found[i] != 0) grid.border.push_back(places[i] + grid.origin);
  }
}

}  // namespace

Mask::Mask(std::span<const Vec3d> points, std::span<const double> values, double width, int threads) {
  check(points, values, width);
  const Bricks bricks = bricks_around(points, width);
  auto grid = std::make_shared<MaskGrid>();
  grid->width = width;
  grid->spacing = width / kCellsPerWidth;
  grid->bricks = bricks.count;
  grid->origin = Vec3d{static_cast<double>(bricks.first[0]), static_cast<double>(bricks.first[1]),
                       static_cast<double>(bricks.first[2])} *
                 (kBrickCells * grid->spacing);
  make_nodes(masked_cells(points, values, grid->spacing, bricks), bricks, threads, *grid);
  if (grid->bytes.size() == 2 * kBrickBytes &&
      std::none_of(grid->start.begin(), grid->start.end(), [](std::int32_t start) { return start != 0; })) {
    return;  // all values are 0
  }
  measure_clearance(*grid);
  find_border(threads, *grid);
  grid_ = std::move(grid);
}

double Mask::width() const { return grid_ == nullptr ? 0 : grid_->width; }

Box Mask::box() const {
  if (grid_ == nullptr) return {};
  const Vec3d size{1.0 * grid_->bricks[0], 1.0 * grid_->bricks[1], 1.0 * grid_->bricks[2]};
  const Vec3d brick = Vec3d{1, 1, 1} * (kBrickCells * grid_->spacing);
  return {grid_->origin + brick, grid_->origin + (size - Vec3d{1, 1, 1}) * (kBrickCells * grid_->spacing)};
}

MaskValue<double> Mask::at(const Vec3d& x) const {
  if (grid_ == nullptr) return {1, {0, 0, 0}};
  return evaluate_mask(view_of<double>(*grid_, grid_->origin), x - grid_->origin);
}

bool Mask::holds(const Vec3d& x) const {
  if (grid_ == nullptr) return false;
  const MaskView<double> view = view_of<double>(*grid_, grid_->origin);
  MaskRows<double> rows;
  read_rows(view, cells_at(view, x - grid_->origin), rows);
  return rows.are_masked();
}

bool operator==(const Mask& a, const Mask& b) {
  if (a.grid_ == b.grid_) return true;
  return a.grid_ != nullptr && b.grid_ != nullptr && *a.grid_ == *b.grid_;
}

std::vector<std::uint32_t> representative_points(std::span<const Vec3d> points, std::span<const double> values,
                                                 double width) {
  check(points, values, width);
  struct Best {
    int value = 0;
    std::uint32_t point = 0;
  };
  std::map<Index, Best> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int value = values.empty() ? 255 : byte_of(values[i]);
    if (value == 0) continue;
    for_each_cell(points[i], width / kCellsPerWidth, [&](const Index& cell) {
      Best& best = cells[cell];
      if (value > best.value) best = {value, static_cast<std::uint32_t>(i)};
    });
  }
  std::vector<std::uint32_t> result;
  result.reserve(cells.size());
  for (const auto& [cell, best] : cells) result.push_back(best.point);
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace knead
