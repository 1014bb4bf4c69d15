// Poses: what the pins of a gesture become.
#include <algorithm>
#include <cmath>

#include "gestures/gesture_kinds.h"

namespace knead::studio {

namespace {

constexpr double kLiveDetail = 0.12;  // at least, while the pointer moves

bool is_renumbered(const ShapeState& state) { return state.provenance != nullptr && state.provenance->is_renumbered; }

// The pins of a pose, with the place of each.
class PosedPins {
 public:
  explicit PosedPins(double near) : near_(near) {}

  bool is_taken(const Vec3d& place) const {
    return std::any_of(places_.begin(), places_.end(), [&](const Vec3d& p) { return norm(p - place) <= near_; });
  }

  void add(PosePin pin, const Vec3d& place) {
    pin.hold = pin.path.empty();
    pins_.push_back(std::move(pin));
    places_.push_back(place);
  }

  // Adds the images of all that move, then of all that hold, where there is none yet.
  void add_images(const std::vector<SymmetryImage>& images) {
    const std::vector<PosePin> own = pins_;
    const std::vector<Vec3d> places = places_;
    for (const bool holds : {false, true}) {
      for (const SymmetryImage& image : images) {
        for (std::size_t i = 0; i < own.size(); ++i) {
          const Vec3d place = image.motion(places[i]);
          if (own[i].hold != holds || is_taken(place)) continue;
          PosePin pin = own[i];
          pin.vertex.reset();
          pin.point = place;
          for (Vec3d& p : pin.path) p = image.motion(p);
          add(std::move(pin), place);
        }
      }
    }
  }

  const std::vector<PosePin>& pins() const { return pins_; }

 private:
  double near_;
  std::vector<PosePin> pins_;
  std::vector<Vec3d> places_;
};

PosePin posed(const Pin& pin, const ShapeState& state) {
  PosePin posed;
  const auto seat = std::find_if(pin.seats.begin(), pin.seats.end(),
                                 [&](const Pin::Seat& one) { return one.mesh.lock() == state.mesh; });
  if (seat != pin.seats.end() && !is_renumbered(state)) {
    posed.vertex = seat->vertex;
  } else {
    posed.point = pin.place;
  }
  return posed;
}

// A pin that goes as far as the dragged one goes along its path; else straight to its goal.
std::vector<Vec3d> path_of(const PinsGesture& gesture, const PinGoal& goal) {
  const Vec3d apart = gesture.pins[goal.pin].place - gesture.pins[gesture.dragged].place;
  if (gesture.path.empty() || norm(gesture.to + apart - goal.to) > 1e-9 * norm(goal.to)) return {goal.to};
  std::vector<Vec3d> path = gesture.path;
  for (Vec3d& p : path) p += apart;
  path.back() = goal.to;
  return path;
}

}  // namespace

std::optional<PoseStroke> pose_stroke(const PinsGesture& gesture, const ShapeState& state,
                                      const ToolSettings& settings) {
  if (gesture.to == gesture.drag.start) return std::nullopt;
  PosedPins posed_pins(kOneImage * settings.radius);
  std::vector<std::optional<PinGoal>> goals(gesture.pins.size());
  std::vector<Vec3d> taken;  // by images of the pins that move
  for (const PinGoal& goal : pin_goals(gesture.pins, gesture.dragged, gesture.to, settings)) {
    if (goal.is_image) continue;
    goals[goal.pin] = goal;
    for (const SymmetryImage& image : images_of(settings)) {
      taken.push_back(image.motion(gesture.pins[goal.pin].place));
    }
  }
  for (std::size_t i = 0; i < gesture.pins.size(); ++i) {
    const Pin& pin = gesture.pins[i];
    const bool is_image = std::any_of(
        taken.begin(), taken.end(), [&](const Vec3d& p) { return norm(p - pin.place) <= kOneImage * settings.radius; });
    if (!goals[i] && (!pin.holds || is_image)) continue;
    PosePin item = posed(pin, state);
    if (goals[i]) item.path = path_of(gesture, *goals[i]);
    posed_pins.add(std::move(item), pin.place);
  }
  posed_pins.add_images(images_of(settings));
  PoseStroke stroke;
  stroke.detail = gesture.rests ? settings.pose_detail : std::max(settings.pose_detail, kLiveDetail);
  stroke.parts.assign(posed_pins.pins().begin(), posed_pins.pins().end());
  return stroke;
}

void extend_path(const Vec3d& start, const Vec3d& to, double step, std::vector<Vec3d>& path) {
  const std::optional<Vec3d> last = path.empty() ? std::nullopt : std::optional(path.back());
  if (last == to) return;
  if (last) path.pop_back();
  // The place before the last piece is near of itself.
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
