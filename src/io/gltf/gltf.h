// The buffers of glTF: in the file's binary chunk, in its text as base64 (data URIs), or in files beside it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/codec.h"
#include "io/glb/glb.h"
#include "io/numbers.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::io_detail::gltf {

struct Buffer {
  enum class Kind { chunk, data, file };

  Kind kind = Kind::chunk;
  std::string head;       // of a data URI: "data:...;base64,"
  std::string file;       // the plain name of a file
  std::size_t begin = 0;  // of its bytes among those of all buffers
  std::size_t size = 0;
};

// Returns the name of a file in the same folder that a URI names: no folder, no scheme; "%20" is a blank. Nothing for
// other URIs.
std::optional<std::string> plain_file_name(std::string_view uri);

// Returns the URI of a plain file name.
std::string with_percents(std::string_view name);

// Returns the bytes of a regular file of that name in the folder, no link. Throws InvalidInput that names the buffer.
std::string read_beside(const std::filesystem::path& folder, const std::string& file, const glb::Value& buffer);

// Returns a name that may be written beside `target`: `wanted` where nothing stands there, or where it is what the
// source itself has there; else one made of the target's name that is none of `taken`.
std::string free_name(const std::filesystem::path& target, const std::string& wanted, bool is_own,
                      const std::vector<std::string>& taken);

// Decompresses what glTF's extensions compress, with the libraries draco and meshoptimizer where this build has them.

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

// glTF files whose meshes are compressed. Source: Khronos, KHR_draco_mesh_compression and EXT_meshopt_compression.

// Returns the extension of a buffer view that compresses it, or null.
const char* meshopt_extension(const Json& view);

// Returns whether a text names a compression that this build can undo.
bool names_codec(std::string_view text);

// Returns the file without compression, and adds a note; the same bytes where nothing is compressed that this build can
// decompress. `bytes` is a GLB file with one buffer, its binary chunk. Throws InvalidInput that names the view or the
// primitive.
std::string decompressed(std::string bytes, const std::string& name, std::vector<std::string>& notes);

// glTF 2.0 as text (.gltf), and GLB files whose buffers are not in their binary chunk. A file is read as the GLB file that holds the same (glb/glb.h) and written back as it came. Source:
// Khronos, "glTF 2.0 Specification" (2021).

struct Layout {
  ShapeFile glb;                // the same as a GLB file with one buffer, its binary chunk
  std::vector<Buffer> buffers;  // of the source
  std::string buffers_text;     // the JSON array of them
  std::filesystem::path path;   // of the source, beside which the files of buffers are
};

// Returns a GLB file as text, with its buffer as a data URI.
std::string as_text(const std::string& glb_bytes);

}  // namespace knead::io_detail::gltf
