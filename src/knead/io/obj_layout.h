// Where the numbers of an OBJ file are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "knead/math/vec3.h"

namespace knead {

// The part of an OBJ file that a mesh does not hold.
struct ObjLayout {
  std::vector<std::size_t> vertex_begin;     // the byte after the keyword `v` of each vertex
  std::vector<std::size_t> normal_begin;     // the byte after the keyword `vn` of each normal
  std::vector<Vec3d> normals;                // the value of each vn
  std::vector<std::uint32_t> corner_normal;  // which vn each corner of the mesh uses, or kNoNormal
  std::vector<std::string> other_keywords;   // of the lines that a mesh does not hold, e.g. "usemtl"; each once
};

}  // namespace knead
