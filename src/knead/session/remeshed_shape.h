// A shape on its way through strokes that are remeshed. Internal to the session room.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/mesh/mesh.h"
#include "knead/remesh/remesh.h"

namespace knead::session_detail {

struct RemeshedShape {
  Mesh mesh;
  std::vector<std::uint32_t> face_source;          // of the mesh at the beginning
  std::vector<std::uint32_t> vertex_source;        // the same, or kNewVertex
  std::vector<bool> touched;                       // for each vertex: whether it, or the surface there, was moved
  std::optional<std::vector<MeshEdge>> creases{};  // of the shape at the beginning, as far as it was remeshed
  std::vector<std::uint32_t> steps;                // accepted, of each vertex
  RemeshCounts counts;                             // of all strokes
  AdvectResult work;                               // of all path lines
  bool renumbered = false;                         // vertices have other numbers than at the beginning
};

RemeshedShape unmoved(const Mesh& mesh);

// Moves the shape through a flow, and remeshes it by the options, if any; their face_labels are of the faces at the
// beginning. Returns what the remesh gave, its mesh moved
// out into the shape. On another status than done in shape.work the shape is as it was, but for that.
std::optional<Remeshed> move_and_remesh(const Flow& flow, const AdvectOptions& move,
                                        const std::optional<RemeshOptions>& remesh, RemeshedShape& shape);

}  // namespace knead::session_detail
