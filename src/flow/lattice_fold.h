// Whether a lattice folds space: a proof that det J > 0 in its box, or a place where it is not. Internal to the
// library.
#pragma once

#include <optional>

#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// A place where a lattice folds space, or where the proof ended.
struct LatticeFold {
  Vec3d place;  // at t = 0
  double time = 1;
  double determinant = 0;  // of the Jacobian of x + time D(x) there
};

// Returns nothing if det J > 0 is proven in the whole box, at every time from 0 to `until`. The proof divides the box
// and the time into pieces, in each of which J differs from one matrix K with det K > 0 so little that |K^-1 J - I| < 1
// for all coefficients of J in Bernstein's basis, and so everywhere. A fold has a determinant of at most 0; a place
// with a greater one is so near to a fold that the proof would take too long.
std::optional<LatticeFold> find_fold(const LatticeMotion& lattice, double until = 1);

// Returns a time up to which there is no fold, as near to the first fold as a few trials tell.
double time_without_fold(const LatticeMotion& lattice, const LatticeFold& fold);

}  // namespace knead::detail
