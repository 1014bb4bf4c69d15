// How the document opens shapes, adds and removes them.
#include <fmt/format.h>

#include <cstddef>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "document/document.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::studio {

namespace {

// Bytes that the window allocates to draw a shape, at most, while it makes a render::LiveMesh.
constexpr std::size_t kBytesOfVertex = 160;
constexpr std::size_t kBytesOfSplat = 400;  // more
constexpr std::size_t kBytesOfCorner = 60;

// Throws std::bad_alloc if the window would have too little memory to draw the shape. The memory is never touched.
void check_room_for_drawing(const Mesh& mesh) {
  const std::size_t of_vertex = kBytesOfVertex + (are_splats(mesh) ? kBytesOfSplat : 0);
  ::operator delete(::operator new(mesh.vertex_count() * of_vertex + mesh.corner_vertex.size() * kBytesOfCorner));
}

// A shape and everything made from it, before they replace the document.
struct Opening {
  DocumentObjects objects;
  std::optional<Journal> journal;
  std::optional<Workbench> history;
  std::shared_ptr<const Picker> picker;
  Measures measures;
};

// Does everything that can run out of memory while the previous document is still open.
Opening prepare(std::vector<DocumentObject> list, const std::string& title, const DocumentOptions& options,
                PickerPool& pickers) {
  Opening opening;
  opening.objects.list = std::move(list);
  join(opening.objects);
  std::vector<std::shared_ptr<const ShapeFile>> sources;
  for (const DocumentObject& object : opening.objects.list) sources.push_back(object.source);
  std::filesystem::path folder = std::filesystem::temp_directory_path();
  try {
    opening.journal.emplace(Journal::create(options.journals, *sources.front(), title, std::span(sources).subspan(1)));
    folder = opening.journal->folder();
  } catch (const IoError& error) {
    options.tell(
        {true, fmt::format("The crash journal cannot be written, so a crash would lose work: {}", error.what())});
  }
  try {
    const Mesh& mesh = opening.objects.mesh();
    opening.history.emplace(mesh, folder, face_labels(opening.objects), options.threads);
    opening.measures = measure(WeldedMesh(mesh).mesh());
    opening.picker = pickers.make(opening.history->state());
    opening.history->prepare();
    check_room_for_drawing(mesh);
  } catch (...) {
    if (opening.journal) opening.journal->discard();
    throw;
  }
  return opening;
}

// Copies the stamps and the view of a journal to the one that replaces it.
void copy_folder(const std::filesystem::path& from, const std::filesystem::path& to) {
  namespace fs = std::filesystem;
  std::error_code ignored;  // a view is not worth a failure, and a stamp that is missing is named where it is needed
  for (const char* const name : {"stamps", kViewFile}) {
    if (fs::exists(from / name, ignored)) fs::copy(from / name, to / name, fs::copy_options::recursive, ignored);
  }
}

}  // namespace

ShapeFile made_shape(ShapeKind kind, std::size_t vertices) {
  const std::string name(shape_names()[static_cast<std::size_t>(kind)]);
  return parse_shape(serialize_mesh("ply", make_shape(kind, vertices), {true, {}}), "ply", name);
}

void Document::open(std::vector<DocumentObject> list, const std::string& title) {
  Opening opening = prepare(std::move(list), title, options_, pickers_);
  close();
  for (const Subject subject : {Subject::saving, Subject::exporting, Subject::strokes, Subject::gesture}) {
    options_.tell({false, {}, subject});
  }
  history_.emplace(std::move(*opening.history));
  history_->limit_memory(undo_memory_);
  journal_ = std::move(opening.journal);
  is_dragging_layers_ = false;
  dragged_lines_ = {};
  is_measurable_ = opening.measures.closed() && opening.measures.oriented();
  const std::uint64_t version = shown_.version;
  const std::uint64_t opened = shown_.opened;
  const std::uint64_t ended = shown_.ended;
  shown_ = {};
  shown_.version = version;
  shown_.ended = ended;
  shown_.opened = opened + 1;
  shown_.title = title;
  shown_.objects = std::move(opening.objects);
  shown_.shape_path = shown_.objects.list.front().path;
  const double diagonal = shape_box(shown_.objects.mesh()).diagonal();
  shown_.diagonal = diagonal > 0 ? diagonal : 1;
  if (is_measurable_) shown_.volume_before = shown_.volume = opening.measures.volume;
  shown_.picker = std::move(opening.picker);
  picker_is_stale_ = false;
  for (const DocumentObject& object : shown_.objects.list) {
    for (const std::string& note : object.source->notes) {
      options_.tell({false, fmt::format("{}: {}", object.name, note)});
    }
  }
  show_state();
}

void Document::open_shape(const std::filesystem::path& path, Progress& progress) {
  guarded(Subject::opening, [&] {
    DocumentObject object = read_object(path);
    stop_if_cancelled(&progress);
    open({std::move(object)}, path.filename().string());
  });
}

void Document::add_shape(const std::filesystem::path& path, Progress& progress) {
  if (!history_) return open_shape(path, progress);
  guarded(Subject::opening, [&] {
    std::vector<DocumentObject> list = shown_.objects.list;
    list.push_back(read_object(path));
    stop_if_cancelled(&progress);
    if (!put_objects(std::move(list), shown_.objects.active, "Adding the shape", progress)) return;
    for (const std::string& note : shown_.objects.list.back().source->notes) {
      options_.tell({false, fmt::format("{}: {}", shown_.objects.list.back().name, note)});
    }
  });
}

void Document::remove_object(std::size_t object, Progress& progress) {
  guarded(Subject::opening, [&] {
    std::vector<DocumentObject> list = shown_.objects.list;
    if (list.size() < 2 || object >= list.size()) return;
    const std::string name = list[object].name;
    if (list[object].path.empty()) {  // it was made or recovered
      throw InvalidInput(name + " has no file to bring it back from; save the session and open it, then remove " +
                         name);
    }
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(object));
    std::optional<std::size_t> active = shown_.objects.active;
    if (active == object) {
      active.reset();
    } else if (active && *active > object) {
      --*active;
    }
    if (!put_objects(std::move(list), active, "Removing the shape", progress)) return;
    options_.tell({false, fmt::format("Removed {}. File > Add a shape brings it back.", name), Subject::opening});
  });
}

// Applies the history to all shapes from the beginning. The document does not change before that is done.
bool Document::put_objects(std::vector<DocumentObject> list, std::optional<std::size_t> active, const char* doing,
                           Progress& progress) {
  PickerPool pickers;
  Opening opening = prepare(std::move(list), shown_.title, options_, pickers);
  const auto give_up = [&] {
    if (opening.journal) opening.journal->discard();
    return false;
  };
  WorkResult result;
  try {
    if (opening.journal && journal_) copy_folder(journal_->folder(), opening.journal->folder());
    result = opening.history->append(history_->strokes(), &progress);
  } catch (...) {
    give_up();
    throw;
  }
  if (!tell_failure(result, doing)) return give_up();
  if (journal_) journal_->discard();
  history_.emplace(std::move(*opening.history));
  history_->limit_memory(undo_memory_);
  journal_ = std::move(opening.journal);
  pickers_ = std::move(pickers);
  shown_.objects = std::move(opening.objects);
  shown_.objects.active = active;
  shown_.shape_path = shown_.objects.list.front().path;
  is_measurable_ = opening.measures.closed() && opening.measures.oriented();
  shown_.volume_before.reset();
  shown_.volume.reset();
  if (is_measurable_) shown_.volume_before = opening.measures.volume;
  const double diagonal = shape_box(shown_.objects.mesh()).diagonal();
  shown_.diagonal = diagonal > 0 ? diagonal : 1;
  journal(result.lines);
  shown_.is_changed = true;
  if (journal_ && !shown_.session_path.empty()) journal_->note_saved(shown_.session_path, false);
  measure_volume();
  picker_is_stale_ = true;
  show_state();
  return true;
}

void Document::open_made(ShapeKind kind, std::size_t vertices, Progress& /*progress*/) {
  guarded(Subject::opening, [&] {
    const std::string name(shape_names()[static_cast<std::size_t>(kind)]);
    const std::string title = "new " + name;
    open({{title, {}, std::make_shared<const ShapeFile>(made_shape(kind, vertices))}}, title);
  });
}

}  // namespace knead::studio
