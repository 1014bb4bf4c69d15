// Writing OFF back: the bytes of the source with some numbers replaced.
#include "knead/io/binary_floats.h"
#include "knead/io/layout.h"
#include "knead/io/off/layout.h"
#include "knead/io/off/off.h"
#include "knead/io/splice.h"

namespace knead::io_detail::off {
namespace {

Vec3d vector_at(const std::vector<double>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

std::string rewrite_text(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                         const Attribute* old_normals, const WriteOptions& options) {
  Splice splice(source.bytes, options.decimals);
  TextCursor text(source.bytes, source.format, layout_of<Layout>(source).vertex_begin);
  const auto next = [&] { return text.next(); };
  for (std::size_t i = 0; i < positions.size(); ++i) {
    splice.replace_changed(source.mesh.positions[i], positions[i], next);
    if (!normals.empty()) splice.replace_direction(vector_at(old_normals->values, i), normals[i], next);
    text.next_line();
  }
  return splice.finish();
}

std::string rewrite_binary(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                           const Attribute* old_normals, const WriteOptions&) {
  check_fits_floats(positions);
  const Layout& layout = layout_of<Layout>(source);
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

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options) {
  const auto rewrite = layout_of<Layout>(source).binary ? rewrite_binary : rewrite_text;
  return rewrite(source, positions, normals, source.mesh.find_attribute("normal"), options);
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  if (layout_of<Layout>(source).binary) return;
  TextCursor text(source.bytes, source.format, layout_of<Layout>(source).vertex_begin);
  for (std::size_t i = 0; i < source.mesh.vertex_count(); ++i, text.next_line()) {
    for (std::size_t axis = 0; axis < 3; ++axis) visit(text.next());
  }
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  if (layout_of<Layout>(source).all_read) return {};
  return {"numbers that are not colors of one kind are left out"};
}

bool stores_floats(const ShapeFile& source) { return layout_of<Layout>(source).binary; }

}  // namespace knead::io_detail::off
