// Any bytes as a shape file of KNEAD_FUZZED_FORMAT: refused with InvalidInput, or a shape that keeps its promises, is
// written back byte for byte, and is read back as written once it has moved.
#include <cstdint>
#include <cstdlib>

#include "knead/io/shape_file.h"
#include "knead/math/error.h"
#include "knead/mesh/flipped.h"
#include "knead/mesh/measures.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void check(const knead::ShapeFile& shape, const std::string& bytes) {
  const knead::Mesh& mesh = shape.mesh;
  require(mesh.face_begin.back() == mesh.corner_vertex.size());
  for (const std::uint32_t v : mesh.corner_vertex) require(v < mesh.vertex_count());
  for (const knead::Vec3d& p : mesh.positions) require(knead::is_finite(p));
  require(knead::serialize_shape(shape.format, shape, mesh.positions) == bytes);
  knead::measure(mesh);
  std::vector<knead::Vec3d> moved = mesh.positions;
  for (knead::Vec3d& p : moved) p = {p.y * 0.5, p.x * 0.5 + 1, p.z};
  knead::count_flipped(mesh, mesh.positions, moved);
  const std::string written = knead::serialize_shape(shape.format, shape, moved, {.double_coordinates = true});
  require(knead::parse_shape(written, shape.format, "written").mesh.positions == moved);
  const std::string other = shape.format == "ply" ? "obj" : "ply";
  const std::string converted = knead::serialize_shape(other, shape, moved);
  require(knead::parse_shape(converted, other, "converted").mesh.corner_vertex == mesh.corner_vertex);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(data, data + size);
  try {
    check(knead::parse_shape(bytes, KNEAD_FUZZED_FORMAT, "fuzzed"), bytes);
  } catch (const knead::InvalidInput&) {
    return 0;
  }
  return 0;
}
