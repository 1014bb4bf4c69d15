// ParaView's time series: a collection of VTK's XML PolyData files with appended binary data. Source: Kitware, "VTK
// File Formats" (https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html).
#include <fmt/format.h>

#include <bit>
#include <memory>

#include "knead/io/animation/changes.h"
#include "knead/io/animation/writers.h"
#include "knead/io/atomic_file.h"

namespace knead::io_detail {

namespace {

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

}  // namespace

AnimationFile::Writer pvd_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options) {
  discard_abandoned_files(path.parent_path());
  const auto series =
      std::make_shared<Series>(Series{source, FrameNormals(source), AtomicFile(path), path, options.fps});
  return {[series](std::span<const Vec3d> positions) { series->add(positions); }, [series] { series->finish(); }};
}

}  // namespace knead::io_detail
