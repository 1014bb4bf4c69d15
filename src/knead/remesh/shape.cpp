#include "knead/remesh/shape.h"

namespace knead::remesh_detail {

bool turns(const TurnLimit& limit, const Vec3d& was, const Vec3d& is, double quality_was, const Vec3d& mean) {
  const Vec3d& reference = quality_was < limit.reliable ? mean : was;
  return !(dot(reference, is) >= limit.cosine * std::sqrt(norm2(reference) * norm2(is))) || !(norm2(is) > 0);
}

double star_quality(const Surface& s, std::uint32_t v, const Vec3d& p, const TurnLimit& limit) {
  const Vec3d mean = star_vector(s, v);
  double least = std::numeric_limits<double>::infinity();
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    if (least < 0) return;
    const Vec3d& b = s.after[s.target(h)];
    const Vec3d& c = s.after[s.apex(h)];
    const bool too_far =
        turns(limit, area_vector(s, h / 3, s.after), cross(b - p, c - p), quality(s, h / 3, s.after), mean);
    least = too_far ? -1 : std::min(least, quality(p, b, c));
  });
  return least;
}

double plane_distance(const Surface& s, std::uint32_t v, const Vec3d& p) {
  double most = 0;
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    if (quality(s, h / 3, s.after) < kThin) return;
    const Vec3d n = area_vector(s, h / 3, s.after);
    most = std::max(most, std::abs(dot(n, p - s.after[v])) / norm(n));
  });
  return most;
}

void Star::read(const Surface& s, std::uint32_t v) {
  place_ = s.after[v];
  vector_ = {};
  faces_.clear();
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    const Vec3d n = area_vector(s, h / 3, s.after);
    vector_ += n;
    faces_.push_back({s.after[s.target(h)], s.after[s.apex(h)], n, norm(n), quality(s, h / 3, s.after)});
  });
}

double Star::quality_at(const Vec3d& p, const TurnLimit& limit, double floor) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Face& face : faces_) {
    if (turns(limit, face.normal, cross(face.b - p, face.c - p), face.quality, vector_)) return -1;
    least = std::min(least, remesh_detail::quality(p, face.b, face.c));
    if (least <= floor) break;
  }
  return least;
}

bool Star::is_farther(const Vec3d& p, double distance) const {
  const Vec3d d = p - place_;
  return std::any_of(faces_.begin(), faces_.end(), [&](const Face& face) {
    return face.quality >= kThin && std::abs(dot(face.normal, d)) / face.size > distance;
  });
}

bool is_crowded(const Surface& s, std::uint32_t v) {
  int count = 0;
  return !s.all_outgoing(v, [&](std::uint32_t) { return ++count <= kMostFacesOfVertex; });
}

bool are_neighbours(const Surface& s, std::uint32_t v, std::uint32_t w) {
  if (s.has(v, kFixed)) std::swap(v, w);
  bool found = s.has(v, kFixed);
  s.for_each_outgoing(v, [&](std::uint32_t h) { found = found || s.target(h) == w || s.apex(h) == w; });
  return found;
}

}  // namespace knead::remesh_detail
