// A half-edge mesh: connects triangles, splits, flips and collapses edges, and measures the faces around a vertex.
#include "remesh/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace knead::detail {

namespace {

// The half-edges sorted by their smaller vertex: those of v are [begin[v], begin[v + 1]).
struct Buckets {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> halfedges;
};

Buckets bucket_halfedges(const Surface& s) {
  Buckets buckets;
  buckets.begin.assign(s.vertex_count() + 1, 0);
  buckets.halfedges.resize(s.corner.size());
  const auto low = [&](std::uint32_t h) { return std::min(s.origin(h), s.target(h)); };
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) ++buckets.begin[low(h) + std::size_t{1}];
  for (std::size_t v = 0; v < s.vertex_count(); ++v) buckets.begin[v + 1] += buckets.begin[v];
  std::vector<std::uint32_t> at(buckets.begin.begin(), buckets.begin.end() - 1);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) buckets.halfedges[at[low(h)]++] = h;
  return buckets;
}

std::uint32_t append_edge(Surface& s, std::uint8_t flags) {
  s.halfedge.push_back(kNone);
  s.edge_flags.push_back(flags);
  if (!s.next_copy.empty()) s.next_copy.push_back(kNone);
  return static_cast<std::uint32_t>(s.edge_flags.size() - 1);
}

void set_edge(Surface& s, std::uint32_t h, std::uint32_t edge) {
  s.edge[h] = edge;
  s.halfedge[edge] = h;
}

void pair(Surface& s, std::uint32_t a, std::uint32_t b) {
  if (a != kNone) s.opposite[a] = b;
  if (b != kNone) s.opposite[b] = a;
}

// Appends the pairs of faces with the same vertices among those of one edge, given by their half-edges in order.
void add_equal(const Surface& s, std::span<const std::uint32_t> uses,
               std::vector<std::array<std::uint32_t, 2>>& equal) {
  for (std::size_t i = 1; i < uses.size(); ++i) {
    std::size_t first = 0;
    while (s.apex(uses[first]) != s.apex(uses[i])) ++first;
    if (first < i) equal.push_back({uses[first] / 3, uses[i] / 3});
  }
}

// Makes the edge or edges that these half-edges form.
void join_uses(Surface& s, std::span<const std::uint32_t> uses) {
  if (uses.size() == 2 && s.origin(uses[0]) == s.target(uses[1])) {
    const std::uint32_t edge = append_edge(s, 0);
    set_edge(s, uses[1], edge);
    set_edge(s, uses[0], edge);
    return pair(s, uses[0], uses[1]);
  }
  std::vector<std::uint32_t> edges;
  for (const std::uint32_t h : uses) {
    edges.push_back(append_edge(s, kFeature | kBoundary));
    set_edge(s, h, edges.back());
    if (uses.size() == 1) return;
    s.set(s.origin(h), kImmovable);
    s.set(s.target(h), kImmovable);
  }
  join_copies(s, edges);
}

std::vector<std::array<std::uint32_t, 2>> join_halfedges(Surface& s, const Progress* progress) {
  std::vector<std::array<std::uint32_t, 2>> equal;
  const Buckets buckets = bucket_halfedges(s);
  s.halfedge.reserve(s.corner.size() / 2 + s.corner.size() / 8);
  s.edge_flags.reserve(s.halfedge.capacity());
  std::vector<std::uint64_t> sorted;  // larger vertex, half-edge
  std::vector<std::uint32_t> uses;
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    stop_if_cancelled(progress);
    sorted.clear();
    for (std::size_t i = buckets.begin[v]; i < buckets.begin[v + 1]; ++i) {
      const std::uint32_t h = buckets.halfedges[i];
      sorted.push_back(std::uint64_t{std::max(s.origin(h), s.target(h))} << 32 | h);
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size();) {
      uses.clear();
      const std::uint64_t high = sorted[i] >> 32;
      for (; i < sorted.size() && sorted[i] >> 32 == high; ++i) uses.push_back(static_cast<std::uint32_t>(sorted[i]));
      join_uses(s, uses);
      add_equal(s, uses, equal);
    }
  }
  std::sort(equal.begin(), equal.end());
  equal.erase(std::unique(equal.begin(), equal.end()), equal.end());
  return equal;
}

// Fixes the vertices whose faces form more than one fan.
void fix_pinched(Surface& s) {
  std::vector<std::uint32_t> faces(s.vertex_count(), 0);
  for (const std::uint32_t v : s.corner) ++faces[v];
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.outgoing[v] == kNone) continue;
    std::uint32_t in_fan = 0;
    s.for_each_outgoing(v, [&](std::uint32_t) { ++in_fan; });
    if (in_fan != faces[v]) s.set(v, kImmovable);
  }
}

std::uint32_t append_face(Surface& s, std::uint32_t face) {
  const auto first = static_cast<std::uint32_t>(s.corner.size());
  s.corner.resize(first + 3, kNone);
  s.opposite.resize(first + 3, kNone);
  s.edge.resize(first + 3, kNone);
  s.face_source.push_back(s.face_source[face]);
  if (!s.quality_before.empty()) s.quality_before.push_back(s.quality_before[face]);
  s.corner_values.resize(first + 3);
  return first;
}

// Moves corner, opposite and edge of half-edge `from` to half-edge `to` of another face.
void move_halfedge(Surface& s, std::uint32_t from, std::uint32_t to) {
  s.corner[to] = s.corner[from];
  set_edge(s, to, s.edge[from]);
  pair(s, to, s.opposite[from]);
  s.corner_values.copy(from, to);
  if (s.outgoing[s.corner[from]] == from) s.outgoing[s.corner[from]] = to;
}

// Splits the face of h at the new vertex m. The face keeps the half of the edge at its origin, a new face gets the
// other half. Returns the half-edge from m in the new face.
std::uint32_t split_side(Surface& s, std::uint32_t h, std::uint32_t m) {
  const std::uint32_t k = append_face(s, h / 3);
  const std::uint32_t n = Surface::next(h);
  const std::uint32_t p = Surface::previous(h);
  s.corner[k] = m;
  s.corner_values.blend(h, n, 0.5, k);
  move_halfedge(s, n, k + 1);
  s.corner[k + 2] = s.corner[p];
  s.corner_values.copy(p, k + 2);
  s.corner[n] = m;
  s.corner_values.copy(k, n);
  const std::uint32_t across = append_edge(s, 0);
  set_edge(s, n, across);
  set_edge(s, k + 2, across);
  pair(s, n, k + 2);
  return k;
}

// Splits the edge of h alone at the new vertex m. Returns the edge of the half at its target.
std::uint32_t split_at(Surface& s, std::uint32_t h, std::uint32_t m) {
  const std::uint32_t o = s.opposite[h];
  const std::uint32_t far = append_edge(s, s.edge_flags[s.edge[h]]);
  const std::uint32_t near = s.edge[h];
  const std::uint32_t k = split_side(s, h, m);
  set_edge(s, k, far);
  set_edge(s, h, near);
  s.outgoing[m] = k;
  if (o == kNone) {
    s.opposite[h] = kNone;
    s.opposite[k] = kNone;
    return far;
  }
  const std::uint32_t l = split_side(s, o, m);
  set_edge(s, l, near);
  set_edge(s, o, far);
  pair(s, h, l);
  pair(s, k, o);
  return far;
}

// Sets the values of the corners around an edge that is collapsed into its target. Corners that have the value of one
// side of the edge get (1 - t) times the value at the target plus t times the value at the origin. Corners beyond
// another seam keep their values.
void blend_corners(Surface& s, std::uint32_t h, double t, std::span<const std::uint32_t> at_a,
                   std::span<const std::uint32_t> at_b) {
  if (s.corner_values.stride == 0) return;
  const std::uint32_t o = s.opposite[h];
  const std::uint32_t left_b = Surface::next(h);
  const std::uint32_t right_a = o == kNone ? h : Surface::next(o);
  const std::uint32_t right_b = o == kNone ? left_b : o;
  const auto same = [&](std::uint32_t c, std::uint32_t d) {
    return std::equal(s.corner_values.of(c).begin(), s.corner_values.of(c).end(), s.corner_values.of(d).begin());
  };
  std::vector<std::uint32_t> left;
  std::vector<std::uint32_t> right;
  const auto sort_in = [&](std::uint32_t c, std::uint32_t of_left, std::uint32_t of_right) {
    if (same(c, of_left)) {
      left.push_back(c);
    } else if (same(c, of_right)) {
      right.push_back(c);
    }
  };
  for (const std::uint32_t c : at_a) sort_in(c, h, right_a);
  for (const std::uint32_t c : at_b) sort_in(c, left_b, right_b);
  Values sides{s.corner_values.stride, {}};
  sides.resize(2);
  for (std::size_t i = 0; i < sides.stride; ++i) {
    const auto mix = [&](std::uint32_t of_b, std::uint32_t of_a) {
      const double from = s.corner_values.of(of_b)[i];
      const double at = s.corner_values.of(of_a)[i];
      return from == at ? from : (1 - t) * from + t * at;
    };
    sides.of(0)[i] = mix(left_b, h);
    sides.of(1)[i] = mix(right_b, right_a);
  }
  for (const std::size_t side : {0, 1}) {
    const std::span<const double> values = sides.of(side);
    for (const std::uint32_t c : side == 0 ? left : right) {
      std::copy(values.begin(), values.end(), s.corner_values.of(c).begin());
    }
  }
}

}  // namespace

void keep_part_quality(Surface& s) {
  s.quality_before.assign(s.face_count(), std::numeric_limits<float>::infinity());
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_of_part(f)) continue;
    int borders = 0;
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h)
      borders += s.edge_has(h, kFeature) || s.edge_has(h, kBend) ? 1 : 0;
    if (borders > 1) s.quality_before[f] = static_cast<float>(quality(s, f, s.before));
  }
}

std::vector<std::array<std::uint32_t, 2>> connect(Surface& s, const Progress* progress) {
  s.opposite.assign(s.corner.size(), kNone);
  s.edge.assign(s.corner.size(), kNone);
  s.halfedge.clear();
  s.edge_flags.clear();
  s.next_copy.clear();
  s.outgoing.assign(s.vertex_count(), kNone);
  s.vertex_flags.resize(s.vertex_count(), 0);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) s.outgoing[s.corner[h]] = h;
  std::vector<std::array<std::uint32_t, 2>> equal = join_halfedges(s, progress);
  stop_if_cancelled(progress);
  fix_pinched(s);
  return equal;
}

void Values::copy(std::size_t from, std::size_t to) {
  for (std::size_t i = 0; i < stride; ++i) numbers[to * stride + i] = numbers[from * stride + i];
}

void Values::blend(std::size_t a, std::size_t b, double t, std::size_t to) {
  for (std::size_t i = 0; i < stride; ++i) {
    const double from = numbers[a * stride + i];
    const double at = numbers[b * stride + i];
    numbers[to * stride + i] = from == at ? from : (1 - t) * from + t * at;
  }
}

Vec3d area_vector(const Surface& surface, std::size_t face, std::span<const Vec3d> positions) {
  const auto [a, b, c] = surface.triangle(face);
  return cross(positions[b] - positions[a], positions[c] - positions[a]);
}

Vec3d star_vector(const Surface& surface, std::uint32_t v) {
  Vec3d sum{};
  surface.for_each_outgoing(v, [&](std::uint32_t h) { sum += area_vector(surface, h / 3, surface.after); });
  return sum;
}

std::uint32_t split(Surface& s, std::uint32_t h, const Vec3d& before, const Vec3d& after) {
  const auto m = static_cast<std::uint32_t>(s.vertex_count());
  const std::uint32_t a = s.origin(h);
  const std::uint32_t b = s.target(h);
  s.before.push_back(before);
  s.after.push_back(after);
  s.vertex_flags.push_back(static_cast<std::uint8_t>((s.vertex_flags[a] | s.vertex_flags[b]) & kRegion));
  s.vertex_values.resize(m + std::size_t{1});
  s.vertex_values.blend(a, b, 0.5, m);
  s.outgoing.push_back(kNone);
  if (!s.has_copies(s.edge[h])) {
    split_at(s, h, m);
    return m;
  }
  s.set(m, kImmovable);
  std::array<std::vector<std::uint32_t>, 2> halves;  // the edges at a, and those at b
  s.for_each_copy(s.edge[h], [&](std::uint32_t near) {
    const std::uint32_t g = s.halfedge[near];
    const std::size_t end = s.origin(g) == a ? 0 : 1;
    halves[end].push_back(near);
    halves[1 - end].push_back(split_at(s, g, m));
  });
  for (const std::vector<std::uint32_t>& edges : halves) join_copies(s, edges);
  return m;
}

void join_copies(Surface& s, std::span<const std::uint32_t> edges) {
  s.next_copy.resize(s.halfedge.size(), kNone);
  for (std::size_t i = 0; i < edges.size(); ++i) s.next_copy[edges[i]] = edges[(i + 1) % edges.size()];
}

void flip(Surface& s, std::uint32_t h) {
  const std::uint32_t o = s.opposite[h];
  // The half-edges h: a -> b, b -> c, c -> a, and o: b -> a, a -> d, d -> b become h: d -> c, c -> a, a -> d, and
  // o: c -> d, d -> b, b -> c.
  const std::array<std::uint32_t, 6> slots{h, Surface::next(h), Surface::previous(h),
                                           o, Surface::next(o), Surface::previous(o)};
  constexpr std::array<std::size_t, 6> from{5, 2, 4, 2, 5, 1};  // the slot whose corner each slot gets
  struct Outer {
    std::uint32_t corner, opposite, edge;
  };
  std::array<Outer, 6> was{};
  std::vector<double> values;
  for (std::size_t i = 0; i < 6; ++i) {
    was[i] = {s.corner[slots[i]], s.opposite[slots[i]], s.edge[slots[i]]};
    const std::span<const double> row = s.corner_values.of(slots[i]);
    values.insert(values.end(), row.begin(), row.end());
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const std::uint32_t to = slots[i];
    const Outer& source = was[from[i]];
    s.corner[to] = source.corner;
    s.outgoing[source.corner] = to;
    const auto row = values.begin() + static_cast<std::ptrdiff_t>(from[i] * s.corner_values.stride);
    std::copy(row, row + static_cast<std::ptrdiff_t>(s.corner_values.stride), s.corner_values.of(to).begin());
    if (i % 3 == 0) continue;  // the diagonal itself
    set_edge(s, to, source.edge);
    pair(s, to, source.opposite);
  }
}

bool can_collapse(const Surface& s, std::uint32_t h) {
  const std::uint32_t a = s.origin(h);
  const std::uint32_t b = s.target(h);
  const std::uint32_t o = s.opposite[h];
  const std::array<std::uint32_t, 2> apexes{s.apex(h), o == kNone ? kNone : s.apex(o)};
  std::array<std::uint32_t, 64> ring{};
  std::size_t count = 0;
  bool a_on_boundary = false;
  bool b_on_boundary = false;
  const auto visit_ring = [&](std::uint32_t v, bool& on_boundary, auto visit) {
    s.for_each_outgoing(v, [&](std::uint32_t e) {
      visit(s.target(e));
      if (s.opposite[e] == kNone) on_boundary = true;
      if (s.opposite[Surface::previous(e)] != kNone) return;
      on_boundary = true;
      visit(s.apex(e));
    });
  };
  visit_ring(a, a_on_boundary, [&](std::uint32_t v) {
    if (count < ring.size()) ring[count] = v;
    ++count;
  });
  if (count > ring.size()) return false;
  std::size_t common = 0;
  std::size_t b_count = 0;
  bool linked = true;
  visit_ring(b, b_on_boundary, [&](std::uint32_t v) {
    ++b_count;
    if (std::find(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(count), v) ==
        ring.begin() + static_cast<std::ptrdiff_t>(count)) {
      return;
    }
    ++common;
    linked = linked && (v == apexes[0] || v == apexes[1]);
  });
  const std::size_t faces = o == kNone ? 1 : 2;
  if (!linked || common != faces) return false;
  if (o != kNone && (a_on_boundary || b_on_boundary)) return false;
  if (count + b_count < 5 + faces) return false;  // the remaining vertex keeps at least three neighbours
  // An apex must keep three faces, and each of its edges at least one.
  for (const std::uint32_t e : {h, o}) {
    if (e == kNone) continue;
    if (s.opposite[Surface::next(e)] == kNone && s.opposite[Surface::previous(e)] == kNone) return false;
    std::size_t degree = 0;
    s.for_each_outgoing(s.apex(e), [&](std::uint32_t) { ++degree; });
    if (degree < 4) return false;
  }
  return true;
}

void collapse(Surface& s, std::uint32_t h, const Vec3d& after, double t) {
  const std::uint32_t a = s.origin(h);
  const std::uint32_t b = s.target(h);
  s.halfedge[s.edge[h]] = kNone;
  s.vertex_values.blend(b, a, t, b);
  std::vector<std::uint32_t> at_a;
  std::vector<std::uint32_t> at_b;
  s.for_each_outgoing(a, [&](std::uint32_t e) { at_a.push_back(e); });
  s.for_each_outgoing(b, [&](std::uint32_t e) { at_b.push_back(e); });
  const std::uint32_t o = s.opposite[h];
  blend_corners(s, h, t, at_a, at_b);
  for (const std::uint32_t e : at_a) s.corner[e] = b;
  const auto remove_face = [&](std::uint32_t e) {
    const std::uint32_t n = Surface::next(e);
    const std::uint32_t p = Surface::previous(e);
    const std::uint32_t x = s.opposite[n];
    const std::uint32_t y = s.opposite[p];
    const std::uint32_t kept_edge = s.edge[p];
    const std::uint32_t gone_edge = s.edge[n];
    s.edge_flags[kept_edge] = static_cast<std::uint8_t>(s.edge_flags[kept_edge] | s.edge_flags[gone_edge]);
    s.halfedge[gone_edge] = kNone;
    pair(s, x, y);
    for (const std::uint32_t kept : {x, y}) {
      if (kept == kNone) continue;
      set_edge(s, kept, kept_edge);
      s.outgoing[s.corner[kept]] = kept;
      s.outgoing[s.corner[Surface::next(kept)]] = Surface::next(kept);
    }
    for (const std::uint32_t gone : {e, n, p}) {
      s.corner[gone] = kNone;
      s.opposite[gone] = kNone;
    }
  };
  remove_face(h);
  if (o != kNone) remove_face(o);
  s.vertex_flags[b] = static_cast<std::uint8_t>(s.vertex_flags[b] | (s.vertex_flags[a] & (kMoved | kRegion)));
  s.set(a, kRemoved);
  s.outgoing[a] = kNone;
  s.after[b] = after;
}

bool turns(double cosine, const Vec3d& reference, double reference2, const Vec3d& is, double is2) {
  constexpr double far = 1 + 1e-12;  // above rounding errors
  const double along = dot(reference, is);
  const double sizes2 = reference2 * is2;
  const double limit2 = cosine * cosine * sizes2;
  if (along > 0 && (cosine <= 0 || along * along > limit2 * far)) return !(is2 > 0);  // most cases need no root
  return !(along >= cosine * std::sqrt(sizes2)) || !(is2 > 0);
}

bool turns(const TurnLimit& limit, const Vec3d& was, const Vec3d& is, double quality_was, const Vec3d& mean) {
  const Vec3d& reference = quality_was < limit.reliable ? mean : was;
  return turns(limit.cosine, reference, norm2(reference), is, norm2(is));
}

double star_quality(const Surface& s, std::uint32_t v, const Vec3d& p, const TurnLimit& limit) {
  const Vec3d mean = star_vector(s, v);
  double least = kInfinity;
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
  double greatest = 0;
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    if (quality(s, h / 3, s.after) < kMinReliableQuality) return;
    const Vec3d n = area_vector(s, h / 3, s.after);
    greatest = std::max(greatest, std::abs(dot(n, p - s.after[v])) / norm(n));
  });
  return greatest;
}

void Star::begin(const Vec3d& position) {
  position_ = position;
  vector_ = {};
  sum_ = {};
  faces_.clear();
}

void Star::add(const Surface& s, std::uint32_t h, double quality) {
  const Vec3d& b = s.after[s.target(h)];
  const Vec3d& c = s.after[s.apex(h)];
  const Vec3d n = area_vector(s, h / 3, s.after);
  vector_ += n;
  sum_ += b;
  faces_.push_back({b, c, n, norm2(n), norm2(c - b), quality});
}

double Star::quality_at(const Vec3d& p, const TurnLimit& limit, double floor) const {
  const double vector2 = norm2(vector_);
  double least = kInfinity;
  for (const Face& face : faces_) {
    const Vec3d b = face.b - p;
    const Vec3d c = face.c - p;
    const Vec3d normal = cross(b, c);
    const double size2 = norm2(normal);
    const bool is_thin = face.quality < limit.reliable;
    if (turns(limit.cosine, is_thin ? vector_ : face.normal, is_thin ? vector2 : face.size2, normal, size2)) return -1;
    least = std::min(least, quality_of(size2, norm2(b), face.beyond2, norm2(c)));
    if (least <= floor) break;
  }
  return least;
}

// While the vertex stays, only thin faces may turn. The known quality of a face has a rounding error that depends on
// the order of the corners, so the faces that may be the least are measured again from the vertex.
double Star::least() const {
  constexpr double margin = 1e-9;  // far above rounding
  double known = kInfinity;
  for (const Face& face : faces_) known = std::min(known, face.quality);
  if (!(known > 2 * kMinReliableQuality)) return quality_at(position_, {}, -2);
  double least = kInfinity;
  for (const Face& face : faces_) {
    if (face.quality <= known + margin) least = std::min(least, detail::quality(position_, face.b, face.c));
  }
  return least;
}

bool Star::is_farther(const Vec3d& p, double distance) const {
  const Vec3d d = p - position_;
  return std::any_of(faces_.begin(), faces_.end(), [&](const Face& face) {
    return face.quality >= kMinReliableQuality && std::abs(dot(face.normal, d)) / std::sqrt(face.size2) > distance;
  });
}

bool is_crowded(const Surface& s, std::uint32_t v) {
  int count = 0;
  return !s.all_outgoing(v, [&](std::uint32_t) { return ++count <= kMaxFacesOfVertex; });
}

bool are_neighbours(const Surface& s, std::uint32_t v, std::uint32_t w) {
  if (s.has(v, kImmovable)) std::swap(v, w);
  bool found = s.has(v, kImmovable);
  s.for_each_outgoing(v, [&](std::uint32_t h) { found = found || s.target(h) == w || s.apex(h) == w; });
  return found;
}
}  // namespace knead::detail
