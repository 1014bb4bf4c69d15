// The paper's remeshing (section 5.2), which ours is compared with: diffusion with projection back onto the undiffused
// surface, collapses at midpoints, no flips and no compensation. It loses volume at every stroke.
#pragma once

#include <span>

#include "knead/remesh.h"

namespace knead::test {

// Does what remesh() does, improving the triangles as the paper does; with no iterations, not at all.
Remeshed remesh_as_in_the_paper(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                                const RemeshOptions& options);

}  // namespace knead::test
