// Bytes as text: base64 (RFC 4648). Internal to the library.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace knead::io_detail {

// Returns the bytes that base64 text stands for; nothing where it is malformed.
std::optional<std::string> from_base64(std::string_view text);
std::string to_base64(std::string_view bytes);

}  // namespace knead::io_detail
