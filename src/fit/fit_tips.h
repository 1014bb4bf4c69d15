// A start for surfaces in different poses: pairs of ends of limbs. Internal to the fit module.
#pragma once

#include <optional>
#include <vector>

#include "fit/coarse_body.h"
#include "fit/surface_matches.h"
#include "knead/fit.h"

namespace knead::detail {

// A surface, some of its points with normals, and a few hundred nodes.
struct PosedSurface {
  const CoarseBody& body;
  const std::vector<SurfaceSample>& samples;
};

// Returns the nodes that are farthest from all others along the surface, each the farthest of those around it. At most
// eight, the farthest first.
std::vector<std::uint32_t> tips_of(const CoarseBody& body);

// Returns sets of pairs of tips whose distances along the surfaces agree, at most twelve, the best first.
std::vector<std::vector<FitPair>> tip_sets(const CoarseBody& source, const CoarseBody& target, double diagonal);

// Returns pairs of tips whose distances along the surfaces agree, and whose pose brings the source much nearer to the
// target; nothing if there are no such pairs. Time: up to 2 s. Throws Cancelled.
std::optional<std::vector<FitPair>> match_tips(const PosedSurface& source, const PosedSurface& target, double diagonal,
                                               const Progress* progress);

}  // namespace knead::detail
