// The attributes of the vertices that a GLB file's primitives have. Internal to the GLB reader.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "knead/io/glb/accessor.h"

namespace knead::io_detail::glb {

// An attribute of a primitive that becomes one of the mesh.
struct Semantic {
  const char* key;   // in the file
  const char* name;  // of the mesh's attribute
  std::optional<std::size_t> Block::*accessor;
};

inline constexpr std::array<Semantic, 4> kSemantics = {{{"NORMAL", "normal", &Block::normal},
                                                        {"TANGENT", "tangent", &Block::tangent},
                                                        {"TEXCOORD_0", "uv", &Block::uv},
                                                        {"COLOR_0", "color", &Block::color}}};

// The attributes that some block has: directions in world coordinates and of length 1. Where a block has none, colors
// are white and others 0, which a note says. Throws InvalidInput for accessors that do not fit.
std::vector<Attribute> read_attributes(const Document& document, const std::vector<Block>& blocks,
                                       std::vector<std::string>& notes);

// Whether an attribute of that key in the file becomes one of the mesh.
bool is_read(const std::string& key);

// The direction of a vector; zero for zero and for what is not finite.
Vec3d direction(const Vec3d& v);

}  // namespace knead::io_detail::glb
