// The sum of many wide pushes, as potential grids whose cost does not depend on their number
// (docs/decisions/0045-prints.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// The wide weight of bump a and outer R is a sum of weights of bumps a, 2a, 4a, ... up to R, whose outer is the next
// bump. The potential of each lies on grids with half its bump as spacing. Pushes that are close, by its bump, are
// joined.
class PushGrids {
 public:
  // Time: n log^2 n.
  PushGrids(std::span<const Vec3d> places, double bump, double outer, int threads);

  // Returns the grids of the pushes at these places, which must be near those of the constructor and as many. A push
  // alone moves its place by its vector in a unit of time. The grids act one after the other, those of the greatest
  // bump first.
  std::vector<PotentialGrid> grids(std::span<const Vec3d> places, std::span<const Vec3d> vectors) const;

  // Returns the number of grids.
  std::size_t count() const;
  double nodes() const { return nodes_; }

 private:
  // Pushes that act as one.
  using Cluster = std::vector<std::uint32_t>;

  struct Level {
    double bump = 0;
    double outer = 0;
    std::vector<std::vector<Cluster>> blocks;  // a grid each
  };

  double factor_ = 1;  // of each level's weight
  double nodes_ = 0;
  int threads_;
  std::vector<Level> levels_;
};

}  // namespace knead::detail
