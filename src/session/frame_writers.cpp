// Writes the shapes that a replay makes: one, one of several, or all frames in one file.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "io/mesh_builder.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead {

namespace {

MeshPart part_in(const ShapePart& part, const Mesh& mesh, const Provenance& from) {
  return part.joined.part_of(part.number, mesh, from.face_source, from.vertex_source);
}

// What a deformation changes of points besides their places.
struct PointNumbers {
  std::vector<Vec3d> normals{};
  ChangedSplats splats{};

  // Valid as long as this.
  WriteOptions with(WriteOptions options) const {
    if (!normals.empty()) options.normals = normals;
    options.attributes = splats.attributes;
    options.changed = splats.splats;
    return options;
  }
};

ChangedSplats changed(const ShapeFile& source, const SplatJacobians& splats, int threads = 0) {
  return have_splats(source.mesh) ? deformed_splats(source.mesh, splats, threads) : ChangedSplats{};
}

PointNumbers numbers_of(const ShapeFile& source, const DeformedShape& shape) {
  PointNumbers numbers{shape.normals(), {}};
  if (shape.splats()) numbers.splats = changed(source, *shape.splats(), shape.motion().threads);
  return numbers;
}

// Returns the splats of one part, by their numbers in it.
SplatJacobians splats_in(const ShapePart& part, const SplatJacobians& all) {
  const std::span<const Vec3d> whole = part.joined.mesh().positions;
  const std::span<const Vec3d> own = part.joined.vertices_of(part.number, whole);
  const auto begin = static_cast<std::uint32_t>(own.data() - whole.data());
  SplatJacobians result;
  for (std::size_t k = 0; k < all.splats.size(); ++k) {
    if (all.splats[k] < begin || all.splats[k] >= begin + own.size()) continue;
    result.splats.push_back(all.splats[k] - begin);
    result.jacobians.push_back(all.jacobians[k]);
  }
  return result;
}

// Sets the splats of a remeshed mesh: its vertices in no face are those of the source, in the same order.
void put_splats(Mesh& mesh, ChangedSplats splats, const Mesh& source) {
  const std::vector<std::uint32_t> before = detail::vertices_in_no_face(source);
  const std::vector<std::uint32_t> now = detail::vertices_in_no_face(mesh);
  if (before.size() != now.size()) return;
  for (std::uint32_t& splat : splats.splats) {
    splat = now[static_cast<std::size_t>(std::lower_bound(before.begin(), before.end(), splat) - before.begin())];
  }
  detail::put_values(mesh, splats.attributes, splats.splats);
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
      remeshed = parse_shape(serialize_mesh("ply", mesh, {.double_coordinates = true}), "ply", path.string());
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

std::vector<IndexRange> splats_among(std::span<const Mesh* const> meshes) {
  std::vector<IndexRange> ranges;
  std::uint32_t begin = 0;
  for (const Mesh* mesh : meshes) {
    if (have_splats(*mesh)) {
      splat_degree(*mesh);
      for (const std::uint32_t v : detail::vertices_in_no_face(*mesh)) {
        const bool goes_on = !ranges.empty() && ranges.back().end == begin + v;
        if (!goes_on) ranges.push_back({begin + v, begin + v});
        ++ranges.back().end;
      }
    }
    begin += static_cast<std::uint32_t>(mesh->vertex_count());
  }
  return ranges;
}

void write_deformed(const std::filesystem::path& path, const ShapeFile& source, const DeformedShape& shape,
                    const WriteOptions& options) {
  if (shape.is_remeshed()) {
    return write_remeshed(path, source, shape.to_mesh(), shape.provenance()->face_source, options);
  }
  const PointNumbers numbers = numbers_of(source, shape);
  write_shape(path, source, shape.positions(), numbers.with(options));
}

std::string serialize_deformed(std::string_view format, const ShapeFile& source, const DeformedShape& shape,
                               const WriteOptions& options) {
  if (shape.is_remeshed()) {
    return serialize_remeshed(format, source, shape.to_mesh(), shape.provenance()->face_source, options);
  }
  const PointNumbers numbers = numbers_of(source, shape);
  return serialize_shape(format, source, shape.positions(), numbers.with(options));
}

void write_part(const std::filesystem::path& path, const ShapePart& part, const ShapeState& state,
                const WriteOptions& options) {
  const bool is_cloud = part.source.mesh.face_count() == 0;
  PointNumbers numbers;
  if (state.splats) numbers.splats = changed(part.source, splats_in(part, *state.splats));
  if (state.provenance != nullptr) {
    MeshPart found = part_in(part, state.to_mesh(), *state.provenance);
    if (!is_cloud) {
      if (state.splats) put_splats(found.mesh, numbers.splats, part.source.mesh);
      return write_remeshed(path, part.source, found.mesh, found.face_source, options);
    }
    return write_shape(path, part.source, found.mesh.positions, numbers.with(options));
  }
  const std::vector<Vec3d> positions = state.positions.copy();
  if (is_cloud && !state.normals.empty()) {
    const std::span<const Vec3d> normals = part.joined.vertices_of(part.number, std::span<const Vec3d>(state.normals));
    numbers.normals.assign(normals.begin(), normals.end());
  }
  write_shape(path, part.source, part.joined.vertices_of(part.number, std::span<const Vec3d>(positions)),
              numbers.with(options));
}

}  // namespace knead
