// Flips, collapses, moves and splits that improve triangles, and the blocks in which several threads apply them.
#include "remesh/improver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "math/elementary.h"
#include "remesh/crossings.h"

namespace knead::detail {

namespace {

constexpr double kMinGain = 1 + 1e-6;  // the smallest factor of an improvement: less might be rounding

double det(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return dot(a, cross(b, c)); }

double cosine(const Vec3d& a, const Vec3d& b) {
  const double sizes = std::sqrt(norm2(a) * norm2(b));
  return sizes > 0 ? dot(a, b) / sizes : -1;
}

// Unit vectors in a plane, all around.
std::array<std::array<double, 2>, 12> make_directions() {
  std::array<std::array<double, 2>, 12> directions{};
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(directions.size());
    directions[i] = {elementary::cos(angle), elementary::sin(angle)};
  }
  return directions;
}

const std::array<std::array<double, 2>, 12> kDirections = make_directions();

constexpr std::size_t kMaxBlockVertices = 8192;

// Moves the first `half` of the vertices, along the longest side of their box, to the front.
void halve(const Surface& s, std::span<std::uint32_t> vertices, std::size_t half) {
  Box box;
  for (const std::uint32_t v : vertices) box.extend(s.after[v]);
  const Vec3d size = box.max - box.min;
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::nth_element(vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(half), vertices.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(s.after[a][axis], a) < std::pair(s.after[b][axis], b);
                   });
}

}  // namespace

void SurfaceMemory::begin(const Surface& s, int threads) {
  edge_rests_.clear();
  vertex_rests_.clear();
  round_ = 0;
  refused_.clear();
  changed_.clear();
  add_new(s);
  measure(s, threads);
}

void SurfaceMemory::measure(const Surface& s, int threads) {
  constexpr std::size_t grain = 4096;
  parallel_for(s.face_count(), grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      if (s.is_alive(f)) quality(s, f);
    }
  });
}

void SurfaceMemory::add_new(const Surface& s) {
  quality_.resize(s.face_count(), -1);
  edge_rests_.resize(s.halfedge.size(), 0);
  vertex_rests_.resize(s.vertex_count(), 0);
  refused_.resize(s.face_count(), 0);
  changed_.resize(s.vertex_count(), 0);
}

void SurfaceMemory::forget_around(const Surface& s, std::uint32_t v) {
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    quality_[h / 3] = -1;
    edge_rests_[s.edge[h]] = 0;
    edge_rests_[s.edge[Surface::next(h)]] = 0;
    edge_rests_[s.edge[Surface::previous(h)]] = 0;
    vertex_rests_[s.target(h)] = 0;
    vertex_rests_[s.apex(h)] = 0;
  });
  vertex_rests_[v] = 0;
  if (round_ == 0) return;
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    for (const std::uint32_t w : {s.target(h), s.apex(h)}) {
      s.for_each_outgoing(w, [&](std::uint32_t k) { changed_[s.target(k)] = changed_[s.apex(k)] = round_; });
    }
  });
}

Improver::Improver(Surface& surface, const Improvement& improvement)
    : s_(surface),
      targets_(improvement.targets),
      progress_(improvement.progress),
      deadline_(improvement.deadline),
      guard_(improvement.guard),
      memory_(improvement.memory),
      exact_(improvement.exact),
      may_collapse_(improvement.may_collapse) {}

bool Improver::is_open(std::uint32_t v) const {
  return s_.has(v, kRegion) && !s_.has(v, kImmovable) && !s_.has(v, kRemoved);
}

template <class Visit>
Freedom Improver::freedom(std::uint32_t v, Visit visit) const {
  if (!is_open(v)) return Freedom::none;
  int faces = 0;
  int features = 0;
  bool on_boundary = false;
  const bool is_crowded = !s_.all_outgoing(v, [&](std::uint32_t h) {
    visit(h);
    const std::uint32_t in = Surface::previous(h);
    features += is_feature(h) ? 1 : 0;
    if (s_.opposite[in] == kNone && is_feature(in)) ++features;
    on_boundary = on_boundary || s_.opposite[h] == kNone || s_.opposite[in] == kNone;
    return ++faces <= kMaxFacesOfVertex;
  });
  if (is_crowded) return Freedom::none;
  if (features == 0) return Freedom::free;
  return features == 2 && !on_boundary ? Freedom::on_crease : Freedom::none;
}

Freedom Improver::freedom(std::uint32_t v) const {
  return freedom(v, [](std::uint32_t) {});
}

Freedom Improver::read_star(std::uint32_t v) {
  star_.begin(s_.after[v]);
  return freedom(v, [&](std::uint32_t h) { star_.add(s_, h, quality_of(h / 3)); });
}

bool Improver::any_turns(std::uint32_t v, const Vec3d& p, const Vec3d& star, const TurnLimit& limit) {
  return !s_.all_outgoing(v, [&](std::uint32_t h) {
    const Vec3d is = cross(s_.after[s_.target(h)] - p, s_.after[s_.apex(h)] - p);
    const Vec3d reference = quality_of(h / 3) < limit.reliable ? star : area_vector(s_, h / 3, s_.after);
    return !turns(limit.cosine, reference, norm2(reference), is, norm2(is));
  });
}

bool Improver::restore_volume(double volume, std::span<const std::uint32_t> vertices, const Bounds& bounds) {
  if (exact_) return true;  // the change is a rounding error
  moving_.clear();
  moving_stars_.clear();
  Vec3d sum{};
  for (const std::uint32_t v : vertices) {
    if (freedom(v) != Freedom::free) continue;
    moving_.push_back(v);
    moving_stars_.push_back(star_vector(s_, v));
    sum += moving_stars_.back();
  }
  const double size2 = norm2(sum);
  if (!(size2 > 0)) return volume == 0;
  const Vec3d d = sum * (volume / size2);
  if (norm(d) > bounds.distance) return false;
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    if (any_turns(moving_[i], s_.after[moving_[i]] + d, moving_stars_[i], bounds.turn)) return false;
  }
  if (!may_move(moving_, d)) return false;
  for (const std::uint32_t v : moving_) s_.after[v] += d;
  report_change(moving_);
  return true;
}

bool Improver::gains_by_flip(std::uint32_t h) {
  const std::uint32_t o = s_.opposite[h];
  if (o == kNone || is_feature(h) || s_.edge_has(h, kLocked)) return false;
  const std::array<std::uint32_t, 4> v{s_.origin(h), s_.target(h), s_.apex(h), s_.apex(o)};
  if (std::any_of(v.begin(), v.end(), [&](std::uint32_t w) { return !s_.has(w, kRegion); })) return false;
  const Vec3d& a = s_.after[v[0]];
  const Vec3d& b = s_.after[v[1]];
  const Vec3d& c = s_.after[v[2]];
  const Vec3d& d = s_.after[v[3]];
  constexpr double margin = 1e-9;  // far above the rounding of known qualities
  const double known = std::min(quality_of(h / 3), quality_of(o / 3));
  const double is = quality(d, c, a);
  if (is <= known - margin) return false;
  const double was = std::min(quality(a, b, c), quality(b, a, d));
  return is > was * kMinGain && quality(c, d, b) > was * kMinGain;
}

bool Improver::try_flip(std::uint32_t h, const Bounds& bounds) {
  const std::uint32_t o = s_.opposite[h];
  const std::array<std::uint32_t, 4> v{s_.origin(h), s_.target(h), s_.apex(h), s_.apex(o)};
  const Vec3d& a = s_.after[v[0]];
  const Vec3d& b = s_.after[v[1]];
  const Vec3d& c = s_.after[v[2]];
  const Vec3d& d = s_.after[v[3]];
  const double was = std::min(quality(a, b, c), quality(b, a, d));
  if (std::any_of(v.begin(), v.end(), [&](std::uint32_t w) { return is_crowded(s_, w); })) return false;
  Vec3d sum = cross(b - a, c - a) + cross(d - b, a - b);
  if (was < bounds.turn.reliable && !exact_) {
    for (const std::uint32_t w : v) sum += star_vector(s_, w);
  }
  if (cosine(cross(c - d, a - d), sum) < bounds.fold || cosine(cross(d - c, b - c), sum) < bounds.fold) return false;
  const double volume = det(c - a, d - a, b - a);
  const double span = norm(cross(b - a, d - c));
  if (std::abs(volume) > bounds.distance * span || norm2(d - c) > targets_.max_edge * targets_.max_edge) return false;
  if (v[2] == v[3] || are_neighbours(s_, v[2], v[3]) || !may_flip(h)) return false;
  flip(s_, h);
  report_change({&v[2], 1});
  if (!restore_volume(-volume, v, bounds)) {
    flip(s_, h);
    report_change({&v[0], 1});
    return false;
  }
  s_.edge_flags[s_.edge[h]] = 0;  // the new diagonal is no crease
  ++counts_.flips;
  return true;
}

// Returns true if a vertex of a crease lies on the line between its neighbours on the crease.
bool Improver::is_straight(std::uint32_t v, double tolerance) const {
  std::vector<Vec3d> ends;
  s_.for_each_outgoing(v, [&](std::uint32_t h) {
    if (is_feature(h)) ends.push_back(s_.after[s_.target(h)] - s_.after[v]);
  });
  if (ends.size() != 2) return false;
  const Vec3d chord = ends[1] - ends[0];
  const double t = norm2(chord) > 0 ? std::clamp(-dot(ends[0], chord) / norm2(chord), 0.0, 1.0) : 0.0;
  return norm(ends[0] + chord * t) <= tolerance;
}

// Returns the possible collapses of an edge: the vertex to remove, and the position of the other.
std::vector<Improver::Merge> Improver::plan_merges(std::uint32_t h, const Bounds& bounds) const {
  const std::uint32_t a = s_.origin(h);
  const std::uint32_t b = s_.target(h);
  std::vector<Merge> merges;
  // The faces of a fixed vertex outside the patch are unknown here, so nothing is merged into it.
  if (s_.has(a, kImmovable) || s_.has(b, kImmovable)) return merges;
  if (is_crowded(s_, a) || is_crowded(s_, b)) return merges;
  const auto add = [&](std::uint32_t e, double t) {
    Merge merge;
    merge.halfedge = e;
    merge.t = t;
    merge.place = s_.after[s_.target(e)] * (1 - t) + s_.after[s_.origin(e)] * t;
    merges.push_back(merge);
  };
  const bool along = is_feature(h);
  // Creases that are closer together than they may move are merged.
  const bool is_short = norm2(s_.after[b] - s_.after[a]) < bounds.crease * bounds.crease;
  const auto may_go = [&](std::uint32_t v) {
    const Freedom freedom_of_v = freedom(v);
    if (freedom_of_v == Freedom::on_crease) return along ? is_straight(v, bounds.crease) : is_short;
    return freedom_of_v == Freedom::free && !along;
  };
  const bool a_goes = may_go(a);
  const bool b_goes = s_.opposite[h] != kNone && may_go(b);
  if (a_goes && b_goes && !along) add(h, 0.5);
  if (a_goes) add(h, 0);
  if (b_goes) add(s_.opposite[h], 0);
  return merges;
}

// Computes the effect of a collapse. A position inside the edge is moved so that the volume is kept; else the volume
// change is stored. Stores the least quality of the triangles around; -1 if it is below `least_quality`, or if the
// surface would turn or move too far.
void Improver::evaluate_merge(Merge& merge, double least_quality, const Bounds& bounds) const {
  const std::uint32_t h = merge.halfedge;
  const std::uint32_t a = s_.origin(h);
  const std::uint32_t b = s_.target(h);
  const Vec3d origin = merge.place;
  Vec3d ring{};
  double volume = 0;
  const auto is_dying = [&](std::uint32_t face) {
    return face == h / 3 || (s_.opposite[h] != kNone && face == s_.opposite[h] / 3);
  };
  for (const std::uint32_t v : {a, b}) {
    s_.for_each_outgoing(v, [&](std::uint32_t e) {
      if (v == b && is_dying(e / 3)) return;  // already counted at a
      const Vec3d x = s_.after[s_.target(e)] - origin;
      const Vec3d y = s_.after[s_.apex(e)] - origin;
      volume += det(s_.after[v] - origin, x, y);
      if (!is_dying(e / 3)) ring += cross(x, y);
    });
  }
  merge.volume = volume;
  if (merge.t != 0 && norm2(ring) > 0) {
    merge.place += ring * (volume / norm2(ring));
    merge.volume = 0;
  }
  merge.quality = -1;
  double least = kInfinity;
  const auto is_good = [&](std::uint32_t e) {
    if (is_dying(e / 3)) return true;
    const Vec3d& x = s_.after[s_.target(e)];
    if (norm2(x - merge.place) > targets_.max_edge * targets_.max_edge) return false;
    least = std::min(least, quality(merge.place, x, s_.after[s_.apex(e)]));
    return least >= least_quality;
  };
  if (!s_.all_outgoing(a, is_good) || !s_.all_outgoing(b, is_good)) return;
  const Vec3d mean = star_vector(s_, a) + star_vector(s_, b);
  const auto is_steady = [&](std::uint32_t e) {
    const Vec3d normal = cross(s_.after[s_.target(e)] - merge.place, s_.after[s_.apex(e)] - merge.place);
    return is_dying(e / 3) ||
           !turns(bounds.turn, area_vector(s_, e / 3, s_.after), normal, quality(s_, e / 3, s_.after), mean);
  };
  if (!s_.all_outgoing(a, is_steady) || !s_.all_outgoing(b, is_steady)) return;
  const auto is_far = [&](std::uint32_t v) { return plane_distance(s_, v, merge.place) > bounds.distance; };
  if (!is_far(a) && !is_far(b)) merge.quality = least;
}

bool Improver::collapse_edge(std::uint32_t h, const std::function<double()>& least_quality, const Bounds& bounds) {
  if (!may_collapse_ || s_.edge_has(h, kLocked) || s_.edge_has(h, kBoundary)) return false;
  std::vector<Merge> merges = plan_merges(h, bounds);
  if (merges.empty()) return false;
  const double least = least_quality();
  Merge best;
  for (Merge& merge : merges) {
    // The first candidate keeps the volume; if it is good, the others are not needed.
    if (best.quality >= least) break;
    evaluate_merge(merge, least, bounds);
    if (merge.quality > best.quality && can_collapse(s_, merge.halfedge)) best = merge;
  }
  if (best.halfedge == kNone || !may_merge(best)) return false;
  std::vector<std::uint32_t> ring;  // of the removed vertex: these vertices compensate the volume
  const std::uint32_t kept = s_.target(best.halfedge);
  s_.for_each_outgoing(s_.origin(best.halfedge), [&](std::uint32_t e) {
    if (s_.target(e) != kept) ring.push_back(s_.target(e));
  });
  if (guard_ != nullptr) {
    guard_->remove(best.halfedge / 3);
    if (s_.opposite[best.halfedge] != kNone) guard_->remove(s_.opposite[best.halfedge] / 3);
  }
  collapse(s_, best.halfedge, best.place, best.t);
  report_change({&kept, 1});
  if (best.volume != 0 && !restore_volume(best.volume, ring, bounds)) counts_.volume += best.volume / 6;
  ++counts_.collapses;
  return true;
}

Attempt Improver::move_to_best(std::uint32_t v, std::span<const Vec3d> places, const Bounds& bounds) {
  const Vec3d& star = star_.vector();
  const double size2 = norm2(star);
  if (!(size2 > 0)) return Attempt::impossible;
  const Vec3d was = s_.after[v];
  const double least = star_.least() * kMinGain;
  std::vector<std::pair<double, Vec3d>> better;  // with negated qualities, so that the best comes first
  for (const Vec3d& wanted : places) {
    const Vec3d d = wanted - was;
    const Vec3d p = was + d - star * (dot(d, star) / size2);
    const double q = star_.quality_at(p, bounds.turn, least);
    if (q > least && !star_.is_farther(p, bounds.distance)) better.emplace_back(-q, p);
  }
  if (better.empty()) return Attempt::impossible;
  std::stable_sort(better.begin(), better.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto place = std::find_if(better.begin(), better.end(), [&](const auto& each) {
    return may_move({&v, 1}, each.second - was);
  });
  if (place == better.end() || place->second == was) return Attempt::refused;
  carry_values(v, place->second);
  s_.after[v] = place->second;
  report_change({&v, 1});
  return Attempt::done;
}

Attempt Improver::move_vertex(std::uint32_t v, const Bounds& bounds) {
  if (read_star(v) != Freedom::free) return Attempt::impossible;
  const Vec3d d = star_.mean() - s_.after[v];
  const std::array<Vec3d, 3> places{s_.after[v] + d, s_.after[v] + d * 0.5, s_.after[v] + d * 0.25};
  return move_to_best(v, places, bounds);
}

bool Improver::search_vertex(std::uint32_t v, const Bounds& bounds) {
  if (read_star(v) != Freedom::free) return false;
  const Vec3d star = star_.vector();
  if (!(norm2(star) > 0)) return false;
  const Vec3d x = any_orthogonal(normalized(star));
  const Vec3d y = cross(normalized(star), x);
  double size = 0;
  s_.for_each_outgoing(v, [&](std::uint32_t h) { size = std::max(size, norm(s_.after[s_.target(h)] - s_.after[v])); });
  std::vector<Vec3d> places;
  for (const std::array<double, 2>& direction : kDirections) {
    const Vec3d along = x * direction[0] + y * direction[1];
    for (const double share : {0.03, 0.1, 0.25, 0.5}) places.push_back(s_.after[v] + along * (share * size));
  }
  return move_to_best(v, places, bounds) == Attempt::done;
}

bool Improver::merge_apex_into_crease(std::uint32_t h, const Bounds& bounds) {
  const std::uint32_t v = s_.apex(h);
  const std::uint32_t o = s_.opposite[h];
  const std::uint32_t a = s_.origin(h);
  const std::uint32_t b = s_.target(h);
  const std::uint8_t flags = s_.edge_flags[s_.edge[h]];
  const bool is_open_feature = is_feature(h) && (flags & (kSeam | kLocked | kBoundary)) == 0;
  if (!is_open_feature || o == kNone || freedom(v) != Freedom::free || !is_open(a) || !is_open(b)) return false;
  const std::uint32_t d = s_.apex(o);
  if (!is_open(d) || are_neighbours(s_, v, d)) return false;
  const Vec3d edge = s_.after[b] - s_.after[a];
  if (!(norm2(edge) > 0)) return false;
  const double t = std::clamp(dot(s_.after[v] - s_.after[a], edge) / norm2(edge), 0.0, 1.0);
  const Vec3d foot = s_.after[a] + edge * t;
  const double was = star_quality(s_, v, s_.after[v], {});
  double is = std::min(quality(s_.after[a], s_.after[d], foot), quality(s_.after[d], s_.after[b], foot));
  const Vec3d mean = star_vector(s_, v);
  double volume = 0;
  std::vector<std::uint32_t> ring;
  s_.for_each_outgoing(v, [&](std::uint32_t e) {
    const Vec3d& x = s_.after[s_.target(e)];
    const Vec3d& y = s_.after[s_.apex(e)];
    volume += det(s_.after[v] - foot, x - foot, y - foot);
    ring.push_back(s_.target(e));
    if (e / 3 == h / 3) return;
    const bool too_far = turns(bounds.turn, area_vector(s_, e / 3, s_.after), cross(x - foot, y - foot),
                               quality(s_, e / 3, s_.after), mean);
    is = too_far ? -1 : std::min(is, quality(foot, x, y));
  });
  if (is <= was * kMinGain || norm(foot - s_.after[v]) > bounds.distance || !may_merge_apex(h, foot)) return false;
  s_.after[v] = foot;
  flip(s_, h);
  report_change({&v, 1});
  s_.edge_flags[s_.edge[h]] = 0;
  s_.for_each_outgoing(v, [&](std::uint32_t e) {
    if (s_.target(e) != a && s_.target(e) != b) return;
    s_.edge_flags[s_.edge[e]] = flags;
  });
  if (!restore_volume(volume, ring, bounds)) counts_.volume += volume / 6;
  ++counts_.flips;
  return true;
}

// Sets the values at v, whose star has been read, to those at the projection of p onto the star.
void Improver::carry_values(std::uint32_t v, const Vec3d& p) {
  if (s_.vertex_values.stride == 0 && s_.corner_values.stride == 0) return;
  const Vec3d& normal = star_.vector();
  std::uint32_t best = s_.outgoing[v];
  double least = -kInfinity;
  std::array<double, 3> weights{1, 0, 0};
  s_.for_each_outgoing(v, [&](std::uint32_t h) {
    const Vec3d& a = s_.after[v];
    const Vec3d& b = s_.after[s_.target(h)];
    const Vec3d& c = s_.after[s_.apex(h)];
    const double area = det(b - a, c - a, normal);
    if (!(area > 0)) return;
    const std::array<double, 3> at{det(b - p, c - p, normal) / area, det(c - p, a - p, normal) / area,
                                   det(a - p, b - p, normal) / area};
    const double inside = *std::min_element(at.begin(), at.end());
    if (inside <= least) return;
    least = inside;
    weights = at;
    best = h;
  });
  const auto mix = [&](Values& values, std::uint32_t a, std::uint32_t b, std::uint32_t c, auto store) {
    for (std::size_t i = 0; i < values.stride; ++i) {
      const double x = values.of(a)[i];
      const double y = values.of(b)[i];
      const double z = values.of(c)[i];
      store(i, x == y && y == z ? x : weights[0] * x + weights[1] * y + weights[2] * z);
    }
  };
  mix(s_.vertex_values, v, s_.target(best), s_.apex(best),
      [&](std::size_t i, double value) { s_.vertex_values.of(v)[i] = value; });
  mix(s_.corner_values, best, Surface::next(best), Surface::previous(best), [&](std::size_t i, double value) {
    s_.for_each_outgoing(v, [&](std::uint32_t h) { s_.corner_values.of(h)[i] = value; });
  });
}

// For splits within planes. The least angle of a face between two features stays whatever is split, and on a curved
// surface no diagonal could be flipped afterwards.
bool Improver::is_helped_by_split(std::uint32_t h) const {
  const auto length2 = [&](std::uint32_t e) { return norm2(s_.after[s_.target(e)] - s_.after[s_.origin(e)]); };
  const std::uint32_t n = Surface::next(h);
  const std::uint32_t p = Surface::previous(h);
  return s_.is_of_part(h / 3) && !(is_feature(h) && is_feature(length2(n) > length2(p) ? n : p));
}

bool Improver::split_chord(std::uint32_t h) {
  const std::uint32_t a = s_.origin(h);
  const std::uint32_t b = s_.target(h);
  const bool is_still = !s_.has(a, kRegion) || !s_.has(b, kRegion);
  if (is_still || s_.edge_has(h, kLocked) || s_.edge_has(h, kBoundary)) return false;
  if (s_.vertex_count() >= targets_.max_vertices || (exact_ && !is_helped_by_split(h))) return false;
  if (norm2(s_.after[b] - s_.after[a]) < 4 * targets_.max_chord * targets_.max_chord) return false;
  const Vec3d middle = (s_.after[a] + s_.after[b]) * 0.5;
  if (!may_split(h, middle)) return false;
  const std::array<std::uint32_t, 2> halves{h, s_.opposite[h]};
  const auto first = static_cast<std::uint32_t>(s_.face_count());
  const std::uint32_t m = split(s_, h, (s_.before[a] + s_.before[b]) * 0.5, middle);
  s_.set(m, kMoved);
  if (guard_ != nullptr) {
    for (std::uint32_t f = first; f < s_.face_count(); ++f) guard_->add(f, halves.at(f - first) / 3);
  }
  if (memory_ != nullptr) memory_->add_new(s_);
  report_change({&m, 1});
  ++counts_.splits;
  return true;
}

bool Improver::may_move(std::span<const std::uint32_t> vertices, const Vec3d& d) const {
  return guard_ == nullptr || guard_->allows_move(vertices, d);
}

bool Improver::may_flip(std::uint32_t h) const {
  if (guard_ == nullptr) return true;
  const std::uint32_t o = s_.opposite[h];
  const std::uint32_t c = s_.apex(h);
  const std::uint32_t d = s_.apex(o);
  const std::array<PlacedFace, 2> proposed{placed(s_, {d, c, s_.origin(h)}), placed(s_, {c, d, s_.target(h)})};
  return guard_->allows(std::array<std::uint32_t, 2>{h / 3, o / 3}, proposed);
}

bool Improver::may_merge(const Merge& merge) const {
  if (guard_ == nullptr) return true;
  const std::uint32_t h = merge.halfedge;
  const std::uint32_t kept = s_.target(h);
  std::vector<std::uint32_t> faces;
  std::vector<PlacedFace> proposed;
  for (const std::uint32_t v : {s_.origin(h), kept}) {
    s_.for_each_outgoing(v, [&](std::uint32_t e) {
      const bool dies = e / 3 == h / 3 || (s_.opposite[h] != kNone && e / 3 == s_.opposite[h] / 3);
      if (dies && v == kept) return;  // already counted at the other end
      faces.push_back(e / 3);
      if (dies) return;
      PlacedFace face = placed(s_, {kept, s_.target(e), s_.apex(e)});
      face.corners[0] = merge.place;
      proposed.push_back(face);
    });
  }
  return guard_->allows(faces, proposed);
}

bool Improver::may_merge_apex(std::uint32_t h, const Vec3d& foot) const {
  if (guard_ == nullptr) return true;
  const std::uint32_t v = s_.apex(h);
  const std::uint32_t o = s_.opposite[h];
  std::vector<std::uint32_t> faces{o / 3};
  std::vector<PlacedFace> proposed{placed(s_, {v, s_.origin(h), s_.apex(o)}),
                                   placed(s_, {v, s_.apex(o), s_.target(h)})};
  s_.for_each_outgoing(v, [&](std::uint32_t e) {
    faces.push_back(e / 3);
    if (e / 3 != h / 3) proposed.push_back(placed(s_, {v, s_.target(e), s_.apex(e)}));
  });
  for (PlacedFace& face : proposed) face.corners[0] = foot;
  return guard_->allows(faces, proposed);
}

bool Improver::may_split(std::uint32_t h, const Vec3d& middle) const {
  if (guard_ == nullptr) return true;
  const auto m = static_cast<std::uint32_t>(s_.vertex_count());
  std::vector<std::uint32_t> faces;
  std::vector<PlacedFace> proposed;
  for (const std::uint32_t side : {h, s_.opposite[h]}) {
    if (side == kNone) continue;
    faces.push_back(side / 3);
    for (const std::uint32_t e : {Surface::next(side), Surface::previous(side)}) {
      PlacedFace face{{m, s_.origin(e), s_.target(e)}, {middle, s_.after[s_.origin(e)], s_.after[s_.target(e)]}};
      proposed.push_back(face);
    }
  }
  return guard_->allows(faces, proposed);
}

void Improver::report_change(std::span<const std::uint32_t> vertices) {
  for (const std::uint32_t v : vertices) {
    if (guard_ != nullptr) guard_->update_around(v);
    if (memory_ != nullptr) memory_->forget_around(s_, v);
  }
}

Blocks::Blocks(const Surface& s, int threads) : block_(s.vertex_count()) {
  while (s.vertex_count() / count_ > kMaxBlockVertices) count_ *= 2;
  std::vector<std::uint32_t> vertices(s.vertex_count());
  std::iota(vertices.begin(), vertices.end(), 0U);
  const auto part = [&](std::size_t i, std::size_t parts) {
    const std::size_t first = vertices.size() * i / parts;
    return std::span(vertices).subspan(first, vertices.size() * (i + 1) / parts - first);
  };
  for (std::size_t parts = 1; parts < count_; parts *= 2) {
    parallel_for(parts, 1, threads,
                 [&](std::size_t i, std::size_t) { halve(s, part(i, parts), part(2 * i, 2 * parts).size()); });
  }
  for (std::uint32_t i = 0; i < count_; ++i) {
    for (const std::uint32_t v : part(i, count_)) block_[v] = i;
  }
}

void Blocks::find_inner(const Surface& s) {
  inner_.assign(s.vertex_count(), 1);
  for (std::size_t f = 0; f < s.face_count() && count_ > 1; ++f) {
    if (!s.is_alive(f)) continue;
    const auto [a, b, c] = s.triangle(f);
    if (block_[a] != block_[b] || block_[b] != block_[c]) inner_[a] = inner_[b] = inner_[c] = 0;
  }
}

}  // namespace knead::detail
