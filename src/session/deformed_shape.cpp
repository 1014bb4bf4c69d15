// A shape that strokes deform: its state, its moves, its normals, and relaxing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "io/mesh_builder.h"
#include "knead/editor/shape_state.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/system.h"
#include "remesh/relax.h"
#include "session/deformed_shape_detail.h"
#include "session/point_constraint.h"

namespace knead {

namespace detail {

// For the faces and creases from which it was made.
struct RelaxMesh {
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const Provenance> provenance;
  WeldedMesh welded;
  detail::RelaxTopology topology;
};

}  // namespace detail

namespace {

using namespace detail;

// Of the diagonal: the error of the path lines around a point with a normal, and the distance at which they begin. The
// direction of a normal then has an error of about 1e-5 by rounding, and a smaller one by the curvature of the flow.
constexpr double kNormalTolerance = 1e-9;
constexpr double kNormalOffset = 1e-4;

// Squares of lengths beyond these limits overflow or vanish in single precision. Of all tools paint fails first: not
// yet on shapes of 3e-17, on shapes of 1e-18 it does.
constexpr double kLargestShape = 1e18;
constexpr double kSmallestShape = 1e-15;

constexpr double kMinConstrainedPart = 1.0 / 64;  // of a segment

// With fewer segments, sorting the vertices takes longer than it saves.
constexpr std::size_t kSegmentsWorthSorting = 4;

std::shared_ptr<const Mesh> checked(std::shared_ptr<const Mesh> mesh) {
  validate(*mesh);
  return mesh;
}

constexpr std::size_t kChunksAtOnce = 16;

// Compares bits: 0 and -0 differ.
bool are_same(const Vec3d* a, const Vec3d* b, std::size_t count) {
  return std::memcmp(static_cast<const void*>(a), static_cast<const void*>(b), count * sizeof(Vec3d)) == 0;
}

// Places four points around every point whose normal has a direction; as many normals as positions. `offset`: a length
// above 0. The error of a turned normal falls with its square until rounding takes over.
TransportedNormals carry_normals(std::span<const Vec3d> positions, std::vector<Vec3d> normals, double offset) {
  TransportedNormals carried;
  carried.offset = offset;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!has_direction(normals[i])) continue;
    const Vec3d n = normalized(normals[i]);
    const Vec3d a = any_orthogonal(n) * offset;
    const Vec3d b = cross(n, a);
    const Vec3d& p = positions[i];
    carried.vertex.push_back(static_cast<std::uint32_t>(i));
    carried.begin.insert(carried.begin.end(), {p + a, p - a, p + b, p - b});
  }
  carried.now = carried.begin;
  carried.normals = std::move(normals);
  return carried;
}

// Returns the normal of the k-th vertex with points, from their present places; its length does not change. It keeps
// its bits if the points did not move, or were torn apart (at the wall of a limit cylinder).
Vec3d turned(const TransportedNormals& carried, std::size_t k) {
  constexpr double torn = 1e3;  // times their distance before: no flow of a tool stretches more at this scale
  const Vec3d& normal = carried.normals[carried.vertex[k]];
  const std::span<const Vec3d> now = std::span(carried.now).subspan(4 * k, 4);
  if (std::equal(now.begin(), now.end(), carried.begin.begin() + static_cast<std::ptrdiff_t>(4 * k))) return normal;
  const Vec3d a = (now[0] - now[1]) / (2 * carried.offset);
  const Vec3d b = (now[2] - now[3]) / (2 * carried.offset);
  const Vec3d n = cross(a, b);
  if (!(norm(n) > 0) || norm(a) > torn || norm(b) > torn) return normal;
  return n * (norm(normal) / norm(n));
}

std::vector<Vec3d> turned_normals(const TransportedNormals& carried) {
  std::vector<Vec3d> result = carried.normals;
  for (std::size_t k = 0; k < carried.vertex.size(); ++k) result[carried.vertex[k]] = turned(carried, k);
  return result;
}

Vec3d turned_normal(const TransportedNormals& carried, std::uint32_t vertex) {
  const auto found = std::lower_bound(carried.vertex.begin(), carried.vertex.end(), vertex);
  if (found == carried.vertex.end() || *found != vertex) return carried.normals[vertex];
  return turned(carried, static_cast<std::size_t>(found - carried.vertex.begin()));
}

// Returns a flag for each vertex that the mask holds; empty without a mask.
detail::RelaxTopology masked_topology(const Mask& mask, const detail::RelaxTopology& topology,
                                      std::span<const Vec3d> positions) {
  if (mask.is_empty()) return {};
  detail::RelaxTopology result = topology;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (mask.holds(positions[v])) result.freedom[v] = detail::RelaxTopology::Freedom::stays;
  }
  return result;
}

// Of a shape with that box, which has points in all of `whole`.
double reference_length(const Box& whole, const Box& box) {
  if (box.empty()) return 1;
  double farthest = 0;
  double extent = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    farthest = std::max({farthest, std::abs(whole.min[axis]), std::abs(whole.max[axis])});
    extent = std::max(extent, box.max[axis] - box.min[axis]);
  }
  if (!(farthest <= kLargestShape)) {
    throw InvalidInput(
        fmt::format("the shape has coordinates of up to {:.3g}, too large to compute with; scale it so that none is "
                    "above {:g}",
                    farthest, kLargestShape));
  }
  if (extent > 0 && extent < kSmallestShape) {
    throw InvalidInput(fmt::format(
        "the shape is only {:.3g} long, too small to compute with; scale it to at least {:g}", extent, kSmallestShape));
  }
  return extent > 0 ? box.diagonal() : 1;
}

}  // namespace

bool detail::has_direction(const Vec3d& normal) {
  const double length = norm(normal);
  return length > 0 && std::isfinite(length);
}

bool MotionOptions::is_standard() const {
  const MotionOptions standard;
  return relative_tolerance == standard.relative_tolerance && !diagonal && integrator == standard.integrator &&
         precision == standard.precision && !backend;
}

double reference_length(const Mesh& mesh) { return reference_length(bounding_box(mesh.positions), shape_box(mesh)); }

double reference_length(std::span<const Vec3d> positions) {
  CloudBox cloud;
  cloud.add(positions);
  return reference_length(cloud.whole(), cloud.box());
}

AdvectOptions advect_options(const MotionOptions& options, double reference_length) {
  if (options.threads < 0) {
    throw InvalidInput(fmt::format("the number of threads must be 0 (all) or more, got {}", options.threads));
  }
  AdvectOptions result;
  result.tolerance = absolute_tolerance(options.relative_tolerance, reference_length);
  result.integrator = options.integrator;
  result.precision = options.precision;
  result.threads = options.threads;
  return result;
}

std::shared_ptr<const Mesh> borrow(const Mesh& mesh) { return {std::shared_ptr<const Mesh>(), &mesh}; }

Mesh ShapeState::to_mesh() const {
  Mesh result = *mesh;
  positions.copy_to(result.positions);
  return result;
}

bool ShapeState::is_same(const ShapeState& other) const {
  return mesh == other.mesh && provenance == other.provenance && mask.shares(other.mask) && splats == other.splats &&
         positions.size() == other.positions.size() && positions.changes_since(other.positions).empty();
}

std::size_t ShapeState::splat_bytes() const {
  return splats == nullptr ? 0 : splats->splats.capacity() * (sizeof(std::uint32_t) + sizeof(Mat3d));
}

Snapshot::Snapshot(std::span<const Vec3d> positions, const Snapshot& before, int threads)
    : size_(positions.size()), chunks_((positions.size() + kChunk - 1) / kChunk) {
  const bool may_share = before.size_ == size_;
  parallel_for(chunks_.size(), kChunksAtOnce, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t count = std::min(kChunk, size_ - i * kChunk);
      const Vec3d* const from = positions.data() + i * kChunk;
      if (may_share && are_same(before.chunks_[i]->data(), from, count)) {
        chunks_[i] = before.chunks_[i];
        continue;
      }
      auto chunk = std::make_shared<Chunk>();
      std::copy(from, from + count, chunk->begin());
      chunks_[i] = std::move(chunk);
    }
  });
}

void Snapshot::copy_to(std::span<Vec3d> positions) const {
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const std::size_t count = std::min(kChunk, size_ - i * kChunk);
    std::copy_n(chunks_[i]->begin(), count, positions.begin() + static_cast<std::ptrdiff_t>(i * kChunk));
  }
}

std::vector<Vec3d> Snapshot::copy() const {
  std::vector<Vec3d> positions(size_);
  copy_to(positions);
  return positions;
}

std::vector<IndexRange> Snapshot::changes_since(const Snapshot& before) const {
  std::vector<IndexRange> ranges;
  const bool comparable = before.size_ == size_;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (comparable && chunks_[i] == before.chunks_[i]) continue;
    const auto begin = static_cast<std::uint32_t>(i * kChunk);
    const auto end = static_cast<std::uint32_t>(std::min((i + 1) * kChunk, size_));
    if (!ranges.empty() && ranges.back().end == begin) {
      ranges.back().end = end;
    } else {
      ranges.push_back({begin, end});
    }
  }
  return ranges;
}

DeformedShape::DeformedShape(std::shared_ptr<const Mesh> mesh, MotionOptions motion, RemeshPolicy remesh,
                             std::vector<Vec3d> normals)
    : start_(checked(std::move(mesh))),
      mesh_(start_),
      motion_(std::move(motion)),
      policy_(std::make_shared<const RemeshPolicy>(std::move(remesh))),
      reference_length_(motion_.diagonal.value_or(knead::reference_length(*start_))) {
  advect_options(motion_, reference_length_);
  if (policy_->settings) validate(*policy_->settings);
  if (!policy_->face_labels.empty() && policy_->face_labels.size() != start_->face_count()) {
    throw InvalidInput("give a label for each face");
  }
  if (!normals.empty() && normals.size() != start_->vertex_count()) {
    throw InvalidInput("give a normal for each vertex");
  }
  reserve_large(positions_, start_->vertex_count());
  positions_ = start_->positions;
  start_normals(std::move(normals));
}

void DeformedShape::start_normals(std::vector<Vec3d> normals) {
  normals_.reset();
  if (normals.empty()) return;
  normals_ = carry_normals(positions_, std::move(normals), kNormalOffset * reference_length_);
}

std::vector<Vec3d> DeformedShape::normals() const {
  return normals_ ? turned_normals(*normals_) : std::vector<Vec3d>{};
}

Vec3d DeformedShape::normal(std::uint32_t vertex) const { return turned_normal(*normals_, vertex); }

Mesh DeformedShape::to_mesh() const {
  Mesh result = *mesh_;
  result.positions = positions_;
  if (!splats_ || !have_splats(result)) return result;
  std::vector<std::uint32_t> now(start_->vertex_count());  // of each vertex at the start
  for (std::uint32_t v = 0; v < positions_.size(); ++v) {
    const std::uint32_t source = provenance_ ? provenance_->vertex_source[v] : v;
    if (source < now.size()) now[source] = v;
  }
  ChangedSplats changed = deformed_splats(*start_, *splats_, motion_.threads);
  for (std::uint32_t& splat : changed.splats) splat = now[splat];
  detail::put_values(result, changed.attributes, changed.splats);
  return result;
}

std::span<const Triangle> DeformedShape::triangles() const {
  if (!triangles_) triangles_ = std::make_shared<const std::vector<Triangle>>(triangulate(WeldedMesh(*mesh_).mesh()));
  return *triangles_;
}

std::vector<bool> DeformedShape::touched() const {
  std::vector<bool> touched = provenance_ ? provenance_->touched : std::vector<bool>(positions_.size());
  for (std::size_t i = 0; i < touched.size(); ++i) {
    if (positions_[i] != mesh_->positions[i]) touched[i] = true;
  }
  return touched;
}

std::vector<std::uint32_t> DeformedShape::steps() const {
  std::vector<std::uint32_t> steps = blocks_ ? blocks_->steps() : std::vector<std::uint32_t>{};
  steps.resize(positions_.size());
  for (std::size_t i = 0; i < earlier_steps_.size(); ++i) steps[i] += earlier_steps_[i];
  return steps;
}

AdvectStatus DeformedShape::move(const Flow& flow, Progress* progress) {
  if (flow.segments.empty()) return AdvectStatus::done;
  AdvectOptions options = advect_options(motion_, reference_length_);
  options.progress = progress;
  detail::MovedSplats splats;
  try {
    if (splats_ && !are_splats_held_) splats = moved_splats(flow, options);
  } catch (const Cancelled&) {
    return AdvectStatus::cancelled;
  }
  AdvectResult result = constraint_ ? move_constrained(flow, options) : move_vertices(flow, options);
  if (result.status == AdvectStatus::done) put(splats);
  if (result.status == AdvectStatus::done && normals_ && !normals_->vertex.empty()) {
    options.tolerance = kNormalTolerance * reference_length_;
    options.integrator = Integrator::tsitouras;
    options.precision = Precision::float64;
    if (!normals_->blocks) normals_->blocks.emplace(normals_->now);
    result.status = advect(flow, *normals_->blocks, normals_->now, options).status;
    normals_->blocks->update(normals_->now);
  }
  work_ += result;
  return std::exchange(work_.status, AdvectStatus::done);
}

// Moves the points in parts that are so short that the corrections are small.
AdvectResult DeformedShape::move_constrained(const Flow& flow, const AdvectOptions& options) {
  AdvectResult all;
  const auto put_on_planes = [&] {
    const double distance = constraint_->put_on_planes(positions_);
    if (!(distance > 0)) return;
    put_back_ = std::max(put_back_, distance);
    free_layout();
  };
  if (constraint_->is_flow()) {
    all = move_vertices(flow, options);
    put_on_planes();
    return all;
  }
  double size = 1;  // of a part, in segments
  for (std::size_t segment = 0; segment < flow.segments.size(); ++segment, size = std::min(1.0, 2 * size)) {
    for (double at = 0; at < 1;) {
      const std::vector<Vec3d> before = positions_;
      const double from = static_cast<double>(segment) + at;
      all += move_vertices(flow_between(flow, from, from + size), options);
      if (all.status != AdvectStatus::done) return all;
      free_layout();
      segments_ = 0;  // the next part needs other blocks, and for one part they are not worth sorting
      const PointCorrection correction = constraint_->put_back(before, positions_, motion_.threads);
      if (correction.is_small || size <= kMinConstrainedPart) {
        put_back_ = std::max(put_back_, correction.greatest);
        at += size;
      } else {
        positions_ = before;
        size /= 2;
      }
    }
  }
  put_on_planes();
  return all;
}

// A backend does not know the blocks, which would be out of date after it.
AdvectResult DeformedShape::move_vertices(const Flow& flow, const AdvectOptions& options) {
  if (!motion_.backend) {
    segments_ += flow.segments.size();
    lay_out(segments_ >= kSegmentsWorthSorting);
    const AdvectResult result = advect(flow, *blocks_, positions_, options);
    blocks_->update(positions_);
    return result;
  }
  earlier_steps_ = steps();
  blocks_.reset();
  AdvectOptions counted = options;
  counted.steps = earlier_steps_;
  return motion_.backend(flow, positions_, counted);
}

void DeformedShape::take(const std::vector<bool>& vertices, const DeformedShape& from) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i]) positions_[i] = from.positions_[i];
  }
  if (normals_) {
    for (std::size_t i = 0; i < normals_->now.size(); ++i) {
      if (vertices[normals_->vertex[i / 4]]) normals_->now[i] = from.normals_->now[i];
    }
    normals_->blocks.reset();
  }
  if (splats_) take_splats(vertices, from);
  work_ = from.work_;
  earlier_steps_ = from.steps();
  blocks_.reset();
}

void DeformedShape::set_positions(std::vector<Vec3d> positions) {
  free_layout();
  positions_ = std::move(positions);
}

ShapeState DeformedShape::state(const ShapeState& before) const {
  return {mesh_, Snapshot(positions_, before.positions, motion_.threads), normals(), provenance_, mask_, splats_};
}

void DeformedShape::restore(const ShapeState& state) {
  if (mesh_ != state.mesh) triangles_.reset();
  mesh_ = state.mesh;
  provenance_ = state.provenance;
  mask_ = state.mask;
  splats_ = state.splats;
  positions_ = state.positions.copy();
  start_normals(state.normals);
  blocks_.reset();
  segments_ = 0;
  earlier_steps_.clear();
}

void DeformedShape::prepare() { lay_out(true); }

void DeformedShape::free_layout() {
  if (!blocks_) return;
  earlier_steps_ = steps();
  blocks_.reset();
}

void DeformedShape::lay_out(bool sorted) {
  if (blocks_ && (is_sorted_ || !sorted)) return;
  free_layout();
  blocks_.emplace(positions_, sorted ? PointBlocks::Order::sorted : PointBlocks::Order::given);
  is_sorted_ = sorted;
}

// The creases are those that remeshing keeps: of the shape before any deformation.
const detail::RelaxMesh& DeformedShape::relax_mesh() const {
  if (relax_mesh_ && relax_mesh_->mesh == mesh_ && relax_mesh_->provenance == provenance_) return *relax_mesh_;
  const bool has_creases = provenance_ && provenance_->creases;
  std::vector<MeshEdge> creases = has_creases ? *provenance_->creases : find_creases(WeldedMesh(*start_).mesh());
  WeldedMesh welded(*mesh_);
  for (MeshEdge& crease : creases) crease = {welded.first(crease[0]), welded.first(crease[1])};
  detail::RelaxTopology topology = detail::relax_topology(triangles(), positions_.size(), creases);
  relax_mesh_ = std::make_shared<const detail::RelaxMesh>(
      detail::RelaxMesh{mesh_, provenance_, std::move(welded), std::move(topology)});
  return *relax_mesh_;
}

AdvectStatus DeformedShape::relax(const RelaxStroke& stroke, double from, double to, Progress* progress) {
  if (mesh_->face_count() == 0) throw InvalidInput("a point cloud has no surface to relax; remove this line");
  if (from >= to) return AdvectStatus::done;
  free_layout();
  const detail::RelaxTopology masked = masked_topology(mask_, relax_mesh().topology, positions_);
  detail::Relaxer relaxer(mask_.is_empty() ? relax_mesh().topology : masked, triangles(), positions_,
                          policy_->single_precision, motion_.threads);
  for (double i = std::floor(from); i < to; ++i) {
    if (progress != nullptr && progress->cancel) return AdvectStatus::cancelled;
    const double part = std::min(1.0, to - i);
    relaxer.apply({stroke.points[static_cast<std::size_t>(i)], stroke.radius, part * stroke.amount, stroke.surface,
                   stroke.iterations});
    ++dabs_;
  }
  relax_mesh().welded.share(positions_);
  return AdvectStatus::done;
}

}  // namespace knead
