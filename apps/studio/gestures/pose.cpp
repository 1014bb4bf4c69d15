// The poses of gestures that drag pins or parts.
#include <algorithm>

#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"
#include "knead/mesh.h"

namespace knead::studio {

namespace {

constexpr double kLiveDetail = 0.12;           // at least, while the pointer moves
constexpr double kRoom = 0.06;                 // of the shape: points nearer to a moving one do not hold
constexpr double kMoreRoom = 1.6;              // of the gap to the nearest holding point, for a pose with more room
constexpr double kNearImage = 0.01;            // of the shape: vertices nearer to an image of a part belong to it
constexpr double kSamePart = 0.25;             // of its extent: an image nearer to a part is that part
constexpr std::size_t kPointsOfPart = 150;     // where it is named by its points
constexpr std::size_t kMaxRanges = 2000;       // of numbers that name a part
constexpr std::size_t kVerticesOfPart = 2000;  // that name one of more ranges, about

bool is_renumbered(const ShapeState& state) { return state.provenance != nullptr && state.provenance->is_renumbered; }

// The items of a pose, with the place of each pin or part, and the distance below which another one counts as the same.
class PoseItems {
 public:
  bool is_taken(const Vec3d& place) const {
    return std::any_of(items_.begin(), items_.end(),
                       [&](const Item& one) { return norm(one.place - place) <= one.near; });
  }

  // `by_points` names no vertices.
  void add(PoseItem item, PoseItem by_points, const Vec3d& place, double near, bool moves) {
    items_.push_back({std::move(item), std::move(by_points), place, near, moves});
  }

  void add(const PoseItems& others) { items_.insert(items_.end(), others.items_.begin(), others.items_.end()); }

  // Adds the images of all moving items, then of all holding ones, at places without an item.
  void add_images(const std::vector<SymmetryImage>& images) {
    const std::vector<Item> own = items_;
    for (const bool moves : {true, false}) {
      for (const SymmetryImage& image : images) {
        for (const Item& one : own) {
          const Vec3d place = image.motion(one.place);
          if (one.moves != moves || is_taken(place)) continue;
          PoseStroke alone;
          alone.parts = {one.by_points};
          const PoseItem item = std::get<PoseStroke>(transformed(alone, image.motion)).parts.front();
          items_.push_back({item, item, place, one.near, moves});
        }
      }
    }
  }

  std::vector<PoseItem> parts() const {
    std::vector<PoseItem> parts;
    for (const Item& one : items_) parts.push_back(one.item);
    return parts;
  }

 private:
  struct Item {
    PoseItem item;
    PoseItem by_points;
    Vec3d place;
    double near = 0;
    bool moves = false;
  };
  std::vector<Item> items_;
};

std::vector<VertexRange> ranges_of(std::span<const std::uint32_t> vertices) {
  std::vector<VertexRange> ranges;
  for (const std::uint32_t v : vertices) {
    if (!ranges.empty() && ranges.back().last + 1 == v) {
      ranges.back().last = v;
    } else {
      ranges.push_back({v, v});
    }
  }
  return ranges;
}

// The points of one posed part.
struct PartOfShape {
  std::vector<VertexRange> ranges;
  std::vector<Vec3d> points;  // some of it, evenly spread
  Vec3d middle{0, 0, 0};
  double extent = 0;
};

// Without the vertices for which is_free(vertex) holds.
template <class IsFree>
PartOfShape part_of_shape(const PartMarks& parts, std::size_t part, const ShapeState& state, const IsFree& is_free) {
  PartOfShape result;
  std::vector<std::uint32_t> vertices = vertices_of(parts, part);
  std::erase_if(vertices, is_free);
  std::vector<Vec3d> all;
  for (const std::uint32_t v : vertices) {
    all.push_back(state.positions[v]);
    result.middle += all.back() / static_cast<double>(vertices.size());
  }
  result.extent = bounding_box(all).diagonal();
  result.points = thinned(all, kPointsOfPart);
  result.ranges = ranges_of(vertices);
  if (result.ranges.size() <= kMaxRanges) return result;
  std::vector<std::uint32_t> some;
  const std::size_t stride = vertices.size() / kVerticesOfPart + 1;
  for (std::size_t i = 0; i < vertices.size(); i += stride) some.push_back(vertices[i]);
  result.ranges = ranges_of(some);
  return result;
}

// Without `motion` it holds.
void add_part(const PartOfShape& shape, const PartMotion* motion, const ShapeState& state, PoseItems& items) {
  PosePart item;
  item.hold = motion == nullptr;
  if (motion != nullptr && motion->angle_deg != 0) {
    item.rotation = HandlesRotation{motion->axis, motion->center, motion->angle_deg};
  }
  if (motion != nullptr && motion->translation != Vec3d{0, 0, 0}) item.translation = motion->translation;
  PosePart by_points = item;
  by_points.points = shape.points;
  item.vertices = shape.ranges;
  const bool needs_points = is_renumbered(state);
  items.add(needs_points ? by_points : item, by_points, shape.middle, kSamePart * shape.extent, motion != nullptr);
}

const Pin::PinVertex* vertex_of(const Pin& pin, const ShapeState& state) {
  const auto vertex = std::find_if(pin.vertices.begin(), pin.vertices.end(),
                                   [&](const Pin::PinVertex& one) { return one.mesh.lock() == state.mesh; });
  return vertex == pin.vertices.end() ? nullptr : &*vertex;
}

// Returns the part that a pin lies in; the pin then needs no item of its own.
std::optional<std::size_t> part_under(const Pin& pin, const PartMarks& parts, const ShapeState& state) {
  const Pin::PinVertex* const vertex = vertex_of(pin, state);
  return vertex == nullptr ? std::nullopt : part_of(parts, vertex->vertex);
}

// Along an empty path it holds.
void add_pin(const Pin& pin, std::vector<Vec3d> path, const ShapeState& state, double near, PoseItems& items) {
  PosePin item;
  item.path = std::move(path);
  item.hold = item.path.empty();
  PosePin by_points = item;
  by_points.point = pin.place;
  const Pin::PinVertex* const vertex = vertex_of(pin, state);
  if (vertex != nullptr && !is_renumbered(state)) {
    item.vertex = vertex->vertex;
  } else {
    item.point = pin.place;
  }
  const bool moves = !item.hold;
  items.add(std::move(item), std::move(by_points), pin.place, near, moves);
}

// The holding parts and pins of a gesture, on the shape in this state. The images of moving ones, at `taken`, do not
// hold.
struct Holding {
  const PartMarks& parts;
  const ShapeState& state;
  const std::vector<Vec3d>& taken;
};

// Adds the holding pins, without images of moving ones.
void add_held_pins(const Holding& holding, const std::vector<Pin>& pins, const std::vector<bool>& moves, double near,
                   PoseItems& items) {
  const PartMarks& parts = holding.parts;
  const ShapeState& state = holding.state;
  const std::vector<Vec3d>& taken = holding.taken;
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const Pin& pin = pins[i];
    if (moves[i] || !pin.holds || part_under(pin, parts, state)) continue;
    const bool is_image =
        std::any_of(taken.begin(), taken.end(), [&](const Vec3d& p) { return norm(p - pin.place) <= near; });
    if (!is_image) add_pin(pin, {}, state, near, items);
  }
}

// Adds the holding parts, without their free vertices, and without images of moving ones; some parts are left out.
template <class IsFree>
void add_held_parts(const Holding& holding, const std::vector<bool>& left_out, const IsFree& is_free,
                    PoseItems& items) {
  const PartMarks& parts = holding.parts;
  const ShapeState& state = holding.state;
  const std::vector<Vec3d>& taken = holding.taken;
  for (std::size_t part = 0; part < parts.holds.size(); ++part) {
    if (left_out[part] || !parts.holds[part]) continue;
    const PartOfShape shape = part_of_shape(parts, part, state, is_free);
    const bool is_image = std::any_of(
        taken.begin(), taken.end(), [&](const Vec3d& p) { return norm(p - shape.middle) <= kSamePart * shape.extent; });
    if (!is_image && !shape.ranges.empty()) add_part(shape, nullptr, state, items);
  }
}

// Returns for each vertex whether it bends when a part and its images move.
std::vector<bool> bending_of(const PartMarks& parts, std::size_t part, const ShapeState& state,
                             const ToolSettings& settings) {
  const std::vector<Vec3d> positions = state.positions.copy();
  std::vector<Triangle> triangles;
  for_each_triangle(*state.mesh, positions, [&](const Triangle& t) { triangles.push_back(t); });
  std::vector<bool> bends(positions.size(), false);
  const auto add = [&](std::span<const std::uint32_t> vertices) {
    for (const std::uint32_t v : bending_about(positions, triangles, vertices)) bends[v] = true;
  };
  const std::vector<std::uint32_t> own = vertices_of(parts, part);
  add(own);
  const std::vector<SymmetryImage> images = images_of(settings);
  if (images.empty()) return bends;
  std::vector<Triangle> of_part;
  of_part.reserve(own.size());
  for (const std::uint32_t v : own) of_part.push_back({v, v, v});
  const SurfaceTree tree(of_part, positions);
  const double near = kNearImage * bounding_box(positions).diagonal();
  for (const SymmetryImage& image : images) {  // those of an image are among the images
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
      if (tree.closest(image.motion(positions[v]), near)) vertices.push_back(v);
    }
    add(vertices);
  }
  return bends;
}

}  // namespace

struct PosePlan {
  PoseItems held;
  PartOfShape moving;  // of a part
  std::vector<PoseStiffness> stiffness;
};

namespace {

// Returns the stiffness of the parts for which it is not 1. Numbers name vertices of the first mesh only.
std::vector<PoseStiffness> stiffness_of(const PartMarks& parts, const ShapeState& state) {
  std::vector<PoseStiffness> regions;
  for (std::size_t part = 0; part < parts.stiffness.size() && !is_renumbered(state); ++part) {
    if (parts.stiffness[part] == 1) continue;
    regions.push_back({ranges_of(vertices_of(parts, part)), parts.stiffness[part]});
  }
  return regions;
}

PoseStroke stroke_of(PoseItems items, const PosePlan& plan, bool rests, const ToolSettings& settings) {
  items.add(plan.held);
  items.add_images(images_of(settings));
  PoseStroke stroke;
  stroke.stiffness = plan.stiffness;
  stroke.detail = rests ? settings.pose_detail : std::max(settings.pose_detail, kLiveDetail);
  stroke.parts = items.parts();
  return stroke;
}

// A pin with the dragged pin's displacement follows its path; any other moves straight to its target.
std::vector<Vec3d> path_of(const PinsGesture& gesture, const PinGoal& goal) {
  const Vec3d apart = gesture.pins[goal.pin].place - gesture.pins[gesture.dragged].place;
  if (gesture.path.empty() || norm(gesture.to + apart - goal.to) > 1e-9 * norm(goal.to)) return {goal.to};
  std::vector<Vec3d> path = gesture.path;
  for (Vec3d& p : path) p += apart;
  path.back() = goal.to;
  return path;
}

}  // namespace

std::shared_ptr<const PosePlan> plan_pose(const PinsGesture& gesture, const ShapeState& state,
                                          const ToolSettings& settings) {
  PosePlan plan;
  const double near = kOneImage * settings.radius;
  std::vector<bool> moves(gesture.pins.size());
  std::vector<bool> left_out(gesture.parts.holds.size());
  std::vector<Vec3d> moving;
  std::vector<Vec3d> taken;  // by images of the pins that move
  for (const PinGoal& goal : pin_goals(gesture.pins, gesture.dragged, gesture.to, settings)) {
    moves[goal.pin] = true;
    const Pin& pin = gesture.pins[goal.pin];
    moving.push_back(pin.place);
    if (const auto part = part_under(pin, gesture.parts, state)) left_out[*part] = true;
    if (goal.is_image) continue;
    for (const SymmetryImage& image : images_of(settings)) taken.push_back(image.motion(pin.place));
  }
  moving.insert(moving.end(), taken.begin(), taken.end());
  const double room = kRoom * bounding_box(state.mesh->positions).diagonal();
  const auto is_near = [&](std::uint32_t v) {
    return std::any_of(moving.begin(), moving.end(),
                       [&](const Vec3d& p) { return norm2(state.positions[v] - p) < room * room; });
  };
  add_held_pins({gesture.parts, state, taken}, gesture.pins, moves, near, plan.held);
  add_held_parts({gesture.parts, state, taken}, left_out, is_near, plan.held);
  plan.stiffness = stiffness_of(gesture.parts, state);
  return std::make_shared<const PosePlan>(std::move(plan));
}

std::shared_ptr<const PosePlan> plan_pose(const PartGesture& gesture, const ShapeState& state,
                                          const ToolSettings& settings) {
  PosePlan plan;
  const std::size_t selected = *gesture.parts.selected;
  plan.moving = part_of_shape(gesture.parts, selected, state, [](std::uint32_t) { return false; });
  std::vector<bool> left_out(gesture.parts.holds.size());
  left_out[selected] = true;
  std::vector<Vec3d> taken;
  for (const SymmetryImage& image : images_of(settings)) taken.push_back(image.motion(plan.moving.middle));
  const std::vector<bool> bends = bending_of(gesture.parts, selected, state, settings);
  add_held_pins({gesture.parts, state, taken}, gesture.pins, std::vector<bool>(gesture.pins.size()),
                kOneImage * settings.radius, plan.held);
  add_held_parts(
      {gesture.parts, state, taken}, left_out, [&](std::uint32_t v) { return bends[v]; }, plan.held);
  plan.stiffness = stiffness_of(gesture.parts, state);
  return std::make_shared<const PosePlan>(std::move(plan));
}

namespace {

bool holds(const PoseItem& item) {
  return std::visit([](const auto& own) { return own.hold; }, item);
}

// Calls visit(place) for the places of an item, and leaves out those for which it returns false.
template <class Visit>
void filter_places(PoseItem& item, std::span<const Vec3d> positions, const Visit& visit) {
  if (auto* const pin = std::get_if<PosePin>(&item)) {
    const bool stays = visit(pin->vertex ? positions[*pin->vertex] : *pin->point);
    if (!stays) pin->hold = false;
    return;
  }
  auto& part = std::get<PosePart>(item);
  std::erase_if(part.points, [&](const Vec3d& p) { return !visit(p); });
  std::vector<std::uint32_t> vertices;
  for (const VertexRange& range : part.vertices) {
    for (std::uint32_t v = range.first; v <= range.last; ++v) {
      if (visit(positions[v])) vertices.push_back(v);
    }
  }
  part.vertices = ranges_of(vertices);
}

bool is_nothing(const PoseItem& item) {
  const auto* const part = std::get_if<PosePart>(&item);
  return part != nullptr ? part->vertices.empty() && part->points.empty()
                         : !holds(item) && std::get<PosePin>(item).path.empty();
}

}  // namespace

PoseStroke holding_less(PoseStroke pose, std::span<const Vec3d> positions, double room) {
  std::vector<Vec3d> moving;
  for (PoseItem& item : pose.parts) {
    if (holds(item)) continue;
    filter_places(item, positions, [&](const Vec3d& p) {
      moving.push_back(p);
      return true;
    });
  }
  moving = thinned(moving, kPointsOfPart);
  const auto distance2 = [&](const Vec3d& p) {
    double least = kInfinity;
    for (const Vec3d& q : moving) least = std::min(least, norm2(p - q));
    return least;
  };
  double gap2 = kInfinity;
  const PoseStroke before = pose;
  for (PoseItem& item : pose.parts) {
    if (!holds(item)) continue;
    filter_places(item, positions, [&](const Vec3d& p) {
      gap2 = std::min(gap2, distance2(p));
      return true;
    });
  }
  const double least2 = std::max(room * room, kMoreRoom * kMoreRoom * gap2);
  for (PoseItem& item : pose.parts) {
    if (holds(item)) filter_places(item, positions, [&](const Vec3d& p) { return distance2(p) > least2; });
  }
  std::erase_if(pose.parts, is_nothing);
  return std::any_of(pose.parts.begin(), pose.parts.end(), holds) ? pose : before;
}

std::vector<Stroke> PinsGesture::strokes(const ShapeState& start, const ToolSettings& settings) const {
  if (to == drag.start) return {};
  if (settings.pose == PoseMode::exact) return {pins_stroke(pins, dragged, to, settings)};
  const auto used = plan ? plan : plan_pose(*this, start, settings);
  PoseItems items;
  for (const PinGoal& goal : pin_goals(pins, dragged, to, settings)) {
    if (goal.is_image) continue;
    add_pin(pins[goal.pin], path_of(*this, goal), start, kOneImage * settings.radius, items);
  }
  return {stroke_of(std::move(items), *used, rests, settings)};
}

std::vector<Stroke> PartGesture::strokes(const ShapeState& start, const ToolSettings& settings) const {
  if (motion.is_nothing() || !parts.selected) return {};
  const auto used = plan ? plan : plan_pose(*this, start, settings);
  PoseItems items;
  add_part(used->moving, &motion, start, items);
  return {stroke_of(std::move(items), *used, rests, settings)};
}

void extend_path(const Vec3d& start, const Vec3d& to, double step, std::vector<Vec3d>& path) {
  const std::optional<Vec3d> last = path.empty() ? std::nullopt : std::optional(path.back());
  if (last == to) return;
  if (last) path.pop_back();
  // The start of the last piece is always near, and does not count.
  for (std::size_t kept = 0; kept < path.size(); ++kept) {
    const Vec3d& place = kept == 0 ? start : path[kept - 1];
    if (norm(place - to) >= step) continue;
    path.resize(kept);
    path.push_back(to);
    return;
  }
  const Vec3d& before = path.empty() ? start : path.back();
  if (last && norm(*last - before) >= step) path.push_back(*last);
  path.push_back(to);
}

}  // namespace knead::studio
