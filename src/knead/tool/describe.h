// How a tool describes itself. Internal to the tool room.
#pragma once

#include <string>
#include <vector>

#include "knead/tool/check.h"
#include "knead/tool/tool.h"

namespace knead::tool_detail {

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
Segment carried_segment(Field field, const Vec3d& displacement, TimeLaw time_law = TimeLaw::swept);

// Returns a segment with one field that rests.
Segment resting_segment(Field field);

// Warns of a strong flow back beside the tool, which a thin intermediate region causes (inner / outer above 0.9).
void warn_of_thin_shell(const Thresholds<double>& thresholds, Warnings& warnings);

// Returns the thresholds of a bend, which its width may stand for.
Thresholds<double> bend_thresholds(const BendStroke& stroke);

// Moves the centre of a bend for another falloff, as set_falloff says.
void move_center(BendStroke& stroke, int falloff);

}  // namespace knead::tool_detail
