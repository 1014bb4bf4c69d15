// The loop of the window: events, panels, the picture.
#include "application.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "knead/editor/render.h"
#include "knead/io.h"
#include "panels/interface.h"
#include "platform/gui.h"
#include "platform/window.h"
#include "studio.h"
#include "view/overlay.h"
#include "view/shown_shape.h"

namespace knead::studio {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kFirstVertices = 40'000;
constexpr double kIdleWait = 0.1;  // seconds between looks at what the worker has done, when nothing happens
constexpr double kBusyWait = 0.002;
// After the last event panels move for this many seconds and frames.
constexpr double kStaysActive = 0.4;
constexpr int kFramesToSettle = 4;
constexpr double kWaitForStep = 0.012;  // for a step of a drag that is likely to be done by then
constexpr double kLikelyDoneWithin = 0.010;
constexpr int kPictureScale = 2;
constexpr int kMaxWindows = 5;  // one after the other, where the driver loses them

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

// Discards the journals of other runs that are empty or saved.
void discard_needless_journals(Studio& studio) {
  const std::vector<AbandonedJournal> journals = studio.document().abandoned();
  for (const AbandonedJournal& journal : journals) {
    const bool is_needless = journal.strokes == 0 || journal.is_saved;
    if (is_needless && journal.problem.empty()) studio.document().discard(std::filesystem::path(journal.folder));
  }
}

void begin(Studio& studio, const ApplicationOptions& options) {
  if (options.backend) studio.preferences().backend = *options.backend;
  if (options.shape) {
    studio.document().open(*options.shape);
  } else {
    studio.document().open_made(ShapeKind::sphere, kFirstVertices);
  }
  for (const std::filesystem::path& shape : options.also) studio.document().add(shape);
  if (options.session) studio.document().open(*options.session);
}

}  // namespace

// A window with all that is drawn in it.
class Application {
 public:
  explicit Application(Studio& studio)
      : window_("Knead Studio", studio.preferences().window),
        studio_(studio),
        gui_(window_.scale() * studio.preferences().interface_scale),
        backend_(window_),
        interface_(studio, gui_,
                   {[this] { window_.toggle_full_screen(); },
                    [this](const std::filesystem::path& path) { write_picture(path); }}) {
    gui_.set_touch(window_.has_touch());
    interface_.set_size(window_.width(), window_.height());
  }
  ~Application() { studio_.set_hit_test({}); }
  Application(const Application&) = delete;
  Application& operator=(const Application&) = delete;

  WindowPlace place() const { return window_.place(); }

  // Until the person quits, or the driver has lost what is drawn: false.
  bool run() {
    while (!has_ended()) {
      if (view_.is_lost()) return false;
      step();
    }
    return true;
  }

  bool has_ended() const { return interface_.has_ended(); }

  void welcome() { interface_.welcome(); }

  std::string message() const {
    const auto& messages = interface_.messages().messages;
    return messages.empty() ? std::string() : messages.back().notice.text;
  }

  // Takes the events, and draws a picture if something changes.
  void step() {
    note_picture();
    const std::vector<Event> events = window_.events(studio_.document().worker().is_busy() ? kBusyWait : kIdleWait);
    studio_.refresh();
    const Clock::time_point now = Clock::now();
    const std::uint64_t version = studio_.document().shown().version;
    const bool is_changed = !events.empty() || version != drawn_version_ || window_.is_closing();
    if (is_changed) last_changed_ = now;
    if (is_changed || studio_.document().worker().is_busy()) {
      last_active_ = now;
      frames_since_ = 0;
    }
    const bool has_settled = frames_since_ >= kFramesToSettle && seconds_between(last_active_, now) > kStaysActive;
    if (has_settled) studio_.view().remember_look();
    const bool is_moving = interface_.has_messages() || studio_.view().turntable() || view_.is_sorting();
    if (has_settled && !is_moving && fineness_ == Fineness::smooth) {
      last_frame_.reset();
      return;
    }
    fineness_ = quality_.fineness(seconds_between(last_changed_, now) > kStaysActive);
    draw_frame(events);
    ++frames_since_;
    drawn_version_ = version;
  }

 private:
  void draw_frame(const std::vector<Event>& events) {
    const Clock::time_point began = Clock::now();
    backend_.begin_frame(window_);
    gui_.set_touch(window_.has_touch());
    gui_.begin_frame(events);
    interface_.handle(events);
    if (window_.is_closing()) {
      window_.set_closing(false);
      interface_.close();
    }
    wait_for_step();
    studio_.refresh();
    interface_.draw(times_, {overlay_.knows_stretch(), estimate_.update(studio_)});
    const bool is_new = draw_picture();
    studio_.view().step_turntable([this](const std::filesystem::path& path) { write_view(path); });
    gui_.end_frame();
    backend_.draw();
    times_.drawing = seconds_between(began, Clock::now());
    window_.show();
    note_time();
    set_title();
    if (is_new) began_ = began;
  }

  // A page's browser shows a picture after the step: the next step begins when it is ready for another one.
  void note_picture() {
    if (const auto began = std::exchange(began_, {})) quality_.note(seconds_between(*began, Clock::now()), fineness_);
  }

  // Gives a quick step of a drag the time to be in this very picture.
  void wait_for_step() const {
    if (!studio_.gesture() || studio_.document().shown().live_seconds > kLikelyDoneWithin) return;
    if (shape_.gpu() != nullptr && shape_.gpu()->is_ahead()) return;
    const Clock::time_point began = Clock::now();
    while (studio_.document().worker().is_busy() && seconds_between(began, Clock::now()) < kWaitForStep) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }

  // Starts or ends the use of the GPU, as chosen.
  void choose_mover() {
    const bool wanted = studio_.preferences().backend == BackendChoice::gpu;
    if (wanted == (shape_.gpu() != nullptr)) return;
    if (!wanted) return leave_gpu();
    try {
      shape_.use_gpu();
      const GpuPreview& gpu = *shape_.gpu();
      times_.mover = gpu.description();
      studio_.set_hit_test([this](const Ray& ray) { return hit_on_gpu(ray); });
      studio_.document().tell(
          {false,
           fmt::format("The GPU {} now moves the shape during a drag{}.", times_.mover,
                       gpu.is_software() ? ", but it is emulated in software, so the CPU is faster" : ""),
           Subject::gpu});
    } catch (const std::exception& error) {
      give_up_gpu(error);
    }
  }

  void leave_gpu() {
    shape_.use_cpu();
    times_.mover.clear();
    times_.volume.reset();
    studio_.set_hit_test({});
  }

  // The next picture gives up a GPU that fails.
  std::optional<SurfaceHit> hit_on_gpu(const Ray& ray) {
    try {
      return shape_.gpu()->hit(ray);
    } catch (const std::exception& error) {
      studio_.document().tell({true, error.what(), Subject::gpu});
      return std::nullopt;
    }
  }

  void give_up_gpu(const std::exception& error) {
    leave_gpu();
    studio_.preferences().backend = BackendChoice::cpu;
    studio_.document().tell({true, fmt::format("Studio continues on the CPU: {}.", error.what()), Subject::gpu});
  }

  bool follow_shape() {
    const DocumentState& shown = studio_.document().shown();
    shape_.show(shown.objects);
    return shape_.follow(shown.state, studio_.pending(), shown.diagonal, view_);
  }

  void follow_on_gpu(GpuPreview& gpu) {
    const std::uint64_t sent = gpu.transfers().bytes_sent;
    const bool was_ahead = gpu.is_ahead();
    const bool has_moved = follow_shape();
    if (has_moved) times_.uploaded = gpu.transfers().bytes_sent - sent;
    if (!was_ahead && gpu.is_ahead()) reads_before_ = gpu.transfers().read;
    if (!gpu.is_ahead()) times_.volume.reset();
    const bool is_measured = studio_.view().settings().statistics && studio_.document().shown().volume_before;
    if (is_measured && has_moved && gpu.is_ahead()) times_.volume = gpu.volume();
    times_.read_back = gpu.transfers().read - reads_before_;
  }

  void follow_on_cpu() {
    if (!follow_shape()) return;
    times_.uploaded = view_.counts().bytes;
    times_.touched = shape_.touched();
  }

  // Returns false if the last one was shown again.
  bool draw_picture() {
    choose_mover();
    try {
      if (shape_.gpu() != nullptr) follow_on_gpu(*shape_.gpu());
    } catch (const std::exception& error) {
      give_up_gpu(error);
    }
    if (shape_.gpu() == nullptr) follow_on_cpu();
    if (const auto influence = overlay_.influence(studio_)) view_.set_influence(*influence);
    if (const auto mask = overlay_.mask(studio_)) view_.set_mask(*mask);
    render::LiveScene scene = overlay_.scene(studio_);
    set_fineness(scene, fineness_);
    const bool is_new = view_.draw(scene, window_.width(), window_.height());
    draw_target();
    return is_new;
  }

  // The shape that the shown one is fitted to, beside it.
  void draw_target() {
    if (!studio_.fit().is_open()) {
      target_.reset();
      target_mesh_.reset();
      return;
    }
    if (!target_) target_.emplace();
    if (target_mesh_ != studio_.fit().target().mesh) {
      target_mesh_ = studio_.fit().target().mesh;
      target_->set_shape(*target_mesh_);
    }
    render::LiveScene scene = Overlay::target_scene(studio_);
    set_fineness(scene, fineness_);
    const Area& area = interface_.layout().target;
    const Screen screen = studio_.fit().screen();
    target_->draw(scene, screen.width, screen.height, static_cast<int>(std::lround(area.left)),
                  window_.height() - static_cast<int>(std::lround(area.bottom)));
  }

  void write_view(const std::filesystem::path& path) {
    const render::Image image =
        view_.picture(overlay_.scene(studio_), kPictureScale * window_.width(), kPictureScale * window_.height());
    write_file_atomically(path, render::encode_png(image));
  }

  void write_picture(const std::filesystem::path& path) {
    studio_.document().withdraw(Subject::picture);
    try {
      write_view(path);
      studio_.document().tell({false, fmt::format("Wrote {}.", path.filename().string())});
    } catch (const std::exception& error) {
      studio_.document().tell({true, error.what(), Subject::picture});
    }
  }

  // Of frames that follow each other without a pause.
  void note_time() {
    const Clock::time_point now = Clock::now();
    if (const auto last = std::exchange(last_frame_, now)) {
      times_.seconds[times_.count++ % times_.seconds.size()] = static_cast<float>(seconds_between(*last, now));
    }
  }

  void set_title() {
    const DocumentState& shown = studio_.document().shown();
    const std::string name = shown.session_path.empty() ? shown.title : shown.session_path.filename().string();
    const std::string title =
        name.empty() ? "Knead Studio" : name + (shown.is_changed ? "* - " : " - ") + "Knead Studio";
    if (title == title_) return;
    window_.set_title(title);
    title_ = title;
  }

  Window window_;
  Studio& studio_;
  Gui gui_;
  GuiBackend backend_;
  Interface interface_;
  render::LiveView view_;
  std::optional<render::LiveView> target_;  // while the shape is fitted to another one
  std::shared_ptr<const Mesh> target_mesh_;
  Overlay overlay_;
  StretchEstimate estimate_;
  ShownShape shape_;
  std::uint64_t reads_before_ = 0;
  FrameTimes times_;
  std::string title_;
  std::uint64_t drawn_version_ = 0;
  Clock::time_point last_changed_ = Clock::now();
  Clock::time_point last_active_ = Clock::now();  // the same while the worker is busy
  int frames_since_ = 0;
  std::optional<Clock::time_point> last_frame_;
  PictureQuality quality_{view_.draws_in_software()};
  Fineness fineness_ = Fineness::smooth;    // of the last picture
  std::optional<Clock::time_point> began_;  // of the last picture, until it is noted
};

void run_application(const ApplicationOptions& options) {
  Studio studio({});
  discard_needless_journals(studio);
  auto application = std::make_unique<Application>(studio);
  begin(studio, options);
  if (!options.shape && !options.session) application->welcome();
  for (int windows = 1; !application->run(); ++windows) {
    if (windows == kMaxWindows) throw std::runtime_error("the graphics driver keeps resetting");
    const Pointer& at = studio.pointer();
    if (studio.gesture()) studio.handle(ButtonChanged{MouseButton::left, false, at.x, at.y, at.modifiers});
    studio.view().remember_window(application->place());
    application.reset();
    application = std::make_unique<Application>(studio);
    studio.preferences().backend = BackendChoice::cpu;
    studio.document().tell(
        {true, "The GPU was reset: Studio continues on the CPU in a new window, and no work is lost."});
  }
  studio.view().remember_look();
  studio.view().remember_window(application->place());
  studio.document().close();
}

SteppedApplication::SteppedApplication(const ApplicationOptions& options) {
  StudioOptions studio_options;
#if defined(__EMSCRIPTEN__) && !defined(__EMSCRIPTEN_PTHREADS__)
  studio_options.has_worker = false;  // no thread can be started
#endif
  studio_ = std::make_unique<Studio>(studio_options);
  discard_needless_journals(*studio_);
  application_ = std::make_unique<Application>(*studio_);
  begin(*studio_, options);
}

SteppedApplication::~SteppedApplication() = default;

std::string SteppedApplication::message() const { return application_->message(); }

bool SteppedApplication::step() {
  if (application_->has_ended()) return false;
  application_->step();
  if (!application_->has_ended()) return true;
  studio_->view().remember_look();
  studio_->document().close();
  return false;
}

}  // namespace knead::studio
