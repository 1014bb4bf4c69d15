// The lines `vn` of an OBJ file after its shape has moved.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/io/obj/layout.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail::obj {

// One authored normal per corner of the source's mesh after its vertices moved to `after`; the zero vector where a
// corner has none. Corners that use one line at one vertex turn together (transport_normals).
std::vector<Vec3d> moved_corner_normals(const Mesh& mesh, const Layout& layout, std::span<const Vec3d> after);

// Lines `vn` that together say what the corners' normals are now. The first are those of the file, in their order, with
// new values; then those that are needed because corners which shared a line have turned apart.
struct NormalLines {
  struct Line {
    Vec3d normal;
    std::uint32_t source = 0;  // the line of the file that corners used before
  };
  std::vector<Line> lines;
  std::vector<std::uint32_t> corner_line;  // of each corner; kNoNormal: none. Empty: as in the file
};

// A line keeps its value where a corner that did not turn uses it; else it takes that of the first corner that does.
// Corners whose normals are equal to about 1e-4 of their length share a line.
NormalLines plan_normals(const Layout& layout, std::span<const Vec3d> corner_normals);

}  // namespace knead::io_detail::obj
