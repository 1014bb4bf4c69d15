// One path line with its derivatives along up to kTangents directions: the step control that both ways of finding
// derivatives share. Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "flow/tangents.h"
#include "flow/varying_fields.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// A place and its derivatives.
using TangentState = std::array<Vec3d, 1 + kTangents>;

// An accepted step: dx = h v, from the time t on. `h` is below 0 backwards in time.
struct TangentStep {
  double t = 0;
  double h = 0;
  std::array<Vec3d, Tableau::kMaxStages> places;  // at which the stages evaluate v
};

// The numbers of a segment whose begin and end come first.
inline constexpr std::size_t kBeginAndEnd = 2;

// Follows path lines through one segment that is no curve.
class TangentLine {
 public:
  // Keeps the segment and the options. Throws as advect_tangents.
  TangentLine(const Segment& segment, const SegmentRates& rates, const TangentOptions& options);

  // Lets the coefficients of a segment with a grid vary with the first variable. `rates` must outlive it.
  void vary_grid(const GridNodes<double>* rates) {
    fields_.front().vary_grid(rates);
    varies_grid_ = true;
  }

  // Moves a place, and appends its steps if requested. Returns the parts that move it, as bits: 0 if none does.
  unsigned move(TangentState& state, std::vector<TangentStep>* steps = nullptr) const;

  // Returns v of some parts.
  Vec3d velocity(const Vec3d& x, double t, unsigned chosen) const { return slope({x}, t, chosen)[0]; }

  // The parts of the segment.
  const std::vector<std::unique_ptr<const PartOfSegment>>& parts() const { return parts_; }

 private:
  void shift(TangentState& state, const Varying& end, double t, double sign, unsigned chosen) const;
  TangentState slope(const TangentState& state, double t, unsigned chosen) const;
  double excess(const TangentState& state, const TangentState& first, const TangentState& error) const;
  void find_kinks(const Vec3d& x, double t, unsigned chosen, std::vector<Kinks>& kinks) const;
  double longest_step(const TangentState& state, const TangentState& first) const;
  void integrate(TangentState& state, double t, double end, unsigned chosen, std::vector<TangentStep>* steps) const;

  const Segment& segment_;
  TangentOptions options_;
  std::vector<Segment> segments_;  // the parts
  std::vector<std::unique_ptr<const PartOfSegment>> parts_;
  std::vector<VaryingFields<Varying>> fields_;  // of the parts
  std::array<Varying, kBeginAndEnd> ends_;
  std::array<double, kTangents> rounding_{};  // of derivatives: their error where they cancel, as at a pin
  bool varies_grid_ = false;
  double reach_ = kInfinity;  // of a step
  double tool_speed_ = 0;
  double turning_ = 0;
  Vec3d turning_center_;
};

}  // namespace knead::detail
