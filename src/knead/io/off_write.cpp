// Writing OFF back: the bytes of the source with some numbers replaced.
#include "knead/io/binary_floats.h"
#include "knead/io/off.h"
#include "knead/io/splice.h"

namespace knead {
namespace {

Vec3d vector_at(const std::vector<double>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

std::string rewrite_text(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                         const Attribute* old_normals) {
  Splice splice(source.bytes);
  TextCursor text(source.bytes, source.format, std::get<OffLayout>(source.layout).vertex_begin);
  const auto next = [&] { return text.next(); };
  for (std::size_t i = 0; i < positions.size(); ++i) {
    splice.replace_changed(source.mesh.positions[i], positions[i], next);
    if (!normals.empty()) splice.replace_changed(vector_at(old_normals->values, i), normals[i], next);
    text.next_line();
  }
  return splice.finish();
}

std::string rewrite_binary(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                           const Attribute* old_normals) {
  check_fits_floats(positions);
  const OffLayout& layout = std::get<OffLayout>(source.layout);
  std::string bytes = source.bytes;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t begin = layout.vertex_begin + i * layout.width * sizeof(float);
    replace_floats(bytes, begin, source.mesh.positions[i], positions[i], layout.order);
    if (normals.empty()) continue;
    const Vec3d old = vector_at(old_normals->values, i);
    replace_floats(bytes, begin + 3 * sizeof(float), old, normals[i], layout.order);
  }
  return bytes;
}

}  // namespace

std::string rewrite_off(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions&) {
  const auto rewrite = std::get<OffLayout>(source.layout).binary ? rewrite_binary : rewrite_text;
  return rewrite(source, positions, normals, source.mesh.find_attribute("normal"));
}

std::vector<std::string> off_source_losses(const ShapeFile& source) {
  if (std::get<OffLayout>(source.layout).all_read) return {};
  return {"numbers that are no colors of one kind are left out"};
}

}  // namespace knead
