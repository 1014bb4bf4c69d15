#include "knead/io/formats.h"

#include <array>

#include "knead/io/cloud/xyz.h"
#include "knead/io/glb/glb.h"
#include "knead/io/obj/obj.h"
#include "knead/io/off/off.h"
#include "knead/io/ply/ply.h"
#include "knead/io/stl/stl.h"
#include "knead/math/error.h"

namespace knead::io_detail {
namespace {

bool always(const ShapeFile&) { return true; }
bool never(const ShapeFile&) { return false; }

constexpr std::array<Format, 6> kFormats = {
    {{"ply", ply::parse, ply::rewrite, ply::generate, ply::losses, ply::source_losses, ply::remeshed,
      ply::remesh_losses, nullptr, never, false},
     {"obj", obj::parse, obj::rewrite, obj::generate, obj::losses, obj::source_losses, obj::remeshed,
      obj::remesh_losses, obj::face_labels, never, false},
     {"glb", glb::parse, glb::rewrite, glb::generate, glb::losses, glb::source_losses, glb::remeshed,
      glb::remesh_losses, glb::face_labels, always, true},
     {"stl", stl::parse, stl::rewrite, stl::generate, stl::losses, stl::source_losses, stl::remeshed,
      stl::remesh_losses, nullptr, stl::stores_floats, true},
     {"off", off::parse, off::rewrite, off::generate, off::losses, off::source_losses, off::remeshed,
      off::remesh_losses, nullptr, off::stores_floats, false},
     {"xyz", xyz::parse, xyz::rewrite, xyz::generate, xyz::losses, xyz::source_losses, nullptr, nullptr, nullptr, never,
      false}}};

}  // namespace

std::span<const Format> formats() { return kFormats; }

const Format& format_named(std::string_view name, const std::string& file) {
  std::string supported;
  for (const Format& format : kFormats) {
    if (format.name == name) return format;
    supported += (supported.empty() ? "." : ", .") + std::string(format.name);
  }
  const std::string what =
      name.empty() ? "its name has no extension" : "format '" + std::string(name) + "' is not supported";
  throw InvalidInput(Place{file}, what + "; use one of " + supported);
}

}  // namespace knead::io_detail
