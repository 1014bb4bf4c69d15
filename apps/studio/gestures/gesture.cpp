// The choice of the gesture that begins, functions for all gestures, and the gizmo.
#include "gestures/gesture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "gestures/gesture_kinds.h"
#include "gestures/tools.h"
#include "knead/vec.h"

namespace knead::studio {

namespace {

// The pointer grabs a stamp well within the rings of its gizmo.
constexpr double kStampReach = 35;  // points
constexpr const char* kNoImages =
    " takes the whole shape along, so it has no mirror image: switch the mirror and repetitions off first.";
constexpr double kSameImage = 1e-9;  // of the radius: images that differ by less are one
constexpr double kArrow = 90;        // points, of the length of an arrow
constexpr double kRing = 0.7;        // radius of a ring, in arrows
constexpr double kGizmoReach = 9;    // points within which a part is hit
constexpr double kCenterReach = 12;
constexpr int kRingPoints = 48;
constexpr std::array<render::Color, 3> kColors{
    {{0.80f, 0.22f, 0.20f, 1}, {0.30f, 0.62f, 0.22f, 1}, {0.22f, 0.40f, 0.85f, 1}}};

Gesture in_trouble(std::string what) {
  Gesture gesture;
  gesture.kind = LassoGesture{};
  gesture.trouble = std::move(what);
  return gesture;
}

template <class G>
std::optional<Gesture> made(std::optional<G> gesture) {
  if (!gesture) return std::nullopt;
  return Gesture{std::move(*gesture)};
}

bool is_on_stamp(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  if (around.settings.tool->use != ToolUse::stamp || !placed.stamp || !placed.placement) return false;
  const auto middle = pixel_of(around.screen, placed.placement->center);
  return middle && std::hypot(middle->x - pointer.x, middle->y - pointer.y) <= kStampReach * around.screen.unit;
}

std::optional<Gesture> begin_placed(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  if (placed.placement) {
    if (is_on_stamp(pointer, around, placed)) return Gesture{begin_stamp(pointer, around, placed)};
    const auto part = gizmo_part_at(around.screen, *placed.placement, pointer.x, pointer.y);
    if (part) return Gesture{GizmoGesture{*part, *placed.placement, pointer}};
  }
  return Gesture{TurnGesture{pointer, placed.placement}};
}

// Begins a gesture beside the pins, for a pose without exact pins.
std::optional<Gesture> begin_pose(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  const PoseMode mode = around.settings.pose;
  const bool has_ctrl = pointer.modifiers.ctrl;
  const std::optional<std::size_t>& selected = placed.parts.selected;
  const bool is_on_selected = mode == PoseMode::lasso && selected && part_at(pointer, around, placed.parts) == selected;
  const bool moves = mode == PoseMode::pins || is_on_selected || is_on_part_gizmo(pointer, around, placed);
  if (moves && !has_ctrl) return made(begin_part(pointer, around, placed));
  if (mode == PoseMode::brush) return made(begin_part_paint(pointer, around, placed));
  return Gesture{LassoGesture{{{pointer.x, pointer.y}}, false, mode == PoseMode::lasso && has_ctrl}};
}

std::optional<Gesture> begin_any_pins(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  if (!has_exact_pins(around.settings) && !pin_at(pointer, around, placed.pins)) {
    const bool is_lasso_of_pins =
        around.settings.lasso_selects && around.settings.pose == PoseMode::pins && !pointer.modifiers.ctrl;
    std::optional<Gesture> gesture = is_lasso_of_pins ? std::nullopt : begin_pose(pointer, around, placed);
    if (gesture || around.settings.pose != PoseMode::pins) return gesture;
  }
  const bool selects = !pointer.modifiers.ctrl && around.settings.lasso_selects;
  if ((pointer.modifiers.ctrl || selects) && !pin_at(pointer, around, placed.pins)) {
    return Gesture{LassoGesture{{{pointer.x, pointer.y}}, selects}};
  }
  return made(begin_pins(pointer, around, placed));
}

std::optional<Gesture> begin_by_tool(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  const ToolUse use = around.settings.tool->use;
  const bool takes_all = use == ToolUse::bend_along || use == ToolUse::lattice;
  if (takes_all && !images_of(around.settings).empty()) return in_trouble(around.settings.tool->name + kNoImages);
  if (use == ToolUse::lattice && is_on_placed(pointer, around, placed)) return begin_lattice(pointer, around, placed);
  if (pointer.modifiers.shift || around.settings.tool->use == ToolUse::smooth) {
    if (around.state.mesh->face_count() == 0) return in_trouble("A point cloud has no surface to smooth.");
    return made(begin_relax(pointer, around));
  }
  switch (around.settings.tool->use) {
    case ToolUse::pull:
      return Gesture{begin_implicit(pointer, around)};
    case ToolUse::paint:
      return Gesture{begin_paint(pointer, around)};
    case ToolUse::inflate:
      if (around.state.mesh->face_count() == 0) return in_trouble("A point cloud has no surface to inflate.");
      return made(begin_inflate(pointer, around));
    case ToolUse::print:
      if (around.state.mesh->face_count() == 0) return in_trouble("A point cloud has no surface to print on.");
      return made(begin_print(pointer, around, placed));
    case ToolUse::points:
    case ToolUse::curve:
      if (is_near(placed, pointer, around)) return Gesture{begin_points(pointer, around, placed)};
      return made(begin_draw(pointer, around));
    case ToolUse::bend_along:
      return made(begin_bend_along(pointer, around, placed));
    case ToolUse::lattice:
      return begin_lattice(pointer, around, placed);
    case ToolUse::pose:
      return begin_any_pins(pointer, around, placed);
    case ToolUse::stamp:
    case ToolUse::turn:
      return begin_placed(pointer, around, placed);
    case ToolUse::smooth:  // above
    case ToolUse::mask:    // changes no shape: StudioMasks
      break;
  }
  return std::nullopt;
}

// The strokes of a gesture without added images, and whether they already contain their images.
struct OwnStrokes {
  std::vector<Stroke> strokes{};
  bool has_images = false;
};

template <class G>
constexpr bool kHasImagesAlready = false;
template <class G>
requires G::kHasImages constexpr bool kHasImagesAlready<G> = true;

template <class G>
OwnStrokes own_strokes_of(const G& gesture, const ShapeState& start, const ToolSettings& settings) {
  if constexpr (requires { gesture.strokes(); }) return {gesture.strokes()};
  if constexpr (requires { gesture.strokes(start, settings); }) {
    return {gesture.strokes(start, settings), kHasImagesAlready<G>};
  }
  return {};
}

OwnStrokes own_strokes_of(const Gesture& gesture, const ToolSettings& settings) {
  if (!gesture.trouble.empty()) return {};
  return std::visit([&](const auto& own) { return own_strokes_of(own, gesture.start, settings); }, gesture.kind);
}

std::vector<Stroke> with_all_images(OwnStrokes own, const ToolSettings& settings, const ImageFile& image_file) {
  if (own.has_images) return std::move(own.strokes);
  return symmetric_strokes(own.strokes, images_of(settings), kSameImage * settings.radius, image_file);
}

std::array<Vec3d, 3> axes(const Placement& p) { return {p.x, p.y, p.z}; }

double distance_to_segment(const Pixel& p, const Pixel& a, const Pixel& b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  const double t = length2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0;
  return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

// Returns the distance in pixels; infinite if the polyline is not visible.
double distance_to_line(const Screen& screen, const std::vector<Vec3d>& points, const Pixel& p) {
  double least = kInfinity;
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

bool is_on_placed(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  const ToolUse use = around.settings.tool->use;
  if (use == ToolUse::points || use == ToolUse::curve) return is_near(placed, pointer, around);
  if (use == ToolUse::bend_along) return handle_at(pointer, around.screen, placed.line, placed.line_stride).has_value();
  if (use == ToolUse::lattice) {
    return control_point_at(pointer, around.screen, control_points(placed.lattice.stroke)).has_value();
  }
  if (use != ToolUse::stamp && use != ToolUse::turn) return false;
  if (is_on_stamp(pointer, around, placed)) return true;
  return placed.placement && gizmo_part_at(around.screen, *placed.placement, pointer.x, pointer.y);
}

std::optional<Gesture> begin_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  std::optional<Gesture> gesture = begin_by_tool(pointer, around, placed);
  if (gesture) gesture->start = around.state;
  return gesture;
}

void move_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture) {
  if (!gesture.trouble.empty()) return;
  std::visit([&](auto& own) { own.move({pointer, around, placed}); }, gesture.kind);
}

void end_gesture(const Pointer& pointer, const GestureContext& around, PlacedTools& placed, Gesture& gesture) {
  move_gesture(pointer, around, placed, gesture);
  if (!gesture.trouble.empty()) return;
  const GestureStep step{pointer, around, placed};
  std::visit(
      [&](auto& own) {
        if constexpr (requires { own.end(step); }) own.end(step);
      },
      gesture.kind);
}

std::vector<SessionStroke> lines_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file) {
  OwnStrokes own = own_strokes_of(gesture, settings);
  const auto is_sum = [](const Stroke& stroke) { return !tool_of(stroke).is_event; };
  std::optional<Mirror> mirror;
  if (!own.has_images && std::all_of(own.strokes.begin(), own.strokes.end(), is_sum)) mirror = mirror_of(settings);
  std::vector<Stroke> strokes = mirror ? std::move(own.strokes) : with_all_images(std::move(own), settings, image_file);
  std::vector<SessionStroke> lines;
  for (Stroke& stroke : strokes) {
    lines.push_back({std::move(stroke)});
    if (mirror) lines.back().mirror = *mirror;
  }
  return lines;
}

std::vector<Stroke> strokes_of(const Gesture& gesture, const ToolSettings& settings, const ImageFile& image_file) {
  return with_all_images(own_strokes_of(gesture, settings), settings, image_file);
}

std::optional<Amount> amount_of(const Gesture& gesture, const ToolSettings& settings) {
  if (!gesture.trouble.empty()) return std::nullopt;
  return std::visit(
      [&](const auto& own) -> std::optional<Amount> {
        if constexpr (requires { own.number(); }) return own.number();
        if constexpr (requires { own.number(settings); }) return own.number(settings);
        return std::nullopt;
      },
      gesture.kind);
}

const Drag* drag_of(const Gesture& gesture) {
  return std::visit(
      [](const auto& own) -> const Drag* {
        if constexpr (requires { own.drag; }) return &own.drag;
        return nullptr;
      },
      gesture.kind);
}

bool* rests_of(Gesture& gesture) {
  return std::visit(
      [](auto& own) -> bool* {
        if constexpr (requires { own.rests; }) return &own.rests;
        return nullptr;
      },
      gesture.kind);
}

double angle_round(const Screen& screen, const Vec3d& center, const Vec3d& axis, const Pixel& from, const Pixel& to) {
  const auto middle = pixel_of(screen, center);
  if (!middle) return 0;
  const double before = std::atan2(from.y - middle->y, from.x - middle->x);
  const double after = std::atan2(to.y - middle->y, to.x - middle->x);
  const Vec3d to_eye = -ray_through(screen, middle->x, middle->y).direction;
  return std::remainder(before - after, 2 * std::numbers::pi) * (dot(axis, to_eye) >= 0 ? 1 : -1);
}

double gizmo_size(const Screen& screen, const Placement& placement) {
  return kArrow * point_size(screen, placement.center);
}

std::optional<GizmoPart> gizmo_part_at(const Screen& screen, const Placement& placement, double x, double y) {
  const Pixel at{x, y};
  const auto middle = pixel_of(screen, placement.center);
  if (!middle) return std::nullopt;
  if (std::hypot(middle->x - x, middle->y - y) <= kCenterReach * screen.unit) return GizmoPart::center;
  constexpr std::array<GizmoPart, 3> movers{GizmoPart::move_x, GizmoPart::move_y, GizmoPart::move_z};
  constexpr std::array<GizmoPart, 3> turners{GizmoPart::turn_x, GizmoPart::turn_y, GizmoPart::turn_z};
  const double size = gizmo_size(screen, placement);
  std::optional<GizmoPart> best;
  double least = kGizmoReach * screen.unit;
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
