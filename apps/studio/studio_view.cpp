// The view of a document: framing, settings, references, turntables.
#include "studio_view.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <exception>
#include <numbers>
#include <string>
#include <utility>
#include <variant>

#include "gestures/gesture.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "setting.h"

namespace knead::studio {

namespace {

// The file of the document, by which its references are found again; empty if there is none.
std::filesystem::path file_of(const DocumentState& shown) {
  return shown.shape_path.empty() ? shown.session_path : shown.shape_path;
}

constexpr double kNearMiddle = 0.1;  // of the picture's height
constexpr double kClose = 0.7;       // of the shape's size: a picture that is less high shows a part of the shape

std::optional<StandardView> side_of(Action action) {
  constexpr std::array<std::pair<Action, StandardView>, 6> sides{{{Action::view_front, StandardView::front},
                                                                  {Action::view_back, StandardView::back},
                                                                  {Action::view_right, StandardView::right},
                                                                  {Action::view_left, StandardView::left},
                                                                  {Action::view_top, StandardView::top},
                                                                  {Action::view_bottom, StandardView::bottom}}};
  for (const auto& [wanted, side] : sides) {
    if (wanted == action) return side;
  }
  return std::nullopt;
}

render::Matcap next_matcap(render::Matcap matcap) {
  return render::all_matcaps()[(static_cast<std::size_t>(matcap) + 1) % render::kMatcapCount];
}

// After a colour comes the first.
std::string next_background(const std::string& background) {
  if (background == "gradient") return "light";
  return background == "light" ? "dark" : "gradient";
}

}  // namespace

void PreferencesFile::save(StudioDocument& document) const {
  document.withdraw(Subject::preferences);
  try {
    save_preferences(folder, preferences);
  } catch (const IoError& error) {
    document.tell({true, error.what(), Subject::preferences});
  }
}

StudioView::StudioView(StudioDocument& document, PreferencesFile& preferences, std::filesystem::path state)
    : document_(document), preferences_(preferences), state_folder_(std::move(state)) {
  const Preferences& own = preferences_.preferences;
  navigation_.preset = own.navigation;
  navigation_.view.up = own.up;
  navigation_.view.projection = own.look.projection;
  navigation_.view.field_of_view_deg = own.look.field_of_view_deg;
  settings_.look = own.look;
  saved_panels_ = own.panels;
  settings_.panels = own.panels.shown;
  settings_.history = own.panels.history;
  settings_.tool_labels = own.panels.labels;
}

Screen StudioView::screen() const {
  return {camera_of(navigation_.view), navigation_.width, navigation_.height, unit_};
}

void StudioView::remember_panels() {
  PanelState now = preferences_.preferences.panels;
  now.shown = settings_.panels;
  now.history = settings_.history;
  now.labels = settings_.tool_labels;
  if (now == saved_panels_) return;
  preferences_.preferences.panels = saved_panels_ = std::move(now);
  preferences_.save(document_);
}

void StudioView::remember_window(const WindowPlace& window) {
  if (window == preferences_.preferences.window) return;
  preferences_.preferences.window = window;
  preferences_.save(document_);
}

void StudioView::begin_document() {
  turntable_.reset();
  kept_views_.clear();
  last_stroke_.reset();
  settings_.cut = false;
  frame_all();
  load_references();
}

void StudioView::frame_all() {
  const DocumentState& shown = document_.shown();
  if (shown.opened == 0) return;
  const Box box = shape_box(visible_mesh(shown.objects, shown.state));
  navigation_.view = framed(navigation_.view, box, {navigation_.width, navigation_.height, navigation_.covered});
  navigation_.home = box.empty() ? std::nullopt : std::optional(box.center());
}

void StudioView::look_from(StandardView side) {
  const View before = navigation_.view;
  const Vec3d middle = navigation_.home.value_or(before.target);
  View& view = navigation_.view;
  view = keeping(middle, before, seen_from(before, side));
  // What was framed from aslant lies a little off the line of sight.
  const Vec3d forward = render::camera_frame(camera_of(view)).forward;
  const Vec3d off = middle - view.target;
  if (norm(off - forward * dot(off, forward)) < kNearMiddle * view.height) view.target = middle;
}

void StudioView::keep_view() {
  kept_views_.push_back(navigation_.view);
  document_.tell({false, fmt::format("View {} is kept.", kept_views_.size())});
}

void StudioView::look_as_kept() {
  if (kept_views_.empty()) return document_.tell({false, "No view is kept yet: View > Keep this view."});
  navigation_.view = kept_views_[next_kept_view_++ % kept_views_.size()];
}

void StudioView::turn(double dx, double dy) {
  const View before = navigation_.view;
  const Vec3d pivot = close_stroke().value_or(navigation_.home.value_or(before.target));
  navigation_.view = orbited_about(before, pivot, dx, dy, navigation_.height);
}

// Returns the end of the last stroke if it is in the picture, and the picture shows a part of the shape only.
std::optional<Vec3d> StudioView::close_stroke() const {
  if (!last_stroke_ || navigation_.view.height > kClose * document_.shown().diagonal) return std::nullopt;
  const auto at = pixel_of(screen(), *last_stroke_);
  const bool is_seen = at && at->x >= 0 && at->x < navigation_.width && at->y >= 0 && at->y < navigation_.height;
  return is_seen ? last_stroke_ : std::nullopt;
}

bool StudioView::perform(Action action) {
  if (const auto side = side_of(action)) {
    look_from(*side);
    return true;
  }
  const std::vector<Setting> rows = settings_of(settings_);
  if (step(find_setting(rows, action == Action::cutting_plane ? "cut" : name_of(action)))) return true;
  switch (action) {
    case Action::frame_all:
      frame_all();
      return true;
    case Action::keep_view:
      keep_view();
      return true;
    case Action::kept_view:
      look_as_kept();
      return true;
    case Action::projection:
      navigation_.view = toggled_projection(navigation_.view);
      return true;
    case Action::next_matcap:
      if (settings_.look.material == render::Material::matcap) {
        settings_.look.matcap = next_matcap(settings_.look.matcap);
      }
      settings_.look.material = render::Material::matcap;
      return true;
    case Action::background:
      settings_.look.background = next_background(settings_.look.background);
      return true;
    default:
      return false;
  }
}

// References of a shape without a file stay while Studio runs.
void StudioView::load_references() {
  if (file_of(document_.shown()).empty() && saved_references_.empty()) return;
  LoadedReferences loaded = studio::load_references(state_folder_, file_of(document_.shown()));
  references_ = std::move(loaded.references);
  saved_references_ = references_;
  for (std::string& message : loaded.messages) document_.tell({true, std::move(message)});
}

bool StudioView::add_reference(const std::filesystem::path& file) {
  if (document_.shown().opened == 0) return false;
  Reference reference;
  reference.file = std::filesystem::absolute(file);
  try {
    reference.image = read_reference(file);
  } catch (const std::exception& error) {
    document_.tell({true, error.what()});
    return false;
  }
  const Box box = shape_box(document_.shown().state.to_mesh());
  reference.plane = plane_of(navigation_.view);
  reference.center = box.center();
  const Vec3d up = frame_of(reference.plane, navigation_.view.up).up;
  reference.height = std::abs(dot(box.max - box.min, up));
  if (!(reference.height > 0)) reference.height = document_.shown().diagonal;
  references_.push_back(std::move(reference));
  settings_.references = true;
  return true;
}

void StudioView::remember_look() {
  try {
    if (references_ != saved_references_) save_references(state_folder_, file_of(document_.shown()), references_);
    saved_references_ = references_;
  } catch (const IoError& error) {
    document_.tell({true, error.what()});
  }
  Look look = settings_.look;
  look.projection = navigation_.view.projection;
  look.field_of_view_deg = navigation_.view.field_of_view_deg;
  if (look == preferences_.preferences.look) return;
  preferences_.preferences.look = look;
  preferences_.save(document_);
}

// --- what the pointer turns about; the last stroke framed ----------------------------------------------------------

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

// Returns a box of the points that the strokes may move; empty for half-spaces.
Box reach_of(const std::vector<SessionStroke>& strokes) {
  Box box;
  for (const SessionStroke& stroke : strokes) {
    if (reads_surface(stroke.stroke)) continue;
    for (const Segment& segment : flow_of(stroke.stroke, stroke.mirror).segments) extend(box, segment);
  }
  return box;
}

}  // namespace

// Frames everything if there is no such box.
void StudioView::frame_stroke(const Box& placed) {
  const DocumentState& shown = document_.shown();
  const bool has_stroke = shown.opened != 0 && !shown.history.empty();
  const Box box = !placed.empty() || !has_stroke ? placed : reach_of(shown.history.back()->strokes);
  if (!(box.diagonal() > 0)) return frame_all();
  navigation_.view = framed(navigation_.view, box, {navigation_.width, navigation_.height, navigation_.covered});
  navigation_.home = box.center();
}

// A drag that turns the view turns it about the point under the pointer; beside the shape, about the last stroke.
void StudioView::set_pivot(const Event& event) {
  const auto* const button = std::get_if<ButtonChanged>(&event);
  if (button == nullptr || !button->down || navigation_.drag != NavigationDrag::none) return;
  navigation_.pivot = close_stroke();
  if (drag_of(navigation_.preset, button->button, button->modifiers) != NavigationDrag::orbit) return;
  const bool fits = document_.shown().opened != 0 && document_.shown().picker &&
                    document_.shown().picker->fits(document_.shown().state);
  if (!fits) return;
  const auto hit = document_.shown().picker->pick(ray_through(screen(), button->x, button->y), document_.shown().state);
  if (hit) navigation_.pivot = hit->point;
}

// --- turntables ------------------------------------------------------------------------------------------------------

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

namespace {

double hundredths(double radians) { return std::round(radians * 18000 / std::numbers::pi) / 100; }

}  // namespace

void StudioView::write_poster(const std::filesystem::path& file, const Poster& poster) {
  const View& view = navigation_.view;
  const bool is_z_up = view.up == UpAxis::z;
  const double azimuth = std::remainder(view.yaw, 2 * std::numbers::pi);
  PosterScene scene{render::view_direction(hundredths(azimuth), hundredths(view.pitch), is_z_up), is_z_up, {}, {}};
  scene.fit.projection = view.projection;
  scene.fit.field_of_view_deg = view.field_of_view_deg;
  const Look& look = settings_.look;
  render::Options& options = scene.options;
  options.width = poster.width;
  options.height = poster.height;
  const auto background = render::background_named(look.background);
  options.background = poster.is_transparent ? render::Color{1, 1, 1, 0} : background->top;
  options.background_bottom = poster.is_transparent ? render::Color{1, 1, 1, 0} : background->bottom;
  if (look.material == render::Material::matcap) options.matcap = look.matcap;
  if (look.material == render::Material::flat) options.shading = render::Shading::flat;
  options.relief = look.relief;
  options.wireframe = settings_.wireframe;
  options.ground = poster.has_ground;
  document_.post(
      [file, scene, pictures = poster.pictures](Document& document, Progress& progress) {
        document.write_poster(file, scene, pictures, progress);
      },
      "Drawing the poster");
}

void StudioView::record_turntable(const std::filesystem::path& pattern, int pictures) {
  if (document_.shown().opened == 0) return;
  try {
    turntable_ = make_turntable(pattern, pictures, navigation_.view);
  } catch (const InvalidInput& error) {
    document_.tell({true, error.what()});
  }
}

bool StudioView::step_turntable(const std::function<void(const std::filesystem::path&)>& write) {
  if (!turntable_) return false;
  navigation_.view = view_of(*turntable_);
  try {
    write(file_of(*turntable_));
  } catch (const std::exception& error) {
    document_.tell({true, error.what()});
    stop_turntable();
    return false;
  }
  if (++turntable_->next < turntable_->pictures) return true;
  document_.tell({false, fmt::format("Recorded {} pictures.", turntable_->pictures)});
  stop_turntable();
  return false;
}

void StudioView::stop_turntable() {
  if (!turntable_) return;
  if (turntable_->next < turntable_->pictures) {
    document_.tell({false, fmt::format("The recording was stopped after {} of {} pictures.", turntable_->next,
                                       turntable_->pictures)});
  }
  navigation_.view = turntable_->start;
  turntable_.reset();
}

}  // namespace knead::studio
