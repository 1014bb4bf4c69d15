// Gaussian splats: points with a covariance, and a colour that depends on the direction from which they are seen.
#pragma once

#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

// Returns whether the mesh holds splats: no faces, and the vertex attributes of real numbers scale_0 to scale_2
// (logarithms of the standard deviations) and rot_0 to rot_3 (the quaternion w, x, y, z of their axes), as the files of
// Kerbl et al. (2023) have them.
bool are_splats(const Mesh& mesh);

// Returns the attributes of splats after a deformation, those that scale_*, rot_* and f_rest_* replace, in their order.
// `jacobians`: one for each splat, of the deformation at its centre (flow.h), with a determinant above 0. With J the
// covariance S becomes J S J^T, again as sizes and a unit quaternion, whose axes keep their order. The spherical
// harmonics f_rest_* (9, 24 or 45 of them: degrees 1 to 3; those of red first) turn by the rotation of J's polar
// factor. Opacity and f_dc_* stay. Where J is the identity, every bit stays. Throws InvalidInput if are_splats() is
// false, for another number of harmonics or of Jacobians; Cancelled. Method: one-sided Jacobi for the singular values;
// harmonics are read in as many directions as there are of a degree. Time: about 2 us a splat that changes. The same
// bits for every number of threads, which are as for parallel_for.
std::vector<Attribute> deformed_splats(const Mesh& splats, std::span<const Mat3d> jacobians, int threads = 0,
                                       const Progress* progress = nullptr);

}  // namespace knead
