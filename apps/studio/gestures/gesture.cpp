#include "gestures/gesture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "gestures/gesture_kinds.h"

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

bool is_on_stamp(const Pointer& pointer, const Surroundings& around, const Placed& placed) {
  if (around.settings.tool->use != ToolUse::stamp || !placed.stamp || !placed.placement) return false;
  const auto middle = pixel_of(around.screen, placed.placement->center);
  return middle && std::hypot(middle->x - pointer.x, middle->y - pointer.y) <= kStampReach;
}

std::optional<Gesture> begin_placed(const Pointer& pointer, const Surroundings& around, Placed& placed) {
  if (placed.placement) {
    if (is_on_stamp(pointer, around, placed)) return Gesture{begin_stamp(pointer, around, placed)};
    const auto part = gizmo_part_at(around.screen, *placed.placement, pointer.x, pointer.y);
    if (part) return Gesture{GizmoGesture{*part, *placed.placement, pointer}};
  }
  return Gesture{TurnGesture{pointer, placed.placement}};
}

std::optional<Gesture> begin_any_handles(const Pointer& pointer, const Surroundings& around, Placed& placed) {
  if (around.settings.handle == HandleMode::move) {
    std::optional<HandlesGesture> gesture = begin_handles(pointer, around, placed);
    if (!gesture) return in_trouble("First paint what moves with the left button, and what stays with Ctrl.");
    return Gesture{std::move(*gesture)};
  }
  const HandlePaintGesture gesture = begin_handle_paint(pointer, around);
  move_handle_paint(pointer, around, gesture, placed);
  return Gesture{gesture};
}

std::optional<Gesture> begin_by_tool(const Pointer& pointer, const Surroundings& around, Placed& placed) {
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
    case ToolUse::stamp:
    case ToolUse::turn:
      return begin_placed(pointer, around, placed);
  }
  return std::nullopt;
}

}  // namespace

std::optional<Gesture> begin_gesture(const Pointer& pointer, const Surroundings& around, Placed& placed) {
  std::optional<Gesture> gesture = begin_by_tool(pointer, around, placed);
  if (gesture) gesture->start = around.state;
  return gesture;
}

void move_gesture(const Pointer& pointer, const Surroundings& around, Placed& placed, Gesture& gesture) {
  if (!gesture.trouble.empty()) return;
  struct Move {
    const Pointer& pointer;
    const Surroundings& around;
    Placed& placed;

    void operator()(ImplicitGesture& g) const { move_implicit(pointer, around, g); }
    void operator()(PaintGesture& g) const { move_paint(pointer, around, g); }
    void operator()(DrawGesture& g) const { move_draw(pointer, around, g); }
    void operator()(PointsGesture& g) const { move_points(pointer, around, g); }
    void operator()(StampGesture& g) const { move_stamp(pointer, around, g); }
    void operator()(TurnGesture& g) const { move_turn(pointer, around, g); }
    void operator()(HandlePaintGesture& g) const { move_handle_paint(pointer, around, g, placed); }
    void operator()(HandlesGesture& g) const { move_handles(pointer, around, g); }
    void operator()(GizmoGesture& g) const {
      placed.placement = dragged(around.screen, g.start, g.part, {g.from.x, g.from.y}, {pointer.x, pointer.y});
    }
  };
  std::visit(Move{pointer, around, placed}, gesture.kind);
}

void end_gesture(const Pointer& pointer, const Surroundings& around, Placed& placed, Gesture& gesture) {
  move_gesture(pointer, around, placed, gesture);
  if (!gesture.trouble.empty()) return;
  if (auto* paint = std::get_if<PaintGesture>(&gesture.kind)) end_paint(*paint);
  if (auto* draw = std::get_if<DrawGesture>(&gesture.kind)) end_draw(*draw, placed);
  if (auto* points = std::get_if<PointsGesture>(&gesture.kind)) carry_placed(*points, placed);
  if (auto* turn = std::get_if<TurnGesture>(&gesture.kind)) end_turn(around, *turn, placed);
  if (auto* stamp = std::get_if<StampGesture>(&gesture.kind)) {
    if (placed.placement) placed.placement->center = stamp->stroke.path.back();
  }
}

namespace {

// The pieces of a gesture, each to be followed by its mirror images; without mirrors in as few strokes as say it.
struct Pieces {
  bool is_mirrored = false;

  std::vector<Stroke> operator()(const ImplicitGesture& g) const {
    if (g.stroke.path.size() < 2) return {};
    return is_mirrored ? along_path(g.stroke) : std::vector<Stroke>{g.stroke};
  }
  std::vector<Stroke> operator()(const PaintGesture& g) const { return {g.stroke}; }
  std::vector<Stroke> operator()(const PointsGesture& g) const {
    if (g.stroke.displacements.empty()) return {};
    if (!is_mirrored) return {g.stroke};
    std::vector<Stroke> pieces;
    PointsStroke piece = g.stroke;
    for (const Vec3d& displacement : g.stroke.displacements) {
      piece.displacements = {displacement};
      pieces.push_back(piece);
      for (Vec3d& p : piece.points) p += displacement;
      for (auto& curve : piece.curves) {
        for (Vec3d& p : curve) p += displacement;
      }
    }
    return pieces;
  }
  std::vector<Stroke> operator()(const StampGesture& g) const { return along_path(g.stroke); }
  std::vector<Stroke> operator()(const HandlesGesture& g) const {
    if (g.stroke.motion == std::variant<HandlesTranslation, HandlesRotation>(HandlesTranslation{})) return {};
    return {g.stroke};
  }
  std::vector<Stroke> operator()(const TurnGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const DrawGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const HandlePaintGesture& /*g*/) const { return {}; }
  std::vector<Stroke> operator()(const GizmoGesture& /*g*/) const { return {}; }

  template <class S>
  static std::vector<Stroke> along_path(const S& stroke) {
    std::vector<Stroke> pieces;
    for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
      S piece = stroke;
      piece.path = {stroke.path[i], stroke.path[i + 1]};
      pieces.push_back(std::move(piece));
    }
    return pieces;
  }
};

Stroke image_of(Stroke stroke, unsigned planes, const ImageFile& image_file) {
  for (int axis = 0; axis < 3; ++axis) {
    if ((planes >> axis & 1U) != 0) stroke = mirrored(stroke, axis);
  }
  if (auto* stamp = std::get_if<StampStroke>(&stroke)) stamp->mesh = image_file(stamp->mesh, planes);
  return stroke;
}

// Bit masks of the planes: every combination of those that are on.
std::vector<unsigned> images(const std::array<bool, 3>& mirror) {
  unsigned all = 0;
  for (unsigned axis = 0; axis < 3; ++axis) all |= mirror[axis] ? 1U << axis : 0U;
  std::vector<unsigned> result;
  for (unsigned planes = 1; planes < 8; ++planes) {
    if ((planes & ~all) == 0) result.push_back(planes);
  }
  return result;
}

// Samples of one brush are mirrored one by one, so that both sides grow together.
PaintStroke with_images(const PaintStroke& stroke, const std::vector<unsigned>& planes) {
  PaintStroke result = stroke;
  result.samples.clear();
  for (const PaintSample& sample : stroke.samples) {
    result.samples.push_back(sample);
    for (const unsigned mask : planes) {
      PaintStroke one = stroke;
      one.samples = {sample};
      result.samples.push_back(std::get<PaintStroke>(image_of(one, mask, {})).samples.front());
    }
  }
  return result;
}

}  // namespace

std::vector<Stroke> strokes_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file) {
  if (!gesture.trouble.empty()) return {};
  const std::vector<unsigned> planes = images(settings.mirror);
  std::vector<Stroke> pieces = std::visit(Pieces{!planes.empty()}, gesture.kind);
  if (const auto* turn = std::get_if<TurnGesture>(&gesture.kind); turn != nullptr && turn->placement) {
    if (auto stroke = turning_stroke(settings, *turn->placement, turn->amount)) pieces = {std::move(*stroke)};
  }
  if (planes.empty()) return pieces;
  std::vector<Stroke> result;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Stroke& piece = pieces[i];
    if (const auto* paint = std::get_if<PaintStroke>(&piece)) {
      result.emplace_back(with_images(*paint, planes));
      continue;
    }
    std::vector<Stroke> same{piece};  // images that are the piece itself, or each other, count once
    for (const unsigned mask : planes) {
      Stroke image = image_of(piece, mask, image_file);
      if (std::find(same.begin(), same.end(), image) == same.end()) same.push_back(std::move(image));
    }
    // The order turns round from piece to piece, so that no side is always first (Strang's splitting).
    if (i % 2 == 1) std::reverse(same.begin(), same.end());
    std::move(same.begin(), same.end(), std::back_inserter(result));
  }
  return result;
}

}  // namespace knead::studio
