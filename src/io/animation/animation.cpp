// Writes animations: PC2 and MDD, ParaView's time series, and OpenUSD; glTF is in morph_targets.cpp.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "io/animation/writers.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {
namespace {

using Writer = AnimationFile::Writer;

// PC2 and MDD: positions alone. Sources: Blender's manual, "Mesh Cache Modifier", and the layouts that its readers
// document (MOD_meshcache_pc2.c, MOD_meshcache_mdd.c).

// Numbers of four bytes in one order.
class Bytes {
 public:
  explicit Bytes(std::endian order) : order_(order) {}

  void add(std::uint32_t value) {
    const std::uint32_t stored = order_ == std::endian::native ? value : swap_bytes(value);
    bytes_.append(reinterpret_cast<const char*>(&stored), sizeof stored);
  }
  void add(int value) { add(static_cast<std::uint32_t>(value)); }
  void add(float value) { add(bit_cast<std::uint32_t>(value)); }
  void add_text(std::string_view text) { bytes_ += text; }

  // Gives what was added, and begins again.
  std::string take() { return std::exchange(bytes_, {}); }

 private:
  std::endian order_;
  std::string bytes_;
};

Writer cache_writer(const std::filesystem::path& path, const std::string& header, std::endian order) {
  const auto file = std::make_shared<AtomicFile>(path);
  file->write(header);
  Writer writer;
  writer.add = [file, order, frame = std::string()](std::span<const Vec3d> positions) mutable {
    check_fits_floats(positions);
    frame.resize(positions.size() * 3 * sizeof(float));
    std::size_t at = 0;
    for (const Vec3d& p : positions) {
      for (std::size_t axis = 0; axis < 3; ++axis, at += sizeof(float)) put_float(frame, at, p[axis], order);
    }
    file->write(frame);
  };
  writer.finish = [file] { file->finish(); };
  return writer;
}

Writer pc2_writer(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options) {
  using namespace std::string_view_literals;
  Bytes header(std::endian::little);
  header.add_text("POINTCACHE2\0"sv);
  header.add(1);  // version
  header.add(static_cast<std::uint32_t>(source.mesh.vertex_count()));
  header.add(0.0f);  // start
  header.add(1.0f);  // frames from one sample to the next
  header.add(options.frames);
  return cache_writer(path, header.take(), std::endian::little);
}

Writer mdd_writer(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options) {
  Bytes header(std::endian::big);
  header.add(options.frames);
  header.add(static_cast<std::uint32_t>(source.mesh.vertex_count()));
  for (int k = 0; k < options.frames; ++k) header.add(static_cast<float>(k / options.fps));
  return cache_writer(path, header.take(), std::endian::big);
}

// ParaView's time series: a collection of VTK's XML PolyData files with appended binary data. Source: Kitware, "VTK
// File Formats" (https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html).

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

// The header of a .vtp file and the data that it tells of.
class PolyData {
 public:
  void begin(const char* part) { xml_ += fmt::format("<{}>\n", part); }
  void end(const char* part) { xml_ += fmt::format("</{}>\n", part); }

  template <class T>
  void add(std::string_view name, std::size_t components, const std::vector<T>& values) {
    const char* const type = std::is_same_v<T, double> ? "Float64" : std::is_same_v<T, float> ? "Float32" : "UInt32";
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        escaped(name), components, data_.size());
    const std::uint64_t size = values.size() * sizeof(T);
    data_.append(reinterpret_cast<const char*>(&size), sizeof size);
    data_.append(reinterpret_cast<const char*>(values.data()), size);
  }

  std::string file(std::size_t points, std::size_t verts, std::size_t polys) const {
    return fmt::format(
               "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" "
               "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" "
               "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n{}</Piece>\n</PolyData>\n"
               "<AppendedData encoding=\"raw\">\n_",
               std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", points, verts, polys, xml_) +
           data_ + "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::string xml_;
  std::string data_;
};

std::vector<double> numbers_of(std::span<const Vec3d> vectors) {
  std::vector<double> numbers;
  numbers.reserve(3 * vectors.size());
  for (const Vec3d& v : vectors) numbers.insert(numbers.end(), {v.x, v.y, v.z});
  return numbers;
}

// Polygons, or for a point cloud a cell for each point.
void add_cells(PolyData& data, const Mesh& mesh) {
  std::vector<std::uint32_t> connectivity = mesh.corner_vertex;
  std::vector<std::uint32_t> offsets(mesh.face_begin.begin() + 1, mesh.face_begin.end());
  const bool is_cloud = mesh.face_count() == 0;
  for (std::uint32_t v = 0; is_cloud && v < mesh.vertex_count(); ++v) {
    connectivity.push_back(v);
    offsets.push_back(v + 1);
  }
  data.begin(is_cloud ? "Verts" : "Polys");
  data.add("connectivity", 1, connectivity);
  data.add("offsets", 1, offsets);
  data.end(is_cloud ? "Verts" : "Polys");
}

std::string poly_data(const ShapeFile& source, std::span<const Vec3d> positions, const FrameNormals& normals) {
  const Mesh& mesh = source.mesh;
  PolyData data;
  data.begin("PointData");
  std::vector<Vec3d> displacement(positions.begin(), positions.end());
  for (std::size_t v = 0; v < displacement.size(); ++v) displacement[v] -= mesh.positions[v];
  data.add("displacement", 3, as_floats(displacement));
  const std::vector<Vec3d> directions = normals.at(positions);
  if (!directions.empty()) data.add("normal", 3, as_floats(directions));
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain != Domain::vertex || (attribute.name == "normal" && !directions.empty())) continue;
    data.add(attribute.name, static_cast<std::size_t>(attribute.components),
             std::vector<float>(attribute.values.begin(), attribute.values.end()));
  }
  data.end("PointData");
  data.begin("Points");
  data.add("Points", 3, numbers_of(positions));
  data.end("Points");
  add_cells(data, mesh);
  const bool is_cloud = mesh.face_count() == 0;
  return data.file(mesh.vertex_count(), is_cloud ? mesh.vertex_count() : 0, mesh.face_count());
}

// The files of the frames so far, and the collection that names them.
struct Series {
  const ShapeFile& source;
  FrameNormals normals;
  AtomicFile collection;
  std::filesystem::path path;
  double fps = 24;
  std::vector<AtomicFile> frames{};
  std::string text{};

  void add(std::span<const Vec3d> positions) {
    const std::string name = fmt::format("{}_{:04}.vtp", path.stem().string(), frames.size());
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", static_cast<double>(frames.size()) / fps,
                        escaped(name));
    frames.emplace_back(path.parent_path() / name, collection);
    frames.back().write(poly_data(source, positions, normals));
    frames.back().close();
  }

  void finish() {
    for (AtomicFile& frame : frames) frame.finish();
    collection.write(
        fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\">\n<Collection>\n{}</Collection>\n</VTKFile>\n",
                    text));
    collection.finish();
  }
};

Writer pvd_writer(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options) {
  discard_abandoned_files(path.parent_path());
  const auto series =
      std::make_shared<Series>(Series{source, FrameNormals(source), AtomicFile(path), path, options.fps});
  return {[series](std::span<const Vec3d> positions) { series->add(positions); }, [series] { series->finish(); }};
}

// OpenUSD's text format. Source: Pixar, "USD File Format" and the schemas UsdGeomMesh and UsdGeomPoints
// (https://openusd.org/release/api).

void append_tuple(std::string& text, const float* values) {
  fmt::format_to(std::back_inserter(text), "({}, {}, {})", values[0], values[1], values[2]);
}

// "[(x, y, z), ...]"
std::string tuples(std::span<const float> values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); i += 3) {
    if (i > 0) text += ", ";
    append_tuple(text, &values[i]);
  }
  return text + "]";
}

template <class T>
std::string list(std::span<const T> values) {
  return fmt::format("[{}]", fmt::join(values.begin(), values.end(), ", "));
}

std::string header(const AnimationOptions& options) {
  return fmt::format(
      "#usda 1.0\n(\n    defaultPrim = \"Shape\"\n    doc = \"Written by Knead\"\n    endTimeCode = {}\n"
      "    framesPerSecond = {}\n    metersPerUnit = 1\n    startTimeCode = 0\n    timeCodesPerSecond = {}\n"
      "    upAxis = \"Y\"\n)\n\n",
      options.frames - 1, options.fps, options.fps);
}

// The colours of vertices, from 0 to 1.
std::vector<float> colors_of(const Mesh& mesh) {
  const Attribute* color = mesh.find_attribute("color");
  std::vector<float> colors;
  if (color == nullptr || color->domain != Domain::vertex || color->components < 3) return colors;
  const double one = color->type == NumberType::uint8 ? 255 : color->type == NumberType::uint16 ? 65535 : 1;
  const auto components = static_cast<std::size_t>(color->components);
  for (std::size_t i = 0; i < color->values.size(); i += components) {
    for (std::size_t k = 0; k < 3; ++k) colors.push_back(static_cast<float>(color->values[i + k] / one));
  }
  return colors;
}

std::string prim(const Mesh& mesh) {
  std::string text = fmt::format("def {} \"Shape\"\n{{\n", mesh.face_count() > 0 ? "Mesh" : "Points");
  if (mesh.face_count() > 0) {
    std::vector<std::size_t> counts;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) counts.push_back(mesh.face(f).size());
    text += "    int[] faceVertexCounts = " + list<std::size_t>(counts) + "\n";
    text += "    int[] faceVertexIndices = " + list<std::uint32_t>(mesh.corner_vertex) + "\n";
    text += "    uniform token subdivisionScheme = \"none\"\n";
  }
  if (mesh.face_count() == 0) {  // spheres of about half the distance between points on a surface
    const double width = shape_box(mesh).diagonal() / std::sqrt(1.0 + static_cast<double>(mesh.vertex_count()));
    text += fmt::format("    float[] widths = [{}] (\n        interpolation = \"constant\"\n    )\n", 0.5 * width);
  }
  const std::vector<float> colors = colors_of(mesh);
  if (!colors.empty()) {
    text +=
        "    color3f[] primvars:displayColor = " + tuples(colors) + " (\n        interpolation = \"vertex\"\n    )\n";
  }
  return text;
}

// Points are written as they come; what is smaller, or not known before the end, is kept until then.
struct FileOfFrames {
  AtomicFile file;
  FrameNormals frame_normals;
  int frames = 0;
  std::vector<Changes> normals{};  // of each frame
  std::vector<std::array<float, 6>> extents{};

  void add(std::span<const Vec3d> positions) {
    check_fits_floats(positions);
    const std::vector<float> points = as_floats(positions);
    file.write(fmt::format("        {}: {},\n", frames++, tuples(points)));
    normals.push_back(changes_between(as_floats(frame_normals.first()), as_floats(frame_normals.at(positions))));
    const Box box = bounding_box(positions);
    const std::vector<float> corners = as_floats(std::array{box.min, box.max});
    extents.emplace_back();
    if (!box.empty()) std::copy(corners.begin(), corners.end(), extents.back().begin());
  }

  void finish() {
    file.write("    }\n");
    if (!frame_normals.first().empty()) write_normals();
    std::string text = "    float3[] extent.timeSamples = {\n";
    for (std::size_t k = 0; k < extents.size(); ++k) text += fmt::format("        {}: {},\n", k, tuples(extents[k]));
    file.write(text + "    }\n}\n");
    file.finish();
  }

  void write_normals() {
    file.write("    normal3f[] normals.timeSamples = {\n");
    for (std::size_t k = 0; k < normals.size(); ++k) {
      std::vector<float> now = as_floats(frame_normals.first());
      for (std::size_t i = 0; i < normals[k].elements.size(); ++i) {
        std::copy_n(&normals[k].values[3 * i], 3, &now[std::size_t{3} * normals[k].elements[i]]);
      }
      file.write(fmt::format("        {}: {},\n", k, tuples(now)));
    }
    file.write("    }\n");
  }
};

Writer usda_writer(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options) {
  const auto stage = std::make_shared<FileOfFrames>(FileOfFrames{AtomicFile(path), FrameNormals(source)});
  stage->file.write(header(options) + prim(source.mesh) + "    point3f[] points.timeSamples = {\n");
  return {[stage](std::span<const Vec3d> positions) { stage->add(positions); }, [stage] { stage->finish(); }};
}

struct AnimationFormat {
  std::string_view extension;
  Writer (*make)(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options);
};

constexpr std::array<AnimationFormat, 5> kFormats{{{".pc2", &pc2_writer},
                                                   {".mdd", &mdd_writer},
                                                   {".glb", &glb_writer},
                                                   {".usda", &usda_writer},
                                                   {".pvd", &pvd_writer}}};

std::string lower_extension(const std::filesystem::path& path) { return lower(path.extension().string()); }

const AnimationFormat* format_of_animation(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  for (const AnimationFormat& format : kFormats) {
    if (format.extension == extension) return &format;
  }
  return nullptr;
}

Writer make_writer(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options) {
  if (options.frames < 1) {
    throw InvalidInput(fmt::format("an animation has 1 frame or more, got {}", options.frames));
  }
  if (!(options.fps > 0 && std::isfinite(options.fps))) {
    throw InvalidInput(fmt::format("the frames per second must be a number above 0, got {}", shown(options.fps)));
  }
  const AnimationFormat* format = format_of_animation(path);
  if (format == nullptr) {
    throw InvalidInput(Place{path.string()},
                       "its extension is that of no animation; use one of .pc2, .mdd, .glb, .usda, .pvd");
  }
  return format->make(path, source, options);
}

// Returns how many objects other programs make of an OBJ file; 1 for other formats.
std::size_t objects_of(const ShapeFile& source) {
  if (source.format != "obj") return 1;
  const std::string_view text = source.bytes;
  std::size_t count = text.starts_with("o ") ? 1 : 0;
  for (std::size_t at = text.find("\no "); at != std::string_view::npos; at = text.find("\no ", at + 1)) ++count;
  return std::max<std::size_t>(count, 1);
}

bool has_loose_vertices(const Mesh& mesh) {
  const std::vector<bool> used = used_vertices(mesh);
  return mesh.face_count() > 0 && std::find(used.begin(), used.end(), false) != used.end();
}

}  // namespace

bool has_vertex_normals(const ShapeFile& source) {
  const Attribute* normals = source.mesh.find_attribute("normal");
  return normals != nullptr && normals->domain == Domain::vertex && source.mesh.face_count() > 0;
}

FrameNormals::FrameNormals(const ShapeFile& source) : source_(source) {
  if (has_vertex_normals(source)) {
    first_ = moved_normals(source, source.mesh.positions, {});
  } else if (source.mesh.face_count() > 0) {
    first_ = vertex_normals(source.mesh);
  }
}

std::vector<Vec3d> FrameNormals::at(std::span<const Vec3d> positions) const {
  if (has_vertex_normals(source_)) return moved_normals(source_, positions, {});
  const Mesh& mesh = source_.mesh;
  std::vector<bool> touched(mesh.vertex_count());  // the vertices of faces that moved
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    const auto has_moved = [&](std::uint32_t v) { return positions[v] != mesh.positions[v]; };
    if (std::none_of(face.begin(), face.end(), has_moved)) continue;
    for (const std::uint32_t v : face) touched[v] = true;
  }
  std::vector<Vec3d> normals = vertex_normals(mesh, positions, touched);
  for (std::size_t v = 0; v < first_.size(); ++v) {
    if (!touched[v]) normals[v] = first_[v];
  }
  return first_.empty() ? first_ : normals;
}

}  // namespace knead::detail

namespace knead {

bool is_animation(const std::filesystem::path& path) { return detail::format_of_animation(path) != nullptr; }

std::vector<std::string> animation_losses(const std::filesystem::path& path, const ShapeFile& source) {
  const std::string extension = detail::lower_extension(path);
  if (extension == ".glb") {
    std::vector<std::string> losses;
    if (source.format != "gltf") losses = conversion_losses(path, source);
    if (have_splats(source.mesh)) {
      losses.emplace_back("in an animation only the centres of splats move; write each frame to its own file");
    }
    return losses;
  }
  if (extension == ".pc2" || extension == ".mdd") {
    const std::size_t objects = detail::objects_of(source);
    if (objects > 1) {
      return {
          fmt::format("{} holds the positions of one mesh, but programs read the {} objects of this file as {} meshes; "
                      "write .glb or .usda, which hold the mesh themselves, or remove the lines 'o' first",
                      extension.substr(1), objects, objects)};
    }
    if (source.format == "obj" && detail::has_loose_vertices(source.mesh)) {
      return {
          fmt::format("{} holds the positions of all vertices, but programs leave out those that no face uses when "
                      "they read the shape; write .glb or .usda, which hold the mesh themselves, or remove these "
                      "vertices first",
                      extension.substr(1))};
    }
    return {fmt::format("{} holds positions alone: import the shape from {} first, and give it this cache",
                        extension.substr(1), source.format)};
  }
  std::vector<std::string> losses;
  for (const Attribute& attribute : source.mesh.attributes) {
    const bool is_held = extension == ".pvd" ? attribute.domain == Domain::vertex : attribute.name == "normal";
    const bool is_color = extension == ".usda" && attribute.name == "color" && attribute.domain == Domain::vertex;
    if (!is_held && !is_color) losses.push_back(fmt::format("\"{}\" is left out", attribute.name));
  }
  return losses;
}

AnimationFile::AnimationFile(const std::filesystem::path& path, const ShapeFile& source,
                             const AnimationOptions& options)
    : writer_(detail::make_writer(path, source, options)) {}

}  // namespace knead
