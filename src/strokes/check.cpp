// Checks of a stroke's numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "knead/error.h"
#include "knead/field.h"
#include "strokes/describe.h"

namespace knead::detail {

namespace {

void require(bool good, std::string_view key, const std::string& expected, double got) {
  if (!good) throw InvalidInput(fmt::format("\"{}\" must be {}, got {}", key, expected, got));
}

}  // namespace

void require_finite(std::string_view key, double value) {
  require(std::isfinite(value), key, "a finite number", value);
}

void require_finite(std::string_view key, const Vec3d& value) {
  if (is_finite(value)) return;
  throw InvalidInput(
      fmt::format("\"{}\" must be three finite numbers, got [{}, {}, {}]", key, value.x, value.y, value.z));
}

void require_finite(std::string_view key, const std::vector<Vec3d>& values) {
  for (const Vec3d& value : values) require_finite(key, value);
}

void require_positive(std::string_view key, double value) {
  require(std::isfinite(value) && value > 0, key, "a number greater than 0", value);
}

void require_factor(std::string_view key, double value) {
  require(value >= 1e-6 && value <= 1e6, key, "a number greater than 0, from 1e-6 to 1e6", value);
}

void require_direction(std::string_view key, const Vec3d& value) {
  require_finite(key, value);
  if (value == Vec3d{0, 0, 0}) {
    throw InvalidInput(fmt::format("\"{}\" must be a vector of any length but 0, got [0, 0, 0]", key));
  }
}

void require_angle(std::string_view key, double degrees) {
  require(std::abs(degrees) <= kMaxDegrees, key, "a number of degrees from -360000 to 360000", degrees);
}

void require_count(std::string_view key, std::size_t count, std::size_t least, std::string_view what) {
  if (count >= least) return;
  throw InvalidInput(fmt::format("\"{}\" must hold {} or more {}, got {}", key, least, what, count));
}

void require_falloff(std::string_view key, int value) {
  if (value >= kMinFalloff && value <= kGreatestFalloff) return;
  throw InvalidInput(
      fmt::format("\"{}\" must be a whole number from {} to {}, got {}", key, kMinFalloff, kGreatestFalloff, value));
}

void require_even(std::string_view key, int value, int least) {
  if (value >= least && value % 2 == 0) return;
  throw InvalidInput(fmt::format("\"{}\" must be an even number, {} or more, got {}", key, least, value));
}

void require_thresholds(double inner, double outer) {
  require_finite("inner", inner);
  require_finite("outer", outer);
  require(inner < outer, "outer", fmt::format("a number greater than \"inner\" ({})", inner), outer);
}

void require_distance_thresholds(double inner, double outer) {
  require_positive("outer", outer);
  require(std::isfinite(inner) && inner >= 0, "inner", "a number that is 0 or greater", inner);
  require_thresholds(inner, outer);
}

void require_wide_thresholds(const Thresholds<double>& thresholds) {
  constexpr double kMaxCore = 0.8;
  const auto& [inner, outer, falloff, bump] = thresholds;
  require_positive("bump", bump);
  require(std::isfinite(outer) && outer > bump, "outer", fmt::format("a number greater than \"bump\" ({})", bump),
          outer);
  const double core = inner / bump;
  require(core >= 0 && core <= kMaxCore * (1 + 1e-12), "core", fmt::format("a number from 0 to {}", kMaxCore), core);
}

Vec3d unit(const Vec3d& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  return normalized(v / largest);
}

}  // namespace knead::detail
