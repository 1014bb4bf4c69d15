// The rule by which path lines choose their steps, and its constants, for CPU and GPU; and the errors that the sums of
// point sets may have. Internal to the library.
//
// Errors are those of a slope (an error of position per unit of time), in units of the allowed error; lengths that a
// step passes are in units of the longest step. Most numbers are squares, which saves packs the roots.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// The allowed error of a slope, as a part of the tolerance. The estimate sees the error of each step but not its growth
// along the rest of the flow, and is too small where v is not smooth (at the inner threshold, and on the planes through
// a capsule's ends). Measured: docs/decisions/0005-step-control.md.
inline constexpr double kErrorShare = 0.02;

// The part of the intermediate region's width that a step may pass (method, section 3, "A grazing tool is missed"):
// with 0.16 a segment and the same segment cut into 50 differ by at most 2 tolerances. The gradient of a capsule's v
// jumps on the planes through its ends, which the estimate misses where only a step's last stages are beyond one.
// Between handles v is nowhere 0 over a length, so the estimate misses nothing.
inline constexpr double kReach = 0.16;
inline constexpr double kCapsuleReach = 0.06;
inline constexpr double kHandlesReach = 0.3;

// The part of a potential grid's spacing that a step may pass: the second derivatives of v jump between cells, which
// the estimate misses where only a step's last stages are beyond (docs/decisions/0028-grid-potentials.md).
inline constexpr double kGridReach = 0.25;

// The part of the width of a mask's border that a step may pass: two cells of its spline. From farther away a step may
// go up to the border.
inline constexpr double kMaskReach = 0.25;

// Steps are never shorter than this part of the longest, or of the segment: there the estimate is rounding error, which
// shorter steps do not reduce (docs/decisions/0005-step-control.md).
template <class S>
inline constexpr double kShortestPart = std::numeric_limits<S>::digits == 24 ? 1.0 / 16 : 1e-7;

// The rounding of a slope, in units of its last place, which the estimate never counts as an error.
inline constexpr double kRoundingOfSlope = 8;

// The integration of a path line stops after this number of steps.
inline constexpr int kStepLimit = 1'000'000;

// Where derivatives are followed, a step ends just before a place where the second derivatives of v jump, after this
// part of the way to it, and one of kMaxStepOverKink crosses it (docs/decisions/0037-derivatives.md).
inline constexpr double kPartBeforeKink = 0.98;
inline constexpr double kMaxStepOverKink = 1e-6;

// In a blended segment one of the two fields has no weight at t = 0, the other at t = 1, so that no stage near there
// sees it: a step is at most this part of the time to the nearer end, but may always be kMinBlendedStep.
inline constexpr double kBlendedShare = 0.5;
inline constexpr double kMinBlendedStep = 1.0 / 32;

// The next step aims at kStepMargin^order of the allowed error, and differs from the last one by at most these factors
// (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, section II.4).
inline constexpr double kStepMargin = 0.9;
inline constexpr double kMinStepFactor = 0.2;
inline constexpr double kMaxStepFactor = 5;
inline constexpr double kMinError2 = 1e-8;  // squared; smaller errors do not make the step grow more
inline constexpr double kMinSpeed = std::numeric_limits<float>::min();  // as a divisor

// A whole segment is first tried as one step of second order (Heun), then of third (Shu and Osher 1988). The error of
// each is estimated as that of the next lower order times the length of the segment in longest steps: up to 1 for the
// third order, up to 1/16 for the second, whose estimate is coarser.
inline constexpr double kSecondOrderReach = 1.0 / 16;
inline constexpr double kThirdOrderReach = 1;
// The error of the third order is at most this part of that estimate: in random segments of every kind a tenth does not
// change the worst error; with a fifth the bend of knead bench errs by 0.36 of the tolerance (docs/decisions/0010).
inline constexpr double kThirdOrderShare = 0.2;
// The error of the third order that is expected from the first slope alone: this part of the speed, times the third
// power of the part of the intermediate region's width that the step passes. And the ratio of that error to the second
// order's error times the same part. Both were measured in the scenes of knead bench: with smaller numbers more
// attempts fail, with greater ones attempts that would succeed are omitted.
inline constexpr double kExpectedThirdOrderError = 0.01;
inline constexpr double kExpectedThirdOrderGain = 0.1;
// If the expected error is below this part of the allowed error, and the step is too long for the second order, the
// third is evaluated without judging the second. Does not change results.
inline constexpr double kCertainThirdOrderError = 0.1;

struct StepConstant {
  const char* name;
  double value;
};

// The constants that shaders use.
inline constexpr std::array<StepConstant, 13> kStepConstants{{{"kHandlesReach", kHandlesReach},
                                                              {"kRoundingOfSlope", kRoundingOfSlope},
                                                              {"kBlendedShare", kBlendedShare},
                                                              {"kMinBlendedStep", kMinBlendedStep},
                                                              {"kStepMargin", kStepMargin},
                                                              {"kMinStepFactor", kMinStepFactor},
                                                              {"kMaxStepFactor", kMaxStepFactor},
                                                              {"kMinError2", kMinError2},
                                                              {"kMinSpeed", kMinSpeed},
                                                              {"kSecondOrderReach", kSecondOrderReach},
                                                              {"kThirdOrderReach", kThirdOrderReach},
                                                              {"kThirdOrderShare", kThirdOrderShare},
                                                              {"kExpectedThirdOrderGain", kExpectedThirdOrderGain}}};

// The functions are written once, in the common subset of C++ and GLSL. In C++ they are templates over R, a number or a
// pack. kStepRuleText is the same text for shaders, which define R, minimum, maximum, the constants, and an empty
// STEP_RULE.
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
// Returns the longest step that misses nothing: neither the point nor the region passes the other by more than reach.
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

// Returns the squared error of a step whose estimate is that of the next lower order: the estimate times the ratio of the
// step to the longest.
STEP_RULE R extrapolated_error2(R error2, R h, R shortest, R shortest_part) {
  R part = h * shortest_part / shortest;
  return error2 * part * part;
}

// Returns the factor of the next step after an error. The error per unit of time is proportional to the error_order-th
// power of the step, whose root is taken by square roots only: the same bits everywhere.
STEP_RULE R step_factor(R error2, int error_order) {
  R root = sqrt(sqrt(R(1) / maximum(error2, R(kMinError2))));
  if (error_order != 2) root = sqrt(root);
  return minimum(maximum(root * R(kStepMargin), R(kMinStepFactor)), R(kMaxStepFactor));
}

// Returns the expected squared error of the third order. scale2: the square of kExpectedThirdOrderError times the third
// power of the part of the width that a longest step passes, in units of the allowed error.
STEP_RULE R expected_third_order_error2(R part2, R speed2, R scale2) {
  return part2 * part2 * part2 * speed2 * scale2;
}

// These return at most 1 if the second order is accurate enough, if the third is, and if the third is worth an
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

// The part of a path line's tolerance that the sums of a point set's lists and trees may use up.
inline constexpr double kSumsShareOfTolerance = 0.5;

// Upper bounds of |w'| (outer - inner) and |w''| (outer - inner)^2 beyond s. For the default falloff
// w' = -24 s^2 (1-s)^3 (1 + 2s + 3s^2); the others have one bound for all s.
inline double greatest_slope(double s, int falloff) {
  if (falloff != kDefaultFalloff) return falloff_facts(falloff).slope;
  return std::min(2.1, 144 * (1 - s) * (1 - s) * (1 - s));
}
inline double greatest_curvature(double s, int falloff) {
  if (falloff != kDefaultFalloff) return falloff_facts(falloff).curvature;
  return std::min(7.0, 432 * (1 - s) * (1 - s));
}

// Places within `arm` of the field's centre where least <= r <= most.
struct SumPlaces {
  Thresholds<double> thresholds;
  int exponent = 8;
  double least = 0;
  double most = 0;
  double arm = 0;
};

// Returns the allowed relative error of the sum at these places, so that v = w u + w' grad r x A errs by at most
// `error` times the tool's speed: r changes by 1/m of the sum's error, and grad r by all of it. Between 2 epsilon and
// 0.1.
inline double sum_error_allowed(const SumPlaces& at, double error, double epsilon) {
  constexpr double greatest = 0.1;
  const auto& [inner, outer, falloff, bump] = at.thresholds;
  const double width = outer - inner;
  const double s = std::clamp((at.least - inner) / width, 0.0, 1.0);
  const double slope = greatest_slope(s, falloff) / width;
  const double of_r = at.most / at.exponent;
  const double gain = slope * of_r + 0.5 * at.arm * (greatest_curvature(s, falloff) / (width * width) * of_r + slope);
  return std::clamp(error / gain, 2 * epsilon, greatest);
}

}  // namespace knead::detail
