// Polygon meshes: triangles, joined and welded meshes, normals, procedural shapes, measures, searches by trees, and
// self-intersections; Gaussian splats.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"

namespace knead {

// The kind of element that an attribute has a value for.
enum class Domain { vertex, corner, face };

// The number type of an attribute in its file; it is written with the same type.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

// Numbers for each vertex, corner or face, e.g. "normal" (3 components), "uv" (2), "color" (3 or 4; from 0 to the
// maximum of an integer type, or from 0 to 1 for floats).
struct Attribute {
  std::string name;
  Domain domain = Domain::vertex;
  NumberType type = NumberType::float32;
  int components = 1;
  std::vector<double> values;  // `components` numbers for each element, in the order of the elements

  friend bool operator==(const Attribute&, const Attribute&) = default;
};

// A polygon mesh, or a point cloud if it has no faces. Face f has the corners [face_begin[f], face_begin[f + 1]);
// corner_vertex holds the vertex of each corner. Corners are counter-clockwise seen from outside.
//
// Invariants: face_begin is never empty, begins with 0, never decreases and ends with corner_vertex.size(). Every entry
// of corner_vertex is below positions.size(). Readers and makers give such meshes; validate() checks others.
struct Mesh {
  std::vector<Vec3d> positions;
  std::vector<std::uint32_t> face_begin{0};
  std::vector<std::uint32_t> corner_vertex;
  std::vector<Attribute> attributes;

  // Returns the number of vertices.
  std::size_t vertex_count() const { return positions.size(); }
  // Returns the number of faces.
  std::size_t face_count() const { return face_begin.size() - 1; }

  // Returns the number of elements of a kind.
  std::size_t element_count(Domain domain) const {
    return domain == Domain::vertex ? vertex_count() : domain == Domain::corner ? corner_vertex.size() : face_count();
  }

  // Returns the vertices of face f, in order.
  std::span<const std::uint32_t> face(std::size_t f) const {
    return {corner_vertex.data() + face_begin[f], face_begin[f + 1] - face_begin[f]};
  }

  // Appends a face. The caller appends its values to corner and face attributes.
  void add_face(std::span<const std::uint32_t> vertices) {
    corner_vertex.insert(corner_vertex.end(), vertices.begin(), vertices.end());
    face_begin.push_back(static_cast<std::uint32_t>(corner_vertex.size()));
  }

  // Returns the first attribute of that name, or null.
  const Attribute* find_attribute(const std::string& name) const {
    for (const Attribute& attribute : attributes) {
      if (attribute.name == name) return &attribute;
    }
    return nullptr;
  }
};

// Returns the factor that scales the values of a color to the range from 0 to 1. The type decides for bytes and shorts.
// For other types the greatest value decides, which may be up to 1, 255 or 65535. Reals up to 16 keep their values:
// they are light brighter than white.
double color_scale(const Attribute& color);

// Throws InvalidInput, with the number of the first vertex, face or corner at fault, unless the invariants hold, every
// coordinate is finite, and every attribute has its numbers. Time: linear.
void validate(const Mesh& mesh);

// Triangles of polygons.

using Triangle = std::array<std::uint32_t, 3>;  // three vertices, counter-clockwise seen from outside

// Returns the triangles of all faces, in the order of faces. A face of n corners gives n - 2 triangles (none for n <
// 3). Convex polygons are cut as a fan from their first corner, others by ear clipping in the plane of their mean
// normal (Meisters 1975). If no ear is left (the polygon crosses itself or has no area), or after about 10^7 tests, the
// rest of the polygon is cut as a fan. No face is dropped. Throws InvalidInput for faces that are not sound, and for
// positions that are not finite.
std::vector<Triangle> triangulate(const Mesh& mesh);

// Returns the face of each triangle of triangulate(mesh).
std::vector<std::uint32_t> triangle_faces(const Mesh& mesh);

// Appends the triangles of one polygon, which must have at least three corners.
void triangulate_polygon(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon,
                         std::vector<Triangle>& triangles);

// Throws InvalidInput, with the number of the first triangle at fault, unless every triangle has vertices below the
// number of positions, with finite coordinates.
void check_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> positions);

// Calls visit(triangle) for each triangle that triangulate() would return for the mesh with these positions.
template <class Visit>
void for_each_triangle(const Mesh& mesh, std::span<const Vec3d> positions, Visit visit) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> polygon = mesh.face(f);
    if (polygon.size() == 3) visit(Triangle{polygon[0], polygon[1], polygon[2]});
    if (polygon.size() <= 3) continue;
    triangles.clear();
    triangulate_polygon(positions, polygon, triangles);
    for (const Triangle& t : triangles) visit(t);
  }
}

// Returns the normal of a closed polygon; its length is twice the area. Method: sum of cross products (Newell).
Vec3d polygon_normal(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon);

// Several meshes as one.

// A mesh, and for each face the face of an earlier mesh in which it lies.
struct MeshPart {
  Mesh mesh;
  std::vector<std::uint32_t> face_source;
};

// Joins several meshes into one, and separates them again. mesh() has the vertices, faces, corners and attributes of
// the meshes one after the other. The attributes of one mesh are 0 at the elements of all others.
class JoinedMeshes {
 public:
  // Throws InvalidInput if there are more vertices or corners than 32 bits can number.
  explicit JoinedMeshes(std::span<const Mesh* const> meshes);

  // Returns all meshes as one.
  const Mesh& mesh() const { return mesh_; }
  // Returns the number of meshes.
  std::size_t size() const { return begins_.size() - 1; }

  // Returns the items of one mesh's vertices. `items`: one for each vertex of mesh().
  template <class T>
  std::span<const T> vertices_of(std::size_t part, std::span<const T> items) const {
    return items.subspan(begins_[part].vertex, begins_[part + 1].vertex - begins_[part].vertex);
  }

  // Returns one of the meshes after mesh() was remeshed into `remeshed`. face_source: for each face of `remeshed`, the
  // face of mesh() in which it lies. vertex_source: for each vertex of `remeshed`, the vertex of mesh(), or a greater
  // number for a new one; used only for vertices without faces. Throws InvalidInput for lists of other lengths.
  MeshPart part_of(std::size_t part, const Mesh& remeshed, std::span<const std::uint32_t> face_source,
                   std::span<const std::uint32_t> vertex_source) const;

  // Returns the number of the mesh that a face of mesh() belongs to.
  std::size_t part_of_face(std::uint32_t face) const;

 private:
  struct Begin {
    std::uint32_t vertex = 0;
    std::uint32_t face = 0;
    std::uint32_t attribute = 0;
  };

  Mesh mesh_;
  std::vector<Begin> begins_;  // of each mesh, and the ends of the last one
};

// A mesh whose border vertices at equal positions are joined. Some files repeat vertices for each triangle, others
// along seams of normals or texture coordinates.
class WeldedMesh {
 public:
  // The mesh must outlive this object. Joins only vertices on the border, so closed parts that touch stay separate.
  // Time: linear in the corners, and a sort of the vertices on the border. Throws InvalidInput for faces that are not
  // sound.
  explicit WeldedMesh(const Mesh& mesh);

  // Returns a mesh with the same vertices and without attributes, whose faces name the first vertex at each position;
  // the given mesh if count() is 0.
  const Mesh& mesh() const { return own_ ? *own_ : *given_; }

  // Returns the first vertex that is joined with this one; the vertex itself if there is none.
  std::uint32_t first(std::uint32_t vertex) const { return first_.empty() ? vertex : first_[vertex]; }

  // Returns the number of vertices that are joined to an earlier one.
  std::size_t count() const { return count_; }

  // Gives every vertex the item of the first vertex that it is joined with. `items`: one for each vertex.
  template <class T>
  void share(std::vector<T>& items) const {
    for (std::uint32_t v = 0; v < first_.size(); ++v) items[v] = items[first_[v]];
  }

 private:
  const Mesh* given_;
  std::optional<Mesh> own_;
  std::vector<std::uint32_t> first_;  // of each vertex; empty if all are alone
  std::size_t count_ = 0;
};

// Vertex normals; authored normals and tangents after a deformation.

// Returns one unit normal for each vertex: the mean of the normals of its faces, weighted by the angles of the faces at
// the vertex (Thurmer and Wuthrich 1998). Returns the zero vector for a vertex without a face that has an area; never
// NaN. The second form uses other positions, one for each vertex. Throws InvalidInput for faces that are not sound, and
// for positions of another number.
std::vector<Vec3d> vertex_normals(const Mesh& mesh);
std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns the same normals, bit for bit, for the vertices with a flag in `needed` (one for each vertex), and zero for
// all others. Time: that of the needed normals, plus one pass over all corners.
std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions, const std::vector<bool>& needed);

// In corner_normal: the corner has no normal.
inline constexpr std::uint32_t kNoNormal = 0xffffffffu;

// Returns authored normals after the vertices of `mesh` have moved to `after`. Corner c of the mesh uses
// normals[corner_normal[c]] (kNoNormal: none). For normals per vertex, pass mesh.corner_vertex as corner_normal.
//
// Each normal is rotated and keeps its length. The rotation maps the mean normal of the corners that use it (weighted
// by angle) from before to after, and their edges as closely as possible. So hard edges and authored smoothing are
// kept. A normal keeps its bits if no vertex of the faces of its corners moved, if no corner uses it, or if the mean is
// undefined.
std::vector<Vec3d> transport_normals(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> normals,
                                     std::span<const std::uint32_t> corner_normal);

// Returns authored tangents, one for each vertex, after the vertices have moved to `after` and the authored normals
// have become `normals`. Each tangent is mapped by the linear map of the surface that best fits the edges of the faces
// at the vertex (least squares, equal weights). It is then made orthogonal to the normal and scaled to length 1. If the
// faces have no area, the tangent is made orthogonal only. If no vertex of the faces moved, the tangent keeps its bits.
std::vector<Vec3d> transport_tangents(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> tangents,
                                      std::span<const Vec3d> normals);

// Procedural closed shapes.

// The kinds of procedural shapes.
enum class ShapeKind {
  sphere,    // radius 1, about the origin; an evenly subdivided icosahedron
  box,       // a bar along x: [-3, 3] x [-0.5, 0.5] x [-0.5, 0.5]
  cylinder,  // radius 0.5 about the z axis, z from -3 to 3, closed by disks
  torus,     // radii 1 and 0.3 about the z axis
  hand,      // a right hand: fingers along +y, palm towards +z, thumb on the side of +x; y from about -0.95 to 0.95
  crater,    // a block of ground: x and y from -5 to 5, bottom at z = -1.5, hilly surface near z = 0 with a crater
  knot,      // a trefoil on the torus of radii 2 and 1 about the z axis, tube of radius 0.45
  letter_y,  // x and y from -0.4 to 0.4, z from -0.1 to 0.1, flat in front and behind, edges rounded by 0.02
  figure,    // a person who stands with the arms apart, facing +z; y from about -0.99 to 0.99
};

// Returns the names, in the order of ShapeKind: "sphere", ..., "letter-y".
std::span<const std::string_view> shape_names();

// Returns the kind with this name. Throws InvalidInput for an unknown name.
ShapeKind shape_kind(std::string_view name);

// The numbers of vertices that make_shape() accepts for a kind, and its standard number.
struct ShapeCounts {
  std::size_t minimum;
  std::size_t standard;
  std::size_t maximum;
};
// Returns the numbers of vertices that a kind can have.
ShapeCounts shape_counts(ShapeKind kind);

// Returns a closed, manifold, connected triangle mesh of about `vertices` vertices (0: the standard number of the
// kind); triangles are counter-clockwise seen from outside. The number of vertices is within 10% of the given one; a
// sphere of fewer than 1000 has the nearest of 12, 42, 92, 162, 252, 362, 492, 642, 812 and 1002. The same arguments
// give the same bits. Throws InvalidInput for a number outside shape_counts(kind).
//
// Cost: about 0.1 us per vertex (letter-y 4 us, hand and figure 20 us); memory 70 bytes per vertex (letter-y, hand and
// figure 220).
Mesh make_shape(ShapeKind kind, std::size_t vertices = 0);

// A finger of the hand. On the tip's side of the plane through `base` orthogonal to `axis`, the finger is within
// `radius` of the line through base along axis and shorter than `length`. There, no other part of the hand is within
// radius + 0.02 of that line. So a cylinder of this radius and length contains this finger only.
struct Finger {
  std::string_view name;
  Vec3d base;
  Vec3d axis;  // unit vector, towards the tip
  double length = 0;
  double radius = 0;
};

// Returns the fingers: thumb, index, middle, ring, little.
std::span<const Finger> hand_fingers();

// Measures: counts, topology, volume, area, flipped triangles and folded edges.

// Finds the box of a point cloud without its stray points. The points may come in any order. Memory: constant. A point
// is stray if its distance from all others is more than 10 times the extent of these. At most 5% of the points, and at
// most 64 on each side of each axis, are strays; clouds of fewer than 20 points have none.
class CloudBox {
 public:
  // Adds points, whose coordinates are finite.
  void add(std::span<const Vec3d> points);

  // Returns the box of all points but the strays; empty without points.
  Box box() const;

  // Returns the box of all points.
  const Box& whole() const { return whole_; }

 private:
  static constexpr std::size_t kMaxStrays = 64;  // on each side of each axis

  std::size_t points_ = 0;
  Box whole_;
  std::array<std::vector<double>, 6> ends_;  // heaps of the lowest and of the highest coordinates on each axis
};

// Returns the box of the vertices that faces use; for a mesh without faces, the box that CloudBox finds. Lengths that
// are relative to a shape refer to the diagonal of this box. `positions`: used in place of the mesh's own, one for each
// vertex. Time: linear.
Box shape_box(const Mesh& mesh);
Box shape_box(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns a sentence about vertices that are farther outside shape_box() than its diagonal; empty if there are none.
std::string stray_note(const Mesh& mesh);

// The measures of a mesh. An edge is an unordered pair of different vertices that are consecutive in a face. A face
// that uses an edge twice counts as two faces there.
struct Measures {
  std::size_t vertices = 0;
  std::size_t unused_vertices = 0;  // in no face
  std::size_t faces = 0;
  std::size_t triangles = 0;             // of triangulate(mesh)
  std::size_t degenerate_triangles = 0;  // with a repeated vertex or without area (see is_degenerate)
  std::size_t edges = 0;
  std::size_t boundary_edges = 0;        // with one face
  std::size_t nonmanifold_edges = 0;     // with more than two faces
  std::size_t misoriented_edges = 0;     // used in one direction two or more times more than in the other
  std::size_t nonmanifold_vertices = 0;  // whose faces form several fans
  std::size_t components = 0;            // connected by shared vertices; unused vertices do not count
  std::size_t boundary_loops = 0;
  std::int64_t euler = 0;  // used vertices - edges + faces
  double volume = 0;       // signed; positive if the faces point outward. Meaningful for a closed mesh only
  double area = 0;
  std::optional<double> smallest_angle_deg;  // of the triangles that are not degenerate
  Box box;                                   // of the vertices that faces use (see shape_box)

  // Returns whether there are faces, and no edge has only one.
  bool closed() const { return faces > 0 && boundary_edges == 0; }
  // Returns whether no edge has more than two faces and no vertex lies in several fans.
  bool manifold() const { return nonmanifold_edges == 0 && nonmanifold_vertices == 0; }
  // Returns whether the faces at each edge agree about which side is outside: the numbers of uses in the two directions
  // differ by at most 1. The volume of a closed mesh then does not depend on the origin, even if it is not manifold.
  bool oriented() const { return misoriented_edges == 0; }
};

// Returns the measures of a mesh. Time: linear in the corners, plus a small sort at each vertex. Sums run in the order
// of faces, so every run returns the same bits. threads as for parallel_for. Throws InvalidInput where validate(mesh)
// does.
Measures measure(const Mesh& mesh, int threads = 0);

// Does the same in less time, given the measures of a mesh with the same faces.
Measures measure(const Mesh& mesh, const Measures& same_faces, int threads = 0);

// The volume and the area of a mesh.
struct VolumeAndArea {
  double volume = 0;
  double area = 0;
};
// Returns the volume and area of `mesh` with other positions, one for each vertex, by the same sums as measure().
VolumeAndArea measure_volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns true if the triangle has no area: its height over the longest edge is below 1e-12 times that edge, or two
// corners are equal.
bool is_degenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c);

// Returns the defects of a mesh, one sentence each, e.g. "1 edge has more than two faces"; empty for a closed, manifold
// and oriented mesh without degenerate triangles.
std::vector<std::string> describe_defects(const Measures& measures);

// Returns the number of flipped triangles. A triangle is flipped if its normal opposes the mean of the vertex normals
// of its corners (negative dot product) with the positions `after`, but not with `before`. A triangle without area is
// never flipped. Polygons are cut into triangles with the positions `before`. Both spans hold one position per vertex.
std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after);

// Returns the number of folded edges. An edge is folded if it has exactly two triangles, these have the same
// orientation, and the angle between their normals is above 170 degrees. The triangles are those of triangulate(mesh),
// so an edge may lie inside a polygon. Triangles without area (see is_degenerate) are ignored.
std::size_t count_folded_edges(const Mesh& mesh);

// Nearest points and rays.

// A point of the surface and the triangle that it lies in.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> barycentric{};  // weights of the corners: each from 0 to 1, sum 1
  Vec3d point;
  double distance = 0;
};

// Where a ray meets the surface.
struct RayHit {
  std::uint32_t triangle = 0;
  double t = 0;         // the hit is at origin + t direction
  bool leaves = false;  // the ray passes to the side that the triangle's normal points to: out of a solid
};

// A tree over any triangles, also degenerate ones. To search a point cloud, use triangles {i, i, i}: the number of a
// triangle is then the number of the point.
//
// Every answer equals that of a search through all triangles, bit for bit: it depends on the triangles and positions,
// not on the tree. All coordinates must be finite and either 0 or between 1e-75 and 1e75 in magnitude.
//
// Cost: building takes about 0.3 us for each triangle, refitting 0.03 us. Near a surface of 20,000 triangles a ray
// query takes about 3 us and a nearest-point query 8 us; twice that for 200,000 (docs/decisions/0008). Memory: about
// 150 bytes for each triangle. Queries may run on many threads at once.
class SurfaceTree {
 public:
  // Builds the tree. It keeps copies of the triangles and positions. Throws InvalidInput where check_triangles() does.
  SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions);

  // Moves the vertices; there must be as many positions as before. After large motions queries are slower than in a
  // newly built tree.
  void refit(std::span<const Vec3d> positions);

  // Does the same if only vertices within this box have moved: visits only triangles whose boxes meet it.
  void refit(std::span<const Vec3d> positions, const Box& moved);

  // Returns the point of the surface nearest to p; nothing if none is within max_distance. Of equally near triangles,
  // it returns the one with the lowest number.
  std::optional<SurfacePoint> closest(const Vec3d& p, double max_distance = kInfinity) const;

  // Returns the nearest points of the `count` nearest triangles within max_distance, one for each triangle; nearest
  // first, then by number. Time: linear in count for each triangle near p, so use it for small counts.
  std::vector<SurfacePoint> nearest(const Vec3d& p, std::size_t count, double max_distance = kInfinity) const;

  // Returns the first triangle that the ray meets at 0 <= t <= max_t; of several at the same t, the one with the lowest
  // number. The direction must not be zero and need not be a unit vector.
  std::optional<RayHit> first_hit(const Vec3d& origin, const Vec3d& direction, double max_t = kInfinity) const;

  // Returns every triangle that the ray meets at t >= 0, sorted by t, then by number. A ray exactly through an edge or
  // a vertex meets the same triangles as a ray just beside it. So a line through a closed surface enters as many
  // triangles as it leaves.
  std::vector<RayHit> hits(const Vec3d& origin, const Vec3d& direction) const;

 private:
  static constexpr std::size_t kLeafSize = 4;

  struct Entry {
    std::array<Vec3d, 3> corners;
    std::uint32_t triangle = 0;
  };

  std::span<const Entry> entries_of(std::size_t leaf) const;
  void fit_leaf(std::size_t leaf, std::span<const Vec3d> positions);
  void refit_below(std::size_t node, std::span<const Vec3d> positions, const Box& moved);
  // Calls visit(entry) for the entries within sqrt(limit2) of p, nearer boxes first. visit returns the new limit2.
  template <class Visit>
  void visit_near(const Vec3d& p, double limit2, Visit visit) const;
  // Calls visit(entry) for the entries whose boxes the ray meets before limit. visit returns the new limit.
  template <class Ray, class Visit>
  void visit_along(const Ray& ray, double limit, Visit visit) const;
  double limit2_of(double distance) const;

  std::vector<Triangle> triangles_;
  std::vector<Entry> entries_;  // in the order of the Morton curve
  std::size_t first_leaf_ = 1;  // a power of two
  std::vector<Box> nodes_;      // node i has the children 2 i and 2 i + 1; the root is 1
  double slack_ = 0;            // larger than any rounding error between a box and its contents
};

// Stretches.

// How the triangles of a surface are stretched: the singular values of their linear maps.
struct SurfaceStretch {
  double greatest = 1;
  double least = 1;
  double percentile_99 = 1;        // 99% of the triangles are stretched or compressed by at most this factor
  double rms_log = 0;              // root mean square of the logarithms
  std::size_t worst_triangle = 0;  // the triangle that is stretched or compressed most

  // Returns the greatest factor by which a triangle is stretched or compressed.
  double worst() const { return least > 0 ? std::max(greatest, 1 / least) : kInfinity; }
};

// Returns the stretches of the triangles from the positions `rest` to `now`, one for each vertex. Triangles without
// area do not count.
SurfaceStretch surface_stretch(std::span<const Triangle> triangles, std::span<const Vec3d> rest,
                               std::span<const Vec3d> now);

// Returns the greatest singular value of the linear map from one triangle to another; nothing if the first has no area.
std::optional<double> triangle_stretch(const std::array<Vec3d, 3>& rest, const std::array<Vec3d, 3>& now);

// Returns for each vertex the greatest stretch of its triangles from `rest` to `now`, which have a position for each
// vertex; 1 for a vertex without triangles that have an area. Time: linear, about 20 ns a triangle.
std::vector<float> vertex_stretches(std::span<const Triangle> triangles, std::span<const Vec3d> rest,
                                    std::span<const Vec3d> now);

// Self-intersections.

// How self_intersections() searches.
struct SelfIntersectionOptions {
  int threads = 0;                            // 0: as many as the machine has
  std::size_t limit = 10'000'000;             // the search stops after this many pairs
  const Progress* progress = nullptr;         // cancels the search, which then throws Cancelled
  const std::vector<bool>* chosen = nullptr;  // for each triangle: finds only pairs with a chosen one; null: all
};

// The pairs of triangles that cross.
struct SelfIntersections {
  std::vector<std::array<std::uint32_t, 2>> pairs;  // numbers of triangles, the smaller first, sorted; each pair once
  std::size_t count = 0;                            // of pairs; at most the limit
  bool complete = true;  // false if there are more pairs than the limit; `pairs` is then empty
};

// Returns how many pairs of `now` are not in `before`; all of them if one of the searches was stopped at its limit.
std::size_t count_new(const SelfIntersections& now, const SelfIntersections& before);

// Returns how many of the pairs, among triangles of mesh(), lie on two different meshes. `triangle_source`: for each
// triangle its face in JoinedMeshes::mesh(). Throws InvalidInput if the search was stopped at its limit.
std::size_t count_between(const SelfIntersections& found, const JoinedMeshes& joined,
                          std::span<const std::uint32_t> triangle_source);

// Returns the pairs of triangles that intersect in more than the vertices and edges they share. Vertices are shared if
// their numbers are equal. Two triangles are a pair
// - without a common vertex: if they have a common point; touching counts;
// - with one common vertex: if the edge opposite to it in one triangle meets the other triangle;
// - with two: if they lie in one plane on the same side of the common edge;
// - with three: always.
// A triangle whose corners are collinear is a pair with itself and with no other triangle. CGAL 5.5
// (Polygon_mesh_processing::self_intersections) returns the same pairs, also for edges with more than two triangles.
//
// Throws InvalidInput where check_triangles() does. Every decision is exact (predicates.h); coordinates below 2^-250
// (about 1e-75) of the largest one count as 0. The result is the same for every number of threads. Use the triangles of
// triangulate(mesh); the same triangles with two sets of positions compare a mesh before and after a deformation.
//
// Time: about n log n for surfaces, n + k log k with k chosen triangles; in the worst case quadratic in the number of
// triangles whose boxes overlap (a fan of k triangles: k^2 / 2).
SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options = {});

// Gaussian splats: points with a covariance, and a colour that depends on the direction from which they are seen.

// Returns whether the mesh holds splats: no faces, and the vertex attributes of real numbers scale_0 to scale_2
// (logarithms of the standard deviations) and rot_0 to rot_3 (the quaternion w, x, y, z of their axes), as the files of
// Kerbl et al. (2023) have them.
bool are_splats(const Mesh& mesh);

// Returns whether the mesh has these attributes, with faces or without: of a mesh with faces, the vertices in no face
// are splats.
bool have_splats(const Mesh& mesh);

// Returns the degree of the spherical harmonics of splats, from 0 to 3; the mesh has 0, 9, 24 or 45 attributes
// f_rest_*. Throws InvalidInput for another number of them, or if have_splats() is false.
std::size_t splat_degree(const Mesh& splats);

// Returns the real spherical harmonics of degrees 1 to 3 at a unit vector, with the signs and factors of splat files.
std::array<double, 15> splat_harmonics(const Vec3d& direction);

// Returns the unit axes of a splat, in the order of its sizes. turn: a quaternion w, x, y, z of any length above 0; any
// other one counts as no rotation.
std::array<Vec3d, 3> splat_axes(std::array<double, 4> turn);

// Returns the smallest axis of each splat, as the normal of the surface that the splats cover: on the side from which
// most of 26 views from far away see the splat. Time: about 1 us a splat.
std::vector<Vec3d> splat_normals(const Mesh& splats);

// The Jacobian of a deformation at the splats where it is not the identity.
struct SplatJacobians {
  std::vector<std::uint32_t> splats;  // ascending
  std::vector<Mat3d> jacobians;       // one for each of `splats`, with a determinant above 0
};

// New values of some splats, for WriteOptions.
struct ChangedSplats {
  std::vector<std::uint32_t> splats;  // ascending
  std::vector<Attribute> attributes;  // with a value for each of `splats`
};

// Returns the new scale_*, rot_* and f_rest_* of the splats that have a Jacobian. The Jacobian J changes the covariance
// S to J S J^T; the result is given as sizes and a unit quaternion, whose axes keep their order. The spherical
// harmonics f_rest_* (red first) turn by the rotation of J's polar factor. Opacity and f_dc_* do not change. Throws
// InvalidInput as splat_degree(), and for a number that is no splat; Cancelled. Method: one-sided Jacobi for the
// singular values; harmonics are evaluated in as many directions as their degree has functions. Time: about 2 us a
// splat. `threads`: as for parallel_for; the result has the same bits for every number.
ChangedSplats deformed_splats(const Mesh& splats, const SplatJacobians& jacobians, int threads = 0,
                              const Progress* progress = nullptr);

}  // namespace knead
