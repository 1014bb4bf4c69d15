// What an OBJ file holds besides a mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "knead/math/vec3.h"

namespace knead::io_detail::obj {

// The part of an OBJ file that a mesh does not hold.
struct Layout {
  std::vector<Vec3d> normals;                // the value of each vn
  std::vector<std::uint32_t> corner_normal;  // which vn each corner of the mesh uses, or kNoNormal; empty: none does
  bool normals_ahead = false;                // whether a face stands before a vn that it uses
  std::vector<std::string> material_files;   // what `mtllib` lines name: each line's words, and each line as a whole
  std::vector<std::uint32_t> unplaced;       // lines `v`, counted from 0, of vertices that the mesh lacks (unplaced.h)
  std::vector<std::string> other_keywords;   // of the lines that a mesh does not hold, e.g. "usemtl"; each once
};

}  // namespace knead::io_detail::obj
