// Writing PLY: a new file, which is binary and little-endian, or the source's header and another mesh.
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"

namespace knead::detail::ply {
namespace {

// The attributes as PLY holds them: numbers per vertex, numbers per face, and u v per corner as a list per face.
struct Holdings {
  std::vector<Attribute> vertex;
  std::vector<Attribute> face;
  std::optional<Attribute> corner_uv;
  std::vector<std::string> losses;
};

Holdings sort_attributes(const Mesh& mesh) {
  Holdings held;
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain == Domain::vertex) {
      held.vertex.push_back(attribute);
    } else if (attribute.domain == Domain::face) {
      held.face.push_back(attribute);
    } else if (std::optional<Attribute> merged = merge_corners(mesh, attribute)) {
      held.vertex.push_back(*std::move(merged));
    } else if (attribute.name == "uv" && attribute.components == 2) {
      held.corner_uv = attribute;
    } else {
      held.losses.push_back("PLY cannot hold '" + attribute.name + "' that differs between the faces at a vertex");
    }
  }
  return held;
}

std::string property_name(const Attribute& attribute, int component) {
  const std::size_t i = static_cast<std::size_t>(component);
  if (attribute.name == "normal" && i < 3) return std::array{"nx", "ny", "nz"}[i];
  if (attribute.name == "uv" && i < 2) return std::array{"s", "t"}[i];
  if (attribute.name == "color" && i < 4) return std::array{"red", "green", "blue", "alpha"}[i];
  return attribute.components == 1 ? attribute.name : attribute.name + std::to_string(component);
}

void append_properties(std::string& header, const std::vector<Attribute>& attributes) {
  for (const Attribute& attribute : attributes) {
    for (int c = 0; c < attribute.components; ++c) {
      header +=
          "property " + std::string(type_name(stored_type(attribute.type))) + " " + property_name(attribute, c) + "\n";
    }
  }
}

constexpr bool kSwapped = std::endian::native == std::endian::big;  // in new files

// A value of an attribute as near as its type can hold it.
double nearest(NumberType type, double value) { return type == NumberType::float32 ? nearest_of(type, value) : value; }

void append_values(std::string& bytes, const std::vector<Attribute>& attributes, std::size_t element) {
  for (const Attribute& attribute : attributes) {
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    for (std::size_t c = 0; c < n; ++c)
      append_binary(bytes, stored_type(attribute.type), nearest(attribute.type, attribute.values[element * n + c]),
                    kSwapped);
  }
}

std::size_t largest_face(const Mesh& mesh) {
  std::size_t largest = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) largest = std::max(largest, mesh.face(f).size());
  return largest;
}

std::string header_for(const Mesh& mesh, const Holdings& held, StoredType coordinate, StoredType length,
                       StoredType uv_length) {
  const std::string type(type_name(coordinate));
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertex_count()) +
                       "\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
  append_properties(header, held.vertex);
  header += "element face " + std::to_string(mesh.face_count()) + "\nproperty list " + std::string(type_name(length)) +
            " int vertex_indices\n";
  if (held.corner_uv) header += "property list " + std::string(type_name(uv_length)) + " float texcoord\n";
  append_properties(header, held.face);
  return header + "end_header\n";
}

void check_range(const Mesh& mesh) {
  for (const Vec3d& p : mesh.positions) {
    if (fits_floats(p)) continue;
    throw InvalidInput("a coordinate does not fit in a float; use double precision");
  }
}

void append_corner_uv(std::string& bytes, const Mesh& mesh, const Attribute& uv, std::size_t f, StoredType length) {
  append_binary(bytes, length, 2.0 * static_cast<double>(mesh.face(f).size()), kSwapped);
  for (std::size_t i = 2 * std::size_t{mesh.face_begin[f]}; i < 2 * std::size_t{mesh.face_begin[f + 1]}; ++i) {
    append_binary(bytes, StoredType::float32, nearest(NumberType::float32, uv.values[i]), kSwapped);
  }
}

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  if (!options.double_coordinates) check_range(mesh);
  const Holdings held = sort_attributes(mesh);
  const StoredType coordinate = options.double_coordinates ? StoredType::float64 : StoredType::float32;
  const std::size_t largest = largest_face(mesh);
  const StoredType length = largest < 256 ? StoredType::uint8 : StoredType::uint32;
  const StoredType uv_length = largest < 128 ? StoredType::uint8 : StoredType::uint32;
  std::string bytes = header_for(mesh, held, coordinate, length, uv_length);
  bytes.reserve(bytes.size() + mesh.vertex_count() * 24 + mesh.face_count() * 4 + mesh.corner_vertex.size() * 4);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_binary(bytes, coordinate, mesh.positions[i][axis], kSwapped);
    append_values(bytes, held.vertex, i);
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    append_binary(bytes, length, static_cast<double>(mesh.face(f).size()), kSwapped);
    for (const std::uint32_t v : mesh.face(f)) append_binary(bytes, StoredType::int32, v, kSwapped);
    if (held.corner_uv) append_corner_uv(bytes, mesh, *held.corner_uv, f, uv_length);
    append_values(bytes, held.face, f);
  }
  return bytes;
}

void append_row_losses(const Layout& layout, std::vector<std::string>& losses) {
  if (!layout.unplaced.empty()) losses.push_back(unplaced_loss(layout.unplaced.size()));
  if (layout.surplus) losses.emplace_back("numbers beyond those that the header declares are left out");
}

std::vector<std::string> losses(const Mesh& mesh) { return sort_attributes(mesh).losses; }

std::vector<std::string> source_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  for (const Element& element : layout_of<Layout>(source).elements) {
    const bool is_known = element.name == "vertex" || element.name == "face" || element.name == "tristrips";
    if (!is_known) losses.push_back("element '" + element.name + "' is left out");
    for (const Property& property : element.properties) {
      const bool is_read = is_index_list(element, property) || (element.name == "face" && property.name == "texcoord");
      if (is_known && property.is_list && !is_read) losses.push_back("list '" + property.name + "' is left out");
    }
  }
  append_row_losses(layout_of<Layout>(source), losses);
  return losses;
}

// A file like the source, with its header, and another mesh.

// What becomes of an element: vertices and faces are those of the new mesh, rows are kept as they are.
enum class Fate { dropped, vertices, faces, rows };

// A list of vertices that has a place in the new file.
bool is_face_list(const Sink& sink) { return sink.kind == Sink::Kind::faces; }

// Whether the numbers of an element are none that could count vertices.
bool cannot_refer(const Element& element) {
  return std::none_of(element.properties.begin(), element.properties.end(), [](const Property& p) {
    const bool is_byte = p.type == StoredType::int8 || p.type == StoredType::uint8;
    return p.is_list || (is_integer(p.type) && !is_byte);
  });
}

std::vector<Fate> fates_of(const Layout& layout, const Plan& plan) {
  std::vector<Fate> fates(layout.elements.size(), Fate::dropped);
  std::size_t faces = layout.elements.size();
  for (std::size_t e = 0; e < layout.elements.size(); ++e) {
    const Element& element = layout.elements[e];
    if (element.name == "face" && std::any_of(plan.sinks[e].begin(), plan.sinks[e].end(), is_face_list)) faces = e;
    const bool is_known = element.name == "face" || element.name == "tristrips";
    if (!is_known && cannot_refer(element)) fates[e] = Fate::rows;
    if (e == layout.vertex_element) fates[e] = Fate::vertices;
  }
  for (std::size_t e = 0; e < layout.elements.size() && faces == layout.elements.size(); ++e) {
    if (layout.elements[e].name == "tristrips") faces = e;
  }
  if (faces < fates.size()) fates[faces] = Fate::faces;
  return fates;
}

// The attributes of the plan that the mesh has, by their number in the plan: the reader drops some.
std::vector<const Attribute*> held_attributes(const Plan& plan, const Mesh& source, const Mesh& mesh) {
  std::vector<const Attribute*> held(plan.attributes.size(), nullptr);
  std::size_t next = 0;
  for (std::size_t i = 0; i < held.size() && next < source.attributes.size(); ++i) {
    const Attribute& planned = plan.attributes[i];
    const Attribute& read = source.attributes[next];
    const bool is_it = planned.name == read.name && planned.domain == read.domain;
    if (is_it) held[i] = &mesh.attributes[next++];
  }
  return held;
}

// A number that the type holds.
std::string integer_text(StoredType type, double number) {
  if (type == StoredType::uint64) return std::to_string(static_cast<std::uint64_t>(number));
  return std::to_string(static_cast<std::int64_t>(number));
}

// A property of the new file.
struct Column {
  Sink sink;
  StoredType type = StoredType::float32;      // of the number, or of the list's items
  StoredType count_type = StoredType::uint8;  // of a list's length
  const Attribute* attribute = nullptr;
};

class Writer {
 public:
  Writer(const NewMesh& shape, const WriteOptions& options)
      : source_(shape.source),
        mesh_(shape.mesh),
        options_(options),
        layout_(layout_of<Layout>(shape.source)),
        plan_(make_plan(layout_, shape.source.format)),
        fates_(fates_of(layout_, plan_)),
        held_(held_attributes(plan_, shape.source.mesh, shape.mesh)),
        ascii_(layout_.encoding == Encoding::ascii),
        swapped_(is_swapped(layout_.encoding)),
        bytes_(source_.all()),
        line_end_(line_end_of(bytes_)) {}

  std::string run() {
    for (std::size_t e = 0; e < layout_.elements.size(); ++e) plan_element(e);
    result_.reserve(bytes_.size());
    copy_until(layout_.body_begin);
    for (std::size_t e = 0; e < layout_.elements.size(); ++e) append_element(e);
    append_rest();
    return std::move(result_);
  }

 private:
  void copy_until(std::size_t end) {
    result_.append(bytes_, copied_, end - copied_);
    copied_ = end;
  }

  void replace(std::size_t begin, std::size_t end, std::string_view text) {
    copy_until(begin);
    result_ += text;
    copied_ = end;
  }

  // The header's lines, and what is written below them.
  void plan_element(std::size_t e) {
    const Element& element = layout_.elements[e];
    columns_.emplace_back();
    if (fates_[e] == Fate::rows) return;
    const bool is_strips = fates_[e] == Fate::faces && element.name == "tristrips";
    const std::size_t count = fates_[e] == Fate::vertices ? mesh_.vertex_count() : mesh_.face_count();
    if (fates_[e] == Fate::dropped) {
      replace(element.line_begin, element.line_end, "");
    } else if (is_strips) {
      columns_[e].push_back({{Sink::Kind::faces, 0, 0}, StoredType::int32, StoredType::uint8, nullptr});
      replace(
          element.line_begin, element.line_end,
          "element face " + std::to_string(count) + line_end_ + "property list uchar int vertex_indices" + line_end_);
    } else {
      replace(element.count_begin, element.count_end, std::to_string(count));
    }
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if (is_strips || fates_[e] == Fate::dropped || !plan_property(e, property, plan_.sinks[e][p])) {
        replace(property.line_begin, property.line_end, "");
      }
    }
  }

  // Whether the property stays.
  bool plan_property(std::size_t e, const Property& property, const Sink& sink) {
    Column column{sink, property.type, property.count_type, nullptr};
    const bool is_of_attribute = sink.kind == Sink::Kind::attribute || sink.kind == Sink::Kind::corner_uv;
    if (is_of_attribute) column.attribute = held_[sink.attribute];
    if (sink.kind == Sink::Kind::skip || sink.kind == Sink::Kind::strips) return false;
    if (is_of_attribute && column.attribute == nullptr) return false;
    if (sink.kind == Sink::Kind::coordinate && needs_doubles(property.type, sink.component)) {
      widen(property, StoredType::float64, column);
    }
    const double most = static_cast<double>(mesh_.vertex_count()) - 1;
    const bool is_narrow = !is_integer(property.type) || nearest_of(property.type, most) < most;
    if (sink.kind == Sink::Kind::faces && is_narrow) {
      widen(property, most > nearest_of(StoredType::int32, most) ? StoredType::uint32 : StoredType::int32, column);
    }
    columns_[e].push_back(column);
    return true;
  }

  bool needs_doubles(StoredType type, std::size_t axis) const {
    if (type == StoredType::float32) return options_.double_coordinates;
    return std::any_of(mesh_.positions.begin(), mesh_.positions.end(),
                       [&](const Vec3d& p) { return nearest_of(type, p[axis]) != p[axis]; });
  }

  // The word for the type, in the style of the one that stands there.
  void widen(const Property& property, StoredType type, Column& column) {
    const bool sized = std::isdigit(static_cast<unsigned char>(bytes_[property.type_end - 1])) != 0;
    const std::string_view sized_name = type == StoredType::float64 ? "float64"
                                        : type == StoredType::int32 ? "int32"
                                                                    : "uint32";
    replace(property.type_begin, property.type_end, sized ? sized_name : type_name(type));
    column.type = type;
  }

  void append_element(std::size_t e) {
    const Element& element = layout_.elements[e];
    if (fates_[e] == Fate::rows) append_rows(element);
    if (fates_[e] == Fate::vertices && !append_columns(columns_[e])) {
      for (std::size_t i = 0; i < mesh_.vertex_count(); ++i) append_row(columns_[e], i);
    }
    if (fates_[e] == Fate::faces && !append_faces(columns_[e])) {
      for (std::size_t f = 0; f < mesh_.face_count(); ++f) append_row(columns_[e], f);
    }
  }

  // Appends the rows of all vertices as append_row() would, a column at a time, if they are binary numbers. Returns
  // whether they are.
  bool append_columns(const std::vector<Column>& columns) {
    std::size_t stride = 0;
    for (const Column& column : columns) {
      const bool is_coordinate = column.sink.kind == Sink::Kind::coordinate;
      if (ascii_ || swapped_ || (!is_coordinate && column.sink.kind != Sink::Kind::attribute)) return false;
      stride += size_of(column.type);
    }
    const auto is_too_far = [&](const Vec3d& p) {
      return std::any_of(columns.begin(), columns.end(), [&](const Column& column) {
        return column.sink.kind == Sink::Kind::coordinate && column.type == StoredType::float32 &&
               !fits_float(p[column.sink.component]);
      });
    };
    if (std::any_of(mesh_.positions.begin(), mesh_.positions.end(), is_too_far)) return false;  // which says so
    const std::size_t first = result_.size();
    result_.resize(first + mesh_.vertex_count() * stride);
    char* to = result_.data() + first;
    for (const Column& column : columns) {
      const auto n = column.attribute != nullptr ? static_cast<std::size_t>(column.attribute->components) : 0;
      const std::size_t k = column.sink.component;
      visit_type(column.type, [&](auto number) {
        for (std::size_t i = 0; i < mesh_.vertex_count(); ++i) {
          const double value = n > 0 ? column.attribute->values[i * n + k] : mesh_.positions[i][k];
          number = static_cast<decltype(number)>(nearest_of(column.type, value));
          std::memcpy(to + i * stride, &number, sizeof number);
        }
      });
      to += size_of(column.type);
    }
    return true;
  }

  // Appends the rows of all faces as append_row() would, if they are binary lists of corners and nothing else. Returns
  // whether they are.
  bool append_faces(const std::vector<Column>& columns) {
    constexpr std::size_t most = 127;  // corners, which a byte with a sign can count
    const bool is_plain = columns.size() == 1 && columns[0].sink.kind == Sink::Kind::faces && !ascii_ && !swapped_ &&
                          size_of(columns[0].count_type) == 1 &&
                          (columns[0].type == StoredType::int32 || columns[0].type == StoredType::uint32);
    if (!is_plain) return false;
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      if (mesh_.face(f).size() > most) return false;
    }
    const std::size_t first = result_.size();
    result_.resize(first + mesh_.face_count() + sizeof(std::uint32_t) * mesh_.corner_vertex.size());
    char* to = result_.data() + first;
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      const std::span<const std::uint32_t> face = mesh_.face(f);
      *to++ = static_cast<char>(face.size());
      std::memcpy(to, face.data(), face.size_bytes());
      to += face.size_bytes();
    }
    return true;
  }

  // The source's own; text begins and ends with whole lines.
  void append_rows(const Element& element) {
    std::string_view rows = bytes_.substr(element.rows_begin, element.rows_end - element.rows_begin);
    while (ascii_ && !rows.empty() && (is_blank(rows.front()) || is_line_end(rows.front()))) rows.remove_prefix(1);
    result_ += rows;
    if (ascii_ && !rows.empty()) result_ += line_end_;
  }

  void append_row(const std::vector<Column>& columns, std::size_t row) {
    at_line_begin_ = true;
    for (const Column& column : columns) {
      switch (column.sink.kind) {
        case Sink::Kind::coordinate:
          append_coordinate(column, row);
          break;
        case Sink::Kind::faces:
          append_face(column, mesh_.face(row));
          break;
        case Sink::Kind::corner_uv:
          append_corner_uv(column, row);
          break;
        default: {
          const std::size_t n = static_cast<std::size_t>(column.attribute->components);
          append_number(column.type, column.attribute->values[row * n + column.sink.component]);
        }
      }
    }
    if (ascii_) result_ += line_end_;
  }

  void append_face(const Column& column, std::span<const std::uint32_t> face) {
    append_number(column.count_type, static_cast<double>(face.size()));
    const bool same_bytes = column.type == StoredType::int32 || column.type == StoredType::uint32;
    if (same_bytes && !ascii_ && !swapped_) {
      result_.append(reinterpret_cast<const char*>(face.data()), face.size_bytes());
    } else {
      for (const std::uint32_t v : face) append_number(column.type, v);
    }
  }

  void append_coordinate(const Column& column, std::size_t row) {
    const double value = mesh_.positions[row][column.sink.component];
    if (column.type == StoredType::float32 && !fits_float(value)) {
      throw InvalidInput("vertex " + std::to_string(row) +
                         " has coordinates beyond the range of float; use double precision");
    }
    if (!ascii_ || !options_.decimals || is_integer(column.type)) return append_number(column.type, value);
    begin_number();
    append_decimals(result_, value, options_.decimals);
  }

  void append_corner_uv(const Column& column, std::size_t face) {
    append_number(column.count_type, 2.0 * static_cast<double>(mesh_.face(face).size()));
    for (std::size_t i = 2 * std::size_t{mesh_.face_begin[face]}; i < 2 * std::size_t{mesh_.face_begin[face + 1]}; ++i)
      append_number(column.type, column.attribute->values[i]);
  }

  void begin_number() {
    if (!at_line_begin_) result_ += ' ';
    at_line_begin_ = false;
  }

  void append_number(StoredType type, double value) {
    const double number = nearest_of(type, value);
    if (!ascii_) return append_binary(result_, type, number, swapped_);
    begin_number();
    if (is_integer(type)) {
      result_ += integer_text(type, number);
    } else if (type == StoredType::float32) {
      append_real(result_, static_cast<float>(number));
    } else {
      append_real(result_, number);
    }
  }

  // What follows the last element.
  void append_rest() {
    std::string_view rest = bytes_.substr(layout_.elements.back().rows_end);
    if (ascii_ && !rest.empty() && is_line_end(rest.front())) rest.remove_prefix(line_end_of(rest).size());
    result_ += rest;
  }

  SourceBytes source_;
  const Mesh& mesh_;
  const WriteOptions& options_;
  const Layout& layout_;
  Plan plan_;
  std::vector<Fate> fates_;
  std::vector<const Attribute*> held_;
  bool ascii_;
  bool swapped_;
  std::string_view bytes_;  // of the source
  std::string line_end_;
  std::vector<std::vector<Column>> columns_;  // of each element
  bool at_line_begin_ = true;
  std::string result_;
  std::size_t copied_ = 0;
};

std::string remeshed(const NewMesh& shape, const WriteOptions& options) { return Writer(shape, options).run(); }

std::vector<std::string> remesh_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const Plan plan = make_plan(layout, source.format);
  const std::vector<Fate> fates = fates_of(layout, plan);
  const std::vector<const Attribute*> held = held_attributes(plan, source.mesh, source.mesh);
  std::vector<std::string> losses;
  for (std::size_t e = 0; e < fates.size(); ++e) {
    const Element& element = layout.elements[e];
    if (fates[e] == Fate::rows) continue;
    if (element.name == "tristrips") {
      losses.emplace_back("strips of triangles become faces");
    } else if (fates[e] == Fate::dropped && element.count > 0) {
      losses.push_back("element '" + element.name + "' is left out");
    }
    for (std::size_t p = 0; p < element.properties.size() && fates[e] != Fate::dropped; ++p) {
      const Sink& sink = plan.sinks[e][p];
      const bool is_of_attribute = sink.kind == Sink::Kind::attribute || sink.kind == Sink::Kind::corner_uv;
      const bool is_kept = is_of_attribute ? held[sink.attribute] != nullptr : sink.kind != Sink::Kind::skip;
      const char* what = element.properties[p].is_list ? "list '" : "property '";
      if (!is_kept) losses.push_back(what + element.properties[p].name + "' is left out");
    }
  }
  append_row_losses(layout, losses);
  return losses;
}

}  // namespace
}  // namespace knead::detail::ply

const knead::detail::Codec knead::detail::ply_codec{.name = "ply",
                                                    .read = ply::read,
                                                    .read_in_pieces = ply::read_in_pieces,
                                                    .summarize = ply::summarize,
                                                    .rewrite_in_pieces = ply::rewrite,
                                                    .with_copies = ply::with_copies,
                                                    .writes_edits = ply::writes_edits,
                                                    .generate = ply::generate,
                                                    .losses = ply::losses,
                                                    .source_losses = ply::source_losses,
                                                    .remeshed = ply::remeshed,
                                                    .remesh_losses = ply::remesh_losses,
                                                    .stores_floats = ply::stores_floats,
                                                    .can_widen = true,
                                                    .visit_coordinates = ply::visit_coordinates};
