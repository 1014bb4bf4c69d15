// Searches for triangles that cross, and a guard that refuses changes that would make triangles cross.
#include "remesh/crossings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/edges.h"
#include "mesh/predicates.h"

namespace knead::detail {

namespace {

// Random strong strokes on scans need up to 371 tests a face; a heap of overlapping faces took 287,000.
constexpr std::uint64_t kMaxTestsPerFace = 1000;
constexpr std::uint64_t kExtraFaces = 200;  // added to the number of faces, so that few faces have enough tests

// Overlaps no box.
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr FloatBox kNoBox{{kInf, kInf, kInf}, {-kInf, -kInf, -kInf}};

std::vector<std::uint32_t> all_of(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

Vec3d as_float(const Vec3d& p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

// Returns the point with coordinates that are too small for the predicates set to 0.
Vec3d without_tiny(const Vec3d& p) {
  const auto kept = [](double x) { return std::abs(x) < 0x1p-250 ? 0.0 : x; };
  return {kept(p.x), kept(p.y), kept(p.z)};
}

// Returns the box of the vertices that may change, widened by 5% of its diagonal.
Box search_box(const Surface& s) {
  std::vector<Vec3d> points;
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.has(v, kRegion) && !s.has(v, kRemoved)) points.push_back(s.after[v]);
  }
  Box box = bounding_box(points);
  const double margin = 0.05 * box.diagonal();
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  return box;
}

// Returns the triangles of the mesh that are outside the patch and overlap its search box.
std::vector<Triangle> triangles_near(const Mesh& before, const Patch& patch, int threads, const Progress* progress) {
  constexpr std::size_t grain = 8192;  // faces
  const Box box = search_box(patch.surface);
  std::vector<std::vector<Triangle>> of_chunk(before.face_count() / grain + 1);
  parallel_for(before.face_count(), grain, threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    std::vector<Triangle> parts;
    for (std::size_t f = begin; f < end; ++f) {
      if (patch.holds_face[f] != 0 || before.face(f).size() < 3) continue;
      parts.clear();
      triangulate_polygon(before.positions, before.face(f), parts);
      for (const Triangle& t : parts) {
        if (overlap(bounding_box(corners_of(t, before.positions)), box)) of_chunk[begin / grain].push_back(t);
      }
    }
  });
  std::vector<Triangle> found;
  for (const std::vector<Triangle>& some : of_chunk) found.insert(found.end(), some.begin(), some.end());
  return found;
}

// Returns the number of connected sets of pairs: pairs that share a vertex are connected.
std::size_t count_curves(const SelfIntersections& found, std::span<const Triangle> triangles, std::size_t vertices) {
  if (found.pairs.empty()) return 0;
  DisjointSets sets(vertices);
  for (const auto& [t, u] : found.pairs) {
    for (const std::uint32_t other : {t, u}) {
      for (const std::uint32_t v : triangles[other]) sets.join(v, triangles[t][0]);
    }
  }
  std::vector<std::uint32_t> firsts;
  for (const auto& pair : found.pairs) firsts.push_back(sets.find(triangles[pair[0]][0]));
  std::sort(firsts.begin(), firsts.end());
  return static_cast<std::size_t>(std::unique(firsts.begin(), firsts.end()) - firsts.begin());
}

}  // namespace

CrossingSearch::CrossingSearch(const Mesh& before, const Patch& patch, bool single_precision, int threads,
                               const Progress* progress)
    : first_(static_cast<std::uint32_t>(patch.vertex_source.size())),
      single_precision_(single_precision),
      threads_(threads),
      progress_(progress) {
  std::vector<std::uint32_t> number(before.vertex_count(), kNone);
  for (std::uint32_t p = 0; p < patch.vertex_source.size(); ++p) number[patch.vertex_source[p]] = p;
  for (const Triangle& t : triangles_near(before, patch, threads, progress)) {
    Triangle& named = outside_.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      if (number[t[i]] == kNone) {
        number[t[i]] = first_ + static_cast<std::uint32_t>(outside_positions_.size());
        outside_positions_.push_back(before.positions[t[i]]);
      }
      named[i] = number[t[i]];
    }
  }
}

Vec3d CrossingSearch::as_written(const Vec3d& p) const { return without_tiny(single_precision_ ? as_float(p) : p); }

PlacedFace CrossingSearch::as_written(PlacedFace face) const {
  for (std::uint32_t& v : face.vertices) v = number(v);
  for (Vec3d& corner : face.corners) corner = as_written(corner);
  return face;
}

CrossingSearch::Triangles CrossingSearch::triangles(const Surface& s, const std::optional<Box>& box) const {
  Triangles result;
  result.positions.reserve(s.vertex_count() + outside_positions_.size());
  const auto first = s.after.begin() + first_;
  result.positions.assign(s.after.begin(), first);
  result.positions.insert(result.positions.end(), outside_positions_.begin(), outside_positions_.end());
  result.positions.insert(result.positions.end(), first, s.after.end());
  for (Vec3d& p : result.positions) p = as_written(p);
  result.triangles.reserve(box ? 0 : outside_.size() + s.face_count());
  const auto add = [&](const Triangle& t) {
    const bool is_in = !box || overlap(bounding_box(corners_of(t, result.positions)), *box);
    if (is_in) result.triangles.push_back(t);
    return is_in;
  };
  for (const Triangle& t : outside_) add(t);
  result.outside = result.triangles.size();
  result.faces.reserve(box ? 0 : s.face_count());
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    const auto [a, b, c] = s.triangle(f);
    if (add({number(a), number(b), number(c)})) result.faces.push_back(f);
  }
  return result;
}

Crossings CrossingSearch::find(const Patch& patch, const std::vector<bool>& only) const {
  const Surface& s = patch.surface;
  std::optional<Box> box;
  if (!only.empty()) {
    box.emplace();
    for (std::uint32_t f = 0; f < s.face_count(); ++f) {
      if (!only[f] || !s.is_alive(f)) continue;
      for (const std::uint32_t v : s.triangle(f)) box->extend(as_written(s.after[v]));
    }
  }
  const Triangles searched = triangles(s, box);
  std::vector<bool> is_changed(searched.triangles.size(), false);
  for (std::size_t i = 0; i < searched.faces.size(); ++i) {
    const std::uint32_t f = searched.faces[i];
    if (!only.empty() && !only[f]) continue;
    const Triangle t = s.triangle(f);
    is_changed[searched.outside + i] = !patch.is_unchanged(f) || std::any_of(t.begin(), t.end(), [&](std::uint32_t v) {
      return s.has(v, kMoved) || s.has(v, kRegion);
    });
  }
  SelfIntersectionOptions options;
  options.threads = threads_;
  options.progress = progress_;
  options.chosen = &is_changed;
  stop_if_cancelled(progress_);
  const SelfIntersections found = self_intersections(searched.triangles, searched.positions, options);
  Crossings crossings;
  if (!found.complete) crossings.pairs = found.count;
  crossings.curves = found.complete ? count_curves(found, searched.triangles, searched.positions.size()) : found.count;
  std::vector<bool> crosses(found.pairs.empty() ? 0 : searched.triangles.size(), false);
  for (const auto& [t, u] : found.pairs) {
    ++crossings.pairs;
    crosses[t] = true;
    crosses[u] = true;
  }
  for (std::size_t w = searched.outside; w < crosses.size(); ++w) {  // in ascending order
    if (crosses[w]) crossings.faces.push_back(searched.faces[w - searched.outside]);
  }
  return crossings;
}

CrossingGuard::CrossingGuard(const Surface& surface, const CrossingSearch& search)
    : CrossingGuard(surface, search, search.triangles(surface)) {}

CrossingGuard::CrossingGuard(const Surface& surface, const CrossingSearch& search, const CrossingSearch::Triangles& all)
    : s_(surface),
      search_(search),
      tree_(all.triangles, all.positions, all_of(all.triangles.size()), search.threads()),
      obstacles_(all.triangles.size()),
      written_(all.triangles.size()),
      place_(all_of(all.triangles.size())),
      face_(all.triangles.size(), kNone),
      obstacle_of_(surface.face_count(), kNone),
      watched_(surface.vertex_count(), false),
      max_tests_(kMaxTestsPerFace * (kExtraFaces + surface.face_count())) {
  for (std::uint32_t place = 0; place < place_.size(); ++place) {
    const std::uint32_t t = tree_.member_at(place);
    set(place, all.placed(t));
    if (t < all.outside) continue;
    face_[place] = all.faces[t - all.outside];
    obstacle_of_[face_[place]] = place;
  }
}

void CrossingGuard::set(std::uint32_t obstacle, const PlacedFace& written) {
  written_[obstacle] = written;
  obstacles_[obstacle].box = are_collinear(written.corners) ? kNoBox : tree_.box_of(written.corners);
}

void CrossingGuard::watch(std::span<const Box> places) {
  for (const Box& place : places) {
    tree_.for_each_place_with(tree_.box_of({place.min, place.max, place.min}), [&](std::uint32_t at) {
      if (face_[at] == kNone) return true;
      for (const std::uint32_t v : s_.triangle(face_[at])) watched_[v] = true;
      return true;
    });
  }
}

void CrossingGuard::mark(std::span<const std::uint32_t> faces) {
  ++mark_;
  for (const std::uint32_t f : faces) obstacles_[obstacle_of_[f]].mark = mark_;
}

bool CrossingGuard::cross(const Boxed& face, const FloatBox& box, const PlacedFace& triangle) {
  if (!face.box.overlaps(box)) return false;
  ++tests_;
  return meet_beyond_shared(face.triangle.vertices, face.triangle.corners, triangle.vertices, triangle.corners);
}

std::size_t CrossingGuard::count_pairs(std::span<const PlacedFace> faces, std::size_t enough) {
  faces_.clear();
  std::size_t pairs = 0;
  for (const PlacedFace& face : faces) {
    const PlacedFace triangle = search_.as_written(face);
    if (are_collinear(triangle.corners)) {
      ++pairs;
    } else {
      faces_.push_back({triangle, tree_.box_of(triangle.corners)});
    }
  }
  if (faces_.empty() || pairs >= enough) return pairs;
  for (std::size_t i = 0; i < faces_.size() && pairs < enough; ++i) {
    for (std::size_t j = i + 1; j < faces_.size(); ++j) {
      pairs += cross(faces_[i], faces_[j].box, faces_[j].triangle) ? 1 : 0;
    }
  }
  FloatBox all = faces_[0].box;
  for (const Boxed& face : faces_) all = join(all, face.box);
  if (pairs >= enough) return pairs;
  tree_.for_each_place_with(all, [&](std::uint32_t place) {
    for (std::uint32_t i = place; i != kNone; i = obstacles_[i].next) {
      const Obstacle& obstacle = obstacles_[i];
      if (obstacle.mark == mark_ || !all.overlaps(obstacle.box)) continue;
      for (const Boxed& face : faces_) pairs += cross(face, obstacle.box, written_[i]) ? 1 : 0;
      if (pairs >= enough) return false;
    }
    return true;
  });
  return pairs;
}

bool CrossingGuard::allows(std::span<const std::uint32_t> faces, std::span<const PlacedFace> proposed) {
  const bool watched = std::any_of(faces.begin(), faces.end(), [&](std::uint32_t f) {
    const Triangle t = s_.triangle(f);
    return std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_watched(v); });
  });
  if (!watched) return true;
  mark(faces);
  if (count_pairs(proposed, 1) == 0) return true;
  std::vector<PlacedFace> were;
  were.reserve(faces.size());
  for (const std::uint32_t f : faces) were.push_back(placed(s_, s_.triangle(f)));
  const std::size_t pairs = count_pairs(were, std::numeric_limits<std::size_t>::max());
  return pairs > 0 && count_pairs(proposed, pairs) < pairs;
}

bool CrossingGuard::allows_move(std::span<const std::uint32_t> vertices, const Vec3d& d) {
  std::vector<std::uint32_t> faces;
  for (const std::uint32_t v : vertices) {
    s_.for_each_outgoing(v, [&](std::uint32_t h) { faces.push_back(h / 3); });
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::vector<PlacedFace> proposed;
  proposed.reserve(faces.size());
  for (const std::uint32_t f : faces) {
    PlacedFace face = placed(s_, s_.triangle(f));
    for (std::size_t i = 0; i < 3; ++i) {
      const bool moves = std::find(vertices.begin(), vertices.end(), face.vertices[i]) != vertices.end();
      if (moves) face.corners[i] += d;
    }
    proposed.push_back(face);
  }
  return allows(faces, proposed);
}

bool CrossingGuard::crosses(std::uint32_t face) {
  if (!s_.is_alive(face)) return false;
  const PlacedFace own = placed(s_, s_.triangle(face));
  mark({&face, 1});
  return count_pairs({&own, 1}, 1) > 0;
}

void CrossingGuard::update(std::uint32_t face) {
  const std::uint32_t i = obstacle_of_[face];
  const PlacedFace written = search_.as_written(placed(s_, s_.triangle(face)));
  set(i, written);
  tree_.widen(place_[i], tree_.box_of(written.corners));
}

void CrossingGuard::update_around(std::uint32_t v) {
  s_.for_each_outgoing(v, [&](std::uint32_t h) { update(h / 3); });
}

void CrossingGuard::add(std::uint32_t face, std::uint32_t from) {
  const auto i = static_cast<std::uint32_t>(obstacles_.size());
  const std::uint32_t place = place_[obstacle_of_[from]];
  obstacle_of_.resize(std::max<std::size_t>(obstacle_of_.size(), face + 1), kNone);
  obstacle_of_[face] = i;
  obstacles_.push_back({kNoBox, std::exchange(obstacles_[place].next, i), 0});
  written_.emplace_back();
  place_.push_back(place);
}

void CrossingGuard::remove(std::uint32_t face) { obstacles_[obstacle_of_[face]].box = kNoBox; }

}  // namespace knead::detail
