#include "gestures/tool_names.h"

namespace knead::studio {

const char* name_of(DragMode mode) {
  switch (mode) {
    case DragMode::view:
      return "In the view plane";
    case DragMode::surface:
      return "Along the surface";
    case DragMode::normal:
      return "Along the normal";
    case DragMode::axis:
      return "Along an axis";
  }
  return "";
}

const char* name_of(HandleMode mode) {
  switch (mode) {
    case HandleMode::full:
      return "Moves";
    case HandleMode::zero:
      return "Stays";
    case HandleMode::erase:
      return "Erase";
    case HandleMode::move:
      return "Drag";
  }
  return "";
}

Action action_of(ToolKind tool) {
  return static_cast<Action>(static_cast<int>(Action::tool_ball) + static_cast<int>(tool));
}

std::string hint_of(const ToolSettings& settings, const Placed& placed) {
  switch (settings.tool) {
    case ToolKind::ball:
    case ToolKind::capsule:
      return "Drag the shape, or start beside it.";
    case ToolKind::paint:
      return settings.paint_in ? "Paint on the shape to press it in; Ctrl pulls out."
                               : "Paint on the shape to pull it out; Ctrl presses in.";
    case ToolKind::points:
      return placed.points.empty() ? "Click points on the shape; then drag one of them."
                                   : "Drag one of the points, or click more. Escape takes them away.";
    case ToolKind::curve:
      return placed.curves.empty() ? "Draw a curve on the shape; then drag it."
                                   : "Drag the curve, or draw more. Escape takes them away.";
    case ToolKind::stamp:
      return placed.placement ? "Drag the stamp by its middle into the shape; its arrows and rings move and turn it."
                              : "Click on the shape to place the stamp.";
    case ToolKind::rotate:
    case ToolKind::stretch:
    case ToolKind::twist:
    case ToolKind::bend:
      return placed.placement ? "Drag to the right or left beside the gizmo; its arrows and rings move and turn it."
                              : "Click on the shape to place the tool.";
    case ToolKind::handles:
      if (settings.handle == HandleMode::move) return "Drag the handle that moves.";
      return "Paint what moves, with Ctrl what stays; then choose Drag.";
  }
  return {};
}

}  // namespace knead::studio
