#include "studio.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "script.h"

namespace knead::studio {

namespace {

constexpr double kFirstRadius = 0.12;  // of the diagonal
constexpr double kWheelFactor = 1.1;
constexpr double kRatioStep = 0.05;
constexpr double kRest = 0.35;  // seconds without a move after which the pointer rests

std::filesystem::path journals_of(const StudioOptions& options) { return options.state / "journals"; }

DocumentOptions document_options(const StudioOptions& options, std::function<void(const DocumentState&)> show,
                                 std::function<void(Notice)> tell, std::function<void(std::string)> name_work) {
  DocumentOptions result;
  result.journals = journals_of(options);
  result.threads = options.threads;
  result.show = std::move(show);
  result.tell = std::move(tell);
  result.name_work = std::move(name_work);
  return result;
}

}  // namespace

Studio::Studio(StudioOptions options)
    : options_(std::move(options)),
      document_(document_options(
          options_,
          [this](const DocumentState& shown) {
            const std::lock_guard lock(mailbox_.mutex);
            mailbox_.shown = shown;
          },
          [this](Notice notice) { tell(std::move(notice)); },
          [this](std::string what) { worker_->name(std::move(what)); })) {
  worker_.emplace(options_.has_worker, [this](Progress& progress) { document_.when_idle(progress); });
  LoadedPreferences loaded = load_preferences(options_.config);
  preferences_ = std::move(loaded.preferences);
  for (std::string& message : loaded.messages) tell({true, std::move(message)});
  document_.limit_undo_memory(static_cast<std::size_t>(preferences_.undo_memory_mb * 1e6));
  navigation_.preset = preferences_.navigation;
  navigation_.view.up = preferences_.up;
  show_panels(preferences_.panels);
  navigation_.view.projection = preferences_.look.projection;
  navigation_.view.field_of_view_deg = preferences_.look.field_of_view_deg;
  view_.look = preferences_.look;
  recent_ = load_recent(options_.state);
  abandoned_ = abandoned_journals(journals_of(options_));
}

Studio::~Studio() { worker_.reset(); }

void Studio::save_preferences() {
  withdraw(Subject::preferences);
  try {
    studio::save_preferences(options_.config, preferences_);
  } catch (const IoError& error) {
    tell({true, error.what(), Subject::preferences});
  }
}

void Studio::show_panels(const PanelState& panels) {
  saved_panels_ = panels;
  view_.panels = panels.shown;
  view_.history = panels.history;
  view_.tool_labels = panels.labels;
}

void Studio::remember_panels() {
  PanelState now = preferences_.panels;
  now.shown = view_.panels;
  now.history = view_.history;
  now.labels = view_.tool_labels;
  if (now == saved_panels_) return;
  preferences_.panels = saved_panels_ = std::move(now);
  save_preferences();
}

void Studio::remember_window(const WindowPlace& window) {
  if (window == preferences_.window) return;
  preferences_.window = window;
  save_preferences();
}

void Studio::tell(Notice notice) {
  const std::lock_guard lock(mailbox_.mutex);
  const bool withdraws = !notice.is_error && mailbox_.troubled.erase(notice.subject) > 0;
  if (notice.text.empty() && !withdraws) return;
  if (notice.is_error && notice.subject != Subject::other) mailbox_.troubled.insert(notice.subject);
  mailbox_.notices.push_back(std::move(notice));
}

std::vector<Notice> Studio::take_notices() {
  const std::lock_guard lock(mailbox_.mutex);
  return std::exchange(mailbox_.notices, {});
}

void Studio::post(Worker::Job job, std::string what) {
  worker_->post(std::move(job), std::move(what));
  refresh();
}

void Studio::refresh() {
  const std::uint64_t opened = shown_.opened;
  {
    const std::lock_guard lock(mailbox_.mutex);
    if (mailbox_.shown.version != shown_.version) shown_ = mailbox_.shown;
    if (mailbox_.limit_cylinder && placed_.placement == mailbox_.limit_cylinder->first)
      placed_.placement = mailbox_.limit_cylinder->second;
    mailbox_.limit_cylinder.reset();
    if (mailbox_.stamp) placed_.stamp = std::exchange(mailbox_.stamp, std::nullopt);
  }
  if (shown_.opened != opened) after_opening();
  if (!shown_.recovered_view.empty() && restored_ != shown_.opened) {
    restored_ = shown_.opened;
    restore_view(*this, shown_.recovered_view);
  }
  if (!worker_->is_busy() && !layer_drag_) follow(layers_, shown_);
  if (layers_.entry && *layers_.entry >= shown_.history.size()) layers_ = {};
  if (!gesture_ && shown_.ended == ended_) pending_.reset();
  if (placed_.handles.size() != shown_.state.positions.size()) placed_.handles.clear();
  remember_view();
  refresh_mask();
  refresh_pins();
  rest();
  const bool has_limit_cylinder = placed_.placement && placed_.placement->limit_cylinder;
  if (has_limit_cylinder && !gesture_ && !worker_->is_busy() && shown_.state.mesh != limit_cylinder_mesh_)
    find_limit_cylinder(false);
}

void Studio::after_opening() {
  gesture_.reset();
  layers_ = {};
  layer_drag_.reset();
  turntable_.reset();
  remembered_view_.clear();
  masking_.reset();
  pending_.reset();
  ended_ = shown_.ended;
  const std::optional<StampShape> stamp = placed_.stamp;
  placed_ = {};
  settings_.radius = kFirstRadius * shown_.diagonal;
  view_.cut = false;
  frame_all();
  load_own_references();
  if (stamp) set_stamp([this, stamp] { return document_.add_stamp(stamp->name, *stamp->mesh); });
  if (shown_.shape_path.empty()) return;
  add_recent(recent_, std::filesystem::absolute(shown_.shape_path));
  try {
    save_recent(options_.state, recent_);
  } catch (const IoError& error) {
    tell({true, error.what()});
  }
}

Screen Studio::screen() const { return {camera_of(navigation_.view), navigation_.width, navigation_.height}; }

GestureContext Studio::gesture_context() const {
  const ShapeState& state = gesture_ ? gesture_->start : shown_.state;
  const bool fits = shown_.picker && shown_.picker->fits(state);
  const Picker* const picker = fits ? shown_.picker.get() : nullptr;
  return {screen(), state, picker, settings_, worker_->begun() >= sent_, {}, snap_length(shown_.diagonal)};
}

// Whether the picker knows the shape as it is seen.
bool Studio::picker_is_right() const {
  const bool fits = shown_.picker && shown_.picker->fits(shown_.state);
  return fits && !shown_.picker_is_behind && shown_.ended == ended_;
}

// Other gestures ask where they go on the surface, too, as it was when they began.
bool Studio::asks_hit_test() const {
  const bool asks_once = settings_.tool->use == ToolUse::pull;
  return hit_test_ && asks_once && settings_.drag != DragMode::surface && !picker_is_right();
}

const PendingStrokes* Studio::pending() const {
  const bool is_meant = pending_ && !pending_->strokes.empty() && shown_.refusal.empty();
  return is_meant ? &*pending_ : nullptr;
}

void Studio::frame_all() {
  if (shown_.opened == 0) return;
  const Box box = shape_box(shown_.state.to_mesh());
  navigation_.view = framed(navigation_.view, box, {navigation_.width, navigation_.height, navigation_.covered});
  navigation_.home = box.empty() ? std::nullopt : std::optional(box.center());
}

void Studio::handle(const Event& event) {
  refresh();
  if (const auto* moved = std::get_if<PointerMoved>(&event)) {
    pointer_.pressure = moved->pressure;
    placed_.lit_pin.reset();
    place_pointer(moved->x, moved->y, moved->modifiers);
  }
  set_pivot(event);
  const bool in_hand = gesture_ || adjusting_ || layer_drag_ || masking_;
  if (!in_hand && (change_pin(event) || navigate(navigation_, event))) return;
  struct Handler {
    Studio& studio;

    void operator()(const PointerMoved& e) const { studio.move(e); }
    void operator()(const ButtonChanged& e) const { e.down ? studio.press(e) : studio.release(e); }
    void operator()(const WheelTurned& e) const { studio.turn_wheel(e); }
    void operator()(const KeyChanged& e) const { studio.press_key(e); }
    void operator()(const FilesDropped& e) const { studio.drop_files(e.files); }
    void operator()(const Resized& e) const { navigate(studio.navigation_, e); }
  };
  std::visit(Handler{*this}, event);
}

void Studio::drop_files(const std::vector<std::filesystem::path>& files) {
  for (const std::filesystem::path& file : files) {
    const std::string extension = file.extension().string();
    const bool is_picture = extension == ".png" || extension == ".jpg" || extension == ".jpeg";
    if (!is_picture) open(file);
    if (is_picture) add_reference(file);
  }
}

// --- the pointer -----------------------------------------------------------------------------------------------------

// Keeps the pressure and what was typed.
void Studio::place_pointer(double x, double y, const Modifiers& modifiers) {
  pointer_.x = x;
  pointer_.y = y;
  pointer_.modifiers = modifiers;
}

void Studio::press(const ButtonChanged& button) {
  place_pointer(button.x, button.y, button.modifiers);
  if (adjusting_) return stop_adjusting(button.button != MouseButton::right);
  if (layer_drag_ && button.button == MouseButton::right) return end_handle_drag(false);
  if (layer_drag_) return;
  if (gesture_ && button.button == MouseButton::right) return end(false);
  if (masking_ && button.button == MouseButton::right) return end_masking(false);
  if (gesture_ || masking_ || button.button != MouseButton::left || shown_.opened == 0) return;
  if (shown_.looked_at) {
    look_at(std::nullopt);
    tell({false, "This is the present shape again."});
    return;
  }
  if (picking_ != PlanePick::none && pick_plane()) return;
  if (!begin_handle_drag()) begin();
}

void Studio::begin() {
  settings_.pressure = preferences_.pressure;
  clear_typed();
  const bool has_surface = shown_.state.mesh->face_count() > 0;
  GestureContext around = gesture_context();
  if (has_surface && asks_hit_test()) around.hit_test = hit_test_;
  if (has_surface && around.picker == nullptr && !around.hit_test) {
    tell({false, "One moment: Studio is still preparing the shape."});
    return;
  }
  if (settings_.tool->use == ToolUse::mask) return begin_masking();
  gesture_ = begin_gesture(pointer_, around, placed_);
  sent_strokes_.clear();
  if (!pending_) {
    pending_ = PendingStrokes{shown_.state, {}};
    ended_strokes_.clear();
  }
  withdraw(Subject::gesture);
  if (gesture_ && !gesture_->trouble.empty()) tell({true, gesture_->trouble, Subject::gesture});
  if (settings_.tool->use == ToolUse::stamp && !placed_.stamp) use_stamp(ShapeKind::sphere);
  send_live();
}

void Studio::move(const PointerMoved& /*pointer_ has it*/) {
  if (adjusting_) adjust();
  if (layer_drag_) move_handle();
  if (masking_) move_masking();
  if (!gesture_) return;
  move_gesture(pointer_, gesture_context(), placed_, *gesture_);
  send_live();
  moved_ = std::chrono::steady_clock::now();
}

// A pose that waits for the pointer is computed with all its detail.
void Studio::rest() {
  bool* const rests = gesture_ ? rests_of(*gesture_) : nullptr;
  const std::chrono::duration<double> waits = std::chrono::steady_clock::now() - moved_;
  const bool is_due = rests != nullptr && !*rests && !worker_->is_busy() && waits.count() > kRest;
  if (!is_due || settings_.pose == PoseMode::exact) return;
  *rests = true;
  send_live(true);
}

void Studio::release(const ButtonChanged& button) {
  if (layer_drag_ && button.button == MouseButton::left) return end_handle_drag(true);
  if (masking_ && button.button == MouseButton::left) return end_masking(true);
  if (!gesture_ || button.button != MouseButton::left) return;
  place_pointer(button.x, button.y, button.modifiers);
  accept();
}

void Studio::accept() {
  // Nothing waits any more that could still be changed: what was sent is kept as it is.
  GestureContext around = gesture_context();
  const std::size_t pins = placed_.pins.size();
  end_gesture(pointer_, around, placed_, *gesture_);
  set_pin_ = placed_.pins.size() == pins + 1 ? std::optional(pins) : std::nullopt;
  if (const auto* handles = std::get_if<HandlesGesture>(&gesture_->kind)) {
    const std::string refusal = refusal_of(*handles, settings_);
    if (!refusal.empty()) tell({true, refusal});
  }
  send_live();
  end(true);
}

void Studio::send_live(bool gives_way) {
  if (!gesture_) return;
  std::vector<SessionStroke> live = lines_of(*gesture_, settings_, image_file);
  for (SessionStroke& line : live) {
    if (settings_.remesh) line.remesh = settings_.remesh_settings;
  }
  if (live == sent_strokes_) return;
  sent_strokes_ = live;
  pending_->strokes = ended_strokes_;
  pending_->strokes.insert(pending_->strokes.end(), live.begin(), live.end());
  const bool* const rests = rests_of(*gesture_);
  const bool follows = rests != nullptr && !*rests;
  sent_ =
      worker_->post_latest([this, live, follows](Progress& progress) { document_.set_live(live, progress, follows); },
                           settings_.tool->name, gives_way);
  refresh();
}

void Studio::end(bool is_kept) {
  const bool did_something = !sent_strokes_.empty();
  const bool was_placing =
      std::holds_alternative<GizmoGesture>(gesture_->kind) || std::holds_alternative<TurnGesture>(gesture_->kind);
  const auto* const turn = std::get_if<TurnGesture>(&gesture_->kind);
  const bool was_clicked = turn != nullptr && !(turn->placement && turn->has_gone);
  gesture_.reset();
  clear_typed();
  sent_strokes_.clear();
  if (did_something) ++ended_;
  if (did_something && is_kept) {
    worker_->keep_latest();
    ended_strokes_ = pending_->strokes;
    post([this](Progress& progress) { document_.finish(progress); }, "Ending the stroke");
  } else if (did_something) {
    pending_->strokes = ended_strokes_;
    post([this](Progress& progress) { document_.give_up(progress); });
  }
  if (was_placing) find_limit_cylinder(was_clicked);
}

void Studio::find_limit_cylinder(bool may_turn) {
  const Turning& turning = settings_.tool->turning;
  if (!turning.takes_limit_cylinder || !placed_.placement) return;
  limit_cylinder_mesh_ = shown_.state.mesh;
  const Placement placement = *placed_.placement;
  const bool bends = turning.axis == &Placement::x;
  const auto find = [this, placement, bends, may_turn, settings = settings_](Progress& progress) {
    try {
      Placement found = settings.uses_limit_cylinder
                            ? document_.with_limit_cylinder(placement, bends, may_turn, progress)
                            : placement;
      found.profile = document_.profile(settings, found);
      const std::lock_guard lock(mailbox_.mutex);
      mailbox_.limit_cylinder = {placement, found};
    } catch (const Cancelled&) {
      tell({false, "The search for the part was stopped; the tool moves everything below its plane."});
    }
  };
  post(find, "Looking for the part to move");
}

void Studio::turn_wheel(const WheelTurned& wheel) {
  if (wheel.modifiers.shift) {
    settings_.inner_ratio = std::clamp(settings_.inner_ratio + kRatioStep * wheel.steps, 0.01, 0.95);
  } else if (wheel.modifiers.ctrl) {
    fix_radius();
    settings_.radius *= std::pow(kWheelFactor, wheel.steps);
  }
}

// --- files and history -----------------------------------------------------------------------------------------------

void Studio::open(const std::filesystem::path& path) {
  if (path.extension() == ".knead") {
    post([this, path](Progress& progress) { document_.open_session(path, progress); }, "Opening the session");
  } else {
    post([this, path](Progress& progress) { document_.open_shape(path, progress); }, "Opening the shape");
  }
}

void Studio::open_made(ShapeKind kind, std::size_t vertices) {
  post([this, kind, vertices](Progress& progress) { document_.open_made(kind, vertices, progress); },
       "Making the shape");
}

void Studio::save(const std::filesystem::path& path) {
  post([this, path](Progress& /*progress*/) { document_.save(path); }, "Saving");
}

void Studio::export_shape(const std::filesystem::path& path, bool as_double) {
  post([this, path, as_double](Progress& progress) { document_.export_shape(path, as_double, progress); }, "Exporting");
}

void Studio::export_frames(const std::filesystem::path& file, const FrameExport& how) {
  post([this, file, how](Progress& progress) { document_.export_frames(file, how, progress); }, "Exporting frames");
}

// The path may be one of those that are erased.
void Studio::recover(std::filesystem::path journal) {
  std::erase_if(abandoned_, [&](const AbandonedJournal& one) { return one.folder == journal; });
  post([this, journal](Progress& progress) { document_.recover(journal, progress); }, "Recovering");
}

void Studio::discard(std::filesystem::path journal) {
  std::erase_if(abandoned_, [&](const AbandonedJournal& one) { return one.folder == journal; });
  discard_journal(journal);
}

void Studio::undo() {
  if (gesture_) return end(false);
  if (masking_) return end_masking(false);
  post([this](Progress& progress) { document_.undo(progress); }, "Undo");
}

void Studio::redo() {
  if (gesture_ || masking_) return;
  post([this](Progress& progress) { document_.redo(progress); }, "Redo");
}

void Studio::look_at(std::optional<std::size_t> entries) {
  if (gesture_) end(false);
  post([this, entries](Progress& progress) { document_.look_at(entries, progress); }, "Making the earlier shape");
}

void Studio::look_at_frame(const FrameExport& how, int frame) {
  if (gesture_) end(false);
  const auto look = [this, how, frame](Progress& progress) { document_.look_at_frame(how, frame, progress); };
  worker_->post_latest(look, "Making the frames");
}

void Studio::count_crossings() {
  post([this](Progress& progress) { document_.count_crossings(progress); }, "Counting crossings");
}

void Studio::remesh_last() {
  if (gesture_) end(false);
  refresh();
  if (shown_.history.empty()) return;
  std::vector<SessionStroke> strokes = shown_.history.back()->strokes;
  for (SessionStroke& stroke : strokes) stroke.remesh = settings_.remesh_settings;
  change_layers(replaced(shown_.history.size() - 1, std::move(strokes)));
}

void Studio::set_stamp(const std::function<StampShape()>& make) {
  const auto load = [this, make](Progress& progress) {
    withdraw(Subject::stamp);
    try {
      StampShape stamp = make();
      stop_if_cancelled(&progress);
      const std::lock_guard lock(mailbox_.mutex);
      mailbox_.stamp = std::move(stamp);
    } catch (const Cancelled&) {
      tell({false, "The stamp was not loaded."});
    } catch (const std::exception& error) {
      tell({true, error.what(), Subject::stamp});
    }
  };
  post(load, "Loading the stamp");
}

void Studio::use_stamp(ShapeKind kind) {
  set_stamp([this, kind] {
    return document_.add_stamp(std::string(shape_names()[static_cast<std::size_t>(kind)]), make_shape(kind));
  });
}

void Studio::use_stamp(const std::filesystem::path& file) {
  if (gesture_) end(false);
  settings_.tool = &studio_tool(ToolUse::stamp);
  set_stamp([this, file] { return document_.add_stamp(file.stem().string(), read_shape(file).mesh); });
}

void Studio::clear_placed() {
  PlacedTools kept;
  kept.stamp = std::move(placed_.stamp);
  select_pins(false);
  select_part(std::nullopt);
  kept.pins = std::move(placed_.pins);
  kept.parts = std::move(placed_.parts);
  placed_ = std::move(kept);
  picking_ = PlanePick::none;
}

std::vector<Stroke> Studio::preview() const {
  if (!gesture_) return {};
  return strokes_of(*gesture_, settings_, image_file);
}

void Studio::close() {
  post([this](Progress& /*progress*/) { document_.close(); });
  worker_->wait();
}

}  // namespace knead::studio
