// Gestures that carry a tool along a path: ball, capsule, points, stamp; and those that paint.
#include <algorithm>
#include <cmath>

#include "gestures/gesture_kinds.h"
#include "knead/tools.h"

namespace knead::studio {

namespace {

constexpr double kShortestPiece = 0.01;         // of the radius
constexpr double kShortestDisplacement = 0.03;  // of the radius, of a set of points
// Sines of the angle between a line and the view: the line faces the viewer below the first, and is seen from the side
// above the second.
constexpr double kFacesViewer = 0.35;
constexpr double kSeenFromSide = 0.6;
constexpr double kLevel = 1e-6;  // a line that is seen level counts as one that goes up

Vec3d forward_of(const GestureContext& around) { return render::camera_frame(around.screen.camera).forward; }

double distance_in_pixels(const Screen& screen, const Vec3d& p, const Pointer& pointer) {
  const auto pixel = pixel_of(screen, p);
  return pixel ? std::hypot(pixel->x - pointer.x, pixel->y - pointer.y) : kInfinity;
}

}  // namespace

std::optional<SurfaceHit> hit_at(const Pointer& pointer, const GestureContext& around) {
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  if (around.hit_test) return around.hit_test(ray);
  if (around.picker == nullptr) return std::nullopt;
  return around.picker->pick(ray, around.state);
}

double snapped(double value, double step, const Pointer& pointer) {
  return pointer.modifiers.ctrl && step > 0 ? step * std::round(value / step) : value;
}

// A line is measured from its start along its direction.
Vec3d Drag::on_its_line(const Pointer& pointer, const GestureContext& around) const {
  double along = 0;
  if (depth < 1) {
    const auto place = on_line(ray_through(around.screen, pointer.x, pointer.y), start, direction);
    if (place) along += (1 - depth) * dot(*place - start, direction);
  }
  if (depth > 0) along += depth * up * (from.y - pointer.y) * pixel_size(around.screen, start);
  return start + direction * along + offset;
}

Vec3d Drag::pointed_at(const Pointer& pointer, const GestureContext& around) const {
  if (is_on_line()) return on_its_line(pointer, around);
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  if (mode == DragMode::surface) {
    if (const auto hit = hit_at(pointer, around)) return hit->point + offset;
    return on_plane(ray, start, forward_of(around)).value_or(start);
  }
  const auto place = on_plane(ray, start, direction);
  return place ? *place + offset : start;
}

double Drag::length_of(const Vec3d& to) const { return is_on_line() ? dot(to - start, direction) : norm(to - start); }

// A typed distance goes where the pointer is seen from the start.
Vec3d Drag::at(const Pointer& pointer, const GestureContext& around) const {
  const Vec3d place = pointed_at(pointer, around);
  if (!pointer.typed && !pointer.modifiers.ctrl) return place;
  Vec3d unit = direction;
  if (!is_on_line()) {
    const Vec3d way = place - start;
    unit = norm(way) > 0 ? normalized(way) : render::camera_frame(around.screen.camera).right;
  }
  return start + unit * pointer.typed.value_or(snapped(length_of(place), around.snap, pointer));
}

Drag begin_drag(const Pointer& pointer, const Vec3d& start, const Vec3d& normal, const GestureContext& around) {
  Drag drag{drag_mode(around.settings), start, forward_of(around)};
  drag.from = {pointer.x, pointer.y};
  if (drag.mode == DragMode::normal) drag.direction = normalized(normal);
  if (drag.mode == DragMode::axis) drag.direction = normalized(around.settings.axis);
  if (drag.is_on_line()) {
    const Screen& screen = around.screen;
    const auto pixel = pixel_of(screen, start).value_or(drag.from);
    const Vec3d view = ray_through(screen, pixel.x, pixel.y).direction;
    const Vec3d seen = drag.direction - view * dot(drag.direction, view);
    const double s = std::clamp((norm(seen) - kFacesViewer) / (kSeenFromSide - kFacesViewer), 0.0, 1.0);
    drag.depth = 1 - s * s * (3 - 2 * s);
    const bool faces = drag.depth == 1;
    const double upwards = faces ? -dot(drag.direction, view) : dot(seen, render::camera_frame(screen.camera).up);
    drag.up = upwards >= -kLevel ? 1 : -1;
  }
  Pointer free = pointer;
  free.typed.reset();
  free.modifiers.ctrl = false;
  drag.offset = start - drag.at(free, around);
  return drag;
}

namespace {

// A start so deep under the surface that the inner region just touches it from below, or half way through the shape.
Vec3d under_surface(const SurfaceHit& hit, const GestureContext& around) {
  double deep = around.settings.inner_ratio * around.settings.radius;
  if (around.picker != nullptr) {
    const auto thickness = around.picker->thickness(hit, around.state);
    if (thickness) deep = std::min(deep, 0.5 * *thickness);
  }
  return hit.point - hit.normal * deep;
}

// Where a drag begins, where that is seen on the surface, and the surface's normal there (against the view where there
// is no surface).
struct PullPlace {
  Vec3d start;
  Vec3d touched;
  Vec3d normal;
};

PullPlace start_of(const Pointer& pointer, const GestureContext& around) {
  const Vec3d forward = forward_of(around);
  const PullStart start = around.settings.start;
  if (start != PullStart::plane) {
    if (const auto hit = hit_at(pointer, around)) {
      const Vec3d from = start == PullStart::inside ? under_surface(*hit, around) : hit->point;
      return {from, hit->point, hit->normal};
    }
  }
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  const Vec3d target = around.screen.camera.target;
  const Vec3d place = on_plane(ray, target, forward).value_or(target);
  return {place, place, -forward};
}

// The path goes on to p, or its last place does where nobody has looked at that yet. With a number, typed or snapped,
// it is straight.
void extend(std::vector<Vec3d>& path, const Vec3d& p, double shortest, const Pointer& pointer, bool is_taken) {
  if (pointer.typed || pointer.modifiers.ctrl) {
    path.resize(1);
    if (!(p == path.front())) path.push_back(p);
    return;
  }
  if (!is_taken && path.size() > 1) path.pop_back();
  if (norm(p - path.back()) >= shortest) path.push_back(p);
}

}  // namespace

ImplicitGesture begin_implicit(const Pointer& pointer, const GestureContext& around) {
  const ToolSettings& settings = around.settings;
  const PullPlace place = start_of(pointer, around);
  const Vec3d start = snapped_to_symmetry(place.start, place.touched, {}, settings);
  ImplicitGesture gesture{begin_drag(pointer, start, place.normal, around), {}, place.touched, place.normal};
  gesture.stroke.inner = settings.inner_ratio * settings.radius;
  gesture.stroke.outer = settings.radius;
  gesture.stroke.falloff = settings.falloff;
  gesture.stroke.path = {start};
  if (settings.tool->is_long) {
    gesture.stroke.region = ImplicitRegion::capsule;
    const Vec3d right = render::camera_frame(around.screen.camera).right;
    gesture.stroke.half_axis = right * (settings.capsule_length * settings.radius);
  }
  return gesture;
}

void move_implicit(const Pointer& pointer, const GestureContext& around, ImplicitGesture& gesture) {
  std::vector<Vec3d>& path = gesture.stroke.path;
  const Vec3d to = gesture.drag.at(pointer, around);
  const Vec3d& start = gesture.drag.start;
  if (path.size() == 1) path = {snapped_to_symmetry(start, gesture.touched, to - start, around.settings)};
  const Vec3d p = kept_in_symmetry(to, path.front(), around.settings);
  extend(path, p, kShortestPiece * around.settings.radius, pointer, around.is_taken);
}

bool is_near(const PlacedTools& placed, const Pointer& pointer, const GestureContext& around) {
  const auto near = [&](const Vec3d& p) { return distance_in_pixels(around.screen, p, pointer) <= kNear; };
  const auto curve_is_near = [&](const std::vector<Vec3d>& curve) {
    return std::any_of(curve.begin(), curve.end(), near);
  };
  return std::any_of(placed.points.begin(), placed.points.end(), near) ||
         std::any_of(placed.curves.begin(), placed.curves.end(), curve_is_near);
}

PointsGesture begin_points(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  PointsGesture gesture;
  gesture.stroke.points = placed.points;
  gesture.stroke.curves = placed.curves;
  gesture.stroke.outer = around.settings.radius;
  gesture.stroke.inner = 0;
  gesture.stroke.exponent = around.settings.exponent;
  gesture.stroke.falloff = around.settings.falloff;
  Vec3d nearest = placed.points.empty() ? placed.curves.front().front() : placed.points.front();
  const auto consider = [&](const Vec3d& p) {
    if (distance_in_pixels(around.screen, p, pointer) < distance_in_pixels(around.screen, nearest, pointer))
      nearest = p;
  };
  std::for_each(placed.points.begin(), placed.points.end(), consider);
  for (const auto& curve : placed.curves) std::for_each(curve.begin(), curve.end(), consider);
  const auto hit = hit_at(pointer, around);
  gesture.drag = begin_drag(pointer, nearest, hit ? hit->normal : -forward_of(around), around);
  gesture.reached = nearest;
  return gesture;
}

void move_points(const Pointer& pointer, const GestureContext& around, PointsGesture& gesture) {
  const Vec3d p = gesture.drag.at(pointer, around);
  std::vector<Vec3d>& displacements = gesture.stroke.displacements;
  if (pointer.typed || pointer.modifiers.ctrl) {
    displacements.clear();
    gesture.reached = gesture.drag.start;
  }
  if (!around.is_taken && !displacements.empty()) {
    gesture.reached -= displacements.back();
    displacements.pop_back();
  }
  const Vec3d displacement = p - gesture.reached;
  if (norm(displacement) < kShortestDisplacement * around.settings.radius) return;
  displacements.push_back(displacement);
  gesture.reached += displacement;
}

void carry_placed(const PointsGesture& gesture, PlacedTools& placed) {
  for (const Vec3d& displacement : gesture.stroke.displacements) {
    for (Vec3d& p : placed.points) p += displacement;
    for (auto& curve : placed.curves) {
      for (Vec3d& p : curve) p += displacement;
    }
  }
}

StampGesture begin_stamp(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  StampGesture gesture;
  gesture.stroke = stamp_at(around.settings, *placed.stamp, *placed.placement);
  gesture.drag = begin_drag(pointer, placed.placement->center, -placed.placement->z, around);
  gesture.step = gesture.stroke.step.value_or(around.settings.stamp_size * around.settings.radius / 50);
  gesture.stroke.path = {placed.placement->center};
  return gesture;
}

void move_stamp(const Pointer& pointer, const GestureContext& around, StampGesture& gesture) {
  extend(gesture.stroke.path, gesture.drag.at(pointer, around), gesture.step, pointer, around.is_taken);
}

std::vector<Vec3d> thinned(const std::vector<Vec3d>& points, std::size_t most) {
  if (points.size() <= most) return points;
  double cell = bounding_box(points).diagonal() / std::cbrt(8.0 * static_cast<double>(most)) / 4;
  while (true) {
    std::vector<std::pair<std::array<long, 3>, std::size_t>> cells(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3d& p = points[i];
      cells[i] = {{std::lround(p.x / cell), std::lround(p.y / cell), std::lround(p.z / cell)}, i};
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(
        std::unique(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
        cells.end());
    if (cells.size() <= most) {
      std::vector<Vec3d> result;
      result.reserve(cells.size());
      for (const auto& kept : cells) result.push_back(points[kept.second]);
      return result;
    }
    cell *= 1.3;
  }
}

// --- gestures along the surface: paint, lines drawn
// -------------------------------------------------------------------

namespace {

constexpr double kMinPressure = 0.05;
constexpr double kRadiusSteps = 16;     // of the radius, under a pen
constexpr int kMaxRays = 400;           // between two places of the pointer
constexpr double kFirstSpacing = 0.1;   // of the radius: how far rays are apart before paint meets the shape
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

PaintGesture begin_paint(const Pointer& pointer, const GestureContext& around) {
  const ToolSettings& settings = around.settings;
  const bool in = settings.paint_in != pointer.modifiers.ctrl;
  PaintGesture gesture;
  gesture.brush = {settings.radius, settings.depth * settings.radius * (in ? 1 : -1), {}, {}, settings.falloff};
  gesture.last = pointer;
  if (const auto hit = hit_at(pointer, around)) {
    gesture.paint = begin_paint(gesture.brush, touch_at(*hit, pointer, settings));
  }
  return gesture;
}

void move_paint(const Pointer& pointer, const GestureContext& around, PaintGesture& gesture) {
  const double way = std::hypot(pointer.x - gesture.last.x, pointer.y - gesture.last.y);
  // Beside the shape as fine as paint of this radius is at the view's target.
  const double spacing = gesture.paint ? gesture.paint->spacing : kFirstSpacing * gesture.brush.outer;
  const Vec3d& place = gesture.paint ? gesture.paint->last : around.screen.camera.target;
  const double fine = 0.25 * spacing / pixel_size(around.screen, place);  // pixels
  const int rays = std::clamp(static_cast<int>(std::ceil(way / std::max(fine, 0.5))), 1, kMaxRays);
  const Pointer from = gesture.last;
  for (int i = 1; i <= rays; ++i) {
    const Pointer here = between(from, pointer, static_cast<double>(i) / rays);
    gesture.last = here;
    const auto hit = hit_at(here, around);
    if (!hit) continue;
    const PaintTouch touch = touch_at(*hit, here, around.settings);
    if (gesture.paint) drag_paint(*gesture.paint, touch);
    if (!gesture.paint) gesture.paint = begin_paint(gesture.brush, touch);
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

void extend_line(const Pointer& pointer, std::vector<Pixel>& line) {
  const Pixel here{pointer.x, pointer.y};
  const Pixel& last = line.back();
  if (std::hypot(here.x - last.x, here.y - last.y) >= kLassoPiece) line.push_back(here);
}

// --- places along the pointer's path: inflate, and with Shift any tool, which then relaxes the surface ---------------

namespace {

constexpr double kSpacing = 0.3;  // of the places, in radii
constexpr int kMaxPlaces = 200;   // between two places of the pointer

// Goes from the last of the points on to where the pointer is on the surface.
void extend_on_surface(const Pointer& pointer, const GestureContext& around, double spacing, Vec3d& last,
                       std::vector<Vec3d>& points) {
  const auto end = hit_at(pointer, around);
  if (!end) return;
  const Vec3d from = last;
  const int pieces = std::clamp(static_cast<int>(norm(end->point - from) / spacing), 0, kMaxPlaces);
  for (int i = 1; i <= pieces; ++i) points.push_back(from + (end->point - from) * (static_cast<double>(i) / pieces));
  if (pieces > 0) last = end->point;
}

}  // namespace

std::optional<RelaxGesture> begin_relax(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  RelaxGesture gesture;
  gesture.stroke.points = {hit->point};
  gesture.stroke.radius = around.settings.radius;
  if (pointer.modifiers.ctrl) gesture.stroke.surface = 0;
  gesture.last_point = hit->point;
  return gesture;
}

void move_relax(const Pointer& pointer, const GestureContext& around, RelaxGesture& gesture) {
  extend_on_surface(pointer, around, kSpacing * gesture.stroke.radius, gesture.last_point, gesture.stroke.points);
}

std::optional<InflateGesture> begin_inflate(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  const ToolSettings& settings = around.settings;
  const double cube = settings.radius * settings.radius * settings.radius;
  const bool shrinks = settings.paint_in != pointer.modifiers.ctrl;
  return InflateGesture{{{hit->point}, settings.radius, settings.growth * cube * (shrinks ? -1 : 1)}, hit->point};
}

void move_inflate(const Pointer& pointer, const GestureContext& around, InflateGesture& gesture) {
  if (pointer.typed) gesture.stroke.volume = *pointer.typed;
  extend_on_surface(pointer, around, kSpacing * gesture.stroke.radius, gesture.last_point, gesture.stroke.points);
}

}  // namespace knead::studio
