#include "knead/tool/stroke.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "knead/math/error.h"
#include "knead/tool/tools.h"

namespace knead {

std::string tool_name(const Stroke& stroke) {
  constexpr std::array<const char*, std::variant_size_v<Stroke>> kNames{
      "implicit", "paint", "points", "handles", "stamp", "rotate", "stretch", "twist", "bend"};
  return kNames[stroke.index()];
}

void validate(const Stroke& stroke) {
  std::visit([](const auto& tool) { tool_detail::validate(tool); }, stroke);
}

bool reads_surface(const Stroke& stroke) {
  if (const auto* paint = std::get_if<PaintStroke>(&stroke)) return !paint->path.empty();
  if (const auto* handles = std::get_if<HandlesStroke>(&stroke)) {
    return !handles->full_vertices.empty() || !handles->zero_vertices.empty();
  }
  if (const auto* twist = std::get_if<TwistStroke>(&stroke)) return twist->radius_auto;
  if (const auto* bend = std::get_if<BendStroke>(&stroke)) return bend->radius_auto;
  return std::holds_alternative<StampStroke>(stroke);
}

Flow flow_of(const Stroke& stroke) {
  validate(stroke);
  if (reads_surface(stroke)) throw InvalidInput("this stroke reads the surface, so resolve it first");
  return std::visit(
      [](const auto& tool) {
        if constexpr (std::is_same_v<decltype(tool), const StampStroke&>) {
          return Flow{};
        } else {
          return tool_detail::flow_of(tool);
        }
      },
      stroke);
}

std::vector<std::string> warnings(const Stroke& stroke) {
  std::vector<std::string> result;
  if (std::holds_alternative<HandlesStroke>(stroke) && reads_surface(stroke)) return result;
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
