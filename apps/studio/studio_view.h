// The view of the open document: camera, settings, the pictures behind the shape, turntables.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "gestures/navigation.h"
#include "keys.h"
#include "knead/editor/render.h"
#include "platform/window.h"
#include "preferences.h"
#include "studio_document.h"

namespace knead::studio {

// The reference of the colours of stretches.
enum class StretchView { off, since_start, last_stroke };

struct ViewSettings {
  Look look;  // without the projection, which belongs to the navigation
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

inline constexpr int kMaxTurntablePictures = 9999;

// A recording of the shape from all around: numbered pictures, evenly spaced about the axis that is up.
struct Turntable {
  std::filesystem::path pattern;  // with %04d in its name
  int pictures = 0;
  int next = 0;  // the number of the next picture, from 0
  View start;    // the view of the first picture, restored at the end
};

// Returns a recording that has not begun, with a numbered() pattern. Throws InvalidInput for another format than PNG,
// and for a number of pictures outside [2, kMaxTurntablePictures].
Turntable make_turntable(const std::filesystem::path& pattern, int pictures, const View& view);

// Return the view and the file of the next picture.
View view_of(const Turntable& turntable);
std::filesystem::path file_of(const Turntable& turntable);

// The preferences with the folder that they are written to.
struct PreferencesFile {
  std::filesystem::path folder;
  Preferences preferences;

  // Writes the preferences; a notice says if that failed.
  void save(StudioDocument& document) const;
};

class StudioView {
 public:
  StudioView(StudioDocument& document, PreferencesFile& preferences, std::filesystem::path state);

  ViewSettings& settings() { return settings_; }
  const ViewSettings& settings() const { return settings_; }
  Navigation& navigation() { return navigation_; }
  const Navigation& navigation() const { return navigation_; }
  Screen screen() const;
  // unit: pixels for one point of the design, of what is drawn to be grabbed.
  void set_unit(double unit) { unit_ = unit; }

  // Performs an action of a key or menu; returns false if it does not concern the view.
  bool perform(Action action);
  // frame_all() frames the shape; frame_stroke() frames the box, or if it is empty the region of the last stroke.
  void frame_all();
  void frame_stroke(const Box& placed);
  // Shows the shape from a side; its middle keeps its place in the picture.
  void look_from(StandardView side);
  // keep_view() keeps the view until another shape is opened; look_as_kept() shows the kept views in turn.
  void keep_view();
  void look_as_kept();
  // Turns the view as a drag of that many pixels beside the shape does: about the last stroke where that is close, else
  // about the middle of the framed box.
  void turn(double dx, double dy);
  // Makes a drag that turns the view turn it about the point under the pointer; beside the shape as turn().
  void set_pivot(const Event& event);
  // Notes where the last stroke has ended.
  void note_stroke(const Vec3d& place) { last_stroke_ = place; }
  // Frames the document that was opened, and reads its references.
  void begin_document();

  std::vector<Reference>& references() { return references_; }
  const std::vector<Reference>& references() const { return references_; }
  // Puts the picture of a PNG or JPEG file behind the shape, in the plane that the view looks at. Returns false, with a
  // notice, if it cannot be read.
  bool add_reference(const std::filesystem::path& file);

  // Write to the preferences, if it changed: the look of the shape and the references of the document; the shown
  // panels; the window's place.
  void remember_look();
  void remember_panels();
  void remember_window(const WindowPlace& window);

  // Writes a picture of the whole shape as `knead render` draws it, with the current view and shading. The view is
  // rounded to hundredths of a degree. Takes about 20 s for 3840 x 2160 pixels without a GPU; Escape stops it.
  void write_poster(const std::filesystem::path& file, const Poster& poster);

  // Records a turntable: every step_turntable() shows the next view and calls `write`. It returns false at the end.
  void record_turntable(const std::filesystem::path& pattern, int pictures);
  bool step_turntable(const std::function<void(const std::filesystem::path&)>& write);
  void stop_turntable();
  const std::optional<Turntable>& turntable() const { return turntable_; }

 private:
  void load_references();
  std::optional<Vec3d> close_stroke() const;

  StudioDocument& document_;
  PreferencesFile& preferences_;
  std::filesystem::path state_folder_;
  PanelState saved_panels_;
  Navigation navigation_;
  double unit_ = 1;
  ViewSettings settings_;
  std::vector<Reference> references_;
  std::vector<Reference> saved_references_;
  std::vector<View> kept_views_;
  std::size_t next_kept_view_ = 0;  // of kept_views_, in turn
  std::optional<Vec3d> last_stroke_;
  std::optional<Turntable> turntable_;
};

}  // namespace knead::studio
