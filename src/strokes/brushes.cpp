// The brushes of a sculptor: which strokes they make.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "strokes/describe.h"

namespace knead {

namespace {

constexpr std::array<Brush, 6> kBrushes{{{.name = "move", .pulls = true},
                                         {.name = "snakehook", .pulls = true, .taper = 0.9},
                                         {.name = "paint", .amount = 0.15},
                                         {.name = "crease", .pinch = 1, .sink = 0.3, .amount = 0.7},
                                         {.name = "pinch", .pinch = 1, .amount = 0.7},
                                         {.name = "flatten", .pinch = -1, .amount = 0.7}}};

}  // namespace

const Brush& brush_named(std::string_view name) {
  const auto* const found =
      std::find_if(kBrushes.begin(), kBrushes.end(), [&](const Brush& b) { return b.name == name; });
  if (found != kBrushes.end()) return *found;
  std::array<std::string_view, kBrushes.size()> names;
  std::transform(kBrushes.begin(), kBrushes.end(), names.begin(), [](const Brush& brush) { return brush.name; });
  throw InvalidInput(fmt::format("there is no brush \"{}\"; there are {}", name, fmt::join(names, ", ")));
}

Stroke stroke_of(const Brush& brush, double radius, double amount) {
  if (brush.pulls) {
    ImplicitStroke pull;
    pull.falloff = kWideFalloff;
    pull.bump = radius;
    pull.taper = brush.taper;
    return pull;
  }
  PaintStroke paint;
  paint.falloff = kWideFalloff;
  paint.bump = radius;
  if (brush.pinch == 0) {
    paint.depth = -amount * radius;
    return paint;
  }
  paint.depth = brush.sink * amount * radius;
  paint.pinch = brush.pinch * (brush.sink == 0 ? amount : std::abs(amount));
  return paint;
}

}  // namespace knead
