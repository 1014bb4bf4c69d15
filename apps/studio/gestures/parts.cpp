// Parts of a pose: marked on vertices, followed as the shape changes, drawn round, painted, and moved.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"
#include "knead/remesh.h"
#include "knead/vec.h"

namespace knead::studio {

namespace {

// The part of vertices that remeshing has made, until it is found.
constexpr std::uint8_t kUnknown = 255;
constexpr double kBrush = 0.5;  // of the radius
constexpr double kShaft = 68;   // pixels of an arrow
constexpr double kBorderOfPiece =
    0.7;  // of its extent: so near to a joint is the border of a piece that can turn there

std::uint32_t source_of(const ShapeState& state, std::uint32_t vertex) {
  return state.provenance ? state.provenance->vertex_source[vertex] : vertex;
}

// Gives unknown vertices the part of a neighbour, from neighbour to neighbour.
void spread(const Mesh& mesh, std::vector<std::uint8_t>& marks) {
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      const auto known = std::find_if(face.begin(), face.end(), [&](std::uint32_t v) { return marks[v] != kUnknown; });
      if (known == face.end()) continue;
      for (const std::uint32_t v : face) {
        if (marks[v] != kUnknown) continue;
        marks[v] = marks[*known];
        has_changed = true;
      }
    }
  }
  std::replace(marks.begin(), marks.end(), kUnknown, std::uint8_t{0});
}

std::vector<std::uint8_t> taken_over(const std::vector<std::uint8_t>& marks, const ShapeState& from,
                                     const ShapeState& to) {
  std::vector<std::uint8_t> of_source;
  for (std::uint32_t v = 0; v < marks.size(); ++v) {
    const std::uint32_t source = source_of(from, v);
    if (source == kNewVertex) continue;
    if (source >= of_source.size()) of_source.resize(source + 1, kUnknown);
    of_source[source] = marks[v];
  }
  std::vector<std::uint8_t> result(to.positions.size(), kUnknown);
  for (std::uint32_t v = 0; v < result.size(); ++v) {
    const std::uint32_t source = source_of(to, v);
    if (source < of_source.size()) result[v] = of_source[source];
  }
  spread(*to.mesh, result);
  return result;
}

void place_gizmo(PartMarks& parts) {
  parts.placement = parts.selected ? joint_of(parts, *parts.selected, parts.at) : std::nullopt;
}

void begin_marking(const ShapeState& state, PartMarks& parts) {
  follow(parts, state);
  if (parts.of_vertex.empty()) parts.of_vertex.resize(state.positions.size());
  parts.at = state;
  parts.on_meshes.clear();
}

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

// Vertices of joints that no longer bend hold again, in the part that holds most of the body.
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

bool is_seen(std::uint32_t vertex, const GestureContext& around) {
  const Vec3d place = around.state.positions[vertex];
  const auto pixel = pixel_of(around.screen, place);
  const auto hit = around.picker->pick(ray_through(around.screen, pixel->x, pixel->y), around.state);
  return hit && norm(hit->point - place) < 2 * pixel_size(around.screen, place);
}

// Drops pieces that are hidden behind others. A piece consists of vertices that are connected by triangles.
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

std::vector<std::uint32_t> under_brush(const Pointer& pointer, const GestureContext& around) {
  std::vector<std::uint32_t> vertices;
  const auto hit = hit_at(pointer, around);
  const double reach2 = std::pow(kBrush * around.settings.radius, 2);
  for (std::uint32_t v = 0; hit && v < around.state.positions.size(); ++v) {
    if (norm2(around.state.positions[v] - hit->point) <= reach2) vertices.push_back(v);
  }
  return vertices;
}

// Returns the connected vertices beyond a plane through a joint, on the side that `direction` points to. Returns none
// if they are also connected to the other side far from the joint.
std::vector<std::uint32_t> piece_beyond(const Placement& joint, const Vec3d& direction, const GestureContext& around,
                                        std::span<const Vec3d> positions) {
  const auto is_beyond = [&](std::uint32_t v) { return dot(positions[v] - joint.center, direction) > 0; };
  const auto distance = [&](std::uint32_t v) { return norm2(positions[v] - joint.center); };
  std::optional<std::uint32_t> first;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (is_beyond(v) && (!first || distance(v) < distance(*first))) first = v;
  }
  if (!first) return {};
  std::vector<std::uint32_t> links(positions.size());  // to a smaller vertex of the same piece, or to itself
  std::iota(links.begin(), links.end(), 0U);
  const auto root_of = [&](std::uint32_t v) {
    while (links[v] != v) v = links[v] = links[links[v]];
    return v;
  };
  for (const Triangle& t : around.picker->triangles()) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!is_beyond(t[k]) || !is_beyond(t[(k + 1) % 3])) continue;
      const auto [smaller, greater] = std::minmax({root_of(t[k]), root_of(t[(k + 1) % 3])});
      links[greater] = smaller;
    }
  }
  const auto is_in = [&](std::uint32_t v) { return is_beyond(v) && root_of(v) == root_of(*first); };
  double border2 = 0;
  for (const Triangle& t : around.picker->triangles()) {
    if (std::none_of(t.begin(), t.end(), is_in)) continue;
    for (const std::uint32_t v : t) border2 = is_beyond(v) ? border2 : std::max(border2, distance(v));
  }
  Box box;
  std::vector<std::uint32_t> piece;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (!is_in(v)) continue;
    piece.push_back(v);
    box.extend(positions[v]);
  }
  return border2 < std::pow(kBorderOfPiece * box.diagonal(), 2) ? piece : std::vector<std::uint32_t>{};
}

}  // namespace

std::optional<std::size_t> part_of(const PartMarks& parts, std::uint32_t vertex) {
  if (vertex >= parts.of_vertex.size() || parts.of_vertex[vertex] == 0) return std::nullopt;
  return parts.of_vertex[vertex] - 1u;
}

std::optional<std::size_t> add_part(std::span<const std::uint32_t> vertices, const ShapeState& state,
                                    PartMarks& parts) {
  if (vertices.empty() || parts.holds.size() == kMaxParts) return std::nullopt;
  parts.holds.push_back(true);
  parts.stiffness.push_back(1);
  mark(vertices, parts.holds.size() - 1, state, parts);
  remove_empty_parts(parts);
  select_part(parts.holds.size() - 1, parts);
  return parts.selected;
}

void mark(std::span<const std::uint32_t> vertices, std::optional<std::size_t> part, const ShapeState& state,
          PartMarks& parts) {
  begin_marking(state, parts);
  const std::uint8_t number = part ? static_cast<std::uint8_t>(*part + 1) : std::uint8_t{0};
  for (const std::uint32_t v : vertices) parts.of_vertex[v] = number;
  place_gizmo(parts);
}

void remove_part(std::size_t part, PartMarks& parts) {
  parts.on_meshes.clear();
  for (std::uint8_t& number : parts.of_vertex) {
    if (number == part + 1) {
      number = 0;
    } else if (number > part + 1) {
      --number;
    }
  }
  parts.holds.erase(parts.holds.begin() + static_cast<std::ptrdiff_t>(part));
  parts.stiffness.erase(parts.stiffness.begin() + static_cast<std::ptrdiff_t>(part));
  if (parts.selected == part) parts.selected.reset();
  if (parts.selected && *parts.selected > part) --*parts.selected;
  if (parts.holds.empty()) parts = {};
  place_gizmo(parts);
}

void remove_empty_parts(PartMarks& parts) {
  for (std::size_t part = parts.holds.size(); part-- > 0;) {
    const auto number = static_cast<std::uint8_t>(part + 1);
    const bool is_empty = std::find(parts.of_vertex.begin(), parts.of_vertex.end(), number) == parts.of_vertex.end();
    if (is_empty) remove_part(part, parts);
  }
}

void select_part(std::optional<std::size_t> part, PartMarks& parts) {
  parts.selected = part;
  place_gizmo(parts);
}

void follow(PartMarks& parts, const ShapeState& state) {
  if (parts.of_vertex.empty() || (parts.at.is_same(state) && !parts.is_ahead)) return;
  parts.is_ahead = false;
  if (parts.at.mesh != state.mesh) {
    std::erase_if(parts.on_meshes, [](const PartMarks::OnMesh& one) { return one.mesh.expired(); });
    const auto known = std::find_if(parts.on_meshes.begin(), parts.on_meshes.end(),
                                    [&](const PartMarks::OnMesh& one) { return one.mesh.lock() == state.mesh; });
    std::vector<std::uint8_t> next =
        known != parts.on_meshes.end() ? known->of_vertex : taken_over(parts.of_vertex, parts.at, state);
    const bool is_kept = std::any_of(parts.on_meshes.begin(), parts.on_meshes.end(),
                                     [&](const PartMarks::OnMesh& one) { return one.mesh.lock() == parts.at.mesh; });
    if (!is_kept) parts.on_meshes.push_back({parts.at.mesh, parts.of_vertex});
    parts.of_vertex = std::move(next);
  }
  parts.at = state;
  place_gizmo(parts);
}

std::vector<std::uint32_t> vertices_of(const PartMarks& parts, std::size_t part) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < parts.of_vertex.size(); ++v) {
    if (parts.of_vertex[v] == part + 1) vertices.push_back(v);
  }
  return vertices;
}

std::optional<Placement> joint_of(const PartMarks& parts, std::size_t part, const ShapeState& state) {
  const std::vector<std::uint32_t> vertices = vertices_of(parts, part);
  if (vertices.empty()) return std::nullopt;
  Vec3d middle{0, 0, 0};
  for (const std::uint32_t v : vertices) middle += state.positions[v];
  middle = middle / static_cast<double>(vertices.size());
  Vec3d border{0, 0, 0};
  std::size_t count = 0;
  const Mesh& mesh = *state.mesh;
  const auto is_inside = [&](std::uint32_t v) { return parts.of_vertex[v] == part + 1; };
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const auto inside = std::count_if(face.begin(), face.end(), is_inside);
    if (inside == 0 || inside == static_cast<std::ptrdiff_t>(face.size())) continue;
    for (const std::uint32_t v : face) {
      if (!is_inside(v)) continue;
      border += state.positions[v];
      ++count;
    }
  }
  Placement joint{middle};
  if (count == 0) return joint;
  joint.center = border / static_cast<double>(count);
  const Vec3d along = middle - joint.center;
  if (!(norm2(along) > 0)) return joint;
  joint.z = normalized(along);
  joint.x = any_orthogonal(joint.z);
  joint.y = cross(joint.z, joint.x);
  return joint;
}

// --- parts of a pose: drawn round, painted, and moved ----------------------------------------------------------------

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
  return hit ? part_of(parts, around.picker->vertex_of(*hit, around.state)) : std::nullopt;
}

bool is_on_part_gizmo(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  return gizmo_at(pointer, around, placed).has_value();
}

std::string add_limb(const Pointer& pointer, const GestureContext& around, PlacedTools& placed) {
  const auto hit = hit_at(pointer, around);
  if (!hit || around.picker == nullptr) return "Double click on a finger, an arm or a leg of the shape.";
  const std::vector<Vec3d> positions = around.state.positions.copy();
  const Limb limb = find_limb(positions, around.picker->triangles(), around.picker->vertex_of(*hit, around.state));
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

bool add_part_beyond(const Placement& joint, const GestureContext& around, PlacedTools& placed) {
  if (around.picker == nullptr) return false;
  const std::vector<Vec3d> positions = around.state.positions.copy();
  std::vector<std::uint32_t> piece = piece_beyond(joint, joint.z, around, positions);
  std::vector<std::uint32_t> other = piece_beyond(joint, -joint.z, around, positions);
  if (piece.empty() || (!other.empty() && other.size() < piece.size())) piece = std::move(other);
  if (piece.empty() || 2 * piece.size() > positions.size()) return false;
  std::vector<std::uint32_t> rest;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (!std::binary_search(piece.begin(), piece.end(), v)) rest.push_back(v);
  }
  placed.parts = {};
  add_part(rest, around.state, placed.parts);
  add_part(piece, around.state, placed.parts);
  return true;
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

void end_part_lasso(const Pointer& pointer, const GestureContext& around, const LassoGesture& gesture,
                    PlacedTools& placed) {
  if (gesture.line.size() < 3) return select_part(part_at(pointer, around, placed.parts), placed.parts);
  std::vector<std::uint32_t> within;
  for (std::uint32_t v = 0; v < around.state.positions.size(); ++v) {
    const auto pixel = pixel_of(around.screen, around.state.positions[v]);
    if (pixel && is_within(gesture.line, *pixel)) within.push_back(v);
  }
  drop_hidden(around, within);
  if (!gesture.frees) {
    add_part(within, around.state, placed.parts);
  } else if (!placed.parts.of_vertex.empty()) {
    mark(within, std::nullopt, around.state, placed.parts);
    remove_empty_parts(placed.parts);
  }
}

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
  gesture.move({pointer, around, placed});
  return gesture;
}

void PartGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const bool is_click = std::hypot(pointer.x - from.x, pointer.y - from.y) < kClick * around.screen.unit;
  has_gone = has_gone || !is_click || pointer.typed;
  rests = false;
  if (!has_gone) return;
  if (handle) {
    drag_gizmo(pointer, around, *this);
  } else {
    turn_about_joint(pointer, around, *this);
  }
}

void PartGesture::end(const GestureStep& step) {
  rests = true;
  if (!step.placed.parts.placement) return;
  step.placed.parts.placement = moved(*step.placed.parts.placement, motion);
  step.placed.parts.is_ahead = true;
}

std::optional<Amount> PartGesture::number() const {
  if (handle == GizmoPart::center) return std::nullopt;
  return Amount{!handle || turns(*handle) ? AmountKind::angle : AmountKind::length, amount};
}

void PartPaintGesture::move(const GestureStep& step) const {
  mark(under_brush(step.pointer, step.around), part, step.around.state, step.placed.parts);
}

void PartPaintGesture::end(const GestureStep& step) const { remove_empty_parts(step.placed.parts); }

}  // namespace knead::studio
