#include <fmt/format.h>

#include "knead/math/error.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

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

bool reads_surface(const MaskStroke& stroke) { return !stroke.vertices.empty(); }

}  // namespace

Mask mask_of(const MaskStroke& stroke, int threads) {
  validate(stroke);
  if (reads_surface(stroke)) throw InvalidInput("this mask reads the surface, so resolve it first");
  return is_empty(stroke) ? Mask() : Mask(stroke.points, stroke.values, *stroke.width, threads);
}

const Tool& MaskStroke::tool() {
  static const Tool kTool = [] {
    Tool tool = describe<MaskStroke>("mask", {keys, validate, flow_of, nullptr, reads_surface, prepare});
    tool.is_event = true;
    return tool;
  }();
  return kTool;
}

}  // namespace knead
