// Knead Studio without its window: takes events, holds the document, the tools, the view, the history and the masks,
// and tells what to show.
//
// Used on the window's thread only. The deformation runs on another (worker.h); without that thread every call returns
// when its work is done, as scripts and tests need it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gestures/gesture.h"
#include "gestures/tools.h"
#include "keys.h"
#include "platform/window.h"
#include "studio_document.h"
#include "studio_fit.h"
#include "studio_history.h"
#include "studio_tools.h"
#include "studio_view.h"

namespace knead::studio {

// The strokes that the worker has not completed yet, and the shape before them.
struct PendingStrokes {
  ShapeState start;
  std::vector<SessionStroke> strokes;
};

// A number that the pointer sets: of the current gesture, or a setting that follows the pointer.
struct PointedNumber {
  Amount amount;
  std::string typed;          // what has been typed instead of it so far
  bool is_adjusting = false;  // a setting
};

class Studio {
 public:
  explicit Studio(const StudioOptions& options);
  ~Studio() { document_.end_work(); }  // its jobs use the tools
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  void handle(const Event& event);

  // Takes over the completed work of the worker. Call this once a frame.
  void refresh();

  // Performs an action of a key or menu. Actions that need a dialog go to the window, by take_request().
  void perform(Action action);
  std::optional<Action> take_request() { return std::exchange(request_, std::nullopt); }

  StudioDocument& document() { return document_; }
  const StudioDocument& document() const { return document_; }
  StudioTools& tools() { return tools_; }
  const StudioTools& tools() const { return tools_; }
  StudioView& view() { return view_; }
  const StudioView& view() const { return view_; }
  StudioHistory& history() { return history_; }
  const StudioHistory& history() const { return history_; }
  const StudioMasks& masks() const { return masks_; }
  StudioFit& fit() { return fit_; }
  const StudioFit& fit() const { return fit_; }
  Preferences& preferences() { return preferences_.preferences; }
  const Preferences& preferences() const { return preferences_.preferences; }
  void save_preferences() { preferences_.save(document_); }

  // Adds a shape to those that are open; the history moves it, too.
  void add_shape(const std::filesystem::path& path);
  // Removes one of several objects.
  void remove_object(std::size_t object);
  // Changes the whole mask, as a stroke of its own.
  void change_mask(MaskEdit edit);
  // Applies the last stroke, a pose that fell short, again: with a detail that fits its parts, or if it had that, with
  // fewer holding points.
  void improve_pose();
  // Returns whether improve_pose() would make it finer.
  bool can_refine_pose() const;
  // Chooses the tool Pose, and makes a part of the vertices beyond the placed twist or bend.
  void pose_placed();
  // Moves the pin with this number in placed().pins as a drag does: by a stroke.
  void move_pin(std::size_t pin, const Vec3d& to);

  // Returns the strokes of the current gesture and of earlier ones that are not completed; null if there are none.
  const PendingStrokes* pending() const;
  const std::optional<Gesture>& gesture() const { return gesture_; }
  // Returns the strokes of the current gesture with mirror images, which the tool picture shows; empty if there is
  // none.
  std::vector<Stroke> preview() const;
  // Returns what Escape would do while nothing is dragged, in a word for a button; null: nothing.
  const char* cancellable() const;
  // Returns the number that the pointer sets.
  std::optional<PointedNumber> number() const;
  const Pointer& pointer() const { return pointer_; }
  // Returns whether a drag is changing the shape, a number, the history or a mask.
  bool is_in_hand() const { return gesture_ || adjusting_ || history_.is_dragging() || masks_.is_drawing(); }
  bool pointer_is_over_view() const { return pointer_is_over_view_; }
  void set_pointer_over_view(bool is_over) { pointer_is_over_view_ = is_over; }
  // Returns the pin that is dragged, or that the panel or the pointer points to.
  std::optional<std::size_t> pointed_pin() const;

  // Sets the hit test by which a drag of a ball or capsule finds its start while the picker is not up to date. Empty:
  // the drag waits for the picker.
  void set_hit_test(HitTest hit_test) { hit_test_ = std::move(hit_test); }

 private:
  struct Adjusting {
    Action what = Action::radius;
    double start_x = 0;
    double start_value = 0;
    bool was_auto = false;  // the radius, of pins
  };

  const DocumentState& shown() const { return document_.shown(); }
  const ToolSettings& settings() const { return tools_.settings(); }
  GestureContext gesture_context() const;
  std::optional<Amount> amount() const;
  void place_pointer(double x, double y, const Modifiers& modifiers);
  bool type(const KeyChanged& key);
  void follow_typed();
  void accept();
  void clear_typed();
  bool picker_is_right() const;
  bool is_beside_shape() const;
  bool asks_hit_test() const;
  void press(const ButtonChanged& button);
  void release(const ButtonChanged& button);
  void move(const PointerMoved& moved);
  void turn_wheel(const WheelTurned& wheel);
  void press_key(const KeyChanged& key);
  void choose(const StudioTool& tool);
  void save();
  void cancel();
  void undo();
  void redo();
  void adjust();
  void begin_adjusting(Action what);
  void stop_adjusting(bool is_kept);
  void begin();
  void send_live(bool gives_way = false);  // gives_way: the pointer may go on
  void rest();
  void end(bool is_kept);
  void interrupt();  // gives up the current gesture
  void end_handle_drag(bool is_kept);
  void remember_view();
  void change_last(const std::function<void(SessionStroke&)>& change);  // applies the last entry again
  void apply(std::vector<SessionStroke> strokes);
  void refresh_pins();
  bool change_pin(const Event& event);
  bool change_part(const ButtonChanged& button);
  bool propose_limb(const ButtonChanged& button);
  bool perform_mask(Action action);
  void drop_files(const std::vector<std::filesystem::path>& files);
  void begin_document();

  StudioDocument document_;
  PreferencesFile preferences_;
  StudioTools tools_;
  StudioView view_;
  StudioHistory history_;
  StudioMasks masks_;
  StudioFit fit_;
  Pointer pointer_;
  bool pointer_is_over_view_ = true;
  std::optional<Gesture> gesture_;
  std::chrono::steady_clock::time_point moved_{};  // when the gesture last was
  std::string typed_;
  std::uint64_t sent_ = 0;  // number of the last live job
  std::optional<PendingStrokes> pending_;
  std::vector<SessionStroke> ended_strokes_;  // of pending_, those of gestures that have ended
  std::uint64_t ended_ = 0;                   // gestures so far; shown().ended of them are done
  HitTest hit_test_;
  std::optional<Adjusting> adjusting_;
  std::string remembered_view_;  // as it stands in the journal
  std::uint64_t restored_ = 0;   // shown().opened of the document whose view was restored last
  std::optional<Action> request_;
};

}  // namespace knead::studio
