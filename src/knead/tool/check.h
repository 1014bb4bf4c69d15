// Checks of a stroke's numbers. Internal to the tool room. Every failure is an InvalidInput whose message begins with
// the key in quotes and says what was expected and what was got.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "knead/math/vec3.h"

namespace knead::tool_detail {

void require_finite(std::string_view key, double value);
void require_finite(std::string_view key, const Vec3d& value);
void require_finite(std::string_view key, const std::vector<Vec3d>& values);

// Finite and greater than 0.
void require_positive(std::string_view key, double value);

// A factor from 1e-6 to 1e6: beyond that nothing is left of a shape, and path lines take for ever.
void require_factor(std::string_view key, double value);

// Finite, and not the zero vector.
void require_direction(std::string_view key, const Vec3d& value);

inline constexpr double kMostDegrees = 360000;

// A number of degrees whose sine the evaluation can take: at most 360,000 either way.
void require_angle(std::string_view key, double degrees);

void require_count(std::string_view key, std::size_t count, std::size_t least, std::string_view what);

// A whole number from 3 to 7 (field/blend.h).
void require_falloff(std::string_view key, int value);

// An even number, `least` or more.
void require_even(std::string_view key, int value, int least);

// Both finite, inner < outer.
void require_thresholds(double inner, double outer);

// For a region whose r is a distance: outer > 0 and 0 <= inner < outer. (A negative inner would leave a cone at r = 0.)
void require_distance_thresholds(double inner, double outer);

// v / |v| for any finite v but zero, also where |v|^2 overflows or underflows.
Vec3d unit(const Vec3d& v);

// What Studio says about the thresholds of most tools.
inline constexpr std::string_view kInnerHelp = "everything nearer moves rigidly with the tool";
inline constexpr std::string_view kOuterHelp = "everything farther stays";

inline constexpr double kRadiansPerDegree = 0.017453292519943295769;

}  // namespace knead::tool_detail
