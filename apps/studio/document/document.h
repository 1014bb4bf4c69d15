// The document: a shape, its history, its files and its journal. Its calls take time, so only the worker's thread uses
// it. The window shows a value (DocumentState), which any thread may keep.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "document/objects.h"
#include "gestures/picker.h"
#include "gestures/tools.h"
#include "knead/editor/render.h"
#include "knead/editor/workbench.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::studio {

// The subject of a notice. A new attempt withdraws earlier errors on its subject.
enum class Subject { other, opening, saving, exporting, strokes, gesture, stamp, picture, preferences, gpu };

struct Notice {
  bool is_error = false;
  std::string text;  // a sentence or two: what happened, what to do; empty: only withdraws errors
  Subject subject = Subject::other;
};

// The entries of the history, each as a list of strokes, and a change of them (document/layers.h).
using Layers = std::vector<std::vector<SessionStroke>>;
using LayerChange = std::function<void(Layers&)>;

// The document as the window shows it at one moment.
struct DocumentState {
  std::uint64_t version = 0;  // grows with every change
  std::uint64_t opened = 0;   // grows when another shape is opened; 0: none is
  std::uint64_t ended = 0;    // the number of gestures that were kept or given up
  ShapeState state;           // of all objects, to be drawn
  DocumentObjects objects;
  std::shared_ptr<const Picker> picker;
  bool picker_is_behind = false;  // the shape has changed since the picker was made
  std::vector<std::shared_ptr<const HistoryEntry>> history;
  std::vector<std::shared_ptr<const HistoryEntry>> redoable;  // next first
  std::optional<std::size_t> looked_at;                       // the number of applied entries if the past is shown
  std::string title;
  std::filesystem::path shape_path;     // of the first object; empty: the shape was made, not read
  std::filesystem::path session_path;   // empty: never saved
  bool is_changed = false;              // since it was saved
  double diagonal = 1;                  // of the box of the shape as it was opened
  std::optional<double> volume_before;  // of a closed shape as it was opened
  std::optional<double> volume;         // the last measured one: during a drag, and at its end
  double live_seconds = 0;              // duration of the last step of a drag
  std::uint64_t live_steps = 0;         // accepted steps of the last entry
  double journal_seconds = 0;           // duration of writing the last batch
  std::string journal_trouble;          // one line while the disk refuses the journal
  std::optional<Stroke> contacts;       // of the stamp being dragged: the points that it pushed last
  std::string recovered_view;           // of a recovered document: its view, as remember_view kept it
  std::string refusal;                  // why the current stroke is impossible; empty: it is possible
  ShapeState start;                     // the shape as it was opened
  std::optional<ShapeState>
      before_stroke;  // before the current gesture, else before the last entry; std::nullopt: not kept
  // The number of triangles that the last entry made poor, if it was not remeshed: newly stretched more than
  // kStrongStretch times, with an angle below 5 degrees, or inclined by more than 30 degrees to the normal at a corner.
  // 0 if they are fewer than 1 in 500 of the triangles that it touched.
  std::size_t poor_triangles = 0;
  bool is_coarse = false;  // the triangles are too large for the last entry, which was not remeshed
};

// Returns Studio's word for a key of a session.
std::string word_for_key(std::string key);

// Returns the library's line about a stroke as a sentence in Studio's words, without keys of a session.
std::string in_words(const std::string& line);

// A mask: for each vertex, from 0 (free) to 255 (fixed); empty: no vertex is masked.
using MaskValues = std::vector<std::uint8_t>;

// The folders of the document, and the functions that it calls.
struct DocumentOptions {
  std::filesystem::path journals;  // root of the crash journals
  int threads = 0;
  std::function<void(const DocumentState&)> show;  // called after every change
  std::function<void(Notice)> tell;                // called with a notice for the user
  std::function<void(std::string)> name_work;      // called with the name of the current work; may be empty
};

// The file in a journal's folder that holds the view.
inline constexpr const char* kViewFile = "view.script";

// Reads a shape as an object. Throws as read_shape.
DocumentObject read_object(const std::filesystem::path& path);

// Returns a procedural shape, for new shapes and for stamps.
ShapeFile made_shape(ShapeKind kind, std::size_t vertices);

// The digits of the number in names of frames and pictures.
inline constexpr const char* kNumber = "%04d";

// Returns the name with "_%04d" before its extension; unchanged if it has "%04d".
std::filesystem::path numbered(const std::filesystem::path& pattern);

// How the motion of a session is exported.
struct FrameExport {
  int frames = 24;  // 1 or more
  int frames_per_second = 24;
  int hold = 0;            // how often the first and the last frame are repeated
  bool is_smooth = false;  // begins and ends slowly

  friend bool operator==(const FrameExport&, const FrameExport&) = default;
};

// A picture of the whole shape, or several from all around, as `knead render` draws them.
struct Poster {
  int width = 3840;  // pixels
  int height = 2160;
  int pictures = 1;            // more: evenly about the axis that is up
  bool is_transparent = true;  // else the background of the view
  bool has_ground = true;      // the shadow on the ground
};

// The view and shading of a poster.
struct PosterScene {
  render::ViewDirection view;
  bool is_z_up = false;
  render::FitOptions fit;
  render::Options options;  // with the poster's size and background
};

class Document {
 public:
  explicit Document(DocumentOptions options);

  // Limits the memory of undo (Workbench::limit_memory), also for shapes that are opened later.
  void limit_undo_memory(std::size_t bytes);

  // Open a shape or a session. They close the previous work and remove its journal. If the file cannot be read, a
  // notice says why and nothing changes.
  void open_shape(const std::filesystem::path& path, Progress& progress);
  void open_session(const std::filesystem::path& path, Progress& progress);  // on the shape that is open, or its own
  void open_made(ShapeKind kind, std::size_t vertices, Progress& progress);
  // Adds a shape to those that are open, or opens it. The whole history moves it, too. If it cannot be read, or a
  // stroke cannot be applied to all, a notice says why and nothing changes.
  void add_shape(const std::filesystem::path& path, Progress& progress);
  // Removes one of several objects; the whole history moves the others. Refuses an object without a file, because it
  // could not be added again. Other failures are as in add_shape.
  void remove_object(std::size_t object, Progress& progress);
  void recover(const std::filesystem::path& journal, Progress& progress);

  // As in Workbench; they also measure time and write the journal. Strokes name stamps by their file in stamp_folder().
  void set_live(std::vector<SessionStroke> strokes, Progress& progress, bool follows = false);
  void finish(Progress& progress);
  void give_up(Progress& progress);
  void undo(Progress& progress);
  void redo(Progress& progress);
  void change_layers(const LayerChange& change, Progress& progress);
  // The same for the steps of a drag of a slider or a handle. All steps until end_layer_drag() are one change for undo;
  // the journal gets it at the end.
  void drag_layers(const LayerChange& change, Progress& progress);
  void end_layer_drag(bool is_kept);
  void look_at(std::optional<std::size_t> entries, Progress& progress);

  // Shows or hides an object, or makes it the active one (std::nullopt: none). The shapes do not change.
  void show_object(std::size_t object, bool is_visible);
  void make_active(std::optional<std::size_t> object);
  // Hides the faces that this mask holds (`masked`), or those that it leaves free; faces that are hidden stay so. Does
  // nothing, with a notice, if no face would be left.
  void hide_faces(const MaskValues& mask, bool masked);
  void show_all_faces();

  // Write files. A notice says when they are done. Several objects are exported to a file each (path_of_object); all
  // files appear at once, or none.
  void save(const std::filesystem::path& path);
  void export_shape(const std::filesystem::path& path, bool as_double, Progress& progress);
  void export_frames(const std::filesystem::path& file, const FrameExport& how, Progress& progress);
  // Writes a poster; several pictures go to numbered() files.
  void write_poster(const std::filesystem::path& file, const PosterScene& how, int pictures, Progress& progress);

  // Shows a frame (from 0) of the export, without repeated ones. The first call makes all frames, or fewer if they
  // would take more than half a GB. Later calls show a frame at once, until something else is shown.
  void look_at_frame(const FrameExport& how, int frame, Progress& progress);

  // Writes a closed shape and its mirror images to the folder of stamps and returns it as a stamp. Throws InvalidInput
  // and IoError.
  StampShape add_stamp(const std::string& name, const Mesh& mesh);

  // Copies a file to the folder of stamps, and returns its name for strokes. Throws IoError.
  std::string keep_file(const std::filesystem::path& from) const;

  // Returns the placement with the limit cylinder of the part that a twist or bend there moves. `may_turn`, for a new
  // placement: it may turn about its x towards the thinnest part there, and of equally thin ones towards the nearer
  // tip. Otherwise its z points to the tip.
  Placement with_limit_cylinder(const Placement& placement, bool bends, bool may_turn, const Progress& progress) const;
  // Returns the profile of the shape for a twist or bend with this placement.
  std::shared_ptr<const ZoneProfile> profile(const ToolSettings& settings, const Placement& placement) const;
  void count_crossings(Progress& progress);

  // Keeps a text about the view in the journal's folder, for `recover`.
  void remember_view(const std::string& view) const;

  // Does the work that can wait: remeshes after strokes, builds the tree for picking, flushes the journal to disk.
  // After a cancellation the next call continues it.
  void when_idle(Progress& progress);

  // Closes the document and removes its journal.
  void close();

 private:
  void open(std::vector<DocumentObject> list, const std::string& title);
  void see_objects();
  bool put_objects(std::vector<DocumentObject> list, std::optional<std::size_t> active, const char* doing,
                   Progress& progress);
  void append(Session session, Progress& progress);
  bool take(const WorkResult& result, const char* what);
  bool tell_failure(const WorkResult& result, const char* what) const;
  void end_gesture(Progress& progress);
  void arrange(const LayerChange& change, bool is_step, Progress& progress);
  bool settle(Progress& progress);
  void get_ready(Progress& progress);
  void journal(const LineChange& now);
  void tell_warnings(const HistoryEntry& entry) const;
  void show();
  void show_state();
  void measure_volume();
  void measure_large_volume();
  void count_poor_triangles();
  void find_coarse(Progress& progress);
  bool guarded(Subject subject, const std::function<void()>& work) const;
  bool guarded(const std::function<void()>& work) const { return guarded(Subject::strokes, work); }
  std::filesystem::path stamp_folder() const;
  Session to_session(const std::filesystem::path& path) const;
  Session history_session() const;
  std::shared_ptr<const Mesh> base_mesh(std::shared_ptr<const ShapeFile> source = nullptr) const;
  std::filesystem::path shape_for(const std::filesystem::path& session, std::size_t number) const;
  std::shared_ptr<const ShapeFile> exported_source() const;
  void carry_points(const ShapeFile& source, ReplayOptions& options) const;
  std::optional<DeformedShape> exported_cloud(const std::shared_ptr<const ShapeFile>& source, Progress& progress) const;
  void write_objects(const std::filesystem::path& path, const ShapeState& state, const WriteOptions& options) const;
  std::function<void(const ReplayFrame&)> animation_of(const std::filesystem::path& file,
                                                       const AnimationOptions& animation, bool is_remeshed) const;
  ReplayOptions motion_of(const FrameExport& how, Progress& progress) const;
  bool make_frames(const FrameExport& how, Progress& progress);

  // Frames of the motion, evenly spaced in time.
  struct Motion {
    FrameExport how;
    std::vector<ShapeState> frames;
  };

  DocumentOptions options_;
  std::optional<Workbench> history_;
  std::vector<Parameter> parameters_;  // of the session that it begins with
  std::optional<Journal> journal_;
  DocumentState shown_;
  std::optional<Motion> motion_;  // while it is looked at
  bool is_measurable_ = false;    // closed and oriented
  PickerPool pickers_;
  bool picker_is_stale_ = false;
  bool volume_is_stale_ = false;
  std::chrono::steady_clock::time_point measured_{};  // when the volume was measured last
  bool is_dragging_layers_ = false;                   // the last change of the history is a step of the drag
  LineChange dragged_lines_;                          // of its steps
  std::size_t undo_memory_ = std::size_t{1} << 30;
};

// Returns the mesh mirrored in the planes of a bit mask (1: x = 0, 2: y = 0, 4: z = 0), its faces facing outwards
// again.
Mesh mirrored_mesh(Mesh mesh, unsigned planes);

// Returns the name of the file of a stamp's mirror image.
std::string image_file(const std::string& file, unsigned planes);

// --- masks
// ------------------------------------------------------------------------------------------------------------

// Returns the values of the mask after these entries, for the vertices of the state. After remeshing, new vertices are
// masked where the mask holds them.
MaskValues mask_values(std::span<const std::shared_ptr<const HistoryEntry>> history, const ShapeState& state);

// Returns the stroke that masks the vertices of the state with these values and a border of this width. It names
// vertices, or points if remeshing has changed the vertices' numbers.
MaskStroke mask_stroke(const MaskValues& values, const ShapeState& state, double width);

// Changes of a whole mask: blur takes means over neighbours, grow the greatest and shrink the smallest value.
enum class MaskEdit { fill, clear, invert, blur, grow, shrink };

// Returns the edit with a name in lower case, or nothing.
std::optional<MaskEdit> mask_edit(std::string_view word);

MaskValues changed(MaskValues values, MaskEdit edit, const Mesh& mesh);

// A brush: full within `inner` of the center, down to nothing at `outer`.
struct MaskBrush {
  Vec3d center;
  double inner = 0;
  double outer = 0;
  bool erases = false;
};
void paint(const MaskBrush& brush, const Snapshot& positions, MaskValues& values);

// Masks or frees every vertex within a closed line of the view, also hidden ones.
void fill(std::span<const Pixel> line, const Screen& screen, bool erases, const Snapshot& positions,
          MaskValues& values);

}  // namespace knead::studio
