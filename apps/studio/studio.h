// Knead Studio without its window: takes events, keeps the tools, the view and the work, and says what is to be seen.
//
// Used on one thread, the window's. The work is done on another (worker.h); without a thread everything is done before
// a call returns, which is what scripts and tests ask for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "document/document.h"
#include "gestures/gesture.h"
#include "gestures/navigation.h"
#include "gestures/tools.h"
#include "keys.h"
#include "knead/render/live_view.h"
#include "platform/event.h"
#include "platform/worker.h"
#include "preferences.h"

namespace knead::studio {

struct StudioOptions {
  std::filesystem::path config = config_folder();
  std::filesystem::path state = state_folder();
  bool has_worker = true;
  int threads = 0;  // of the deformation; 0: all
};

// How the shape is looked at.
struct ViewSettings {
  render::Material material = render::Material::clay;
  bool wireframe = false;
  bool influence = false;  // the region of influence as colour on the shape
  bool tool = true;        // the picture of the region
  bool cut = false;        // the cutting plane
  Vec3d cut_normal{1, 0, 0};
  double cut_offset = 0;  // from the middle of the shape as it was opened, along the normal
  bool panels = true;
  bool history = true;
  bool statistics = false;
  bool help = false;
};

// What hands have done that the worker has not: the shape as it was before, and the strokes since.
struct PendingStrokes {
  ShapeState start;
  std::vector<SessionStroke> strokes;
};

class Studio {
 public:
  explicit Studio(StudioOptions options);
  ~Studio();
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  void handle(const Event& event);

  // Takes what the worker has got done. To be called once a frame.
  void refresh();

  // What a key or a menu asks for. Actions that need a dialog are handed to the window: take_request.
  void perform(Action action);
  std::optional<Action> take_request() { return std::exchange(request_, std::nullopt); }
  std::vector<Notice> take_notices();
  void tell(Notice notice);

  // Files. By its extension: a session (.knead) or a shape.
  void open(const std::filesystem::path& path);
  void open_made(ShapeKind kind, std::size_t vertices);
  void save(const std::filesystem::path& path);
  void export_shape(const std::filesystem::path& path, bool as_double = false);
  void export_frames(const std::filesystem::path& pattern, int frames);
  const std::vector<std::filesystem::path>& recent() const { return recent_; }

  // Work that another run left behind, and what is to become of it.
  const std::vector<AbandonedJournal>& abandoned() const { return abandoned_; }
  void recover(std::filesystem::path journal);
  void discard(std::filesystem::path journal);

  // The history. edit: no strokes take the entry out.
  void undo();
  void redo();
  void edit(std::size_t entry, std::vector<SessionStroke> strokes);
  void look_at(std::optional<std::size_t> entries);
  void count_crossings();

  void use_stamp(ShapeKind kind);
  void use_stamp(const std::filesystem::path& file);  // which the stamp in the hand is then
  void clear_placed();

  // What panels show and change.
  ToolSettings& settings() { return settings_; }
  const ToolSettings& settings() const { return settings_; }
  ViewSettings& view() { return view_; }
  const ViewSettings& view() const { return view_; }
  Navigation& navigation() { return navigation_; }
  Preferences& preferences() { return preferences_; }
  const Placed& placed() const { return placed_; }
  const DocumentState& shown() const { return shown_; }
  // Of the gesture under way and those before it that are not done yet; null: the shape is as shown.
  const PendingStrokes* pending() const;
  const std::optional<Gesture>& gesture() const { return gesture_; }
  const Pointer& pointer() const { return pointer_; }
  bool pointer_is_over_view() const { return pointer_is_over_view_; }
  void set_pointer_over_view(bool is_over) { pointer_is_over_view_ = is_over; }
  bool is_adjusting() const { return adjusting_.has_value(); }
  bool is_busy() const { return worker_->is_busy(); }
  void cancel_work() { worker_->cancel(); }
  void wait() { worker_->wait(); }

  // Where a drag of a ball or capsule begins while the picker is behind; empty: it waits.
  void set_hit_test(HitTest hit_test) { hit_test_ = std::move(hit_test); }

  Screen screen() const;
  // The strokes as they are now with mirror images, or nothing where the hand is still: what the tool picture shows.
  std::vector<Stroke> preview() const;

  // The work is put away properly: its journal is removed. Else the next start offers it back.
  void close();

 private:
  struct Adjusting {
    Action what = Action::radius;
    double start_x = 0;
    double start_value = 0;
  };

  Surroundings surroundings() const;
  bool picker_is_right() const;
  bool asks_hit_test() const;
  void press(const ButtonChanged& button);
  void release(const ButtonChanged& button);
  void move(const PointerMoved& moved);
  void turn_wheel(const WheelTurned& wheel);
  void press_key(const KeyChanged& key);
  void choose(ToolKind tool);
  void adjust(double x);
  void begin();
  void send_live();
  void end(bool is_kept);
  void drop_files(const std::vector<std::filesystem::path>& files);
  void after_opening();
  void find_barrel(bool may_turn);
  void set_stamp(const std::function<StampShape()>& make);
  void frame_all();
  bool perform_view(Action action);
  bool perform_tool(Action action);
  void post(Worker::Job job);

  StudioOptions options_;
  Preferences preferences_;
  Navigation navigation_;
  ToolSettings settings_;
  ViewSettings view_;
  Placed placed_;
  Pointer pointer_;
  bool pointer_is_over_view_ = true;
  std::optional<Gesture> gesture_;
  std::uint64_t sent_ = 0;  // number of the last live job
  std::vector<Stroke> sent_strokes_;
  std::optional<PendingStrokes> pending_;
  std::vector<SessionStroke> ended_strokes_;  // of pending_, those of gestures that have ended
  std::uint64_t ended_ = 0;                   // gestures so far; shown_.ended of them are done
  HitTest hit_test_;
  std::optional<Adjusting> adjusting_;
  std::optional<Action> request_;
  std::vector<std::filesystem::path> recent_;
  std::vector<AbandonedJournal> abandoned_;
  DocumentState shown_;

  // Between the threads.
  struct Mailbox {
    std::mutex mutex;
    DocumentState shown;
    std::vector<Notice> notices;
    std::optional<std::pair<Placement, Placement>> barrel;  // as it was, and with its barrel
    std::optional<StampShape> stamp;
  };
  Mailbox mailbox_;
  Document document_;             // the worker's
  std::optional<Worker> worker_;  // ends before what its jobs use
};

}  // namespace knead::studio
