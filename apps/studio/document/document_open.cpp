// How the document opens a shape.
#include <fmt/format.h>

#include <new>
#include <utility>

#include "document/document.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::studio {

namespace {

// What the window allocates to draw a shape, while it makes what is drawn of it (render::LiveMesh).
constexpr std::size_t kBytesOfVertex = 160;
constexpr std::size_t kBytesOfCorner = 60;

// Throws std::bad_alloc if the window would have too little memory to draw the shape. The memory is never touched.
void check_room_for_drawing(const Mesh& mesh) {
  ::operator delete(::operator new(mesh.vertex_count() * kBytesOfVertex + mesh.corner_vertex.size() * kBytesOfCorner));
}

// A shape and what is made of it, before it takes the place of the document.
struct Opening {
  std::shared_ptr<const ShapeFile> source;
  std::optional<Journal> journal;
  std::optional<Workbench> history;
  std::shared_ptr<const Picker> picker;
  Measures measures;
};

// Everything that can run out of memory is done here, while the document before it is still open.
Opening prepare(ShapeFile source, const std::string& title, const DocumentOptions& options, PickerPool& pickers) {
  Opening opening;
  opening.source = std::make_shared<const ShapeFile>(std::move(source));
  std::filesystem::path folder = std::filesystem::temp_directory_path();
  try {
    opening.journal.emplace(Journal::create(options.journals, *opening.source, title));
    folder = opening.journal->folder();
  } catch (const IoError& error) {
    options.tell(
        {true, fmt::format("The crash journal cannot be written, so a crash would lose work: {}", error.what())});
  }
  try {
    const Mesh& mesh = opening.source->mesh;
    opening.history.emplace(mesh, folder, face_labels(*opening.source), options.threads);
    opening.measures = measure(mesh);
    opening.picker = pickers.make(opening.history->state());
    opening.history->prepare();
    check_room_for_drawing(mesh);
  } catch (...) {
    if (opening.journal) opening.journal->discard();
    throw;
  }
  return opening;
}

}  // namespace

ShapeFile made_shape(ShapeKind kind, std::size_t vertices) {
  const std::string name(shape_names()[static_cast<std::size_t>(kind)]);
  return parse_shape(serialize_mesh("ply", make_shape(kind, vertices), {true, {}}), "ply", name);
}

void Document::open(ShapeFile source, const std::string& title, const std::filesystem::path& path) {
  Opening opening = prepare(std::move(source), title, options_, pickers_);
  close();
  for (const Subject subject : {Subject::saving, Subject::exporting, Subject::strokes, Subject::gesture}) {
    options_.tell({false, {}, subject});
  }
  source_ = std::move(opening.source);
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
  shown_.shape_path = path;
  const double diagonal = shape_box(source_->mesh).diagonal();
  shown_.diagonal = diagonal > 0 ? diagonal : 1;
  if (is_measurable_) shown_.volume_before = shown_.volume = opening.measures.volume;
  shown_.picker = std::move(opening.picker);
  picker_is_stale_ = false;
  for (const std::string& note : source_->notes) options_.tell({false, fmt::format("{}: {}", title, note)});
  show_state();
}

void Document::open_shape(const std::filesystem::path& path, Progress& progress) {
  guarded(Subject::opening, [&] {
    ShapeFile file = read_shape(path);
    stop_if_cancelled(&progress);
    open(std::move(file), path.filename().string(), path);
  });
}

void Document::open_made(ShapeKind kind, std::size_t vertices, Progress& /*progress*/) {
  guarded(Subject::opening, [&] {
    const std::string name(shape_names()[static_cast<std::size_t>(kind)]);
    open(made_shape(kind, vertices), "new " + name, {});
  });
}

}  // namespace knead::studio
