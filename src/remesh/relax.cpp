// Relaxes a surface at one place: moves vertices towards their neighbours, restores the volume, and undoes crossings.
#include "remesh/relax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "knead/error.h"
#include "knead/mesh.h"
#include "math/elementary.h"
#include "remesh/surface.h"

namespace knead::detail {

// The vertices that a dab may move, then those around them; and the triangles at the vertices that may move.
struct RelaxPatch {
  using Neighbours = std::array<std::uint32_t, 2>;

  std::vector<double> weight;          // of each vertex that may move, from 0 to 1
  std::vector<Neighbours> crease;      // of each vertex that may move: its neighbours on a crease; kNone: it is on none
  std::vector<Vec3d> positions;        // of all vertices
  std::vector<Triangle> triangles;     // by these numbers of vertices
  std::vector<std::uint32_t> begin;    // of each vertex that may move, in `corners`; one more
  std::vector<std::uint32_t> corners;  // 3 t + i: the vertex is corner i of triangle t

  std::size_t moving() const { return weight.size(); }
};

namespace {

constexpr std::size_t kGrain = 1024;
constexpr int kMaxRestRounds = 8;
constexpr int kMaxCorrections = 8;                                // steps of Newton's method; two or three are enough
constexpr double kStraight = 1e-9;                                // sine of the angle at a vertex of a straight crease
const double kMinCosine = elementary::cos(std::numbers::pi / 4);  // of the angle by which a triangle turns
const double kGoodQuality = elementary::tan(15 * std::numbers::pi / 180);  // a triangle may lose quality above this
constexpr double kSameQuality = 1 - 1e-9;

constexpr std::size_t kChunk = 512;  // triangles with a common box
constexpr std::size_t kChunksAtOnce = 32;
constexpr int kMaxDabAttempts = 5;

// Lists the corners of the triangles at each vertex.
void list_corners(std::span<const Triangle> triangles, std::size_t vertices, RelaxTopology& topology) {
  topology.corner_begin.assign(vertices + 1, 0);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) ++topology.corner_begin[v + 1];
  }
  for (std::size_t v = 0; v < vertices; ++v) topology.corner_begin[v + 1] += topology.corner_begin[v];
  topology.corners.resize(3 * triangles.size());
  std::vector<std::uint32_t> next(topology.corner_begin.begin(), topology.corner_begin.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t i = 0; i < 3; ++i) topology.corners[next[triangles[t][i]]++] = 3 * t + i;
  }
}

// Returns true if the triangles at a vertex form one closed fan that faces one side.
class FanTest {
 public:
  bool is_closed(std::span<const Triangle> triangles, std::span<const std::uint32_t> corners) {
    edges_.clear();
    for (const std::uint32_t corner : corners) {
      const Triangle& t = triangles[corner / 3];
      edges_.push_back({t[(corner + 1) % 3], t[(corner + 2) % 3]});
      if (edges_.back()[0] == edges_.back()[1] || edges_.back()[0] == t[corner % 3]) return false;
    }
    std::sort(edges_.begin(), edges_.end());
    const auto begins_alike = [](const auto& a, const auto& b) { return a[0] == b[0]; };
    if (edges_.empty() || std::adjacent_find(edges_.begin(), edges_.end(), begins_alike) != edges_.end()) return false;
    std::uint32_t at = edges_.front()[0];
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const auto edge = std::lower_bound(edges_.begin(), edges_.end(), std::array<std::uint32_t, 2>{at, 0});
      if (edge == edges_.end() || (*edge)[0] != at) return false;
      at = (*edge)[1];
      if (at == edges_.front()[0]) return i + 1 == edges_.size();
    }
    return false;
  }

 private:
  std::vector<std::array<std::uint32_t, 2>> edges_;  // opposite to the vertex
};

// Counts the creases at each vertex and lists the vertices that have two.
void find_creased(std::size_t vertices, std::span<const MeshEdge> creases, RelaxTopology& topology) {
  std::vector<MeshEdge> ends;  // each crease from both ends
  for (const MeshEdge& edge : creases) {
    ends.push_back(edge);
    ends.push_back({edge[1], edge[0]});
  }
  std::sort(ends.begin(), ends.end());
  for (std::size_t i = 0; i < ends.size();) {
    std::size_t last = i;
    while (last < ends.size() && ends[last][0] == ends[i][0]) ++last;
    const std::uint32_t v = ends[i][0];
    if (v < vertices && topology.freedom[v] == RelaxTopology::Freedom::free) {
      topology.freedom[v] = last - i == 2 ? RelaxTopology::Freedom::on_crease : RelaxTopology::Freedom::stays;
      if (last - i == 2) topology.on_crease.push_back({v, {ends[i][1], ends[i + 1][1]}});
    }
    i = last;
  }
}

// One iteration: moves the vertices of a patch towards the means of their neighbours, and keeps the volume (Relaxer).
class Iteration {
 public:
  Iteration(RelaxPatch& patch, double amount, double surface, int threads)
      : patch_(patch), threads_(threads), from_(patch.positions), center_(from_.front()) {
    areas(from_, area_);
    plan(amount, surface);
  }

  void run() {
    const double volume = volume_of(from_);
    rests_.assign(patch_.moving(), false);
    for (int round = 0; round < kMaxRestRounds; ++round) {
      for (std::size_t v = 0; v < patch_.moving(); ++v) {
        patch_.positions[v] = rests_[v] ? from_[v] : from_[v] + move_[v];
      }
      if (restore(volume) && !let_rest()) return;
    }
    patch_.positions = from_;
  }

 private:
  void areas(std::span<const Vec3d> x, std::vector<Vec3d>& result) const {
    result.resize(patch_.triangles.size());
    parallel_for(result.size(), kGrain, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const auto [a, b, c] = patch_.triangles[t];
        result[t] = cross(x[b] - x[a], x[c] - x[a]);
      }
    });
  }

  Vec3d star(std::size_t v, const std::vector<Vec3d>& area) const {
    Vec3d sum{};
    for (std::uint32_t i = patch_.begin[v]; i < patch_.begin[v + 1]; ++i) sum += area[patch_.corners[i] / 3];
    return sum;
  }

  // Plans the motion of each vertex, and the direction in which it restores the volume.
  void plan(double amount, double surface) {
    move_.resize(patch_.moving());
    along_.resize(patch_.moving());
    parallel_for(patch_.moving(), kGrain, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (patch_.crease[v][0] != kNone) {
          move_[v] = along_crease(v) * (amount * patch_.weight[v]);
          continue;
        }
        const Vec3d sum = star(v, area_);
        if (!(norm2(sum) > 0)) continue;
        const Vec3d normal = normalized(sum);
        const Vec3d d = to_mean(v);
        const double across = dot(normal, d);
        move_[v] = (d + normal * ((surface - 1) * across)) * (amount * patch_.weight[v]);
        along_[v] = normal * patch_.weight[v];
      }
    });
  }

  // The neighbours of a vertex in a closed fan are the next corners of its triangles.
  Vec3d to_mean(std::size_t v) const {
    Vec3d sum{};
    for (std::uint32_t i = patch_.begin[v]; i < patch_.begin[v + 1]; ++i) {
      const std::uint32_t corner = patch_.corners[i];
      sum += from_[patch_.triangles[corner / 3][(corner + 1) % 3]] - from_[v];
    }
    return sum / static_cast<double>(patch_.begin[v + 1] - patch_.begin[v]);
  }

  Vec3d along_crease(std::size_t v) const {
    const Vec3d a = from_[patch_.crease[v][0]] - from_[v];
    const Vec3d b = from_[patch_.crease[v][1]] - from_[v];
    const bool is_straight = dot(a, b) < 0 && norm(cross(a, b)) <= kStraight * norm(a) * norm(b);
    return is_straight ? (a + b) * 0.5 : Vec3d{};
  }

  // Returns six times the volume between the triangles and the centre.
  double volume_of(std::span<const Vec3d> x) const {
    double sum = 0;
    for (const auto& [a, b, c] : patch_.triangles) sum += dot(x[a] - center_, cross(x[b] - center_, x[c] - center_));
    return sum;
  }

  // Moves the vertices that do not rest along their normals until the volume is right. Returns false if that fails.
  bool restore(double volume) {
    std::vector<Vec3d>& x = patch_.positions;
    double missing = volume - volume_of(x);
    for (int i = 0; i < kMaxCorrections && missing != 0; ++i) {
      areas(x, new_area_);
      double growth = 0;
      for (std::size_t v = 0; v < patch_.moving(); ++v) {
        if (!rests_[v]) growth += dot(star(v, new_area_), along_[v]);
      }
      if (!(growth > 0)) break;
      const std::vector<Vec3d> before = x;
      for (std::size_t v = 0; v < patch_.moving(); ++v) {
        if (!rests_[v]) x[v] += along_[v] * (missing / growth);
      }
      const double still = volume - volume_of(x);
      if (std::abs(still) >= std::abs(missing)) {
        x = before;
        break;
      }
      missing = still;
    }
    double size = 0;  // its rounding error is far below the volume at any visible triangle
    for (std::size_t t = 0; t < area_.size(); ++t) size += norm(area_[t]) * norm(x[patch_.triangles[t][0]] - center_);
    return std::abs(missing) <= 1e-12 * size;
  }

  // Lets the vertices of triangles that turn or shrink too much rest. Returns true if there are any.
  bool let_rest() {
    const std::vector<Vec3d>& x = patch_.positions;
    areas(x, new_area_);
    std::vector<char> is_bad(patch_.triangles.size());
    parallel_for(is_bad.size(), kGrain, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) is_bad[t] = turns_or_shrinks(t) ? 1 : 0;
    });
    bool any = false;
    for (std::size_t t = 0; t < is_bad.size(); ++t) {
      if (is_bad[t] == 0) continue;
      for (const std::uint32_t v : patch_.triangles[t]) {
        if (v >= patch_.moving() || rests_[v]) continue;
        rests_[v] = true;
        any = true;
      }
    }
    return any;
  }

  bool turns_or_shrinks(std::size_t t) const {
    const auto [a, b, c] = patch_.triangles[t];
    const std::vector<Vec3d>& x = patch_.positions;
    if (x[a] == from_[a] && x[b] == from_[b] && x[c] == from_[c]) return false;
    const double was = quality(from_[a], from_[b], from_[c]);
    if (quality(x[a], x[b], x[c]) < std::min(was, kGoodQuality) * kSameQuality) return true;
    if (was >= kMinReliableQuality)
      return dot(area_[t], new_area_[t]) < kMinCosine * norm(area_[t]) * norm(new_area_[t]);
    return std::any_of(patch_.triangles[t].begin(), patch_.triangles[t].end(),
                       [&](std::uint32_t v) { return v < patch_.moving() && dot(star(v, area_), new_area_[t]) < 0; });
  }

  RelaxPatch& patch_;
  int threads_;
  std::vector<Vec3d> from_;
  Vec3d center_;
  std::vector<Vec3d> area_;  // twice the area vectors at the beginning
  std::vector<Vec3d> new_area_;
  std::vector<Vec3d> move_;
  std::vector<Vec3d> along_;
  std::vector<bool> rests_;
};

using Pair = std::array<std::uint32_t, 2>;

Vec3d in_float(const Vec3d& p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

void extend(Box& box, const Box& by) {
  box.extend(by.min);
  box.extend(by.max);
}

double weight_at(double distance2, double radius) {
  const double rest = 1 - distance2 / (radius * radius);
  return rest * rest;
}

}  // namespace

RelaxTopology relax_topology(std::span<const Triangle> triangles, std::size_t vertices,
                             std::span<const MeshEdge> creases) {
  RelaxTopology topology;
  list_corners(triangles, vertices, topology);
  topology.freedom.assign(vertices, RelaxTopology::Freedom::stays);
  FanTest test;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    if (test.is_closed(triangles, topology.corners_of(v))) topology.freedom[v] = RelaxTopology::Freedom::free;
  }
  find_creased(vertices, creases, topology);
  return topology;
}

// The patch of one dab, the numbers of its vertices and triangles in the mesh, and the triangles around that it may
// cross.
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
    for (int attempt = 0; attempt < kMaxDabAttempts; ++attempt) {
      patch_.positions.assign(start_.begin(), start_.end());
      for (int i = 0; i < dab.iterations; ++i) Iteration(patch_, dab.amount, dab.surface, relaxer_.threads_).run();
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

  // Appends the triangles around the patch.
  void take_surroundings(const Box& box) {
    if (all_.empty()) all_ = patch_.triangles;
    for (const std::uint32_t t : relaxer_.triangles_in(box)) {
      if (relaxer_.triangle_number_[t] != kNone) continue;
      relaxer_.triangle_number_[t] = static_cast<std::uint32_t>(triangles_.size());
      triangles_.push_back(t);
      all_.push_back(numbered(t));
    }
  }

  // Returns the pairs that cross with these positions of the patch, each with at least one triangle of the patch.
  std::vector<Pair> crossings(const std::vector<Vec3d>& positions) const {
    std::vector<Vec3d> x = positions;
    for (std::size_t i = x.size(); i < vertices_.size(); ++i) x.push_back(relaxer_.positions_[vertices_[i]]);
    if (relaxer_.single_precision_) std::transform(x.begin(), x.end(), x.begin(), in_float);
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

  // Lets the corners of a triangle rest, and with `neighbours` also the vertices around them.
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

}  // namespace knead::detail
