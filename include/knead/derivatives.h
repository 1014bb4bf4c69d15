// Derivatives of a deformation with respect to the parameters of its session, and measures of a surface with theirs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead {

// How path lines are followed for their derivatives, always in double.
struct DerivativeOptions {
  // Error of one path line and of its derivative over one segment: of the place as a fraction of the diagonal, of the
  // derivative as a fraction of itself. From 1e-13 to 1. That of deform, 1e-5, takes a third of the default's time.
  double relative_tolerance = 1e-8;
  std::optional<double> diagonal{};  // by default that of the points' box
  int threads = 0;                   // 0: as many as the machine has
  Progress* progress = nullptr;      // counts points times segments
};

// Points where a flow takes them, and how they move there per unit of a direction in the space of the parameters.
struct PointTangents {
  std::vector<Vec3d> points;
  std::vector<Vec3d> tangents;
};

// The gradient of a function of the deformed points, with respect to the points before and to each parameter.
struct SessionGradient {
  std::vector<Vec3d> points;
  std::vector<double> parameters;
};

// The derivatives of the map that a session applies to points with respect to its parameters, at their values. The map
// is that of the exact flow (docs/decisions/0037-derivatives.md).
class SessionDerivatives {
 public:
  // Throws InvalidInput where flow_of does; naming it, for a parameter of which the flow has no derivative: it chooses
  // a whole number or how many segments there are, or it is in a mask, or in the nodes of a grid.
  // Costs some 20 flow_of() for each parameter, of the strokes that name it, each with the solution of its pins. Throws
  // Cancelled.
  explicit SessionDerivatives(const Session& session, const SessionPart& part = {}, int threads = 0,
                              const Progress* progress = nullptr);
  SessionDerivatives(const SessionDerivatives&) = delete;
  SessionDerivatives& operator=(const SessionDerivatives&) = delete;
  ~SessionDerivatives();

  // Returns the number of the flow's segments.
  std::size_t segments() const;

  // Forwards: returns where the flow takes each of the points, and the derivative of that place along the direction,
  // one number for each parameter of the session. The bits of a result depend on its point and the diagonal alone.
  // Cost: about 2 us for a point that a segment of one field reaches. Throws InvalidInput for numbers that are not
  // finite or not so many, a tolerance out of range, and a path line that needs over a million steps; Cancelled.
  PointTangents jvp(std::span<const Vec3d> points, std::span<const double> direction,
                    const DerivativeOptions& options) const;

  // Backwards: returns the gradient of a function of the deformed points, from its gradient with respect to these, one
  // vector for each point. Sums are taken in a fixed order: the result does not depend on the number of threads. Cost:
  // about one jvp(), however many parameters there are. Throws as jvp.
  SessionGradient vjp(std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                      const DerivativeOptions& options) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// Numbers measured on a surface, with their derivatives with respect to its points: an optimiser's constraints. Where a
// number has no derivative, as at the edge of what a thickness meets, one of the derivatives beside it is given.
struct SurfaceMeasures {
  std::vector<double> values;
  // Of each value in turn, up to ends[i]: the points on which it depends, and its derivatives with respect to these.
  std::vector<std::size_t> ends;
  std::vector<std::uint32_t> vertices;
  std::vector<Vec3d> derivatives;
  std::size_t points = 0;  // of the surface

  // Returns how fast the values change where the points move by the tangents. Throws InvalidInput unless there is one
  // for each point.
  std::vector<double> jvp(std::span<const Vec3d> tangents) const;
  // Returns the gradient by the points of the sum of weights times values. Throws InvalidInput unless there is one for
  // each value.
  std::vector<Vec3d> vjp(std::span<const double> weights) const;
};

// These throw InvalidInput for a number that is no vertex, and for coordinates that are not finite. Triangles are
// counter-clockwise seen from outside.

// Returns the volume within a closed surface. Throws InvalidInput if it is open.
SurfaceMeasures volume_of(std::span<const Vec3d> points, std::span<const Triangle> triangles);

// Returns the area of a surface.
SurfaceMeasures area_of(std::span<const Vec3d> points, std::span<const Triangle> triangles);

// Returns the wall thickness at each of the vertices: the distance along the inward normal to the other side. The
// normal is the mean of those of the faces around, weighted by area. Throws InvalidInput where there is no other side.
SurfaceMeasures thickness_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices);

// Returns the mean curvature at each of the vertices, 1 / r on a sphere, below 0 in hollows: of the cotangent Laplacian
// (Meyer et al. 2003), with a third of the area around. Throws InvalidInput at a border.
SurfaceMeasures curvature_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices);

// Returns the distance of each of the vertices from a patch. Where it is 0, so is its derivative.
SurfaceMeasures patch_distance(std::span<const Vec3d> points, std::span<const std::uint32_t> vertices,
                               std::span<const Triangle> patch);

}  // namespace knead
