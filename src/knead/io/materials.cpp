// The material files that an OBJ file names.
#include <fstream>
#include <iterator>
#include <system_error>

#include "knead/io/atomic_file.h"
#include "knead/io/layout.h"
#include "knead/io/obj/layout.h"
#include "knead/io/shape_file.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = 64 << 20;

bool is_plain_name(const std::string& name) {
  const bool ends_well = name.size() > 4 && fs::path(name).extension() == ".mtl";
  return ends_well && name.find_first_of("/\\:") == std::string::npos && name.find('\0') == std::string::npos;
}

bool is_worth_copying(const fs::path& from, const fs::path& to) {
  std::error_code error;
  const bool is_there = fs::is_regular_file(fs::symlink_status(from, error));  // a link may lead anywhere
  return is_there && fs::file_size(from, error) <= kMostBytes && !error && !fs::exists(fs::symlink_status(to, error));
}

fs::path folder_of(const fs::path& path) {
  const fs::path parent = path.parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

}  // namespace

std::vector<fs::path> copy_material_files(const ShapeFile& shape, const fs::path& source, const fs::path& target) {
  std::vector<fs::path> copied;
  const auto* layout = io_detail::find_layout<io_detail::obj::Layout>(shape);
  std::error_code error;
  if (layout == nullptr || fs::equivalent(folder_of(source), folder_of(target), error)) return copied;
  for (std::string name : layout->material_files) {
    if (name.substr(0, 2) == "./") name.erase(0, 2);
    if (!is_plain_name(name)) continue;
    const fs::path from = folder_of(source) / name;
    const fs::path to = folder_of(target) / name;
    if (!is_worth_copying(from, to)) continue;
    std::ifstream file(from, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    if (!file) continue;
    write_file_atomically(to, bytes);
    copied.push_back(to);
  }
  return copied;
}

}  // namespace knead
