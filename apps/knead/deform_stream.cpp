// knead deform --stream: a point cloud in pieces.
#include "deform.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "inputs.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "output.h"
#include "program.h"

namespace knead::command {
namespace {

// Returns the option that a stream cannot serve, or nothing.
std::optional<std::string> what_needs_the_whole(const DeformOptions& options) {
  if (is_stream(options.shape) || is_stream(options.output)) return "-";
  if (!options.also.empty()) return "--also";
  if (options.frames.frames) return "--frames";
  if (options.check) return "--check";
  if (options.require) return "--require";
  if (options.remesh.remesh || settings_of(options.remesh)) return "--remesh";
  if (!options.report.empty()) return "--report";
  if (options.common.json) return "--json";
  if (options.backend != "cpu") return "--backend " + options.backend;
  return std::nullopt;
}

bool is_larger_than_half_the_memory(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return false;
  return size > memory_bytes() / 2;
}

// The properties of the whole cloud that must be known before a piece is moved.
struct Whole {
  CloudBox cloud;
  std::optional<int> decimals;
  std::vector<std::string> columns;  // the names of the attributes
  std::size_t points = 0;
};

std::vector<std::string> columns_of(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const Attribute& attribute : mesh.attributes) names.push_back(attribute.name);
  return names;
}

class Stream {
 public:
  explicit Stream(const DeformOptions& options)
      : options_(options),
        digits_(digits_of(options)),
        replay_(replay_options(options)),
        cloud_(options.shape, static_cast<std::size_t>(options.piece_mb * 1e6)),
        session_(without_off(read_session_with(source_of(options)))) {}

  void run() {
    check_until(options_, session_);
    if (needs_faces(session_)) {
      throw InvalidInput(
          Place{options_.session},
          "a stroke reads the surface, of which a piece has only a part; resolve it first (knead resolve)");
    }
    require_different(options_.shape, options_.output);
    require_same_type();
    const bool quiet = options_.common.quiet;
    Progress progress;  // an interruption ends the program at once, because nothing must be cleaned up
    {
      progress.total = 2 * cloud_.size();
      ProgressBar bar(progress, progress.total, !quiet);
      find_whole(progress);
      write(progress);
    }
    end_after_last_shape(options_.output, false);
    output_->finish();
    if (!quiet) {
      for (const std::string& note : notes_) print_message("note: " + note);
      print(fmt::format("{}: {} of {} vertices moved by {}, in {}\nseconds  {:.2f}\n", options_.output, moved_,
                        whole_.points, counted(session_.strokes.size(), "stroke"), counted(pieces_, "piece"),
                        clock_.seconds()));
    }
  }

 private:
  // Refuses --precision double where the coordinates of the file are floats, before it is read to its end.
  void require_same_type() {
    if (options_.precision != Precision::float64) return;
    const std::optional<ShapeFile> piece = cloud_.next();
    cloud_.rewind();
    if (!piece || piece->format != "ply") return;
    std::vector<Vec3d> positions = piece->mesh.positions;
    for (Vec3d& p : positions) p.x += 0.1 * (1 + std::abs(p.x));
    WriteOptions options;
    options.double_coordinates = true;
    if (serialize_shape("ply", *piece, positions, options).size() == piece->bytes.size()) return;
    throw UsageError("--stream: --precision double writes other types than the file has; leave one of them out");
  }

  void find_whole(Progress& progress) {
    bool is_first = true;
    while (const std::optional<ShapeFile> piece = cloud_.next()) {
      whole_.cloud.add(piece->mesh.positions);
      whole_.decimals = std::max(whole_.decimals, decimals_of(*piece));
      whole_.points += piece->mesh.vertex_count();
      const std::vector<std::string> columns = columns_of(piece->mesh);
      if (is_first) whole_.columns = columns;
      if (columns != whole_.columns) {
        throw InvalidInput(Place{options_.shape},
                           "its rows are not alike: a later part has other columns than the first, "
                           "so it cannot be read in pieces");
      }
      if (is_first) notes_of_file(piece->notes);
      if (is_first && are_splats(piece->mesh) && options_.max_splats != 0) {
        notes_.insert("long splats are not split in a stream: they stay straight");
      }
      is_first = false;
      progress.done = cloud_.position();
    }
    cloud_.rewind();
  }

  void notes_of_file(const std::vector<std::string>& notes) {
    for (const std::string& note : notes) notes_.insert(options_.shape + ": " + note);
  }

  void write(Progress& progress) {
    const Box box = whole_.cloud.box();
    const std::vector<Vec3d> corners = box.empty() ? std::vector<Vec3d>{} : std::vector<Vec3d>{box.min, box.max};
    replay_.motion.diagonal = reference_length(corners);
    WriteOptions write_options;
    write_options.double_coordinates = options_.precision == Precision::float64;
    write_options.decimals = decimals_for(digits_, whole_.decimals, box.diagonal(), options_.tolerance);
    output_.emplace(options_.output);
    output_->write(cloud_.head());
    while (const std::optional<ShapeFile> piece = cloud_.next()) {
      write(*piece, write_options);
      progress.done = cloud_.size() + cloud_.position();
    }
    output_->write(cloud_.tail());
  }

  void write(const ShapeFile& piece, const WriteOptions& options) {
    ++pieces_;
    replay_.normals = vertex_normals_of(piece);
    const ReplayResult result = replay(borrow(piece.mesh), session_, replay_);
    if (result.status == AdvectStatus::step_limit) {
      throw QualityError(to_string(Place{session_.name, result.failed_line}) + ": " + kStepLimitAdvice);
    }
    notes_.insert(result.warnings.begin(), result.warnings.end());
    notes_.insert(result.shortfalls.begin(), result.shortfalls.end());
    replay_.strokes_warn = false;  // they are the same for every piece
    const std::span<const Vec3d> positions = result.shape.positions();
    for (std::size_t i = 0; i < positions.size(); ++i) moved_ += positions[i] != piece.mesh.positions[i] ? 1 : 0;
    output_->write(cloud_.rows(piece, serialize_deformed(piece.format, piece, result.shape, options)));
  }

  Clock clock_;
  const DeformOptions& options_;
  Digits digits_;
  ReplayOptions replay_;
  CloudPieces cloud_;
  Session session_;
  Whole whole_;
  std::optional<AtomicFile> output_;
  std::set<std::string> notes_;
  std::size_t moved_ = 0;
  std::size_t pieces_ = 0;
};

}  // namespace

bool is_streamed(const DeformOptions& options) {
  const std::optional<std::string> obstacle = what_needs_the_whole(options);
  if (options.stream) {
    if (obstacle) throw UsageError(fmt::format("--stream: {} needs the whole cloud; leave one of them out", *obstacle));
    if (format_of(options.output) != format_of(options.shape)) {
      throw UsageError("--stream: the output must have the format of the cloud; convert it afterwards");
    }
    return true;
  }
  if (obstacle || !is_larger_than_half_the_memory(options.shape)) return false;
  try {
    const CloudPieces cloud(options.shape, 1);
    return format_of(options.output) == format_of(options.shape) && !needs_faces(read_session_with(source_of(options)));
  } catch (const std::exception&) {
    return false;  // reading it as a whole names the error
  }
}

void run_stream(const DeformOptions& options) { Stream(options).run(); }

}  // namespace knead::command
