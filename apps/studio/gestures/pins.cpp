// Pins: set on vertices, followed as the shape changes, selected, and dragged.
#include <algorithm>
#include <cmath>
#include <utility>

#include "gestures/gesture_kinds.h"
#include "knead/error.h"

namespace knead::studio {

namespace {

constexpr double kHidden = 6;            // pixels by which the surface may lie in front of a visible pin
constexpr double kPathPiece = 2;         // snapping steps between two places of a path
constexpr double kLonePinReach = 2;      // displacements of a single pin, at least, with an automatic radius
constexpr double kLassoSpacing = 25;     // pixels between the pins that a lasso sets, at least
constexpr std::size_t kMaxOfLasso = 32;  // pins that a lasso sets

double distance2_to(const std::vector<Vec3d>& places, const Vec3d& p) {
  double least = kInfinity;
  for (const Vec3d& place : places) least = std::min(least, norm2(place - p));
  return least;
}

std::uint32_t nearest_vertex(const Snapshot& positions, const Vec3d& p) {
  std::uint32_t nearest = 0;
  for (std::uint32_t v = 1; v < positions.size(); ++v) {
    if (norm2(positions[v] - p) < norm2(positions[nearest] - p)) nearest = v;
  }
  return nearest;
}

Pin pin_on_vertex(std::uint32_t vertex, const ShapeState& state) {
  return {state.positions[vertex], true, {{state.mesh, vertex}}};
}

Pin pin_on(const SurfaceHit& hit, const GestureContext& around) {
  return pin_on_vertex(around.picker->vertex_of(hit, around.state), around.state);
}

bool is_hidden(const Vec3d& place, const Pixel& pixel, const GestureContext& around) {
  if (around.picker == nullptr) return false;
  const Ray ray = ray_through(around.screen, pixel.x, pixel.y);
  const auto hit = around.picker->pick(ray, around.state);
  return hit && dot(place - hit->point, ray.direction) > kHidden * pixel_size(around.screen, place);
}

// Returns the place nearest to `to` that stays in the mirror planes, or on the axis, in which the point lies.
Vec3d kept_by_images(const Vec3d& point, const Vec3d& to, const ToolSettings& settings) {
  Vec3d displacement = to - point;
  double count = 1;
  for (const SymmetryImage& image : images_of(settings)) {
    if (norm(image.motion(point) - point) > kOneImage * settings.radius) continue;
    displacement += image.motion(to) - image.motion(point);
    ++count;
  }
  return point + displacement / count;
}

// Calls body with each image of a pin that lies elsewhere, where it is a pin of its own.
template <class Body>
void for_images_apart(const Vec3d& pin, const ToolSettings& settings, const Body& body) {
  for (const SymmetryImage& image : images_of(settings)) {
    if (norm(image.motion(pin) - pin) > kOneImage * settings.radius) body(image);
  }
}

}  // namespace

std::optional<std::size_t> pin_at(const Pointer& pointer, const GestureContext& around, const std::vector<Pin>& pins) {
  std::optional<std::size_t> nearest;
  double least = kNear * around.screen.unit;
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const auto pixel = pixel_of(around.screen, pins[i].place);
    const double distance = pixel ? std::hypot(pixel->x - pointer.x, pixel->y - pointer.y) : least;
    if (distance >= least || is_hidden(pins[i].place, *pixel, around)) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

void follow(std::vector<Pin>& pins, const ShapeState& state) {
  for (Pin& pin : pins) {
    auto found = std::find_if(pin.vertices.begin(), pin.vertices.end(),
                              [&](const Pin::PinVertex& one) { return one.mesh.lock() == state.mesh; });
    if (found == pin.vertices.end()) {
      std::erase_if(pin.vertices, [](const Pin::PinVertex& one) { return one.mesh.expired(); });
      found = pin.vertices.insert(pin.vertices.end(), {state.mesh, nearest_vertex(state.positions, pin.place)});
    }
    pin.place = state.positions[found->vertex];
  }
}

std::vector<PinGoal> pin_goals(const std::vector<Pin>& pins, std::size_t dragged, const Vec3d& to,
                               const ToolSettings& settings) {
  const double near2 = std::pow(kOneImage * settings.radius, 2);
  const Vec3d by = to - pins[dragged].place;
  std::vector<std::pair<Vec3d, Vec3d>> taken;  // where images of the pins are, and go
  std::vector<PinGoal> goals;
  const auto add = [&](std::size_t pin, const Vec3d& goal) {
    const Vec3d& from = pins[pin].place;
    const auto by_image =
        std::find_if(taken.begin(), taken.end(), [&](const auto& image) { return norm2(image.first - from) <= near2; });
    const bool is_image = by_image != taken.end();
    goals.push_back({pin, is_image ? by_image->second : goal, is_image});
    if (is_image) return;
    for_images_apart(from, settings,
                     [&](const SymmetryImage& image) { taken.emplace_back(image.motion(from), image.motion(goal)); });
  };
  add(dragged, to);
  for (std::size_t i = 0; i < pins.size() && pins[dragged].is_selected; ++i) {
    if (i == dragged || !pins[i].is_selected) continue;
    add(i, kept_by_images(pins[i].place, pins[i].place + by, settings));
  }
  return goals;
}

PinsStroke pins_stroke(const std::vector<Pin>& pins, std::size_t dragged, const Vec3d& to,
                       const ToolSettings& settings) {
  const double near2 = std::pow(kOneImage * settings.radius, 2);
  const std::vector<SymmetryImage> images = images_of(settings);
  std::vector<std::optional<Vec3d>> goals(pins.size());
  std::vector<Vec3d> taken;  // by images of the pins that move
  for (const PinGoal& goal : pin_goals(pins, dragged, to, settings)) {
    const Vec3d& from = pins[goal.pin].place;
    if (goal.is_image) continue;
    goals[goal.pin] = goal.to;
    for_images_apart(from, settings, [&](const SymmetryImage& image) { taken.push_back(image.motion(from)); });
  }
  PinsStroke stroke;
  std::vector<bool> moving;
  const auto add = [&](const Vec3d& point, const Vec3d& its_to, bool moves) {
    stroke.points.push_back(point);
    stroke.to.push_back(its_to);
    moving.push_back(moves);
  };
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const Vec3d& place = pins[i].place;
    if (goals[i]) add(place, *goals[i], true);
    if (!goals[i] && pins[i].holds && distance2_to(taken, place) > near2) add(place, place, false);
  }
  const PinsStroke own = stroke;
  for (const bool moves : {true, false}) {
    for (const SymmetryImage& image : images) {
      for (std::size_t i = 0; i < own.points.size(); ++i) {
        const Vec3d place = image.motion(own.points[i]);
        if (moving[i] != moves || distance2_to(stroke.points, place) <= near2) continue;
        add(place, moves ? image.motion(own.to[i]) : place, moves);
      }
    }
  }
  stroke.radius_auto = settings.auto_radius && stroke.points.size() > 1;
  const double least = settings.auto_radius ? kLonePinReach * norm(to - pins[dragged].place) : 0;
  if (!stroke.radius_auto) stroke.radius = std::max(settings.radius, least);
  return stroke;
}

std::optional<double> radius_of(const PinsStroke& stroke) {
  try {
    return flow_of(stroke).segments.front().fields.front().thresholds.outer;
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

std::optional<PinsGesture> begin_pins(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  PinsGesture gesture;
  gesture.pins = placed.pins;
  gesture.parts = placed.parts;
  std::optional<std::size_t> pin = pin_at(pointer, around, gesture.pins);
  const auto hit = hit_at(pointer, around);
  if (!pin && !hit) return std::nullopt;
  if (!pin) {
    const Pin next = pin_on(*hit, around);
    const auto same =
        std::find_if(gesture.pins.begin(), gesture.pins.end(), [&](const Pin& one) { return one.place == next.place; });
    pin = static_cast<std::size_t>(same - gesture.pins.begin());
    if (same == gesture.pins.end()) gesture.pins.push_back(next);
  }
  gesture.dragged = *pin;
  gesture.to = gesture.pins[*pin].place;
  gesture.drag = begin_drag(pointer, gesture.to, hit ? hit->normal : -forward_of(around), around);
  if (!has_exact_pins(around.settings)) gesture.plan = plan_pose(gesture, around.state, around.settings);
  return gesture;
}

void select_pins(const GestureContext& around, const std::vector<Pixel>& line, std::vector<Pin>& pins) {
  for (Pin& pin : pins) {
    const auto pixel = pixel_of(around.screen, pin.place);
    pin.is_selected = pixel && is_within(line, *pixel);
  }
}

void end_pin_lasso(const GestureContext& around, const std::vector<Pixel>& line, PlacedTools& placed) {
  if (line.size() < 3) return;
  const Snapshot& positions = around.state.positions;
  std::vector<std::uint32_t> within;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const auto pixel = pixel_of(around.screen, positions[v]);
    if (pixel && is_within(line, *pixel)) within.push_back(v);
  }
  std::vector<double> distances(within.size(), kInfinity);
  const std::vector<SymmetryImage> images = images_of(around.settings);
  const auto keep_from = [&](const Vec3d& pin) {
    std::vector<Vec3d> places{pin};
    for (const SymmetryImage& image : images) places.push_back(image.motion(pin));
    for (std::size_t i = 0; i < within.size(); ++i) {
      distances[i] = std::min(distances[i], distance2_to(places, positions[within[i]]));
    }
  };
  for (const Pin& pin : placed.pins) keep_from(pin.place);
  const double spacing = kLassoSpacing * pixel_size(around.screen, around.screen.camera.target);
  for (std::size_t count = 0; count < kMaxOfLasso && !within.empty(); ++count) {
    const auto farthest = std::max_element(distances.begin(), distances.end());
    if (*farthest < spacing * spacing) return;
    placed.pins.push_back(pin_on_vertex(within[static_cast<std::size_t>(farthest - distances.begin())], around.state));
    keep_from(placed.pins.back().place);
  }
}

void PinsGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const Pixel& from = drag.from;
  const bool is_click = std::hypot(pointer.x - from.x, pointer.y - from.y) < kClick * around.screen.unit;
  has_gone = has_gone || !is_click || pointer.typed;
  if (!has_gone) return;
  to = kept_by_images(drag.start, drag.at(pointer, around), around.settings);
  rests = false;
  if (pointer.typed || pointer.modifiers.ctrl || !(around.snap > 0)) {
    path = {to};
  } else {
    extend_path(drag.start, to, kPathPiece * around.snap, path);
  }
}

// Leaves the pins at their places after the gesture.
void PinsGesture::end(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  rests = true;
  placed.pins = pins;
  for (const PinGoal& goal : pin_goals(pins, dragged, to, around.settings)) {
    placed.pins[goal.pin].place = goal.to;
  }
}

}  // namespace knead::studio
