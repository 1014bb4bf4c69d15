#include "knead/remesh/crossing_guard.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace knead::remesh_detail {

namespace {

// Random strong strokes on scans need up to 371 (docs/remeshing.md); a heap of faces took 287,000.
constexpr std::uint64_t kTestsPerFace = 1000;
constexpr std::uint64_t kFewFaces = 200;  // may take as long as so many more

std::vector<std::uint32_t> all_of(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

}  // namespace

CrossingGuard::CrossingGuard(const Surface& surface, const CrossingSearch& search)
    : s_(surface),
      search_(search),
      outside_count_(search.outside_count()),
      triangles_(search.triangles(surface)),
      tree_(triangles_.triangles, triangles_.positions, all_of(triangles_.triangles.size())),
      places_(tree_.places(triangles_.triangles.size())),
      root_(all_of(surface.face_count())),
      next_(surface.face_count(), kNone),
      triangle_of_(surface.face_count(), kNone),
      boxes_(surface.face_count()),
      watched_(surface.vertex_count(), false),
      marks_(surface.face_count(), 0),
      most_tests_(kTestsPerFace * (kFewFaces + surface.face_count())) {
  for (std::size_t i = 0; i < triangles_.faces.size(); ++i) {
    const auto t = static_cast<std::uint32_t>(outside_count_ + i);
    triangle_of_[triangles_.faces[i]] = t;
    boxes_[triangles_.faces[i]] = tree_.box_of(triangles_.placed(t).corners);
  }
}

void CrossingGuard::watch(std::span<const Box> places) {
  for (const Box& place : places) {
    tree_.for_each_overlap_with(tree_.box_of({place.min, place.max, place.min}), [&](std::uint32_t t) {
      if (t < outside_count_) return true;
      for (const std::uint32_t v : s_.triangle(triangles_.faces[t - outside_count_])) watched_[v] = true;
      return true;
    });
  }
}

void CrossingGuard::mark(std::span<const std::uint32_t> faces) {
  ++mark_;
  for (const std::uint32_t f : faces) marks_[f] = mark_;
}

// Finds the triangles whose boxes overlap that of one of the faces.
void CrossingGuard::find_obstacles() {
  obstacles_.clear();
  const auto is_near = [&](const FloatBox& box) {
    return std::any_of(faces_.begin(), faces_.end(), [&](const Boxed& face) { return face.box.overlaps(box); });
  };
  FloatBox all = faces_[0].box;
  for (const Boxed& face : faces_) all = join(all, face.box);
  tree_.for_each_overlap_with(all, [&](std::uint32_t t) {
    if (t < outside_count_) {
      const PlacedFace triangle = triangles_.placed(t);
      const FloatBox box = tree_.box_of(triangle.corners);
      if (is_near(box)) obstacles_.push_back({triangle, box});
      return true;
    }
    for (std::uint32_t f = triangles_.faces[t - outside_count_]; f != kNone; f = next_[f]) {
      if (marks_[f] == mark_ || !is_near(boxes_[f]) || !s_.is_alive(f)) continue;
      obstacles_.push_back({search_.as_written(placed(s_, s_.triangle(f))), boxes_[f]});
    }
    return true;
  });
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
  const auto cross = [&](const Boxed& a, const Boxed& b) {
    if (!a.box.overlaps(b.box)) return false;
    ++tests_;
    return meet_beyond_shared(a.triangle.vertices, a.triangle.corners, b.triangle.vertices, b.triangle.corners);
  };
  for (std::size_t i = 0; i < faces_.size() && pairs < enough; ++i) {
    for (std::size_t j = i + 1; j < faces_.size(); ++j) pairs += cross(faces_[i], faces_[j]) ? 1 : 0;
  }
  if (pairs >= enough) return pairs;
  find_obstacles();
  for (const Boxed& obstacle : obstacles_) {
    if (are_collinear(obstacle.triangle.corners)) continue;
    for (const Boxed& face : faces_) pairs += cross(face, obstacle) ? 1 : 0;
    if (pairs >= enough) break;
  }
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
  boxes_[face] = tree_.box_of(search_.as_written(placed(s_, s_.triangle(face))).corners);
  tree_.widen(places_[triangle_of_[root_[face]]], boxes_[face]);
}

void CrossingGuard::update_around(std::uint32_t v) {
  s_.for_each_outgoing(v, [&](std::uint32_t h) { update(h / 3); });
}

void CrossingGuard::add(std::uint32_t face, std::uint32_t from) {
  const std::uint32_t root = root_[from];
  root_.resize(std::max<std::size_t>(root_.size(), face + 1), root);
  root_[face] = root;
  next_.resize(root_.size(), kNone);
  boxes_.resize(root_.size());
  marks_.resize(root_.size(), 0);
  next_[face] = next_[root];
  next_[root] = face;
}

}  // namespace knead::remesh_detail
