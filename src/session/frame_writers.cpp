// Writes the frames of a replay to one file, those of one of several shapes to a file of its own.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "knead/animation.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead {

namespace {

MeshPart part_in(const ShapePart& part, const Mesh& mesh, const Provenance& from) {
  return part.joined.part_of(part.number, mesh, from.face_source, from.vertex_source);
}

// Writes the frames of a shape, or of one part of several. Remeshed ones have the vertices and faces of the first
// frame.
struct Output {
  const ShapeFile& source;
  std::filesystem::path path;
  AnimationOptions options;
  std::optional<ShapePart> part{};
  ShapeFile remeshed{};  // the first frame
  std::optional<AnimationFile> file{};

  void add_remeshed(const Mesh& mesh) {
    if (!file) {
      remeshed = parse_shape(serialize_mesh("ply", mesh, {true, {}, {}}), "ply", path.string());
      file.emplace(path, remeshed, options);
    }
    file->add(mesh.positions);
  }

  void add(const ReplayFrame& frame) {
    const std::vector<Vec3d>& positions = frame.shape.positions();
    if (const Provenance* const from = frame.shape.provenance(); part && from != nullptr) {
      add_remeshed(part_in(*part, frame.shape.to_mesh(), *from).mesh);
    } else if (part) {
      if (!file) file.emplace(path, source, options);
      file->add(part->joined.vertices_of(part->number, std::span(positions)));
    } else if (file) {
      file->add(positions);
    } else {
      add_remeshed(frame.shape.to_mesh());
    }
    if (frame.index + 1 == options.frames) file->finish();
  }
};

}  // namespace

std::function<void(const ReplayFrame&)> animation_writer(const std::filesystem::path& path, const ShapeFile& source,
                                                         bool is_remeshed, const AnimationOptions& options) {
  const auto output = std::make_shared<Output>(Output{source, path, options});
  if (!is_remeshed) output->file.emplace(path, source, options);
  return [output](const ReplayFrame& frame) { output->add(frame); };
}

std::function<void(const ReplayFrame&)> part_animation_writer(const std::filesystem::path& path, const ShapePart& part,
                                                              const AnimationOptions& options) {
  const auto output = std::make_shared<Output>(Output{part.source, path, options, part});
  return [output](const ReplayFrame& frame) { output->add(frame); };
}

void write_part(const std::filesystem::path& path, const ShapePart& part, const ShapeState& state,
                const WriteOptions& options) {
  const bool is_cloud = part.source.mesh.face_count() == 0;
  if (state.provenance != nullptr) {
    const MeshPart found = part_in(part, state.to_mesh(), *state.provenance);
    if (!is_cloud) return write_remeshed(path, part.source, found.mesh, found.face_source, options);
    return write_shape(path, part.source, found.mesh.positions, options);
  }
  const std::vector<Vec3d> positions = state.positions.copy();
  WriteOptions with_normals = options;
  if (is_cloud && !state.normals.empty()) {
    with_normals.normals = part.joined.vertices_of(part.number, std::span<const Vec3d>(state.normals));
  }
  write_shape(path, part.source, part.joined.vertices_of(part.number, std::span<const Vec3d>(positions)), with_normals);
}

}  // namespace knead
