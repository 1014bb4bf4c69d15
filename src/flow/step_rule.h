// The rule by which path lines choose their steps, and its constants: the only place of both. internal
// and to those who move points as it does.
//
// Errors are of a slope (an error of position per unit of time) and in units of what the tolerance allows; lengths that
// a step passes are in units of the longest step. Most numbers are given as squares, which spares packs the roots.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// The error of a slope that is allowed, as a part of the tolerance. The estimate sees the error of each step, not how
// the rest of the flow magnifies it, and is too small where v is not smooth (at the inner threshold, and on the planes
// through a capsule's ends). Measured: docs/decisions/0005-step-control.md.
inline constexpr double kErrorShare = 0.02;

// How much of the intermediate region's width a step may pass (method, section 3, "A grazing tool is missed"): with
// 0.16 a segment and the same segment cut into 50 differ by 2 tolerances at most. The gradient of a capsule's v jumps
// on the planes through its ends, which the estimate misses where a step's last stages alone are beyond one. Between
// handles v is nowhere 0 over a length, so nothing is out of the estimate's sight.
inline constexpr double kReach = 0.16;
inline constexpr double kCapsuleReach = 0.06;
inline constexpr double kHandlesReach = 0.3;

// How much of the spacing of a potential grid a step may pass: the second derivatives of v jump between cells, which
// the estimate misses where a step's last stages alone are beyond (docs/decisions/0028-grid-potentials.md).
inline constexpr double kGridReach = 0.25;

// How much of the width of a mask's border a step may pass: two cells of its spline. From a place that is farther from
// the border a step may go up to the border.
inline constexpr double kMaskReach = 0.25;

// Steps are never shorter than this part of the longest, or of the segment: there the estimate is rounding, which no
// step size mends (docs/decisions/0005-step-control.md).
template <class S>
inline constexpr double kShortestPart = std::numeric_limits<S>::digits == 24 ? 1.0 / 16 : 1e-7;

// Rounding of a slope, in units of its last place, that is never taken for an error.
inline constexpr double kRoundingOfSlope = 8;

// A path line with so many steps is given up.
inline constexpr int kStepLimit = 1'000'000;

// In a blended segment one of the two fields has no weight at t = 0, the other at t = 1, so that no stage near there
// sees it: a step is at most this part of the time to the nearer end, but never has to be below the least one.
inline constexpr double kBlendedShare = 0.5;
inline constexpr double kMinBlendedStep = 1.0 / 32;

// The next step is chosen for an error of kStepMargin^order of what is allowed, and differs from the last one by at
// most these factors (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, section II.4).
inline constexpr double kStepMargin = 0.9;
inline constexpr double kMinStepFactor = 0.2;
inline constexpr double kGreatestStepFactor = 5;
inline constexpr double kMinError2 = 1e-8;  // squared; no smaller one makes the step grow more
inline constexpr double kMinSpeed = std::numeric_limits<float>::min();  // divided by

// A whole segment is first tried as one step of second order (Heun), then of third (Shu and Osher 1988). The error of
// each is taken as that of the next lower order, times the part of the longest step that the segment is: up to the
// whole of that step for the third order, up to 1/16 of it for the second, whose error estimate is the coarser.
inline constexpr double kSecondOrderReach = 1.0 / 16;
inline constexpr double kThirdOrderReach = 1;
// The error of the third order is this part of that estimate at most: in random segments of every kind a tenth changes
// no worst error; with a fifth knead bench's bend errs by 0.36 of the tolerance (docs/decisions/0010).
inline constexpr double kThirdOrderShare = 0.2;
// The error of the third order that is to be expected before anything but the first slope is known: this part of the
// speed, times the third power of the part of the intermediate region's width that is passed. And how much smaller than
// the second order's error, times the same part, it is to be expected. Both measured in knead bench's scenes: smaller
// numbers make more attempts fail, greater ones leave out attempts that would succeed.
inline constexpr double kExpectedThirdOrderError = 0.01;
inline constexpr double kExpectedThirdOrderGain = 0.1;
// Where the expected error is below this part of what is allowed, and the second order is out of reach, the third is
// evaluated without a look at the second's. Changes no result.
inline constexpr double kCertainThirdOrderError = 0.1;

struct StepConstant {
  const char* name;
  double value;
};

// The constants that shaders use, in these functions and around them.
inline constexpr std::array<StepConstant, 13> kStepConstants{{{"kHandlesReach", kHandlesReach},
                                                              {"kRoundingOfSlope", kRoundingOfSlope},
                                                              {"kBlendedShare", kBlendedShare},
                                                              {"kMinBlendedStep", kMinBlendedStep},
                                                              {"kStepMargin", kStepMargin},
                                                              {"kMinStepFactor", kMinStepFactor},
                                                              {"kGreatestStepFactor", kGreatestStepFactor},
                                                              {"kMinError2", kMinError2},
                                                              {"kMinSpeed", kMinSpeed},
                                                              {"kSecondOrderReach", kSecondOrderReach},
                                                              {"kThirdOrderReach", kThirdOrderReach},
                                                              {"kThirdOrderShare", kThirdOrderShare},
                                                              {"kExpectedThirdOrderGain", kExpectedThirdOrderGain}}};

// The functions are written once, in what C++ and GLSL have in common: here they are templates over R, a number or a
// pack; kStepRuleText is the same text for shaders, which define R, minimum, maximum, the constants, and STEP_RULE as
// nothing.
namespace step_rule {

using std::sqrt;

#define STEP_RULE    \
  template <class R> \
  [[gnu::always_inline]] inline
#define KNEAD_AS_CODE_AND_TEXT(...) \
  __VA_ARGS__                       \
  inline constexpr const char* kStepRuleText = #__VA_ARGS__;

// clang-format off
KNEAD_AS_CODE_AND_TEXT(
// Returns the longest step that jumps over nothing: neither the point nor the region passes the other by more than reach.
STEP_RULE R longest_step(R speed, R reach) {
  return reach / maximum(speed, R(kMinSpeed));
}

STEP_RULE R longest_blended_step(R t) {
  return maximum(R(kBlendedShare) * minimum(t, R(1) - t), R(kMinBlendedStep));
}

STEP_RULE R shortest_step(R longest, R shortest_part) {
  return minimum(longest, R(1)) * shortest_part;
}

STEP_RULE R chosen_step(R trial, R shortest, R longest, R remaining) {
  return minimum(minimum(maximum(trial, shortest), longest), remaining);
}

// Returns the squared error of a step whose estimate is that of the next lower order: the estimate times the part that
// the step is of the longest.
STEP_RULE R extrapolated_error2(R error2, R h, R shortest, R shortest_part) {
  R part = h * shortest_part / shortest;
  return error2 * part * part;
}

// Returns by what the step is multiplied after an error. The error per unit of time falls with the step's error_order-th
// power, whose root is taken by square roots only: results are the same bits everywhere.
STEP_RULE R step_factor(R error2, int error_order) {
  R root = sqrt(sqrt(R(1) / maximum(error2, R(kMinError2))));
  if (error_order != 2) root = sqrt(root);
  return minimum(maximum(root * R(kStepMargin), R(kMinStepFactor)), R(kGreatestStepFactor));
}

// Returns the squared error to be expected of the third order: scale2 is the square of kExpectedThirdOrderError times the
// third power of the part of the width that a longest step passes, in units of the error allowed.
STEP_RULE R expected_third_order_error2(R part2, R speed2, R scale2) {
  return part2 * part2 * part2 * speed2 * scale2;
}

// These return at most 1 where the second order is accurate enough, where the third is, and where the third is worth an
// evaluation. change2: of the slope from the next lower order.
STEP_RULE R second_order_excess(R change2, R part2) {
  return maximum(change2 * part2, part2 * R(1 / (kSecondOrderReach * kSecondOrderReach)));
}

STEP_RULE R third_order_excess(R change2, R part2) {
  return change2 * part2 * R(kThirdOrderShare * kThirdOrderShare);
}

STEP_RULE R third_order_outlook(R change2, R part2) {
  return maximum(third_order_excess(change2, part2) * part2 * R(kExpectedThirdOrderGain * kExpectedThirdOrderGain),
                 part2 * R(1 / (kThirdOrderReach * kThirdOrderReach)));
}

)
// clang-format on

#undef KNEAD_AS_CODE_AND_TEXT
#undef STEP_RULE

}  // namespace step_rule

// How far a point set's sum may be off where it is taken from lists or trees of its points. internal
// and those who move points as it does.

// How much of the tolerance of a path line such sums may use up.
inline constexpr double kSumsShareOfTolerance = 0.5;

// w' and w'', by (outer - inner) and its square, are at most so much from s on. For the default falloff
// w' = -24 s^2 (1-s)^3 (1 + 2s + 3s^2); the others have one bound for all s.
inline double greatest_slope(double s, int falloff) {
  if (falloff != kDefaultFalloff) return falloff_facts(falloff).slope;
  return std::min(2.1, 144 * (1 - s) * (1 - s) * (1 - s));
}
inline double greatest_curvature(double s, int falloff) {
  if (falloff != kDefaultFalloff) return falloff_facts(falloff).curvature;
  return std::min(7.0, 432 * (1 - s) * (1 - s));
}

// Places at most `arm` from the field's centre where least <= r <= most.
struct SumPlaces {
  Thresholds<double> thresholds;
  int exponent = 8;
  double least = 0;
  double most = 0;
  double arm = 0;
};

// The relative error of the sum that is allowed there so that v errs by at most `error` times the tool's speed: it
// changes r by 1/m of it, and grad r by all of it, in w u + w' grad r x A. At least twice `epsilon`, at most 0.1.
inline double sum_error_allowed(const SumPlaces& at, double error, double epsilon) {
  constexpr double greatest = 0.1;
  const auto& [inner, outer, falloff] = at.thresholds;
  const double width = outer - inner;
  const double s = std::clamp((at.least - inner) / width, 0.0, 1.0);
  const double slope = greatest_slope(s, falloff) / width;
  const double of_r = at.most / at.exponent;
  const double gain = slope * of_r + 0.5 * at.arm * (greatest_curvature(s, falloff) / (width * width) * of_r + slope);
  return std::clamp(error / gain, 2 * epsilon, greatest);
}

}  // namespace knead::detail
