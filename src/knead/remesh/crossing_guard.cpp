#include "knead/remesh/crossing_guard.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace knead::remesh_detail {

namespace {

// Random strong strokes on scans need up to 371 (docs/remeshing.md); a heap of faces took 287,000.
constexpr std::uint64_t kTestsPerFace = 1000;
constexpr std::uint64_t kFewFaces = 200;  // may take as long as so many more

// Overlaps none.
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr FloatBox kNoBox{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

std::vector<std::uint32_t> all_of(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

}  // namespace

CrossingGuard::CrossingGuard(const Surface& surface, const CrossingSearch& search)
    : CrossingGuard(surface, search, search.triangles(surface)) {}

CrossingGuard::CrossingGuard(const Surface& surface, const CrossingSearch& search, const CrossingSearch::Triangles& all)
    : s_(surface),
      search_(search),
      tree_(all.triangles, all.positions, all_of(all.triangles.size())),
      obstacles_(all.triangles.size()),
      written_(all.triangles.size()),
      place_(all_of(all.triangles.size())),
      face_(all.triangles.size(), kNone),
      obstacle_of_(surface.face_count(), kNone),
      watched_(surface.vertex_count(), false),
      most_tests_(kTestsPerFace * (kFewFaces + surface.face_count())) {
  for (std::uint32_t place = 0; place < place_.size(); ++place) {
    const std::uint32_t t = tree_.member_at(place);
    set(place, all.placed(t));
    if (t < search.outside_count()) continue;
    face_[place] = all.faces[t - search.outside_count()];
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

}  // namespace knead::remesh_detail
