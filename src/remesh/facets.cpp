// Finds flat faces by the planes of their triangles, and decides which of them belong to a part.
#include "remesh/facets.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

#include "math/elementary.h"
#include "mesh/edges.h"
#include "remesh/improve.h"

namespace knead::detail {

namespace {

constexpr double kFloatRounding = 4 * 0x1p-24;  // of four points, relative to the greatest coordinate
constexpr double kFlatShare = 1e-7;             // of the diagonal
constexpr double kMinHeightFactor = 4;          // of the tolerance: a lower triangle has no plane
constexpr int kMaxPlanelessRun = 4;             // triangles without a plane in a row
constexpr std::size_t kMinFacetTriangles = 3;   // two may be a quadrilateral of a curved grid
const double kNarrowQuality = elementary::tan(std::numbers::pi / 12);

// Returns the face, or, if its corners lie on a line, the next one beyond longest edges that has a plane.
std::uint32_t face_with_plane(const Surface& s, std::uint32_t f, double tolerance) {
  for (int step = 0; step < kMaxPlanelessRun; ++step) {
    const std::uint32_t longest = longest_edge(s, f, s.before);
    const double length2 = norm2(s.before[s.target(longest)] - s.before[s.origin(longest)]);
    const double min_height = kMinHeightFactor * tolerance;
    const bool has_plane = norm2(area_vector(s, f, s.before)) > min_height * min_height * length2;
    if (has_plane || s.opposite[longest] == kNone) return f;
    f = s.opposite[longest] / 3;
  }
  return f;
}

struct Planes {
  std::vector<std::uint32_t> face;  // of each face: the one whose plane it has
  std::vector<Vec3d> normal;        // of each face; zero without a plane
  double tolerance = 0;
};

Planes find_planes(const Surface& s, double tolerance, const Progress* progress) {
  Planes planes{std::vector<std::uint32_t>(s.face_count()), std::vector<Vec3d>(s.face_count()), tolerance};
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    stop_if_cancelled(progress);
    planes.face[f] = face_with_plane(s, f, planes.tolerance);
    const Vec3d n = area_vector(s, f, s.before);
    if (norm2(n) > 0) planes.normal[f] = normalized(n);
  }
  return planes;
}

// Returns true if face f lies in the plane of face g.
bool lies_in(const Surface& s, const Planes& planes, std::uint32_t f, std::uint32_t g) {
  const Vec3d& origin = s.before[s.corner[3 * std::size_t{g}]];
  const Triangle t = s.triangle(f);
  return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
    return std::abs(dot(planes.normal[g], s.before[v] - origin)) <= planes.tolerance;
  });
}

// A set of triangles in one plane.
struct Facet {
  std::size_t triangles = 0;
  bool is_narrow = false;
  bool has_crease = false;

  // Curved surfaces have single flat triangles and quadrilaterals, too.
  bool is_of_part() const { return triangles >= kMinFacetTriangles || (is_narrow && (triangles > 1 || has_crease)); }
};

constexpr double kDelaunayMargin = 1e-10;        // of the sine of two angles: above rounding
constexpr double kSameValue = 1e-6;              // of attributes, relative
constexpr double kNoValue = 1e-9;                // smaller ones are equal to kSameValue of this
constexpr std::size_t kMaxFlatFaceGrowth = 8;    // factor by which good triangles may increase the number of faces
constexpr std::size_t kFewFlatFaces = 1000;      // added before that factor
constexpr std::size_t kMaxStripTriangles = 8;    // a flat face of more has fine edges opposite to long ones
const double kBesideEdge = -0.5 * std::sqrt(3);  // cosine of 150 degrees: a vertex that sees an edge so is too near it

// Divides the flat faces of parts. A triangle is thin below kNarrowQuality.
class FlatFaces {
 public:
  FlatFaces(Surface& s, const Improvement& task, double max_edge)
      : s_(s),
        task_(task),
        max_edge2_(max_edge * max_edge),
        flips_(s),
        max_faces_(kMaxFlatFaceGrowth * (s.face_count() + kFewFlatFaces)),
        is_strip_(s.of_part.size(), 0) {
    DisjointSets sets(s.face_count());
    for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
      if (!flips_.is_border(h)) sets.join(h / 3, s.opposite[h] / 3);
    }
    std::vector<std::size_t> triangles(s.face_count(), 0);
    for (std::uint32_t f = 0; f < s.face_count(); ++f) ++triangles[sets.find(f)];
    for (std::uint32_t f = 0; f < s.face_count(); ++f) {
      if (s.is_of_part(f)) is_strip_[s.face_source[f]] = triangles[sets.find(f)] > kMaxStripTriangles ? 0 : 1;
    }
  }

  ImprovementCounts divide() {
    if (!has_room()) return {};
    for (std::uint32_t f = 0; f < s_.face_count(); ++f) add_if_bad(f);
    while (!bad_.empty() && s_.vertex_count() < task_.targets.max_vertices) {
      stop_if_cancelled(task_.progress);
      if (task_.deadline != nullptr && task_.deadline->is_over()) break;
      const auto [length2, f] = bad_.top();
      bad_.pop();
      if (length2_of(longest_edge(s_, f, s_.after)) != length2) continue;  // it is in the queue again
      flips_.unsettle(f);
      const bool has_changed = settle() || split_beside(f);
      if (has_changed) add_if_bad(f);
    }
    return counts_;
  }

 private:
  double length2_of(std::uint32_t h) const { return norm2(s_.after[s_.target(h)] - s_.after[s_.origin(h)]); }

  // Returns false if the faces need more vertices than there may be, even in equilateral triangles.
  bool has_room() const {
    double area = 0;
    for (std::size_t f = 0; f < s_.face_count(); ++f) {
      if (s_.is_of_part(f)) area += 0.5 * norm(area_vector(s_, f, s_.after));
    }
    return 2 * area <= static_cast<double>(task_.targets.max_vertices) * std::sqrt(3.0) * max_edge2_;
  }

  void add_if_bad(std::uint32_t f) {
    if (!s_.is_of_part(f)) return;
    const double length2 = length2_of(longest_edge(s_, f, s_.after));
    const bool is_thin = s_.face_count() < max_faces_ && quality(s_, f, s_.after) < kNarrowQuality;
    if (length2 > max_edge2_ || is_thin) bad_.emplace(length2, f);
  }

  bool settle() {
    const std::size_t flips = flips_.settle([&](std::uint32_t h) {
      add_if_bad(h / 3);
      add_if_bad(s_.opposite[h] / 3);
    });
    counts_.flips += flips;
    return flips > 0;
  }

  // A short edge is not split for the sake of good triangles; neither is one whose middle would be close to an edge
  // between faces, nor one at the border of a strip: the strips of a finely divided cylinder would divide each other
  // all around.
  bool may_split(std::uint32_t h) const {
    const bool is_still = !s_.has(s_.origin(h), kRegion) || !s_.has(s_.target(h), kRegion);
    if (is_still || s_.edge_has(h, kLocked)) return false;
    if (length2_of(h) > max_edge2_) return true;
    const double shortest = 2 * task_.targets.max_chord;
    if (length2_of(h) < shortest * shortest) return false;
    if (flips_.is_border(h)) {
      const bool is_alone = s_.opposite[h] == kNone || !s_.is_of_part(s_.opposite[h] / 3) || !s_.is_of_part(h / 3);
      if (is_alone || is_strip_[s_.face_source[h / 3]] != 0) return false;
    }
    const Vec3d middle = (s_.after[s_.origin(h)] + s_.after[s_.target(h)]) * 0.5;
    const auto is_beside = [&](std::uint32_t side) {
      const Vec3d a = s_.after[s_.origin(side)] - middle;
      const Vec3d b = s_.after[s_.target(side)] - middle;
      return flips_.is_border(side) && dot(a, b) < kBesideEdge * std::sqrt(norm2(a) * norm2(b));
    };
    const std::uint32_t o = s_.opposite[h];
    return !is_beside(Surface::next(h)) && !is_beside(Surface::previous(h)) && !is_beside(Surface::next(o)) &&
           !is_beside(Surface::previous(o));
  }

  // Splits the edge where the path of longer and longer edges from the face ends. Returns true if it did.
  bool split_beside(std::uint32_t f) {
    std::uint32_t h = longest_edge(s_, f, s_.after);
    while (!flips_.is_border(h)) {
      const std::uint32_t next = longest_edge(s_, s_.opposite[h] / 3, s_.after);
      if (!(length2_of(next) > length2_of(h))) break;
      h = next;
    }
    if (!may_split(h)) return false;
    std::vector<std::uint32_t> changed;
    s_.for_each_copy(s_.edge[h], [&](std::uint32_t e) {
      changed.push_back(s_.halfedge[e] / 3);
      if (s_.opposite[s_.halfedge[e]] != kNone) changed.push_back(s_.opposite[s_.halfedge[e]] / 3);
    });
    for (std::size_t i = changed.size(), first = s_.face_count(); i > 0; --i)
      changed.push_back(static_cast<std::uint32_t>(first++));
    const Vec3d middle = (s_.after[s_.origin(h)] + s_.after[s_.target(h)]) * 0.5;
    s_.set(split(s_, h, middle, middle), kMoved);
    ++counts_.splits;
    for (const std::uint32_t face : changed) {
      flips_.unsettle(face);
      add_if_bad(face);
    }
    settle();
    return true;
  }

  Surface& s_;
  const Improvement& task_;
  double max_edge2_;
  FlatFlips flips_;
  std::size_t max_faces_;
  std::vector<std::uint8_t> is_strip_;                         // of each face_source: 1 if its flat face is one
  std::priority_queue<std::pair<double, std::uint32_t>> bad_;  // square of the longest edge, and face
  ImprovementCounts counts_;
};

}  // namespace

double plane_tolerance(std::span<const Vec3d> positions) {
  const Box box = bounding_box(positions);
  double greatest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    greatest = std::max({greatest, std::abs(box.min[axis]), std::abs(box.max[axis])});
  }
  return kFloatRounding * greatest + kFlatShare * box.diagonal();
}

std::vector<Bend> find_bends(const Surface& s, double angle_deg, double tolerance, const Progress* progress) {
  const Planes planes = find_planes(s, tolerance, progress);
  const double sharp_cosine = elementary::cos(angle_deg * std::numbers::pi / 180);
  std::vector<Bend> bends(s.halfedge.size(), Bend::open);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (s.opposite[h] == kNone || s.opposite[h] < h) continue;
    const std::uint32_t f = planes.face[h / 3];
    const std::uint32_t g = planes.face[s.opposite[h] / 3];
    const double cosine = dot(planes.normal[f], planes.normal[g]);
    const bool is_flat = f == g || (cosine > 0 && (lies_in(s, planes, f, g) || lies_in(s, planes, g, f)));
    bends[s.edge[h]] = is_flat ? Bend::flat : cosine < sharp_cosine ? Bend::sharp : Bend::soft;
  }
  return bends;
}

std::vector<std::uint8_t> add_edges_of_parts(const Surface& s, const std::vector<Bend>& bends,
                                             std::vector<std::uint8_t>& creases) {
  DisjointSets sets(s.face_count());
  std::vector<int> excess(s.vertex_count(), 0);  // of each vertex: soft edges minus flat and sharp ones
  for (std::size_t e = 0; e < bends.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (bends[e] == Bend::flat) {
      sets.join(h / 3, s.opposite[h] / 3);
      creases[e] = 0;
    }
    for (const std::uint32_t v : {s.origin(h), s.target(h)}) excess[v] += bends[e] == Bend::soft ? 1 : -1;
  }
  std::vector<Facet> facets(s.face_count());
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    Facet& facet = facets[sets.find(f)];
    ++facet.triangles;
    facet.is_narrow = facet.is_narrow || quality(s, f, s.before) < kNarrowQuality;
  }
  const auto facet_of = [&](std::uint32_t h) -> Facet& { return facets[sets.find(h / 3)]; };
  std::vector<std::uint8_t> on_crease(s.vertex_count(), 0);
  for (std::size_t e = 0; e < bends.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (bends[e] == Bend::sharp) {
      const bool is_between_faces = facet_of(h).triangles > 1 && facet_of(s.opposite[h]).triangles > 1;
      if (is_between_faces || excess[s.origin(h)] + excess[s.target(h)] <= 0) creases[e] = 1;
    }
    if (creases[e] == 0) continue;
    on_crease[s.origin(h)] = on_crease[s.target(h)] = 1;
    for (const std::uint32_t side : {h, s.opposite[h]}) {
      if (side != kNone) facet_of(side).has_crease = true;
    }
  }
  for (std::size_t e = 0; e < bends.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (bends[e] != Bend::soft) continue;
    const bool is_of_part = facet_of(h).is_of_part() || facet_of(s.opposite[h]).is_of_part();
    if (is_of_part || (on_crease[s.origin(h)] & on_crease[s.target(h)]) != 0) creases[e] = 1;
  }
  std::vector<std::uint8_t> of_part(s.face_count());
  for (std::uint32_t f = 0; f < s.face_count(); ++f) of_part[f] = facets[sets.find(f)].is_of_part() ? 1 : 0;
  return of_part;
}

bool FlatFlips::is_border(std::uint32_t h) const {
  constexpr int kStays = kFeature | kBoundary | kLocked | kBend;
  return s_.opposite[h] == kNone || (s_.edge_flags[s_.edge[h]] & kStays) != 0;
}

// Returns true if the angles opposite to the edge are more than half a turn, and its two faces lie in one plane.
bool FlatFlips::gains_by_flip(std::uint32_t h) const {
  const std::uint32_t o = s_.opposite[h];
  if (is_border(h) || !s_.is_of_part(h / 3) || !s_.is_of_part(o / 3)) return false;
  const std::array<std::uint32_t, 4> v{s_.origin(h), s_.target(h), s_.apex(h), s_.apex(o)};
  const Vec3d& c = s_.before[v[2]];
  const Vec3d& d = s_.before[v[3]];
  const Vec3d ca = s_.before[v[0]] - c;
  const Vec3d cb = s_.before[v[1]] - c;
  const Vec3d da = s_.before[v[0]] - d;
  const Vec3d db = s_.before[v[1]] - d;
  const Vec3d normal = normalized(cross(ca, cb) + cross(db, da));
  const double sine_c = dot(cross(ca, cb), normal);
  const double sine_d = dot(cross(db, da), normal);
  const double sizes = std::sqrt(norm2(ca) * norm2(cb) * norm2(da) * norm2(db));
  if (!(sine_c * dot(da, db) + sine_d * dot(ca, cb) < -kDelaunayMargin * sizes)) return false;
  if (!(dot(cross(c - d, da), normal) > 0 && dot(cross(d - c, cb), normal) > 0)) return false;
  const Vec3d across = cross(ca - cb, d - c);
  if (std::abs(dot(across, ca)) > tolerance_ * norm(across)) return false;
  if (!std::all_of(v.begin(), v.end(), [&](std::uint32_t w) { return s_.has(w, kRegion); })) return false;
  return v[2] != v[3] && !are_neighbours(s_, v[2], v[3]) && keeps_values(h);
}

// Returns true if the values of attributes at the two faces of an edge are those of one linear function.
bool FlatFlips::keeps_values(std::uint32_t h) const {
  if (s_.vertex_values.stride + s_.corner_values.stride == 0) return true;
  const std::uint32_t o = s_.opposite[h];
  const std::array<std::uint32_t, 4> corners{h, Surface::next(h), Surface::previous(h), Surface::previous(o)};
  std::array<Vec3d, 4> p{};
  std::transform(corners.begin(), corners.end(), p.begin(), [&](std::uint32_t k) { return s_.before[s_.corner[k]]; });
  const Vec3d normal = cross(p[1] - p[0], p[2] - p[0]);
  const auto share = [&](std::size_t i) {
    return dot(cross(p[(i + 1) % 3] - p[3], p[(i + 2) % 3] - p[3]), normal) / norm2(normal);
  };
  const std::array<double, 3> shares{share(0), share(1), share(2)};
  const auto are_linear = [&](const Values& values, const auto& row_of) {
    for (std::size_t i = 0; i < values.stride; ++i) {
      double expected = 0;
      double size = kNoValue;
      for (std::size_t k = 0; k < 3; ++k) {
        const double value = values.of(row_of(corners[k]))[i];
        expected += shares[k] * value;
        size += std::abs(shares[k] * value);
      }
      if (!(std::abs(values.of(row_of(corners[3]))[i] - expected) <= kSameValue * size)) return false;
    }
    return true;
  };
  return are_linear(s_.vertex_values, [&](std::uint32_t k) { return s_.corner[k]; }) &&
         are_linear(s_.corner_values, [](std::uint32_t k) { return k; });
}

ImprovementCounts divide_flat_faces(Surface& s, const Improvement& improvement, double max_edge) {
  return FlatFaces(s, improvement, max_edge).divide();
}

}  // namespace knead::detail
