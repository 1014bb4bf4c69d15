// The faces of a mesh in renderer units, and where shading is smooth over them.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "knead/mesh/mesh.h"
#include "knead/mesh/triangulate.h"
#include "knead/render/view.h"

namespace knead::render {

inline constexpr std::uint32_t kNoVertex = 0xffffffff;

struct PlacedFaces {
  std::vector<Vec3d> positions;            // per vertex, renderer units
  std::vector<Vec3d> normals;              // per face, unit; zero: the face is left out
  std::vector<std::uint32_t> corner_face;  // per corner
};

// Faces without area, or with a corner that is not finite, are left out.
PlacedFaces place_faces(const Mesh& mesh, const Placement& placement);

// The triangles of the faces that are not left out, as corners, face after face.
std::vector<Triangle> corner_triangles(const Mesh& mesh, const PlacedFaces& faces);

// The vertices before and after a corner in its face.
std::pair<std::uint32_t, std::uint32_t> around(const Mesh& mesh, const PlacedFaces& faces, std::uint32_t corner);

// One drawn vertex per vertex and group of faces that meet smoothly there.
struct SmoothGroups {
  std::vector<std::uint32_t> corner_vertex;  // the drawn vertex of each corner; kNoVertex: its face is left out
  std::vector<std::uint32_t> begin;          // the drawn vertices of vertex v are begin[v] to begin[v + 1]
  std::vector<std::uint32_t> corner;         // per drawn vertex, one of its corners
};

// crease_angle: in radians; faces meet smoothly where they bend by at most this; negative: nowhere.
SmoothGroups smooth_groups(const Mesh& mesh, const PlacedFaces& faces, double crease_angle);

}  // namespace knead::render
