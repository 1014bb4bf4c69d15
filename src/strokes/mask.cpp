// The event "mask": what the strokes after it must not move.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(MaskStroke& s) {
  return {{"points", Quantity::finite, &s.points, Presence::not_empty},
          {"vertices", Quantity::other, &s.vertices, Presence::not_empty},
          {"values", Quantity::finite, &s.values, Presence::optional},
          {"width", Quantity::positive, &s.width, Presence::optional, "from what stays to what is free"}};
}

void prepare(MaskStroke& /*stroke*/, const HasKey& has) {
  const bool is_null = !has("points") && (has("name") || has("off") || has("strength") || has("duration") ||
                                          has("new_entry"));  // with these
  if (has("points") != has("vertices") || is_null) return;
  throw InvalidInput(fmt::format(R"(a mask has either "points" or "vertices", {})",
                                 has("points") ? "not both" : "got neither; {\"mask\": null} removes it"));
}

void validate(const MaskStroke& stroke) {
  if (!stroke.points.empty() && !stroke.vertices.empty()) {
    throw InvalidInput("\"points\" must not be given together with \"vertices\"");
  }
  if (is_empty(stroke)) {
    if (stroke.width || !stroke.values.empty()) {
      throw InvalidInput("\"points\" or \"vertices\" is missing; without them there is no mask");
    }
    return;
  }
  if (!stroke.width) throw InvalidInput("\"width\" is missing; it must be a length greater than 0");
  for (const VertexRange& range : stroke.vertices) {
    if (range.last >= range.first) continue;
    throw InvalidInput(fmt::format("\"vertices\" must hold ranges [first, last] with first <= last, got [{}, {}]",
                                   range.first, range.last));
  }
  const std::size_t items = stroke.points.size() + stroke.vertices.size();
  if (!stroke.values.empty() && stroke.values.size() != items) {
    throw InvalidInput(fmt::format("\"values\" must hold a number for each of the {} items of \"{}\", got {}", items,
                                   stroke.points.empty() ? "vertices" : "points", stroke.values.size()));
  }
  for (const double value : stroke.values) {
    if (value >= 0 && value <= 1) continue;
    throw InvalidInput(fmt::format("\"values\" must hold numbers from 0 (free) to 1 (stays), got {}", value));
  }
}

Flow flow_of(const MaskStroke& /*stroke*/) { return {}; }

std::string words(const MaskStroke& stroke, const std::string& /*unit*/) {
  return is_empty(stroke) ? "Clear the mask" : "Mask";
}

bool reads_surface(const MaskStroke& stroke) { return !stroke.vertices.empty(); }

// Masked points and their values.
struct MaskedPoints {
  std::vector<Vec3d> points;
  std::vector<double> values;
};

double longest_edge(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return std::sqrt(std::max({norm2(b - a), norm2(c - b), norm2(a - c)}));
}

// Adds points inside the triangles whose three corners are masked, so close that the mask's grid has no gap between
// them. Otherwise a large face would bend between its fixed corners. `level`: the value of each vertex.
void add_points_between(const LiveSurface& surface, const std::vector<double>& level, double width,
                        MaskedPoints& masked) {
  constexpr double kSpacingOfWidth = 1.0 / 16;  // of the width: half a cell of the grid
  constexpr double kMax = 4e6;                  // with more points, they lie further apart
  std::vector<Triangle> among;
  double squares = 0;
  for (const Triangle& t : surface.triangles) {
    if (std::min({level[t[0]], level[t[1]], level[t[2]]}) == 0) continue;
    among.push_back(t);
    squares += norm2(surface.positions[t[1]] - surface.positions[t[0]]);
  }
  const double spacing = std::max(kSpacingOfWidth * width, std::sqrt(squares / kMax));
  for (const auto& [i, j, k] : among) {
    const Vec3d& a = surface.positions[i];
    const Vec3d& b = surface.positions[j];
    const Vec3d& c = surface.positions[k];
    const auto pieces = static_cast<int>(std::min(1e3, std::ceil(longest_edge(a, b, c) / spacing)));
    for (int v = 0; v <= pieces && pieces > 1; ++v) {
      for (int w = 0; w + v <= pieces; ++w) {
        const double s = static_cast<double>(v) / pieces;
        const double r = static_cast<double>(w) / pieces;
        if (std::max({s, r, 1 - s - r}) == 1) continue;  // a corner
        masked.points.push_back(a + (b - a) * s + (c - a) * r);
        masked.values.push_back(level[i] + (level[j] - level[i]) * s + (level[k] - level[i]) * r);
      }
    }
  }
}

void resolve(const MaskStroke& stroke, SurfaceRun& run) {
  const LiveSurface& surface = run.surface;
  MaskedPoints masked;
  std::vector<double> level(surface.positions.size(), 0);
  for (std::size_t i = 0; i < stroke.vertices.size(); ++i) {
    const VertexRange& range = stroke.vertices[i];
    require_vertex("vertices", surface.positions, range.last);
    for (std::size_t vertex = range.first; vertex <= range.last; ++vertex) {
      const double value = stroke.values.empty() ? 1 : stroke.values[i];
      masked.points.push_back(surface.positions[vertex]);
      masked.values.push_back(value);
      level[vertex] = std::max(level[vertex], value);
    }
  }
  add_points_between(surface, level, *stroke.width, masked);
  MaskStroke named;
  named.width = stroke.width;
  for (const std::uint32_t i : representative_points(masked.points, masked.values, *stroke.width)) {
    named.points.push_back(masked.points[i]);
    if (!stroke.values.empty()) named.values.push_back(std::clamp(masked.values[i], 0.0, 1.0));
  }
  if (named.points.empty()) named.width.reset();  // all values are 0
  surface.apply(named);
}

}  // namespace

Mask mask_of(const MaskStroke& stroke, int threads) {
  validate(stroke);
  if (reads_surface(stroke)) throw InvalidInput("this mask reads the surface, so resolve it first");
  return is_empty(stroke) ? Mask() : Mask(stroke.points, stroke.values, *stroke.width, threads);
}

constinit const detail::ToolRow<MaskStroke> MaskStroke::tool{.name = "mask",
                                                             .is_event = true,
                                                             .keys = keys,
                                                             .prepare = prepare,
                                                             .validate = validate,
                                                             .reads_surface = reads_surface,
                                                             .resolve = resolve,
                                                             .flow = flow_of,
                                                             .words = words};

}  // namespace knead
