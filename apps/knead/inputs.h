// Reads the inputs of subcommands: shapes, sessions and landmarks, also from standard input (`-` with --format); and
// replays sessions with a backend and a progress bar.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "command.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::command {

using StreamFormat = std::optional<std::string>;  // the value of --format

void add_format_option(std::vector<Option>& options, StreamFormat& format);

inline bool is_stream(const std::string& path) { return path == "-"; }

// Throws UsageError if one of these paths is `-` and there is no format, or a format and none of them is `-`, or the
// format is none that is known.
void check_streams(const std::vector<std::string>& paths, const StreamFormat& format);

// Throws UsageError if the output is standard output, and so is what this option asks for.
void require_free_output(const std::string& output, bool asked, std::string_view option);

// Returns read_shape(path, options), or the shape on standard input.
ShapeFile read_shape_or_stream(const std::string& path, const StreamFormat& format, const ReadOptions& options = {});

// Returns read_summary(path), or that of the shape on standard input.
ShapeSummary read_summary_or_stream(const std::string& path, const StreamFormat& format);

// Returns a path with the extension of the format, for functions that ask what a format can hold: the path itself, or a
// name for standard output.
std::filesystem::path format_path(const std::string& path, const StreamFormat& format);

// Throws what require_shape_extension and require_writable throw for a file; nothing for standard output.
void require_shape_output(const std::string& path);

// Calls end_after_last_output, unless writing the shape writes several files (glTF with buffers, OBJ with materials).
void end_after_last_shape(const std::string& path, bool more_to_say);

// The option --set, which `deform` and `resolve` have.
void add_set_option(std::vector<Option>& options, std::vector<std::string>& set);

// A session that a command line names: a file, or strokes as JSON or in words (parse_stroke).
struct SessionSource {
  std::string path;
  std::vector<std::string> set{};      // values of parameters, each NAME=NUMBER
  std::vector<std::string> strokes{};  // in the place of a file
};

// Reads the session, with the values of --set. Throws UsageError for one that is none, or whose name is given twice.
Session read_session_with(const SessionSource& source);

// Writes to the file, or to standard output.
void write_remeshed_or_stream(const std::string& path, const StreamFormat& format, const ShapeFile& source,
                              const Mesh& mesh, std::span<const std::uint32_t> face_source,
                              const WriteOptions& options = {});

// Copies the material files that an OBJ file names to the folder of a target in its own format, with notes on standard
// error.
void copy_materials(const ShapeFile& shape, const std::string& source, const std::string& target, bool quiet);

// --- a session applied to a shape, watched and interruptible

// What the subcommands read. The session has no strokes that are off. Notes go to standard error unless quiet.
struct Inputs {
  ShapeFile shape;
  Session session;
  bool quiet = false;                    // no notes
  std::vector<ShapeFile> also{};         // further shapes that move along
  std::optional<JoinedMeshes> joined{};  // of `shape` and these, if there are some
  bool remeshes = false;                 // Replay::remeshes() with the options of the command

  // Returns what is deformed.
  const Mesh& mesh() const { return joined ? joined->mesh() : shape.mesh; }
};
Inputs read_inputs(const std::string& shape, const StreamFormat& format, const SessionSource& source, bool quiet,
                   int threads = 0);

// Returns the session for what keeps no points, so that no cell need be judged.
Session without_cells(Session session);

// Returns replay() of a session whose status is done; throws Interrupted or QualityError for other statuses. Unless
// quiet, shows a progress bar, and warnings on standard error. Replaces options.progress. The mesh must outlive the
// result.
ReplayResult replay_watched(const Mesh& mesh, const Session& session, ReplayOptions options, bool quiet);

// Returns a moment of a session, in strokes, counted in the strokes that it has resolved to instead: each stroke has
// become those of its line.
double moment_among_resolved(const std::vector<SessionStroke>& strokes, const std::vector<SessionStroke>& resolved,
                             double moment);

// Throws QualityError if a stroke fell short of what was asked. What was made has been written.
void require_reached(const ReplayResult& result);

// --- what --backend chooses

// What happened to a backend.
struct BackendUse {
  bool was_called = false;
  bool has_failed = false;  // the CPU did the rest
};

struct ChosenBackend {
  Backend move;  // empty: the CPU
  std::shared_ptr<const BackendUse> use{};

  // Returns the report's "backend": gpu only if the GPU moved all vertices.
  std::string name() const { return use != nullptr && use->was_called && !use->has_failed ? "gpu" : "cpu"; }
};

// Returns the backend of a name that check_backend accepts. If there is no GPU, or it fails, the CPU does the work, and
// a note on standard error says so unless quiet.
ChosenBackend choose_backend(const std::string& name, bool quiet);

// --- tables of text

using Fields = std::vector<std::string>;

// A table whose first line may name its columns.
struct Table {
  std::string path;
  char separator = ',';
  Fields names;  // empty: the first line has numbers
  struct Row {
    std::size_t line = 0;
    Fields fields;
  };
  std::vector<Row> rows;

  Place place(const Row& row) const { return {path, row.line}; }
};

// Reads a table with commas, semicolons or tabs between fields, also in quotes. Empty lines and those that begin with #
// are left out. Throws IoError(read), and InvalidInput for UTF-16.
Table read_table(const std::string& path);

// Returns a number, also with + or, where commas do not separate, with a decimal comma; nothing if it is none.
std::optional<double> number_in(std::string field, char separator);

// --- landmarks of `knead fit`: a table of pairs, or one file of points for each shape

struct LandmarkPairs {
  std::vector<Vec3d> source;
  std::vector<Vec3d> target;
  std::vector<double> tolerance;  // as many lengths, 0: exact
  std::vector<std::string> notes;
};

// Reads pairs of places (source_x,source_y,source_z,target_x,target_y,target_z) or of vertices from 0 on
// (source_vertex,target_vertex), as the first line names them, or by the number of columns; a column `tolerance` may
// follow. Fields lie between commas,
// semicolons or tabs, also in quotes; decimal commas are read where semicolons or tabs separate. A pair that is given
// twice counts once. Throws IoError(read), and InvalidInput with the line.
LandmarkPairs read_pairs(const std::string& path, const Mesh& source, const Mesh& target);

// Reads the landmarks of one shape from each file: .fcsv or .mrk.json of 3D Slicer, or a table x,y,z with or without
// `label`. Points belong together by their labels if both files have the same ones, otherwise by their order. Where one
// file is in RAS and the other in LPS, x and y of the one in RAS change their signs; a note says so. Throws as above.
LandmarkPairs read_points(const std::string& source, const std::string& target);

// Throws InvalidInput where the places of the target lie far from those of the source, or are their mirror images in
// axes, as between RAS and LPS. `diagonal`: of the source.
void check_frames(const LandmarkPairs& pairs, const std::string& path, double diagonal);

}  // namespace knead::command
