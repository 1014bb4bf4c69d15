// Remeshes a surface after a deformation: splits edges where the flow bends or stretches it, and keeps triangles well
// shaped (paper, section 5.2; docs/remeshing.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead {

// The targets of a remeshed surface as a user gives them. Missing ones are chosen from the shape: see resolve().
struct RemeshSettings {
  // Edges longer than this are split; a length > 0.
  std::optional<double> max_edge;
  // Edges are split if the deformation increases the angle between the normals at their ends by more; in (0, 180].
  std::optional<double> max_angle_deg;
  // Edges are split if their middle is farther than this from its true image; a fraction of the box diagonal, in (0,
  // 1).
  std::optional<double> max_chord;
  // Shorter edges are collapsed where the surface is flat; a length >= 0.
  std::optional<double> min_edge;
  // Rounds of flips, collapses and diffusion; 0 to 100.
  std::optional<int> iterations;
  // The limit on the vertices of the mesh, and with it on the work; 1 to kMaxVertices.
  std::optional<std::size_t> max_vertices;

  friend bool operator==(const RemeshSettings&, const RemeshSettings&) = default;
};

// The limit on the vertices of a remeshed surface.
inline constexpr std::size_t kMaxVertices = 500'000'000;

// The targets of a remesh in lengths and radians: the settings, completed by resolve().
struct RemeshTargets {
  double max_edge = 0;   // a length, as max_chord and min_edge
  double max_angle = 0;  // radians
  double max_chord = 0;
  double min_edge = 0;
  int iterations = 0;
  std::size_t max_vertices = kMaxVertices;
  double diagonal = 1;  // of the shape's box; the setting max_chord is a fraction of it
};

// Remeshing would need more vertices, or more work, than RemeshTargets::max_vertices allows. The message names the
// setting to change and a value that is enough.
class RemeshLimit : public QualityLimit {
 public:
  using QualityLimit::QualityLimit;
};

inline constexpr double kExactDistance = 1e-6;  // of remesh(mesh, settings): a fraction of the diagonal
inline constexpr double kDefaultMaxAngleDeg = 30;
inline constexpr double kDefaultMaxChord = 3e-4;
inline constexpr int kDefaultRemeshIterations = 4;
inline constexpr std::size_t kDefaultGrowth = 50;  // max_vertices divided by the number of the shape's vertices
inline constexpr std::size_t kDefaultMaxVertices = 2'000'000;  // the least default of max_vertices

// Returns the targets for a shape. By default max_edge is twice the 95th percentile of its edge lengths, and min_edge a
// quarter of its mean edge (at most a quarter of max_edge). By default max_vertices is kDefaultGrowth times the number
// of its vertices, and at least kDefaultMaxVertices. Throws InvalidInput if validate() does.
RemeshTargets resolve(const RemeshSettings& settings, const Mesh& mesh);
// Throws InvalidInput for a setting out of range, or min_edge above half of max_edge. The message begins with the key
// in quotes.
void validate(const RemeshSettings& settings);

// Two vertices, the smaller first.
using MeshEdge = std::array<std::uint32_t, 2>;

inline constexpr double kDefaultCreaseDeg = 40;

// Returns the creases of a mesh, ascending. An edge is sharp if the normals of its two faces differ by more than
// angle_deg. Creases are
// - sharp edges between two flat faces of several triangles, or where most edges around are flat or sharp, as on CAD
//   parts and polyhedra;
// - the other edges of flat faces that have at least three triangles, or are long and narrow as the strips of a fillet;
//   and edges between two vertices of creases;
// - chains of at least five connected sharp edges, a third of them with an angle above 60 degrees. Each edge of a chain
//   has a next one at one end or both, which turns by at most 45 degrees.
// Other sharp edges are noise of a rough surface. Triangles count as flat if they lie in one plane to the rounding of
// float coordinates. Call this for the shape before any deformation: folds that a deformation makes are no creases.
std::vector<MeshEdge> find_creases(const Mesh& mesh, double angle_deg = kDefaultCreaseDeg);

// The deformation that remesh() follows.
struct Deformation {
  // Moves points from the shape before to the shape after, as it moved the vertices.
  std::function<void(std::span<Vec3d>)> carry;
  // Returns false only if no point in the ball is moved. Empty: any point may be moved.
  std::function<bool(const Vec3d& center, double radius)> may_move{};
  // The size of the smallest detail of the deformation; a length. Larger faces are sampled inside to find such details.
  // Infinity: no face is sampled.
  double feature = kInfinity;
  // Returns the size of the smallest detail in a ball, at least `feature`. Empty: it is `feature` everywhere.
  std::function<double(const Vec3d& center, double radius)> feature_near{};
  // Returns about how many more points `carry` may move before the limit on the work. Empty: any number.
  std::function<double()> points_left{};
};

// How remesh() works.
struct RemeshOptions {
  RemeshTargets targets;
  bool single_precision = true;  // find crossings in the positions rounded to float, as most files store them
  bool whole = false;            // improve the whole surface, not only the part that moved
  // Keeps the surface: moves vertices only within flat faces, and along straight edges between them. For a deformation
  // that moves nothing.
  bool exact = false;
  // Stops without improving the result if many triangles still cross after all faces that cross have been split, for
  // callers who then remesh the deformation in parts.
  bool stop_where_crossed = false;
  // Also stops before improving anything if over 5000 pairs of triangles cross that did not before.
  bool stop_where_thousands_cross = false;
  // Creases of the mesh before. They may be split, but are not smoothed. remesh() does not look for others.
  std::span<const MeshEdge> creases{};
  // A label for each face (material, group), or empty. Edges between different labels are treated like seams.
  std::span<const std::uint32_t> face_labels{};
  int threads = 0;            // 0: as many as the machine has
  bool assume_valid = false;  // skips the checks of the mesh and the positions
  // remesh() ends after this time with the best surface so far. The result then depends on the machine's speed.
  double seconds = kInfinity;
  // 1 for each vertex that a mask holds, or empty. Such vertices keep their places, and the faces among them stay as
  // they are. The deformation must not move them.
  std::span<const std::uint8_t> held{};
  // Cancels remesh(), which then throws Cancelled. Counts the steps if `total` is 0; else the caller counts.
  Progress* progress = nullptr;
};

// What remesh() has done, and what remains.
struct RemeshCounts {
  std::size_t splits = 0;
  std::size_t collapses = 0;
  std::size_t flips = 0;
  std::size_t crossings = 0;         // pairs of crossing triangles in the result, at least one of them touched
  std::size_t crossings_before = 0;  // the same before the deformation; 0 if none cross in the result
  std::size_t curves = 0;            // connected sets of these pairs
  std::size_t curves_before = 0;     // the same before the deformation; 0 if none cross in the result
  std::size_t faces = 0;             // faces with a moved vertex after refinement: the work grows with their number
  bool stopped = false;              // by RemeshOptions::stop_where_crossed or stop_where_thousands_cross
  double missing_volume = 0;         // true volume minus the volume of the refined mesh
  double compensated_volume = 0;     // the part of it that was restored
  bool out_of_time = false;          // RemeshOptions::seconds ended the work
  double distance = 0;               // from the old to the new surface; of remesh(mesh, settings) only
  // False if a limit on rounds or time left edges that do not meet the targets, if most triangles were too thin to
  // improve, or if nearly every pair of triangles overlaps.
  bool complete = true;
};

// The remeshed shape, and where its vertices and faces come from.
struct Remeshed {
  Mesh mesh;                                 // the shape after, with interpolated attributes
  std::vector<std::uint32_t> face_source;    // for each face: the face of the mesh before that contains it
  std::vector<std::uint32_t> vertex_source;  // for each vertex: its number in the mesh before, or kNewVertex
  std::vector<MeshEdge> creases;             // the given creases in the new mesh, ascending
  std::vector<Vec3d> crossing_places;        // the centres of the faces that still cross
  std::vector<bool> moved;                   // for each vertex: true if the deformation moves the surface there
  RemeshCounts counts;
};
inline constexpr std::uint32_t kNewVertex = 0xffffffffu;

// Returns the deformed shape with a mesh that follows the deformation. `after` holds the positions to which the
// deformation moves the vertices of `before`.
//
// Edges are split on the undeformed and the deformed surface at once; the deformation moves each new vertex. Flips,
// collapses and diffusion along the surface then improve the triangles. Changes that would make triangles cross are
// undone.
// - Creases, boundaries and seams of attributes are split, but neither flipped nor smoothed.
// - Edges of more than two faces do not change.
// - Polygons that are touched become triangles.
// - Faces and vertices that the deformation does not touch keep their corners, bits and order, before new ones.
// - Values per vertex and corner are interpolated, values per face are inherited. "normal" (3 components) is changed
//   as by transport_normals().
//
// The result has the same bits for every number of threads. Throws InvalidInput where validate(before) does,
// for a position that is not finite, and for spans of wrong sizes; RemeshLimit if the mesh would need more vertices, or
// carrying its points more work, than the targets allow.
Remeshed remesh(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                const RemeshOptions& options);

// Returns the whole mesh refined and improved without a deformation, as `knead remesh` does, with its creases. The
// surface stays, to kExactDistance of its diagonal, unless the settings name `min_edge` or `max_chord`: then curved
// parts may move by about `max_chord`. Replaces the options `targets`, `whole`, `exact` and `creases`. Throws as above,
// and QualityLimit if the surface did not stay.
Remeshed remesh(const Mesh& mesh, const RemeshSettings& settings, RemeshOptions options = {});

// What a deformation did to the cells of a volume mesh.
struct CellSummary {
  std::size_t inverted = 0;
  std::size_t below = 0;  // inverted cells, and cells that fell below CellOptions::least_scaled_jacobian
  double least_scaled_jacobian = 1;
  double mean_volume_change = 0;  // the mean of |volume ratio - 1| of the cells that had a volume
};

// Moves points in place by the part of a deformation between two moments from 0 to 1.
using CarryPoints = std::function<void(double from, double to, std::span<Vec3d> points)>;

// How deform_cells() works.
struct CellOptions {
  double least_scaled_jacobian = 0.05;    // the bound that cells must not fall below; above 0, at most 0.5
  std::span<const std::uint8_t> fixed{};  // empty, or 1 for each point that must follow the deformation exactly
  int rounds = 30;                        // rounds over the bad cells, after each part of the motion
  int threads = 0;                        // 0: as many as the machine has
  const Progress* progress = nullptr;     // cancels the work, which then throws Cancelled
};

// The points of a volume mesh after a deformation.
struct DeformedCells {
  std::vector<Vec3d> points;
  CellSummary flow;       // of the deformation alone
  CellSummary result;     // of `points`
  std::size_t freed = 0;  // the number of points that are not where the deformation takes them
  int parts = 1;          // into which the motion was divided
};

// Deforms a volume mesh and keeps its cells good. Points on the boundary, fixed points, and points that the deformation
// does not move go exactly where it takes them. An interior point next to a bad cell may move further, to a place where
// the least scaled Jacobian around it is greater. If cells remain bad, the motion is divided into 8 or 32 parts, with
// such moves after each part; the best of these results is returned. So the result never has more inverted cells than
// the deformation alone.
//
// The result has the same bits for every number of threads if those of `carry` have. Throws InvalidInput for options
// out of range and where compare_cells() does; Cancelled.
//
// Method: ascent by the step that is best for the linearised qualities around a vertex. After L. Freitag, M. Jones, P.
// Plassmann, "An Efficient Parallel Algorithm for Mesh Smoothing", 4th International Meshing Roundtable, 1995, who
// follow the worst cells' gradients.
DeformedCells deform_cells(const Cells& cells, std::span<const Vec3d> before, const CarryPoints& carry,
                           const CellOptions& options = {});

}  // namespace knead
