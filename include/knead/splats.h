// Gaussian splats: points with a covariance, and a colour that depends on the direction from which they are seen.
#pragma once

#include "knead/flow.h"
#include "knead/mesh.h"

namespace knead {

// Returns whether the mesh holds splats: no faces, and the vertex attributes scale_0 to scale_2 (logarithms of the
// standard deviations) and rot_0 to rot_3 (the quaternion w, x, y, z of their axes), as the files of Kerbl et al.
// (2023) have them.
bool are_splats(const Mesh& mesh);

// What deform_splats() did.
struct DeformedSplats {
  std::size_t changed = 0;  // splats whose surroundings turned or stretched
  // Of these, how many reach farther than the flow about them is linear: over one standard deviation their image bends
  // by more than a tenth of it. One splat cannot show such an image.
  std::size_t bent = 0;
};

// Changes the attributes of splats as the flow changes the space about their centres; leaves the positions where they
// are, before the flow. With J, the Jacobian of the flow's map, the covariance S becomes J S J^T, again as sizes and a
// unit quaternion, whose axes keep their order. The spherical harmonics f_rest_* (9, 24 or 45 of them: degrees 1 to 3;
// those of red first) turn by the rotation of J's polar factor. Opacity and f_dc_* stay. Where J is the identity, every
// bit stays.
// Throws InvalidInput if are_splats() is false, for another number of harmonics, and where jacobians() does; Cancelled.
// Method: one-sided Jacobi for the singular values; harmonics are read in as many directions as there are of a degree.
// Time: about 2 us a splat that changes, besides jacobians(). The same bits for every number of threads.
DeformedSplats deform_splats(Mesh& splats, const Flow& flow, const AdvectOptions& options);

}  // namespace knead
