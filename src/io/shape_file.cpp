#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <system_error>

#include "io/cloud/cloud.h"
#include "io/formats.h"
#include "io/glb/glb.h"
#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/obj/obj.h"
#include "io/off/off.h"
#include "io/ply/ply.h"
#include "io/solver/solver.h"
#include "io/stl/stl.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/system.h"

namespace knead::io_detail {
namespace {

bool always(const ShapeFile&) { return true; }
bool never(const ShapeFile&) { return false; }

constexpr std::array<std::string_view, 6> kPointExtensions = {"txt", "asc", "pts", "csv", "xyzn", "xyzrgb"};

constexpr std::array<std::string_view, 1> kFoamExtensions = {"points"};
constexpr std::array<std::string_view, 1> kNastranExtensions = {"nas"};

constexpr std::array<Format, 15> kFormats = {
    {{"ply",
      ply::parse,
      nullptr,
      nullptr,
      ply::generate,
      ply::losses,
      ply::source_losses,
      ply::remeshed,
      ply::remesh_losses,
      nullptr,
      never,
      false,
      ply::reads_floats,
      ply::visit_coordinates,
      {},
      ply::rewrite,
      ply::parse_in_pieces,
      ply::summarize},
     {"obj", obj::parse, nullptr, obj::rewrite, obj::generate, obj::losses, obj::source_losses, obj::remeshed,
      obj::remesh_losses, obj::face_labels, never, false, never, obj::visit_coordinates},
     {"glb", gltf::parse_glb, gltf::parse_glb_beside, gltf::rewrite, glb::generate, glb::losses, gltf::source_losses,
      gltf::remeshed, gltf::remesh_losses, gltf::face_labels, always, true, always},
     {"gltf", gltf::parse, gltf::parse_beside, gltf::rewrite, gltf::generate, glb::losses, gltf::source_losses,
      gltf::remeshed, gltf::remesh_losses, gltf::face_labels, always, true, always},
     {"stl", stl::parse, nullptr, stl::rewrite, stl::generate, stl::losses, stl::source_losses, stl::remeshed,
      stl::remesh_losses, nullptr, stl::stores_floats, true, stl::stores_floats, stl::visit_coordinates},
     {"off", off::parse, nullptr, off::rewrite, off::generate, off::losses, off::source_losses, off::remeshed,
      off::remesh_losses, nullptr, off::stores_floats, false, off::stores_floats, off::visit_coordinates},
     {"xyz", xyz::parse, nullptr, xyz::rewrite, xyz::generate, xyz::losses, xyz::source_losses, nullptr, nullptr,
      nullptr, never, false, never, xyz::visit_coordinates, kPointExtensions},
     {"pcd", pcd::parse, nullptr, pcd::rewrite, pcd::generate, pcd::losses, pcd::source_losses, nullptr, nullptr,
      nullptr, pcd::stores_floats, false, pcd::stores_floats, pcd::visit_coordinates},
     {"ptx", ptx::parse, nullptr, ptx::rewrite, nullptr, nullptr, ptx::source_losses, nullptr, nullptr, nullptr, never,
      false, never, ptx::visit_coordinates},
     solver::format<solver::kSu2>(),
     solver::format<solver::kGmsh>(),
     solver::format<solver::kFoam>(kFoamExtensions),
     solver::format<solver::kNastran>(kNastranExtensions),
     solver::format<solver::kAbaqus>(),
     solver::format<solver::kUnv>()}};

bool has_extension(const Format& format, std::string_view extension) {
  return format.name == extension ||
         std::find(format.extensions.begin(), format.extensions.end(), extension) != format.extensions.end();
}

}  // namespace

std::span<const Format> formats() { return kFormats; }

void check_decimals(const WriteOptions& options) {
  constexpr int most = 17;  // that a double can tell apart
  if (options.decimals.value_or(0) >= 0 && options.decimals.value_or(0) <= most) return;
  throw InvalidInput(std::to_string(*options.decimals) + " decimals; give 0 to " + std::to_string(most));
}

void write_own_format(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes) {
  gltf::write_beside(path, source, bytes);
}

void write_new_file(const std::filesystem::path& path, const std::string& bytes) {
  write_file_atomically(path, is_gzip_name(path) ? zipped(bytes, path.string()) : bytes);
}

const Format& format_with_extension(std::string_view extension, const std::string& file) {
  std::string supported;
  for (const Format& format : kFormats) {
    if (has_extension(format, extension)) return format;
    supported += (supported.empty() ? "." : ", .") + std::string(format.name);
    for (const std::string_view other : format.extensions) supported += ", ." + std::string(other);
  }
  if (extension == "knead") throw InvalidInput(Place{file}, "is a session, not a shape; name the shape it is for");
  const std::string what =
      extension.empty() ? "its name has no extension" : "format '" + std::string(extension) + "' is not supported";
  throw InvalidInput(Place{file}, what + "; use one of " + supported);
}

const Format& format_named(std::string_view name, const std::string& file) {
  std::string supported;
  for (const Format& format : kFormats) {
    if (format.name == name) return format;
    supported += (supported.empty() ? "" : ", ") + std::string(format.name);
  }
  throw InvalidInput(Place{file}, "format '" + std::string(name) + "' is not supported; use one of " + supported);
}

SourceFile::SourceFile(const std::filesystem::path& path)
    : path_(path.string()), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_ < 0) fail("cannot be read (" + std::generic_category().message(errno) + ")");
  state_ = state();
}

SourceFile::~SourceFile() {
  if (file_ >= 0) ::close(file_);
}

void SourceFile::fail(const std::string& what) const {
  throw IoError(IoError::Operation::read, path_, what + "; check the file and run this again");
}

SourceFile::State SourceFile::state() const {
  struct stat now {};
  if (::fstat(file_, &now) != 0) fail("cannot be read (" + std::generic_category().message(errno) + ")");
  return {static_cast<std::size_t>(now.st_size), changed_ns(file_, now)};
}

void SourceFile::read(std::size_t begin, std::span<char> to) const {
  while (!to.empty()) {
    const ssize_t count = ::pread(file_, to.data(), to.size(), static_cast<off_t>(begin));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("cannot be read (" + std::generic_category().message(errno) + ")");
    if (count == 0) break;  // it has become shorter
    begin += static_cast<std::size_t>(count);
    to = to.subspan(static_cast<std::size_t>(count));
  }
  if (!to.empty() || state() != state_) fail("has changed while it was in use");
}

std::string_view SourceBytes::piece(std::size_t begin, std::size_t count) {
  if (!source_.file) return std::string_view(source_.bytes).substr(begin, count);
  reserve_large(buffer_, count);
  buffer_.resize(count);
  source_.file->read(begin, buffer_);
  return buffer_;
}

void SourceBytes::copy(std::size_t begin, std::size_t end, const std::function<void(std::string_view)>& out) {
  constexpr std::size_t most = std::size_t{1} << 20;
  for (; begin < end; begin += std::min(most, end - begin)) out(piece(begin, std::min(most, end - begin)));
}

namespace {

constexpr double kCoarse = 0.01;  // of the mean edge

double mean_edge(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t c = 0; c < face.size(); ++c) {
      sum += norm(mesh.positions[face[c]] - mesh.positions[face[(c + 1) % face.size()]]);
    }
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, mesh.corner_vertex.size()));
}

// With three digits.
std::string short_number(double value) {
  char buffer[32];
  const auto result = float_to_chars(buffer, buffer + sizeof buffer, value, kGeneral, 3);
  return {buffer, result.ptr};
}

}  // namespace

std::string spacing_note(const Mesh& mesh) {
  const Box box = shape_box(mesh);
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(box.min[axis]), std::abs(box.max[axis])});
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  const double spacing = std::ldexp(1.0, std::ilogb(largest) - (std::numeric_limits<float>::digits - 1));
  const double diagonal = box.diagonal();
  const double points = std::sqrt(static_cast<double>(mesh.vertex_count()));
  constexpr double finest = 1e-5;  // edges of the diagonal: no mesh of memory's size has a shorter mean
  if (spacing < kCoarse * finest * diagonal) return {};
  const double edge = mesh.face_count() > 0 ? mean_edge(mesh) : diagonal / points;
  if (!(spacing > kCoarse * edge) || !(edge > 0)) return {};
  return "coordinates are floats that lie " + short_number(spacing) + " apart where the shape stands, and its mean " +
         (mesh.face_count() > 0 ? "edge" : "distance") + " is " + short_number(edge) +
         "; move the shape to the origin, or write its coordinates as doubles";
}

}  // namespace knead::io_detail

namespace knead {

using io_detail::ByteSink;
using io_detail::check_decimals;
using io_detail::Format;
using io_detail::format_named;
using io_detail::has_unit_colors;
using io_detail::moved_mesh;
using io_detail::moved_normals;
using io_detail::SourceBytes;
using io_detail::SourceFile;
using io_detail::with_unit_colors;

namespace {

constexpr std::string_view kFoamPoints = "points";  // the name of OpenFOAM's files, which have no extension

bool is_device(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_type type = std::filesystem::status(path, error).type();
  return type == std::filesystem::file_type::character || type == std::filesystem::file_type::block;
}

// Returns true if the bytes of a file are on a disk, as they will be parsed.
bool is_plain_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && !io_detail::is_gzip_name(path);
}

// Names a file of points that a folder of OpenFOAM has.
void require_no_folder(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return;
  std::string file = "a file in it";
  for (const char* const points : {"points", "polyMesh/points", "constant/polyMesh/points"}) {
    if (std::filesystem::exists(path / points, error)) file = (path / points).string();
  }
  throw IoError(IoError::Operation::read, path.string(), "is a folder; name " + file);
}

std::string read_bytes(const std::filesystem::path& path) {
  require_no_folder(path);
  const auto fail = [&](int error) {
    throw IoError(
        IoError::Operation::read, path.string(),
        "cannot be read (" + std::generic_category().message(error) + "); check the name and its permissions");
  };
  if (is_device(path)) {
    throw IoError(IoError::Operation::read, path.string(), "is a device, which may have no end; name a file or a pipe");
  }
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_to_read(path), std::fclose);
  if (!file) fail(errno);
  std::error_code no_size;  // pipes have none
  const std::uintmax_t size = std::filesystem::file_size(path, no_size);
  std::string bytes;
  reserve_large(bytes, no_size ? 0 : size);
  bytes.resize(no_size ? 0 : size);
  std::size_t count = std::fread(bytes.data(), 1, bytes.size(), file.get());
  bytes.resize(count);
  std::array<char, 1 << 16> block{};
  while ((count = std::fread(block.data(), 1, block.size(), file.get())) > 0) bytes.append(block.data(), count);
  if (std::ferror(file.get()) != 0) fail(errno);
  return io_detail::is_gzip_name(path) ? io_detail::unzipped(bytes, path.string()) : bytes;
}

bool fits_floats(std::span<const Vec3d> positions) {
  return std::all_of(positions.begin(), positions.end(), [](const Vec3d& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!io_detail::fits_float(p[axis]) || double{static_cast<float>(p[axis])} != p[axis]) return false;
    }
    return true;
  });
}

void check_positions(const ShapeFile& source, std::span<const Vec3d> positions) {
  if (positions.size() != source.mesh.vertex_count()) {
    throw InvalidInput(std::to_string(positions.size()) + " positions for a shape of " +
                       std::to_string(source.mesh.vertex_count()) + " vertices; give one for each");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!is_finite(positions[i])) {
      throw InvalidInput("vertex " + std::to_string(i) +
                         " would move to a position that is not finite; check the deformation");
    }
  }
}

void check(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options) {
  check_positions(source, positions);
  check_decimals(options);
  if (options.normals.empty() || options.normals.size() == positions.size()) return;
  throw InvalidInput(std::to_string(options.normals.size()) + " normals for " + std::to_string(positions.size()) +
                     " vertices; give one for each, or none");
}

// Passes on the bytes of the source with other positions. The arguments have been checked.
void rewrite_in_pieces(const Format& format, const ShapeFile& source, std::span<const Vec3d> positions,
                       const WriteOptions& options, const ByteSink& out) {
  if (std::equal(positions.begin(), positions.end(), source.mesh.positions.begin())) {
    SourceBytes bytes(source);
    return bytes.copy(0, bytes.size(), out);
  }
  format.rewrite_in_pieces(source, positions, moved_normals(source, positions, options), options, out);
}

// Adds what a user of the shape should know about what it is.
void add_notes(const Mesh& mesh, std::vector<std::string>& notes) {
  if (mesh.find_attribute("rot_0") != nullptr && mesh.find_attribute("scale_0") != nullptr) {
    notes.emplace_back("the turns and sizes of splats (rot_*, scale_*) stay as they are; only their places move");
  }
  if (std::string note = stray_note(mesh); !note.empty()) notes.push_back(std::move(note));
}

ShapeSummary summary_of(const ShapeFile& shape) {
  ShapeSummary summary;
  summary.format = shape.format;
  summary.vertices = shape.mesh.vertex_count();
  summary.faces = shape.mesh.face_count();
  summary.triangles = shape.mesh.corner_vertex.size() - 2 * shape.mesh.face_count();
  summary.box = shape_box(shape.mesh);
  for (const Attribute& attribute : shape.mesh.attributes) summary.attributes.push_back(attribute.name);
  summary.notes = shape.notes;
  add_notes(shape.mesh, summary.notes);
  return summary;
}

ShapeFile with_notes(const Format& format, ShapeFile shape) {
  add_notes(shape.mesh, shape.notes);
  if (!format.reads_floats(shape)) return shape;
  std::string note = io_detail::spacing_note(shape.mesh);
  const bool is_due = !note.empty() && fits_floats(shape.mesh.positions);  // else a node has moved them (GLB)
  if (is_due) shape.notes.push_back(std::move(note));
  return shape;
}

}  // namespace

namespace {

// Throws InvalidInput for a mesh of which no new file of a format can be made.
void require_held(const Format& format, const Mesh& mesh, const std::string& file) {
  const bool has_faces = mesh.face_count() > 0;
  const std::vector<std::string_view> extensions = written_extensions(has_faces);
  if (std::find(extensions.begin(), extensions.end(), format.name) != extensions.end()) return;
  if (has_faces && format.generate != nullptr) return;  // its points alone
  std::string others;
  for (const std::string_view extension : extensions) {
    others += (others.empty() ? "." : extension == extensions.back() ? " or ." : ", .") + std::string(extension);
  }
  const std::string what = format.generate == nullptr
                               ? "can only be written from a shape that was read from such a file"
                               : "holds faces, and this shape has none";
  throw InvalidInput(Place{file}, "a file ." + std::string(format.name) + " " + what + "; write " + others);
}

}  // namespace

std::vector<std::string_view> written_extensions(bool has_faces) {
  std::vector<std::string_view> extensions;
  for (const io_detail::Format& format : io_detail::formats()) {
    const bool is_held = format.generate != nullptr && (has_faces ? format.remeshed != nullptr : format.name != "stl");
    if (is_held) extensions.push_back(format.name);
  }
  return extensions;
}

std::vector<std::string_view> format_names() {
  std::vector<std::string_view> names;
  for (const io_detail::Format& format : io_detail::formats()) names.push_back(format.name);
  return names;
}

std::vector<std::string_view> shape_extensions() {
  std::vector<std::string_view> extensions;
  for (const io_detail::Format& format : io_detail::formats()) {
    extensions.push_back(format.name);
    extensions.insert(extensions.end(), format.extensions.begin(), format.extensions.end());
  }
  return extensions;
}

std::string shape_suffix(const std::filesystem::path& path) {
  if (io_detail::is_gzip_name(path)) return shape_suffix(path.stem()) + path.extension().string();
  return path.filename() == kFoamPoints ? "." + std::string(kFoamPoints) : path.extension().string();
}

std::string format_of(const std::filesystem::path& path) {
  std::string extension = shape_suffix(path);
  if (io_detail::is_gzip_name(path)) extension.resize(extension.size() - io_detail::kGzip.size());
  if (!extension.empty()) extension.erase(0, 1);
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::string(io_detail::format_with_extension(extension, path.string()).name);
}

namespace {

// Calls parse() for a file that begins so and has so many bytes. What it refuses, and is of another kind than its name
// says, is refused for that.
template <class Parse>
auto parsed(const std::string& head, std::size_t size, const Format& format, const std::string& name,
            const Parse& parse) {
  io_detail::text_begin(head, name);
  try {
    return parse();
  } catch (const InvalidInput&) {
    if (const auto other = io_detail::other_kind(head, size, format.name)) throw InvalidInput(Place{name}, *other);
    throw;
  }
}

constexpr std::size_t kHead = 4096;  // bytes that tell the kind of a file

std::string head_of(const SourceFile& file) {
  std::string head(std::min(kHead, file.size()), '\0');
  file.read(0, head);
  return head;
}

ShapeFile parse_beside(const Format& format, const std::filesystem::path& path) {
  std::string bytes = read_bytes(path);
  return parsed(bytes.substr(0, kHead), bytes.size(), format, path.string(),
                [&] { return format.parse_beside(std::move(bytes), path); });
}

}  // namespace

ShapeFile read_shape(const std::filesystem::path& path, const ReadOptions& options) {
  require_no_folder(path);
  const Format& source = format_named(format_of(path), path.string());
  if (source.parse_beside != nullptr) return with_notes(source, parse_beside(source, path));
  std::error_code error;
  const bool is_large = source.parse_in_pieces != nullptr && is_plain_file(path) &&
                        std::filesystem::file_size(path, error) > options.most_kept_bytes && !error;
  if (is_large) {
    const auto file = std::make_shared<const SourceFile>(path);
    std::optional<ShapeFile> shape = parsed(head_of(*file), file->size(), source, path.string(),
                                            [&] { return source.parse_in_pieces(file, path.string()); });
    if (shape) return with_notes(source, *std::move(shape));
  }
  return parse_shape(read_bytes(path), source.name, path.string());
}

ShapeFile parse_shape(std::string bytes, std::string_view format, const std::string& name) {
  const Format& source = format_named(format, name);
  return with_notes(source, parsed(bytes.substr(0, kHead), bytes.size(), source, name,
                                   [&] { return source.parse(std::move(bytes), name); }));
}

std::string io_detail::bytes_of_file(const std::filesystem::path& path) { return read_bytes(path); }

std::string read_text(const std::filesystem::path& path) {
  std::string bytes = read_bytes(path);
  bytes.erase(0, io_detail::text_begin(bytes, path.string()));
  return bytes;
}

ShapeSummary read_summary(const std::filesystem::path& path) {
  require_no_folder(path);
  const Format& source = format_named(format_of(path), path.string());
  if (source.parse_beside != nullptr) return summary_of(parse_beside(source, path));
  if (source.summarize != nullptr && is_plain_file(path)) {
    ShapeFile file;
    file.file = std::make_shared<const SourceFile>(path);
    std::optional<ShapeSummary> summary = parsed(head_of(*file.file), file.file->size(), source, path.string(),
                                                 [&] { return source.summarize(file, path.string()); });
    if (summary) return *std::move(summary);
  }
  return parse_summary(read_bytes(path), source.name, path.string());
}

ShapeSummary parse_summary(std::string bytes, std::string_view format, const std::string& name) {
  const Format& source = format_named(format, name);
  ShapeFile file;
  file.bytes = std::move(bytes);
  return parsed(file.bytes.substr(0, kHead), file.bytes.size(), source, name, [&] {
    std::optional<ShapeSummary> summary;
    if (source.summarize != nullptr) summary = source.summarize(file, name);
    return summary ? *std::move(summary) : summary_of(source.parse(std::move(file.bytes), name));
  });
}

std::string serialize_shape(std::string_view format, const ShapeFile& source, std::span<const Vec3d> positions,
                            const WriteOptions& options) {
  const Format& target = format_named(format, "output");
  check(source, positions, options);
  if (target.name != source.format) {
    WriteOptions exact = options;
    exact.double_coordinates = options.double_coordinates || !fits_floats(positions);
    require_held(target, source.mesh, "output");
    return target.generate(with_unit_colors(moved_mesh(source, positions, options)), exact);
  }
  if (target.rewrite_in_pieces != nullptr) {
    std::string bytes;
    reserve_large(bytes, SourceBytes(source).size());
    rewrite_in_pieces(target, source, positions, options, [&](std::string_view piece) { bytes += piece; });
    return bytes;
  }
  if (std::equal(positions.begin(), positions.end(), source.mesh.positions.begin())) return source.bytes;
  return target.rewrite(source, positions, moved_normals(source, positions, options), options);
}

std::string serialize_mesh(std::string_view format, const Mesh& mesh, const WriteOptions& options) {
  validate(mesh);
  check_decimals(options);
  const Format& target = format_named(format, "output");
  require_held(target, mesh, "output");
  return has_unit_colors(mesh) ? target.generate(mesh, options) : target.generate(with_unit_colors(mesh), options);
}

void write_shape(const std::filesystem::path& path, const ShapeFile& source, std::span<const Vec3d> positions,
                 const WriteOptions& options) {
  const std::string format = format_of(path);
  const Format& target = format_named(format, path.string());
  if (format == source.format && target.rewrite_in_pieces != nullptr && !io_detail::is_gzip_name(path)) {
    check(source, positions, options);
    std::optional<AtomicFile> file;  // from the first piece on: what is refused touches no file
    rewrite_in_pieces(target, source, positions, options, [&](std::string_view piece) {
      if (!file) file.emplace(path);
      file->write(piece);
    });
    return file->finish();
  }
  const std::string bytes = serialize_shape(format, source, positions, options);
  if (format == source.format) return io_detail::write_own_format(path, source, bytes);
  io_detail::write_new_file(path, bytes);
}

void write_mesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options) {
  io_detail::write_new_file(path, serialize_mesh(format_of(path), mesh, options));
}

std::vector<std::string> conversion_losses(const std::filesystem::path& path, const ShapeFile& source) {
  const std::string format = format_of(path);
  if (format == source.format) return {};
  const Format& target = format_named(format, path.string());
  require_held(target, source.mesh, path.string());
  const bool has_units = has_unit_colors(source.mesh);
  std::vector<std::string> losses =
      has_units ? target.losses(source.mesh) : target.losses(with_unit_colors(source.mesh));
  if (!has_units) losses.emplace_back("colors that are not from 0 to 1 are scaled to what the format has");
  const std::vector<std::string> more = format_named(source.format, path.string()).source_losses(source);
  losses.insert(losses.end(), more.begin(), more.end());
  std::vector<std::string> once;
  for (std::string& loss : losses) {
    if (std::find(once.begin(), once.end(), loss) == once.end()) once.push_back(std::move(loss));
  }
  return once;
}

std::vector<Vec3d> vertex_normals_of(const ShapeFile& source) {
  const Attribute* normal = source.mesh.find_attribute("normal");
  if (normal == nullptr || normal->domain != Domain::vertex || normal->components != 3) return {};
  std::vector<Vec3d> normals(source.mesh.vertex_count());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    normals[i] = {normal->values[3 * i], normal->values[3 * i + 1], normal->values[3 * i + 2]};
  }
  return normals;
}

std::optional<int> decimals_of(const ShapeFile& source) {
  const auto visit_coordinates = format_named(source.format, "source").visit_coordinates;
  std::optional<int> most;
  if (visit_coordinates == nullptr) return most;
  visit_coordinates(source,
                    [&](std::string_view word) { most = std::max(most.value_or(0), io_detail::decimals_in(word)); });
  return most;
}

bool stores_floats(const std::filesystem::path& path, const ShapeFile& source) {
  const Format& format = format_named(format_of(path), path.string());
  return format.name == source.format ? format.rewrites_floats(source) : format.generates_floats;
}

bool stores_floats(const std::filesystem::path& path, const ShapeFile& source, const WriteOptions& options) {
  if (stores_floats(path, source)) return true;
  const Format& format = format_named(format_of(path), path.string());
  return format.name == source.format && format.reads_floats(source) && !options.double_coordinates;
}

}  // namespace knead
