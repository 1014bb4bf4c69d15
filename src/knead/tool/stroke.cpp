#include "knead/tool/stroke.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "knead/tool/tools.h"

namespace knead {

std::string tool_name(const Stroke& stroke) {
  constexpr std::array<const char*, std::variant_size_v<Stroke>> kNames{"implicit", "paint", "points", "rotate",
                                                                        "stretch",  "twist", "bend"};
  return kNames[stroke.index()];
}

void validate(const Stroke& stroke) {
  std::visit([](const auto& tool) { tool_detail::validate(tool); }, stroke);
}

Flow flow_of(const Stroke& stroke) {
  validate(stroke);
  return std::visit([](const auto& tool) { return tool_detail::flow_of(tool); }, stroke);
}

std::vector<std::string> warnings(const Stroke& stroke) {
  std::vector<std::string> result;
  std::visit([&](const auto& tool) { tool_detail::warn(tool, result); }, stroke);
  return result;
}

namespace tool_detail {

namespace {

constexpr double kThinShell = 0.9;

// How fast, in units of the tool's speed, a translating ball's field flows back on its equator, where
// v = (w + r/2 dw/dr) u.
double counter_flow(const Thresholds<double>& thresholds) {
  constexpr int kSamples = 1000;
  double least = 0;
  for (int i = 0; i <= kSamples; ++i) {
    const double r = thresholds.inner + (thresholds.outer - thresholds.inner) * i / kSamples;
    const Weight<double> w = blend_weight(r, thresholds);
    least = std::min(least, w.value + 0.5 * r * w.derivative);
  }
  return -least;
}

}  // namespace

Segment carried_segment(Field field, const Vec3d& displacement, TimeLaw time_law) {
  Segment segment;
  segment.fields.push_back(std::move(field));
  segment.displacement = displacement;
  segment.time_law = time_law;
  return segment;
}

Segment resting_segment(Field field) { return carried_segment(std::move(field), {0, 0, 0}); }

void warn_of_thin_shell(double inner, double outer, Warnings& warnings) {
  if (inner <= kThinShell * outer) return;
  warnings.push_back(
      fmt::format("\"inner\" is {:.3g} of \"outer\": beside the tool the flow runs back at {:.2g} times its speed; "
                  "make \"outer\" larger or \"inner\" smaller",
                  inner / outer, counter_flow({inner, outer})));
}

}  // namespace tool_detail

}  // namespace knead
