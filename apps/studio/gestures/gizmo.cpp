#include "gestures/gizmo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "knead/vec.h"

namespace knead::studio {

namespace {

constexpr double kPixels = 90;  // length of an arrow
constexpr double kRing = 0.7;   // radius of a ring, in arrows
constexpr double kReach = 9;    // pixels within which a part is hit
constexpr double kCenterReach = 12;
constexpr int kRingPoints = 48;

constexpr std::array<render::Color, 3> kColors{
    {{0.80f, 0.22f, 0.20f, 1}, {0.30f, 0.62f, 0.22f, 1}, {0.22f, 0.40f, 0.85f, 1}}};

std::array<Vec3d, 3> axes(const Placement& p) { return {p.x, p.y, p.z}; }

double distance_to_segment(const Pixel& p, const Pixel& a, const Pixel& b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  const double t = length2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0;
  return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

// In pixels; infinite where the polyline is not in sight.
double distance_to_line(const Screen& screen, const std::vector<Vec3d>& points, const Pixel& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const auto a = pixel_of(screen, points[i]);
    const auto b = pixel_of(screen, points[i + 1]);
    if (a && b) least = std::min(least, distance_to_segment(p, *a, *b));
  }
  return least;
}

std::vector<Vec3d> ring_of(const Placement& placement, std::size_t axis, double size) {
  std::vector<Vec3d> points = render::ring(placement.center, axes(placement)[axis], kRing * size, kRingPoints);
  points.push_back(points.front());
  return points;
}

Vec3d turned(const Vec3d& v, const Vec3d& axis, double angle) { return rotate(v, axis, sincos(angle)); }

}  // namespace

double angle_round(const Screen& screen, const Vec3d& center, const Vec3d& axis, const Pixel& from, const Pixel& to) {
  const auto middle = pixel_of(screen, center);
  if (!middle) return 0;
  const double before = std::atan2(from.y - middle->y, from.x - middle->x);
  const double after = std::atan2(to.y - middle->y, to.x - middle->x);
  const Vec3d to_eye = -ray_through(screen, middle->x, middle->y).direction;
  return std::remainder(before - after, 2 * std::numbers::pi) * (dot(axis, to_eye) >= 0 ? 1 : -1);
}

double gizmo_size(const Screen& screen, const Placement& placement) {
  return kPixels * pixel_size(screen, placement.center);
}

std::optional<GizmoPart> gizmo_part_at(const Screen& screen, const Placement& placement, double x, double y) {
  const Pixel at{x, y};
  const auto middle = pixel_of(screen, placement.center);
  if (!middle) return std::nullopt;
  if (std::hypot(middle->x - x, middle->y - y) <= kCenterReach) return GizmoPart::center;
  constexpr std::array<GizmoPart, 3> movers{GizmoPart::move_x, GizmoPart::move_y, GizmoPart::move_z};
  constexpr std::array<GizmoPart, 3> turners{GizmoPart::turn_x, GizmoPart::turn_y, GizmoPart::turn_z};
  const double size = gizmo_size(screen, placement);
  std::optional<GizmoPart> best;
  double least = kReach;
  const auto consider = [&](GizmoPart part, const std::vector<Vec3d>& line) {
    const double distance = distance_to_line(screen, line, at);
    if (distance >= least) return;
    least = distance;
    best = part;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    consider(movers[k], {placement.center, placement.center + axes(placement)[k] * size});
    consider(turners[k], ring_of(placement, k, size));
  }
  return best;
}

bool turns(GizmoPart part) { return part >= GizmoPart::turn_x; }

Vec3d axis_of(const Placement& placement, GizmoPart part) {
  const GizmoPart first = turns(part) ? GizmoPart::turn_x : GizmoPart::move_x;
  return axes(placement)[static_cast<std::size_t>(part) - static_cast<std::size_t>(first)];
}

double dragged_by(const Screen& screen, const Placement& start, GizmoPart part, const Pixel& from, const Pixel& to) {
  const Vec3d axis = axis_of(start, part);
  if (turns(part)) return angle_round(screen, start.center, axis, from, to) * 180 / std::numbers::pi;
  const auto a = on_line(ray_through(screen, from.x, from.y), start.center, axis);
  const auto b = on_line(ray_through(screen, to.x, to.y), start.center, axis);
  return a && b ? dot(*b - *a, axis) : 0;
}

Placement moved_by(const Placement& start, GizmoPart part, double amount) {
  Placement result = start;
  result.limit_cylinder.reset();
  const Vec3d axis = axis_of(start, part);
  if (!turns(part)) {
    result.center += axis * amount;
    return result;
  }
  const double angle = amount * std::numbers::pi / 180;
  for (Vec3d* v : {&result.x, &result.y, &result.z}) *v = normalized(turned(*v, axis, angle));
  return result;
}

Placement center_dragged(const Screen& screen, const Placement& start, const Pixel& from, const Pixel& to) {
  Placement result = start;
  result.limit_cylinder.reset();
  const Vec3d forward = render::camera_frame(screen.camera).forward;
  const auto a = on_plane(ray_through(screen, from.x, from.y), start.center, forward);
  const auto b = on_plane(ray_through(screen, to.x, to.y), start.center, forward);
  if (a && b) result.center += *b - *a;
  return result;
}

void draw_gizmo(const Screen& screen, const Placement& placement, std::optional<GizmoPart> lit,
                std::vector<render::Arrow>& arrows, std::vector<render::Line>& lines) {
  const double size = gizmo_size(screen, placement);
  const auto tint = [&](std::size_t k, GizmoPart first) {
    render::Color color = kColors[k];
    const bool is_lit = lit && static_cast<std::size_t>(*lit) == static_cast<std::size_t>(first) + k;
    if (is_lit) color = {1.0f, 0.85f, 0.25f, 1};
    return color;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    arrows.push_back({.from = placement.center,
                      .to = placement.center + axes(placement)[k] * size,
                      .radius = 0.022 * size,
                      .color = tint(k, GizmoPart::move_x)});
    lines.push_back(
        {.points = ring_of(placement, k, size), .radius = 0.013 * size, .color = tint(k, GizmoPart::turn_x)});
  }
}

}  // namespace knead::studio
