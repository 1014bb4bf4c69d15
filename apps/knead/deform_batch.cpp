// knead deform --table: one deformed shape for each row of a table of values.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <system_error>

#include "deform.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/knead.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "output.h"

namespace knead::command {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kName = "name";
constexpr const char* kResults = "results.csv";
// The columns of a result, after the values. "made_of" identifies the inputs, so that the result need not be made
// again.
constexpr std::array<std::string_view, 8> kColumns{
    "file",           "moved_vertices", "volume_error", "greatest_stretch", "flipped_triangles",
    "inverted_cells", "made_of",        "error"};
constexpr std::size_t kMadeOf = 6;
constexpr std::size_t kError = 7;
// Shapes of more vertices are deformed one after the other, by all threads.
constexpr std::size_t kLargeShape = 500'000;

// One row of the table, and its result.
struct Variant {
  const Table::Row* row = nullptr;
  std::string name;
  ParameterValues values;
  std::string output;
  std::array<std::string, kColumns.size()> result{};  // as kColumns
  bool is_there = false;                              // from an earlier run
  bool has_failed = false;
  bool misses_quality = false;  // and for this reason
};

// FNV-1a.
std::string hash_of(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return fmt::format("{:016x}", hash);
}

// The size and the time of the last change.
std::string state_of(const fs::path& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error).time_since_epoch().count();
  return fmt::format("{} {} {}\n", path.string(), fs::file_size(path, error), time);
}

// A field of a CSV file.
std::string quoted(const std::string& field) {
  if (field.find_first_of("\",\n") == field.npos) return field;
  std::string text = "\"";
  for (const char c : field) text.append(c == '"' ? 2 : 1, c);
  return text + '"';
}

void check_alone(const DeformOptions& options) {
  const auto refuse = [](bool given, std::string_view option) {
    if (given) throw UsageError(fmt::format("--table: {} is for a single result; leave one of them out", option));
  };
  refuse(options.frames.frames.has_value(), "--frames");
  refuse(!options.also.empty(), "--also");
  refuse(options.stream, "--stream");
  refuse(options.check, "--check");
  refuse(options.require.has_value(), "--require");
  refuse(!options.report.empty(), "--report");
  refuse(options.backend != "cpu", "--backend");
  refuse(is_stream(options.shape) || is_stream(options.output), "standard input or output");
  check_streams({options.shape}, options.format);
}

class Batch {
 public:
  explicit Batch(const DeformOptions& options)
      : options_(options),
        is_animation_(is_animation(options.output) && !is_pattern(options.output)),
        replay_(replay_options(options)),
        digits_(digits_of(options)),
        table_(read_table(options.table)) {
    check_output();
    inputs_ = read_inputs(options.shape, {}, source_of(options), options.common.quiet, replay_.motion.threads);
    check_until(options, inputs_.session);
    find_columns();
    prepare();
    for (const Table::Row& row : table_.rows) add(row);
  }

  void run() {
    for (Variant& variant : variants_) begin(variant);
    CancelOnInterruption cancel(progress_);
    is_animation_ ? run_animation() : run_folder();
    finish();
  }

 private:
  void check_output() const {
    std::error_code error;
    const fs::path path = options_.output;
    if (is_animation_) return require_writable(path);
    if (!fs::is_directory(path, error) && (fs::exists(path, error) || is_shape_file(path))) {
      throw UsageError(
          fmt::format("--output {}: with --table, give a folder, or an animation such as all.pc2", path.string()));
    }
    require_writable(fs::is_directory(path, error) ? path / kResults : path);
    require_shape_extension(options_.shape);
  }

  // Finds the columns of parameters. Throws InvalidInput for unknown names, before anything is done.
  void find_columns() {
    const Place header{table_.path, 1};
    if (table_.names.empty()) throw InvalidInput(header, "the first line must name the columns by parameters");
    if (table_.rows.empty()) throw InvalidInput(header, "it holds no row of values; give 1 or more");
    std::set<std::string> known;
    for (const std::string& name : table_.names) {
      if (!known.insert(name).second) throw InvalidInput(header, fmt::format("the column \"{}\" is there twice", name));
      if (name == kName) continue;
      const auto is_it = [&](const Parameter& parameter) { return parameter.name == name; };
      const auto found = std::ranges::find_if(inputs_.session.parameters, is_it);
      if (found != inputs_.session.parameters.end()) continue;
      try {
        with_values(inputs_.session, {{name, 0}});
      } catch (const InvalidInput& error) {
        throw InvalidInput(header, error.what());
      }
    }
  }

  void prepare() {
    const ShapeFile& shape = inputs_.shape;
    const bool remeshes = Replay(borrow(shape.mesh), inputs_.session, replay_).remeshes();
    if (is_animation_ && remeshes) {
      throw UsageError(
          "--table: the session remeshes, and the frames of an animation have the same faces; give a folder");
    }
    if (shape.mesh.face_count() == 0) replay_.normals = vertex_normals_of(shape);
    replay_.remesh.face_labels = face_labels(shape);
    if (!is_animation_) {
      write_options_ = write_options_for(options_, digits_, shape, options_.shape);
      replay_.remesh.single_precision = stores_floats(options_.shape, shape, write_options_);
      if (!options_.common.quiet && remeshes) print_notes(remesh_losses(options_.shape, shape));
    }
    if (!options_.common.quiet && are_splats(shape.mesh) && options_.max_splats != 0) {
      print_message("note: long splats are not split with --table: they stay straight");
    }
    is_large_ = shape.mesh.vertex_count() > kLargeShape || is_animation_;
    threads_ = replay_.motion.threads;
    if (!is_large_) replay_.motion.threads = 1;
    replay_.progress = &progress_;
    replay_.strokes_warn = false;
    made_with_ = fmt::format(KNEAD_VERSION " {} {} {} {} {} {}\n", options_.tolerance,
                             static_cast<int>(options_.integrator), static_cast<int>(options_.precision),
                             options_.inverse, options_.until.value_or(-1), options_.digits);
    const RemeshFlags& remesh = options_.remesh;
    made_with_ +=
        fmt::format("{} {} {} {} {} {} {} {}\n", remesh.remesh, remesh.max_edge.value_or(-1),
                    remesh.max_angle.value_or(-1), remesh.max_chord.value_or(-1), remesh.min_edge.value_or(-1),
                    remesh.iterations.value_or(-1), remesh.max_vertices.value_or(0), remesh.seconds.value_or(0));
    made_with_ += state_of(options_.shape);
    for (const SessionStroke& stroke : inputs_.session.strokes) {
      const std::string file = file_of(stroke.stroke);
      if (!file.empty()) made_with_ += state_of(fs::path(options_.session).parent_path() / file);
    }
  }

  // Reads the values of a row. An error is a failure of that row alone.
  void add(const Table::Row& row) {
    Variant& variant = variants_.emplace_back();
    variant.row = &row;
    const int width = std::max(4, static_cast<int>(fmt::formatted_size("{}", table_.rows.size())));
    variant.name = fmt::format("{:0{}}", variants_.size(), width);
    guarded(variant, [&] {
      if (row.fields.size() > table_.names.size()) {
        throw InvalidInput(
            fmt::format("the line has {} fields, but the first line names {}", row.fields.size(), table_.names.size()));
      }
      for (std::size_t i = 0; i < row.fields.size(); ++i) read(table_.names[i], row.fields[i], variant);
      check_name(variant);
    });
  }

  void read(const std::string& column, const std::string& field, Variant& variant) const {
    if (field.empty()) return;  // the session's own value
    if (column == kName) {
      variant.name = field;
      return;
    }
    const std::optional<double> number = number_in(field, table_.separator);
    if (!number) throw InvalidInput(fmt::format("\"{}\" must be a number, got {}", column, field));
    variant.values[column] = *number;
  }

  void check_name(Variant& variant) {
    const std::string& name = variant.name;
    const bool is_plain =
        fs::path(name).filename() == name && name != "." && name != ".." && name.find('\\') == name.npos;
    const fs::path file = name + shape_suffix(options_.shape);
    if (!is_plain || lower_case(file.string()) == kResults) {
      throw InvalidInput(fmt::format("\"name\" must be that of a file, without folders, got {}", name));
    }
    const auto [other, is_new] = names_.emplace(lower_case(name), variant.row->line);
    if (!is_new) {
      throw InvalidInput(
          fmt::format("line {} has the name {}, too, or one that differs in upper and lower case alone, which are one "
                      "file on many systems; give each row a name of its own",
                      other->second, name));
    }
    variant.output = (fs::path(options_.output) / file).string();
  }

  // Checks the values, and finds the inputs of the result.
  void begin(Variant& variant) {
    if (variant.has_failed) return;
    guarded(variant, [&] {
      const Session session = with_values(inputs_.session, variant.values);
      variant.result[kMadeOf] = hash_of(made_with_ + serialize_session(session));
    });
  }

  // Calls do_it. An exception is the failure of the variant; a file that cannot be written ends the batch.
  template <class DoIt>
  void guarded(Variant& variant, const DoIt& do_it) {
    std::string error;
    try {
      return do_it();
    } catch (const QualityLimit& limit) {
      error = limit.what();
      variant.misses_quality = true;
    } catch (const QualityError& missed) {
      error = missed.what();
      variant.misses_quality = true;
    } catch (const InvalidInput& wrong) {
      error = wrong.what();
    } catch (const IoError& io) {
      if (io.operation() == IoError::Operation::write) {
        progress_.cancel = true;  // of the other rows
        throw;
      }
      error = io.what();
    }
    variant.has_failed = true;
    variant.result = {};
    variant.result[kError] = error;
    const std::scoped_lock lock(mutex_);
    print_message(fmt::format("{}: {}", to_string(table_.place(*variant.row)), error));
  }

  ReplayResult deform(const Variant& variant) {
    const Session session = with_values(inputs_.session, variant.values);
    ReplayResult result = replay(borrow(inputs_.shape.mesh), session, replay_);
    if (result.status == AdvectStatus::cancelled || progress_.cancel) throw Cancelled();
    if (result.status == AdvectStatus::step_limit) {
      throw QualityError(to_string(Place{session.name, result.failed_line}) + ": " + kStepLimitAdvice);
    }
    std::move(result.shortfalls.begin(), result.shortfalls.end(), std::back_inserter(result.warnings));
    const std::scoped_lock lock(mutex_);
    for (const std::string& warning : result.warnings) {
      const bool is_new = told_.insert(warning).second;
      if (is_new && !options_.common.quiet) {
        print_message(fmt::format("note: {}: {}", to_string(table_.place(*variant.row)), warning));
      }
    }
    return result;
  }

  void count_work() {
    const auto to_do = static_cast<std::uint64_t>(std::ranges::count_if(variants_, is_to_do));
    const std::uint64_t work =
        to_do > 0 ? to_do * Replay(borrow(inputs_.shape.mesh), inputs_.session, replay_).work() : 0;
    bar_.emplace(progress_, work, !options_.common.quiet, static_cast<int>(to_do), "variants");
  }

  static bool is_to_do(const Variant& variant) { return !variant.has_failed && !variant.is_there; }

  // --- a folder

  void run_folder() {
    fs::create_directories(options_.output);
    skip_what_is_there();
    write_results();
    std::ofstream results(results_path(), std::ios::binary | std::ios::app);
    count_work();
    parallel_for(variants_.size(), 1, is_large_ ? 1 : threads_, [&](std::size_t i, std::size_t) {
      Variant& variant = variants_[i];
      if (!is_to_do(variant)) return;
      stop_if_cancelled(&progress_);
      guarded(variant, [&] { make(variant); });
      const std::scoped_lock lock(mutex_);
      bar_->count_frame();
      results << line_of(variant) << std::flush;
      if (!results)
        throw IoError(IoError::Operation::write, results_path().string(), "cannot be written; free some space");
    });
    bar_.reset();
    write_results();
  }

  void make(Variant& variant) {
    const ReplayResult result = deform(variant);
    write_frame(variant.output, {}, inputs_, result.shape, write_options_);
    const Report report = make_report(inputs_.shape.mesh, result, replay_, {});
    const auto text = [](const std::optional<double>& number) { return number ? fmt::format("{}", *number) : ""; };
    variant.result = {fs::path(variant.output).filename().string(),
                      fmt::format("{}", report.moved_vertices),
                      text(report.volume_error),
                      text(report.greatest_stretch),
                      fmt::format("{}", report.flipped_triangles),
                      report.cells ? fmt::format("{}", report.cells->inverted) : "",
                      variant.result[kMadeOf],
                      ""};
    const std::scoped_lock lock(mutex_);
    if (!std::exchange(has_materials_, true)) {
      copy_materials(inputs_.shape, options_.shape, variant.output, options_.common.quiet);
    }
  }

  fs::path results_path() const { return fs::path(options_.output) / kResults; }

  // An earlier result counts if it has the same inputs, and its file still exists.
  void skip_what_is_there() {
    std::error_code error;
    if (!fs::exists(results_path(), error)) return;
    const Table before = read_table(results_path().string());
    std::map<std::string, std::size_t> columns;
    for (std::size_t i = 0; i < before.names.size(); ++i) columns[before.names[i]] = i;
    const auto lacks = [&](std::string_view name) { return !columns.contains(std::string(name)); };
    if (lacks(kName) || std::ranges::any_of(kColumns, lacks)) {
      throw InvalidInput(Place{results_path().string()},
                         "is no list of results of --table; move it, or give another folder");
    }
    std::map<std::string, const Table::Row*> rows;
    for (const Table::Row& row : before.rows) {
      if (row.fields.size() != before.names.size()) continue;  // cut off
      const bool has_failed = !row.fields[columns[std::string(kColumns[kError])]].empty();
      if (!has_failed) rows[row.fields[columns[std::string(kName)]]] = &row;
    }
    for (Variant& variant : variants_) {
      const auto found = rows.find(variant.name);
      if (variant.has_failed || found == rows.end() || !fs::exists(variant.output, error)) continue;
      std::array<std::string, kColumns.size()> result;
      for (std::size_t i = 0; i < kColumns.size(); ++i) {
        result[i] = found->second->fields[columns[std::string(kColumns[i])]];
      }
      variant.is_there = result[kMadeOf] == variant.result[kMadeOf];
      if (variant.is_there) variant.result = result;
    }
  }

  std::string line_of(const Variant& variant) const {
    std::string line = quoted(variant.name);
    for (const Parameter& parameter : inputs_.session.parameters) {
      const auto value = variant.values.find(parameter.name);
      line += fmt::format(",{}", value == variant.values.end() ? parameter.value : value->second);
    }
    for (const std::string& field : variant.result) line.append(",").append(quoted(field));
    return line + "\n";
  }

  // Writes the results so far, in the order of the table.
  void write_results() const {
    std::string text{kName};
    for (const Parameter& parameter : inputs_.session.parameters) text.append(",").append(parameter.name);
    text += fmt::format(",{}\n", fmt::join(kColumns, ","));
    for (const Variant& variant : variants_) {
      const bool is_done = variant.has_failed || !variant.result.front().empty();
      if (is_done) text += line_of(variant);
    }
    write_file_atomically(results_path(), text);
  }

  // --- an animation

  // Every row is a frame, so none may fail.
  void run_animation() {
    count_work();
    const auto add = animation_writer(options_.output, inputs_.shape, false, {static_cast<int>(variants_.size())});
    for (std::size_t i = 0; i < variants_.size(); ++i) {
      if (failures() > 0) return;
      guarded(variants_[i], [&] {
        const ReplayResult result = deform(variants_[i]);
        if (i + 1 == variants_.size()) end_after_last_output(options_.common.json);
        add({static_cast<int>(i), result.shape});
      });
      bar_->count_frame();
    }
    bar_.reset();
  }

  // ---

  std::size_t failures() const {
    return static_cast<std::size_t>(std::ranges::count_if(variants_, &Variant::has_failed));
  }

  void finish() const {
    const auto there = static_cast<std::size_t>(std::ranges::count_if(variants_, &Variant::is_there));
    const std::size_t failed = failures();
    const std::size_t made = is_animation_ && failed > 0 ? 0 : variants_.size() - there - failed;
    if (options_.common.json) {
      print(
          to_indented_text(Json{{"variants", variants_.size()}, {"made", made}, {"kept", there}, {"failed", failed}}));
    } else if (!options_.common.quiet) {
      print(fmt::format("{}: {}, {} made, {} kept, {} failed\n", options_.output, counted(variants_.size(), "variant"),
                        made, there, failed));
    }
    if (failed == 0) return;
    const std::string where = is_animation_ ? "nothing was written" : results_path().string() + " says why";
    const std::string text =
        fmt::format("{}: {} of {} failed; {}", table_.path, failed, counted(variants_.size(), "variant"), where);
    const auto is_quality = [](const Variant& variant) { return !variant.has_failed || variant.misses_quality; };
    if (std::ranges::all_of(variants_, is_quality)) throw QualityError(text);
    throw InvalidInput(text);
  }

  const DeformOptions& options_;
  bool is_animation_;
  ReplayOptions replay_;
  Digits digits_;
  Table table_;
  Inputs inputs_;
  WriteOptions write_options_;
  bool is_large_ = false;
  int threads_ = 0;
  std::string made_with_;
  std::vector<Variant> variants_;
  std::map<std::string, std::size_t> names_;  // in lower case, and their lines
  Progress progress_;
  std::optional<ProgressBar> bar_;
  std::mutex mutex_;  // of messages, results and what follows
  std::set<std::string> told_;
  bool has_materials_ = false;
};

}  // namespace

void run_batch(const DeformOptions& options) {
  check_alone(options);
  Batch batch(options);
  try {
    batch.run();
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
}

}  // namespace knead::command
