#include "knead/render/rods.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knead::render {
namespace {

// A circle of vertices to be joined to others: where, how wide, and how far the normals lean along the axis.
struct Circle {
  Vec3d center;
  double radius = 0;
  double lean = 0;  // of the unit normal along the axis: 0 for a cylinder, -1 for a cap that faces back
};

struct Frame {
  Vec3d axis;
  Vec3d u;
  Vec3d v;
  int sides = 48;  // of the prisms along the axis
};

Frame frame_along(const Vec3d& axis, int sides) {
  const Vec3d u = any_orthogonal(axis);
  return {normalized(axis), u, cross(normalized(axis), u), sides};
}

void add_circle(const Circle& circle, const Frame& frame, Bytes4 color, DrawSurface& surface) {
  const double outwards = std::sqrt(std::max(0.0, 1 - circle.lean * circle.lean));
  for (int i = 0; i < frame.sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / frame.sides;
    const Vec3d out = frame.u * std::cos(angle) + frame.v * std::sin(angle);
    surface.vertices.push_back(
        {Vec3f(circle.center + out * circle.radius), Vec3f(out * outwards + frame.axis * circle.lean), color});
  }
}

// Joins the two circles added last.
void join_circles(const Frame& frame, DrawSurface& surface) {
  const auto sides = static_cast<std::uint32_t>(frame.sides);
  const auto first = static_cast<std::uint32_t>(surface.vertices.size()) - 2 * sides;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t a = first + i;
    const std::uint32_t b = first + (i + 1) % sides;
    for (const std::uint32_t index : {a, b, b + sides, a, b + sides, a + sides}) surface.indices.push_back(index);
  }
}

void add_band(const Circle& from, const Circle& to, const Frame& frame, Bytes4 color, DrawSurface& surface) {
  add_circle(from, frame, color, surface);
  add_circle(to, frame, color, surface);
  join_circles(frame, surface);
}

void add_ball(const Vec3d& center, double radius, const Frame& frame, Bytes4 color, DrawSurface& surface) {
  const int bands = std::max(3, frame.sides / 4);
  for (int i = 0; i < bands; ++i) {
    const auto circle = [&](int k) {
      const double angle = std::numbers::pi * k / bands;
      const double lean = -std::cos(angle);
      return Circle{center + frame.axis * (radius * lean), radius * std::sin(angle), lean};
    };
    add_band(circle(i), circle(i + 1), frame, color, surface);
  }
}

}  // namespace

void add_arrow(const Arrow& arrow, const Placement& placement, DrawSurface& surface, int sides) {
  const Vec3d from = placement.apply(arrow.from);
  const Vec3d to = placement.apply(arrow.to);
  const double length = norm(to - from);
  const double radius = arrow.radius * placement.scale;
  if (!(length > 0) || !(radius > 0) || !std::isfinite(length + radius)) return;
  const Frame frame = frame_along(to - from, sides);
  const Bytes4 color = to_bytes(arrow.color);
  const double head = std::min(0.6 * length, 6 * radius);
  const double head_radius = 2.4 * radius * head / (6 * radius);
  const double shaft_radius = std::min(radius, head_radius / 1.8);
  const Vec3d neck = to - frame.axis * head;
  const double lean = head_radius / std::hypot(head, head_radius);
  add_band({from, 0, -1}, {from, shaft_radius, -1}, frame, color, surface);
  add_band({from, shaft_radius, 0}, {neck, shaft_radius, 0}, frame, color, surface);
  add_band({neck, shaft_radius, -1}, {neck, head_radius, -1}, frame, color, surface);
  add_band({neck, head_radius, lean}, {to, 0, lean}, frame, color, surface);
}

void add_line(const Line& line, const Placement& placement, DrawSurface& surface, int sides) {
  const double radius = line.radius * placement.scale;
  const std::size_t count = line.points.size();
  if (!(radius > 0) || !std::isfinite(radius) || count < 2) return;
  const Bytes4 color = to_bytes(line.color);
  const std::size_t pieces = line.closed ? count : count - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Vec3d from = placement.apply(line.points[i]);
    const Vec3d to = placement.apply(line.points[(i + 1) % count]);
    const double length = norm(to - from);
    if (!(length > 0) || !std::isfinite(length)) continue;
    const Frame frame = frame_along(to - from, sides);
    add_band({from, radius, 0}, {to, radius, 0}, frame, color, surface);
    add_ball(from, radius, frame, color, surface);
    if (!line.closed && i + 1 == pieces) add_ball(to, radius, frame, color, surface);
  }
}

}  // namespace knead::render
