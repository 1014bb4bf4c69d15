// Gaussian splats: points with a covariance, and a colour that depends on the direction from which they are seen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

// Returns whether the mesh holds splats: no faces, and the vertex attributes of real numbers scale_0 to scale_2
// (logarithms of the standard deviations) and rot_0 to rot_3 (the quaternion w, x, y, z of their axes), as the files of
// Kerbl et al. (2023) have them.
bool are_splats(const Mesh& mesh);

// Returns the degree of the spherical harmonics of splats, 0 to 3: that of 0, 9, 24 or 45 attributes f_rest_*. Throws
// InvalidInput for another number of them, or if are_splats() is false.
std::size_t splat_degree(const Mesh& splats);

// Returns the real spherical harmonics of degrees 1 to 3 in the direction of a unit vector, with the signs and factors
// of splats.
std::array<double, 15> splat_harmonics(const Vec3d& direction);

// Returns the axes of a splat, to which its sizes belong. turn: the quaternion w, x, y, z, of any length above 0;
// another one counts as no turn.
std::array<Vec3d, 3> splat_axes(std::array<double, 4> turn);

// The Jacobian of a deformation at the splats where it is not the identity.
struct SplatJacobians {
  std::vector<std::uint32_t> splats;  // ascending
  std::vector<Mat3d> jacobians;       // one for each of these, with a determinant above 0
};

// Splats with other numbers than before, for WriteOptions.
struct ChangedSplats {
  std::vector<std::uint32_t> splats;  // ascending
  std::vector<Attribute> attributes;  // with a value for each of these
};

// Returns the splats after a deformation: scale_*, rot_* and f_rest_* of those that have a Jacobian. With J the
// covariance S becomes J S J^T, again as sizes and a unit quaternion, whose axes keep their order. The spherical
// harmonics f_rest_* (those of red first) turn by the rotation of J's polar factor. Opacity and f_dc_* stay. Throws as
// splat_degree(); InvalidInput for a splat that is not there; Cancelled. Method: one-sided Jacobi for the singular
// values; harmonics are read in as many directions as there are of a degree. Time: about 2 us a splat. The same bits
// for every number of threads, which are as for parallel_for.
ChangedSplats deformed_splats(const Mesh& splats, const SplatJacobians& jacobians, int threads = 0,
                              const Progress* progress = nullptr);

}  // namespace knead
