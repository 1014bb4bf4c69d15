// glTF files whose meshes are compressed. Source: Khronos, KHR_draco_mesh_compression and EXT_meshopt_compression.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knead/io/json.h"

namespace knead::io_detail::gltf {

// Returns the extension of a buffer view that compresses it, or null.
const char* meshopt_extension(const Json& view);

// Returns whether a text names a compression that this build can undo.
bool names_codec(std::string_view text);

// Returns the file without compression, and adds a note; the same bytes where nothing is compressed that this build can
// decompress. `bytes` is a GLB file with one buffer, its binary chunk. Throws InvalidInput that names the view or the
// primitive.
std::string decompressed(std::string bytes, const std::string& name, std::vector<std::string>& notes);

}  // namespace knead::io_detail::gltf
