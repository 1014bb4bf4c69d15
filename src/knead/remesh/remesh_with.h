// A remesh with another improvement of the triangles, for comparisons. Internal to the remesh room.
#pragma once

#include <functional>

#include "knead/remesh/improve.h"

namespace knead::remesh_detail {

// Improves the triangles of a refined surface. Called again, on the refined surface, where its result has crossings.
using Improve = std::function<ImprovementCounts(Surface& surface, const Improvement& improvement)>;

// Does what remesh() does, with `improve` in place of its compensation and improvement.
Remeshed remesh_with(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                     const RemeshOptions& options, const Improve& improve);

}  // namespace knead::remesh_detail
