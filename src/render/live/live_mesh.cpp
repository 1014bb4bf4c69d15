// LiveMesh: updates the drawn vertices that move, and the boxes of what has changed.
#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include "knead/error.h"
#include "math/geometry.h"
#include "render/live/live.h"
#include "render/surface.h"

namespace knead::render {
namespace {

constexpr std::uint32_t kBlock = 4096;              // vertices
constexpr std::size_t kMaxRuns = 256;               // of drawn vertices to upload
constexpr std::uint32_t kCells = 32;                // along each axis; triangles are sorted by their cells
constexpr std::size_t kRunsAtOnce = 64;             // of triangles, for a thread
constexpr std::size_t kMinParallelVertices = 4096;  // fewer take less time than starting threads

// Runs body(range) over parts of all ranges, on several threads if they are many.
template <class Body>
void for_parts(std::span<const VertexRange> ranges, int threads, Body body) {
  std::size_t total = 0;
  for (const VertexRange& range : ranges) total += range.end - range.begin;
  if (total < kMinParallelVertices) {
    for (const VertexRange& range : ranges) body(range);
    return;
  }
  std::vector<VertexRange> parts;
  for (const VertexRange& range : ranges) {
    for (std::uint32_t begin = range.begin; begin < range.end; begin += kBlock) {
      parts.push_back({begin, std::min(range.end - begin, kBlock) + begin});
    }
  }
  const std::size_t grain = std::max<std::size_t>(1, parts.size() / 64);
  parallel_for(parts.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(parts[i]);
  });
}

// Several threads may set the same mark. libc++ has atomic references from 19 on.
void set_mark(std::uint8_t& mark) {
  if (__atomic_load_n(&mark, __ATOMIC_RELAXED) == 0) __atomic_store_n(&mark, std::uint8_t{1}, __ATOMIC_RELAXED);
}

double volume(const std::vector<LiveVertex>& vertices, const std::vector<std::uint32_t>& triangles) {
  double sum = 0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return Vec3d(vertices[triangles[i + k]].position); };
    sum += dot(corner(0), cross(corner(1), corner(2)));
  }
  return sum / 6;
}

double mean_length(const std::vector<LiveVertex>& vertices, const std::vector<std::uint32_t>& edges) {
  double sum = 0;
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    sum += norm(Vec3d(vertices[edges[i]].position - vertices[edges[i + 1]].position));
  }
  return edges.empty() ? 0 : 2 * sum / static_cast<double>(edges.size());
}

}  // namespace

void extend(Box& box, const Box& other) {
  if (other.empty()) return;
  box.extend(other.min);
  box.extend(other.max);
}

LiveMesh::LiveMesh(const Mesh& mesh, const Placement& placement, double crease_angle)
    : placement_(placement),
      points_(mesh.vertex_count()),
      boxes_((mesh.vertex_count() + kBlock - 1) / kBlock),
      marks_(mesh.vertex_count()) {
  if (mesh.face_count() > 0) {
    const PlacedFaces faces = place_faces(mesh, placement);
    SmoothGroups groups = smooth_groups(mesh, faces, crease_angle);
    rings_ = make_rings(mesh, faces, groups);
    PolygonEdges edges = polygon_edges(mesh, faces, groups);
    edges_ = std::move(edges.list);
    solid_ = edges.closed;
    for (const Triangle& t : corner_triangles(mesh, faces)) {
      for (const std::uint32_t corner : t) triangles_.push_back(groups.corner_vertex[corner]);
    }
    drawn_begin_ = std::move(groups.begin);
  } else {
    for (const Vec3d& p : mesh.positions) drawn_begin_.push_back(drawn_begin_.back() + (is_finite(p) ? 1 : 0));
  }
  vertices_.resize(drawn_begin_.back());
  if (!triangles_.empty()) {
    place(mesh.positions, {0, static_cast<std::uint32_t>(mesh.vertex_count())});
    group_triangles();
    find_runs();
  }
  const VertexRange all{0, static_cast<std::uint32_t>(mesh.vertex_count())};
  move(mesh.positions, {&all, 1}, 0);
  mean_edge_ = mean_length(vertices_, edges_);
  solid_ = solid_ && volume(vertices_, triangles_) > 0;
}

void LiveMesh::place(std::span<const Vec3d> positions, const VertexRange& range) {
  for (std::uint32_t v = range.begin; v < range.end; ++v) points_[v] = Vec3f(placement_.apply(positions[v]));
}

// Finds the boxes of the blocks with a flag.
void LiveMesh::measure(const std::vector<std::uint8_t>& blocks, int threads) {
  std::vector<VertexRange> ranges;
  for (std::uint32_t block = 0; block < blocks.size(); ++block) {
    const auto count = static_cast<std::uint32_t>(points_.size());
    if (blocks[block] != 0) ranges.push_back({block * kBlock, std::min(count, (block + 1) * kBlock)});
  }
  for_parts(ranges, threads, [&](const VertexRange& range) {
    Box box;
    for (std::uint32_t v = range.begin; v < range.end; ++v) {
      const Vec3d p(points_[v]);
      if (is_finite(p)) box.extend(p);
    }
    boxes_[range.begin / kBlock] = box;
  });
}

Box LiveMesh::box() const {
  Box box;
  for (const Box& block : boxes_) extend(box, block);
  return box;
}

void LiveMesh::shade(const VertexRange& range) {
  const VertexRange drawn{drawn_begin_[range.begin], drawn_begin_[range.end]};
  const std::vector<LiveVertex> before(vertices_.begin() + drawn.begin, vertices_.begin() + drawn.end);
  for_each_drawn(range, [&](std::uint32_t v, std::uint32_t d) { vertices_[d].position = points_[v]; });
  if (rings_.list.empty()) return;
  set_ring_normals(rings_, points_, drawn, vertices_);
  for (std::uint32_t d = drawn.begin; d < drawn.end; ++d) {
    const LiveVertex& was = before[d - drawn.begin];
    if (was.position == vertices_[d].position && was.normal == vertices_[d].normal) continue;
    for (std::uint32_t i = run_begin_[d]; i < run_begin_[d + 1]; ++i) set_mark(run_marks_[runs_[i]]);
  }
}

void LiveMesh::mark(const VertexRange& range) {
  for (std::uint32_t v = range.begin; v < range.end; ++v) set_mark(marks_[v]);
  if (rings_.list.empty()) return;
  const std::uint32_t begin = rings_.begin[drawn_begin_[range.begin]];
  const std::uint32_t end = rings_.begin[drawn_begin_[range.end]];
  for (std::uint32_t i = begin; i < end; ++i) {
    if (rings_.list[i] != kNoVertex) set_mark(marks_[rings_.list[i]]);
  }
}

// Returns the runs of marked vertices, with gaps closed until they are few; clears the marks.
std::vector<VertexRange> LiveMesh::marked_runs() {
  std::vector<VertexRange> runs;
  const std::size_t count = marks_.size();
  constexpr std::uint32_t gap = 16;
  for (std::size_t v = 0; v < count;) {
    std::uint64_t eight = 0;
    if (v + 8 <= count) std::memcpy(&eight, marks_.data() + v, 8);
    if (v + 8 <= count && eight == 0) {
      v += 8;
      continue;
    }
    const std::size_t end = std::min(count, v + 8);
    for (; v < end; ++v) {
      if (marks_[v] == 0) continue;
      marks_[v] = 0;
      const auto here = static_cast<std::uint32_t>(v);
      if (!runs.empty() && here < runs.back().end + gap) {
        runs.back().end = here + 1;
      } else {
        runs.push_back({here, here + 1});
      }
    }
  }
  for (std::uint32_t wider = 4 * gap; runs.size() > kMaxRuns; wider *= 4) {
    std::size_t kept = 0;
    for (const VertexRange& run : std::span(runs).subspan(1)) {
      if (run.begin < runs[kept].end + wider) {
        runs[kept].end = run.end;
      } else {
        runs[++kept] = run;
      }
    }
    runs.resize(kept + 1);
  }
  return runs;
}

// Sorts the triangles by the grid cell of their middles. Those of a cell form a run.
void LiveMesh::group_triangles() {
  std::vector<std::uint32_t> vertex_of(drawn_begin_.back());
  for_each_drawn({0, static_cast<std::uint32_t>(points_.size())},
                 [&](std::uint32_t v, std::uint32_t d) { vertex_of[d] = v; });
  const auto cell_of = [&](std::size_t i) {
    Vec3f sum{};
    for (std::size_t k = 0; k < 3; ++k) sum = sum + points_[vertex_of[triangles_[i + k]]];
    constexpr float third = 1.0F / 3;
    constexpr int shift = 63 - 3 * std::bit_width(kCells - 1);
    return static_cast<std::uint32_t>(morton_code({sum.x * third, sum.y * third, sum.z * third}) >> shift);
  };
  std::vector<std::uint32_t> begin(kCells * kCells * kCells + 1, 0);
  for (std::size_t i = 0; i < triangles_.size(); i += 3) begin[cell_of(i) + 1] += 3;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  run_first_ = begin;
  run_first_.erase(std::unique(run_first_.begin(), run_first_.end()), run_first_.end());
  std::vector<std::uint32_t> sorted(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); i += 3) {
    std::uint32_t& to = begin[cell_of(i)];
    for (std::size_t k = 0; k < 3; ++k) sorted[to++] = triangles_[i + k];
  }
  triangles_ = std::move(sorted);
  run_boxes_.resize(run_first_.size() - 1);
  run_marks_.resize(run_boxes_.size());
}

// Finds the runs at every drawn vertex.
void LiveMesh::find_runs() {
  constexpr std::uint32_t none = 0xffffffff;
  // Calls visit(d, run) once for each run at a drawn vertex.
  const auto for_each_run = [&](auto visit) {
    std::vector<std::uint32_t> last(vertices_.size(), none);
    for (std::uint32_t run = 0; run < run_boxes_.size(); ++run) {
      for (const std::uint32_t d : indices_of(run)) {
        if (std::exchange(last[d], run) != run) visit(d, run);
      }
    }
  };
  run_begin_.assign(vertices_.size() + 1, 0);
  for_each_run([&](std::uint32_t d, std::uint32_t) { ++run_begin_[d + 1]; });
  std::partial_sum(run_begin_.begin(), run_begin_.end(), run_begin_.begin());
  runs_.resize(run_begin_.back());
  std::vector<std::uint32_t> next(run_begin_.begin(), run_begin_.end() - 1);
  for_each_run([&](std::uint32_t d, std::uint32_t run) { runs_[next[d]++] = static_cast<std::uint16_t>(run); });
}

std::span<const std::uint32_t> LiveMesh::indices_of(std::uint32_t run) const {
  return std::span(triangles_).subspan(run_first_[run], run_first_[run + 1] - run_first_[run]);
}

// Finds the boxes of the runs with a mark; clears the marks.
void LiveMesh::measure_runs(int threads) {
  std::vector<std::uint32_t> changed;
  for (std::uint32_t run = 0; run < run_marks_.size(); ++run) {
    if (std::exchange(run_marks_[run], std::uint8_t{0}) != 0) changed.push_back(run);
  }
  const auto extend_by_all = [&] {
    for (const std::uint32_t run : changed) extend(changes_, run_boxes_[run]);
  };
  extend_by_all();
  parallel_for(changed.size(), kRunsAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Box box;
      for (const std::uint32_t d : indices_of(changed[i])) {
        const Vec3d p(vertices_[d].position);
        if (is_finite(p)) box.extend(p);
      }
      run_boxes_[changed[i]] = box;
    }
  });
  extend_by_all();
}

std::vector<VertexRange> LiveMesh::move(std::span<const Vec3d> positions, std::span<const VertexRange> changed,
                                        int threads) {
  if (positions.size() != points_.size()) {
    throw InvalidInput("live view: " + std::to_string(positions.size()) + " positions for a shape of " +
                       std::to_string(points_.size()) + " vertices; set the shape anew");
  }
  std::vector<std::uint8_t> stale(boxes_.size(), 0);
  bool everything = false;
  for (const VertexRange& range : changed) {
    if (range.begin > range.end || range.end > points_.size()) {
      throw InvalidInput("live view: a range of vertices ends beyond the shape; give ranges within it");
    }
    if (range.begin == range.end) continue;
    everything = everything || range.end - range.begin == points_.size();
    for (std::uint32_t block = range.begin / kBlock; block <= (range.end - 1) / kBlock; ++block) stale[block] = 1;
  }
  for_parts(changed, threads, [&](const VertexRange& range) { place(positions, range); });
  measure(stale, threads);
  std::vector<VertexRange> runs{{0, static_cast<std::uint32_t>(points_.size())}};
  if (!everything) {
    for_parts(changed, threads, [&](const VertexRange& range) { mark(range); });
    runs = marked_runs();
  }
  for_parts(runs, threads, [&](const VertexRange& range) { shade(range); });
  measure_runs(threads);
  for (VertexRange& run : runs) run = {drawn_begin_[run.begin], drawn_begin_[run.end]};
  std::erase_if(runs, [](const VertexRange& run) { return run.begin == run.end; });
  return runs;
}

}  // namespace knead::render
