#include "view/stretch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "view/overlay.h"

namespace knead::studio {

namespace {

// Vertices that an estimate looks at, and those of them that it follows: 3 ms on two cores.
constexpr std::size_t kLookedAt = 40'000;
constexpr std::size_t kFollowed = 192;
constexpr double kMinPart = 0.9 / 2.4;  // of the safe width of a bend

// The places of the vertices from which the shape is stretched.
std::optional<std::vector<Vec3d>> places_before(const DocumentState& shown, StretchView since) {
  const ShapeState& now = shown.state;
  const bool is_past = shown.looked_at.has_value();
  if (since == StretchView::since_start) {
    return now.provenance == nullptr ? shown.start.positions.copy() : now.provenance->rest;
  }
  if (is_past || !shown.before_stroke) return std::nullopt;
  if (shown.before_stroke->mesh == now.mesh) return shown.before_stroke->positions.copy();
  return now.provenance == nullptr ? std::nullopt : std::optional(now.provenance->before_stroke);
}

std::vector<Vec3d> some_of(const Snapshot& positions) {
  const std::size_t stride = positions.size() / kLookedAt + 1;
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < positions.size(); i += stride) result.push_back(positions[i]);
  return result;
}

// Path lines of such a bend may run to infinity (method, section 10).
bool is_crushed(const Stroke& stroke, const ZoneProfile& profile) {
  const std::optional<ZoneCheck> check = check_zone(stroke, profile);
  return check && std::holds_alternative<BendStroke>(stroke) && check->width < kMinPart * check->safe;
}

}  // namespace

float shade_of_stretch(double stretch) {
  return static_cast<float>(std::clamp(std::log(stretch) / std::log(kGreatestShown), 0.0, 1.0));
}

std::optional<std::vector<float>> stretches_shown(const DocumentState& shown, StretchView since) {
  if (shown.opened == 0 || shown.state.mesh == nullptr) return std::nullopt;
  const std::optional<std::vector<Vec3d>> before = places_before(shown, since);
  if (!before || before->size() != shown.state.positions.size()) return std::nullopt;
  return vertex_stretches(triangulate(*shown.state.mesh), *before, shown.state.positions.copy());
}

const std::optional<GreatestStretch>& StretchEstimate::update(const Studio& studio) {
  const DocumentState& shown = studio.shown();
  std::vector<Stroke> strokes;
  if (studio.settings().tool->use == ToolUse::turn && shown.opened != 0 && !shown.looked_at) {
    strokes = studio.gesture() ? studio.preview() : hovering(studio);
  }
  const ShapeState& state = studio.gesture() ? studio.gesture()->start : shown.state;
  const bool is_same = state_.mesh != nullptr && state_.is_same(state);
  if (is_same && strokes == strokes_) return estimate_;
  if (!is_same) positions_ = some_of(state.positions);
  state_ = state;
  strokes_ = std::move(strokes);
  estimate_.reset();
  const auto& placement = studio.placed().placement;
  Flow flow;
  for (const Stroke& stroke : strokes_) {
    if (placement && placement->profile && is_crushed(stroke, *placement->profile)) {
      estimate_ = GreatestStretch{HUGE_VAL, 0, placement->center, 1};
      return estimate_;
    }
    if (reads_surface(stroke)) continue;
    const Flow one = flow_of(stroke);
    flow.segments.insert(flow.segments.end(), one.segments.begin(), one.segments.end());
  }
  if (flow.segments.empty()) return estimate_;
  StrainOptions options;
  options.length = shown.diagonal;
  options.samples = kFollowed;
  estimate_ = greatest_stretch(flow, positions_, options);
  return estimate_;
}

std::string zone_note(const Studio& studio) {
  const std::optional<Gesture>& gesture = studio.gesture();
  const auto* turn = gesture ? std::get_if<TurnGesture>(&gesture->kind) : nullptr;
  if (turn == nullptr || !turn->placement) return {};
  const std::optional<double> width = widened_zone(studio.settings(), *turn->placement, turn->amount);
  if (!width) return {};
  return fmt::format("The zone is {:.3g} wide now: a thinner one would crush the shape at this angle.", *width);
}

}  // namespace knead::studio
