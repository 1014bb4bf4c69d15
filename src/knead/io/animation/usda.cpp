// OpenUSD's text format. Source: Pixar, "USD File Format" and the schemas UsdGeomMesh and UsdGeomPoints
// (https://openusd.org/release/api).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "knead/io/animation/changes.h"
#include "knead/io/animation/writers.h"
#include "knead/io/atomic_file.h"
#include "knead/io/binary_floats.h"
#include "knead/math/box.h"
#include "knead/mesh/measures.h"

namespace knead::io_detail {

namespace {

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
struct Stage {
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

}  // namespace

AnimationFile::Writer usda_writer(const std::filesystem::path& path, const ShapeFile& source,
                                  const AnimationOptions& options) {
  const auto stage = std::make_shared<Stage>(Stage{AtomicFile(path), FrameNormals(source)});
  stage->file.write(header(options) + prim(source.mesh) + "    point3f[] points.timeSamples = {\n");
  return {[stage](std::span<const Vec3d> positions) { stage->add(positions); }, [stage] { stage->finish(); }};
}

}  // namespace knead::io_detail
