// Checks of a stroke's numbers. Every failure is an InvalidInput whose message begins with
// the key in quotes and says what was expected and what was got.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knead/tools.h"
#include "knead/vec.h"

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

inline constexpr double kMaxDegrees = 360000;

// A number of degrees whose sine the evaluation can take: at most 360,000 either way.
void require_angle(std::string_view key, double degrees);

void require_count(std::string_view key, std::size_t count, std::size_t least, std::string_view what);

// A whole number from 3 to 7 (knead/field.h).
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

// Of the flow that returns past a set to the tool's speed; more is warned of. For a set of radius R it is R / (2
// outer), or R / (2 gap) between two sets (method, section 2).
inline constexpr double kStrongReturn = 4;

inline constexpr double kRadiansPerDegree = 0.017453292519943295769;

// How a tool describes itself.

using Warnings = std::vector<std::string>;
using HasKey = std::function<bool(std::string_view)>;

// A tool whose strokes blend: S has the member `falloff`.
template <class S>
inline constexpr bool kBlends = requires(S stroke) {
  stroke.falloff;
};

// The functions of a tool with strokes S. Those that are null have nothing to do: a tool without `flow` always reads
// the surface. Without `prolong` the angles of a stroke are multiplied; a tool without angles cannot go on.
template <class S>
struct ToolFunctions {
  std::vector<StrokeKey> (*keys)(S&);
  void (*validate)(const S&) = nullptr;
  Flow (*flow)(const S&) = nullptr;
  void (*warn)(const S&, Warnings&) = nullptr;
  bool (*reads_surface)(const S&) = nullptr;
  void (*prepare)(S&, const HasKey&) = nullptr;
  void (*prolong)(S&, double strength) = nullptr;
};

template <class S>
Tool describe(std::string_view name, const ToolFunctions<S>& functions) {
  Tool tool;
  tool.name = name;
  tool.start = S{};
  tool.keys = [=](Stroke& stroke) {
    S& own = std::get<S>(stroke);
    std::vector<StrokeKey> keys = functions.keys(own);
    if constexpr (kBlends<S>) keys.push_back({"falloff", Quantity::falloff, &own.falloff, Presence::optional});
    return keys;
  };
  tool.prepare = [=](Stroke& stroke, const HasKey& has) {
    if (functions.prepare != nullptr) functions.prepare(std::get<S>(stroke), has);
  };
  tool.validate = [=](const Stroke& stroke) {
    if (functions.validate != nullptr) functions.validate(std::get<S>(stroke));
  };
  tool.reads_surface = [=](const Stroke& stroke) {
    return functions.reads_surface != nullptr ? functions.reads_surface(std::get<S>(stroke))
                                              : functions.flow == nullptr;
  };
  tool.flow = [=](const Stroke& stroke) { return functions.flow(std::get<S>(stroke)); };
  tool.warn = [=](const Stroke& stroke, Warnings& warnings) {
    if (functions.warn != nullptr) functions.warn(std::get<S>(stroke), warnings);
  };
  if (functions.prolong != nullptr) {
    tool.prolong = [=](Stroke& stroke, double strength) { functions.prolong(std::get<S>(stroke), strength); };
  }
  return tool;
}

// Returns a choice among the values of an enumeration, which the words name in order.
template <class E>
Choice choice(E& value, std::vector<std::string_view> words) {
  return {std::move(words), static_cast<std::size_t>(value), [&value](std::size_t i) { value = static_cast<E>(i); }};
}

// Makes a path so many times as long, in its last direction. A path of length 0 stays.
void prolong_path(std::vector<Vec3d>& path, double strength);

// Returns a segment with one field that is carried along with its displacement.
Segment transported_segment(Field field, const Vec3d& displacement, TimeLaw time_law = TimeLaw::swept);

// Returns a segment with one field that rests.
Segment resting_segment(Field field);

// Warns of a strong flow back beside the tool, which a thin intermediate region causes (inner / outer above 0.9).
void warn_of_thin_shell(const Thresholds<double>& thresholds, Warnings& warnings);

// Returns the thresholds of a bend, which its width may stand for.
Thresholds<double> bend_thresholds(const BendStroke& stroke);

// Moves the centre of a bend for another falloff, as set_falloff says.
void move_center(BendStroke& stroke, int falloff);

}  // namespace knead::tool_detail
