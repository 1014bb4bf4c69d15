#include "knead/io/gltf/buffers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <system_error>

#include "knead/io/text.h"

namespace knead::io_detail::gltf {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> without_percents(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      text += uri[i];
      continue;
    }
    constexpr std::string_view digits = "0123456789abcdef";
    unsigned value = 0;
    for (const std::size_t at : {i + 1, i + 2}) {
      const char c = at < uri.size() ? uri[at] : ' ';
      const std::size_t digit = digits.find(c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c);
      if (digit == std::string_view::npos) return std::nullopt;
      value = 16 * value + static_cast<unsigned>(digit);
    }
    text += static_cast<char>(value);
    i += 2;
  }
  return text;
}

}  // namespace

std::optional<std::string> plain_file_name(std::string_view uri) {
  std::optional<std::string> name = without_percents(uri);
  if (!name) return std::nullopt;
  if (name->starts_with("./")) name->erase(0, 2);
  const bool is_plain = name->find_first_of(std::string_view("/\\:\0", 4)) == std::string::npos;
  if (!is_plain || name->empty() || *name == "." || *name == "..") return std::nullopt;
  return name;
}

std::string with_percents(std::string_view name) {
  std::string uri;
  for (const char c : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
    if (is_plain || static_cast<unsigned char>(c) >= 0x80) {
      uri += c;
    } else {
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return uri;
}

std::string read_beside(const fs::path& folder, const std::string& file, const glb::Value& buffer) {
  const fs::path path = folder / file;
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  if (type == fs::file_type::not_found) {
    buffer.fail(fmt::format("is in the file {}, which is not there; put it beside this one", in_quotes(file)));
  }
  if (type != fs::file_type::regular) {
    buffer.fail(fmt::format("is in {}, which is no regular file; put a copy beside this one", in_quotes(file)));
  }
  std::ifstream stream(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && !stream.eof()) {
    buffer.fail(fmt::format("is in the file {}, which cannot be read; check its permissions", in_quotes(file)));
  }
  return bytes;
}

std::string free_name(const fs::path& target, const std::string& wanted, bool is_own,
                      const std::vector<std::string>& taken) {
  std::error_code error;
  if (is_own || !fs::exists(fs::symlink_status(target.parent_path() / wanted, error))) return wanted;
  const std::string stem = target.stem().string();
  std::string name = stem + ".bin";
  for (int i = 1; std::find(taken.begin(), taken.end(), name) != taken.end(); ++i) {
    name = fmt::format("{}-{}.bin", stem, i);
  }
  return name;
}

}  // namespace knead::io_detail::gltf
