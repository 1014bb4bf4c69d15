// Finds flat faces by the planes of their triangles, and decides which of them belong to a part.
#include "remesh/facets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/elementary.h"
#include "mesh/edges.h"

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

}  // namespace knead::detail
