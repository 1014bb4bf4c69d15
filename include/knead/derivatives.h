// Derivatives of a deformation with respect to the parameters of its session, and measures of a surface with theirs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead {

// How derivatives are integrated along path lines, always in double.
struct DerivativeOptions {
  // Error of one path line over one segment: that of its position divided by the diagonal, and the relative error of
  // its derivative. From 1e-13 to 1. The tolerance of deform, 1e-5, takes a third of the time of 1e-8.
  double relative_tolerance = 1e-8;
  std::optional<double> diagonal{};  // a length; by default the diagonal of the points' box
  int threads = 0;                   // 0: as many as the machine has
  Progress* progress = nullptr;      // counts points times segments
};

// Deformed points, and their derivatives along a direction in the space of the parameters.
struct PointTangents {
  std::vector<Vec3d> points;
  std::vector<Vec3d> tangents;
};

// The gradient of a function of the deformed points with respect to the undeformed points and to each parameter.
struct SessionGradient {
  std::vector<Vec3d> points;
  std::vector<double> parameters;
};

// The derivatives of the map that a session applies to points with respect to its parameters, at their values. The map
// is that of the exact flow (docs/decisions/0037-derivatives.md).
class SessionDerivatives {
 public:
  // Throws InvalidInput where flow_of does, and for a parameter, which the message names, that has no derivative: it
  // sets a whole number or the number of segments, or is part of a mask or of a grid's nodes. Throws Cancelled. Cost:
  // for each parameter about 20 calls of flow_of() for the strokes that name it, each with the solution for its pins.
  explicit SessionDerivatives(const Session& session, const SessionPart& part = {}, int threads = 0,
                              const Progress* progress = nullptr);
  SessionDerivatives(const SessionDerivatives&) = delete;
  SessionDerivatives& operator=(const SessionDerivatives&) = delete;
  ~SessionDerivatives();

  // Returns the number of the flow's segments.
  std::size_t segments() const;

  // Forwards: returns the deformed position of each point, and its derivative along the direction, which has one number
  // for each parameter of the session. The bits of a result depend on its point and the diagonal alone. Cost: about 2
  // us for a point that a segment of one field reaches. Throws InvalidInput for numbers that are not finite, a
  // direction of another length, a tolerance out of range, and a path line that needs over a million steps; Cancelled.
  PointTangents jvp(std::span<const Vec3d> points, std::span<const double> direction,
                    const DerivativeOptions& options) const;

  // Backwards: takes the gradient of a function with respect to the deformed points, one vector for each point, and
  // returns its gradient with respect to the undeformed points and the parameters. The result has the same bits for
  // every number of threads. Cost: about one jvp(), for any number of parameters. Throws as jvp().
  SessionGradient vjp(std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                      const DerivativeOptions& options) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// The coefficients of a flow, for each segment: the displacements of its lattice, or the coefficients of its grid and
// then those at its end; none for another segment. What a grid's growth adds is not among them.
using FlowCoefficients = std::vector<std::vector<Vec3d>>;

// Returns the coefficients of a flow.
FlowCoefficients coefficients_of(const Flow& flow);

// Forwards: returns the deformed position of each point, and its derivative when the coefficients change in a
// direction. The direction has as many as coefficients_of() returns. Throws as SessionDerivatives::jvp().
PointTangents coefficient_jvp(const Flow& flow, std::span<const Vec3d> points, const FlowCoefficients& direction,
                              const DerivativeOptions& options);

// The gradient of a function of the deformed points with respect to the undeformed points and the coefficients.
struct CoefficientGradient {
  std::vector<Vec3d> points;
  FlowCoefficients coefficients;
};

// Backwards, as SessionDerivatives::vjp(), for any number of coefficients: those of grids may also be 0. Time
// (docs/decisions/0037-derivatives.md): a few times that of deform at its tolerance of 1e-5; for a grid some 30 times
// at 1e-8.
CoefficientGradient coefficient_vjp(const Flow& flow, std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                                    const DerivativeOptions& options);

// Values measured on a surface, with their derivatives with respect to its points: constraints for an optimiser. Where
// a value has no derivative, as a thickness measured onto an edge, the derivative on one side is given.
struct SurfaceMeasures {
  std::vector<double> values;
  // Value i depends on the points vertices[ends[i - 1]] to vertices[ends[i] - 1] (from 0 for the first value), and has
  // the derivatives at the same indices with respect to them.
  std::vector<std::size_t> ends;
  std::vector<std::uint32_t> vertices;
  std::vector<Vec3d> derivatives;
  std::size_t points = 0;  // of the surface

  // Returns the derivative of each value when the points move along the tangents. Throws InvalidInput unless there is
  // one tangent for each point.
  std::vector<double> jvp(std::span<const Vec3d> tangents) const;
  // Returns the gradient of the weighted sum of the values with respect to the points. Throws InvalidInput unless there
  // is one weight for each value.
  std::vector<Vec3d> vjp(std::span<const double> weights) const;
};

// The following functions throw InvalidInput for a number that is no vertex, and for coordinates that are not finite.
// Triangles are counter-clockwise seen from outside.

// Returns the volume within a closed surface. Throws InvalidInput if it is open.
SurfaceMeasures volume_of(std::span<const Vec3d> points, std::span<const Triangle> triangles);

// Returns the area of a surface.
SurfaceMeasures area_of(std::span<const Vec3d> points, std::span<const Triangle> triangles);

// Returns the wall thickness at each of the vertices: the distance along the inward normal to the other side. The
// normal is the mean of those of the faces around, weighted by area. Throws InvalidInput where there is no other side.
SurfaceMeasures thickness_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices);

// Returns the mean curvature at each of the vertices: 1 / r on a sphere, below 0 in hollows. Throws InvalidInput at a
// border. Method: the cotangent Laplacian (Meyer et al. 2003), divided by a third of the area of the faces around.
SurfaceMeasures curvature_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices);

// Returns the distance of each of the vertices from a patch. The derivative of a distance of 0 is given as 0.
SurfaceMeasures patch_distance(std::span<const Vec3d> points, std::span<const std::uint32_t> vertices,
                               std::span<const Triangle> patch);

}  // namespace knead
