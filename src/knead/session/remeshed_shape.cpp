#include "knead/session/remeshed_shape.h"

#include <algorithm>
#include <numeric>

#include "knead/flow/reach.h"

namespace knead::session_detail {

namespace {

// Ends a remesh whose points could not be carried.
struct Stopped {};

// advect() that leaves progress->done as it was: how many points are carried nobody knows beforehand.
void carry(const Flow& flow, const AdvectOptions& options, std::span<Vec3d> points, AdvectResult& work) {
  const std::uint64_t done = options.progress != nullptr ? options.progress->done.load() : 0;
  work += advect(flow, points, options);
  if (options.progress != nullptr) options.progress->done = done;
  if (work.status != AdvectStatus::done) throw Stopped{};
}

void add(const RemeshCounts& more, RemeshCounts& counts) {
  counts.splits += more.splits;
  counts.collapses += more.collapses;
  counts.flips += more.flips;
  counts.crossings = more.crossings;
  counts.missing_volume += more.missing_volume;
  counts.compensated_volume += more.compensated_volume;
  counts.complete = counts.complete && more.complete;
}

// What the shape knows of its vertices and faces, handed on to those of the remeshed mesh.
void hand_on(const Remeshed& remeshed, RemeshedShape& shape) {
  const std::size_t count = remeshed.vertex_source.size();
  std::vector<std::uint32_t> vertex_source(count, kNewVertex);
  std::vector<std::uint32_t> steps(count);
  std::vector<bool> touched = remeshed.moved;
  shape.renumbered = shape.renumbered || count != shape.vertex_source.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t source = remeshed.vertex_source[i];
    shape.renumbered = shape.renumbered || source != i;
    if (source == kNewVertex) {
      touched[i] = true;
      continue;
    }
    vertex_source[i] = shape.vertex_source[source];
    steps[i] = shape.steps[source];
    if (shape.touched[source] || remeshed.mesh.positions[i] != shape.mesh.positions[source]) touched[i] = true;
  }
  std::vector<std::uint32_t> face_source(remeshed.face_source.size());
  std::transform(remeshed.face_source.begin(), remeshed.face_source.end(), face_source.begin(),
                 [&](std::uint32_t face) { return shape.face_source[face]; });
  shape.vertex_source = std::move(vertex_source);
  shape.face_source = std::move(face_source);
  shape.touched = std::move(touched);
  shape.steps = std::move(steps);
  shape.creases = remeshed.creases;
  add(remeshed.counts, shape.counts);
}

// The labels of the faces as they are, from those of the faces at the beginning.
std::vector<std::uint32_t> labels_of(const RemeshedShape& shape, std::span<const std::uint32_t> at_beginning) {
  std::vector<std::uint32_t> labels;
  if (at_beginning.empty()) return labels;
  labels.reserve(shape.face_source.size());
  for (const std::uint32_t face : shape.face_source) labels.push_back(at_beginning[face]);
  return labels;
}

}  // namespace

RemeshedShape unmoved(const Mesh& mesh) {
  RemeshedShape shape;
  shape.mesh = mesh;
  shape.face_source.resize(mesh.face_count());
  std::iota(shape.face_source.begin(), shape.face_source.end(), 0U);
  shape.vertex_source.resize(mesh.vertex_count());
  std::iota(shape.vertex_source.begin(), shape.vertex_source.end(), 0U);
  shape.touched.resize(mesh.vertex_count());
  shape.steps.resize(mesh.vertex_count());
  return shape;
}

std::optional<Remeshed> move_and_remesh(const Flow& flow, const AdvectOptions& move,
                                        const std::optional<RemeshOptions>& remesh_options, RemeshedShape& shape) {
  if (flow.segments.empty()) return std::nullopt;
  std::vector<Vec3d> after = shape.mesh.positions;
  AdvectOptions counted = move;
  counted.steps = shape.steps;
  shape.work += advect(flow, after, counted);
  if (shape.work.status != AdvectStatus::done) return std::nullopt;
  if (!remesh_options) {
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (after[i] != shape.mesh.positions[i]) shape.touched[i] = true;
    }
    shape.mesh.positions = std::move(after);
    return std::nullopt;
  }
  const FlowReach reach(flow);
  Deformation deformation;
  deformation.carry = [&](std::span<Vec3d> points) { carry(flow, move, points, shape.work); };
  deformation.may_move = [&](const Vec3d& center, double radius) { return reach.may_move(center, radius); };
  RemeshOptions here = *remesh_options;
  const std::vector<std::uint32_t> labels = labels_of(shape, here.face_labels);
  here.face_labels = labels;
  if (!shape.creases) shape.creases = find_creases(shape.mesh);
  here.creases = *shape.creases;
  deformation.feature = reach.smallest_feature();
  try {
    Remeshed result = remesh(shape.mesh, after, deformation, here);
    hand_on(result, shape);
    shape.mesh = std::move(result.mesh);
    return result;
  } catch (const Stopped&) {
    return std::nullopt;
  }
}

}  // namespace knead::session_detail
