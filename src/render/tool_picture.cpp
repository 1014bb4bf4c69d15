// Draws tools in scenes: rods and arrows as triangles, and the regions, motions and paths of strokes.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

#include "field/grid.h"
#include "flow/curve_map.h"
#include "knead/editor/render.h"
#include "render/surface.h"

namespace knead::render {
namespace {

// A circle of vertices to be joined to others.
struct Circle {
  Vec3d center;
  double radius = 0;
  double lean = 0;  // the normal's component along the axis: 0 for a cylinder, -1 for a cap that faces back
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

constexpr Color kCylinderGrey{0.45f, 0.47f, 0.50f, 0.12f};
constexpr Color kGridGrey{0.45f, 0.47f, 0.50f, 1};
constexpr Color kStampBlue{0.25f, 0.42f, 0.72f, 0.42f};
constexpr Color kPinRed{0.80f, 0.16f, 0.12f, 0.9f};
constexpr Color kHeldBlue{0.25f, 0.42f, 0.72f, 0.9f};
constexpr double kPinSize = 0.016;    // of the shape's
constexpr double kEndOpacity = 0.45;  // of the tool at the end of its path, relative to that at the start

// The scene, and the options of drawing.
struct Canvas {
  Scene& scene;
  const Box& around;
  const ToolDrawing& how;
};

// Draws the arrows of one field.
struct Sketch {
  Scene& scene;
  const Field& field;
  double size;    // a typical length of the tool
  double radius;  // of arrows

  void arrow(const Vec3d& from, const Vec3d& to) const {
    scene.arrows.push_back({.from = from, .to = to, .radius = radius});
  }
  void line(std::vector<Vec3d> points) const {
    scene.lines.push_back({.points = std::move(points), .radius = 0.5 * radius});
  }

  // Draws the axis, and an arc around it by the angle, at most once, with an arrow head.
  void turn(const Vec3d& axis, double angle, double height) const {
    const Vec3d middle = field.center + axis * height;
    line({field.center - axis * (1.2 * size), field.center + axis * (1.2 * size)});
    const double most = 1.8 * std::numbers::pi;
    const double shown = std::clamp(angle, -most, most);
    const Vec3d start = arc_start(axis) * (0.8 * size);
    std::vector<Vec3d> points;
    constexpr int pieces = 48;
    for (int i = 0; i <= pieces; ++i) {
      points.push_back(middle + rotate(start, axis, sincos(shown * i / pieces)));
    }
    const Vec3d tip = points.back();
    const Vec3d along = cross(axis, tip - middle) * std::copysign(1.0, shown);
    line(std::move(points));
    if (norm(along) > 0) arrow(tip, tip + normalized(along) * (6 * radius));
  }

  // Returns the beginning of the arc: on the inner side of a half-space, which turns.
  Vec3d arc_start(const Vec3d& axis) const {
    if (const auto* region = std::get_if<HalfSpace<double>>(&field.region)) {
      const Vec3d across = region->normal - axis * dot(axis, region->normal);
      if (norm(across) > 1e-6) return -normalized(across);
    }
    return any_orthogonal(axis);
  }

  void operator()(const Translation<double>& motion) const {
    const double speed = norm(motion.velocity);
    if (!(speed > 0)) return;
    arrow(field.center, field.center + motion.velocity * std::max(1.0, 0.5 * size / speed));
  }
  void operator()(const Rotation<double>& motion) const { turn(motion.axis, motion.rate, 0); }
  void operator()(const Twist<double>& motion) const {
    const Thresholds<double>& r = field.thresholds;
    const double height = r.inner < 0 ? r.inner : r.inner - 0.5 * (r.outer - r.inner);
    turn(motion.axis, motion.rate * height, height);
  }
  // M = k (a a^T - (I - a a^T) / 2): |M|^2 = 3/2 k^2 and det M = k^3 / 4 give k, the longest column of a a^T gives a.
  void operator()(const Strain<double>& motion) const {
    const Mat3d& m = motion.matrix;
    const double square = norm2(m.row0) + norm2(m.row1) + norm2(m.row2);
    if (!(square > 0)) return;
    const double k = std::copysign(std::sqrt(square / 1.5), determinant(m));
    const Mat3d projector = (m + Mat3d{} * (k / 2)) * (1 / (1.5 * k));
    Vec3d longest = projector.row0;
    for (const Vec3d& row : {projector.row1, projector.row2}) {
      if (norm2(row) > norm2(longest)) longest = row;
    }
    for (const double side : {-1.0, 1.0}) {
      const Vec3d end = field.center + normalized(longest) * (side * 1.2 * size);
      const Vec3d start = field.center + normalized(longest) * (side * 0.3 * size);
      k > 0 ? arrow(start, end) : arrow(end, start);
    }
  }
  void operator()(const CustomMotion& /*motion*/) const {}
};

// Returns a size for arrows. That of a half-space is its zone's width, limited by the shape's size.
double tool_size(const Field& field, const std::optional<LimitCylinder>& limit_cylinder, const Box& around) {
  if (limit_cylinder) return limit_cylinder->radius;
  if (std::holds_alternative<Handles<double>>(field.region)) return 0.1 * around.diagonal();
  const Thresholds<double>& r = field.thresholds;
  if (r.falloff == kWideFalloff) return r.bump;
  if (!std::holds_alternative<HalfSpace<double>>(field.region)) return r.outer;
  return std::min(r.outer - r.inner, 0.3 * around.diagonal());
}

Color fainter(Color color, double opacity) {
  color.alpha = static_cast<float>(color.alpha * opacity);
  return color;
}

Mesh surface_of(const Field& field, double level, const std::optional<LimitCylinder>& limit_cylinder,
                const Canvas& canvas) {
  const ToolDrawing& how = canvas.how;
  if (how.cache != nullptr && level > 0 && std::holds_alternative<PointSet<double>>(field.region)) {
    return how.cache->surface(field, level, how.detail);
  }
  return region_surface(field, field.center, level, canvas.around, limit_cylinder, how.detail);
}

// Draws small balls at the pins, because their supports overlap.
void draw_pins(const Segment& segment, double opacity, const Canvas& canvas) {
  const double radius = kPinSize * canvas.around.diagonal();
  for (const Field& pin : segment.fields) {
    const bool is_held = displacement_of(segment, pin) == Vec3d{0, 0, 0};
    canvas.scene.surfaces.push_back(
        {surface_of(pin, radius, segment.limit_cylinder, canvas), fainter(is_held ? kHeldBlue : kPinRed, opacity)});
  }
}

// Draws the box of a grid's nodes in use, with thin lines.
void draw_grid(const PotentialGrid& grid, const Canvas& canvas) {
  const Box box = detail::box_in_use(grid);
  if (box.empty()) return;
  const double radius = 0.001 * canvas.around.diagonal();
  const auto add = [&](std::vector<Vec3d> points) {
    canvas.scene.lines.push_back({std::move(points), radius, false, kGridGrey});
  };
  const auto& [a, b] = box;
  for (const double z : {a.z, b.z}) add({{a.x, a.y, z}, {b.x, a.y, z}, {b.x, b.y, z}, {a.x, b.y, z}, {a.x, a.y, z}});
  for (const double x : {a.x, b.x}) {
    for (const double y : {a.y, b.y}) add({{x, y, a.z}, {x, y, b.z}});
  }
}

// Draws a curve before and after.
void draw_curve(const CurveMotion& curve, const Canvas& canvas) {
  constexpr int kPieces = 200;
  for (const double time : {0.0, 1.0}) {
    const detail::CurveTable<double> table(curve, time);
    std::vector<Vec3d> points;
    for (int i = 0; i <= kPieces; ++i) {
      Vec3d x;
      table.place({curve.length * i / kPieces, {0, 0}}, x);
      points.push_back(curve.place + x);
    }
    canvas.scene.lines.push_back(
        {std::move(points), 0.003 * canvas.around.diagonal(), false, time == 0 ? kGridGrey : kOuterGreen});
  }
}

// Draws the regions of all fields at the segment's beginning.
void draw_regions(const Segment& segment, double opacity, const Canvas& canvas) {
  for (const Segment& part : segment.parts) draw_regions(part, opacity, canvas);
  if (segment.time_law == TimeLaw::pinned) return draw_pins(segment, opacity, canvas);
  if (!segment.grid.is_empty()) return draw_grid(segment.grid, canvas);
  if (!segment.curve.is_empty()) return draw_curve(segment.curve, canvas);
  for (const Field& field : segment.fields) {
    const auto add = [&](double level, const Color& color) {
      canvas.scene.surfaces.push_back(
          {surface_of(field, level, segment.limit_cylinder, canvas), fainter(color, opacity)});
    };
    const bool wide = field.thresholds.falloff == kWideFalloff;
    add(wide ? field.thresholds.bump : field.thresholds.inner, kInnerRed);
    add(field.thresholds.outer, kOuterGreen);
  }
}

void draw_start(const Segment& segment, const Canvas& canvas) {
  draw_regions(segment, 1, canvas);
  for (const Field& field : segment.fields) {
    const bool is_plane = std::holds_alternative<HalfSpace<double>>(field.region);
    if (segment.limit_cylinder && is_plane) {
      canvas.scene.surfaces.push_back(
          {limit_cylinder_surface(*segment.limit_cylinder, field, canvas.around, canvas.how.detail), kCylinderGrey});
    }
    const bool is_pin = segment.time_law == TimeLaw::pinned;  // whose arrow ends at its target
    const Sketch sketch{canvas.scene, field, is_pin ? 0 : tool_size(field, segment.limit_cylinder, canvas.around),
                        0.006 * canvas.around.diagonal()};
    std::visit(sketch, field.motion);
  }
}

// Draws a line through the places of each field, if all segments have the same fields.
void draw_path(const Flow& stroke, const Canvas& canvas) {
  const std::size_t count = stroke.segments.front().fields.size();
  for (std::size_t i = 0; i < count; ++i) {
    Line path{.points = {}, .radius = 0.003 * canvas.around.diagonal()};
    for (const Segment& segment : stroke.segments) {
      if (segment.fields.size() != count) return;
      path.points.push_back(segment.fields[i].center);
    }
    const Segment& last = stroke.segments.back();
    path.points.push_back(last.fields[i].center + displacement_of(last, last.fields[i]));
    if (path.points.front() == path.points.back()) continue;  // held
    canvas.scene.lines.push_back(std::move(path));
  }
}

// The sets of marked regions at the time t: the full one has turned, the zero one stays behind.
void move_sets(Handles<double>& region, double t) {
  for (Vec3d& p : region.full.points) p = rotate(p, region.turn_axis, sincos(t * region.turn_angle));
  for (Vec3d& p : region.zero.points) p = p - region.sweep * t;
}

// Returns the segment's fields at its time t. The motion of a tool that travels is the rest of its path.
Segment at_time(const Segment& segment, double t) {
  Segment now = segment;
  for (Segment& part : now.parts) part = at_time(part, t);
  for (Field& field : now.fields) {
    const Vec3d by = displacement_of(segment, field);
    field.center += by * t;
    auto* motion = std::get_if<Translation<double>>(&field.motion);
    if (motion != nullptr && by != Vec3d{0, 0, 0}) motion->velocity = motion->velocity * (1 - t);
    if (auto* plane = std::get_if<HalfSpace<double>>(&field.region)) plane->normal = normal_at(*plane, t);
    if (auto* sets = std::get_if<Handles<double>>(&field.region)) move_sets(*sets, t);
  }
  return now;
}

bool moves(const Flow& stroke) {
  const Segment& last = stroke.segments.back();
  return stroke.segments.size() > 1 || std::any_of(last.fields.begin(), last.fields.end(), [&](const Field& field) {
           return displacement_of(last, field) != Vec3d{0, 0, 0};
         });
}

void draw_whole_path(const Flow& stroke, const Canvas& canvas) {
  draw_start(stroke.segments.front(), canvas);
  if (!moves(stroke) || stroke.segments.back().time_law == TimeLaw::pinned) return;  // pins have arrows
  draw_regions(at_time(stroke.segments.back(), 1), kEndOpacity, canvas);
  draw_path(stroke, canvas);
}

// Returns the segment at that moment, with its fields at their places.
Segment segment_at(const Flow& stroke, double moment) {
  const auto index = std::min(static_cast<std::size_t>(moment), stroke.segments.size() - 1);
  return at_time(stroke.segments[index], std::min(moment - static_cast<double>(index), 1.0));
}

// Returns the displacement after the moment. The steps of a stamp without contact are not in its flow, and count as its
// first ones.
Vec3d displacement_after(const Flow& stroke, double moment) {
  Vec3d sum{};
  for (std::size_t i = 0; i < stroke.segments.size(); ++i) {
    const double done = std::clamp(moment - static_cast<double>(i), 0.0, 1.0);
    const Segment& segment = stroke.segments[i];
    sum += (segment.parts.empty() ? segment : segment.parts.front()).displacement * (1 - done);
  }
  return sum;
}

void draw_stamp(const DrawnTool& tool, const Canvas& canvas) {
  const StampTool& stamp = *tool.stamp;
  const double moment = tool.moment.value_or(0);
  Vec3d place = stamp.path.front();
  if (moment > 0) place = stamp.path.back() - displacement_after(tool.stroke, moment);
  TranslucentSurface surface{stamp.mesh, kStampBlue};
  for (Vec3d& p : surface.mesh.positions) p += place;
  canvas.scene.surfaces.push_back(std::move(surface));
  if (moment > 0 && !tool.stroke.segments.empty()) {
    draw_regions(segment_at(tool.stroke, moment), 1, canvas);
    return;
  }
  const double radius = 0.006 * canvas.around.diagonal();
  const Vec3d last = stamp.path[stamp.path.size() - 2];
  canvas.scene.lines.push_back({.points = {stamp.path.begin(), stamp.path.end() - 1}, .radius = 0.5 * radius});
  canvas.scene.arrows.push_back({.from = last, .to = stamp.path.back(), .radius = radius});
}

// Returns the flows of the stroke and of each of its images, which are the parts of sums.
std::vector<Flow> images_of(const Flow& stroke) {
  std::size_t count = 1;
  for (const Segment& segment : stroke.segments) count = std::max(count, segment.parts.size());
  std::vector<Flow> images(count);
  for (const Segment& segment : stroke.segments) {
    for (std::size_t k = 0; k < count; ++k) {
      images[k].segments.push_back(k < segment.parts.size() ? segment.parts[k] : segment);
      if (!segment.parts.empty() && k >= segment.parts.size()) images[k].segments.back() = segment.parts.front();
    }
  }
  return images;
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
    if (!line.round) continue;
    add_ball(from, radius, frame, color, surface);
    if (!line.closed && i + 1 == pieces) add_ball(to, radius, frame, color, surface);
  }
}

void draw_tool(const DrawnTool& tool, const Box& around, Scene& scene, const ToolDrawing& how) {
  const Canvas canvas{scene, around, how};
  if (tool.stamp) return draw_stamp(tool, canvas);
  if (tool.stroke.segments.empty()) return;
  if (const std::vector<Flow> images = images_of(tool.stroke); images.size() > 1) {
    for (const Flow& image : images) draw_tool({image, std::nullopt, tool.moment}, around, scene, how);
    return;
  }
  if (!tool.moment) return draw_whole_path(tool.stroke, canvas);
  draw_start(segment_at(tool.stroke, *tool.moment), canvas);
  if (moves(tool.stroke)) draw_path(tool.stroke, canvas);
}

}  // namespace knead::render
