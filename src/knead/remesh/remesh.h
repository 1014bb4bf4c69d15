// A mesh made to follow a deformation: refined where the flow bends or stretches it, kept well shaped (paper, section
// 5.2; method, section 5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

// What is asked of a remeshed surface. What is left out follows from the shape: see resolve().
struct RemeshSettings {
  std::optional<double> max_edge;  // longer edges are split; a length > 0
  std::optional<double>
      max_angle_deg;                // edges whose end normals the deformation turns apart by more are split; (0, 180]
  std::optional<double> max_chord;  // edges whose middle is farther from its true image are split; a fraction of
                                    // the box diagonal, in (0, 1)
  std::optional<double> min_edge;   // shorter edges are collapsed where the surface is flat; a length >= 0
  std::optional<int> iterations;    // rounds of flips, collapses and diffusion; 0 to 100

  friend bool operator==(const RemeshSettings&, const RemeshSettings&) = default;
};

// The same with nothing left to be chosen.
struct RemeshTargets {
  double max_edge = 0;   // a length
  double max_angle = 0;  // radians
  double max_chord = 0;  // a length
  double min_edge = 0;   // a length
  int iterations = 0;
};

inline constexpr double kDefaultMaxAngleDeg = 30;
inline constexpr double kDefaultMaxChord = 3e-4;
inline constexpr int kDefaultRemeshIterations = 4;

// Targets for a shape: by default max_edge is twice the length that 95% of its edges do not pass, min_edge a quarter of
// its mean edge (at most a quarter of max_edge). Throws InvalidInput for a setting out of range, or min_edge above half
// of max_edge; the message begins with the key in quotes.
RemeshTargets resolve(const RemeshSettings& settings, const Mesh& mesh);
void validate(const RemeshSettings& settings);

// Two vertices, the smaller first.
using MeshEdge = std::array<std::uint32_t, 2>;

inline constexpr double kDefaultCreaseDeg = 40;

// The edges of two faces whose normals are apart by more than the angle, where one of their ends at least goes on about
// straight in another such edge, and at least five hang together of which a third are of more than 60 degrees: what
// else is sharp is noise of a rough surface. Ascending. To be asked of a shape as it was made; a smooth surface that
// is folded by a deformation has no creases.
std::vector<MeshEdge> find_creases(const Mesh& mesh, double angle_deg = kDefaultCreaseDeg);

// How the volume is treated while triangles are improved.
//   keep:  moves, flips and collapses that leave it as it is, to the rounding, and a compensation for what the chords
//          of the refined mesh miss (method, section 5, after Kuprat et al. 2001);
//   paper: the paper's way, as a comparison: projection back onto the undiffused surface, collapses at midpoints, no
//          flips, no compensation. It loses volume every time.
enum class VolumeTreatment { keep, paper };

// The deformation that a remesh follows.
struct Deformation {
  // Moves points of the shape before to where they are after: exactly as the vertices were moved.
  std::function<void(std::span<Vec3d>)> carry;
  // Whether a point in the ball may be moved at all; must not say false where one is. Empty: any may be.
  std::function<bool(const Vec3d& center, double radius)> may_move{};
  // The size of the smallest part of a surface that it might move by itself: faces that are larger, and that may be
  // moved, are searched for such parts. A length; infinity: none is searched.
  double feature = std::numeric_limits<double>::infinity();
};

struct RemeshOptions {
  RemeshTargets targets;
  VolumeTreatment volume = VolumeTreatment::keep;
  bool single_precision = true;  // crossings are judged of the positions rounded to float, as most files hold them
  bool whole = false;            // improve the whole surface, not only what moved
  // Edges of the mesh before that are creases: split along, never smoothed across. Others are not looked at.
  std::span<const MeshEdge> creases{};
  // One for each face, or empty: edges between faces of different labels (materials, groups) are treated like seams.
  std::span<const std::uint32_t> face_labels{};
  int threads = 0;  // 0: all
};

// What was done, and what is left.
struct RemeshCounts {
  std::size_t splits = 0;
  std::size_t collapses = 0;
  std::size_t flips = 0;
  std::size_t crossings = 0;      // pairs in which a touched triangle takes part, left as the result stands
  double missing_volume = 0;      // what the chords of the refined mesh missed: true volume - that of its triangles
  double compensated_volume = 0;  // what the compensation gave back
  bool complete = true;           // false: a limit on vertices or rounds came first; edges above the targets remain
};

struct Remeshed {
  Mesh mesh;                                 // the shape after, its attributes interpolated
  std::vector<std::uint32_t> face_source;    // for each face the face of the mesh before that it lies in
  std::vector<std::uint32_t> vertex_source;  // for each vertex the vertex of the mesh before, or kNewVertex
  std::vector<MeshEdge> creases;             // ascending; what became of those given
  std::vector<bool> moved;                   // for each vertex: whether the deformation moves the surface there
  RemeshCounts counts;
};
inline constexpr std::uint32_t kNewVertex = 0xffffffffu;

// The shape `before`, whose vertices are moved to `after` by the deformation, with a mesh that follows it.
//
// Edges are split on the undeformed and the deformed surface at once, the new vertex carried by the deformation. Then
// triangles are improved by flips, collapses and diffusion along the surface. Creases, boundaries, and seams of
// attributes and face attributes are split along and neither flipped nor diffused; edges of more than two faces are
// left as they are. Faces that the deformation does not touch keep their corners, and all vertices that it does not
// their bits; both keep their order, and come before new ones. Polygons are cut into triangles where touched. A move
// that would make triangles cross is taken back.
//
// Attributes: numbers per vertex and corner are interpolated, per face inherited; "normal" (3) is turned along by the
// deformation as by transport_normals.
//
// Deterministic: the same bits for every number of threads. Throws InvalidInput for spans of another size.
Remeshed remesh(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                const RemeshOptions& options);

}  // namespace knead
