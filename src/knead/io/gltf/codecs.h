// Decompresses what glTF's extensions compress, with the libraries draco and meshoptimizer where this build has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead::io_detail::gltf {

// Whether this build can decompress.
bool has_draco();
bool has_meshopt();

// The contents of a buffer view that EXT_meshopt_compression compresses; the names are those of the extension.
struct MeshoptView {
  std::size_t stride = 0;
  std::size_t count = 0;
  std::string mode;    // ATTRIBUTES, TRIANGLES or INDICES
  std::string filter;  // NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL
};

// Returns count * stride bytes; nothing for a damaged view, or one that the extension does not allow. A view that
// declares more than the codec can pack into so few bytes is damaged: memory stays below 512 bytes for each byte.
std::optional<std::string> decode_meshopt(std::string_view bytes, const MeshoptView& view);

// An attribute that a Draco mesh holds under a number, as an accessor wants it.
struct DracoAttribute {
  std::uint32_t id = 0;
  NumberType type = NumberType::float32;
  std::size_t components = 1;
};

struct DracoMesh {
  std::size_t vertices = 0;
  std::vector<std::uint32_t> corners;   // three for each triangle
  std::vector<std::string> attributes;  // as little-endian numbers side by side, in the order asked for
};

// Returns the mesh; nothing for damaged bytes, an attribute that is not there, more than `most` vertices or corners, or
// attributes of more than 64 bytes for each of `most`.
std::optional<DracoMesh> decode_draco(std::string_view bytes, const std::vector<DracoAttribute>& attributes,
                                      std::size_t most);

}  // namespace knead::io_detail::gltf
