// The files of the document: sessions, stamps, exports, frames and posters.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "document/document.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::studio {

namespace {

// Beside a session file, the folder of the stamps that it names.
std::filesystem::path stamps_beside(const std::filesystem::path& session) {
  return session.stem().string() + "_stamps";
}

// Empty for a file that cannot be read.
std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Calls change(file) for every file that a stroke names. A font without an extension is no file, but a name.
template <class Change>
void for_each_file(std::vector<SessionStroke>& strokes, const Change& change) {
  for (SessionStroke& stroke : strokes) {
    for (const char* const key : {"mesh", "file", "font"}) {
      std::string* const file = find_value<std::string>(stroke.stroke, key);
      if (file != nullptr && std::filesystem::path(*file).has_extension()) change(*file);
    }
  }
}

// Returns the path, or one with a number where another file is there, which strokes may name.
template <class IsOther>
std::filesystem::path free_name(const std::filesystem::path& path, const IsOther& is_other) {
  std::filesystem::path free = path;
  for (int number = 2; std::filesystem::exists(free) && is_other(free); ++number) {
    free.replace_filename(fmt::format("{}_{}{}", path.stem().string(), number, path.extension().string()));
  }
  return free;
}

}  // namespace

Mesh mirrored_mesh(Mesh mesh, unsigned planes) {
  bool is_turned = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((planes >> axis & 1U) == 0) continue;
    is_turned = !is_turned;
    for (Vec3d& p : mesh.positions) p[axis] = -p[axis];
  }
  if (!is_turned) return mesh;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    std::reverse(mesh.corner_vertex.begin() + mesh.face_begin[f], mesh.corner_vertex.begin() + mesh.face_begin[f + 1]);
  }
  return mesh;
}

std::string image_file(const std::string& file, unsigned planes) {
  const std::filesystem::path path = file;
  return (path.parent_path() / fmt::format("{}_mirror{}.ply", path.stem().string(), planes)).string();
}

std::filesystem::path Document::stamp_folder() const {
  return (journal_ ? journal_->folder() : std::filesystem::temp_directory_path()) / "stamps";
}

StampShape Document::add_stamp(const std::string& name, const Mesh& mesh) {
  Mesh plain = mesh;
  plain.attributes.clear();
  const Vec3d middle = bounding_box(plain.positions).center();
  for (Vec3d& p : plain.positions) p = p - middle;
  std::filesystem::create_directories(stamp_folder());
  const auto is_other = [&](const std::filesystem::path& kept) {
    return read_shape(kept).mesh.positions != plain.positions;
  };
  std::string file = "stamps/" + free_name(stamp_folder() / (name + ".ply"), is_other).filename().string();
  for (unsigned planes = 0; planes < 8; ++planes) {
    const std::string of_image = planes == 0 ? file : image_file(file, planes);
    const Mesh image = mirrored_mesh(plain, planes);
    write_mesh(stamp_folder().parent_path() / of_image, image, {true, {}});
  }
  return {name, file, std::make_shared<const Mesh>(std::move(plain))};
}

std::string Document::keep_file(const std::filesystem::path& from) const {
  const std::string bytes = read_text(from);
  const auto is_other = [&](const std::filesystem::path& kept) { return read_text(kept) != bytes; };
  const std::filesystem::path path = free_name(stamp_folder() / from.filename(), is_other);
  std::filesystem::create_directories(stamp_folder());
  write_file_atomically(path, bytes);
  return "stamps/" + path.filename().string();
}

// Copies the stamps of strokes from another document to this one's folder.
void Document::append(Session session, Progress& progress) {
  const std::filesystem::path folder = std::filesystem::path(session.name).parent_path();
  std::map<std::string, std::string> copied;
  for_each_file(session.strokes, [&](std::string& stamp) {
    const std::filesystem::path from = folder / stamp;
    std::string& kept = copied[from.string()];
    if (kept.empty()) kept = keep_file(from);
    stamp = kept;
  });
  for (const std::string& warning : session.warnings) options_.tell({false, warning});
  parameters_ = session.parameters;  // no stroke is before it
  take(history_->append(session.strokes, &progress), "The session");
  picker_is_stale_ = true;
  show_state();
}

void Document::open_session(const std::filesystem::path& path, Progress& progress) {
  guarded(Subject::opening, [&] {
    Session session = read_session(path);
    const std::filesystem::path own = session.mesh ? path.parent_path() / *session.mesh : std::filesystem::path();
    const bool has_all = session.also.empty() || shown_.objects.list.size() == session.also.size() + 1;
    const bool fits = history_ && history_->done().empty() && has_all;
    if (!fits && own.empty()) {
      throw InvalidInput(path.string() + ": the session names no shape; open the shape first, then the session");
    }
    if (!fits) {
      std::vector<DocumentObject> list{read_object(own)};
      for (const std::string& other : session.also) list.push_back(read_object(path.parent_path() / other));
      open(std::move(list), own.filename().string());
    }
    append(std::move(session), progress);
    shown_.session_path = path;
    shown_.is_changed = false;
    if (journal_) journal_->note_saved(path);
    show();
  });
}

void Document::recover(const std::filesystem::path& journal, Progress& progress) {
  guarded(Subject::opening, [&] {
    RecoveredWork work = recover_journal(journal);
    std::string view = text_of_file(journal / kViewFile);
    std::vector<DocumentObject> list;
    const auto add = [&](const std::string& name, ShapeFile& file) {
      const std::filesystem::path& path = work.files[list.size()];
      list.push_back(
          {path.empty() ? name : path.filename().string(), path, std::make_shared<const ShapeFile>(std::move(file))});
    };
    add(work.title, work.shape);
    for (std::size_t i = 0; i < work.also.size(); ++i) add(work.session.also[i], work.also[i]);
    open(std::move(list), work.title);
    append(std::move(work.session), progress);
    shown_.recovered_view = std::move(view);
    shown_.session_path = work.saved;
    shown_.is_changed = true;
    if (journal_ && !work.saved.empty()) journal_->note_saved(work.saved, false);
    show();
    discard_journal(journal);
  });
}

// Replaces the file as a whole, but does not flush it to the disk: it survives the end of the program, and a view is
// not worth the wait.
void Document::remember_view(const std::string& view) const {
  if (!journal_) return;
  const std::filesystem::path path = journal_->folder() / kViewFile;
  const std::filesystem::path next = journal_->folder() / "view.next";
  std::ofstream(next, std::ios::binary) << view;
  std::error_code ignored;  // without it only the view is lost
  std::filesystem::rename(next, path, ignored);
}

// Returns the file of an object for a session: its own file, or one beside the session.
std::filesystem::path Document::shape_for(const std::filesystem::path& session, std::size_t number) const {
  const DocumentObject& object = shown_.objects.list[number];
  if (!object.path.empty()) return object.path;
  const std::string which = number == 0 ? "" : fmt::format("_{}", number + 1);
  return session.parent_path() / fmt::format("{}_shape{}.{}", session.stem().string(), which, object.source->format);
}

// Returns the session for saving at a path: it names shapes and stamps relative to that.
Session Document::to_session(const std::filesystem::path& path) const {
  Session session;
  session.strokes = history_->strokes();
  session.parameters = parameters_;
  const auto parent = std::filesystem::absolute(path).parent_path();
  const auto named = [&](std::size_t number) {
    return std::filesystem::absolute(shape_for(path, number)).lexically_relative(parent).generic_string();
  };
  session.mesh = named(0);
  for (std::size_t i = 1; i < shown_.objects.list.size(); ++i) session.also.push_back(named(i));
  for_each_file(session.strokes, [&](std::string& file) {
    file = (stamps_beside(path) / std::filesystem::path(file).filename()).generic_string();
  });
  return session;
}

void Document::save(const std::filesystem::path& path) {
  if (!history_) return;
  guarded(Subject::saving, [&] {
    if (path.extension() != ".knead") {
      throw InvalidInput(path.string() + ": a session's file ends in .knead; to write the shape, use Export");
    }
    Session session = to_session(path);
    std::set<std::string> written;
    for_each_file(session.strokes, [&](const std::string& file) {
      if (!written.insert(file).second) return;
      const std::filesystem::path to = path.parent_path() / file;
      std::filesystem::create_directories(to.parent_path());
      write_file_atomically(to, read_text(stamp_folder() / to.filename()));
    });
    FilesTogether files;
    std::string made;
    for (std::size_t i = 0; i < shown_.objects.list.size(); ++i) {
      if (!shown_.objects.list[i].path.empty()) continue;
      const std::filesystem::path shape = shape_for(path, i);
      write_file_atomically(shape, shown_.objects.list[i].source->bytes);
      made += fmt::format(" The shape it begins with is in {}.", shape.filename().string());
    }
    write_file_atomically(path, serialize_session(session));
    files.finish();
    shown_.session_path = path;
    shown_.is_changed = false;
    if (journal_) journal_->note_saved(path);
    options_.tell({false, fmt::format("Saved {}.{}", path.filename().string(), made)});
    show();
  });
}

// Returns the file of the only object, with long splats split; of several objects, the file of the first one.
std::shared_ptr<const ShapeFile> Document::exported_source() const {
  const DocumentObjects& objects = shown_.objects;
  const std::shared_ptr<const ShapeFile>& source = objects.list.front().source;
  if (objects.joined != nullptr || !are_splats(source->mesh)) return source;
  auto split = std::make_shared<ShapeFile>(*source);
  ReplayOptions options;
  options.motion.threads = options_.threads;
  std::vector<std::string> notes;
  const bool is_split = split_splats(*split, history_session(), options, {}, &notes);
  for (const std::string& note : notes) options_.tell({false, note + "."});
  return is_split ? split : source;
}

// Makes a replay carry normals of points, and splats. source: exported_source().
void Document::carry_points(const ShapeFile& source, ReplayOptions& options) const {
  std::vector<const Mesh*> meshes;
  bool has_normals = false;
  for (const DocumentObject& object : shown_.objects.list) {
    const ShapeFile& file = shown_.objects.joined == nullptr ? source : *object.source;
    meshes.push_back(&file.mesh);
    const bool is_cloud = meshes.back()->face_count() == 0;
    std::vector<Vec3d> normals = is_cloud ? vertex_normals_of(file) : std::vector<Vec3d>{};
    has_normals = has_normals || !normals.empty();
    normals.resize(meshes.back()->vertex_count());
    options.normals.insert(options.normals.end(), normals.begin(), normals.end());
  }
  if (!has_normals) options.normals.clear();
  options.splats = splats_among(meshes);
}

// Returns the shape with moved normals of points and splats; nothing if it has neither.
std::optional<DeformedShape> Document::exported_cloud(const std::shared_ptr<const ShapeFile>& source,
                                                      Progress& progress) const {
  ReplayOptions options;
  carry_points(*source, options);
  if (options.normals.empty() && options.splats.empty()) return std::nullopt;
  options.may_cross = true;
  options.progress = &progress;
  ReplayResult result = replay(base_mesh(source), history_session(), options);
  if (result.status != AdvectStatus::done) throw Cancelled();
  return std::move(result.shape);
}

// Writes the shape, or each of several objects.
void Document::write_objects(const std::filesystem::path& path, const ShapeState& state,
                             const WriteOptions& options) const {
  const DocumentObjects& objects = shown_.objects;
  if (objects.joined != nullptr) {
    for (std::size_t i = 0; i < objects.list.size(); ++i) {
      write_part(path_of_object(objects, i, path), {*objects.list[i].source, *objects.joined, i}, state, options);
    }
    return;
  }
  const ShapeFile& source = *objects.list.front().source;
  if (state.provenance != nullptr) {
    write_remeshed(path, source, state.to_mesh(), state.provenance->face_source, options);
  } else {
    write_shape(path, source, state.positions.copy(), options);
  }
}

void Document::export_shape(const std::filesystem::path& path, bool as_double, Progress& progress) {
  if (!history_) return;
  guarded(Subject::exporting, [&] {
    if (!settle(progress)) throw Cancelled();
    const ShapeState& state = history_->state();
    const DocumentObjects& objects = shown_.objects;
    const bool is_remeshed = state.provenance != nullptr;
    for (const DocumentObject& object : objects.list) {
      const auto losses = is_remeshed ? remesh_losses(path, *object.source) : conversion_losses(path, *object.source);
      for (const std::string& loss : losses) options_.tell({false, loss});
    }
    const std::shared_ptr<const ShapeFile> source = exported_source();
    const std::optional<DeformedShape> cloud = is_remeshed ? std::nullopt : exported_cloud(source, progress);
    stop_if_cancelled(&progress);
    FilesTogether files;
    const WriteOptions options{.double_coordinates = as_double};
    if (cloud && objects.joined == nullptr) {
      write_deformed(path, *source, *cloud, options);
    } else {
      write_objects(path, cloud ? cloud->state() : state, options);
    }
    for (std::size_t i = 0; i < objects.list.size() && format_of(path) == "obj"; ++i) {
      const DocumentObject& object = objects.list[i];
      if (!object.path.empty()) copy_material_files(*object.source, object.path, path_of_object(objects, i, path));
    }
    files.finish();
    const std::string first = path_of_object(objects, 0, path).filename().string();
    options_.tell({false, objects.joined == nullptr
                              ? fmt::format("Exported {}.", first)
                              : fmt::format("Exported {} shapes: {} and others.", objects.list.size(), first)});
  });
}

std::filesystem::path numbered(const std::filesystem::path& pattern) {
  if (pattern.filename().string().find(kNumber) != std::string::npos) return pattern;
  return pattern.parent_path() / (pattern.stem().string() + "_" + kNumber + pattern.extension().string());
}

// Its stamps are those of the journal.
Session Document::history_session() const {
  Session session;
  session.name = (stamp_folder().parent_path() / "session").string();
  session.strokes = history_->strokes();
  return session;
}

// Returns the shape that the history moves, or that of the file in the place of the only object. It outlives the
// document.
std::shared_ptr<const Mesh> Document::base_mesh(std::shared_ptr<const ShapeFile> source) const {
  const DocumentObjects& objects = shown_.objects;
  if (objects.joined != nullptr) return {objects.joined, &objects.joined->mesh()};
  if (source == nullptr) source = objects.list.front().source;
  return {source, &source->mesh};
}

// Returns the options of a replay of the whole history.
ReplayOptions Document::motion_of(const FrameExport& how, Progress& progress) const {
  ReplayOptions options;
  options.may_cross = true;  // Studio keeps such strokes
  options.progress = &progress;
  options.motion.threads = options_.threads;
  options.remesh.face_labels = face_labels(shown_.objects);
  options.frames.count = how.frames;
  options.frames.ease = how.is_smooth ? Ease::smooth : Ease::linear;
  options.frames.hold = how.hold;
  return options;
}

// Returns a function that writes the frames of the shape, or of each object, to a file each.
std::function<void(const ReplayFrame&)> Document::animation_of(const std::filesystem::path& file,
                                                               const AnimationOptions& animation,
                                                               bool is_remeshed) const {
  const DocumentObjects& objects = shown_.objects;
  if (objects.joined == nullptr) return animation_writer(file, *objects.list.front().source, is_remeshed, animation);
  std::vector<std::function<void(const ReplayFrame&)>> writers;
  for (std::size_t i = 0; i < objects.list.size(); ++i) {
    writers.push_back(part_animation_writer(path_of_object(objects, i, file),
                                            {*objects.list[i].source, *objects.joined, i}, animation));
  }
  return [writers](const ReplayFrame& frame) {
    for (const auto& write : writers) write(frame);
  };
}

void Document::export_frames(const std::filesystem::path& file, const FrameExport& how, Progress& progress) {
  if (!history_) return;
  guarded(Subject::exporting, [&] {
    const Session session = history_session();
    const std::shared_ptr<const ShapeFile> source = exported_source();
    ReplayOptions options = motion_of(how, progress);
    const bool is_one_file = is_animation(file) && file.filename().string().find(kNumber) == std::string::npos;
    options.frames.same_faces = is_one_file;
    const std::string text = numbered(file).string();
    const std::size_t at = text.rfind(kNumber);
    options.frames.deliver = [&](const ReplayFrame& frame) {
      const std::string name = text.substr(0, at) + fmt::format("{:04}", frame.index) + text.substr(at + 4);
      shown_.objects.joined == nullptr ? write_deformed(name, *source, frame.shape)
                                       : write_objects(name, frame.shape.state(), {});
    };
    const std::shared_ptr<const Mesh> mesh = base_mesh(is_one_file ? nullptr : source);
    if (!is_one_file && !Replay(mesh, session, options).remeshes()) carry_points(*source, options);
    if (is_one_file) {
      options.frames.deliver =
          animation_of(file, {frame_count(options.frames), static_cast<double>(how.frames_per_second)},
                       Replay(mesh, session, options).remeshes());
    }
    std::optional<FilesTogether> files;
    if (shown_.objects.joined != nullptr) files.emplace();
    const ReplayResult result = replay(mesh, session, options);
    const bool is_done = result.status == AdvectStatus::done;
    if (files && is_done) files->finish();
    options_.tell({false, is_done ? fmt::format("Exported {} frames.", frame_count(options.frames))
                                  : std::string("The export of frames was cancelled.")});
  });
}

bool Document::make_frames(const FrameExport& how, Progress& progress) {
  constexpr std::size_t most_bytes = std::size_t{1} << 29;
  const std::size_t bytes = sizeof(Vec3d) * std::max<std::size_t>(shown_.objects.mesh().vertex_count(), 1);
  ReplayOptions options = motion_of(how, progress);
  options.frames.hold = 0;
  options.frames.count =
      static_cast<int>(std::min(static_cast<std::size_t>(how.frames), std::max<std::size_t>(most_bytes / bytes, 2)));
  const Session session = history_session();
  options.frames.same_faces = std::all_of(session.strokes.begin(), session.strokes.end(),
                                          [](const SessionStroke& stroke) { return is_flow(stroke.stroke); });
  Motion motion{how, {}};
  options.frames.deliver = [&](const ReplayFrame& frame) {
    motion.frames.push_back(frame.shape.state(motion.frames.empty() ? ShapeState{} : motion.frames.back()));
  };
  const std::shared_ptr<const Mesh> mesh = base_mesh();
  if (replay(mesh, session, options).status != AdvectStatus::done) return false;
  motion_ = std::move(motion);
  return true;
}

void Document::look_at_frame(const FrameExport& how, int frame, Progress& progress) {
  if (!history_) return;
  guarded([&] {
    const bool is_made = motion_ && motion_->how.frames == how.frames && motion_->how.is_smooth == how.is_smooth;
    if (!is_made && !make_frames(how, progress)) return;
    const double moment = static_cast<double>(frame) / std::max(how.frames - 1, 1);
    const std::size_t last = motion_->frames.size() - 1;
    shown_.state = motion_->frames[static_cast<std::size_t>(std::lround(moment * static_cast<double>(last)))];
    shown_.looked_at = history_->done().size();
    show();
  });
}

namespace {

std::filesystem::path picture_file(const std::filesystem::path& file, int number) {
  std::string name = numbered(file).filename().string();
  name.replace(name.find(kNumber), std::string_view(kNumber).size(), fmt::format("{:04}", number));
  return file.parent_path() / name;
}

}  // namespace

void Document::write_poster(const std::filesystem::path& file, const PosterScene& how, int pictures,
                            Progress& progress) {
  if (!history_) return;
  guarded(Subject::picture, [&] {
    if (file.extension() != ".png") throw InvalidInput("A poster is a PNG file: give a name like poster.png");
    if (!settle(progress)) throw Cancelled();
    stop_if_cancelled(&progress);
    constexpr std::uint64_t each = 1000;
    progress.total = each * static_cast<std::uint64_t>(pictures);
    const Mesh mesh = visible_mesh(shown_.objects, history_->state());
    render::Scene scene;
    render::Shape& shape = scene.shapes.emplace_back();
    shape.mesh = &mesh;
    shape.use_mesh_colors = true;
    std::vector<Vec3d> points = render::scene_points(scene);
    if (pictures > 1) {
      points = render::turntable_points(mesh.positions, bounding_box(mesh.positions).center(), pictures, how.is_z_up);
    }
    render::Options options = how.options;
    const double aspect = static_cast<double>(options.width) / options.height;
    for (int i = 0; i < pictures; ++i) {
      const Mat3d turn = render::turntable_turn(i, pictures, how.is_z_up);
      const bool is_first = i == 0;
      const Vec3d direction = is_first ? how.view.direction : turn * how.view.direction;
      scene.camera =
          render::fit_points(points, direction, is_first ? how.view.up : turn * how.view.up, aspect, how.fit);
      options.progress = [&](double part) {
        stop_if_cancelled(&progress);
        progress.done = each * static_cast<std::uint64_t>(i) + static_cast<std::uint64_t>(part * each);
      };
      const std::string bytes = render::encode_png(render::render(scene, options));
      stop_if_cancelled(&progress);
      write_file_atomically(pictures == 1 ? file : picture_file(file, i), bytes);
    }
    options_.tell({false, pictures == 1 ? fmt::format("Wrote {}.", file.filename().string())
                                        : fmt::format("Wrote {} pictures.", pictures)});
  });
}

}  // namespace knead::studio
