#include "knead/tool/paint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/describe.h"
#include "knead/tool/path_curve.h"
#include "knead/tool/surface_point.h"

namespace knead {

double dab_length(int falloff) {
  constexpr std::array kLengths{81.0 / 140, 17.0 / 35, 181.0 / 462, 47.0 / 143, 81.0 / 286};
  return kLengths[static_cast<std::size_t>(falloff - kLeastFalloff)];
}

PaintDabs paint_dabs(const PaintStroke& stroke) {
  constexpr double kSpacing = 1.0 / 8;  // of outer: of the dabs of the default falloff, and the greatest depth of one
  constexpr double kMostDabs = 1e6;
  const tool_detail::PathCurve curve(stroke.path);
  const double doses = std::max(curve.length() / (dab_length(stroke.falloff) * stroke.outer), 1.0);
  const double spacing = kSpacing * (dab_length(stroke.falloff) / dab_length(kDefaultFalloff));
  const double by_length = std::ceil(curve.length() / (spacing * stroke.outer));
  const double by_depth = std::ceil(doses * std::abs(stroke.depth) / (kSpacing * stroke.outer));
  const double count = curve.length() > 0 ? std::max(by_length, by_depth) : 1;
  if (!(count <= kMostDabs)) {
    throw InvalidInput(
        fmt::format("\"path\" is {:.3g} long and would need {:.3g} dabs, more than {:.0f}; make \"outer\" "
                    "larger, or \"depth\" smaller",
                    curve.length(), count, kMostDabs));
  }
  PaintDabs dabs{{}, stroke.depth * doses / count};
  for (double i = 0; i < count; ++i) dabs.aims.push_back(curve.at(curve.length() * ((i + 0.5) / count)));
  return dabs;
}

void paint_on(const PaintStroke& stroke, const LiveSurface& surface) {
  if (surface.triangles.empty() && !surface.normal) {
    throw InvalidInput(
        "\"path\" needs a surface, or a point cloud with normals; give \"samples\" with normals instead");
  }
  constexpr double kMoreThanRounding = 1.001;  // a float's rounding of a distance, in which vertices may move as well
  const PaintDabs dabs = paint_dabs(stroke);
  tool_detail::SurfaceFinder finder(surface);
  for (const Vec3d& aim : dabs.aims) {
    const std::optional<PaintSample> sample = finder.closest(aim);
    if (!sample)
      throw InvalidInput("\"path\" leads to a place where the surface has no normal; give \"samples\" instead");
    if (!surface.apply(PaintStroke{stroke.outer, dabs.depth, {*sample}, {}, stroke.falloff})) return;
    finder.follow(sample->point, kMoreThanRounding * (stroke.outer + std::abs(dabs.depth)));
  }
}

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(PaintStroke& s) {
  return {{"outer", Quantity::positive, &s.outer, Presence::required, "radius of one dab"},
          {"depth", Quantity::other, &s.depth, Presence::required,
           "how far one dab moves the surface; negative pulls it out"},
          {"samples", Quantity::other, s.path.empty() ? &s.samples : nullptr},
          {"path", Quantity::finite, &s.path, Presence::not_empty}};
}

void prepare(PaintStroke& stroke, const HasKey& has) {
  if (!has("path")) return;
  if (has("samples")) throw InvalidInput(R"(a paint stroke has either "samples" or "path", not both)");
  stroke.path.resize(1);  // so that "samples" does not apply
}

void validate(const PaintStroke& stroke) {
  if (!std::isfinite(stroke.depth) || stroke.depth == 0) {
    throw InvalidInput(fmt::format(
        "\"depth\" must be a number other than 0 (greater pushes in, less pulls out), got {}", stroke.depth));
  }
  if (stroke.path.empty()) require_count("samples", stroke.samples.size(), 1, "samples");
  for (const PaintSample& sample : stroke.samples) {
    require_finite("point", sample.point);
    require_direction("normal", sample.normal);
  }
}

bool reads_surface(const PaintStroke& stroke) { return !stroke.path.empty(); }

Flow flow_of(const PaintStroke& stroke) {
  Flow flow;
  for (const PaintSample& sample : stroke.samples) {
    const Vec3d displacement = unit(sample.normal) * -stroke.depth;
    flow.segments.push_back(carried_segment(
        {sample.point, Translation<double>{displacement}, Ball<double>{}, {0, stroke.outer}}, displacement));
  }
  return flow;
}

void prolong(PaintStroke& stroke, double strength) { stroke.depth *= strength; }

}  // namespace

const Tool& PaintStroke::tool() {
  static const Tool kTool =
      describe<PaintStroke>("paint", {keys, validate, flow_of, nullptr, reads_surface, prepare, prolong});
  return kTool;
}

}  // namespace knead
