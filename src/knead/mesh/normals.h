// Vertex normals, and authored normals carried along by a deformation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

// One unit normal per vertex: the mean of the normals of its faces, weighted by the face's angle at the vertex (Thurmer
// and Wuthrich 1998). The zero vector where there is none (no face, or none with an area); never NaN.
std::vector<Vec3d> vertex_normals(const Mesh& mesh);
std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions);

// The same bits for the vertices that are `needed` (one flag a vertex), in the time that these take and a look at every
// corner; zero for the others.
std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions, const std::vector<bool>& needed);

inline constexpr std::uint32_t kNoNormal = 0xffffffffu;

// Authored normals after the vertices of `mesh` have moved to `after`. Corner c of the mesh uses
// normals[corner_normal[c]] (kNoNormal: none); for normals per vertex, corner_normal is mesh.corner_vertex.
// Each is turned by the rotation that takes the angle-weighted mean normal of the corners that use it from before to
// after, and the edges at those corners as near as it can, so that hard edges and authored smoothing stay; its length
// is kept. Where no vertex of the faces of those corners moved, where no corner uses it, or where that mean is
// undefined, the result has the same bits.
std::vector<Vec3d> transport_normals(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> normals,
                                     std::span<const std::uint32_t> corner_normal);

// Authored tangents, one per vertex, after the vertices have moved to `after`, where the authored normals are
// `normals`. Each is carried by the linear map of the surface that fits the edges of its faces at the vertex best
// (least squares, every edge with the same weight), then made orthogonal to the normal, with length 1. Where that map
// is undefined (no area around) it is made orthogonal only; where no vertex of its faces moved, the result has the same
// bits.
std::vector<Vec3d> transport_tangents(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> tangents,
                                      std::span<const Vec3d> normals);

}  // namespace knead
