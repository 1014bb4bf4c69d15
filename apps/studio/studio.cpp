// Events of the pointer and keys, and the gesture that they make.
#include "studio.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "gestures/gesture_kinds.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "script.h"

namespace knead::studio {

namespace {

constexpr double kWheelFactor = 1.1;
constexpr double kRatioStep = 0.05;
constexpr int kRings = 3;  // rings of pixels around the pointer in which the shape is sought
constexpr int kRaysOfRing = 16;
constexpr double kRoomOfPose =
    0.25;                       // of the shape's size: with "Hold less", points nearer to a moving one do not hold
constexpr double kRest = 0.35;  // seconds without a move after which the pointer rests

PreferencesFile preferences_of(const std::filesystem::path& folder, StudioDocument& document) {
  LoadedPreferences loaded = load_preferences(folder);
  for (std::string& message : loaded.messages) document.tell({true, std::move(message)});
  return {folder, std::move(loaded.preferences)};
}

}  // namespace

Studio::Studio(const StudioOptions& options)
    : document_(options, [this] { refresh(); }),
      preferences_(preferences_of(options.config, document_)),
      tools_(document_, [this] { interrupt(); }),
      view_(document_, preferences_, options.state),
      history_(document_, [this] { interrupt(); }),
      masks_(document_, tools_, [this](std::vector<SessionStroke> strokes) { apply(std::move(strokes)); }),
      fit_(document_, options.threads) {
  const auto bytes = static_cast<std::size_t>(preferences().undo_memory_mb * 1e6);
  document_.post([bytes](Document& document, Progress& /*progress*/) { document.limit_undo_memory(bytes); });
}

void Studio::interrupt() {
  if (gesture_) end(false);
}

void Studio::refresh() {
  if (document_.refresh()) begin_document();
  if (!shown().recovered_view.empty() && restored_ != shown().opened) {
    restored_ = shown().opened;
    restore_view(*this, shown().recovered_view);
  }
  history_.follow();
  if (!gesture_ && shown().ended == ended_) pending_.reset();
  remember_view();
  masks_.follow();
  refresh_pins();
  rest();
  tools_.follow(gesture_.has_value());
  fit_.follow(gesture_.has_value());
}

void Studio::begin_document() {
  gesture_.reset();
  history_.clear();
  remembered_view_.clear();
  masks_.clear();
  pending_.reset();
  ended_ = shown().ended;
  tools_.begin_document();
  view_.begin_document();
  document_.note_opened();
}

GestureContext Studio::gesture_context() const {
  const ShapeState& state = gesture_ ? gesture_->start : shown().state;
  const bool fits = shown().picker && shown().picker->fits(state);
  const Picker* const picker = fits ? shown().picker.get() : nullptr;
  return {view_.screen(),
          state,
          picker,
          settings(),
          document_.worker().begun() >= sent_,
          {},
          snap_length(shown().diagonal)};
}

// Returns whether the picker is up to date with the shown shape.
bool Studio::picker_is_right() const {
  const bool fits = shown().picker && shown().picker->fits(shown().state);
  return fits && !shown().picker_is_behind && shown().ended == ended_;
}

// Returns whether a drag would begin beside the shape, and turn the view. Tools that may begin there need a distance
// from the shape in the picture greater than their radius. A drag with modifiers never turns the view.
bool Studio::is_beside_shape() const {
  const ToolUse use = settings().tool->use;
  const bool paints_mask = use == ToolUse::mask && settings().mask_mode == MaskMode::paint;
  const bool may_begin_beside = use == ToolUse::pull || use == ToolUse::paint || paints_mask;
  const bool begins_on_shape = use == ToolUse::inflate || use == ToolUse::print || use == ToolUse::smooth ||
                               use == ToolUse::points || use == ToolUse::curve || use == ToolUse::stamp;
  if (!(may_begin_beside || begins_on_shape) || !(pointer_.modifiers == Modifiers{})) return false;
  const GestureContext context = gesture_context();
  if (context.picker == nullptr || is_on_placed(pointer_, context, tools_.placed())) return false;
  const int rings = may_begin_beside ? kRings : 0;
  const double radius = settings().radius / pixel_size(context.screen, view_.navigation().view.target);
  Pointer at = pointer_;
  for (int ring = 0; ring <= rings; ++ring) {
    for (int i = 0; i < (ring == 0 ? 1 : kRaysOfRing); ++i) {
      const double angle = 2 * std::numbers::pi * i / kRaysOfRing;
      at.x = pointer_.x + radius * ring / kRings * std::cos(angle);
      at.y = pointer_.y + radius * ring / kRings * std::sin(angle);
      if (hit_at(at, context)) return false;
    }
  }
  return true;
}

// True for gestures that need the surface only when they begin. The others also need it while they move, in the state
// at their start, and a hit test shows only the current state.
bool Studio::asks_hit_test() const {
  const bool asks_once = settings().tool->use == ToolUse::pull;
  return hit_test_ && asks_once && shown().objects.are_all_met() && settings().drag != DragMode::surface &&
         !picker_is_right();
}

const PendingStrokes* Studio::pending() const {
  const bool is_meant = pending_ && !pending_->strokes.empty() && shown().refusal.empty();
  return is_meant ? &*pending_ : nullptr;
}

void Studio::handle(const Event& event) {
  refresh();
  if (const auto* moved = std::get_if<PointerMoved>(&event)) {
    pointer_.pressure = moved->pressure;
    tools_.placed().lit_pin.reset();
    place_pointer(moved->x, moved->y, moved->modifiers);
  }
  view_.set_pivot(event);
  if (!is_in_hand() && (change_pin(event) || navigate(view_.navigation(), event))) return;
  struct Handler {
    Studio& studio;

    void operator()(const PointerMoved& e) const { studio.move(e); }
    void operator()(const ButtonChanged& e) const { e.down ? studio.press(e) : studio.release(e); }
    void operator()(const WheelTurned& e) const { studio.turn_wheel(e); }
    void operator()(const KeyChanged& e) const { studio.press_key(e); }
    void operator()(const FilesDropped& e) const { studio.drop_files(e.files); }
    void operator()(const Resized& e) const { navigate(studio.view_.navigation(), e); }
  };
  std::visit(Handler{*this}, event);
}

// Of several shapes the first is opened, and the others are added to it.
void Studio::drop_files(const std::vector<std::filesystem::path>& files) {
  bool has_shape = false;
  for (const std::filesystem::path& file : files) {
    const std::string extension = file.extension().string();
    if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") {
      view_.add_reference(file);
    } else if (has_shape && extension != ".knead") {
      add_shape(file);
    } else {
      has_shape = has_shape || extension != ".knead";
      document_.open(file);
    }
  }
}

void Studio::add_shape(const std::filesystem::path& path) {
  interrupt();
  document_.add(path);
}

void Studio::remove_object(std::size_t object) {
  interrupt();
  document_.remove(object);
}

// --- the pointer -----------------------------------------------------------------------------------------------------

// Keeps the pressure and the typed number.
void Studio::place_pointer(double x, double y, const Modifiers& modifiers) {
  pointer_.x = x;
  pointer_.y = y;
  pointer_.modifiers = modifiers;
}

void Studio::press(const ButtonChanged& button) {
  place_pointer(button.x, button.y, button.modifiers);
  if (adjusting_) return stop_adjusting(button.button != MouseButton::right);
  if (history_.is_dragging() && button.button == MouseButton::right) return end_handle_drag(false);
  if (history_.is_dragging()) return;
  if (gesture_ && button.button == MouseButton::right) return end(false);
  if (masks_.is_drawing() && button.button == MouseButton::right) return masks_.end(false);
  if (gesture_ || masks_.is_drawing() || button.button != MouseButton::left || shown().opened == 0) return;
  if (shown().looked_at) {
    history_.look_at(std::nullopt);
    document_.tell({false, "This is the present shape again."});
    return;
  }
  if (fit_.is_open()) {
    if (is_beside_shape()) return begin_orbit(view_.navigation(), button);
    fit_.choose(pointer_, gesture_context());
    return;
  }
  const bool picks = tools_.picking_mirror() != StudioTools::PlanePick::none;
  if (picks && tools_.pick_plane(pointer_, gesture_context())) return;
  if (history_.begin_handle(view_.screen(), pointer_)) return;
  if (is_beside_shape()) return begin_orbit(view_.navigation(), button);
  begin();
}

void Studio::begin() {
  tools_.settings().pressure = preferences().pressure;
  clear_typed();
  const bool has_surface = shown().state.mesh->face_count() > 0;
  GestureContext around = gesture_context();
  if (has_surface && asks_hit_test()) around.hit_test = hit_test_;
  const bool is_behind = settings().tool->use == ToolUse::lattice && document_.worker().has_named_work();
  if (is_behind || (has_surface && around.picker == nullptr && !around.hit_test)) {
    document_.tell({false, "One moment: Studio is still preparing the shape."});
    return;
  }
  if (settings().tool->use == ToolUse::mask) return masks_.begin(pointer_, around);
  gesture_ = begin_gesture(pointer_, around, tools_.placed());
  if (!pending_) {
    pending_ = PendingStrokes{shown().state, {}};
    ended_strokes_.clear();
  }
  document_.withdraw(Subject::gesture);
  if (gesture_ && !gesture_->trouble.empty()) document_.tell({true, gesture_->trouble, Subject::gesture});
  if (settings().tool->use == ToolUse::stamp && !tools_.placed().stamp) tools_.use_stamp(ShapeKind::sphere);
  send_live();
}

void Studio::move(const PointerMoved& /*pointer_ has it*/) {
  if (adjusting_) adjust();
  if (history_.is_dragging()) history_.move_handle(view_.screen(), pointer_);
  if (masks_.is_drawing()) masks_.move(pointer_, gesture_context());
  if (!gesture_) return;
  move_gesture(pointer_, gesture_context(), tools_.placed(), *gesture_);
  send_live();
  moved_ = std::chrono::steady_clock::now();
}

// A pose that waits for the pointer is computed with all its detail.
void Studio::rest() {
  bool* const rests = gesture_ ? rests_of(*gesture_) : nullptr;
  const std::chrono::duration<double> waits = std::chrono::steady_clock::now() - moved_;
  const bool is_due = rests != nullptr && !*rests && !document_.worker().is_busy() && waits.count() > kRest;
  if (!is_due || settings().pose == PoseMode::exact) return;
  *rests = true;
  send_live(true);
}

void Studio::release(const ButtonChanged& button) {
  if (history_.is_dragging() && button.button == MouseButton::left) return end_handle_drag(true);
  if (masks_.is_drawing() && button.button == MouseButton::left) return masks_.end(true);
  if (!gesture_ || button.button != MouseButton::left) return;
  place_pointer(button.x, button.y, button.modifiers);
  accept();
}

void Studio::accept() {
  // The sent strokes are final now.
  GestureContext around = gesture_context();
  const std::size_t pins = tools_.placed().pins.size();
  end_gesture(pointer_, around, tools_.placed(), *gesture_);
  const auto* const pull = std::get_if<ImplicitGesture>(&gesture_->kind);
  const auto hit = pull == nullptr ? hit_at(pointer_, around) : std::nullopt;
  if (pull != nullptr) view_.note_stroke(pull->stroke.path.back());
  if (hit) view_.note_stroke(hit->point);
  tools_.note_set_pin(tools_.placed().pins.size() == pins + 1 ? std::optional(pins) : std::nullopt);
  send_live();
  end(true);
}

void Studio::send_live(bool gives_way) {
  if (!gesture_) return;
  std::vector<SessionStroke> live = lines_of(*gesture_, settings(), image_file);
  for (SessionStroke& line : live) {
    if (settings().remesh) line.remesh = settings().remesh_settings;
  }
  if (const auto* const lattice = std::get_if<LatticeGesture>(&gesture_->kind)) {
    // The steps of a drag are not remeshed, so that they take no longer than needed.
    if (!lattice->has_ended && !live.empty()) live.front().remesh.reset();
    if (!live.empty()) history_.grow(lattice->lattice.entry, live.front());
    return;
  }
  const auto sent = pending_->strokes.begin() + static_cast<std::ptrdiff_t>(ended_strokes_.size());
  if (std::equal(live.begin(), live.end(), sent, pending_->strokes.end())) return;
  pending_->strokes = ended_strokes_;
  pending_->strokes.insert(pending_->strokes.end(), live.begin(), live.end());
  const bool* const rests = rests_of(*gesture_);
  const bool follows = rests != nullptr && !*rests;
  sent_ = document_.post_latest(
      [live, follows](Document& document, Progress& progress) { document.set_live(live, progress, follows); },
      settings().tool->name, gives_way);
}

void Studio::end(bool is_kept) {
  const bool did_something = pending_ && pending_->strokes.size() > ended_strokes_.size();
  const bool was_placing =
      std::holds_alternative<GizmoGesture>(gesture_->kind) || std::holds_alternative<TurnGesture>(gesture_->kind);
  const auto* const turn = std::get_if<TurnGesture>(&gesture_->kind);
  const bool was_clicked = turn != nullptr && !(turn->placement && turn->has_gone);
  if (std::holds_alternative<LatticeGesture>(gesture_->kind)) history_.end_drag(is_kept);
  gesture_.reset();
  clear_typed();
  if (did_something) ++ended_;
  if (did_something && is_kept) {
    document_.worker().keep_latest();
    ended_strokes_ = pending_->strokes;
    document_.post([](Document& document, Progress& progress) { document.finish(progress); }, "Ending the stroke");
  } else if (did_something) {
    pending_->strokes = ended_strokes_;
    document_.post([](Document& document, Progress& progress) { document.give_up(progress); });
  }
  if (was_placing) tools_.find_limit_cylinder(was_clicked);
}

void Studio::turn_wheel(const WheelTurned& wheel) {
  if (wheel.modifiers.shift) {
    tools_.settings().inner_ratio = std::clamp(settings().inner_ratio + kRatioStep * wheel.steps, 0.01, 0.95);
  } else if (wheel.modifiers.ctrl) {
    tools_.fix_radius();
    tools_.settings().radius *= std::pow(kWheelFactor, wheel.steps);
  }
}

void Studio::undo() {
  if (gesture_) return end(false);
  if (masks_.is_drawing()) return masks_.end(false);
  if (!shown().history.empty()) tools_.take_stamp_back(shown().history.back()->strokes);
  history_.undo();
}

void Studio::redo() {
  if (!gesture_ && !masks_.is_drawing()) history_.redo();
}

void Studio::change_last(const std::function<void(SessionStroke&)>& change) {
  interrupt();
  refresh();
  if (shown().history.empty()) return;
  std::vector<SessionStroke> strokes = shown().history.back()->strokes;
  for (SessionStroke& stroke : strokes) change(stroke);
  history_.change(replaced(shown().history.size() - 1, std::move(strokes)));
}

bool Studio::can_refine_pose() const {
  const std::vector<SessionStroke>& strokes = shown().history.back()->strokes;
  return std::any_of(strokes.begin(), strokes.end(), [](const SessionStroke& stroke) {
    const auto* const pose = std::get_if<PoseStroke>(&stroke.stroke);
    return pose != nullptr && pose->detail > 0;
  });
}

void Studio::improve_pose() {
  refresh();
  if (shown().history.empty()) return;
  const bool refines = can_refine_pose();
  const std::vector<Vec3d> positions = shown().before_stroke.value_or(shown().state).positions.copy();
  change_last([&](SessionStroke& stroke) {
    auto* const pose = std::get_if<PoseStroke>(&stroke.stroke);
    if (pose == nullptr) return;
    pose->detail = 0;
    if (!refines) *pose = holding_less(std::move(*pose), positions, kRoomOfPose * shown().diagonal);
  });
}

void Studio::pose_placed() {
  const std::optional<Placement> joint = tools_.placed().placement;
  if (!joint) return;
  perform(action_of(studio_tool(ToolUse::pose)));
  tools_.settings().pose = PoseMode::pins;
  if (add_part_beyond(*joint, gesture_context(), tools_.placed())) return;
  tools_.settings().pose = PoseMode::lasso;
  document_.tell({false, "Draw a line round what shall turn, then drag it."});
}

void Studio::end_handle_drag(bool is_kept) {
  if (is_kept) history_.move_handle(view_.screen(), pointer_);
  history_.end_handle(is_kept);
}

// Writes the view to the journal when it rests.
void Studio::remember_view() {
  const bool is_moving = gesture_ || adjusting_ || view_.turntable() || view_.navigation().drag != NavigationDrag::none;
  if (shown().opened == 0 || is_moving) return;
  std::string view = script_of_view(*this);
  if (view == remembered_view_) return;
  remembered_view_ = view;
  document_.post(
      [view = std::move(view)](Document& document, Progress& /*progress*/) { document.remember_view(view); });
}

std::vector<Stroke> Studio::preview() const {
  if (!gesture_) return {};
  return strokes_of(*gesture_, settings(), image_file);
}

}  // namespace knead::studio
