#include "knead/io/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "knead/io/animation/writers.h"
#include "knead/io/authored_normals.h"
#include "knead/io/text.h"
#include "knead/math/error.h"
#include "knead/mesh/normals.h"

namespace knead {

namespace {

using MakeWriter = AnimationFile::Writer (*)(const std::filesystem::path& path, const ShapeFile& source,
                                             const AnimationOptions& options);

struct AnimationFormat {
  std::string_view extension;
  MakeWriter make;
};

constexpr std::array<AnimationFormat, 5> kFormats{{{".pc2", &io_detail::pc2_writer},
                                                   {".mdd", &io_detail::mdd_writer},
                                                   {".glb", &io_detail::glb_writer},
                                                   {".usda", &io_detail::usda_writer},
                                                   {".pvd", &io_detail::pvd_writer}}};

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

const AnimationFormat* format_of_animation(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  for (const AnimationFormat& format : kFormats) {
    if (format.extension == extension) return &format;
  }
  return nullptr;
}

AnimationFile::Writer make_writer(const std::filesystem::path& path, const ShapeFile& source,
                                  const AnimationOptions& options) {
  if (options.frames < 1) {
    throw InvalidInput(fmt::format("an animation has 1 frame or more, got {}", options.frames));
  }
  if (!(options.fps > 0 && std::isfinite(options.fps))) {
    throw InvalidInput(
        fmt::format("the frames per second must be a number above 0, got {}", io_detail::shown(options.fps)));
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
  std::vector<bool> is_used(mesh.vertex_count(), mesh.face_count() == 0);
  for (const std::uint32_t v : mesh.corner_vertex) is_used[v] = true;
  return std::find(is_used.begin(), is_used.end(), false) != is_used.end();
}

}  // namespace

bool is_animation(const std::filesystem::path& path) { return format_of_animation(path) != nullptr; }

std::vector<std::string> animation_losses(const std::filesystem::path& path, const ShapeFile& source) {
  const std::string extension = lower_extension(path);
  if (extension == ".glb")
    return source.format == "gltf" ? std::vector<std::string>{} : conversion_losses(path, source);
  if (extension == ".pc2" || extension == ".mdd") {
    const std::size_t objects = objects_of(source);
    if (objects > 1) {
      return {
          fmt::format("{} holds the positions of one mesh, but programs read the {} objects of this file as {} meshes; "
                      "write .glb or .usda, which hold the mesh themselves, or remove the lines 'o' first",
                      extension.substr(1), objects, objects)};
    }
    if (source.format == "obj" && has_loose_vertices(source.mesh)) {
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
    : writer_(make_writer(path, source, options)) {}

namespace io_detail {

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

}  // namespace io_detail
}  // namespace knead
