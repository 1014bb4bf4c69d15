// Where the numbers of a GLB file are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "knead/math/mat3.h"

namespace knead::io_detail::glb {

struct Chunk {
  std::uint32_t type = 0;
  std::size_t begin = 0;  // of its contents
  std::size_t size = 0;
};

// How a node places its mesh: world = linear * local + offset.
struct Placement {
  Mat3d linear;
  Vec3d offset;
  Mat3d inverse;  // of linear
};

// Vertices of the mesh that come from one POSITION accessor, placed by one node.
struct Block {
  std::size_t first = 0;  // vertex of the mesh
  std::size_t count = 0;
  std::size_t node = 0;
  std::size_t mesh = 0;                 // of the file
  std::vector<std::size_t> primitives;  // of that mesh
  std::size_t position = 0;             // accessors
  std::optional<std::size_t> normal;
  std::optional<std::size_t> tangent;
  std::optional<std::size_t> uv;
  std::optional<std::size_t> color;
  Placement placement;
};

// Faces of the mesh, one after the other, that come from one primitive.
struct Faces {
  std::size_t first = 0;
  std::size_t block = 0;
  std::size_t primitive = 0;  // of the block's mesh
};

// The part of a GLB file that a mesh does not hold.
struct Layout {
  std::vector<Chunk> chunks;  // as in the file; the first is the JSON
  std::optional<std::size_t> bin;
  std::size_t end = 0;        // of the last chunk; what follows is kept
  std::vector<Block> blocks;  // the vertices in the mesh's order
  std::vector<Faces> faces;   // in the mesh's order; each goes on to where the next one begins
};

}  // namespace knead::io_detail::glb
