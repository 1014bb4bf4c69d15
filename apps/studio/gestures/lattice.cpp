// Moves the shape by the control points of a lattice about it, and selects them.
#include <cmath>
#include <utility>

#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"

namespace knead::studio {

namespace {

constexpr double kOnEachOther = 1;  // pixels

}  // namespace

std::optional<std::size_t> control_point_at(const Pointer& pointer, const Screen& screen,
                                            const std::vector<Vec3d>& points) {
  const Vec3d forward = render::camera_frame(screen.camera).forward;
  std::optional<std::size_t> nearest;
  double least = kNear * screen.unit;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = pixel_of(screen, points[i]);
    if (!pixel) continue;
    const double distance = std::hypot(pixel->x - pointer.x, pixel->y - pointer.y);
    const bool is_before = nearest && dot(points[i] - points[*nearest], forward) < 0;
    if (!(distance < least - kOnEachOther || (is_before && distance < least + kOnEachOther))) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

std::optional<Gesture> begin_lattice(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  const std::vector<Vec3d> points = control_points(placed.lattice.stroke);
  const std::optional<std::size_t> point = control_point_at(pointer, around.screen, points);
  if (!point) return Gesture{LassoGesture{{{pointer.x, pointer.y}}, true}};
  std::vector<bool>& selected = placed.lattice.selected;
  if (pointer.modifiers.shift) {
    selected[*point] = !selected[*point];
    return std::nullopt;
  }
  if (!selected[*point]) {
    selected.assign(selected.size(), false);
    selected[*point] = true;
  }
  LatticeGesture gesture{placed.lattice, begin_drag(pointer, points[*point], -forward_of(around), around)};
  gesture.lattice.stroke.mode = around.settings.lattice_mode;
  return Gesture{std::move(gesture)};
}

void select_control_points(const GestureStep& step, const std::vector<Pixel>& line) {
  const std::vector<Vec3d> points = control_points(step.placed.lattice.stroke);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = pixel_of(step.around.screen, points[i]);
    const bool is_kept = step.pointer.modifiers.ctrl && step.placed.lattice.selected[i];
    step.placed.lattice.selected[i] = is_kept || (pixel && is_within(line, *pixel));
  }
}

void LatticeGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const bool is_click = std::hypot(pointer.x - drag.from.x, pointer.y - drag.from.y) < kClick * around.screen.unit;
  if (by == Vec3d{0, 0, 0} && is_click && !pointer.typed) return;
  by = drag.at(pointer, around) - drag.start;
}

// Leaves the control points where they go, until the shape has followed.
void LatticeGesture::end(const GestureStep& step) {
  has_ended = true;
  step.placed.lattice.stroke = moved();
  step.placed.lattice.is_ahead = true;
}

LatticeStroke LatticeGesture::moved() const {
  LatticeStroke stroke = lattice.stroke;
  for (std::size_t i = 0; i < stroke.displacements.size(); ++i) {
    if (lattice.selected[i]) stroke.displacements[i] += by;
  }
  return stroke;
}

}  // namespace knead::studio
