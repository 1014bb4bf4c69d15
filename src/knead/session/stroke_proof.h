// What is proved of one stroke. Internal to the session room.
#pragma once

#include "knead/session/certificate.h"

namespace knead::session_detail {

struct StrokeProof {
  double drift = 0;           // the mean of det J - 1 over path lines of moved vertices
  double motion_outside = 0;  // Certificate::motion_outside
  StrokeDistance distance;
};

// `diagonal`: of the input's box, which tolerance and distances are relative to. Throws InvalidInput where the result
// cannot be carried back (a path line that runs away).
StrokeProof prove(const AppliedStroke& stroke, const ReplayOptions& options, double diagonal);

// How many triangles more of the mesh after than of the one before oppose the normals of their vertices; 0 for fewer.
std::size_t opposing_more(const Mesh& before, const Mesh& after);

}  // namespace knead::session_detail
