// knead info SHAPE: shows what is in a file. knead check SHAPE: prints that, and whether the surface is sound. knead
// make KIND: makes a procedural closed shape.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "certified.h"
#include "command.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "output.h"

namespace knead::command {

namespace {

// --- what info and check print as text

std::string row(std::string_view name, std::string_view value) { return fmt::format("{:<22}{}\n", name, value); }

std::string to_text(const Vec3d& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z); }

const char* yes_or_no(bool value) { return value ? "yes" : "no"; }

std::string rows_of(const Box& box, const std::vector<std::string>& attributes) {
  std::string text = row("box min", to_text(box.min));
  text += row("box max", to_text(box.max));
  text += row("diagonal", fmt::format("{:.6g}", box.diagonal()));
  return text + row("attributes", fmt::format("{}", fmt::join(attributes, ", ")));
}

// Return a row for each key except the notes; and the rows of the notes.
std::string table_of(const ShapeInfo& info) {
  const Measures& m = info.measures;
  std::string text = row("format", info.format);
  text += row("vertices", fmt::format("{}", m.vertices));
  text += row("faces", fmt::format("{}", m.faces));
  text += row("triangles", fmt::format("{}", m.triangles));
  text += row("closed", yes_or_no(m.closed()));
  text += row("manifold", yes_or_no(m.manifold()));
  text += row("oriented", yes_or_no(m.oriented()));
  text += row("components", fmt::format("{}", m.components));
  text += row("boundary loops", fmt::format("{}", m.boundary_loops));
  text += row("euler", fmt::format("{}", m.euler));
  text += row("volume", m.closed() && m.oriented() ? fmt::format("{:.6g}", m.volume) : "- (not closed and oriented)");
  text += row("area", fmt::format("{:.6g}", m.area));
  text += rows_of(m.box, info.attributes);
  if (info.cells) text += row("cells", fmt::format("{}", *info.cells));
  for (const auto& [name, points] : info.patches)
    text += row("patch", fmt::format("{}, {}", name, counted(points, "point")));
  return text;
}

std::string table_of(const ShapeSummary& summary) {
  std::string text = row("format", summary.format);
  text += row("vertices", fmt::format("{}", summary.vertices));
  text += row("faces", fmt::format("{}", summary.faces));
  text += row("triangles", fmt::format("{}", summary.triangles));
  return text + rows_of(summary.box, summary.attributes);
}

std::string table_of_notes(std::span<const std::string> notes) {
  std::string text;
  for (const std::string& note : notes) text += row("note", note);
  return text;
}

// --- info

struct InfoOptions {
  std::string shape;
  StreamFormat format;
  bool no_topology = false;
  CommonOptions common;
};

template <class Info>
void show(const Info& info, const CommonOptions& common) {
  if (common.json) {
    print(to_json(info));
  } else if (!common.quiet) {
    print(table_of(info) + table_of_notes(info.notes));
  }
}

void run_info(const InfoOptions& options) {
  check_streams({options.shape}, options.format);
  if (options.no_topology) return show(read_summary_or_stream(options.shape, options.format), options.common);
  const ReadOptions keep_no_bytes{.most_kept_bytes = 0};  // only the mesh is looked at
  const ShapeFile file = read_shape_or_stream(options.shape, options.format, keep_no_bytes);
  show(is_stream(options.shape) ? describe(file) : describe(file, options.shape), options.common);
}

// --- check

struct CheckOptions {
  std::string shape;
  std::vector<std::string> also;
  std::string before;
  std::optional<std::string> require;
  StreamFormat format;
  CommonOptions common;
};

std::size_t count_flipped_since(const CheckOptions& options, const Mesh& before, const Mesh& mesh) {
  if (before.vertex_count() != mesh.vertex_count() || before.face_begin != mesh.face_begin ||
      before.corner_vertex != mesh.corner_vertex) {
    throw InvalidInput(Place{options.before}, fmt::format("its faces differ from those of {}; give that shape as it "
                                                          "was before the deformation",
                                                          options.shape));
  }
  return count_flipped(WeldedMesh(mesh).mesh(), before.positions, mesh.positions);
}

std::string table_of_check(const SurfaceCheck& check) {
  const Measures& m = check.info.measures;
  std::string text = table_of(check.info);
  text += row("boundary edges", fmt::format("{}", m.boundary_edges));
  text += row("nonmanifold edges", fmt::format("{}", m.nonmanifold_edges));
  text += row("nonmanifold vertices", fmt::format("{}", m.nonmanifold_vertices));
  text += row("misoriented edges", fmt::format("{}", m.misoriented_edges));
  text += row("self-intersections", fmt::format("{}", check.self_intersections.count));
  text += row("degenerate triangles", fmt::format("{}", m.degenerate_triangles));
  text += row("smallest angle", m.smallest_angle_deg ? fmt::format("{:.6g} degrees", *m.smallest_angle_deg)
                                                     : "- (no triangle has an area)");
  text += row("folded edges", fmt::format("{}", check.folded_edges));
  if (check.crossings_between) text += row("crossings between", fmt::format("{}", *check.crossings_between));
  if (check.flipped_triangles) text += row("flipped triangles", fmt::format("{}", *check.flipped_triangles));
  if (const std::optional<CellCheck>& cells = check.cells) {
    text += row("cells", fmt::format("{}", cells->cells));
    text += row("inverted cells", fmt::format("{}", cells->inverted));
    if (cells->by_corners > 0)
      text += row("judged by corners", fmt::format("{} of the third order", cells->by_corners));
    if (cells->least_scaled_jacobian) {
      text += row("least scaled Jacobian", fmt::format("{:.6g}", *cells->least_scaled_jacobian));
    }
    text += row("non-orthogonality", fmt::format("{:.6g} degrees at most, {:.6g} on average",
                                                 cells->max_non_orthogonality_deg, cells->mean_non_orthogonality_deg));
    text += row("skewness", fmt::format("{:.6g}", cells->max_skewness));
    text += row("aspect ratio", fmt::format("{:.6g}", cells->max_aspect_ratio));
  }
  return text + table_of_notes(check.info.notes);
}

// Prints a line on standard error for each requirement that is not met; throws the last one.
void require_all(const CheckOptions& options, const std::vector<Requirement>& requirements, const SurfaceCheck& check) {
  std::string last;
  for (const Requirement& requirement : requirements) {
    const std::optional<std::string> complaint = unmet(requirement, check);
    if (!complaint) continue;
    if (!last.empty()) print_message(last);
    last = fmt::format("{}: {}", options.shape, *complaint);
  }
  if (!last.empty()) throw QualityError(last);
}

SurfaceCheck check_together(const CheckOptions& options, const ShapeFile& first) {
  std::vector<ShapeFile> others;
  for (const std::string& path : options.also) others.push_back(read_shape(path));
  std::vector<const Mesh*> meshes{&first.mesh};
  for (const ShapeFile& other : others) meshes.push_back(&other.mesh);
  const JoinedMeshes joined(meshes);
  ShapeInfo info = describe(joined.mesh());
  info.format = first.format;
  return check_surfaces(joined, std::move(info));
}

void run_check(const CheckOptions& options) {
  std::vector<Requirement> requirements;
  if (options.require) requirements = parse_requirements(*options.require, !options.before.empty());
  check_streams({options.shape}, options.format);
  if (!options.also.empty() && !options.before.empty()) {
    throw UsageError("--before: compares one shape; check each shape by itself, or leave out --also");
  }
  const ShapeFile file = read_shape_or_stream(options.shape, options.format);
  std::optional<std::size_t> flipped;
  const bool has_before = !options.before.empty();
  const ShapeFile before = has_before ? read_shape(options.before) : ShapeFile{};
  if (has_before) flipped = count_flipped_since(options, before.mesh, file.mesh);
  SurfaceCheck check = options.also.empty() ? check_surface(file.mesh, describe(file)) : check_together(options, file);
  check.flipped_triangles = flipped;
  const bool has_cells = has_before || !is_stream(options.shape);
  const VolumeCells cells = !has_cells   ? VolumeCells{}
                            : has_before ? read_cells(options.before, before)
                                         : read_cells(options.shape, file);
  if (cells.size() > 0) check.cells = check_cells(cells, file.mesh.positions);
  if (options.common.json) {
    print(to_json(check));
  } else if (!options.common.quiet) {
    print(table_of_check(check));
  }
  require_all(options, requirements, check);
}

// --- make

struct MakeOptions {
  std::string kind;
  std::optional<std::size_t> vertices;  // std::nullopt: the default of the kind
  std::string output;
  StreamFormat format;
  CommonOptions common;
};

ShapeKind checked_kind(const std::string& name) {
  const auto names = shape_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw UsageError(fmt::format("no kind of shape '{}'; say one of {}", name, fmt::join(names, ", ")));
  }
  return shape_kind(name);
}

void check_count(ShapeKind kind, const MakeOptions& options) {
  const ShapeCounts counts = shape_counts(kind);
  if (!options.vertices || (*options.vertices >= counts.minimum && *options.vertices <= counts.maximum)) return;
  throw UsageError(fmt::format("--vertices {}: a {} can have {} to {}", *options.vertices, options.kind, counts.minimum,
                               counts.maximum));
}

void run_make(const MakeOptions& options) {
  const ShapeKind kind = checked_kind(options.kind);
  check_count(kind, options);
  check_streams({options.output}, options.format);
  require_free_output(options.output, options.common.json, "--json");
  require_shape_output(options.output);
  const Mesh mesh = make_shape(kind, options.vertices.value_or(0));
  if (is_stream(options.output)) {
    return print(serialize_mesh(format_of(format_path(options.output, options.format)), mesh));
  }
  end_after_last_shape(options.output, options.common.json);
  write_mesh(options.output, mesh);
  if (options.common.json) {
    const Json json{{"kind", options.kind}, {"vertices", mesh.vertex_count()}, {"faces", mesh.face_count()}};
    print(to_indented_text(json));
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} vertices, {} faces\n", options.output, mesh.vertex_count(), mesh.face_count()));
  }
}

}  // namespace

Subcommand info_command() {
  const auto options = std::make_shared<InfoOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "A mesh or point cloud, such as a PLY, OBJ, STL, OFF, glTF or XYZ file", "",
       OptionKind::required},
      {"--no-topology", &options->no_topology,
       "Only counts, box and attributes: no look at which faces are neighbours, nor volume and area. Of a large binary "
       "PLY file this takes a quarter of the time and hardly any memory"},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"info", "Show what is in a file: counts, whether it is closed and manifold, volume, area, box", described,
          "  knead info hand.ply\n"
          "  knead info hand.ply --json\n"
          "  knead info scan.ply --no-topology",

          [options] { run_info(*options); }};
}

Subcommand check_command() {
  const auto options = std::make_shared<CheckOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "A mesh", "", OptionKind::required},
      {"--also", &options->also,
       "A further mesh, such as clothes; may be repeated. All are judged as one surface, and crossings between them "
       "are "
       "counted",
       "FILE"},
      {"--before", &options->before, "The same mesh before it was deformed, to count flipped triangles", "FILE"},
      {"--require", &options->require, "Exit with code 4 unless all of these hold: " + known_requirements(), "LIST"},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"check", "Check whether a surface is sound: self-intersections, triangles without area, folds", described,
          "  knead check scan.ply\n"
          "  knead check bent.ply --before hand.ply --json\n"
          "  knead check body.ply --also clothes.ply --require no-self-intersections\n"
          "  knead check bent.ply --require closed,manifold,no-self-intersections,min-angle=1",
          [options] { run_check(*options); }};
}

Subcommand make_command() {
  const auto options = std::make_shared<MakeOptions>();
  std::vector<Option> described{
      {"KIND", &options->kind, fmt::format("{}", fmt::join(shape_names(), ", ")), "", OptionKind::required},
      {"-n,--vertices", &options->vertices, "About this many vertices (each kind has its own default)", "N"},
      {"-o,--output", &options->output,
       fmt::format("The file, in the format of its extension: {}", fmt::join(written_extensions(true), ", ")), "FILE",
       OptionKind::required},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"make", "Make a procedural shape: closed, in one piece, of triangles", described,
          "  knead make hand -o hand.ply\n"
          "  knead make sphere -n 100000 -o sphere.obj",
          [options] { run_make(*options); }};
}

}  // namespace knead::command
