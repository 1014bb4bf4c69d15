// The certificate of one stroke.
#pragma once

#include <vector>

#include "knead/certify.h"
#include "knead/flow.h"

namespace knead::session_detail {

struct StrokeCertificate {
  // The mean of det J - 1 over path lines of moved vertices; 0 for a stroke that changes volumes on purpose, of which
  // the least and the greatest det J are given.
  double drift = 0;
  double motion_outside = 0;  // Certificate::motion_outside
  StrokeDistance distance;
  std::optional<double> det_least{};
  std::optional<double> det_greatest{};
};

// `length`: the reference length of the input, which tolerance and distances are relative to. Throws InvalidInput if
// the result cannot be carried back (a path line runs away).
StrokeCertificate certify(const AppliedStroke& stroke, const ReplayOptions& options, double length);

// Returns the flow without its limit cylinders: of a point that is known to move it is the same. The limit cylinders of
// a sum stay: they say which of its parts move a point.
Flow for_members(Flow flow);

// Returns the distance of a stroke's result from the exact image. `moved`: for each vertex after the stroke, whether it
// is known to have moved. Throws as certify().
StrokeDistance distance_of(const AppliedStroke& stroke, const std::vector<bool>& moved, const ReplayOptions& options,
                           double length);

// Returns how many more triangles of the mesh after than of the mesh before oppose the normals of their vertices; 0 for
// fewer. Does not judge triangles at edges of more than two faces, where normals mean nothing.
std::size_t opposing_more(const Mesh& before, const Mesh& after);

}  // namespace knead::session_detail
