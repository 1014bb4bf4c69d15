// The library for JavaScript: bindings/web/npm/index.js calls these functions. A Task holds the arrays of one call;
// JavaScript fills them in place, runs the task, and reads the result from it.
#include <emscripten.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "json/json.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/replay.h"
#include "knead/session.h"

// The caller's function, after each stroke.
EM_JS(void, tell_progress, (double fraction), { Module.onProgress(fraction); });

namespace {

using namespace knead;

// What JavaScript asks for, and what it gets.
struct Task {
  Mesh mesh;
  std::string session;
  std::string options;
  std::string file;    // the bytes of a shape's file, given and returned
  std::string name;    // of that file
  std::string report;  // of the result, as JSON
  std::string error;   // one line; empty: none
  std::vector<Vec3d> positions;
  bool is_remeshed = false;
};

struct Options {
  ReplayOptions replay;
  bool has_report = false;
  bool has_progress = false;
};

[[noreturn]] void fail(std::string_view key, const char* expected) {
  throw InvalidInput(fmt::format("options: \"{}\" must be {}", key, expected));
}

void read_option(const JsonMember& member, Options& options) {
  const auto& [key, value] = member;
  ReplayOptions& replay = options.replay;
  if (key == "tolerance") {
    if (!value.is_number()) fail(key, "a number above 0");
    replay.motion.relative_tolerance = value.number();
  } else if (key == "integrator") {
    const auto found = value.is_text() ? integrator_named(value.text()) : std::nullopt;
    if (!found) fail(key, "\"tsit5\" or \"rk4\"");
    replay.motion.integrator = *found;
  } else if (key == "precision") {
    const std::string text = value.is_text() ? value.text() : "";
    if (text != "float" && text != "double") fail(key, "\"float\" or \"double\"");
    replay.motion.precision = text == "float" ? Precision::float32 : Precision::float64;
  } else if (key == "inverse") {
    if (!value.is_flag()) fail(key, "true or false");
    replay.part.direction = value.flag() ? Direction::backwards : Direction::forwards;
  } else if (key == "until") {
    if (!value.is_number()) fail(key, "a number of strokes, 0 or more");
    replay.part.until = value.number();
  } else if (key == "report") {
    if (!value.is_flag()) fail(key, "true or false");
    options.has_report = value.flag();
  } else if (key == "hasProgress") {  // set by index.js
    options.has_progress = value.flag();
  } else if (key == "singlePrecision") {  // of the arrays; set by index.js
    replay.remesh.single_precision = value.flag();
  } else {
    throw InvalidInput(
        fmt::format("options: unknown key \"{}\"; use tolerance, integrator, precision, inverse, until "
                    "or report",
                    key));
  }
}

Options options_of(const std::string& text) {
  Options options;
  const Json json = parse_json(text);
  for (const JsonMember& member : json.members()) read_option(member, options);
  return options;
}

ReplayResult replay_or_throw(const std::shared_ptr<const Mesh>& mesh, const Session& session, const Options& options) {
  ReplayOptions with_progress = options.replay;
  Progress progress;
  if (options.has_progress) {
    with_progress.progress = &progress;
    with_progress.on_stroke = [&progress](const AppliedStroke&) {
      const auto total = static_cast<double>(std::max<std::uint64_t>(progress.total, 1));
      tell_progress(std::min(static_cast<double>(progress.done) / total, 1.0));
    };
  }
  ReplayResult result = replay(mesh, session, with_progress);
  if (result.status == AdvectStatus::step_limit) {
    throw InvalidInput(fmt::format("{}:{}: {}", session.name, result.failed_line, kStepLimitAdvice));
  }
  return result;
}

void deform_arrays(Task& task) {
  const Options options = options_of(task.options);
  const Session session = without_off(parse_session(task.session, "session"));
  const auto mesh = std::make_shared<const Mesh>(std::move(task.mesh));
  const ReplayResult result = replay_or_throw(mesh, session, options);
  if (options.has_report) task.report = to_json(make_report(*mesh, result, options.replay, {}));
  task.is_remeshed = result.shape.is_remeshed();
  task.positions = result.shape.positions();
  if (task.is_remeshed) task.mesh = result.shape.to_mesh();
}

void deform_file(Task& task) {
  Options options = options_of(task.options);
  const Session session = without_off(parse_session(task.session, "session"));
  ShapeFile source = parse_shape(std::move(task.file), format_of(task.name), task.name);
  split_splats(source, session, options.replay);
  if (source.mesh.face_count() == 0) options.replay.normals = vertex_normals_of(source);
  options.replay.remesh.face_labels = face_labels(source);
  WriteOptions write;
  options.replay.remesh.single_precision = stores_floats(task.name, source, write);
  const auto mesh = std::make_shared<const Mesh>(source.mesh);
  const ReplayResult result = replay_or_throw(mesh, session, options);
  if (options.has_report) task.report = to_json(make_report(*mesh, result, options.replay, {}));
  task.file = serialize_deformed(source.format, source, result.shape, write);
}

void read_file(Task& task) {
  ShapeFile shape = parse_shape(std::move(task.file), format_of(task.name), task.name);
  task.mesh = std::move(shape.mesh);
  task.positions = task.mesh.positions;
}

// Runs a function of the task. Whatever fails becomes its error.
void run(Task& task, void (*function)(Task&)) {
  try {
    function(task);
  } catch (const std::bad_alloc&) {
    task.error = "there is not enough memory for this shape; use a smaller one";
  } catch (const std::exception& error) {
    task.error = error.what();
  }
}

}  // namespace

// NOLINTBEGIN(bugprone-easily-swappable-parameters): JavaScript passes numbers
extern "C" {

EMSCRIPTEN_KEEPALIVE Task* knead_task() { return new (std::nothrow) Task; }
EMSCRIPTEN_KEEPALIVE void knead_free(Task* task) { delete task; }

// Makes room for a mesh; false if there is none.
EMSCRIPTEN_KEEPALIVE bool knead_resize(Task* task, std::size_t vertices, std::size_t faces, std::size_t corners) {
  try {
    task->mesh.positions.resize(vertices);
    task->mesh.face_begin.resize(faces + 1);
    task->mesh.corner_vertex.resize(corners);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}
EMSCRIPTEN_KEEPALIVE Vec3d* knead_positions(Task* task) { return task->mesh.positions.data(); }
EMSCRIPTEN_KEEPALIVE std::uint32_t* knead_face_begin(Task* task) { return task->mesh.face_begin.data(); }
EMSCRIPTEN_KEEPALIVE std::uint32_t* knead_corners(Task* task) { return task->mesh.corner_vertex.data(); }
EMSCRIPTEN_KEEPALIVE std::size_t knead_face_count(Task* task) { return task->mesh.face_count(); }
EMSCRIPTEN_KEEPALIVE std::size_t knead_corner_count(Task* task) { return task->mesh.corner_vertex.size(); }

// Makes room for a text; null if there is none. 0: session, 1: options, 2: file, 3: name, 4: report, 5: error.
EMSCRIPTEN_KEEPALIVE std::string* knead_text(Task* task, int which) {
  std::string* const texts[] = {&task->session, &task->options, &task->file, &task->name, &task->report, &task->error};
  return texts[which];
}
EMSCRIPTEN_KEEPALIVE char* knead_text_resize(std::string* text, std::size_t bytes) {
  try {
    text->resize(bytes);
    return text->data();
  } catch (const std::exception&) {
    return nullptr;
  }
}
EMSCRIPTEN_KEEPALIVE const char* knead_text_data(const std::string* text) { return text->data(); }
EMSCRIPTEN_KEEPALIVE std::size_t knead_text_size(const std::string* text) { return text->size(); }

EMSCRIPTEN_KEEPALIVE void knead_deform(Task* task) { run(*task, deform_arrays); }
EMSCRIPTEN_KEEPALIVE void knead_deform_file(Task* task) { run(*task, deform_file); }
EMSCRIPTEN_KEEPALIVE void knead_read(Task* task) { run(*task, read_file); }

EMSCRIPTEN_KEEPALIVE const Vec3d* knead_result(const Task* task) { return task->positions.data(); }
EMSCRIPTEN_KEEPALIVE std::size_t knead_result_count(const Task* task) { return task->positions.size(); }
EMSCRIPTEN_KEEPALIVE bool knead_is_remeshed(const Task* task) { return task->is_remeshed; }

}  // extern "C"
// NOLINTEND(bugprone-easily-swappable-parameters)
