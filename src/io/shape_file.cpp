// Reads and writes shapes (knead/io.h): finds the codec, checks the arguments, and notes what a user should know.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <system_error>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/system.h"

namespace knead {
namespace {

using namespace detail;

constexpr std::string_view kFoamPoints = "points";  // the name of OpenFOAM's files, which have no extension
constexpr double kCoarse = 0.01;                    // of the mean edge
constexpr std::size_t kHead = 4096;                 // bytes that tell the kind of a file

bool is_device(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_type type = std::filesystem::status(path, error).type();
  return type == std::filesystem::file_type::character || type == std::filesystem::file_type::block;
}

// Returns true if the bytes of a file are on a disk, as they will be parsed.
bool is_plain_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && !detail::is_gzip_name(path);
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
  return detail::is_gzip_name(path) ? detail::unzipped(bytes, path.string()) : bytes;
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

void check_decimals(const WriteOptions& options) {
  constexpr int most = 17;  // that a double can tell apart
  if (options.decimals.value_or(0) >= 0 && options.decimals.value_or(0) <= most) return;
  throw InvalidInput(std::to_string(*options.decimals) + " decimals; give 0 to " + std::to_string(most));
}

void check(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options) {
  check_positions(source, positions);
  check_decimals(options);
  for (const Attribute& attribute : options.attributes) {
    if (attribute.values.size() != options.changed.size()) {
      throw InvalidInput("the attribute \"" + attribute.name + "\" has other than one value for each changed vertex");
    }
  }
  if (options.normals.empty() || options.normals.size() == positions.size()) return;
  throw InvalidInput(std::to_string(options.normals.size()) + " normals for " + std::to_string(positions.size()) +
                     " vertices; give one for each, or none");
}

bool are_unchanged(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options) {
  const bool is_edited = source.layout != nullptr && !source.layout->edits.vertices.empty();
  return !is_edited && options.changed.empty() &&
         std::equal(positions.begin(), positions.end(), source.mesh.positions.begin());
}

// Passes on the bytes of the source with other positions. The arguments have been checked.
void rewrite_in_pieces(const Codec& codec, const ShapeFile& source, std::span<const Vec3d> positions,
                       const WriteOptions& options, const ByteSink& out) {
  if (are_unchanged(source, positions, options)) {
    SourceBytes bytes(source);
    return bytes.copy(0, bytes.size(), out);
  }
  codec.rewrite_in_pieces(source, positions, moved_normals(source, positions, options), options, out);
}

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
  const auto result = detail::float_to_chars(buffer, buffer + sizeof buffer, value, detail::kGeneral, 3);
  return {buffer, result.ptr};
}

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

// Adds what a user of the shape should know about what it is.
void add_notes(const Mesh& mesh, std::vector<std::string>& notes) {
  if (are_splats(mesh)) notes.push_back(detail::splat_note(mesh));
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

bool has_floats(const Codec& codec, const ShapeFile& shape) {
  return codec.stores_floats != nullptr && codec.stores_floats(shape);
}

ShapeFile with_notes(const Codec& codec, ShapeFile shape) {
  add_notes(shape.mesh, shape.notes);
  if (!has_floats(codec, shape)) return shape;
  std::string note = spacing_note(shape.mesh);
  const bool is_due = !note.empty() && are_floats(shape.mesh.positions);  // else a node has moved them (GLB)
  if (is_due) shape.notes.push_back(std::move(note));
  return shape;
}

// Throws InvalidInput for a mesh of which no new file of a format can be made.
void require_held(const Codec& codec, const Mesh& mesh, const std::string& file) {
  const bool has_faces = mesh.face_count() > 0;
  if (codec.is_for_splats && are_splats(mesh)) return;
  const std::vector<std::string_view> extensions = written_extensions(has_faces);
  if (std::find(extensions.begin(), extensions.end(), codec.name) != extensions.end()) return;
  if (has_faces && codec.generate != nullptr && !codec.is_for_splats) return;  // its points alone
  std::string others;
  for (const std::string_view extension : extensions) {
    others += (others.empty() ? "." : extension == extensions.back() ? " or ." : ", .") + std::string(extension);
  }
  const std::string what = codec.generate == nullptr ? "can only be written from a shape that was read from such a file"
                           : codec.is_for_splats     ? "holds Gaussian splats, and this shape has none"
                                                     : "holds faces, and this shape has none";
  throw InvalidInput(Place{file}, "a file ." + std::string(codec.name) + " " + what + "; write " + others);
}

// Calls read() for a file that begins so and has so many bytes. A file that it refuses, and that is of another kind
// than its name says, is refused for that.
template <class Read>
auto read_as(const Codec& codec, const std::string& head, std::size_t size, const std::string& name, const Read& read) {
  detail::text_begin(head, name);
  try {
    return read();
  } catch (const InvalidInput&) {
    if (const auto other = detail::other_kind(head, size, codec.name)) throw InvalidInput(Place{name}, *other);
    throw;
  }
}

std::string head_of(const SourceFile& file) {
  std::string head(std::min(kHead, file.size()), '\0');
  file.read(0, head);
  return head;
}

// Returns the codec that the path's extension names. Throws InvalidInput that lists the known ones.
const Codec& codec_of(const std::filesystem::path& path) {
  std::string extension = shape_suffix(path);
  if (detail::is_gzip_name(path)) extension.resize(extension.size() - detail::kGzip.size());
  if (!extension.empty()) extension.erase(0, 1);
  return detail::codec_with_extension(detail::lower(extension), path.string());
}

// A shape of a file that is not read yet.
ShapeFile unread(const Codec& codec, std::string bytes) {
  ShapeFile shape;
  shape.format = codec.name;
  shape.bytes = std::move(bytes);
  return shape;
}

// Reads a file with what lies beside it.
ShapeFile read_beside(const Codec& codec, const std::filesystem::path& path) {
  ShapeFile shape = unread(codec, read_bytes(path));
  read_as(codec, shape.bytes.substr(0, kHead), shape.bytes.size(), path.string(),
          [&] { codec.read_beside(shape, path); });
  return shape;
}

// Writes the bytes of a file of this codec, with what lies beside it if it is of the source's own.
void write_bytes(const Codec& codec, const std::filesystem::path& path, const ShapeFile& source,
                 const std::string& bytes) {
  const bool has_others = codec.name == source.format && codec.write != nullptr;
  has_others ? codec.write(path, source, bytes) : detail::write_new_file(path, bytes);
}

// The options with doubles where the positions are no floats.
WriteOptions exact(WriteOptions options, std::span<const Vec3d> positions) {
  options.double_coordinates = options.double_coordinates || !are_floats(positions);
  return options;
}

void check_has_faces(const ShapeFile& source) {
  if (source.mesh.face_count() == 0) {
    throw InvalidInput("the shape has no faces, so there is nothing to remesh; leave the remeshing out");
  }
}

void check_attributes(const Mesh& before, const Mesh& mesh) {
  bool fits = mesh.attributes.size() == before.attributes.size();
  const std::size_t elements[] = {mesh.vertex_count(), mesh.corner_vertex.size(), mesh.face_count()};
  for (std::size_t i = 0; fits && i < mesh.attributes.size(); ++i) {
    const Attribute& a = mesh.attributes[i];
    const Attribute& b = before.attributes[i];
    fits = a.name == b.name && a.domain == b.domain && a.type == b.type && a.components == b.components &&
           a.values.size() == elements[static_cast<std::size_t>(a.domain)] * static_cast<std::size_t>(a.components);
  }
  if (!fits) throw InvalidInput("the new mesh has other attributes than its source; give it the same");
}

void check(const NewMesh& shape) {
  check_has_faces(shape.source);
  const auto& [source, mesh, face_source] = shape;
  if (face_source.size() != mesh.face_count()) {
    throw InvalidInput(std::to_string(face_source.size()) + " sources for " + std::to_string(mesh.face_count()) +
                       " faces; give one for each");
  }
  for (const std::uint32_t f : face_source) {
    if (f < source.mesh.face_count()) continue;
    throw InvalidInput("a face is said to lie in face " + std::to_string(f) + " of a shape of " +
                       std::to_string(source.mesh.face_count()) + " faces; count from 0");
  }
  check_attributes(source.mesh, mesh);
  validate(mesh);
}

bool is_unchanged(const NewMesh& shape) {
  const Mesh& before = shape.source.mesh;
  const Mesh& mesh = shape.mesh;
  if (before.positions != mesh.positions || before.face_begin != mesh.face_begin ||
      before.corner_vertex != mesh.corner_vertex || before.attributes != mesh.attributes) {
    return false;
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (shape.face_source[f] != f) return false;
  }
  return true;
}

}  // namespace

std::string detail::splat_note(const Mesh& splats) {
  try {
    return "Gaussian splats with spherical harmonics of degree " + std::to_string(splat_degree(splats));
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

std::string detail::bytes_of_file(const std::filesystem::path& path) { return read_bytes(path); }

void detail::write_new_file(const std::filesystem::path& path, const std::string& bytes) {
  write_file_atomically(path, is_gzip_name(path) ? zipped(bytes, path.string()) : bytes);
}

std::filesystem::path detail::folder_of(const std::filesystem::path& path) {
  const std::filesystem::path parent = path.parent_path();
  return parent.empty() ? std::filesystem::path(".") : parent;
}

std::vector<std::string_view> written_extensions(bool has_faces) {
  std::vector<std::string_view> extensions;
  for (const Codec* codec : detail::codecs()) {
    const bool is_held = codec->generate != nullptr && !codec->is_for_splats &&
                         (has_faces ? codec->remeshed != nullptr : !codec->needs_faces);
    if (is_held) extensions.push_back(codec->name);
  }
  return extensions;
}

std::vector<std::string_view> shape_extensions() {
  std::vector<std::string_view> extensions;
  for (const Codec* codec : detail::codecs()) {
    extensions.push_back(codec->name);
    extensions.insert(extensions.end(), codec->extensions.begin(), codec->extensions.end());
  }
  return extensions;
}

std::string shape_suffix(const std::filesystem::path& path) {
  if (detail::is_gzip_name(path)) return shape_suffix(path.stem()) + path.extension().string();
  return path.filename() == kFoamPoints ? "." + std::string(kFoamPoints) : path.extension().string();
}

std::string format_of(const std::filesystem::path& path) { return std::string(codec_of(path).name); }

ShapeFile read_shape(const std::filesystem::path& path, const ReadOptions& options) {
  require_no_folder(path);
  const Codec& codec = codec_of(path);
  std::error_code error;
  const bool is_large = codec.read_in_pieces != nullptr && is_plain_file(path) &&
                        std::filesystem::file_size(path, error) > options.most_kept_bytes && !error;
  if (is_large) {
    ShapeFile shape = unread(codec, {});
    shape.file = std::make_shared<const SourceFile>(path);
    const bool is_read = read_as(codec, head_of(*shape.file), shape.file->size(), path.string(),
                                 [&] { return codec.read_in_pieces(shape, path.string()); });
    if (is_read) return with_notes(codec, std::move(shape));
  }
  if (codec.read_beside != nullptr) return with_notes(codec, read_beside(codec, path));
  return parse_shape(read_bytes(path), codec.name, path.string());
}

ShapeFile parse_shape(std::string bytes, std::string_view format, const std::string& name) {
  const Codec& codec = codec_named(format, name);
  ShapeFile shape = unread(codec, std::move(bytes));
  read_as(codec, shape.bytes.substr(0, kHead), shape.bytes.size(), name, [&] { codec.read(shape, name); });
  return with_notes(codec, std::move(shape));
}

std::string read_text(const std::filesystem::path& path) {
  std::string bytes = read_bytes(path);
  bytes.erase(0, detail::text_begin(bytes, path.string()));
  return bytes;
}

ShapeSummary read_summary(const std::filesystem::path& path) {
  require_no_folder(path);
  const Codec& codec = codec_of(path);
  if (codec.read_beside != nullptr) return summary_of(read_beside(codec, path));
  if (codec.summarize != nullptr && is_plain_file(path)) {
    ShapeFile file;
    file.file = std::make_shared<const SourceFile>(path);
    std::optional<ShapeSummary> summary = read_as(codec, head_of(*file.file), file.file->size(), path.string(),
                                                  [&] { return codec.summarize(file, path.string()); });
    if (summary) return *std::move(summary);
  }
  return parse_summary(read_bytes(path), codec.name, path.string());
}

ShapeSummary parse_summary(std::string bytes, std::string_view format, const std::string& name) {
  const Codec& codec = codec_named(format, name);
  ShapeFile shape = unread(codec, std::move(bytes));
  return read_as(codec, shape.bytes.substr(0, kHead), shape.bytes.size(), name, [&] {
    std::optional<ShapeSummary> summary;
    if (codec.summarize != nullptr) summary = codec.summarize(shape, name);
    if (summary) return *std::move(summary);
    codec.read(shape, name);
    return summary_of(shape);
  });
}

std::string serialize_shape(std::string_view format, const ShapeFile& source, std::span<const Vec3d> positions,
                            const WriteOptions& options) {
  const Codec& codec = codec_named(format, "output");
  check(source, positions, options);
  if (codec.name != source.format) {
    require_held(codec, source.mesh, "output");
    return codec.generate(with_unit_colors(moved_mesh(source, positions, options)), exact(options, positions));
  }
  if (codec.rewrite_in_pieces != nullptr) {
    std::string bytes;
    reserve_large(bytes, SourceBytes(source).size());
    rewrite_in_pieces(codec, source, positions, options, [&](std::string_view piece) { bytes += piece; });
    return bytes;
  }
  if (are_unchanged(source, positions, options)) return source.bytes;
  return codec.rewrite(source, positions, moved_normals(source, positions, options), options);
}

std::string serialize_mesh(std::string_view format, const Mesh& mesh, const WriteOptions& options) {
  validate(mesh);
  check_decimals(options);
  const Codec& codec = codec_named(format, "output");
  require_held(codec, mesh, "output");
  return has_unit_colors(mesh) ? codec.generate(mesh, options) : codec.generate(with_unit_colors(mesh), options);
}

void write_shape(const std::filesystem::path& path, const ShapeFile& source, std::span<const Vec3d> positions,
                 const WriteOptions& options) {
  const Codec& codec = codec_of(path);
  const bool is_one_file = codec.write == nullptr || source.file;
  if (codec.name == source.format && codec.rewrite_in_pieces != nullptr && is_one_file && !detail::is_gzip_name(path)) {
    check(source, positions, options);
    std::optional<AtomicFile> file;  // from the first piece on: what is refused touches no file
    rewrite_in_pieces(codec, source, positions, options, [&](std::string_view piece) {
      if (!file) file.emplace(path);
      file->write(piece);
    });
    return file->finish();
  }
  write_bytes(codec, path, source, serialize_shape(codec.name, source, positions, options));
}

void write_mesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options) {
  detail::write_new_file(path, serialize_mesh(format_of(path), mesh, options));
}

std::vector<std::string> conversion_losses(const std::filesystem::path& path, const ShapeFile& source) {
  const Codec& codec = codec_of(path);
  if (codec.name == source.format) return {};
  require_held(codec, source.mesh, path.string());
  const bool has_units = has_unit_colors(source.mesh);
  std::vector<std::string> losses = has_units ? codec.losses(source.mesh) : codec.losses(with_unit_colors(source.mesh));
  if (!has_units) losses.emplace_back("colors that are not from 0 to 1 are scaled to what the format has");
  const std::vector<std::string> more = codec_named(source.format, path.string()).source_losses(source);
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
  // Files of splats have room for normals and leave it empty.
  const bool is_cloud = source.mesh.face_count() == 0;
  if (is_cloud && std::all_of(normal->values.begin(), normal->values.end(), [](double x) { return x == 0; })) return {};
  std::vector<Vec3d> normals(source.mesh.vertex_count());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    normals[i] = {normal->values[3 * i], normal->values[3 * i + 1], normal->values[3 * i + 2]};
  }
  return normals;
}

std::optional<int> decimals_of(const ShapeFile& source) {
  const auto visit_coordinates = codec_named(source.format, "source").visit_coordinates;
  std::optional<int> most;
  if (visit_coordinates == nullptr) return most;
  visit_coordinates(source,
                    [&](std::string_view word) { most = std::max(most.value_or(0), detail::decimals_in(word)); });
  return most;
}

bool stores_floats(const std::filesystem::path& path, const ShapeFile& source) {
  const Codec& codec = codec_of(path);
  return codec.name == source.format ? !codec.can_widen && has_floats(codec, source) : codec.generates_floats;
}

bool stores_floats(const std::filesystem::path& path, const ShapeFile& source, const WriteOptions& options) {
  if (stores_floats(path, source)) return true;
  const Codec& codec = codec_of(path);
  return codec.name == source.format && has_floats(codec, source) && !options.double_coordinates;
}

std::vector<std::uint32_t> face_labels(const ShapeFile& source) {
  const auto labels_of = codec_named(source.format, "source").face_labels;
  return labels_of == nullptr ? std::vector<std::uint32_t>{} : labels_of(source);
}

std::string serialize_remeshed(std::string_view format, const ShapeFile& source, const Mesh& mesh,
                               std::span<const std::uint32_t> face_source, const WriteOptions& options) {
  const NewMesh shape{source, mesh, face_source};
  check(shape);
  check_decimals(options);
  if (format != source.format) return serialize_mesh(format, mesh, exact(options, mesh.positions));
  if (is_unchanged(shape)) return std::string(SourceBytes(source).all());
  return codec_named(format, "source").remeshed(shape, options);
}

void write_remeshed(const std::filesystem::path& path, const ShapeFile& source, const Mesh& mesh,
                    std::span<const std::uint32_t> face_source, const WriteOptions& options) {
  const Codec& codec = codec_of(path);
  write_bytes(codec, path, source, serialize_remeshed(codec.name, source, mesh, face_source, options));
}

std::vector<std::string> remesh_losses(const std::filesystem::path& path, const ShapeFile& source) {
  check_has_faces(source);
  const Codec& codec = codec_of(path);
  if (codec.name != source.format) return conversion_losses(path, source);
  std::vector<std::string> losses = codec.remesh_losses(source);
  for (const std::string& note : source.notes) {
    if (note.find("fewer than three vertices") != std::string::npos) losses.push_back(note);
  }
  return losses;
}

std::vector<std::filesystem::path> copy_material_files(const ShapeFile& shape, const std::filesystem::path& source,
                                                       const std::filesystem::path& target,
                                                       std::vector<std::string>* notes) {
  const std::filesystem::path from = detail::folder_of(source);
  const std::filesystem::path to = detail::folder_of(target);
  const Codec* const codec = detail::find_codec(shape.format);
  std::error_code error;
  if (codec == nullptr || codec->copy_beside == nullptr || std::filesystem::equivalent(from, to, error)) return {};
  return codec->copy_beside(shape, from, to, [&](std::string_view text) {
    const bool is_new = notes != nullptr && std::find(notes->begin(), notes->end(), text) == notes->end();
    if (is_new) notes->emplace_back(text);
  });
}

}  // namespace knead
