// Knead Studio without its window: takes events, holds the tools, the view and the document, and tells what to show.
//
// Used on the window's thread only. The deformation runs on another (worker.h); without that thread every call returns
// when its work is done, as scripts and tests need it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "document/document.h"
#include "document/layers.h"
#include "gestures/gesture.h"
#include "gestures/navigation.h"
#include "gestures/tools.h"
#include "keys.h"
#include "knead/render.h"
#include "platform/window.h"
#include "platform/worker.h"
#include "preferences.h"

namespace knead::studio {

struct StudioOptions {
  std::filesystem::path config = config_folder();
  std::filesystem::path state = state_folder();
  bool has_worker = true;
  int threads = 0;  // of the deformation; 0: all
};

// What the colours of stretches refer to.
enum class StretchView { off, since_start, last_stroke };

// How the shape is looked at.
struct ViewSettings {
  Look look;  // but for the projection, which is the navigation's
  bool wireframe = false;
  bool influence = false;  // the region of influence as colour on the shape
  bool tool = true;        // the cursor on the surface, and the picture of what is placed
  bool region = false;     // the region of influence at the cursor as translucent surfaces
  bool references = true;  // the pictures behind the shape
  bool cut = false;        // the cutting plane
  StretchView stretch = StretchView::off;
  Vec3d cut_normal{1, 0, 0};
  double cut_offset = 0;  // from the middle of the shape as it was opened, along the normal
  bool panels = true;
  bool tool_labels = false;  // names beside the icons of the tool bar
  bool history = true;
  bool statistics = false;
  bool help = false;
};

// Returns the step of lengths while Ctrl is held: 1, 2 or 5 times a power of ten, about a hundredth of the diagonal.
double snap_length(double diagonal);

inline constexpr int kMaxTurntablePictures = 9999;

// A recording of the shape from all around: numbered pictures, evenly spaced about the axis that is up.
struct Turntable {
  std::filesystem::path pattern;  // with %04d in its name
  int pictures = 0;
  int next = 0;  // the number of the next picture, from 0
  View start;    // the view of the first picture, which is also that afterwards
};

// Returns a recording that has not begun, with a numbered() pattern. Throws InvalidInput for another format than PNG,
// and for a number of pictures outside [2, kMaxTurntablePictures].
Turntable make_turntable(const std::filesystem::path& pattern, int pictures, const View& view);

// Return the view and the file of the next picture.
View view_of(const Turntable& turntable);
std::filesystem::path file_of(const Turntable& turntable);

// The strokes that the worker has not completed yet, and the shape before them.
struct PendingStrokes {
  ShapeState start;
  std::vector<SessionStroke> strokes;
};

// A handle of a past entry that is being dragged.
struct LayerDrag {
  std::size_t entry = 0;
  LayerHandle handle;
  Vec3d start;                         // where the handle was
  Vec3d offset;                        // from where the pointer took hold of it
  std::vector<SessionStroke> strokes;  // of the entry, as they were
};

class Studio {
 public:
  explicit Studio(StudioOptions options);
  ~Studio();
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  void handle(const Event& event);

  // Takes over what the worker has completed. To be called once a frame.
  void refresh();

  // Does what a key or a menu asks for. Actions that need a dialog go to the window: take_request.
  void perform(Action action);
  std::optional<Action> take_request() { return std::exchange(request_, std::nullopt); }
  std::vector<Notice> take_notices();
  void tell(Notice notice);
  // Withdraws the errors about it.
  void withdraw(Subject subject) { tell({false, {}, subject}); }

  // Files. By its extension: a session (.knead) or a shape.
  void open(const std::filesystem::path& path);
  void open_made(ShapeKind kind, std::size_t vertices);
  void save(const std::filesystem::path& path);
  void export_shape(const std::filesystem::path& path, bool as_double = false);
  void export_frames(const std::filesystem::path& file, const FrameExport& how);
  const std::vector<std::filesystem::path>& recent() const { return recent_; }

  // Unsaved work of an earlier run, and what to do with it.
  const std::vector<AbandonedJournal>& abandoned() const { return abandoned_; }
  void recover(std::filesystem::path journal);
  void discard(std::filesystem::path journal);

  // The history. Changes of its entries (document/layers.h) are made in the background: what is seen stays until they
  // are done, and Escape stops them. The steps of a drag are one change.
  void undo();
  void redo();
  void change_layers(const LayerChange& change);
  void drag_layers(const LayerChange& change);
  void end_layer_drag(bool is_kept);
  void select_layer(std::optional<std::size_t> entry);
  LayerEditor& layers() { return layers_; }
  const LayerEditor& layers() const { return layers_; }
  // Returns the handle of the selected entry that the pointer is on, or drags.
  std::optional<LayerHandle> pointed_handle() const;
  void look_at(std::optional<std::size_t> entries);
  void look_at_frame(const FrameExport& how, int frame);  // from 0; look_at shows the present shape again
  void count_crossings();

  // The next click on the shape (`face`), or the next three, give one more mirror's plane. A second call gives that up.
  enum class PlanePick { none, face, three_points };
  void pick_mirror(PlanePick how);
  PlanePick picking_mirror() const { return picking_; }
  // Moves the mirrors x, y and z and the axis to the middle of the shape's box.
  void center_symmetry();
  // Records a turntable: every step_turntable shows the next view and has it written. It returns false at the end.
  void record_turntable(const std::filesystem::path& pattern, int pictures);
  bool step_turntable(const std::function<void(const std::filesystem::path&)>& write);
  const std::optional<Turntable>& turntable() const { return turntable_; }

  // Changes the whole mask, as a stroke of its own.
  void change_mask(MaskEdit edit);
  // How much each vertex is masked, as painted so far; empty: no vertex is.
  const MaskValues& mask_values() const { return mask_values_; }
  // The line that is being drawn round what will be masked or marked; empty: none is.
  std::vector<Pixel> drawn_line() const;
  bool is_masking() const { return masking_.has_value(); }

  void use_stamp(ShapeKind kind);
  void use_stamp(const std::filesystem::path& file);  // also chooses the stamp tool
  // Removes what is placed, but for pins and the stamp. No pin stays selected.
  void clear_placed();

  // Pins, by their number in placed().pins. move_pin makes a stroke, as a drag does. set_pins replaces all; a pin whose
  // vertex is not known takes the nearest one.
  void set_pins(std::vector<Pin> pins);
  void hold_pin(std::size_t pin, bool holds);
  void select_pins(bool are_selected);
  void move_pin(std::size_t pin, const Vec3d& to);
  void remove_pin(std::size_t pin);
  void clear_pins();
  // Parts of a pose, by their number. They stay through clear_placed, which selects none.
  void select_part(std::optional<std::size_t> part);
  void remove_part(std::size_t part);
  // Returns the pin that is dragged, or that the panel or the pointer points to.
  std::optional<std::size_t> pointed_pin() const;

  // Returns the radius of the tool: of pins that which they give themselves, unless it is set. fix_radius sets it.
  double radius() const;
  void fix_radius();

  // What panels show and change.
  ToolSettings& settings() { return settings_; }
  const ToolSettings& settings() const { return settings_; }
  ViewSettings& view() { return view_; }
  const ViewSettings& view() const { return view_; }
  Navigation& navigation() { return navigation_; }
  const Navigation& navigation() const { return navigation_; }
  Preferences& preferences() { return preferences_; }
  // Writes the preferences to their file; a notice says if that failed.
  void save_preferences();
  // Writes them if panels are shown, hidden, resized or folded otherwise than when they were last written.
  void remember_panels();
  const Preferences& preferences() const { return preferences_; }
  std::vector<Reference>& references() { return references_; }
  const std::vector<Reference>& references() const { return references_; }
  PlacedTools& placed() { return placed_; }
  const PlacedTools& placed() const { return placed_; }
  const DocumentState& shown() const { return shown_; }
  // Returns the strokes of the current gesture and of earlier ones that are not completed; null if there are none.
  const PendingStrokes* pending() const;
  const std::optional<Gesture>& gesture() const { return gesture_; }
  const Pointer& pointer() const { return pointer_; }
  bool pointer_is_over_view() const { return pointer_is_over_view_; }
  void set_pointer_over_view(bool is_over) { pointer_is_over_view_ = is_over; }
  bool is_adjusting() const { return adjusting_.has_value(); }
  // Returns the number of the current gesture, or of the setting that follows the pointer; and what has been typed
  // instead of it so far, as text.
  std::optional<Amount> amount() const;
  const std::string& typed() const { return typed_; }
  // Returns the thread that does the work, to ask it or to wait for it.
  const Worker& worker() const { return *worker_; }

  // Sets how a drag of a ball or capsule finds its start while the picker is not up to date; empty: it waits.
  void set_hit_test(HitTest hit_test) { hit_test_ = std::move(hit_test); }

  Screen screen() const;
  // Returns the strokes of the current gesture with mirror images, which the tool picture shows; empty if there is
  // none.
  std::vector<Stroke> preview() const;

  // Puts the picture in a PNG or JPEG file behind the shape, in the plane that the view looks at. Returns false if it
  // cannot be read, and tells why.
  bool add_reference(const std::filesystem::path& file);

  // Takes over into the preferences how the shape is drawn, and saves them if that differs from what they were.
  // Saves the references of the document, too, if they differ.
  void remember_look();

  // Writes the size of the window into the preferences.
  void remember_window(const WindowPlace& window);

  // Closes the document and removes its journal. Otherwise the next start offers to recover it.
  void close();

 private:
  struct Adjusting {
    Action what = Action::radius;
    double start_x = 0;
    double start_value = 0;
    bool was_auto = false;  // the radius, of pins
  };

  // The mask being painted, or drawn round.
  struct Masking {
    MaskValues before;
    bool erases = false;
    std::vector<Pixel> line;
    Screen screen;
  };

  GestureContext gesture_context() const;
  void place_pointer(double x, double y, const Modifiers& modifiers);
  bool type(const KeyChanged& key);
  void follow_typed();
  void accept();
  void clear_typed();
  bool picker_is_right() const;
  bool asks_hit_test() const;
  void press(const ButtonChanged& button);
  void release(const ButtonChanged& button);
  void move(const PointerMoved& moved);
  void turn_wheel(const WheelTurned& wheel);
  void press_key(const KeyChanged& key);
  void choose(const StudioTool& tool);
  void adjust();
  void begin_adjusting(Action what);
  void stop_adjusting(bool is_kept);
  void begin();
  void send_live(bool gives_way = false);  // gives_way: the pointer may go on
  void rest();
  void end(bool is_kept);
  bool begin_handle_drag();
  void move_handle();
  void end_handle_drag(bool is_kept);
  void stop_turntable();
  void remember_view();
  void show_panels(const PanelState& panels);
  void remesh_last();  // applies the last stroke again, and remeshes it
  void refresh_mask();
  void begin_masking();
  void move_masking();
  void paint_mask();
  void end_masking(bool is_kept);
  void apply_mask();
  void apply(std::vector<SessionStroke> strokes);
  void refresh_pins();
  void select_pin(std::size_t pin, bool is_selected);
  bool change_pin(const Event& event);
  bool change_part(const ButtonChanged& button);
  bool propose_limb(const ButtonChanged& button);
  bool perform_mask(Action action);
  void drop_files(const std::vector<std::filesystem::path>& files);
  void after_opening();
  void find_limit_cylinder(bool may_turn);
  void set_stamp(const std::function<StampShape()>& make);
  void frame_all();
  void frame_stroke();
  bool pick_plane();
  void set_pivot(const Event& event);
  void load_own_references();
  bool perform_view(Action action);
  bool perform_tool(Action action);
  void post(Worker::Job job, std::string what = {});

  StudioOptions options_;
  Preferences preferences_;
  PanelState saved_panels_;
  Navigation navigation_;
  ToolSettings settings_;
  ViewSettings view_;
  std::vector<Reference> references_;
  std::vector<Reference> saved_references_;
  PlacedTools placed_;
  Pointer pointer_;
  bool pointer_is_over_view_ = true;
  std::optional<Gesture> gesture_;
  std::chrono::steady_clock::time_point moved_{};  // when the gesture last was
  std::string typed_;
  PlanePick picking_ = PlanePick::none;
  std::uint64_t sent_ = 0;  // number of the last live job
  std::vector<SessionStroke> sent_strokes_;
  std::optional<PendingStrokes> pending_;
  std::vector<SessionStroke> ended_strokes_;  // of pending_, those of gestures that have ended
  std::uint64_t ended_ = 0;                   // gestures so far; shown_.ended of them are done
  MaskValues mask_values_;
  Mask values_mask_;                         // the document's when the values were made
  std::shared_ptr<const Mesh> values_mesh_;  // the document's mesh then
  std::optional<Masking> masking_;
  std::shared_ptr<const Mesh>
      limit_cylinder_mesh_;  // of the shape when the limit cylinder was looked for; a remesh may follow later
  HitTest hit_test_;
  std::optional<std::size_t> set_pin_;  // that the last click has set
  std::optional<Adjusting> adjusting_;
  LayerEditor layers_;
  std::optional<LayerDrag> layer_drag_;
  std::optional<Turntable> turntable_;
  std::string remembered_view_;  // as it stands in the journal
  std::uint64_t restored_ = 0;   // shown_.opened of the document whose view was restored last
  std::optional<Action> request_;
  std::vector<std::filesystem::path> recent_;
  std::vector<AbandonedJournal> abandoned_;
  DocumentState shown_;

  // Between the threads.
  struct Mailbox {
    std::mutex mutex;
    DocumentState shown;
    std::vector<Notice> notices;
    std::set<Subject> troubled;                                     // of errors that were told and not withdrawn
    std::optional<std::pair<Placement, Placement>> limit_cylinder;  // as it was, and with its limit cylinder
    std::optional<StampShape> stamp;
  };
  Mailbox mailbox_;
  Document document_;             // the worker's
  std::optional<Worker> worker_;  // ends before what its jobs use
};

}  // namespace knead::studio
