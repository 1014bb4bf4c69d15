// Writing points in text: a new file, or the source's bytes with some numbers replaced.
#include <algorithm>
#include <optional>
#include <utility>

#include "io/cloud/cloud.h"
#include "io/mesh_builder.h"
#include "io/text.h"

namespace knead::detail::xyz {
namespace {

constexpr std::array<std::string_view, 6> kExtensions = {"txt", "asc", "pts", "csv", "xyzn", "xyzrgb"};

std::string_view next_number(Words& words) {
  std::string_view word = words.next_on_line();
  while (!word.empty() && !is_number(word)) word = words.next_on_line();
  return word;
}

// Calls visit(row's fields, number of the point) for each point of a table that the mesh has.
template <class Visit>
void for_each_point(const ShapeFile& source, const Visit& visit) {
  const Layout& layout = layout_of<Layout>(source);
  Rows rows(source.bytes, layout.points_begin, layout.table->separator);
  std::size_t point = 0;
  for (std::size_t row = 0; rows.next(); ++row) {
    if (!is_unplaced(layout.unplaced, row, point)) visit(rows.fields(), point++);
  }
}

std::string rewrite_table(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                          const WriteOptions& options) {
  const Layout& layout = layout_of<Layout>(source);
  struct Change {
    std::string_view word;
    double from = 0;
    double to = 0;
    bool is_normal = false;
  };
  Splice splice(source.bytes, options.decimals);
  const Attribute* normal = normals.empty() ? nullptr : source.mesh.find_attribute("normal");
  for_each_point(source, [&](const std::vector<std::string_view>& fields, std::size_t point) {
    std::vector<Change> changes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from = source.mesh.positions[point][axis];
      changes.push_back({fields[layout.table->position[axis]], from, positions[point][axis]});
    }
    for (std::size_t axis = 0; axis < layout.normal.size() && normal != nullptr; ++axis) {
      if (layout.normal[axis] >= fields.size() || fields[layout.normal[axis]].empty()) continue;
      const double from = normal->values[3 * point + axis];
      changes.push_back({fields[layout.normal[axis]], from, normals[point][axis], true});
    }
    const auto is_before = [](const Change& a, const Change& b) { return a.word.data() < b.word.data(); };
    std::sort(changes.begin(), changes.end(), is_before);
    for (const Change& change : changes) {
      if (change.is_normal) splice.replace_component(change.word, change.from, change.to);
      if (!change.is_normal) splice.replace_coordinate(change.word, change.from, change.to);
    }
  });
  return splice.finish();
}

// The one attribute that can stand after x y z.
std::optional<Attribute> held_attribute(const Mesh& mesh) {
  if (std::optional<Attribute> normal = vertex_attribute(mesh, "normal", 3)) return normal;
  if (std::optional<Attribute> color = vertex_attribute(mesh, "color", 3)) return color;
  return vertex_attribute(mesh, "color", 4);
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options) {
  const Layout& layout = layout_of<Layout>(source);
  if (layout.table) return rewrite_table(source, positions, normals, options);
  Splice splice(source.bytes, options.decimals);
  Words words(source.bytes, source.format);
  words.go_to(layout.points_begin);
  const Attribute* normal = normals.empty() ? nullptr : source.mesh.find_attribute("normal");
  std::size_t point = 0;
  for (std::size_t row = 0; row < positions.size() + layout.unplaced.size(); ++row, words.next_line()) {
    std::string_view first = words.next();
    if (is_unplaced(layout.unplaced, row, point)) continue;
    if (layout.label_first) first = words.next_on_line();
    const auto next = [&] { return first.empty() ? words.next_on_line() : std::exchange(first, {}); };
    splice.replace_changed(source.mesh.positions[point], positions[point], next);
    if (normal != nullptr) {
      const double* old = normal->values.data() + 3 * point;
      splice.replace_direction({old[0], old[1], old[2]}, normals[point], [&] { return next_number(words); });
    }
    ++point;
  }
  return splice.finish();
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  const Layout& layout = layout_of<Layout>(source);
  if (layout.table) {
    for_each_point(source, [&](const std::vector<std::string_view>& fields, std::size_t) {
      for (const std::size_t column : layout.table->position) visit(fields[column]);
    });
    return;
  }
  Words words(source.bytes, source.format);
  words.go_to(layout.points_begin);
  for (std::size_t i = source.mesh.vertex_count() + layout.unplaced.size(); i > 0; --i, words.next_line()) {
    std::string_view word = words.next();
    if (layout.label_first) word = words.next_on_line();
    for (std::size_t axis = 0; axis < 3; ++axis, word = words.next_on_line()) visit(word);
  }
}

// A new file: x y z and the normal, or if there is none the color as three numbers from 0 to 255.
std::string generate(const Mesh& mesh, const WriteOptions& options) {
  const std::optional<Attribute> held = held_attribute(mesh);
  std::string text;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    append_point(text, mesh.positions[i], options.decimals);
    for (std::size_t c = 0; held && c < 3; ++c) {
      const double value = held->values[i * static_cast<std::size_t>(held->components) + c];
      text += ' ';
      append_real(text, held->name == "color" ? as_byte(value, held->type) : value);
    }
    text += '\n';
  }
  return text;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  if (mesh.face_count() > 0) losses.push_back("XYZ cannot hold faces");
  const std::optional<Attribute> held = held_attribute(mesh);
  for (const Attribute& attribute : mesh.attributes) {
    if (!held || attribute.name != held->name || attribute.components != held->components) {
      losses.push_back("XYZ cannot hold '" + attribute.name + "'");
      continue;
    }
    if (attribute.name != "color") continue;
    if (attribute.components > 3) losses.push_back("XYZ cannot hold the alpha of colors");
    if (attribute.type != NumberType::uint8) losses.push_back("XYZ holds colors as whole numbers from 0 to 255");
  }
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::string> losses;
  if (!layout.columns_read) losses.emplace_back("the numbers after x y z are left out");
  if (layout.has_names) losses.emplace_back("the names of the columns are left out");
  if (layout.labels || layout.label_first) losses.emplace_back("words that are no numbers are left out");
  if (!layout.unplaced.empty()) losses.push_back(unplaced_loss(layout.unplaced.size()));
  return losses;
}

}  // namespace
}  // namespace knead::detail::xyz

const knead::detail::Codec knead::detail::xyz_codec{.name = "xyz",
                                                    .extensions = xyz::kExtensions,
                                                    .read = xyz::read,
                                                    .rewrite = xyz::rewrite,
                                                    .generate = xyz::generate,
                                                    .losses = xyz::losses,
                                                    .source_losses = xyz::source_losses,
                                                    .visit_coordinates = xyz::visit_coordinates};
