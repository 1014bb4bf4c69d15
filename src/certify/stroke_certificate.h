// The certificate of one stroke.
#pragma once

#include <optional>
#include <vector>

#include "knead/certify.h"
#include "knead/flow.h"

namespace knead::detail {

// What certify() finds about one stroke.
struct StrokeCertificate {
  double drift = 0;           // the mean of det J - 1 over path lines of moved vertices; 0 with det_least
  double motion_outside = 0;  // as Certificate::motion_outside
  StrokeDistance distance;
  std::optional<double> det_least{};  // of a stroke that changes volumes on purpose: the least and greatest det J
  std::optional<double> det_greatest{};
};

// Returns the certificate of a stroke. `length`: the reference length of the input; tolerance and distances are
// relative to it. `max_points`: as CertificateBuilder. Throws InvalidInput if the result cannot be carried back (a path
// line runs to infinity).
StrokeCertificate certify(const AppliedStroke& stroke, const ReplayOptions& options, double length,
                          std::size_t max_points);

// Returns the flow without its limit cylinders, which moves the points that the flow moves in the same way. The limit
// cylinders of a sum stay: they decide which parts of the sum move a point.
Flow for_members(Flow flow);

// Returns the distance of a stroke's result from the exact image. `moved`: a flag for each vertex after the stroke that
// is known to have moved. Throws as certify().
StrokeDistance distance_of(const AppliedStroke& stroke, const std::vector<bool>& moved, const ReplayOptions& options,
                           double length, std::size_t max_points);

// Returns by how many the triangles that oppose the normals of their vertices are more in the mesh after than in the
// mesh before; 0 for fewer. Ignores triangles at edges of more than two faces, where normals are meaningless.
std::size_t opposing_more(const Mesh& before, const Mesh& after);

}  // namespace knead::detail
