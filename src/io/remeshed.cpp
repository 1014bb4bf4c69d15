#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include "io/formats.h"
#include "io/gltf/gltf.h"
#include "io/obj/obj.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/io.h"

namespace knead {
namespace {

using io_detail::NewMesh;

// The format of a source with faces: not XYZ.
const io_detail::Format& own_format(const ShapeFile& source) {
  return io_detail::format_named(source.format, "source");
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

bool are_floats(const Mesh& mesh) {
  return std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Vec3d& p) {
    return io_detail::fits_float(p.x) && io_detail::fits_float(p.y) && io_detail::fits_float(p.z) &&
           Vec3d(Vec3f(p)) == p;
  });
}

}  // namespace

std::vector<std::uint32_t> face_labels(const ShapeFile& source) {
  const auto labels_of = own_format(source).face_labels;
  return labels_of == nullptr ? std::vector<std::uint32_t>{} : labels_of(source);
}

std::string serialize_remeshed(std::string_view format, const ShapeFile& source, const Mesh& mesh,
                               std::span<const std::uint32_t> face_source, const WriteOptions& options) {
  const NewMesh shape{source, mesh, face_source};
  check(shape);
  io_detail::check_decimals(options);
  if (format != source.format) {
    WriteOptions exact = options;
    exact.double_coordinates = options.double_coordinates || !are_floats(mesh);
    return serialize_mesh(format, mesh, exact);
  }
  return is_unchanged(shape) ? std::string(io_detail::SourceBytes(source).all())
                             : own_format(source).remeshed(shape, options);
}

void write_remeshed(const std::filesystem::path& path, const ShapeFile& source, const Mesh& mesh,
                    std::span<const std::uint32_t> face_source, const WriteOptions& options) {
  const std::string format = format_of(path);
  const std::string bytes = serialize_remeshed(format, source, mesh, face_source, options);
  if (format == source.format) return io_detail::write_own_format(path, source, bytes);
  io_detail::write_new_file(path, bytes);
}

std::vector<std::string> remesh_losses(const std::filesystem::path& path, const ShapeFile& source) {
  check_has_faces(source);
  if (format_of(path) != source.format) return conversion_losses(path, source);
  std::vector<std::string> losses = own_format(source).remesh_losses(source);
  for (const std::string& note : source.notes) {
    if (note.find("fewer than three vertices") != std::string::npos) losses.push_back(note);
  }
  return losses;
}

// The material files that an OBJ file names.

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxBytes = 64 << 20;

bool is_plain_name(const std::string& name) {
  const bool ends_well = name.size() > 4 && fs::path(name).extension() == ".mtl";
  return ends_well && name.find_first_of("/\\:") == std::string::npos && name.find('\0') == std::string::npos;
}

// Returns the bytes of a regular file; nothing for a link, which may lead anywhere, and what cannot be read.
std::optional<std::string> material_bytes(const fs::path& path) {
  std::error_code error;
  const bool is_there = fs::is_regular_file(fs::symlink_status(path, error));
  if (!is_there || !(fs::file_size(path, error) <= kMaxBytes) || error) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  return file ? std::optional(std::move(bytes)) : std::nullopt;
}

fs::path folder_of(const fs::path& path) {
  const fs::path parent = path.parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

}  // namespace

std::vector<fs::path> copy_material_files(const ShapeFile& shape, const fs::path& source, const fs::path& target,
                                          std::vector<std::string>* notes) {
  std::vector<fs::path> copied;
  const auto note = [&](const std::string& text) {
    const bool is_new = notes != nullptr && std::find(notes->begin(), notes->end(), text) == notes->end();
    if (is_new) notes->push_back(text);
  };
  const auto* layout = io_detail::find_layout<io_detail::obj::Layout>(shape);
  std::error_code error;
  if (fs::equivalent(folder_of(source), folder_of(target), error)) return copied;
  const bool is_gltf = shape.format == "glb" || shape.format == "gltf";
  for (const std::string& name : is_gltf ? io_detail::gltf::image_files(shape) : std::vector<std::string>{}) {
    const bool is_lacking = fs::exists(folder_of(source) / name, error) && !fs::exists(folder_of(target) / name, error);
    if (is_lacking) note((folder_of(source) / name).string() + ": the texture was not copied; copy it yourself");
  }
  if (layout == nullptr) return copied;
  for (std::string name : layout->material_files) {
    if (name.substr(0, 2) == "./") name.erase(0, 2);
    const fs::path from = folder_of(source) / name;
    const fs::path to = folder_of(target) / name;
    const std::optional<std::string> bytes = is_plain_name(name) ? material_bytes(from) : std::nullopt;
    if (!bytes) {
      if (fs::is_regular_file(from, error)) note(from.string() + ": the materials were not copied; copy them yourself");
      continue;
    }
    if (fs::exists(fs::symlink_status(to, error))) {
      const bool is_copy = std::find(copied.begin(), copied.end(), to) != copied.end();
      if (!is_copy && material_bytes(to) != bytes) note(to.string() + ": is another file of materials, and was kept");
      continue;
    }
    write_file_atomically(to, *bytes);
    copied.push_back(to);
    note(to.string() + ": the materials were copied too" +
         (bytes->find("map_") != bytes->npos ? ", but not their textures" : ""));
  }
  return copied;
}

}  // namespace knead
