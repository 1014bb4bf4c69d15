// The part of a mesh that a deformation touches, taken out to be remeshed and put back. Internal to the remesh room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/remesh/remesh.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// The faces that have a moved vertex, or a part that moves, and those around them, as triangles. The vertices that it
// shares with the rest of the mesh are fixed, edges between such locked.
struct Patch {
  Surface surface;                           // face_source: numbers of the mesh's faces
  std::vector<std::uint32_t> vertex_source;  // of the first vertices: their numbers in the mesh, ascending
  std::vector<Triangle> triangles;           // of the first faces, as they were
  std::vector<bool> holds_face;              // for each face of the mesh
  std::vector<MeshEdge> other_creases;       // of the mesh, between its vertices, that the patch does not hold

  bool is_new_vertex(std::size_t v) const { return v >= vertex_source.size(); }
  // Whether a face is as it was taken out.
  bool is_unchanged(std::size_t f) const { return f < triangles.size() && surface.triangle(f) == triangles[f]; }
};

Patch take_patch(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                 const RemeshOptions& options);

// The mesh with the patch put back.
Remeshed put_back(const Mesh& before, std::span<const Vec3d> after, const Patch& patch);

// find_creases() between the vertices of a surface as it is before.
std::vector<MeshEdge> find_crease_edges(const Surface& surface, double angle_deg);

// Marks as features the creases, of which those that the patch does not hold are kept aside, and the seams between
// corner values and labels.
void mark_features(const Mesh& mesh, const RemeshOptions& options, std::span<const std::uint32_t> patch_number,
                   Patch& patch);

}  // namespace knead::remesh_detail
