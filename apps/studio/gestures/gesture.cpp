#include "gestures/gesture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "gestures/gesture_kinds.h"
#include "gestures/parts.h"
#include "gestures/symmetry.h"

namespace knead::studio {

namespace {

Gesture in_trouble(std::string what) {
  Gesture gesture;
  gesture.kind = HandlePaintGesture{};
  gesture.trouble = std::move(what);
  return gesture;
}

template <class G>
std::optional<Gesture> made(std::optional<G> gesture) {
  if (!gesture) return std::nullopt;
  return Gesture{std::move(*gesture)};
}

// A stamp is taken hold of well within the rings of its gizmo.
constexpr double kStampReach = 35;  // pixels

bool is_on_stamp(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  if (around.settings.tool->use != ToolUse::stamp || !placed.stamp || !placed.placement) return false;
  const auto middle = pixel_of(around.screen, placed.placement->center);
  return middle && std::hypot(middle->x - pointer.x, middle->y - pointer.y) <= kStampReach;
}

std::optional<Gesture> begin_placed(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  if (placed.placement) {
    if (is_on_stamp(pointer, around, placed)) return Gesture{begin_stamp(pointer, around, placed)};
    const auto part = gizmo_part_at(around.screen, *placed.placement, pointer.x, pointer.y);
    if (part) return Gesture{GizmoGesture{*part, *placed.placement, pointer}};
  }
  return Gesture{TurnGesture{pointer, placed.placement}};
}

std::optional<Gesture> begin_any_handles(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  if (around.settings.handle == HandleMode::move) {
    std::optional<HandlesGesture> gesture = begin_handles(pointer, around, placed);
    if (!gesture) return in_trouble("First paint what moves with the left button, and what stays with Ctrl.");
    return Gesture{std::move(*gesture)};
  }
  if (around.settings.lasso) {
    return Gesture{LassoGesture{begin_handle_paint(pointer, around).handle, false, {{pointer.x, pointer.y}}}};
  }
  const HandlePaintGesture gesture = begin_handle_paint(pointer, around);
  move_handle_paint(pointer, around, gesture, placed);
  return Gesture{gesture};
}

// Of a pose that has no exact pins, beside the pins.
std::optional<Gesture> begin_pose(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  const PoseMode mode = around.settings.pose;
  const bool has_ctrl = pointer.modifiers.ctrl;
  const bool is_gizmo = !has_ctrl && is_on_part_gizmo(pointer, around, placed);
  if (is_gizmo || (mode == PoseMode::pins && !has_ctrl)) return made(begin_part(pointer, around, placed));
  if (mode == PoseMode::brush) return made(begin_part_paint(pointer, around, placed));
  const bool frees = mode == PoseMode::lasso && has_ctrl;
  return Gesture{LassoGesture{frees ? std::uint8_t{0} : kZeroHandle, false, {{pointer.x, pointer.y}}}};
}

std::optional<Gesture> begin_any_pins(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  if (!has_exact_pins(around.settings) && !pin_at(pointer, around, placed.pins)) {
    const bool is_lasso_of_pins =
        around.settings.lasso_selects && around.settings.pose == PoseMode::pins && !pointer.modifiers.ctrl;
    std::optional<Gesture> gesture = is_lasso_of_pins ? std::nullopt : begin_pose(pointer, around, placed);
    if (gesture || around.settings.pose != PoseMode::pins) return gesture;
  }
  const bool selects = !pointer.modifiers.ctrl && around.settings.lasso_selects;
  if ((pointer.modifiers.ctrl || selects) && !pin_at(pointer, around, placed.pins)) {
    return Gesture{LassoGesture{kZeroHandle, selects, {{pointer.x, pointer.y}}}};
  }
  return made(begin_pins(pointer, around, placed));
}

std::optional<Gesture> begin_by_tool(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  if (pointer.modifiers.shift) {
    if (around.state.mesh->face_count() == 0) return in_trouble("A point cloud has no surface to relax.");
    return made(begin_relax(pointer, around));
  }
  switch (around.settings.tool->use) {
    case ToolUse::pull:
      return Gesture{begin_implicit(pointer, around)};
    case ToolUse::paint:
      return made(begin_paint(pointer, around));
    case ToolUse::points:
    case ToolUse::curve:
      if (is_near(placed, pointer, around)) return Gesture{begin_points(pointer, around, placed)};
      return made(begin_draw(pointer, around));
    case ToolUse::handles:
      return begin_any_handles(pointer, around, placed);
    case ToolUse::pose:
      return begin_any_pins(pointer, around, placed);
    case ToolUse::stamp:
    case ToolUse::turn:
      return begin_placed(pointer, around, placed);
    case ToolUse::mask:
      break;  // changes no shape: studio_masks.cpp
  }
  return std::nullopt;
}

}  // namespace

std::optional<Gesture> begin_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  std::optional<Gesture> gesture = begin_by_tool(pointer, around, placed);
  if (gesture) gesture->start = around.state;
  return gesture;
}

void move_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture) {
  if (!gesture.trouble.empty()) return;
  struct Move {
    const Pointer& pointer;
    const GestureContext& around;
    PlacedTools& placed;

    void operator()(ImplicitGesture& g) const { move_implicit(pointer, around, g); }
    void operator()(PaintGesture& g) const { move_paint(pointer, around, g); }
    void operator()(DrawGesture& g) const { move_draw(pointer, around, g); }
    void operator()(PointsGesture& g) const { move_points(pointer, around, g); }
    void operator()(StampGesture& g) const { move_stamp(pointer, around, g); }
    void operator()(TurnGesture& g) const { move_turn(pointer, around, g); }
    void operator()(HandlePaintGesture& g) const { move_handle_paint(pointer, around, g, placed); }
    void operator()(LassoGesture& g) const { extend_line(pointer, g.line); }
    void operator()(HandlesGesture& g) const { move_handles(pointer, around, g); }
    void operator()(PinsGesture& g) const { move_pins(pointer, around, g); }
    void operator()(RelaxGesture& g) const { move_relax(pointer, around, g); }
    void operator()(PartGesture& g) const { move_part(pointer, around, g); }
    void operator()(PartPaintGesture& g) const { move_part_paint(pointer, around, g, placed); }
    void operator()(GizmoGesture& g) const { placed.placement = move_gizmo(pointer, around, g); }
  };
  std::visit(Move{pointer, around, placed}, gesture.kind);
}

void end_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture) {
  move_gesture(pointer, around, placed, gesture);
  if (!gesture.trouble.empty()) return;
  if (auto* paint = std::get_if<PaintGesture>(&gesture.kind)) end_paint(paint->paint);
  if (auto* draw = std::get_if<DrawGesture>(&gesture.kind)) end_draw(*draw, placed);
  if (auto* lasso = std::get_if<LassoGesture>(&gesture.kind)) {
    const bool is_of_pins = around.settings.tool->use == ToolUse::pose;
    if (lasso->selects) select_pins(around, lasso->line, placed.pins);
    const bool is_of_part = is_of_pins && !has_exact_pins(around.settings) && !lasso->selects;
    if (is_of_part) end_part_lasso(pointer, around, *lasso, placed);
    if (is_of_pins && !is_of_part && !lasso->selects) end_pin_lasso(around, lasso->line, placed);
    if (!is_of_pins) end_lasso(around, *lasso, placed);
  }
  if (bool* const rests = rests_of(gesture)) *rests = true;
  if (std::holds_alternative<PartPaintGesture>(gesture.kind)) remove_empty_parts(placed.parts);
  if (auto* part = std::get_if<PartGesture>(&gesture.kind); part != nullptr && placed.parts.placement) {
    placed.parts.placement = moved(*placed.parts.placement, part->motion);
    placed.parts.is_ahead = true;
  }
  if (auto* pins = std::get_if<PinsGesture>(&gesture.kind)) end_pins(*pins, around, placed);
  if (auto* points = std::get_if<PointsGesture>(&gesture.kind)) carry_placed(*points, placed);
  if (auto* turn = std::get_if<TurnGesture>(&gesture.kind)) end_turn(around, *turn, placed);
  if (auto* stamp = std::get_if<StampGesture>(&gesture.kind)) {
    if (placed.placement) placed.placement->center = stamp->stroke.path.back();
  }
}

namespace {

// The strokes of a gesture, in as few as say it.
struct StrokesOf {
  std::vector<Stroke> operator()(const ImplicitGesture& g) const {
    if (g.stroke.path.size() < 2) return {};
    return {g.stroke};
  }
  std::vector<Stroke> operator()(const PaintGesture& g) const { return g.paint.strokes(); }
  std::vector<Stroke> operator()(const PointsGesture& g) const {
    if (g.stroke.displacements.empty()) return {};
    return {g.stroke};
  }
  std::vector<Stroke> operator()(const StampGesture& g) const { return pieces_of(g.stroke); }
  std::vector<Stroke> operator()(const HandlesGesture& g) const {
    if (g.stroke.motion == std::variant<HandlesTranslation, HandlesRotation>(HandlesTranslation{})) return {};
    return {g.stroke};
  }
  std::vector<Stroke> operator()(const RelaxGesture& g) const { return {g.stroke}; }
  std::vector<Stroke> operator()(const PinsGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const TurnGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const DrawGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const HandlePaintGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const LassoGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const GizmoGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const PartGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const PartPaintGesture& /*g*/) const { return {}; }
};

constexpr double kSameImage = 1e-9;  // of the radius: images that differ by less are one

}  // namespace

namespace {

// The strokes of a gesture without images, and whether they have them already.
struct OwnStrokes {
  std::vector<Stroke> strokes{};
  bool has_images = false;
};

OwnStrokes own_strokes_of(const Gesture& gesture, const ToolSettings& settings) {
  if (!gesture.trouble.empty()) return {};
  const auto* handles = std::get_if<HandlesGesture>(&gesture.kind);
  if (handles != nullptr && !refusal_of(*handles, settings).empty()) return {};
  const auto posed = [](const std::optional<PoseStroke>& pose) {
    return pose ? OwnStrokes{{*pose}, true} : OwnStrokes{};
  };
  if (const auto* part = std::get_if<PartGesture>(&gesture.kind)) {
    return posed(pose_stroke(*part, gesture.start, settings));
  }
  if (const auto* pins = std::get_if<PinsGesture>(&gesture.kind)) {
    if (settings.pose != PoseMode::exact) return posed(pose_stroke(*pins, gesture.start, settings));
    if (pins->to == pins->drag.start) return {};
    return {{pins_stroke(pins->pins, pins->dragged, pins->to, settings)}, true};
  }
  std::vector<Stroke> strokes = std::visit(StrokesOf{}, gesture.kind);
  if (const auto* turn = std::get_if<TurnGesture>(&gesture.kind); turn != nullptr && turn->placement) {
    if (auto stroke = turning_stroke(settings, *turn->placement, turn->amount)) strokes = {std::move(*stroke)};
  }
  return {std::move(strokes)};
}

std::vector<Stroke> with_all_images(OwnStrokes own, const ToolSettings& settings, const ImageFile& image_file) {
  if (own.has_images) return std::move(own.strokes);
  return symmetric_strokes(own.strokes, images_of(settings), kSameImage * settings.radius, image_file);
}

}  // namespace

std::vector<SessionStroke> lines_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file) {
  OwnStrokes own = own_strokes_of(gesture, settings);
  const auto is_sum = [](const Stroke& stroke) {
    return is_flow(stroke) && !std::holds_alternative<MaskStroke>(stroke);
  };
  std::optional<Mirror> mirror;
  if (!own.has_images && std::all_of(own.strokes.begin(), own.strokes.end(), is_sum)) mirror = mirror_of(settings);
  std::vector<Stroke> strokes = mirror ? std::move(own.strokes) : with_all_images(std::move(own), settings, image_file);
  std::vector<SessionStroke> lines;
  for (Stroke& stroke : strokes) {
    lines.push_back({std::move(stroke)});
    if (mirror) lines.back().mirror = *mirror;
  }
  return lines;
}

std::vector<Stroke> strokes_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file) {
  return with_all_images(own_strokes_of(gesture, settings), settings, image_file);
}

std::optional<Amount> amount_of(const Gesture& gesture, const ToolSettings& settings) {
  struct Measure {
    const ToolSettings& settings;

    using Result = std::optional<Amount>;
    static Result length(const Drag& drag, const Vec3d& to) { return Amount{AmountKind::length, drag.length_of(to)}; }
    Result operator()(const ImplicitGesture& g) const { return length(g.drag, g.stroke.path.back()); }
    Result operator()(const PointsGesture& g) const { return length(g.drag, g.reached); }
    Result operator()(const StampGesture& g) const { return length(g.drag, g.stroke.path.back()); }
    Result operator()(const HandlesGesture& g) const {
      return length(g.drag, g.drag.start + std::get<HandlesTranslation>(g.stroke.motion).by);
    }
    Result operator()(const PinsGesture& g) const { return length(g.drag, g.to); }
    Result operator()(const TurnGesture& g) const {
      if (!g.placement) return std::nullopt;
      if (!settings.tool->turning.is_percent) return Amount{AmountKind::angle, g.amount};
      return Amount{AmountKind::percent, 100 * std::expm1(g.amount / 100)};
    }
    Result operator()(const GizmoGesture& g) const {
      if (g.part == GizmoPart::center) return std::nullopt;
      return Amount{turns(g.part) ? AmountKind::angle : AmountKind::length, g.amount};
    }
    Result operator()(const PaintGesture& /*g*/) const { return std::nullopt; }
    Result operator()(const DrawGesture& /*g*/) const { return std::nullopt; }
    Result operator()(const HandlePaintGesture& /*g*/) const { return std::nullopt; }
    Result operator()(const LassoGesture& /*g*/) const { return std::nullopt; }
    Result operator()(const RelaxGesture& /*g*/) const { return std::nullopt; }
    Result operator()(const PartPaintGesture& /*g*/) const { return std::nullopt; }
    Result operator()(const PartGesture& g) const {
      if (g.handle == GizmoPart::center) return std::nullopt;
      return Amount{!g.handle || turns(*g.handle) ? AmountKind::angle : AmountKind::length, g.amount};
    }
  };
  if (!gesture.trouble.empty()) return std::nullopt;
  return std::visit(Measure{settings}, gesture.kind);
}

const Drag* drag_of(const Gesture& gesture) {
  if (const auto* g = std::get_if<ImplicitGesture>(&gesture.kind)) return &g->drag;
  if (const auto* g = std::get_if<PointsGesture>(&gesture.kind)) return &g->drag;
  if (const auto* g = std::get_if<StampGesture>(&gesture.kind)) return &g->drag;
  if (const auto* g = std::get_if<HandlesGesture>(&gesture.kind)) return &g->drag;
  if (const auto* g = std::get_if<PinsGesture>(&gesture.kind)) return &g->drag;
  return nullptr;
}

}  // namespace knead::studio
