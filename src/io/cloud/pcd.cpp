// Reading PCD, the point files of the Point Cloud Library (PCD_V7), and writing it: a new file, or the source's bytes
// with some numbers replaced.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "io/cloud/cloud.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail::pcd {
namespace {

constexpr bool kSwapped = std::endian::native == std::endian::big;  // binary files are little-endian

bool is_attribute_name(const std::string& name) { return name == "normal" || name == "color" || name == "uv"; }

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name)
      : shape_(shape), name_(name), layout_(parse_header(shape.bytes, name)) {}

  Layout run() {
    const std::size_t left = shape_.bytes.size() - layout_.body_begin;
    const std::size_t least = layout_.row_size * (layout_.ascii ? 2 : 1);
    if (least > 0 && layout_.points > (left + (layout_.ascii ? 1 : 0)) / least) {
      throw InvalidInput(Place{name_}, std::to_string(layout_.points) + " points are declared, but only " +
                                           std::to_string(left) + " bytes follow; the file is cut short");
    }
    plan();
    if (layout_.ascii) {
      read_text();
    } else {
      read_binary_rows();
    }
    put_real_colors();
    remove_unplaced(unplaced_, shape_.mesh);
    if (shape_.mesh.positions.empty()) {
      throw InvalidInput(Place{name_}, "no point has finite coordinates; there is no shape in it");
    }
    add_notes();
    layout_.unplaced = std::move(unplaced_.rows);
    return std::move(layout_);
  }

 private:
  // Where the numbers of each field go.
  void plan() {
    const auto has_three = [&] {
      return std::count_if(layout_.fields.begin(), layout_.fields.end(),
                           [](const Field& field) { return field.role == Role::normal; }) == 3;
    };
    if (!has_three()) {
      for (Field& field : layout_.fields) field.role = field.role == Role::normal ? Role::other : field.role;
    }
    attribute_.assign(layout_.fields.size(), kNone);
    for (std::size_t f = 0; f < layout_.fields.size(); ++f) plan_field(f);
    shape_.mesh.positions.resize(layout_.points);
    real_colors_.resize(layout_.fields.size());
    for (std::size_t f = 0; f < layout_.fields.size(); ++f) {
      const bool is_real = layout_.fields[f].role == Role::color && !is_integer(layout_.fields[f].type);
      if (is_real && attribute_[f] != kNone) real_colors_[f].resize(layout_.points);
    }
    for (Attribute& attribute : shape_.mesh.attributes) {
      attribute.values.resize(layout_.points * static_cast<std::size_t>(attribute.components));
    }
  }

  void plan_field(std::size_t f) {
    const Field& field = layout_.fields[f];
    std::vector<Attribute>& attributes = shape_.mesh.attributes;
    const auto known = [&](const std::string& attribute) {
      const auto found =
          std::find_if(attributes.begin(), attributes.end(), [&](const Attribute& a) { return a.name == attribute; });
      return static_cast<std::size_t>(found - attributes.begin());
    };
    const auto add = [&](const std::string& attribute, NumberType type, int components) {
      attribute_[f] = known(attribute);
      if (attribute_[f] == attributes.size()) attributes.push_back({attribute, Domain::vertex, type, components, {}});
    };
    if (field.role == Role::normal) {
      add("normal", number_type(field.type), 3);
    } else if (field.role == Role::color && known("color") == attributes.size()) {
      add("color", NumberType::uint8, field.name == "rgba" ? 4 : 3);
    } else if (field.role == Role::other && field.count == 1 && !is_attribute_name(field.name) &&
               known(field.name) == attributes.size()) {
      add(field.name, number_type(field.type), 1);
    }
  }

  void put(std::size_t f, std::size_t row, double value, std::size_t byte) {
    const Field& field = layout_.fields[f];
    if (field.role == Role::position) {
      shape_.mesh.positions[row][field.axis] = value;
      if (!std::isfinite(value)) unplaced_.add(row, byte);
    } else if (attribute_[f] != kNone) {
      Attribute& attribute = shape_.mesh.attributes[attribute_[f]];
      const std::size_t component = field.role == Role::normal ? field.axis : 0;
      attribute.values[row * static_cast<std::size_t>(attribute.components) + component] = finite_(value);
    }
  }

  // Red, green, blue and alpha of the bits 0xAARRGGBB.
  void put_color(std::size_t f, std::size_t row, std::uint32_t bits) {
    if (attribute_[f] == kNone) return;
    Attribute& color = shape_.mesh.attributes[attribute_[f]];
    constexpr int shifts[4] = {16, 8, 0, 24};
    const std::size_t n = static_cast<std::size_t>(color.components);
    for (std::size_t c = 0; c < n; ++c) color.values[row * n + c] = (bits >> shifts[c]) & 0xffu;
  }

  // Colors of type F have two spellings: the bits of the float are the color, or its value is the color as a whole
  // number, as PCL writes it in text. Bits with an alpha of 0 or 255 make floats that are tiny, huge or NaN.
  void put_real_colors() {
    const auto is_whole = [](double v) { return v == std::floor(v) && v >= -0x1p31 && v <= 0x1p32 - 1; };
    for (std::size_t f = 0; f < layout_.fields.size(); ++f) {
      const std::vector<double>& reals = real_colors_[f];
      const bool are_whole = std::all_of(reals.begin(), reals.end(), is_whole);
      if (!are_whole && !layout_.ascii) continue;  // the bits are read already
      for (std::size_t row = 0; row < reals.size(); ++row) {
        put_color(f, row, color_bits(are_whole ? StoredType::int64 : StoredType::float32, reals[row]));
      }
    }
  }

  void read_binary_rows() {
    const char* row = shape_.bytes.data() + layout_.body_begin;
    for (std::size_t i = 0; i < layout_.points; ++i, row += layout_.row_size) {
      for (std::size_t f = 0; f < layout_.fields.size(); ++f) {
        const Field& field = layout_.fields[f];
        if (!real_colors_[f].empty()) {
          real_colors_[f][i] = read_binary(row + field.offset, field.type, kSwapped);
        }
        if (field.role == Role::color) {
          std::uint32_t bits = 0;
          std::memcpy(&bits, row + field.offset, sizeof bits);
          put_color(f, i, kSwapped ? swap_bytes(bits) : bits);
        } else if (field.count == 1) {
          put(f, i, read_binary(row + field.offset, field.type, kSwapped), 0);
        }
      }
    }
    note_rest(shape_.bytes.size() - layout_.body_begin - layout_.points * layout_.row_size);
  }

  void read_text() {
    TextCursor text(shape_.bytes, name_, layout_.body_begin);
    for (std::size_t i = 0; i < layout_.points; ++i) {
      std::string_view word = text.next();
      for (std::size_t f = 0; f < layout_.fields.size(); ++f) {
        const Field& field = layout_.fields[f];
        for (std::size_t c = 0; c < field.count; ++c, word = text.next_on_line()) {
          const double value = text.real(word, "a number");
          if (!real_colors_[f].empty()) {
            real_colors_[f][i] = value;
          } else if (field.role == Role::color) {
            put_color(f, i, color_bits(field.type, value));
          } else if (field.count == 1) {
            put(f, i, value, text.word_begin());
          }
        }
      }
      if (!word.empty()) text.fail("more numbers on the line than the header's fields have; repair the file");
    }
    if (!text.next().empty()) note_rest(shape_.bytes.size() - text.word_begin());
  }

  static std::uint32_t color_bits(StoredType type, double value) {
    if (!is_integer(type)) return bit_cast<std::uint32_t>(static_cast<float>(std::isfinite(value) ? value : 0.0));
    if (!(std::abs(value) <= 0x1p32 - 1)) return 0;
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
  }

  void note_rest(std::size_t bytes) {
    if (bytes > 0) shape_.notes.push_back(counted(bytes, "byte follows", "bytes follow") + " the last point");
  }

  void add_notes() {
    if (!unplaced_.rows.empty()) shape_.notes.push_back(unplaced_note(unplaced_.rows.size()));
    finite_.append_note(shape_.notes);
    shape_.notes.emplace_back(kCloudNote);
  }

  static constexpr std::size_t kNone = ~std::size_t{0};

  ShapeFile& shape_;
  const std::string& name_;
  Layout layout_;
  Unplaced unplaced_;
  std::vector<std::size_t> attribute_;            // of each field
  std::vector<std::vector<double>> real_colors_;  // of each field: its numbers, if they are colors of type F
  FiniteValues finite_;
};

// The numbers that may differ, row by row of the file.
class Moved {
 public:
  Moved(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals)
      : source_(source), layout_(layout_of<Layout>(source)), positions_(positions), normals_(normals) {
    if (!normals.empty()) old_normals_ = vertex_normals_of(source);
  }

  // Calls visit(row, field, old value, new value) for each coordinate and component of a normal of points with a place.
  template <class Visit>
  void for_each(Visit visit) const {
    std::size_t point = 0;
    for (std::size_t row = 0; row < layout_.points; ++row) {
      if (is_unplaced(layout_.unplaced, row, point)) continue;
      for (const Field& field : layout_.fields) {
        if (field.role == Role::position) {
          visit(row, field, source_.mesh.positions[point][field.axis], positions_[point][field.axis]);
        } else if (field.role == Role::normal && !normals_.empty()) {
          visit(row, field, old_normals_[point][field.axis], normals_[point][field.axis]);
        }
      }
      ++point;
    }
  }

 private:
  const ShapeFile& source_;
  const Layout& layout_;
  std::span<const Vec3d> positions_;
  std::span<const Vec3d> normals_;
  std::vector<Vec3d> old_normals_;
};

std::string rewrite_binary(const ShapeFile& source, const Moved& moved) {
  const Layout& layout = layout_of<Layout>(source);
  std::string bytes = source.bytes;
  moved.for_each([&](std::size_t row, const Field& field, double from, double to) {
    if (from == to) return;
    if (field.type == StoredType::float32 && !fits_float(to)) {
      throw InvalidInput("point " + std::to_string(row) +
                         " has moved to coordinates beyond the range of float, the file's type; write another format");
    }
    std::string number;
    append_binary(number, field.type, to, kSwapped);
    bytes.replace(layout.body_begin + row * layout.row_size + field.offset, number.size(), number);
  });
  return bytes;
}

// The words of a text, each in turn.
class Walk {
 public:
  explicit Walk(const ShapeFile& source)
      : row_size_(layout_of<Layout>(source).row_size),
        text_(source.bytes, source.format, layout_of<Layout>(source).body_begin) {}

  // That word of that row; later than the one before.
  std::string_view word(std::size_t row, std::size_t column) {
    std::string_view word;
    for (const std::size_t wanted = row * row_size_ + column + 1; taken_ < wanted; ++taken_) word = text_.next();
    return word;
  }

 private:
  std::size_t row_size_;
  TextCursor text_;
  std::size_t taken_ = 0;
};

// Points whose coordinates are not finite, which organised scans have, are left out of the mesh. "normal" (fields
// normal_x, normal_y, normal_z), "color" (3, of rgb; 4, of rgba; of type F as bits or as whole numbers), other fields
// of one number under their names. The pose of the viewpoint is not applied. A compressed file is kept, and written,
// uncompressed; a note says so.
void read(ShapeFile& shape, const std::string& name) {
  if (uncompress(shape.bytes, name)) shape.notes.emplace_back("the points are compressed and are written uncompressed");
  set_layout(shape, Reader(shape, name).run());
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options) {
  const Moved moved(source, positions, normals);
  if (!layout_of<Layout>(source).ascii) return rewrite_binary(source, moved);
  Splice splice(source.bytes, options.decimals);
  Walk walk(source);
  moved.for_each([&](std::size_t row, const Field& field, double from, double to) {
    const std::string_view word = walk.word(row, field.offset);
    if (field.role == Role::position) {
      splice.replace_coordinate(word, from, to);
    } else {
      splice.replace_component(word, from, to);
    }
  });
  return splice.finish();
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::string> losses;
  for (const Field& field : layout.fields) {
    const bool is_kept = field.role != Role::other || source.mesh.find_attribute(field.name) != nullptr;
    if (!is_kept) losses.push_back("field '" + field.name + "' is left out");
  }
  if (!layout.unplaced.empty()) losses.push_back(unplaced_loss(layout.unplaced.size()));
  return losses;
}

bool stores_floats(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const auto is_float = [](const Field& f) { return f.role == Role::position && f.type == StoredType::float32; };
  return !layout.ascii && std::any_of(layout.fields.begin(), layout.fields.end(), is_float);
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  if (!layout_of<Layout>(source).ascii) return;
  Walk walk(source);
  Moved(source, source.mesh.positions, {}).for_each([&](std::size_t row, const Field& field, double, double) {
    visit(walk.word(row, field.offset));
  });
}

bool is_color(const Attribute& a) { return a.name == "color" && (a.components == 3 || a.components == 4); }
bool is_normal(const Attribute& a) { return a.name == "normal" && a.components == 3; }

bool is_held(const Attribute& attribute) {
  if (attribute.domain != Domain::vertex) return false;
  if (is_color(attribute) || is_normal(attribute)) return true;
  constexpr std::string_view taken[] = {"x",        "y",        "z",      "rgb",   "rgba", "normal_x",
                                        "normal_y", "normal_z", "normal", "color", "uv"};
  const bool has_blank = attribute.name.find_first_of(" \t\r\n\v\f#") != std::string::npos;
  return attribute.components == 1 && !attribute.name.empty() && !has_blank &&
         std::find(std::begin(taken), std::end(taken), attribute.name) == std::end(taken);
}

// The lines that have a word for each field.
struct Lines {
  std::string names = "FIELDS";
  std::string sizes = "SIZE";
  std::string types = "TYPE";
  std::string counts = "COUNT";

  void add(const std::string& name, std::size_t size, const char* type) {
    names += ' ' + name;
    sizes += ' ' + std::to_string(size);
    types += std::string(" ") + type;
    counts += " 1";
  }
};

StoredType stored_type(NumberType type) {
  for (const StoredType stored : {StoredType::int8, StoredType::uint8, StoredType::int16, StoredType::uint16,
                                  StoredType::int32, StoredType::uint32, StoredType::float32}) {
    if (number_type(stored) == type) return stored;
  }
  return StoredType::float64;
}

const char* letter_of(NumberType type) {
  if (!is_integer(type)) return "F";
  const bool is_unsigned = type == NumberType::uint8 || type == NumberType::uint16 || type == NumberType::uint32;
  return is_unsigned ? "U" : "I";
}

void append_fields(Lines& lines, const Attribute& attribute) {
  if (is_normal(attribute)) {
    for (const char* axis : {"x", "y", "z"}) lines.add(std::string("normal_") + axis, 4, "F");
  } else if (is_color(attribute)) {
    lines.add(attribute.components == 4 ? "rgba" : "rgb", 4, "U");
  } else {
    lines.add(attribute.name, detail::size_of(attribute.type), letter_of(attribute.type));
  }
}

void append_values(std::string& bytes, const Attribute& attribute, std::size_t i) {
  const std::size_t n = static_cast<std::size_t>(attribute.components);
  const double* values = attribute.values.data() + i * n;
  if (is_normal(attribute)) {
    for (std::size_t c = 0; c < 3; ++c) {
      append_binary(bytes, StoredType::float32, nearest_of(StoredType::float32, values[c]), kSwapped);
    }
  } else if (is_color(attribute)) {
    std::uint32_t bits = 0;
    constexpr int shifts[4] = {16, 8, 0, 24};
    for (std::size_t c = 0; c < n; ++c) {
      bits |= static_cast<std::uint32_t>(as_byte(values[c], attribute.type)) << shifts[c];
    }
    append_binary(bytes, StoredType::uint32, bits, kSwapped);
  } else {
    const StoredType type = stored_type(attribute.type);
    append_binary(bytes, type, nearest_of(type, values[0]), kSwapped);
  }
}

// A new binary file: coordinates as floats, or doubles if the options say so, and the attributes of vertices.
std::string generate(const Mesh& mesh, const WriteOptions& options) {
  if (!options.double_coordinates) check_fits_floats(mesh.positions);
  const StoredType coordinate = options.double_coordinates ? StoredType::float64 : StoredType::float32;
  Lines lines;
  for (const char* axis : {"x", "y", "z"}) lines.add(axis, size_of(coordinate), "F");
  for (const Attribute& attribute : mesh.attributes) {
    if (is_held(attribute)) append_fields(lines, attribute);
  }
  const std::string count = std::to_string(mesh.vertex_count());
  std::string bytes = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + lines.names + "\n" + lines.sizes +
                      "\n" + lines.types + "\n" + lines.counts + "\nWIDTH " + count +
                      "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_binary(bytes, coordinate, mesh.positions[i][axis], kSwapped);
    for (const Attribute& attribute : mesh.attributes) {
      if (is_held(attribute)) append_values(bytes, attribute, i);
    }
  }
  return bytes;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  if (mesh.face_count() > 0) losses.emplace_back("PCD cannot hold faces");
  for (const Attribute& attribute : mesh.attributes) {
    if (!is_held(attribute)) {
      losses.push_back("PCD cannot hold '" + attribute.name + "'");
    } else if (is_color(attribute) && attribute.type != NumberType::uint8) {
      losses.emplace_back("PCD holds colors as whole numbers from 0 to 255");
    }
  }
  return losses;
}

}  // namespace
}  // namespace knead::detail::pcd

const knead::detail::Codec knead::detail::pcd_codec{.name = "pcd",
                                                    .read = pcd::read,
                                                    .rewrite = pcd::rewrite,
                                                    .generate = pcd::generate,
                                                    .losses = pcd::losses,
                                                    .source_losses = pcd::source_losses,
                                                    .stores_floats = pcd::stores_floats,
                                                    .visit_coordinates = pcd::visit_coordinates};
