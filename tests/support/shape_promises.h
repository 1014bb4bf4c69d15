// What every shape that was read from a file promises, whatever the file's bytes. For tests and fuzzers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/io/shape_file.h"
#include "knead/math/error.h"
#include "knead/mesh/flipped.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/triangulate.h"

namespace knead {

inline constexpr const char* kEveryFormat[] = {"ply", "obj", "off", "xyz", "glb", "stl"};  // the last two may refuse

inline std::string broken_mesh(const Mesh& mesh) {
  if (mesh.face_begin.front() != 0 || mesh.face_begin.back() != mesh.corner_vertex.size()) return "face_begin";
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face_begin[f + 1] < mesh.face_begin[f] + 3) return "a face of fewer than three corners";
  }
  for (const std::uint32_t v : mesh.corner_vertex) {
    if (v >= mesh.vertex_count()) return "a vertex index";
  }
  for (const Vec3d& p : mesh.positions) {
    if (!is_finite(p)) return "a position that is not finite";
  }
  const std::size_t elements[] = {mesh.vertex_count(), mesh.corner_vertex.size(), mesh.face_count()};
  for (const Attribute& attribute : mesh.attributes) {
    const std::size_t components = static_cast<std::size_t>(attribute.components);
    if (attribute.values.size() != components * elements[static_cast<std::size_t>(attribute.domain)]) {
      return "the number of values of " + attribute.name;
    }
    for (const double value : attribute.values) {
      if (!std::isfinite(value)) return "a value that is not finite of " + attribute.name;
    }
  }
  return measure(mesh).components > mesh.face_count() ? "more components than faces" : "";
}

// Whether the file holds coordinates as floats whatever the options.
inline bool holds_floats(const ShapeFile& shape) {
  if (const StlLayout* stl = std::get_if<StlLayout>(&shape.layout)) return stl->binary;
  if (const OffLayout* off = std::get_if<OffLayout>(&shape.layout)) return off->binary;
  return shape.format == "glb";
}

// Whether each position is read as the file holds it: in a GLB file, where its node leaves it.
inline std::vector<bool> held_positions(const ShapeFile& shape) {
  std::vector<bool> held(shape.mesh.vertex_count(), true);
  const GlbLayout* glb = std::get_if<GlbLayout>(&shape.layout);
  if (glb == nullptr) return held;
  for (const GlbBlock& block : glb->blocks) {
    const bool is_placed = !(block.placement.linear == Mat3d{} && block.placement.offset == Vec3d{});
    for (std::size_t i = block.first; is_placed && i < block.first + block.count; ++i) held[i] = false;
  }
  return held;
}

// The positions of the corners as the file holds them: what STL keeps of a mesh.
inline std::vector<Vec3d> corner_positions(const Mesh& mesh, bool as_floats) {
  std::vector<Vec3d> corners;
  for (const Triangle& triangle : triangulate(mesh)) {
    for (const std::uint32_t v : triangle) {
      corners.push_back(as_floats ? Vec3d(Vec3f(mesh.positions[v])) : mesh.positions[v]);
    }
  }
  return corners;
}

// What differs between a mesh and what was read back of it; empty if nothing does.
inline std::string difference(const Mesh& mesh, const ShapeFile& back, bool as_floats) {
  const bool same_faces = back.mesh.face_begin == mesh.face_begin && back.mesh.corner_vertex == mesh.corner_vertex;
  if (back.format == "stl" || (back.format == "glb" && !same_faces)) {  // GLB: cut into triangles, or split at seams
    return corner_positions(back.mesh, false) == corner_positions(mesh, as_floats) ? "" : "corners";
  }
  if (back.mesh.vertex_count() != mesh.vertex_count()) return "the number of vertices";
  const std::vector<bool> held = held_positions(back);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    if (!held[i]) continue;
    const Vec3d p = as_floats ? Vec3d(Vec3f(mesh.positions[i])) : mesh.positions[i];
    if (!(back.mesh.positions[i] == p)) return "the position of vertex " + std::to_string(i);
  }
  return back.format == "xyz" || same_faces ? "" : "faces";
}

// What Knead wrote, read back; never refused.
inline std::string broken_file(const std::string& format, const std::string& bytes, const Mesh& mesh, bool as_floats) {
  try {
    const std::string what = difference(mesh, parse_shape(bytes, format, "written"), as_floats);
    return what.empty() ? "" : format + " as written has other " + what;
  } catch (const InvalidInput& error) {
    return format + " as written is refused: " + error.what();
  }
}

// The promise that the shape breaks: a sound mesh; the same bytes where nothing moves; and where all moves, the new
// shape read back, in its own format and in every other. Empty if it breaks none. Throws InvalidInput where a format
// cannot hold the moved coordinates.
inline std::string broken_promise(const ShapeFile& shape) {
  if (std::string what = broken_mesh(shape.mesh); !what.empty()) return what;
  if (serialize_shape(shape.format, shape, shape.mesh.positions) != shape.bytes) return "other bytes";
  Mesh moved = shape.mesh;
  for (Vec3d& p : moved.positions) p = {p.y * 0.5, p.x * 0.5 + 1, p.z};
  count_flipped(shape.mesh, shape.mesh.positions, moved.positions);
  for (const std::string format : kEveryFormat) {
    const bool is_own = format == shape.format;
    if (format == "stl" && !is_own && moved.face_count() == 0) continue;
    const std::string bytes = serialize_shape(format, shape, moved.positions, {.double_coordinates = true});
    const bool as_floats = is_own ? holds_floats(shape) : format == "stl" || format == "glb";
    if (std::string what = broken_file(format, bytes, moved, as_floats); !what.empty()) return what;
  }
  return "";
}

}  // namespace knead
