#include "knead/tool/barrel_members.h"

#include <cstdint>

#include "knead/mesh/edges.h"

namespace knead {

namespace {

// still: the motion leaves it where it is, so that nothing needs to be known.
enum class Kind : std::uint8_t { still, moved, unmoved, open };

double distance_from_axis(const Barrel& barrel, const Vec3d& x) {
  return norm(cross(barrel.normal, x - barrel.center));
}

Kind kind_of(const Barrel& barrel, const Vec3d& deformed, const Vec3d& taken_back, double slack) {
  if (deformed == taken_back) return Kind::still;
  if (distance_from_axis(barrel, taken_back) > barrel.radius + slack) return Kind::unmoved;
  const bool would_move = distance_from_axis(barrel, deformed) < barrel.radius - slack &&
                          dot(barrel.normal, deformed - barrel.center) < barrel.outer - slack;
  return would_move ? Kind::moved : Kind::open;
}

template <class Visit>
void for_each_side(std::span<const Triangle> triangles, Visit visit) {
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) visit(triangle[i], triangle[(i + 1) % 3]);
  }
}

}  // namespace

std::vector<bool> barrel_members(const Barrel& barrel, std::span<const Vec3d> deformed,
                                 std::span<const Vec3d> taken_back, std::span<const Triangle> triangles, double slack) {
  std::vector<Kind> kinds;
  kinds.reserve(deformed.size());
  for (std::size_t i = 0; i < deformed.size(); ++i) {
    kinds.push_back(kind_of(barrel, deformed[i], taken_back[i], slack));
  }
  DisjointSets pieces(deformed.size());  // of open vertices
  for_each_side(triangles, [&](std::uint32_t a, std::uint32_t b) {
    if (kinds[a] == Kind::open && kinds[b] == Kind::open) pieces.join(a, b);
  });
  std::vector<int> votes(deformed.size(), 0);  // of a piece's neighbours, kept at its smallest vertex
  const auto vote = [&](std::uint32_t voter, std::uint32_t open) {
    if (kinds[open] != Kind::open) return;
    if (kinds[voter] == Kind::moved) ++votes[pieces.find(open)];
    if (kinds[voter] == Kind::unmoved) --votes[pieces.find(open)];
  };
  for_each_side(triangles, [&](std::uint32_t a, std::uint32_t b) {
    vote(a, b);
    vote(b, a);
  });
  std::vector<bool> members(deformed.size());
  for (std::uint32_t i = 0; i < deformed.size(); ++i) {
    members[i] = kinds[i] == Kind::moved;
    if (kinds[i] != Kind::open) continue;
    const int sum = votes[pieces.find(i)];
    members[i] = sum > 0 || (sum == 0 && distance_from_axis(barrel, taken_back[i]) <= barrel.radius);
  }
  return members;
}

}  // namespace knead
