// The buffers of glTF: in the file's binary chunk, in its text as base64 (data URIs), or in files beside it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/base64.h"
#include "knead/io/glb/json.h"

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

}  // namespace knead::io_detail::gltf
