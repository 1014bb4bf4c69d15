#include "knead/io/formats.h"

#include <algorithm>
#include <array>

#include "knead/io/cloud/pcd.h"
#include "knead/io/cloud/ptx.h"
#include "knead/io/cloud/xyz.h"
#include "knead/io/glb/glb.h"
#include "knead/io/gltf/gltf.h"
#include "knead/io/obj/obj.h"
#include "knead/io/off/off.h"
#include "knead/io/ply/ply.h"
#include "knead/io/stl/stl.h"
#include "knead/math/error.h"

namespace knead::io_detail {
namespace {

bool always(const ShapeFile&) { return true; }
bool never(const ShapeFile&) { return false; }

constexpr std::array<std::string_view, 6> kPointExtensions = {"txt", "asc", "pts", "csv", "xyzn", "xyzrgb"};

constexpr std::array<Format, 9> kFormats = {
    {{"ply",
      ply::parse,
      nullptr,
      nullptr,
      ply::generate,
      ply::losses,
      ply::source_losses,
      ply::remeshed,
      ply::remesh_losses,
      nullptr,
      never,
      false,
      ply::reads_floats,
      ply::visit_coordinates,
      {},
      ply::rewrite,
      ply::is_binary,
      ply::summarize},
     {"obj", obj::parse, nullptr, obj::rewrite, obj::generate, obj::losses, obj::source_losses, obj::remeshed,
      obj::remesh_losses, obj::face_labels, never, false, never, obj::visit_coordinates},
     {"glb", gltf::parse_glb, gltf::parse_glb_beside, gltf::rewrite, glb::generate, glb::losses, gltf::source_losses,
      gltf::remeshed, gltf::remesh_losses, gltf::face_labels, always, true, always},
     {"gltf", gltf::parse, gltf::parse_beside, gltf::rewrite, gltf::generate, glb::losses, gltf::source_losses,
      gltf::remeshed, gltf::remesh_losses, gltf::face_labels, always, true, always},
     {"stl", stl::parse, nullptr, stl::rewrite, stl::generate, stl::losses, stl::source_losses, stl::remeshed,
      stl::remesh_losses, nullptr, stl::stores_floats, true, stl::stores_floats, stl::visit_coordinates},
     {"off", off::parse, nullptr, off::rewrite, off::generate, off::losses, off::source_losses, off::remeshed,
      off::remesh_losses, nullptr, off::stores_floats, false, off::stores_floats, off::visit_coordinates},
     {"xyz", xyz::parse, nullptr, xyz::rewrite, xyz::generate, xyz::losses, xyz::source_losses, nullptr, nullptr,
      nullptr, never, false, never, xyz::visit_coordinates, kPointExtensions},
     {"pcd", pcd::parse, nullptr, pcd::rewrite, pcd::generate, pcd::losses, pcd::source_losses, nullptr, nullptr,
      nullptr, pcd::stores_floats, false, pcd::stores_floats, pcd::visit_coordinates},
     {"ptx", ptx::parse, nullptr, ptx::rewrite, ptx::generate, ptx::losses, ptx::source_losses, nullptr, nullptr,
      nullptr, never, false, never, ptx::visit_coordinates}}};

bool has_extension(const Format& format, std::string_view extension) {
  return format.name == extension ||
         std::find(format.extensions.begin(), format.extensions.end(), extension) != format.extensions.end();
}

}  // namespace

std::span<const Format> formats() { return kFormats; }

void check_decimals(const WriteOptions& options) {
  constexpr int most = 17;  // that a double can tell apart
  if (options.decimals.value_or(0) >= 0 && options.decimals.value_or(0) <= most) return;
  throw InvalidInput(std::to_string(*options.decimals) + " decimals; give 0 to " + std::to_string(most));
}

void write_own_format(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes) {
  gltf::write_beside(path, source, bytes);
}

const Format& format_with_extension(std::string_view extension, const std::string& file) {
  std::string supported;
  for (const Format& format : kFormats) {
    if (has_extension(format, extension)) return format;
    supported += (supported.empty() ? "." : ", .") + std::string(format.name);
    for (const std::string_view other : format.extensions) supported += ", ." + std::string(other);
  }
  const std::string what =
      extension.empty() ? "its name has no extension" : "format '" + std::string(extension) + "' is not supported";
  throw InvalidInput(Place{file}, what + "; use one of " + supported);
}

const Format& format_named(std::string_view name, const std::string& file) {
  std::string supported;
  for (const Format& format : kFormats) {
    if (format.name == name) return format;
    supported += (supported.empty() ? "" : ", ") + std::string(format.name);
  }
  throw InvalidInput(Place{file}, "format '" + std::string(name) + "' is not supported; use one of " + supported);
}

}  // namespace knead::io_detail
