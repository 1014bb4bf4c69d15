// What is found where the pointer is: the middle of a turn of the view, a mirror's plane; and the last stroke framed.
#include <variant>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "studio.h"

namespace knead::studio {

namespace {

// Grows the box by what a segment may move, as far as a box tells: the regions' outer ends along their paths.
void extend(Box& box, const Segment& segment) {
  for (const Segment& part : segment.parts) extend(box, part);
  if (!segment.grid.is_empty()) {
    const PotentialGrid& grid = segment.grid;
    const auto [x, y, z] = grid.counts;
    box.extend(grid.origin - Vec3d{2, 2, 2} * grid.spacing);
    box.extend(grid.origin + Vec3d{x + 1.0, y + 1.0, z + 1.0} * grid.spacing);
  }
  for (const Field& field : segment.fields) {
    const bool is_bounded = !std::holds_alternative<HalfSpace<double>>(field.region) &&
                            !std::holds_alternative<Handles<double>>(field.region);
    if (!is_bounded) continue;
    const Vec3d reach = Vec3d{1, 1, 1} * field.thresholds.outer;
    for (const Vec3d& center : {field.center, field.center + displacement_of(segment, field)}) {
      box.extend(center - reach);
      box.extend(center + reach);
    }
  }
}

// What the strokes may move, as far as a box tells. Empty for half-spaces.
Box reach_of(const std::vector<SessionStroke>& strokes) {
  Box box;
  for (const SessionStroke& stroke : strokes) {
    if (reads_surface(stroke.stroke)) continue;
    for (const Segment& segment : flow_of(stroke.stroke, stroke.mirror).segments) extend(box, segment);
  }
  return box;
}

}  // namespace

// Strokes that a box does not tell: everything.
void Studio::frame_stroke() {
  if (shown_.opened == 0 || shown_.history.empty()) return frame_all();
  const Box box = reach_of(shown_.history.back()->strokes);
  if (!(box.diagonal() > 0)) return frame_all();
  navigation_.view = framed(navigation_.view, box, {navigation_.width, navigation_.height, navigation_.covered});
  navigation_.home = box.center();
}

// A drag that turns the view turns it about what the pointer is on.
void Studio::set_pivot(const Event& event) {
  const auto* const button = std::get_if<ButtonChanged>(&event);
  if (button == nullptr || !button->down || navigation_.drag != NavigationDrag::none) return;
  navigation_.pivot.reset();
  if (drag_of(navigation_.preset, button->button, button->modifiers) != NavigationDrag::orbit) return;
  const bool fits = shown_.opened != 0 && shown_.picker && shown_.picker->fits(shown_.state);
  if (!fits) return;
  const auto hit = shown_.picker->pick(ray_through(screen(), button->x, button->y), shown_.state);
  if (hit) navigation_.pivot = hit->point;
}

// Returns whether the click was for that.
bool Studio::pick_plane() {
  const GestureContext around = surroundings();
  if (around.picker == nullptr) return false;
  const auto hit = around.picker->pick(ray_through(around.screen, pointer_.x, pointer_.y), around.state);
  if (!hit) return false;
  std::vector<Vec3d>& points = placed_.plane_points;
  points.push_back(hit->point);
  std::optional<Symmetry::Plane> plane;
  if (picking_ == PlanePick::face) plane = {hit->point, hit->normal};
  if (picking_ == PlanePick::three_points && points.size() == 3) {
    const Vec3d normal = cross(points[1] - points[0], points[2] - points[0]);
    const double least = 1e-9 * shown_.diagonal * shown_.diagonal;
    if (!(norm(normal) > least)) {
      points.pop_back();
      tell({true, "The three points lie on a line; click the third one elsewhere."});
      return true;
    }
    plane = {points[0], normalized(normal)};
  }
  if (!plane) return true;
  settings_.symmetry.plane = plane;
  pick_mirror(PlanePick::none);
  return true;
}

void Studio::pick_mirror(PlanePick how) {
  picking_ = picking_ == how ? PlanePick::none : how;
  placed_.plane_points.clear();
}

void Studio::center_symmetry() {
  if (shown_.opened != 0) settings_.symmetry.center = shape_box(shown_.state.to_mesh()).center();
}

}  // namespace knead::studio
