// Bends the shape along a line: a handle of the line is dragged, or a new line is drawn in the picture.
#include <cmath>

#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"

namespace knead::studio {

namespace {

constexpr double kDrawnPiece = 3;      // pixels between two points of a drawn line
constexpr double kShortestLine = 0.1;  // of the shape's line; a shorter drag is a slip of the hand

double drawn_length(const std::vector<Vec3d>& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += norm(line[i] - line[i - 1]);
  return length;
}

}  // namespace

std::optional<std::size_t> handle_at(const Pointer& pointer, const Screen& screen, const std::vector<Vec3d>& line,
                                     std::size_t stride) {
  std::optional<std::size_t> nearest;
  double least = kNear * screen.unit;
  for (std::size_t i = 0; i < line.size(); i += stride) {
    const auto pixel = pixel_of(screen, line[i]);
    const double distance = pixel ? std::hypot(pixel->x - pointer.x, pixel->y - pointer.y) : least;
    if (distance >= least) continue;
    least = distance;
    nearest = i / stride;
  }
  return nearest;
}

std::optional<BendAlongGesture> begin_bend_along(const Pointer& pointer, const GestureContext& around,
                                                 PlacedTools& placed) {
  if (placed.line.size() < 2) return std::nullopt;
  BendAlongGesture gesture;
  gesture.line = placed.line;
  gesture.stride = placed.line_stride;
  gesture.length = around.settings.bend_length;
  gesture.keep = around.settings.bend_keep;
  gesture.handle = handle_at(pointer, around.screen, gesture.line, gesture.stride);
  if (gesture.handle) {
    gesture.drag = begin_drag(pointer, gesture.line[*gesture.handle * gesture.stride], -forward_of(around), around);
  } else {
    gesture.move({pointer, around, placed});
  }
  return gesture;
}

void BendAlongGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  if (handle) {
    const bool is_click = std::hypot(pointer.x - drag.from.x, pointer.y - drag.from.y) < kClick * around.screen.unit;
    if (to.empty() && is_click && !pointer.typed) return;
    to = with_handle_moved(line, stride, *handle, drag.at(pointer, around) - drag.start);
    return;
  }
  const Vec3d middle = line[line.size() / 2];
  const auto here = on_plane(ray_through(around.screen, pointer.x, pointer.y), middle, forward_of(around));
  if (!here) return;
  const double least = drawn.empty() ? 0 : kDrawnPiece * pixel_size(around.screen, middle);
  if (drawn.empty() || norm(*here - drawn.back()) >= least) drawn.push_back(*here);
}

// Leaves the line where it goes, until the shape has followed.
void BendAlongGesture::end(const GestureStep& step) {
  if (!handle && drawn_length(drawn) >= kShortestLine * drawn_length(line)) {
    to = smoothed_line(drawn, line, step.around.state.positions.copy());
  }
  if (!to.empty()) step.placed.line = points_on_line(to, line.size());
}

std::vector<Stroke> BendAlongGesture::strokes() const {
  if (to.empty() || to == line) return {};
  CurveStroke stroke = curve_between(line, to);
  stroke.length = length;
  stroke.keep = keep;
  return {stroke};
}

std::optional<Amount> BendAlongGesture::number() const {
  if (!handle) return std::nullopt;
  return Amount{AmountKind::length, to.empty() ? 0 : drag.length_of(to[*handle * stride])};
}

}  // namespace knead::studio
