// A triangle mesh that can be split, flipped and collapsed, with positions before and after a deformation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"

namespace knead::detail {

inline constexpr std::uint32_t kNone = 0xffffffffu;

// Attribute values of vertices or corners: `stride` numbers for each.
struct Values {
  std::size_t stride = 0;
  std::vector<double> numbers;

  std::span<double> of(std::size_t i) { return {numbers.data() + i * stride, stride}; }
  std::span<const double> of(std::size_t i) const { return {numbers.data() + i * stride, stride}; }
  void resize(std::size_t count) { numbers.resize(count * stride); }
  void copy(std::size_t from, std::size_t to);
  // Sets `to` to (1 - t) a + t b.
  void blend(std::size_t a, std::size_t b, double t, std::size_t to);
};

enum EdgeFlag : std::uint8_t {
  kFeature = 1,   // a crease, a boundary or a seam: neither flipped nor smoothed across
  kBoundary = 2,  // has one face: may be split, but is never collapsed, so that coincident boundaries stay together
  kLocked = 4,    // never split: also has faces outside this surface
  kSeam = 8,      // a feature across which values or labels differ
  kCrease = 16,   // a feature of the shape
  kBend = 32,     // its two faces are not in one plane before the deformation
};

enum VertexFlag : std::uint8_t {
  kImmovable = 1,  // must not be moved or removed
  kMoved = 2,      // the deformation moves the surface there
  kRegion = 4,     // triangles here may be improved
  kRemoved = 8,    // by a collapse
};

// A half-edge mesh of triangles. Half-edge 3 f + i of face f goes from its corner i to the next corner. The corners of
// a removed face are kNone. An edge keeps its number while its half-edges change; when it is split, the half at the
// origin keeps the number.
struct Surface {
  std::vector<std::uint32_t> corner;     // of each half-edge: the vertex where it begins
  std::vector<std::uint32_t> opposite;   // of each half-edge; kNone at a boundary
  std::vector<std::uint32_t> edge;       // of each half-edge: its edge
  std::vector<std::uint32_t> halfedge;   // of each edge: one of its half-edges, kNone for a removed edge
  std::vector<std::uint8_t> edge_flags;  // of each edge
  // Copies of edges: where more than two faces meet, or two that disagree about which side is outside, each face has an
  // edge of its own. For each edge: the next of its copies, in a ring, or kNone. Empty if no edge has copies.
  std::vector<std::uint32_t> next_copy;
  std::vector<std::uint32_t> face_source;  // of each face: a number given by the caller; splits inherit it
  std::vector<std::uint32_t> outgoing;     // of each vertex: a half-edge that begins there
  std::vector<std::uint8_t> vertex_flags;  // of each vertex
  std::vector<std::uint8_t> of_part;       // of each face_source: 1 for a flat face of a part (facets.h); or empty
  std::vector<float> quality_before;       // of each face, see keep_part_quality(); or empty
  std::vector<Vec3d> before;               // of each vertex; meaningless after triangles are improved
  std::vector<Vec3d> after;
  Values vertex_values;
  Values corner_values;
  bool has_attributes = false;  // other values than places

  std::size_t face_count() const { return face_source.size(); }
  std::size_t vertex_count() const { return after.size(); }
  bool has_copies(std::uint32_t e) const { return !next_copy.empty() && next_copy[e] != kNone; }
  bool is_alive(std::size_t face) const { return corner[3 * face] != kNone; }
  bool is_of_part(std::size_t face) const {
    return face_source[face] < of_part.size() && of_part[face_source[face]] != 0;
  }
  std::uint32_t origin(std::uint32_t h) const { return corner[h]; }
  std::uint32_t target(std::uint32_t h) const { return corner[next(h)]; }
  std::uint32_t apex(std::uint32_t h) const { return corner[previous(h)]; }

  static constexpr std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static constexpr std::uint32_t previous(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

  std::array<std::uint32_t, 3> triangle(std::size_t f) const {
    return {corner[3 * f], corner[3 * f + 1], corner[3 * f + 2]};
  }

  // Calls visit(c) for the edge and its copies.
  template <class Visit>
  void for_each_copy(std::uint32_t e, Visit visit) const {
    std::uint32_t c = e;
    do {
      const std::uint32_t next = has_copies(c) ? next_copy[c] : e;
      visit(c);
      c = next;
    } while (c != e);
  }

  // Returns the copy with the lowest number, which represents all.
  std::uint32_t first_copy(std::uint32_t e) const {
    std::uint32_t first = e;
    for_each_copy(e, [&](std::uint32_t c) { first = std::min(first, c); });
    return first;
  }

  // Calls visit(h) for the half-edges of one fan that begin at v.
  template <class Visit>
  void for_each_outgoing(std::uint32_t v, Visit visit) const {
    all_outgoing(v, [&](std::uint32_t h) {
      visit(h);
      return true;
    });
  }

  // Calls visit(h) as for_each_outgoing() does, until it returns false. Returns true if it never did.
  template <class Visit>
  bool all_outgoing(std::uint32_t v, Visit visit) const {
    const std::uint32_t first = outgoing[v];
    std::uint32_t h = first;
    do {
      if (!visit(h)) return false;
      h = opposite[previous(h)];
    } while (h != kNone && h != first);
    if (h == first) return true;
    for (h = opposite[first]; h != kNone; h = opposite[h]) {
      h = next(h);
      if (!visit(h)) return false;
    }
    return true;
  }

  bool has(std::uint32_t v, VertexFlag flag) const { return (vertex_flags[v] & flag) != 0; }
  bool edge_has(std::uint32_t h, EdgeFlag flag) const { return (edge_flags[edge[h]] & flag) != 0; }  // of a half-edge
  void set(std::uint32_t v, VertexFlag flag) { vertex_flags[v] = static_cast<std::uint8_t>(vertex_flags[v] | flag); }
  void set_edge(std::uint32_t h, EdgeFlag flag) {
    edge_flags[edge[h]] = static_cast<std::uint8_t>(edge_flags[edge[h]] | flag);
  }
};

// Remembers the quality, in the surface before, of those faces of parts that have two edges between flat faces, such as
// the wall of a finely divided cylinder. Hardly any change helps them, so improving leaves them alone unless the
// deformation made them worse. Splits inherit it.
void keep_part_quality(Surface& surface);

// Makes these edges copies of each other.
void join_copies(Surface& surface, std::span<const std::uint32_t> edges);

// Computes connectivity and flags from the corners. Boundary edges become features. An edge with more than two faces,
// or with two faces of opposite orientation, becomes a boundary for each face: copies with fixed ends. Vertices with
// several fans become fixed. Returns the pairs of faces with the same vertices, the lower number first. `progress`
// cancels.
std::vector<std::array<std::uint32_t, 2>> connect(Surface& surface, const Progress* progress = nullptr);

// Returns twice the area of the face times its normal.
Vec3d area_vector(const Surface& surface, std::size_t face, std::span<const Vec3d> positions);

// Returns the sum of the area vectors of the faces around v. If v moves by d, the volume grows by dot(star, d) / 6.
Vec3d star_vector(const Surface& surface, std::uint32_t v);

// Splits the edge of half-edge h, and its copies at the same vertex. The new vertex gets the given positions and the
// mean values. Returns its number.
std::uint32_t split(Surface& surface, std::uint32_t h, const Vec3d& before, const Vec3d& after);

// Replaces the edge of h, which must have two faces, by the other diagonal of their quadrilateral. h and its opposite
// become the half-edges of that diagonal. Values of corners stay with their vertices.
void flip(Surface& surface, std::uint32_t h);

// Returns true if collapsing the edge of h keeps the surface manifold and its topology (link condition; Dey et al.
// 1999).
bool can_collapse(const Surface& surface, std::uint32_t h);

// Collapses the edge of h: removes its origin and moves its target to `after`. The values of the target become (1 - t)
// times its own plus t times those of the origin, separately for each side of a seam.
void collapse(Surface& surface, std::uint32_t h, const Vec3d& after, double t);

// Returns the tangent of the smallest angle of a triangle by the squares of twice its area and of its sides, in any
// order; 0 if it has no area.
inline double quality_of(double size2, double p, double q, double r) {
  if (p > q) std::swap(p, q);
  if (p > r) std::swap(p, r);
  const double twice_cosine = q + r - p;  // times the two longer edges
  return twice_cosine > 0 ? 2 * std::sqrt(size2) / twice_cosine : 0.0;
}

// Returns this tangent for a triangle with these corners.
inline double quality(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a;
  const Vec3d ac = c - a;
  return quality_of(norm2(cross(ab, ac)), norm2(ab), norm2(c - b), norm2(ac));
}

inline double quality(const Surface& s, std::size_t face, std::span<const Vec3d> positions) {
  const auto [a, b, c] = s.triangle(face);
  return quality(positions[a], positions[b], positions[c]);
}

// Returns the half-edge of the longest edge of the face.
inline std::uint32_t longest_edge(const Surface& s, std::size_t face, std::span<const Vec3d> positions) {
  const auto first = static_cast<std::uint32_t>(3 * face);
  std::uint32_t longest = first;
  double longest2 = -1;
  for (std::uint32_t h = first; h < first + 3; ++h) {
    const double length2 = norm2(positions[s.target(h)] - positions[s.origin(h)]);
    if (length2 > longest2) {
      longest2 = length2;
      longest = h;
    }
  }
  return longest;
}

// Below this quality (3 degrees) the normal of a triangle is unreliable.
inline const double kMinReliableQuality = elementary::tan(std::numbers::pi / 60);

// The largest angle by which a change may turn a face, measured from the old normal of the face; if the quality of the
// face is below `reliable`, from the mean normal around it.
struct TurnLimit {
  double cosine = -1;  // of the largest angle
  double reliable = kMinReliableQuality;
};

// Returns true if a face with normal `was` and quality `quality_was` turns too far when its normal becomes `is`.
bool turns(const TurnLimit& limit, const Vec3d& was, const Vec3d& is, double quality_was, const Vec3d& mean);

// Does this for a known normal to measure from; `reference2` and `is2` are the squared lengths of both vectors.
bool turns(double cosine, const Vec3d& reference, double reference2, const Vec3d& is, double is2);

// Returns the least quality of the faces around v if v were at p; negative if one of them would turn too far.
double star_quality(const Surface& s, std::uint32_t v, const Vec3d& p, const TurnLimit& limit);

// Returns the largest distance of p from the planes of the faces around v. Thin faces are ignored.
double plane_distance(const Surface& s, std::uint32_t v, const Vec3d& p);

// The faces around a vertex, read once to judge many positions of it.
class Star {
 public:
  // Begins with a vertex at this position and no faces.
  void begin(const Vec3d& position);
  // Adds the face of a half-edge that begins at the vertex, and its quality. The order is that of for_each_outgoing().
  void add(const Surface& s, std::uint32_t h, double quality);

  // Returns star_vector() of the vertex.
  const Vec3d& vector() const { return vector_; }
  // Returns the mean of its neighbours.
  Vec3d mean() const { return sum_ / static_cast<double>(faces_.size()); }

  // Returns star_quality() at the vertex's own position, without a limit on turns.
  double least() const;

  // Returns star_quality() at p if that is above `floor`; else any number that is not above it.
  double quality_at(const Vec3d& p, const TurnLimit& limit, double floor) const;

  // Returns true if plane_distance() of p is greater than `distance`.
  bool is_farther(const Vec3d& p, double distance) const;

 private:
  struct Face {
    Vec3d b;  // the corners beside the vertex
    Vec3d c;
    Vec3d normal;        // the area vector
    double size2 = 0;    // the square of its length
    double beyond2 = 0;  // the squared length of the edge opposite to the vertex
    double quality = 0;
  };

  Vec3d position_;
  Vec3d vector_;
  Vec3d sum_;  // of the first corners of the faces
  std::vector<Face> faces_;
};

// Vertices with more faces do not change: visiting their faces for every change would take too long.
inline constexpr int kMaxFacesOfVertex = 200;

// Returns true if v has more faces.
bool is_crowded(const Surface& s, std::uint32_t v);

// Returns true if an edge joins the two vertices, or might join them outside the patch because both are fixed.
bool are_neighbours(const Surface& s, std::uint32_t v, std::uint32_t w);

}  // namespace knead::detail
