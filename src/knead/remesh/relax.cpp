#include "knead/remesh/relax.h"

#include <algorithm>
#include <iterator>

#include "knead/math/parallel.h"
#include "knead/mesh/self_intersections.h"
#include "knead/remesh/relax_patch.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

namespace {

constexpr std::size_t kChunk = 512;  // triangles with a common box
constexpr std::size_t kChunksAtOnce = 32;
constexpr int kMostAttempts = 5;

using Pair = std::array<std::uint32_t, 2>;

Vec3d as_float(const Vec3d& p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

bool overlap(const Box& a, const Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.min[axis] > b.max[axis] || b.min[axis] > a.max[axis]) return false;
  }
  return true;
}

void extend(Box& box, const Box& by) {
  box.extend(by.min);
  box.extend(by.max);
}

double weight_at(double distance2, double radius) {
  const double rest = 1 - distance2 / (radius * radius);
  return rest * rest;
}

}  // namespace

// The patch of one dab, with the numbers that its vertices and triangles have in the mesh, and the triangles around
// that it might cross.
class Relaxer::Patch {
 public:
  Patch(Relaxer& relaxer, const RelaxDab& dab) : relaxer_(relaxer), vertices_(relaxer.vertices_within(dab)) {
    for (const std::uint32_t v : vertices_) {
      patch_.weight.push_back(weight_at(norm2(relaxer.positions_[v] - dab.center), dab.radius));
    }
    take_triangles();
    take_creases();
    start_ = patch_.positions;
  }
  ~Patch() {
    for (const std::uint32_t v : vertices_) relaxer_.number_[v] = kNone;
    for (const std::uint32_t t : triangles_) relaxer_.triangle_number_[t] = kNone;
  }
  Patch(const Patch&) = delete;
  Patch& operator=(const Patch&) = delete;

  void run(const RelaxDab& dab) {
    if (patch_.moving() == 0) return;
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
      patch_.positions.assign(start_.begin(), start_.end());
      for (int i = 0; i < dab.iterations; ++i) relax_once(patch_, dab.amount, dab.surface, relaxer_.threads_);
      const std::vector<Pair> crossings = new_crossings();
      if (crossings.empty()) return write();
      for (const Pair& pair : crossings) {
        for (const std::uint32_t t : pair) hold(t, attempt > 0);
      }
    }
  }

 private:
  std::uint32_t number(std::uint32_t v) {
    if (relaxer_.number_[v] == kNone) {
      relaxer_.number_[v] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(v);
    }
    return relaxer_.number_[v];
  }

  void take_triangles() {
    const std::size_t moving = vertices_.size();
    for (std::uint32_t i = 0; i < moving; ++i) relaxer_.number_[vertices_[i]] = i;
    for (std::size_t i = 0; i < moving; ++i) {
      patch_.begin.push_back(static_cast<std::uint32_t>(patch_.corners.size()));
      for (const std::uint32_t corner : relaxer_.topology_.corners_of(vertices_[i])) {
        const std::uint32_t t = corner / 3;
        if (relaxer_.triangle_number_[t] == kNone) {
          relaxer_.triangle_number_[t] = static_cast<std::uint32_t>(triangles_.size());
          triangles_.push_back(t);
        }
        patch_.corners.push_back(3 * relaxer_.triangle_number_[t] + corner % 3);
      }
    }
    patch_.begin.push_back(static_cast<std::uint32_t>(patch_.corners.size()));
    own_ = triangles_.size();
    for (const std::uint32_t t : triangles_) patch_.triangles.push_back(numbered(t));
    for (const std::uint32_t v : vertices_) patch_.positions.push_back(relaxer_.positions_[v]);
  }

  Triangle numbered(std::uint32_t t) {
    const Triangle& triangle = relaxer_.triangles_[t];
    return {number(triangle[0]), number(triangle[1]), number(triangle[2])};
  }

  void take_creases() {
    patch_.crease.assign(patch_.moving(), {kNone, kNone});
    const std::vector<RelaxTopology::OnCrease>& all = relaxer_.topology_.on_crease;
    for (std::size_t i = 0; i < patch_.moving(); ++i) {
      if (relaxer_.topology_.freedom[vertices_[i]] != RelaxTopology::Freedom::on_crease) continue;
      const auto on = std::lower_bound(all.begin(), all.end(), vertices_[i],
                                       [](const auto& a, std::uint32_t v) { return a.vertex < v; });
      patch_.crease[i] = {number(on->neighbours[0]), number(on->neighbours[1])};
    }
    for (std::size_t i = patch_.positions.size(); i < vertices_.size(); ++i) {
      patch_.positions.push_back(relaxer_.positions_[vertices_[i]]);
    }
  }

  // Takes in the triangles around, when the first search begins.
  void take_surroundings(const Box& box) {
    if (all_.empty()) all_ = patch_.triangles;
    for (const std::uint32_t t : relaxer_.triangles_in(box)) {
      if (relaxer_.triangle_number_[t] != kNone) continue;
      relaxer_.triangle_number_[t] = static_cast<std::uint32_t>(triangles_.size());
      triangles_.push_back(t);
      all_.push_back(numbered(t));
    }
  }

  // The pairs that cross with the positions of the patch, at least one of its triangles in each.
  std::vector<Pair> crossings(const std::vector<Vec3d>& positions) const {
    std::vector<Vec3d> x = positions;
    for (std::size_t i = x.size(); i < vertices_.size(); ++i) x.push_back(relaxer_.positions_[vertices_[i]]);
    if (relaxer_.single_precision_) std::transform(x.begin(), x.end(), x.begin(), as_float);
    SelfIntersections found = self_intersections(all_, x, {.threads = relaxer_.threads_});
    std::erase_if(found.pairs, [&](const Pair& pair) { return pair[0] >= own_; });
    return std::move(found.pairs);
  }

  std::vector<Pair> new_crossings() {
    Box box = bounding_box(start_);
    extend(box, bounding_box(patch_.positions));
    take_surroundings(box);
    const std::vector<Pair> now = crossings(patch_.positions);
    if (now.empty()) return {};
    const std::vector<Pair> before = crossings(start_);
    std::vector<Pair> result;
    std::set_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(result));
    return result;
  }

  // Lets the corners of a triangle rest, and on demand the vertices around them.
  void hold(std::uint32_t t, bool neighbours) {
    for (const std::uint32_t v : all_[t]) {
      if (v >= patch_.moving()) continue;
      patch_.weight[v] = 0;
      for (std::uint32_t i = patch_.begin[v]; neighbours && i < patch_.begin[v + 1]; ++i) {
        for (const std::uint32_t w : patch_.triangles[patch_.corners[i] / 3]) {
          if (w < patch_.moving()) patch_.weight[w] = 0;
        }
      }
    }
  }

  void write() {
    for (std::size_t i = 0; i < patch_.moving(); ++i) relaxer_.positions_[vertices_[i]] = patch_.positions[i];
    std::vector<std::size_t> chunks;
    for (std::size_t t = 0; t < own_; ++t) chunks.push_back(triangles_[t] / kChunk);
    std::sort(chunks.begin(), chunks.end());
    chunks.erase(std::unique(chunks.begin(), chunks.end()), chunks.end());
    for (const std::size_t chunk : chunks) relaxer_.boxes_[chunk] = relaxer_.chunk_box(chunk);
  }

  Relaxer& relaxer_;
  std::vector<std::uint32_t> vertices_;   // those that may move, those of their triangles, then those around
  std::vector<std::uint32_t> triangles_;  // own_ of the patch, then those around
  std::size_t own_ = 0;
  RelaxPatch patch_;
  std::vector<Vec3d> start_;
  std::vector<Triangle> all_;  // triangles_, by the numbers in vertices_
};

Relaxer::Relaxer(const RelaxTopology& topology, std::span<const Triangle> triangles, std::span<Vec3d> positions,
                 bool single_precision, int threads)
    : topology_(topology),
      triangles_(triangles),
      positions_(positions),
      single_precision_(single_precision),
      threads_(threads),
      boxes_((triangles.size() + kChunk - 1) / kChunk),
      number_(positions.size(), kNone),
      triangle_number_(triangles.size(), kNone) {
  parallel_for(boxes_.size(), kChunksAtOnce, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t chunk = begin; chunk < end; ++chunk) boxes_[chunk] = chunk_box(chunk);
  });
}

Box Relaxer::chunk_box(std::size_t chunk) const {
  Box box;
  for (std::size_t t = chunk * kChunk; t < std::min(triangles_.size(), (chunk + 1) * kChunk); ++t) {
    for (const std::uint32_t v : triangles_[t]) box.extend(positions_[v]);
  }
  return box;
}

std::vector<std::uint32_t> Relaxer::triangles_in(const Box& box) const {
  std::vector<std::uint32_t> found;
  for (std::size_t chunk = 0; chunk < boxes_.size(); ++chunk) {
    if (!overlap(boxes_[chunk], box)) continue;
    for (std::size_t t = chunk * kChunk; t < std::min(triangles_.size(), (chunk + 1) * kChunk); ++t) {
      Box own;
      for (const std::uint32_t v : triangles_[t]) own.extend(positions_[v]);
      if (overlap(own, box)) found.push_back(static_cast<std::uint32_t>(t));
    }
  }
  return found;
}

std::vector<std::uint32_t> Relaxer::vertices_within(const RelaxDab& dab) const {
  const Vec3d reach{dab.radius, dab.radius, dab.radius};
  const Box ball{dab.center - reach, dab.center + reach};
  std::vector<std::uint32_t> found;
  for (std::size_t chunk = 0; chunk < boxes_.size(); ++chunk) {
    if (!overlap(boxes_[chunk], ball)) continue;
    for (std::size_t t = chunk * kChunk; t < std::min(triangles_.size(), (chunk + 1) * kChunk); ++t) {
      for (const std::uint32_t v : triangles_[t]) {
        const bool is_near = norm2(positions_[v] - dab.center) < dab.radius * dab.radius;
        if (is_near && topology_.freedom[v] != RelaxTopology::Freedom::stays) found.push_back(v);
      }
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void Relaxer::apply(const RelaxDab& dab) { Patch(*this, dab).run(dab); }

}  // namespace knead::remesh_detail
