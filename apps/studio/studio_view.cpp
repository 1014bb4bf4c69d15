// How the shape is looked at: pictures behind it, past entries, turntables, and what the pointer finds.
#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <numbers>
#include <string>
#include <utility>
#include <variant>

#include "gestures/navigation.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "script.h"
#include "studio.h"

namespace knead::studio {

namespace {

// The file of the document, by which its references are found again; empty if there is none.
std::filesystem::path file_of(const DocumentState& shown) {
  return shown.shape_path.empty() ? shown.session_path : shown.shape_path;
}

}  // namespace

// References of a shape without a file stay while Studio runs.
void Studio::load_own_references() {
  if (file_of(shown_).empty() && saved_references_.empty()) return;
  LoadedReferences loaded = load_references(options_.state, file_of(shown_));
  references_ = std::move(loaded.references);
  saved_references_ = references_;
  for (std::string& message : loaded.messages) tell({true, std::move(message)});
}

bool Studio::add_reference(const std::filesystem::path& file) {
  if (shown_.opened == 0) return false;
  Reference reference;
  reference.file = std::filesystem::absolute(file);
  try {
    reference.image = read_reference(file);
  } catch (const std::exception& error) {
    tell({true, error.what()});
    return false;
  }
  const Box box = shape_box(shown_.state.to_mesh());
  reference.plane = plane_of(navigation_.view);
  reference.center = box.center();
  const Vec3d up = frame_of(reference.plane, navigation_.view.up).up;
  reference.height = std::abs(dot(box.max - box.min, up));
  if (!(reference.height > 0)) reference.height = shown_.diagonal;
  references_.push_back(std::move(reference));
  view_.references = true;
  return true;
}

void Studio::remember_look() {
  try {
    if (references_ != saved_references_) save_references(options_.state, file_of(shown_), references_);
    saved_references_ = references_;
  } catch (const IoError& error) {
    tell({true, error.what()});
  }
  Look look = view_.look;
  look.projection = navigation_.view.projection;
  look.field_of_view_deg = navigation_.view.field_of_view_deg;
  if (look == preferences_.look) return;
  preferences_.look = look;
  save_preferences();
}

// --- past entries, changed from the panel and in the view; the view as the journal keeps it --------------------------

void Studio::change_layers(const LayerChange& change) {
  if (gesture_) end(false);
  post([this, change](Progress& progress) { document_.change_layers(change, progress); }, "Changing the history");
}

// Of a drag only the latest step counts.
void Studio::drag_layers(const LayerChange& change) {
  if (gesture_) end(false);
  sent_ = worker_->post_latest([this, change](Progress& progress) { document_.drag_layers(change, progress); },
                               "Changing the history");
  refresh();
}

void Studio::end_layer_drag(bool is_kept) {
  post([this, is_kept](Progress& /*progress*/) { document_.end_layer_drag(is_kept); });
}

void Studio::select_layer(std::optional<std::size_t> entry) { select(layers_, shown_, entry); }

std::optional<LayerHandle> Studio::pointed_handle() const {
  if (layer_drag_) return layer_drag_->handle;
  if (!layers_.entry || gesture_ || shown_.looked_at) return std::nullopt;
  return handle_at(screen(), layers_.paths, pointer_.x, pointer_.y);
}

bool Studio::begin_handle_drag() {
  const std::optional<LayerHandle> handle = pointed_handle();
  if (!handle) return false;
  LayerDrag drag{*layers_.entry, *handle, place_of(layers_.paths, *handle), {0, 0, 0}, layers_.strokes};
  const Ray ray = ray_through(screen(), pointer_.x, pointer_.y);
  const auto taken = on_plane(ray, drag.start, render::camera_frame(screen().camera).forward);
  if (taken) drag.offset = drag.start - *taken;
  layer_drag_ = std::move(drag);
  return true;
}

// In the plane of the view.
void Studio::move_handle() {
  const Ray ray = ray_through(screen(), pointer_.x, pointer_.y);
  const auto at = on_plane(ray, layer_drag_->start, render::camera_frame(screen().camera).forward);
  if (!at) return;
  const Vec3d by = *at + layer_drag_->offset - layer_drag_->start;
  std::vector<SessionStroke> strokes = with_handle_moved(layer_drag_->strokes, layer_drag_->handle, by);
  if (strokes == layers_.strokes) return;
  set_strokes(layers_, strokes);
  drag_layers(replaced(layer_drag_->entry, std::move(strokes)));
}

void Studio::end_handle_drag(bool is_kept) {
  if (is_kept) move_handle();
  if (!is_kept) set_strokes(layers_, layer_drag_->strokes);
  layer_drag_.reset();
  end_layer_drag(is_kept);
}

void Studio::remember_view() {
  const bool is_moving = gesture_ || adjusting_ || turntable_ || navigation_.drag != NavigationDrag::none;
  if (shown_.opened == 0 || is_moving) return;
  std::string view = script_of_view(*this);
  if (view == remembered_view_) return;
  remembered_view_ = view;
  worker_->post([this, view = std::move(view)](Progress& /*progress*/) { document_.remember_view(view); });
}

// --- what the pointer finds: the middle of a turn, a mirror's plane; the last stroke framed --------------------------

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
  const GestureContext around = gesture_context();
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

Turntable make_turntable(const std::filesystem::path& pattern, int pictures, const View& view) {
  if (pattern.extension() != ".png") throw InvalidInput("The pictures are PNG files: give a name like turn.png");
  if (pictures < 2 || pictures > kMaxTurntablePictures) {
    throw InvalidInput(fmt::format("A turntable has 2 to {} pictures, not {}.", kMaxTurntablePictures, pictures));
  }
  return {numbered(pattern), pictures, 0, view};
}

View view_of(const Turntable& turntable) {
  View view = turntable.start;
  view.yaw += 2 * std::numbers::pi * turntable.next / turntable.pictures;
  return view;
}

std::filesystem::path file_of(const Turntable& turntable) {
  std::string name = turntable.pattern.filename().string();
  name.replace(name.find(kNumber), 4, fmt::format("{:04}", turntable.next));
  return turntable.pattern.parent_path() / name;
}

void Studio::record_turntable(const std::filesystem::path& pattern, int pictures) {
  if (shown_.opened == 0) return;
  try {
    turntable_ = make_turntable(pattern, pictures, navigation_.view);
  } catch (const InvalidInput& error) {
    tell({true, error.what()});
  }
}

bool Studio::step_turntable(const std::function<void(const std::filesystem::path&)>& write) {
  if (!turntable_) return false;
  navigation_.view = view_of(*turntable_);
  try {
    write(file_of(*turntable_));
  } catch (const std::exception& error) {
    tell({true, error.what()});
    stop_turntable();
    return false;
  }
  if (++turntable_->next < turntable_->pictures) return true;
  tell({false, fmt::format("Recorded {} pictures.", turntable_->pictures)});
  stop_turntable();
  return false;
}

void Studio::stop_turntable() {
  if (!turntable_) return;
  if (turntable_->next < turntable_->pictures) {
    tell({false,
          fmt::format("The recording was stopped after {} of {} pictures.", turntable_->next, turntable_->pictures)});
  }
  navigation_.view = turntable_->start;
  turntable_.reset();
}

}  // namespace knead::studio
