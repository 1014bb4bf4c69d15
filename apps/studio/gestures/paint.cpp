// Gestures along the surface: paint, lines drawn, handles painted.
#include <algorithm>
#include <cmath>

#include "gestures/gesture_kinds.h"
#include "knead/tools.h"

namespace knead::studio {

namespace {

constexpr double kMinPressure = 0.05;
constexpr double kRadiusSteps = 16;     // of the radius, under a pen
constexpr int kMaxRays = 400;           // between two places of the pointer
constexpr double kLassoPiece = 3;       // pixels between two points of a lasso
constexpr double kPointSpacing = 0.25;  // of a drawn line, in radii

double pressure_of(const Pointer& pointer) { return std::clamp(pointer.pressure, kMinPressure, 1.0); }

Pointer between(const Pointer& a, const Pointer& b, double t) {
  Pointer result = b;
  result.x = a.x + (b.x - a.x) * t;
  result.y = a.y + (b.y - a.y) * t;
  result.pressure = a.pressure + (b.pressure - a.pressure) * t;
  return result;
}

// The radius of a brush in steps, so that many dabs share one stroke.
double radius_under(const Pointer& pointer, const ToolSettings& settings) {
  if (settings.pressure != PenPressure::radius) return settings.radius;
  return settings.radius * std::max(std::ceil(kRadiusSteps * pressure_of(pointer)), 1.0) / kRadiusSteps;
}

PaintTouch touch_at(const SurfaceHit& hit, const Pointer& pointer, const ToolSettings& settings) {
  const bool by_depth = settings.pressure == PenPressure::depth;
  return {{hit.point, hit.normal}, radius_under(pointer, settings), by_depth ? pressure_of(pointer) : 1};
}

}  // namespace

std::optional<PaintGesture> begin_paint(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  const ToolSettings& settings = around.settings;
  const bool in = settings.paint_in != pointer.modifiers.ctrl;
  const PaintStroke stroke{settings.radius, settings.depth * settings.radius * (in ? 1 : -1), {}, {}, settings.falloff};
  return PaintGesture{begin_paint(stroke, touch_at(*hit, pointer, settings)), pointer};
}

void move_paint(const Pointer& pointer, const GestureContext& around, PaintGesture& gesture) {
  const double way = std::hypot(pointer.x - gesture.last.x, pointer.y - gesture.last.y);
  const double fine = 0.25 * gesture.paint.spacing / pixel_size(around.screen, gesture.paint.last);  // pixels
  const int rays = std::clamp(static_cast<int>(std::ceil(way / std::max(fine, 0.5))), 1, kMaxRays);
  const Pointer from = gesture.last;
  for (int i = 1; i <= rays; ++i) {
    const Pointer here = between(from, pointer, static_cast<double>(i) / rays);
    gesture.last = here;
    if (const auto hit = hit_at(here, around)) drag_paint(gesture.paint, touch_at(*hit, here, around.settings));
  }
}

std::optional<DrawGesture> begin_draw(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  return DrawGesture{{hit->point}, around.settings.tool->use == ToolUse::curve};
}

void move_draw(const Pointer& pointer, const GestureContext& around, DrawGesture& gesture) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return;
  if (!gesture.is_curve) {
    gesture.points = {hit->point};
  } else if (norm(hit->point - gesture.points.back()) >= kPointSpacing * around.settings.radius) {
    gesture.points.push_back(hit->point);
  }
}

void end_draw(const DrawGesture& gesture, PlacedTools& placed) {
  if (gesture.is_curve && gesture.points.size() > 1) {
    placed.curves.push_back(gesture.points);
  } else {
    placed.points.push_back(gesture.points.front());
  }
}

HandlePaintGesture begin_handle_paint(const Pointer& pointer, const GestureContext& around) {
  HandleMode mode = around.settings.handle;
  if (pointer.modifiers.ctrl) mode = mode == HandleMode::full ? HandleMode::zero : HandleMode::full;
  if (pointer.modifiers.shift) mode = HandleMode::erase;
  return {mode == HandleMode::erase ? std::uint8_t{0} : mode == HandleMode::full ? kFullHandle : kZeroHandle};
}

void move_handle_paint(const Pointer& pointer, const GestureContext& around, const HandlePaintGesture& gesture,
                       PlacedTools& placed) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return;
  const Snapshot& positions = around.state.positions;
  placed.handles.resize(positions.size());
  const double reach2 = around.settings.radius * around.settings.radius / 4;
  std::vector<Vec3d> centers{hit->point};
  for (const SymmetryImage& image : images_of(around.settings)) centers.push_back(image.motion(hit->point));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3d p = positions[i];
    const bool is_near =
        std::any_of(centers.begin(), centers.end(), [&](const Vec3d& c) { return norm2(p - c) <= reach2; });
    if (is_near) placed.handles[i] = gesture.handle;
  }
}

void extend_line(const Pointer& pointer, std::vector<Pixel>& line) {
  const Pixel here{pointer.x, pointer.y};
  const Pixel& last = line.back();
  if (std::hypot(here.x - last.x, here.y - last.y) >= kLassoPiece) line.push_back(here);
}

void end_lasso(const GestureContext& around, const LassoGesture& gesture, PlacedTools& placed) {
  if (gesture.line.size() < 3) return;
  const Snapshot& positions = around.state.positions;
  placed.handles.resize(positions.size());
  std::vector<RigidMotion> motions{RigidMotion{}};
  for (const SymmetryImage& image : images_of(around.settings)) motions.push_back(image.motion);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3d p = positions[i];
    const bool is_marked = std::any_of(motions.begin(), motions.end(), [&](const RigidMotion& motion) {
      const auto pixel = pixel_of(around.screen, motion(p));
      return pixel && is_within(gesture.line, *pixel);
    });
    if (is_marked) placed.handles[i] = gesture.handle;
  }
}

}  // namespace knead::studio
