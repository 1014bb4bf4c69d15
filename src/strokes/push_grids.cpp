// Sums of wide pushes on potential grids.
#include "strokes/push_grids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "knead/error.h"

namespace knead::detail {

namespace {

constexpr double kNodesPerBump = 2;
constexpr double kJoined = 0.4;          // of the bump: closer pushes are joined
constexpr double kLastRatio = 3;         // of the outer threshold and the bump of the last level, at most
constexpr double kWorthDividing = 0.75;  // of the nodes
constexpr std::size_t kFewNodes = 4096;  // of a grid, which is not divided

// The nodes of a grid: multiples of the spacing.
struct PushedNodes {
  std::array<int, 3> first{};
  std::array<int, 3> count{};

  std::size_t nodes() const {
    std::size_t product = 1;
    for (const int each : count) product *= static_cast<std::size_t>(each);
    return product;
  }
};

// Returns the nodes nearer than `outer` to the box, and one more on each side for the spline.
PushedNodes nodes_around(const Box& box, double spacing, double outer) {
  PushedNodes nodes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nodes.first[axis] = static_cast<int>(std::floor((box.min[axis] - outer) / spacing)) - 1;
    nodes.count[axis] = static_cast<int>(std::ceil((box.max[axis] + outer) / spacing)) + 2 - nodes.first[axis];
  }
  return nodes;
}

// Makes blocks of clusters: one block, or those of the two halves across the longest side of its box if these save
// nodes. Returns the number of nodes of their grids.
template <class Iterator, class PlaceOf, class Blocks>
std::size_t divide(Iterator begin, Iterator end, double spacing, double outer, const PlaceOf& place_of,
                   Blocks& blocks) {
  Box box;
  for (Iterator each = begin; each != end; ++each) box.extend(place_of(*each));
  const std::size_t whole = nodes_around(box, spacing, outer).nodes();
  if (whole > kFewNodes && end - begin > 1) {
    const Vec3d size = box.max - box.min;
    const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    std::stable_sort(begin, end, [&](const auto& a, const auto& b) { return place_of(a)[axis] < place_of(b)[axis]; });
    const std::size_t before = blocks.size();
    const Iterator middle = begin + (end - begin) / 2;
    const std::size_t halves =
        divide(begin, middle, spacing, outer, place_of, blocks) + divide(middle, end, spacing, outer, place_of, blocks);
    if (static_cast<double>(halves) < kWorthDividing * static_cast<double>(whole)) return halves;
    blocks.resize(before);
  }
  blocks.emplace_back(begin, end);
  return whole;
}

double cubed(double x) { return x * x * x; }

// A part of the wide weight: the difference of two bumps over r^2, a polynomial inside the smaller one.
class LevelWeight {
 public:
  LevelWeight(double bump, double outer)
      : bump2_(bump * bump),
        outer2_(outer * outer),
        per_outer2_(1 / outer2_),
        value_(3 * (1 / bump2_ - per_outer2_)),
        slope_(3 * (1 / (bump2_ * bump2_) - per_outer2_ * per_outer2_)),
        curvature_(cubed(1 / bump2_) - cubed(per_outer2_)) {}

  double operator()(double r2) const {
    if (r2 < bump2_) return value_ - r2 * (slope_ - r2 * curvature_);
    return r2 < outer2_ ? cubed(1 - r2 * per_outer2_) / r2 : 0;
  }

 private:
  double bump2_;
  double outer2_;
  double per_outer2_;
  double value_;
  double slope_;
  double curvature_;
};

// Replaces values at nodes by the coefficients of a spline that approximates them; exact for cubic polynomials.
void filter(std::vector<Vec3d>& values, const std::array<int, 3>& counts) {
  std::array<std::size_t, 3> size{};
  std::copy(counts.begin(), counts.end(), size.begin());
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t length = size[axis];
    for (std::size_t line = 0; line < values.size() / length; ++line) {
      Vec3d* const at = values.data() + line / stride * stride * length + line % stride;
      Vec3d before{0, 0, 0};
      for (std::size_t i = 0; i < length; ++i) {
        const Vec3d own = at[i * stride];
        const Vec3d next = i + 1 < length ? at[(i + 1) * stride] : Vec3d{0, 0, 0};
        at[i * stride] = own * (4.0 / 3) - (before + next) * (1.0 / 6);
        before = own;
      }
    }
    stride *= length;
  }
}

// A push and its vector.
struct Push {
  Vec3d place;
  Vec3d vector;
};

PotentialGrid grid_of(const std::vector<Push>& pushes, double bump, double outer, int threads) {
  PotentialGrid grid;
  grid.spacing = bump / kNodesPerBump;
  Box box;
  for (const Push& push : pushes) box.extend(push.place);
  const PushedNodes nodes = nodes_around(box, grid.spacing, outer);
  grid.counts = nodes.count;
  grid.origin = Vec3d(nodes.first[0], nodes.first[1], nodes.first[2]) * grid.spacing;
  std::vector<Vec3d> values(nodes.nodes(), Vec3d{0, 0, 0});
  const LevelWeight weight(bump, outer);
  const auto row = static_cast<std::size_t>(nodes.count[0]);
  const auto plane = row * static_cast<std::size_t>(nodes.count[1]);
  const auto begin_of = [&](double x, double reach, std::size_t axis) {
    const double at = std::ceil((x - reach - grid.origin[axis]) / grid.spacing);
    return std::max(static_cast<int>(at), 0);
  };
  const auto end_of = [&](double x, double reach, std::size_t axis) {
    const double at = std::floor((x + reach - grid.origin[axis]) / grid.spacing);
    return std::min(static_cast<int>(at) + 1, nodes.count[axis]);
  };
  parallel_for(static_cast<std::size_t>(nodes.count[2]), 1, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const double z = grid.origin.z + static_cast<double>(k) * grid.spacing;
      for (const Push& push : pushes) {
        const double dz = z - push.place.z;
        if (std::abs(dz) >= outer) continue;
        const double disc = std::sqrt(outer * outer - dz * dz);
        for (int j = begin_of(push.place.y, disc, 1); j < end_of(push.place.y, disc, 1); ++j) {
          const double dy = grid.origin.y + j * grid.spacing - push.place.y;
          const double chord = std::sqrt(std::max(0.0, disc * disc - dy * dy));
          Vec3d* const at = values.data() + k * plane + static_cast<std::size_t>(j) * row;
          for (int i = begin_of(push.place.x, chord, 0); i < end_of(push.place.x, chord, 0); ++i) {
            const Vec3d d{grid.origin.x + i * grid.spacing - push.place.x, dy, dz};
            at[i] += cross(push.vector, d) * weight(norm2(d));
          }
        }
      }
    }
  });
  filter(values, nodes.count);
  grid.coefficients = SharedVectors(std::move(values));
  return grid;
}

}  // namespace

PushGrids::PushGrids(std::span<const Vec3d> places, double bump, double outer, int threads)
    : factor_(0.5 * bump * bump / (3 * (1 - bump * bump / (outer * outer)))), threads_(threads) {
  for (double a = bump; a < outer; a = levels_.back().outer) {
    levels_.push_back({a, kLastRatio * a < outer ? 2 * a : outer, {}});
  }
  std::reverse(levels_.begin(), levels_.end());
  for (Level& level : levels_) {
    std::map<std::array<double, 3>, Cluster> cells;
    for (std::uint32_t k = 0; k < places.size(); ++k) {
      const Vec3d cell = places[k] / (kJoined * level.bump);
      const std::array<double, 3> key = level.bump == bump
                                            ? std::array{1.0 * k, 0.0, 0.0}
                                            : std::array{std::floor(cell.x), std::floor(cell.y), std::floor(cell.z)};
      cells[key].push_back(k);
    }
    std::vector<Cluster> clusters;
    clusters.reserve(cells.size());
    for (auto& [key, cluster] : cells) clusters.push_back(std::move(cluster));
    const auto place_of = [&](const Cluster& cluster) { return places[cluster.front()]; };
    nodes_ += static_cast<double>(
        divide(clusters.begin(), clusters.end(), level.bump / kNodesPerBump, level.outer, place_of, level.blocks));
  }
}

std::vector<PotentialGrid> PushGrids::grids(std::span<const Vec3d> places, std::span<const Vec3d> vectors) const {
  std::vector<PotentialGrid> grids;
  std::vector<Push> pushes;
  for (const Level& level : levels_) {
    for (const std::vector<Cluster>& block : level.blocks) {
      pushes.clear();
      for (const Cluster& cluster : block) {
        Push& push = pushes.emplace_back();
        for (const std::uint32_t k : cluster) {
          push.place += places[k];
          push.vector += vectors[k] * factor_;
        }
        push.place = push.place / static_cast<double>(cluster.size());
      }
      grids.push_back(grid_of(pushes, level.bump, level.outer, threads_));
    }
  }
  return grids;
}

std::size_t PushGrids::count() const {
  std::size_t count = 0;
  for (const Level& level : levels_) count += level.blocks.size();
  return count;
}

}  // namespace knead::detail
