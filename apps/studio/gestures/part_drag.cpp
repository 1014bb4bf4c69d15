// Parts of a pose: drawn round, painted, and moved.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "gestures/gesture_kinds.h"
#include "gestures/parts.h"
#include "knead/tools.h"

namespace knead::studio {

namespace {

constexpr double kBrush = 0.5;  // of the radius
constexpr double kShaft = 68;   // pixels of an arrow

// The corner of the triangle that is nearest to the hit.
std::uint32_t vertex_at(const SurfaceHit& hit, const GestureContext& around) {
  const Triangle& corners = around.picker->triangles()[hit.triangle];
  const auto distance = [&](std::uint32_t v) { return norm2(around.state.positions[v] - hit.point); };
  return *std::min_element(corners.begin(), corners.end(),
                           [&](std::uint32_t a, std::uint32_t b) { return distance(a) < distance(b); });
}

Vec3d forward_of(const GestureContext& around) { return render::camera_frame(around.screen.camera).forward; }

std::optional<GizmoPart> gizmo_at(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  if (!placed.parts.placement) return std::nullopt;
  const Placement& at = *placed.parts.placement;
  const auto handle = gizmo_part_at(around.screen, at, pointer.x, pointer.y);
  const bool is_arrow = handle && !turns(*handle) && *handle != GizmoPart::center;
  const auto middle = pixel_of(around.screen, at.center);
  // One arrow lies along the limb, which can be taken hold of there: only its end is the arrow.
  const bool is_shaft = is_arrow && middle && std::hypot(middle->x - pointer.x, middle->y - pointer.y) < kShaft;
  return is_shaft ? std::nullopt : handle;
}

// The shortest rotation about the joint that takes the grabbed place towards the pointer, in the plane of the view. A
// number, typed or snapped, is its angle.
void turn_about_joint(const Pointer& pointer, const GestureContext& around, PartGesture& gesture) {
  const Vec3d& joint = gesture.parts.placement->center;
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  const Vec3d arm = gesture.grabbed - joint;
  const Vec3d goal = on_plane(ray, gesture.grabbed, forward_of(around)).value_or(gesture.grabbed) - joint;
  const Vec3d axis = cross(arm, goal);
  gesture.motion.center = joint;
  gesture.motion.axis = norm(axis) > 0 ? normalized(axis) : -forward_of(around);
  const double angle = std::atan2(norm(axis), dot(arm, goal)) * 180 / std::numbers::pi;
  gesture.amount = pointer.typed.value_or(snapped(angle, kSnapDegrees, pointer));
  gesture.motion.angle_deg = gesture.amount;
}

void drag_gizmo(const Pointer& pointer, const GestureContext& around, PartGesture& gesture) {
  const Placement& start = *gesture.parts.placement;
  const Pixel from{gesture.from.x, gesture.from.y};
  const Pixel to{pointer.x, pointer.y};
  const GizmoPart handle = *gesture.handle;
  gesture.motion = {start.center};
  if (handle == GizmoPart::center) {
    gesture.motion.translation = center_dragged(around.screen, start, from, to).center - start.center;
    return;
  }
  const double step = turns(handle) ? kSnapDegrees : around.snap;
  gesture.amount = pointer.typed.value_or(snapped(dragged_by(around.screen, start, handle, from, to), step, pointer));
  gesture.motion.axis = axis_of(start, handle);
  if (turns(handle)) {
    gesture.motion.angle_deg = gesture.amount;
  } else {
    gesture.motion.translation = gesture.motion.axis * gesture.amount;
  }
}

// Joints that no longer bend hold again, with the part that holds most of the body.
void mark_rest(const std::vector<std::uint32_t>& body, const ShapeState& state, PartMarks& parts) {
  std::vector<std::size_t> counts(parts.holds.size());
  std::vector<std::uint32_t> rest;
  for (const std::uint32_t v : body) {
    const std::optional<std::size_t> part = part_of(parts, v);
    if (part) {
      ++counts[*part];
    } else {
      rest.push_back(v);
    }
  }
  const auto most = static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  if (counts[most] > 0) mark(rest, most, state, parts);
}

}  // namespace

Placement moved(const Placement& placement, const PartMotion& motion) {
  Placement result = placement;
  const RigidMotion turn = rotation_about(motion.center, motion.axis, motion.angle_deg * std::numbers::pi / 180);
  result.center = turn(placement.center) + motion.translation;
  for (Vec3d* axis : {&result.x, &result.y, &result.z}) *axis = turn.turn * *axis;
  return result;
}

std::optional<std::size_t> part_at(const Pointer& pointer, const GestureContext& around, const PartMarks& parts) {
  if (around.picker == nullptr || parts.of_vertex.empty()) return std::nullopt;
  const auto hit = around.picker->pick(ray_through(around.screen, pointer.x, pointer.y), around.state);
  return hit ? part_of(parts, vertex_at(*hit, around)) : std::nullopt;
}

bool is_on_part_gizmo(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  return gizmo_at(pointer, around, placed).has_value();
}

std::string add_limb(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  const auto hit = hit_at(pointer, around);
  if (!hit || around.picker == nullptr) return "Double click on a finger, an arm or a leg of the shape.";
  const std::vector<Vec3d> positions = around.state.positions.copy();
  const Limb limb = find_limb(positions, around.picker->triangles(), vertex_at(*hit, around));
  if (limb.vertices.empty() || limb.body.empty()) {
    return "Studio finds no finger, arm or leg here; draw a line round a part of the shape instead.";
  }
  PartMarks& parts = placed.parts;
  const bool has_body = std::find(parts.holds.begin(), parts.holds.end(), true) != parts.holds.end() ||
                        std::any_of(placed.pins.begin(), placed.pins.end(), [](const Pin& pin) { return pin.holds; });
  if (!has_body) {
    add_part(limb.body, around.state, parts);
  } else if (!parts.of_vertex.empty()) {
    mark_rest(limb.body, around.state, parts);
    mark(limb.bending, std::nullopt, around.state, parts);
  }
  add_part(limb.vertices, around.state, parts);
  return {};
}

std::optional<PartGesture> begin_part(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  PartGesture gesture;
  gesture.from = pointer;
  gesture.handle = gizmo_at(pointer, around, placed);
  if (!gesture.handle) {
    const std::optional<std::size_t> part = part_at(pointer, around, placed.parts);
    if (!part) return std::nullopt;
    select_part(part, placed.parts);
  }
  const auto hit = hit_at(pointer, around);
  if (hit) gesture.grabbed = hit->point;
  if (!placed.parts.placement) return std::nullopt;
  gesture.parts = placed.parts;
  gesture.pins = placed.pins;
  gesture.plan = plan_pose(gesture, around.state, around.settings);
  return gesture;
}

void move_part(const Pointer& pointer, const GestureContext& around, PartGesture& gesture) {
  const bool is_click = std::hypot(pointer.x - gesture.from.x, pointer.y - gesture.from.y) < kClick;
  gesture.has_gone = gesture.has_gone || !is_click || pointer.typed;
  gesture.rests = false;
  if (!gesture.has_gone) return;
  if (gesture.handle) {
    drag_gizmo(pointer, around, gesture);
  } else {
    turn_about_joint(pointer, around, gesture);
  }
}

namespace {

bool is_seen(std::uint32_t vertex, const GestureContext& around) {
  const Vec3d place = around.state.positions[vertex];
  const auto pixel = pixel_of(around.screen, place);
  const auto hit = around.picker->pick(ray_through(around.screen, pixel->x, pixel->y), around.state);
  return hit && norm(hit->point - place) < 2 * pixel_size(around.screen, place);
}

// Drops the pieces of which nothing is seen: what lies behind others is not meant. A piece hangs together by triangles.
void drop_hidden(const GestureContext& around, std::vector<std::uint32_t>& vertices) {
  if (around.picker == nullptr) return;
  constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> parent(around.state.positions.size(), kNone);
  for (const std::uint32_t v : vertices) parent[v] = v;
  const auto root_of = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : around.picker->triangles()) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      if (parent[a] != kNone && parent[b] != kNone) parent[root_of(a)] = root_of(b);
    }
  }
  constexpr std::uint32_t kLookedAt = 500;             // vertices of a piece, about
  std::vector<std::uint32_t> sizes(parent.size(), 0);  // by roots, as the others
  for (const std::uint32_t v : vertices) ++sizes[root_of(v)];
  std::vector<std::uint32_t> passed(parent.size(), 0);
  std::vector<bool> is_shown(parent.size(), false);
  for (const std::uint32_t v : vertices) {
    const std::uint32_t piece = root_of(v);
    const bool is_due = passed[piece]++ % (sizes[piece] / kLookedAt + 1) == 0;
    if (is_due && !is_shown[piece]) is_shown[piece] = is_seen(v, around);
  }
  std::erase_if(vertices, [&](std::uint32_t v) { return !is_shown[root_of(v)]; });
}

}  // namespace

void end_part_lasso(const Pointer& pointer, const GestureContext& around, const LassoGesture& gesture,
                    PlacedTools& placed) {
  if (gesture.line.size() < 3) return select_part(part_at(pointer, around, placed.parts), placed.parts);
  std::vector<std::uint32_t> within;
  for (std::uint32_t v = 0; v < around.state.positions.size(); ++v) {
    const auto pixel = pixel_of(around.screen, around.state.positions[v]);
    if (pixel && is_within(gesture.line, *pixel)) within.push_back(v);
  }
  drop_hidden(around, within);
  if (gesture.handle != 0) {
    add_part(within, around.state, placed.parts);
  } else if (!placed.parts.of_vertex.empty()) {
    mark(within, std::nullopt, around.state, placed.parts);
    remove_empty_parts(placed.parts);
  }
}

namespace {

std::vector<std::uint32_t> under_brush(const Pointer& pointer, const GestureContext& around) {
  std::vector<std::uint32_t> vertices;
  const auto hit = hit_at(pointer, around);
  const double reach2 = std::pow(kBrush * around.settings.radius, 2);
  for (std::uint32_t v = 0; hit && v < around.state.positions.size(); ++v) {
    if (norm2(around.state.positions[v] - hit->point) <= reach2) vertices.push_back(v);
  }
  return vertices;
}

}  // namespace

std::optional<PartPaintGesture> begin_part_paint(const Pointer& pointer, const GestureContext& around,
                                                 PlacedTools& placed) {
  const std::vector<std::uint32_t> vertices = under_brush(pointer, around);
  if (vertices.empty()) return std::nullopt;
  PartPaintGesture gesture;
  if (!pointer.modifiers.ctrl) {
    gesture.part = placed.parts.selected;
    if (!gesture.part) gesture.part = add_part(vertices, around.state, placed.parts);
    if (!gesture.part) return std::nullopt;
  } else if (placed.parts.of_vertex.empty()) {
    return std::nullopt;
  }
  move_part_paint(pointer, around, gesture, placed);
  return gesture;
}

void move_part_paint(const Pointer& pointer, const GestureContext& around, const PartPaintGesture& gesture,
                     PlacedTools& placed) {
  mark(under_brush(pointer, around), gesture.part, around.state, placed.parts);
}

}  // namespace knead::studio
