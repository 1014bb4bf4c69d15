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

// Returns whether the mesh has these attributes, with faces or without: of a mesh with faces, the vertices in no face
// are splats.
bool have_splats(const Mesh& mesh);

// Returns the degree of the spherical harmonics of splats, from 0 to 3; the mesh has 0, 9, 24 or 45 attributes
// f_rest_*. Throws InvalidInput for another number of them, or if have_splats() is false.
std::size_t splat_degree(const Mesh& splats);

// Returns the real spherical harmonics of degrees 1 to 3 at a unit vector, with the signs and factors of splat files.
std::array<double, 15> splat_harmonics(const Vec3d& direction);

// Returns the unit axes of a splat, in the order of its sizes. turn: a quaternion w, x, y, z of any length above 0; any
// other one counts as no rotation.
std::array<Vec3d, 3> splat_axes(std::array<double, 4> turn);

// Returns the smallest axis of each splat, as the normal of the surface that the splats cover: on the side from which
// most of 26 views from far away see the splat. Time: about 1 us a splat.
std::vector<Vec3d> splat_normals(const Mesh& splats);

// The Jacobian of a deformation at the splats where it is not the identity.
struct SplatJacobians {
  std::vector<std::uint32_t> splats;  // ascending
  std::vector<Mat3d> jacobians;       // one for each of `splats`, with a determinant above 0
};

// New values of some splats, for WriteOptions.
struct ChangedSplats {
  std::vector<std::uint32_t> splats;  // ascending
  std::vector<Attribute> attributes;  // with a value for each of `splats`
};

// Returns the new scale_*, rot_* and f_rest_* of the splats that have a Jacobian. The Jacobian J changes the covariance
// S to J S J^T; the result is given as sizes and a unit quaternion, whose axes keep their order. The spherical
// harmonics f_rest_* (red first) turn by the rotation of J's polar factor. Opacity and f_dc_* do not change. Throws
// InvalidInput as splat_degree(), and for a number that is no splat; Cancelled. Method: one-sided Jacobi for the
// singular values; harmonics are evaluated in as many directions as their degree has functions. Time: about 2 us a
// splat. `threads`: as for parallel_for; the result has the same bits for every number.
ChangedSplats deformed_splats(const Mesh& splats, const SplatJacobians& jacobians, int threads = 0,
                              const Progress* progress = nullptr);

}  // namespace knead
