// The command line of `knead deform`, and deformation in pieces. `knead render` and `knead remesh` use parts of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "certified.h"
#include "command.h"
#include "inputs.h"
#include "knead/certify.h"
#include "knead/remesh.h"
#include "knead/replay.h"

namespace knead::command {

// --- remeshing: options of `knead deform` and `knead remesh`

struct RemeshFlags {
  bool remesh = false;
  std::optional<double> max_edge;
  std::optional<double> max_angle;  // degrees
  std::optional<double> max_chord;
  std::optional<double> min_edge;
  std::optional<int> iterations;
  std::optional<std::size_t> max_vertices;
  std::optional<double> seconds;
};

// Returns the settings that the options ask for, if any. Throws UsageError for a value out of range.
std::optional<RemeshSettings> settings_of(const RemeshFlags& flags);

// Adds --max-edge, --min-edge and --max-vertices, which also have a meaning without a deformation.
void add_edge_options(std::vector<Option>& options, RemeshFlags& flags);

// Adds --remesh and all options of remeshing after a deformation.
void add_remesh_options(std::vector<Option>& options, RemeshFlags& flags);

// --- --frames, --fps, --ease and --hold; file names of frames: a pattern with one %d or %0Nd

struct FrameFlags {
  std::optional<int> frames;
  std::optional<double> fps;
  Ease ease = Ease::linear;
  std::optional<int> hold;

  double frames_per_second() const { return fps.value_or(24); }
};

// Appends --fps, --ease and --hold.
void add_time_options(std::vector<Option>& options, FrameFlags& flags);

// Throws UsageError for a time without frames.
FrameOptions frame_options(const FrameFlags& flags);

// Returns whether a name is a pattern, or wants to be one.
inline bool is_pattern(const std::string& name) { return name.find('%') != std::string::npos; }

struct FramePattern {
  std::string before;
  int width = 0;  // digits, filled up with zeros; 0: as many as it takes
  std::string after;
};

// Throws UsageError unless the text holds exactly one %d or %0Nd (N from 1 to 9); %% stands for %.
FramePattern parse_frame_pattern(const std::string& text);

std::string frame_path(const FramePattern& pattern, int index);

// --- the command line

struct DeformOptions {
  std::string shape;
  std::string session;
  std::vector<std::string> strokes;  // in the place of a session
  std::string session_output;        // the file for the session; empty: none
  bool is_brief = false;             // says in one line what was done
  std::vector<std::string> set;      // values of the session's parameters
  std::string table;                 // of values, one variant a row; then `output` is a folder or an animation
  std::vector<std::string> also;     // further shapes; then `output` is a folder
  std::string output;
  double tolerance = 1e-5;
  Integrator integrator = Integrator::tsitouras;
  Precision precision = Precision::float32;
  std::string backend = "cpu";
  int threads = 0;  // 0: all
  bool inverse = false;
  bool keep_mesh = false;
  bool check = false;
  std::optional<std::string> require;
  RemeshFlags remesh;
  std::optional<double> until;
  FrameFlags frames;
  std::string report;
  std::string digits = "auto";
  std::optional<std::size_t> max_splats;
  bool stream = false;
  double piece_mb = 32;
  StreamFormat format;
  CommonOptions common;
};

// The value of --digits.
enum class DigitsKind { automatic, shortest, given };
struct Digits {
  DigitsKind kind = DigitsKind::automatic;
  int count = 0;  // if given
};

// Throws UsageError for values out of range, and for rounding beside a certificate.
Digits digits_of(const DeformOptions& options);

// Returns WriteOptions::decimals for an output like the source. Automatic: as many as the source's coordinates have, if
// half a unit of the last is within the tolerance (relative to the diagonal of the box).
std::optional<int> decimals_for(const Digits& digits, const ShapeFile& source, double tolerance);
// The same for coordinates with `own` decimals (std::nullopt if they are not text) in a box of that diagonal.
std::optional<int> decimals_for(const Digits& digits, std::optional<int> own, double diagonal, double tolerance);

// Throws UsageError where --until is beyond the session.
void check_until(const DeformOptions& options, const Session& session);

// The options of the subcommand, whose values go to `options`.
std::vector<Option> describe(DeformOptions& options);

// Throws UsageError for values out of range.
ReplayOptions replay_options(const DeformOptions& options);

// Returns how a shape like `shape` is written to `output`.
WriteOptions write_options_for(const DeformOptions& options, const Digits& digits, const ShapeFile& shape,
                               const std::string& output);

// Splits the long splats of the shape at that path, with a note.
void split_long_splats(const DeformOptions& options, const ReplayOptions& replay, const std::string& path,
                       const Session& session, ShapeFile& shape);

// Writes one deformed shape.
void write_frame(const std::string& path, const StreamFormat& format, const Inputs& inputs, const DeformedShape& shape,
                 const WriteOptions& options);

// --- what deforming one shape and several together share

// Finds problems with the report before the work begins.
void check_report(const DeformOptions& options, const std::string& output);

// Returns whether a report is printed or written: measuring a large shape takes longer than writing it.
bool is_reported(const DeformOptions& options);

// Returns whether the report that follows the shape is asked for, so that it is worth an interruption.
bool says_more(const DeformOptions& options);

// Returns where the session comes from.
SessionSource source_of(const DeformOptions& options);

// Deforms the shape as the options say.
void run_deform(const DeformOptions& options);

// Returns the report of a result.
Report report_of(const Mesh& mesh, const Certified& certified, const ReportSeconds& seconds);

// Prints or writes the report. `frames`: the line about them, if there are some.
void print_report(const DeformOptions& options, const std::string& output, const std::string& frames,
                  const Report& report);

// Returns whether crossings are bounded.
bool bounds_crossings(const std::vector<Bound>& bounds);

// Throws InvalidInput with the line of a stroke that is no flow: "a relax is no flow, so" and the consequence.
void require_flows(const Session& session, std::string_view consequence);

// To go backwards, resolves strokes that read the surface on the shapes that they were made on, and counts
// options.part.until in these. The replay refuses strokes that have no inverse.
void resolve_on_own_shape(Session& session, ReplayOptions& options, bool quiet);

// --- several shapes in one flow: --also

// Sets `joined` of inputs that have further shapes.
void join(Inputs& inputs);

// Returns the normals of clouds, zero for all other vertices; none if no cloud has some.
std::vector<Vec3d> normals_of_clouds(const Inputs& inputs);

// Deforms the shapes of SHAPE and --also, and puts all results in the folder -o, or none.
void run_together(const DeformOptions& options);

// --- a table of values: --table

// Deforms the shape once for each row of the table, rows side by side. Goes on after a row that fails, and throws
// InvalidInput or QualityError at the end if one did.
void run_batch(const DeformOptions& options);

// --- a point cloud in pieces

// Returns whether the cloud goes through in pieces: with --stream, or where the file is larger than half of the memory
// and nothing stands against it. Throws UsageError, or what CloudPieces throws, where --stream cannot be had.
bool is_streamed(const DeformOptions& options);

// Reads the cloud twice: for the box, the decimals and the columns of the whole; then piece by piece to be moved and
// written. The file appears when all is written. The bytes are those without pieces.
void run_stream(const DeformOptions& options);

}  // namespace knead::command
