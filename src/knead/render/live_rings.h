// What LiveMesh knows of a mesh's topology.
#pragma once

#include <cstdint>
#include <vector>

#include "knead/mesh/mesh.h"
#include "knead/render/smooth_groups.h"

namespace knead::render {

// The vertices round every drawn vertex d: list[begin[d]] to list[begin[d + 1]], so that every two that follow each
// other are those after and before one corner of the group; kNoVertex parts chains that do not hang together.
struct Rings {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> list;
};

Rings make_rings(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups);

struct PolygonEdges {
  std::vector<std::uint32_t> list;  // pairs of drawn vertices, each edge of the mesh once
  bool closed = true;               // every edge has two faces, which go along it in opposite directions
};

PolygonEdges polygon_edges(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups);

}  // namespace knead::render
