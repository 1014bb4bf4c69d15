// Gestures that carry a tool along a path: ball, capsule, points, stamp; and those that paint.
#include <algorithm>
#include <cmath>

#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"

namespace knead::studio {

namespace {

constexpr double kShortestPiece = 0.01;         // of the radius
constexpr double kShortestDisplacement = 0.03;  // of the radius, of a set of points
// Sines of the angle between a line and the view: the line faces the viewer below the first, and is seen from the side
// above the second.
constexpr double kFacesViewer = 0.6;
constexpr double kSeenFromSide = 0.8;
constexpr double kLevel = 1e-6;  // a line that is seen level counts as one that goes up
constexpr double kMinPressure = 0.05;
constexpr double kRadiusSteps = 16;     // of the radius, under a pen
constexpr int kMaxRays = 400;           // between two places of the pointer
constexpr double kFirstSpacing = 0.1;   // of the radius: the distance of rays before paint meets the shape
constexpr double kLassoPiece = 3;       // pixels between two points of a lasso
constexpr double kPointSpacing = 0.25;  // of a drawn line, in radii
constexpr double kSpacing = 0.3;        // of the places, in radii
constexpr int kMaxPlaces = 200;         // between two places of the pointer

double distance_in_pixels(const Screen& screen, const Vec3d& p, const Pointer& pointer) {
  const auto pixel = pixel_of(screen, p);
  return pixel ? std::hypot(pixel->x - pointer.x, pixel->y - pointer.y) : kInfinity;
}

// Returns a start under the surface at which the inner region just touches it from below, or halfway through the shape
// if that is less deep.
Vec3d under_surface(const SurfaceHit& hit, const GestureContext& around) {
  double deep = around.settings.inner_ratio * around.settings.radius;
  if (around.picker != nullptr) {
    const auto thickness = around.picker->thickness(hit, around.state);
    if (thickness) deep = std::min(deep, 0.5 * *thickness);
  }
  return hit.point - hit.normal * deep;
}

// The start of a drag, the place on the surface in front of it, and the normal there (against the view without a
// surface).
struct PullPlace {
  Vec3d start;
  Vec3d touched;
  Vec3d normal;
};

PullPlace start_of(const Pointer& pointer, const GestureContext& around) {
  const Vec3d forward = forward_of(around);
  const PullStart start = around.settings.tool->brush != nullptr ? PullStart::surface : around.settings.start;
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

// Extends the path to p, or replaces its last place if the worker has not taken it yet. With a typed or snapped number
// the path is straight.
void extend(std::vector<Vec3d>& path, const Vec3d& p, double shortest, const Pointer& pointer, bool is_taken) {
  if (pointer.typed || pointer.modifiers.ctrl) {
    path.resize(1);
    if (!(p == path.front())) path.push_back(p);
    return;
  }
  if (!is_taken && path.size() > 1) path.pop_back();
  if (norm(p - path.back()) >= shortest) path.push_back(p);
}

double pressure_of(const Pointer& pointer) { return std::clamp(pointer.pressure, kMinPressure, 1.0); }

Pointer between(const Pointer& a, const Pointer& b, double t) {
  Pointer result = b;
  result.x = a.x + (b.x - a.x) * t;
  result.y = a.y + (b.y - a.y) * t;
  result.pressure = a.pressure + (b.pressure - a.pressure) * t;
  return result;
}

// Rounds the radius of a brush to steps, so that many dabs share one stroke.
double radius_under(const Pointer& pointer, const ToolSettings& settings) {
  if (settings.pressure != PenPressure::radius) return settings.radius;
  return settings.radius * std::max(std::ceil(kRadiusSteps * pressure_of(pointer)), 1.0) / kRadiusSteps;
}

PaintTouch touch_at(const SurfaceHit& hit, const Pointer& pointer, const ToolSettings& settings) {
  const bool by_depth = settings.pressure == PenPressure::depth;
  return {{hit.point, hit.normal}, radius_under(pointer, settings), by_depth ? pressure_of(pointer) : 1};
}

// Returns the surface for a tool that flattens, else null. It is valid as long as `around`.
PaintPlane plane_of(const GestureContext& around) {
  if (!(around.settings.tool->brush->pinch < 0) || around.picker == nullptr) return nullptr;
  return [&around](const PaintSample& at, double radius) {
    const auto position = [&](std::uint32_t vertex) { return around.state.positions[vertex]; };
    return mean_plane(around.picker->triangles(), position, at, radius);
  };
}

std::size_t vertices_within(const ShapeState& state, const Vec3d& center, double radius) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < state.positions.size(); ++i) {
    count += norm2(state.positions[i] - center) < radius * radius ? 1 : 0;
  }
  return count;
}

// Appends points from the last one to the place of the pointer on the surface.
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

Vec3d forward_of(const GestureContext& around) { return render::camera_frame(around.screen.camera).forward; }

std::optional<SurfaceHit> hit_at(const Pointer& pointer, const GestureContext& around) {
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  if (around.hit_test) return around.hit_test(ray);
  if (around.picker == nullptr) return std::nullopt;
  const bool is_cloud = around.state.mesh->face_count() == 0;
  return is_cloud ? around.picker->pick_point(ray, around.state) : around.picker->pick(ray, around.state);
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

// A typed distance is measured from the start towards the pointer.
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
  Drag drag{around.settings.drag, start, forward_of(around)};
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

ImplicitGesture begin_implicit(const Pointer& pointer, const GestureContext& around) {
  const ToolSettings& settings = around.settings;
  const PullPlace place = start_of(pointer, around);
  const Vec3d start = snapped_to_symmetry(place.start, place.touched, {}, settings);
  ImplicitGesture gesture{begin_drag(pointer, start, place.normal, around), {}, place.touched, place.normal};
  gesture.stroke.inner = settings.inner_ratio * settings.radius;
  gesture.stroke.outer = settings.radius;
  gesture.stroke.falloff = settings.falloff;
  gesture.stroke.path = {start};
  if (settings.tool->brush != nullptr) {
    gesture.stroke = std::get<ImplicitStroke>(stroke_of(*settings.tool->brush, settings.radius, 0));
    gesture.stroke.path = {start};
  }
  if (settings.tool->is_long) {
    gesture.stroke.region = ImplicitRegion::capsule;
    const Vec3d right = render::camera_frame(around.screen.camera).right;
    gesture.stroke.half_axis = right * (settings.capsule_length * settings.radius);
  }
  return gesture;
}

bool is_near(const PlacedTools& placed, const Pointer& pointer, const GestureContext& around) {
  const auto near = [&](const Vec3d& p) {
    return distance_in_pixels(around.screen, p, pointer) <= kNear * around.screen.unit;
  };
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

StampGesture begin_stamp(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  StampGesture gesture;
  gesture.stroke = stamp_at(around.settings, *placed.stamp, *placed.placement);
  gesture.drag = begin_drag(pointer, placed.placement->center, -placed.placement->z, around);
  gesture.shortest = gesture.stroke.step.value_or(around.settings.stamp_size * around.settings.radius / 50);
  gesture.stroke.path = {placed.placement->center};
  return gesture;
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

PaintStroke brush_of(const ToolSettings& settings, const Pointer& pointer) {
  const Brush& brush = *settings.tool->brush;
  const double sign = settings.paint_in != pointer.modifiers.ctrl ? -1 : 1;
  const double amount = sign * (brush.pinch == 0 ? settings.depth : settings.pinch);
  return std::get<PaintStroke>(stroke_of(brush, settings.radius, amount));
}

PaintGesture begin_paint(const Pointer& pointer, const GestureContext& around) {
  const ToolSettings& settings = around.settings;
  PaintGesture gesture{brush_of(settings, pointer)};
  gesture.last = pointer;
  if (const auto hit = hit_at(pointer, around)) {
    gesture.paint = begin_paint(gesture.brush, touch_at(*hit, pointer, settings), plane_of(around));
    gesture.paint->plane = nullptr;
  }
  return gesture;
}

std::optional<DrawGesture> begin_draw(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  return DrawGesture{{hit->point}, around.settings.tool->use == ToolUse::curve};
}

void extend_line(const Pointer& pointer, std::vector<Pixel>& line) {
  const Pixel here{pointer.x, pointer.y};
  const Pixel& last = line.back();
  if (std::hypot(here.x - last.x, here.y - last.y) >= kLassoPiece) line.push_back(here);
}

std::optional<RelaxGesture> begin_relax(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  RelaxGesture gesture;
  gesture.stroke.points = {hit->point};
  gesture.stroke.radius = around.settings.radius;
  gesture.stroke.amount = around.settings.smoothing;
  gesture.stroke.iterations = relax_iterations(vertices_within(around.state, hit->point, gesture.stroke.radius));
  if (pointer.modifiers.ctrl) gesture.stroke.surface = 0;
  gesture.last_point = hit->point;
  return gesture;
}

std::optional<InflateGesture> begin_inflate(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  const ToolSettings& settings = around.settings;
  const double depth = std::min(settings.depth, kMaxInflateDepth) * settings.radius *
                       (settings.paint_in != pointer.modifiers.ctrl ? -1 : 1);
  return InflateGesture{{.points = {hit->point}, .radius = settings.radius, .depth = depth}, hit->point};
}

std::optional<PrintGesture> begin_print(const Pointer& pointer, const GestureContext& around,
                                        const PlacedTools& placed) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  const ToolSettings& settings = around.settings;
  PrintGesture gesture;
  PrintStroke& stroke = gesture.stroke;
  if (placed.picture) {
    stroke.file = placed.picture->file;
  } else {
    stroke.text = settings.text;
    stroke.font = settings.font;
  }
  const bool presses_in = settings.paint_in != pointer.modifiers.ctrl;
  stroke.height = settings.radius;
  stroke.depth = settings.depth * settings.radius * (presses_in ? 1 : -1);
  stroke.point = hit->point;
  stroke.up = print_up(around.screen, hit->normal);
  return gesture;
}

Vec3d print_up(const Screen& screen, const Vec3d& normal) {
  constexpr double kSteep = 0.9;
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const double up = dot(normal, frame.up);
  return std::abs(up) < kSteep ? frame.up : frame.forward * std::copysign(1, up);
}

void ImplicitGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  std::vector<Vec3d>& path = stroke.path;
  const Vec3d to = drag.at(pointer, around);
  const Vec3d& start = drag.start;
  if (path.size() == 1) path = {snapped_to_symmetry(start, touched, to - start, around.settings)};
  const Vec3d p = kept_in_symmetry(to, path.front(), around.settings);
  extend(path, p, kShortestPiece * around.settings.radius, pointer, around.is_taken);
}

void PointsGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const Vec3d p = drag.at(pointer, around);
  std::vector<Vec3d>& displacements = stroke.displacements;
  if (pointer.typed || pointer.modifiers.ctrl) {
    displacements.clear();
    reached = drag.start;
  }
  if (!around.is_taken && !displacements.empty()) {
    reached -= displacements.back();
    displacements.pop_back();
  }
  const Vec3d displacement = p - reached;
  if (norm(displacement) < kShortestDisplacement * around.settings.radius) return;
  displacements.push_back(displacement);
  reached += displacement;
}

// Moves the placed things by the gesture.
void PointsGesture::end(const GestureStep& step) const {
  const auto& [pointer, around, placed] = step;
  for (const Vec3d& displacement : stroke.displacements) {
    for (Vec3d& p : placed.points) p += displacement;
    for (auto& curve : placed.curves) {
      for (Vec3d& p : curve) p += displacement;
    }
  }
}

void StampGesture::move(const GestureStep& step) {
  extend(stroke.path, drag.at(step.pointer, step.around), shortest, step.pointer, step.around.is_taken);
}

void StampGesture::end(const GestureStep& step) const {
  if (step.placed.placement) step.placed.placement->center = stroke.path.back();
}

void PaintGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const double way = std::hypot(pointer.x - last.x, pointer.y - last.y);
  // Beside the shape as fine as paint of this radius is at the view's target.
  const double spacing = paint ? paint->spacing : kFirstSpacing * brush.bump;
  const Vec3d& place = paint ? paint->last : around.screen.camera.target;
  const double fine = 0.25 * spacing / pixel_size(around.screen, place);  // pixels
  const int rays = std::clamp(static_cast<int>(std::ceil(way / std::max(fine, 0.5))), 1, kMaxRays);
  const Pointer from = last;
  if (paint) paint->plane = plane_of(around);
  for (int i = 1; i <= rays; ++i) {
    const Pointer here = between(from, pointer, static_cast<double>(i) / rays);
    last = here;
    const auto hit = hit_at(here, around);
    if (!hit) continue;
    const PaintTouch touch = touch_at(*hit, here, around.settings);
    if (paint) {
      drag_paint(*paint, touch);
    } else {
      paint = begin_paint(brush, touch, plane_of(around));
    }
  }
  if (paint) paint->plane = nullptr;
}

void DrawGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const auto hit = hit_at(pointer, around);
  if (!hit) return;
  if (!is_curve) {
    points = {hit->point};
  } else if (norm(hit->point - points.back()) >= kPointSpacing * around.settings.radius) {
    points.push_back(hit->point);
  }
}

void DrawGesture::end(const GestureStep& step) const {
  if (is_curve && points.size() > 1) {
    step.placed.curves.push_back(points);
  } else {
    step.placed.points.push_back(points.front());
  }
}

void LassoGesture::move(const GestureStep& step) { extend_line(step.pointer, line); }

void LassoGesture::end(const GestureStep& step) const {
  const auto& [pointer, around, placed] = step;
  if (around.settings.tool->use == ToolUse::lattice) return select_control_points(step, line);
  if (selects) return select_pins(around, line, placed.pins);
  if (has_exact_pins(around.settings)) return end_pin_lasso(around, line, placed);
  end_part_lasso(pointer, around, *this, placed);
}

void RelaxGesture::move(const GestureStep& step) {
  extend_on_surface(step.pointer, step.around, kSpacing * stroke.radius, last_point, stroke.points);
}

void InflateGesture::move(const GestureStep& step) {
  if (step.pointer.typed) stroke.depth = *step.pointer.typed;
  extend_on_surface(step.pointer, step.around, kSpacing * stroke.radius, last_point, stroke.points);
}

void PrintGesture::move(const GestureStep& step) {
  const auto hit = hit_at(step.pointer, step.around);
  if (!hit) return;
  stroke.point = hit->point;
  stroke.up = print_up(step.around.screen, hit->normal);
}

}  // namespace knead::studio
