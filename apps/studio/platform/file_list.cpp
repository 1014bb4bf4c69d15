#include "platform/file_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <system_error>

namespace knead::studio {

namespace fs = std::filesystem;

namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool ends_in(const std::string& name, std::span<const std::string> extensions) {
  const std::string end = lower(fs::path(name).extension().string());
  return extensions.empty() || std::find(extensions.begin(), extensions.end(), end) != extensions.end();
}

}  // namespace

FileList list_files(const fs::path& folder, std::span<const std::string> extensions) {
  FileList list;
  std::error_code error;
  fs::directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    ListedFile file{entry->path().filename().string()};
    if (file.name.starts_with('.')) continue;
    std::error_code ignored;
    file.is_folder = entry->is_directory(ignored);
    if (!file.is_folder) file.bytes = entry->file_size(ignored);
    if (ignored) file.bytes = 0;
    if (file.is_folder || ends_in(file.name, extensions)) list.files.push_back(file);
  }
  if (error) list.problem = folder.string() + " cannot be listed: " + error.message();
  std::sort(list.files.begin(), list.files.end(), [](const ListedFile& a, const ListedFile& b) {
    if (a.is_folder != b.is_folder) return a.is_folder;
    const std::string x = lower(a.name);
    const std::string y = lower(b.name);
    return x != y ? x < y : a.name < b.name;
  });
  return list;
}

std::string with_extension(const std::string& name, std::span<const std::string> extensions,
                           const std::string& extension) {
  const std::string own = std::filesystem::path(name).extension().string();
  const bool are_letters = std::all_of(own.begin(), own.end(), [](char c) { return c == '.' || (c | 0x20) >= 'a'; });
  // What looks like the extension of another kind of file is left for the message that there is none.
  const bool is_meant = extensions.size() > 1 && own.size() >= 4 && own.size() <= 6 && are_letters;
  return is_meant || (!extensions.empty() && ends_in(name, extensions)) ? name : name + extension;
}

std::string size_text(std::uintmax_t bytes) {
  constexpr std::array<const char*, 4> units{"KB", "MB", "GB", "TB"};
  if (bytes < 1000) return fmt::format("{} bytes", bytes);
  double size = static_cast<double>(bytes) / 1000;
  std::size_t unit = 0;
  while (size >= 999.5 && unit + 1 < units.size()) {
    size /= 1000;
    ++unit;
  }
  return fmt::format("{:.{}f} {}", size, size < 9.95 ? 1 : 0, units[unit]);
}

}  // namespace knead::studio
