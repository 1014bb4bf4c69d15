// What a file dialog shows of a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace knead::studio {

struct ListedFile {
  std::string name;
  bool is_folder = false;
  std::uintmax_t bytes = 0;
};

struct FileList {
  std::vector<ListedFile> files;  // folders first, each group by name, upper and lower case alike
  std::string problem;            // why the folder cannot be listed; empty: it can
};

// The folders, and the files whose names end in one of the extensions (".ply", upper or lower case; none: all). Names
// that begin with a dot are left out.
FileList list_files(const std::filesystem::path& folder, std::span<const std::string> extensions);

// The name with the extension unless it ends in one of those given.
std::string with_extension(const std::string& name, std::span<const std::string> extensions,
                           const std::string& extension);

// "417 bytes", "3.4 MB".
std::string size_text(std::uintmax_t bytes);

}  // namespace knead::studio
