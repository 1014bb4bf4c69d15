// Vertex normals; authored normals and tangents after a deformation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

// Returns one unit normal for each vertex: the mean of the normals of its faces, weighted by the angles of the faces at
// the vertex (Thurmer and Wuthrich 1998). Returns the zero vector for a vertex without a face that has an area; never
// NaN. The second form uses other positions, one for each vertex. Throws InvalidInput for faces that are not sound, and
// for positions of another number.
std::vector<Vec3d> vertex_normals(const Mesh& mesh);
std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns the same normals, to the bit, for the vertices with a flag in `needed` (one for each vertex), and zero for
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

}  // namespace knead
