// How far from a barrel's axis triangles lie. Internal to the tool room.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/tool/barrel.h"

namespace knead::tool_detail {

// Distances from the axis: those from min up to, but not with, max.
struct Reach {
  double min = 0;
  double max = 0;
};

// The distances from the barrel's axis that the triangle's part with normal.(x - center) <= outer covers; nothing where
// it has no such part below outer. `normal` is the barrel's normal at some moment. Rounded as advect rounds when it
// decides whether a point belongs.
std::optional<Reach> reach_of(const Barrel& barrel, const Vec3d& normal, std::span<const Vec3d> positions,
                              const Triangle& triangle);

// Whether a barrel of that radius would be crossed.
inline bool crosses(const std::optional<Reach>& reach, double radius) {
  return reach && reach->min <= radius && radius < reach->max;
}

// Their union, by increasing min, no two touching.
std::vector<Reach> merged(std::vector<Reach> all);

// The union of the reaches of all triangles with the normal at the start, by increasing min, no two touching.
std::vector<Reach> merged_reaches(const Barrel& barrel, std::span<const Vec3d> positions,
                                  std::span<const Triangle> triangles);

// A short number strictly between low and high, as near the target as its digits let it be: six of them, or more where
// the gap is narrow. Nothing where the gap holds no number.
enum class Round { down, nearest, up };
std::optional<double> short_number_between(double low, double high, double target, Round round, int digits = 6);

}  // namespace knead::tool_detail
