// The part of a mesh that a deformation touches; remesh() takes it out, changes it and puts it back.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/remesh.h"
#include "remesh/improve.h"
#include "remesh/surface.h"

namespace knead::detail {

// A face of the mesh with the same vertices as another one. The surface holds only `kept`; `other` is divided alike.
struct EqualFace {
  std::uint32_t kept = 0;
  std::uint32_t other = 0;
  bool is_reversed = false;
};

// The faces with a moved vertex or a moved interior, and the faces around them, as triangles. Vertices that also belong
// to the rest of the mesh are fixed, and the edges between them are locked.
struct Patch {
  Surface surface;                           // its face_source holds faces of the mesh
  std::vector<std::uint32_t> vertex_source;  // for the first vertices: their numbers in the mesh, ascending
  std::vector<Triangle> triangles;           // the first faces in their original state
  std::vector<std::uint8_t> holds_face;      // for each face of the mesh: 1 if the patch holds it, 2 as an equal face
  std::vector<EqualFace> equal_faces;        // by `kept`
  std::size_t corner_rows = 1;               // in the values of a corner: those of the kept face, then of equal ones
  std::vector<MeshEdge> other_creases;       // creases of the mesh outside the patch, by vertices of the mesh

  // Returns the faces that are equal to the kept face f of the mesh.
  std::span<const EqualFace> equal_to(std::uint32_t f) const;
  // Returns true if face f still has its original vertices.
  bool is_unchanged(std::size_t f) const { return f < triangles.size() && surface.triangle(f) == triangles[f]; }
};

// Further positions of the vertices, which a remesh interpolates like the values of an attribute.
struct MorePlaces {
  std::vector<std::span<const Vec3d>> before;  // lists with a position for each vertex of the mesh before
  std::vector<std::vector<Vec3d>> after;       // the same lists for the vertices of the result
};

// Returns the part of the mesh that the deformation touches.
Patch extract_patch(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                    const RemeshOptions& options, const MorePlaces& places = {});

// Returns the mesh with the patch in place of the faces that were taken out.
Remeshed merge_patch(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, MorePlaces& places,
                     const Progress* progress);

// Does what resolve() does, for settings and a mesh that are known to be valid. threads as for parallel_for.
RemeshTargets resolve_on(const RemeshSettings& settings, const Mesh& mesh, int threads);

// Returns the creases of a surface with positions `before`, as find_creases() defines them. `tolerance`:
// plane_tolerance() of the mesh. `progress` cancels.
std::vector<MeshEdge> find_crease_edges(const Surface& surface, double angle_deg, double tolerance,
                                        const Progress* progress = nullptr);

// Does what find_creases() does, for a valid mesh. Throws Cancelled when `progress` is cancelled. threads as for
// parallel_for.
std::vector<MeshEdge> find_creases_unless_cancelled(const Mesh& mesh, double angle_deg, int threads,
                                                    const Progress* progress);

// Transforms the attribute "normal" (3 components) of vertices or corners by the deformation from `before` to `after`
// of the surface (see transport_normals), also for vertices that splits have made.
void turn_normals(const Mesh& mesh, Surface& surface);

// Scales the normals of the surface to length 1. Lengths that are 1 to the rounding of float keep their bits.
void normalise_normals(const Mesh& mesh, Surface& surface);

// Marks creases and seams (of corner values and of labels) as features. Creases outside the patch go to
// patch.other_creases.
void mark_features(const Mesh& mesh, const RemeshOptions& options, std::span<const std::uint32_t> patch_number,
                   Patch& patch);

// Improves the triangles of a refined surface. remesh_with() calls it again, on the refined surface, if the result has
// crossings.
using Improve = std::function<ImprovementCounts(Surface& surface, const Improvement& improvement)>;

// Does what remesh() does, with `improve`, unless it is empty, in place of its own compensation and improvement.
Remeshed remesh_with(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                     const RemeshOptions& options, const Improve& improve, MorePlaces& places);

}  // namespace knead::detail
