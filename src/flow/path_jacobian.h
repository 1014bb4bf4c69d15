// The change of volume by the error of the integration; path lines with their Jacobians. Internal to the library.
// path_jacobian.cpp also defines jacobians() and velocities() of flow.h.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "flow/segment_mover.h"
#include "flow/tangents.h"
#include "flow/varying_fields.h"
#include "knead/flow.h"

namespace knead {

// Moves the points along their path lines and returns det J - 1 for each, where J is the Jacobian of the computed flow
// map. Integrates dJ/dt = grad v J along the path line, by the same method in the same steps, in double, so that the
// result shows the truncation error at options.tolerance, not rounding. Ignores `precision` and `steps`. Returns 0
// where the motion is known in closed form, and NaN where v has no derivative on the path line. Accuracy: about 1e-13 a
// step. Throws InvalidInput where advect does, and for a custom motion or region, whose derivatives are unknown;
// Cancelled.
std::vector<double> volume_drifts(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

// Moves the points along their path lines, and returns their Jacobians as jacobians() does, but also keeps the error of
// each over one segment below `jacobian_tolerance`, above 0. Throws as jacobians().
std::vector<Mat3d> move_with_jacobians(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options,
                                       double jacobian_tolerance);

}  // namespace knead

namespace knead::detail {

// Throws InvalidInput: a path line needs over kStepLimit steps.
[[noreturn]] void refuse_path_line();

// The requested result. The determinant of a motion in closed form is 1.
struct WantedJacobian {
  bool is_determinant = false;
  double jacobian_tolerance = 0;  // of the Jacobian over one segment; 0: the error of the points alone counts
};

// v and its gradient, by rows.
struct Slope {
  Vec3d velocity{};
  Mat3d gradient{{}, {}, {}};
};

// Path lines through one segment that is no curve, with their Jacobians and their derivatives with respect to up to
// kTangents variables. Ignores the limit cylinders of parts.
class SegmentJacobians {
 public:
  // The segment, the options and the rates must outlive it. Throws InvalidInput for a custom motion or region.
  SegmentJacobians(const Segment& segment, const AdvectOptions& options, WantedJacobian wanted,
                   const SegmentRates& rates = {});
  SegmentJacobians(const SegmentJacobians&) = delete;
  SegmentJacobians& operator=(const SegmentJacobians&) = delete;
  ~SegmentJacobians() = default;

  // Returns v, 0 where a mask holds.
  Vec3d velocity_at(const Vec3d& x, double t) const;

  // Returns the time at which the integration of the path line starts. Nothing if x rests, or has been moved in closed
  // form: then sets x, and multiplies its Jacobian.
  std::optional<double> meet(Vec3d& x, Mat3d& jacobian) const;

  // Moves points that have met the segment, multiplies their Jacobians, and sets variables() tangents for each to its
  // derivatives with respect to the numbers other than begin and end. Throws InvalidInput if a path line needs over
  // kStepLimit steps.
  void move(std::span<const JacobianStart> starts, std::span<Vec3d> points, std::span<Mat3d> jacobians,
            std::span<Vec3d> tangents = {}) const;

  // Takes points of a segment with a grid, all from its beginning to its end, with the gradients of functions of them,
  // and adds the integral of -g dv/dcoefficient to three planes of numbers in the order of GridView, or to six if the
  // coefficients change: the segment is the inverse of the one whose gradients are wanted. Throws as move(); Cancelled.
  void carry_back(std::span<Vec3d> points, std::span<Vec3d> gradients, std::span<double> planes) const;

  // Returns the number of variables whose rates were given.
  std::size_t variables() const { return variables_; }
  // Adds the effects of a change of the segment's begin and end to the tangents of one point that it has moved.
  void add_shifts(const Vec3d& from, const Vec3d& to, const Mat3d& jacobian, std::span<Vec3d> tangents) const;

 private:
  SegmentJacobians(const Segment& segment, SegmentMask mask, const AdvectOptions& options, WantedJacobian wanted);

  void take(const SegmentRates& rates);
  void bind_rated();
  bool is_outside_limit_cylinder(const Vec3d& x) const;
  std::optional<Vec3d> known_displacement(const Vec3d& x) const;
  Mat3d known_gradient(const Vec3d& displacement) const;
  Slope slope_of_parts(const Vec3d& x, double t) const;
  Slope slope_in_planes(const Vec3d& x, double t) const;
  Slope slope_at(const Vec3d& x, double t) const;
  void append_kinks(const Vec3d& x, double t, std::vector<Kinks>& to) const;
  template <std::size_t n>
  void find_gradients_of_lane(const JacobianBundle<n>& places, double t, std::size_t lane,
                              JacobianBundle<n>& slopes) const;
  template <std::size_t n>
  void limit_steps(JacobianTask<n>& task) const;
  template <std::size_t n>
  JacobianTask<n> task_of_kernel() const;
  template <std::size_t n>
  void move_with(const JacobianKernels<n>& kernels, std::span<const JacobianStart> starts, std::span<Vec3d> points,
                 std::span<Mat3d> jacobians, std::span<Vec3d> tangents) const;

  const Segment& segment_;
  const AdvectOptions& options_;
  WantedJacobian wanted_;
  SegmentMask mask_;
  const KernelTable& kernels_;
  BoundGradients<0> bound_;  // null if no kernel evaluates the fields
  Method<double> method_;
  SegmentTask<double> task_;
  bool stops_at_kinks_ = false;
  std::vector<PinPiece> pieces_;                    // of pins
  std::unique_ptr<const GridNodes<double>> nodes_;  // of a grid
  std::vector<Segment> own_parts_;                  // of a sum
  std::vector<std::unique_ptr<const SegmentJacobians>> parts_;
  // Of variables.
  std::size_t variables_ = 0;
  std::array<Varying, 2> ends_;
  std::array<double, kTangents> rounding_{};  // of tangents: their error where they cancel, as at a pin
  bool varies_in_space_ = false;              // another number than begin and end varies
  std::vector<std::unique_ptr<const PartOfSegment>> rated_parts_;
  std::vector<VaryingFields<Varying>> rated_;
  BoundGradients<1> rated_by_one_;
  BoundGradients<kTangents> rated_by_several_;
};

}  // namespace knead::detail
