// What every shape that was read from a file promises, whatever the file's bytes. For tests and fuzzers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/cloud/cloud.h"
#include "io/gltf/gltf.h"
#include "io/solver/solver.h"
#include "io/threemf/threemf.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/split_faces.h"

namespace knead {

inline constexpr const char* kEveryFormat[] = {"ply", "obj", "off", "xyz", "pcd",  "ptx", "glb", "gltf",
                                               "stl", "3mf", "su2", "msh", "foam", "bdf", "inp", "unv"};

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

// Whether a file of the format holds the elements of a solver's mesh, and so is written from one of its own alone.
inline bool is_solver(const std::string& format) {
  return format == "su2" || format == "msh" || format == "foam" || format == "bdf" || format == "inp" ||
         format == "unv";
}

inline bool is_gltf(const std::string& format) { return format == "glb" || format == "gltf"; }

// Whether the file holds coordinates as floats whatever the options.
inline bool holds_floats(const ShapeFile& shape) { return stores_floats("shape." + shape.format, shape); }

// Whether each position is read as the file holds it: in a GLB file, where its node leaves it; in a PTX file, where its
// scan does.
inline std::vector<bool> held_positions(const ShapeFile& shape) {
  std::vector<bool> held(shape.mesh.vertex_count(), true);
  if (const detail::ptx::Layout* ptx = detail::find_layout<detail::ptx::Layout>(shape)) {
    for (const detail::ptx::Scan& scan : ptx->scans) {
      if (!scan.is_identity()) held.assign(held.size(), false);
    }
    return held;
  }
  if (const auto* solver = detail::find_layout<detail::solver::Layout>(shape)) {
    return std::vector<bool>(held.size(), !solver->rounds);
  }
  if (const auto* threemf = detail::find_layout<detail::threemf::Layout>(shape)) {
    for (const detail::threemf::Instance& instance : threemf->instances) {
      std::fill_n(held.begin() + instance.first_vertex, instance.vertices, instance.placement.is_identity());
    }
    return held;
  }
  const detail::gltf::Layout* gltf = detail::find_layout<detail::gltf::Layout>(shape);
  if (gltf == nullptr) return held;
  for (const detail::gltf::Block& block : gltf->blocks) {
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
  const bool may_cut = is_gltf(back.format) || back.format == "3mf";
  if (back.format == "stl" || (may_cut && !same_faces)) {  // GLB: cut into triangles, or split at seams
    return corner_positions(back.mesh, false) == corner_positions(mesh, as_floats) ? "" : "corners";
  }
  if (back.mesh.vertex_count() != mesh.vertex_count()) return "the number of vertices";
  const std::vector<bool> held = held_positions(back);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    if (!held[i]) continue;
    const Vec3d p = as_floats ? Vec3d(Vec3f(mesh.positions[i])) : mesh.positions[i];
    if (!(back.mesh.positions[i] == p)) return "the position of vertex " + std::to_string(i);
  }
  const bool is_cloud = back.format == "xyz" || back.format == "pcd" || back.format == "ptx" || is_solver(back.format);
  return is_cloud || same_faces ? "" : "faces";
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

// What differs between a mesh with other connectivity and what was read back of it; empty if nothing does.
inline std::string remade_difference(const ShapeFile& source, const Remade& remade, const ShapeFile& back) {
  const std::vector<std::uint32_t> order = file_order(source, remade);
  const std::vector<bool> held = held_positions(source);
  const bool is_placed = source.format == "3mf" && std::find(held.begin(), held.end(), false) != held.end();
  if (back.mesh.face_count() != order.size()) return "the number of faces";
  for (const Attribute& a : source.mesh.attributes) {
    const bool is_zero = std::all_of(a.values.begin(), a.values.end(), [](double value) { return value == 0; });
    if (!is_zero && back.mesh.find_attribute(a.name) == nullptr) return "attributes: no " + a.name;
  }
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::span<const std::uint32_t> expected = remade.mesh.face(order[k]);
    const std::span<const std::uint32_t> found = back.mesh.face(k);
    if (expected.size() != found.size()) return "the corners of face " + std::to_string(k);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const std::uint32_t v = expected[i];
      const bool is_exact = (v < source.mesh.vertex_count() || !is_gltf(source.format)) && !is_placed;
      if (is_exact && !(back.mesh.positions[found[i]] == remade.mesh.positions[v])) {
        return "a position of face " + std::to_string(k);
      }
    }
  }
  return "";
}

// Every other face is cut, and the shape written into its own format and read back.
inline std::string broken_remesh(const ShapeFile& shape) {
  if (shape.mesh.face_count() == 0) return "";
  const Remade remade = split_faces(shape.mesh, [](std::uint32_t f) { return f % 2 == 0; });
  const std::string bytes =
      serialize_remeshed(shape.format, shape, remade.mesh, remade.face_source, {.double_coordinates = true});
  try {
    const std::string what = remade_difference(shape, remade, parse_shape(bytes, shape.format, "remeshed"));
    return what.empty() ? "" : shape.format + " as remeshed has other " + what;
  } catch (const InvalidInput& error) {
    return shape.format + " as remeshed is refused: " + error.what();
  }
}

// What the summary of a file says that reading it as a shape does not; empty if nothing does.
inline std::string broken_summary(const ShapeFile& shape) {
  const ShapeSummary summary = parse_summary(shape.bytes, shape.format, "summary");
  const Mesh& mesh = shape.mesh;
  const Box box = shape_box(mesh);
  if (summary.format != shape.format) return "format in the summary";
  if (summary.vertices != mesh.vertex_count() || summary.faces != mesh.face_count()) return "counts in the summary";
  if (summary.triangles != triangulate(mesh).size()) return "number of triangles in the summary";
  if (summary.box.min != box.min || summary.box.max != box.max) return "box in the summary";
  std::vector<std::string> names;
  for (const Attribute& attribute : mesh.attributes) names.push_back(attribute.name);
  if (summary.attributes != names) return "attributes in the summary";
  std::vector<std::string> notes = shape.notes;
  std::erase_if(notes, [](const std::string& note) { return note.find("where the shape stands") != note.npos; });
  return summary.notes == notes ? "" : "notes in the summary";
}

// The promise that the shape breaks: a sound mesh; the same in its summary; the same bytes where nothing moves; and
// where all moves, the new shape read back, in its own format and in every other; and with other connectivity in its
// own. Empty if it breaks none. Throws InvalidInput where a format cannot hold the moved coordinates.
inline std::string broken_promise(const ShapeFile& shape) {
  if (std::string what = broken_mesh(shape.mesh); !what.empty()) return what;
  if (std::string what = broken_summary(shape); !what.empty()) return "other " + what;
  if (serialize_shape(shape.format, shape, shape.mesh.positions) != shape.bytes) return "other bytes";
  Mesh moved = shape.mesh;
  for (Vec3d& p : moved.positions) p = {p.y * 0.5, p.x * 0.5 + 1, p.z};
  count_flipped(shape.mesh, shape.mesh.positions, moved.positions);
  for (const std::string format : kEveryFormat) {
    const bool is_own = format == shape.format;
    const bool may_refuse =
        ((format == "stl" || format == "3mf") && moved.face_count() == 0) || format == "ptx" || is_solver(format);
    if (may_refuse && !is_own) continue;
    const std::string bytes = serialize_shape(format, shape, moved.positions, {.double_coordinates = true});
    const bool as_floats = is_own ? holds_floats(shape) : format == "stl" || is_gltf(format);
    if (std::string what = broken_file(format, bytes, moved, as_floats); !what.empty()) return what;
  }
  return broken_remesh(shape);
}

}  // namespace knead
