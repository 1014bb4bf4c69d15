#include "knead/tool/barrel_pieces.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "knead/mesh/edges.h"

namespace knead::tool_detail {

namespace {

constexpr double kFree = 1.25;  // times the gap's inner end, where it has no outer one
constexpr int kDigits = 3;      // of a radius in a wide gap

std::vector<bool> vertices_below(const Barrel& barrel, std::span<const Vec3d> positions) {
  std::vector<bool> below(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    below[i] = dot(barrel.normal, positions[i] - barrel.center) < barrel.outer;
  }
  return below;
}

// A piece is known by its smallest vertex.
std::vector<std::uint32_t> label(const std::vector<bool>& below, std::span<const Triangle> triangles) {
  DisjointSets sets(below.size());
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangle[i];
      const std::uint32_t b = triangle[(i + 1) % 3];
      if (below[a] && below[b]) sets.join(a, b);
    }
  }
  std::vector<std::uint32_t> result;
  result.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    const auto lowest = std::find_if(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return below[v]; });
    result.push_back(lowest == triangle.end() ? BarrelPieces::kNone : sets.find(*lowest));
  }
  return result;
}

std::uint32_t nearest_piece(const std::vector<std::uint32_t>& piece, const Vec3d& center,
                            std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  std::uint32_t nearest = BarrelPieces::kNone;
  double least2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (piece[i] == BarrelPieces::kNone) continue;
    double square = least2;
    for (const std::uint32_t v : triangles[i]) square = std::min(square, norm2(positions[v] - center));
    if (square < least2) {
      least2 = square;
      nearest = piece[i];
    }
  }
  return nearest;
}

// Of every piece, at its number.
std::vector<Reach> piece_reaches(const std::vector<std::uint32_t>& piece,
                                 const std::vector<std::optional<Reach>>& reach, std::size_t vertices) {
  std::vector<Reach> result(vertices, {std::numeric_limits<double>::infinity(), 0});
  for (std::size_t i = 0; i < piece.size(); ++i) {
    if (piece[i] == BarrelPieces::kNone || !reach[i]) continue;
    Reach& whole = result[piece[i]];
    whole = {std::min(whole.min, reach[i]->min), std::max(whole.max, reach[i]->max)};
  }
  return result;
}

std::vector<Reach> later_reaches(const Barrel& barrel, std::span<const Vec3d> positions,
                                 std::span<const Triangle> triangles) {
  std::vector<Reach> all;
  if (barrel.last_normal == barrel.normal) return all;
  for (const Triangle& triangle : triangles) {
    if (const auto reach = reach_of(barrel, barrel.last_normal, positions, triangle)) all.push_back(*reach);
  }
  return merged(std::move(all));
}

// What `taken` leaves of the gap (low, high): the nearest piece that is wide enough, else the widest, by the ratio of
// its ends; all of the gap where nothing is left.
Reach free_part(double low, double high, const std::vector<Reach>& taken) {
  constexpr double kWide = kFree * kFree;
  Reach best{low, low};
  const auto consider = [&](double from, double to) {
    const double ratio = best.max / best.min;
    if (ratio < kWide && to > ratio * from) best = {from, to};
  };
  double from = low;
  for (const Reach& reach : taken) {
    consider(from, std::min(reach.min, high));
    from = std::max(from, reach.max);
  }
  consider(from, high);
  return best.min < best.max ? best : Reach{low, high};
}

}  // namespace

BarrelPieces barrel_pieces(const Barrel& barrel, std::span<const Vec3d> positions,
                           std::span<const Triangle> triangles) {
  BarrelPieces result;
  result.piece = label(vertices_below(barrel, positions), triangles);
  result.part = nearest_piece(result.piece, barrel.center, positions, triangles);
  if (result.part == BarrelPieces::kNone) return result;
  std::vector<std::optional<Reach>> reach;
  reach.reserve(triangles.size());
  for (const Triangle& triangle : triangles) reach.push_back(reach_of(barrel, barrel.normal, positions, triangle));
  const std::vector<Reach> whole = piece_reaches(result.piece, reach, positions.size());
  result.part_max = whole[result.part].max;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (result.piece[i] == BarrelPieces::kNone || result.piece[i] == result.part || !reach[i]) continue;
    const Reach& other = whole[result.piece[i]];
    if (other.max <= result.part_max) {
      ++result.within;
    } else if (other.min > result.part_max) {
      result.others = std::min(result.others, other.min);
    } else {
      if (reach[i]->min <= result.part_max) ++result.blocking;
      result.blocking_min = std::min(result.blocking_min, other.min);
    }
  }
  result.later = later_reaches(barrel, positions, triangles);
  return result;
}

std::optional<double> radius_in_gap(const BarrelPieces& pieces) {
  if (pieces.part == BarrelPieces::kNone || pieces.blocking > 0) return std::nullopt;
  const Reach gap = free_part(pieces.part_max, pieces.others, pieces.later);
  const double middle = std::isinf(gap.max) ? kFree * gap.min : std::sqrt(gap.min * gap.max);
  return short_number_between(gap.min, gap.max, middle, Round::nearest, kDigits);
}

}  // namespace knead::tool_detail
