// How far a point set's sum may be off where it is taken from lists or trees of its points. Internal to the flow room
// and those who move points as it does.
#pragma once

#include <algorithm>

#include "knead/field/blend.h"

namespace knead::detail {

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
