// Gestures that carry a tool along a path: ball, capsule, points, stamp, handles.
#include <algorithm>
#include <cmath>
#include <limits>

#include "gestures/gesture_kinds.h"

namespace knead::studio {

namespace {

constexpr double kShortestPiece = 0.01;         // of the radius
constexpr double kShortestDisplacement = 0.03;  // of the radius, of a set of points
constexpr double kNear = 12;                    // pixels from a placed point or curve

Vec3d forward_of(const Surroundings& around) { return render::camera_frame(around.screen.camera).forward; }

double distance_in_pixels(const Screen& screen, const Vec3d& p, const Pointer& pointer) {
  const auto pixel = pixel_of(screen, p);
  return pixel ? std::hypot(pixel->x - pointer.x, pixel->y - pointer.y) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<SurfaceHit> hit_at(const Pointer& pointer, const Surroundings& around) {
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  if (around.hit_test) return around.hit_test(ray);
  if (around.picker == nullptr) return std::nullopt;
  return around.picker->pick(ray, around.state);
}

Vec3d Drag::at(const Pointer& pointer, const Surroundings& around) const {
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  if (mode == DragMode::surface) {
    if (const auto hit = hit_at(pointer, around)) return hit->point + offset;
    return on_plane(ray, start, forward_of(around)).value_or(start);
  }
  const bool along = mode == DragMode::normal || mode == DragMode::axis;
  const auto place = along ? on_line(ray, start, direction) : on_plane(ray, start, direction);
  return place ? *place + offset : start;
}

Drag begin_drag(const Pointer& pointer, const Vec3d& start, const Vec3d& normal, const Surroundings& around) {
  Drag drag{around.settings.drag, start, forward_of(around)};
  if (drag.mode == DragMode::normal) drag.direction = normal;
  if (drag.mode == DragMode::axis) drag.direction = around.settings.axis;
  drag.offset = start - drag.at(pointer, around);
  return drag;
}

namespace {

// Where a drag begins, and the surface's normal there (against the view where there is no surface).
std::pair<Vec3d, Vec3d> start_of(const Pointer& pointer, const Surroundings& around) {
  const Vec3d forward = forward_of(around);
  if (around.settings.on_surface) {
    if (const auto hit = hit_at(pointer, around)) return {hit->point, hit->normal};
  }
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  const Vec3d target = around.screen.camera.target;
  return {on_plane(ray, target, forward).value_or(target), -forward};
}

// A start so near to a mirror's plane that the tool lies across it goes on in the plane.
Vec3d snapped(Vec3d p, const ToolSettings& settings) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (settings.mirror[axis] && std::abs(p[axis]) < 0.5 * settings.inner_ratio * settings.radius) p[axis] = 0;
  }
  return p;
}

// In the planes in which the first point of the path lies.
Vec3d kept_in_planes(Vec3d p, const Vec3d& first, const ToolSettings& settings) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (settings.mirror[axis] && first[axis] == 0) p[axis] = 0;
  }
  return p;
}

// The path goes on to p, or its last place does where nobody has looked at that yet.
void extend(std::vector<Vec3d>& path, const Vec3d& p, double shortest, bool is_taken) {
  if (!is_taken && path.size() > 1) path.pop_back();
  if (norm(p - path.back()) >= shortest) path.push_back(p);
}

}  // namespace

ImplicitGesture begin_implicit(const Pointer& pointer, const Surroundings& around) {
  const ToolSettings& settings = around.settings;
  auto [start, normal] = start_of(pointer, around);
  start = snapped(start, settings);
  ImplicitGesture gesture{begin_drag(pointer, start, normal, around), {}};
  gesture.stroke.inner = settings.inner_ratio * settings.radius;
  gesture.stroke.outer = settings.radius;
  gesture.stroke.path = {start};
  if (settings.tool->is_long) {
    gesture.stroke.region = ImplicitRegion::capsule;
    const Vec3d right = render::camera_frame(around.screen.camera).right;
    gesture.stroke.half_axis = right * (settings.capsule_length * settings.radius);
  }
  return gesture;
}

void move_implicit(const Pointer& pointer, const Surroundings& around, ImplicitGesture& gesture) {
  const Vec3d p = kept_in_planes(gesture.drag.at(pointer, around), gesture.stroke.path.front(), around.settings);
  extend(gesture.stroke.path, p, kShortestPiece * around.settings.radius, around.is_taken);
}

bool is_near(const Placed& placed, const Pointer& pointer, const Surroundings& around) {
  const auto near = [&](const Vec3d& p) { return distance_in_pixels(around.screen, p, pointer) <= kNear; };
  const auto curve_is_near = [&](const std::vector<Vec3d>& curve) {
    return std::any_of(curve.begin(), curve.end(), near);
  };
  return std::any_of(placed.points.begin(), placed.points.end(), near) ||
         std::any_of(placed.curves.begin(), placed.curves.end(), curve_is_near);
}

PointsGesture begin_points(const Pointer& pointer, const Surroundings& around, const Placed& placed) {
  PointsGesture gesture;
  gesture.stroke.points = placed.points;
  gesture.stroke.curves = placed.curves;
  gesture.stroke.outer = around.settings.radius;
  gesture.stroke.inner = 0;
  gesture.stroke.exponent = around.settings.exponent;
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

void move_points(const Pointer& pointer, const Surroundings& around, PointsGesture& gesture) {
  const Vec3d p = gesture.drag.at(pointer, around);
  std::vector<Vec3d>& displacements = gesture.stroke.displacements;
  if (!around.is_taken && !displacements.empty()) {
    gesture.reached -= displacements.back();
    displacements.pop_back();
  }
  const Vec3d displacement = p - gesture.reached;
  if (norm(displacement) < kShortestDisplacement * around.settings.radius) return;
  displacements.push_back(displacement);
  gesture.reached += displacement;
}

void carry_placed(const PointsGesture& gesture, Placed& placed) {
  for (const Vec3d& displacement : gesture.stroke.displacements) {
    for (Vec3d& p : placed.points) p += displacement;
    for (auto& curve : placed.curves) {
      for (Vec3d& p : curve) p += displacement;
    }
  }
}

StampGesture begin_stamp(const Pointer& pointer, const Surroundings& around, const Placed& placed) {
  StampGesture gesture;
  gesture.stroke = stamp_at(around.settings, *placed.stamp, *placed.placement);
  gesture.drag = begin_drag(pointer, placed.placement->center, -placed.placement->z, around);
  gesture.step = gesture.stroke.outer.value_or(around.settings.radius) / 25;
  gesture.stroke.path = {placed.placement->center};
  return gesture;
}

void move_stamp(const Pointer& pointer, const Surroundings& around, StampGesture& gesture) {
  extend(gesture.stroke.path, gesture.drag.at(pointer, around), gesture.step, around.is_taken);
}

namespace {

// At most about so many vertices of a handle, evenly over space.
constexpr std::size_t kMostHandlePoints = 250;

std::vector<Vec3d> handle_points(const Placed& placed, std::uint8_t handle, const ShapeState& state) {
  std::vector<Vec3d> all;
  for (std::size_t i = 0; i < placed.handles.size(); ++i) {
    if (placed.handles[i] == handle) all.push_back(state.positions[i]);
  }
  return thinned(all, kMostHandlePoints);
}

}  // namespace

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

std::optional<HandlesGesture> begin_handles(const Pointer& pointer, const Surroundings& around, const Placed& placed) {
  HandlesGesture gesture;
  gesture.stroke.full = handle_points(placed, kFullHandle, around.state);
  gesture.stroke.zero = handle_points(placed, kZeroHandle, around.state);
  if (gesture.stroke.full.empty() || gesture.stroke.zero.empty()) return std::nullopt;
  gesture.stroke.exponent = around.settings.exponent;
  const auto hit = hit_at(pointer, around);
  const Vec3d start = hit ? hit->point : gesture.stroke.full.front();
  gesture.drag = begin_drag(pointer, start, hit ? hit->normal : -forward_of(around), around);
  gesture.stroke.motion = HandlesTranslation{{0, 0, 0}};
  return gesture;
}

void move_handles(const Pointer& pointer, const Surroundings& around, HandlesGesture& gesture) {
  gesture.stroke.motion = HandlesTranslation{gesture.drag.at(pointer, around) - gesture.drag.start};
}

}  // namespace knead::studio
