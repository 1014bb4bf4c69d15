// The header of a PCD file.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>

#include "io/cloud/cloud.h"
#include "io/formats.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::io_detail::pcd {
namespace {

constexpr std::size_t kMaxFields = 256;

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& name)
      : name_(name), text_(bytes, name, text_begin(bytes, name)) {}

  Layout run() {
    for (std::string_view keyword = text_.next(); keyword != "DATA"; keyword = text_.next()) read_line(keyword);
    const std::string_view encoding = text_.next_on_line();
    layout_.ascii = encoding == "ascii";
    if (encoding == "binary_compressed") layout_.compressed = text_.word_begin();
    if (!layout_.ascii && layout_.compressed == 0 && encoding != "binary") {
      text_.fail("expected 'DATA ascii', 'DATA binary' or 'DATA binary_compressed', found " + in_quotes(encoding));
    }
    text_.next_line();
    layout_.body_begin = text_.position();
    make_fields();
    count_points();
    return std::move(layout_);
  }

 private:
  void read_line(std::string_view keyword) {
    constexpr std::array<std::string_view, 9> known{"VERSION", "FIELDS", "SIZE",      "TYPE",  "COUNT",
                                                    "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS"};
    const std::string key(keyword == "COLUMNS" ? "FIELDS" : keyword);  // in the oldest files
    if (key.empty()) text_.fail("the header ends without a line 'DATA'; the file is cut short or no PCD");
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      text_.fail("unknown header line " + in_quotes(keyword) + "; is it a PCD file?");
    }
    if (!lines_[key].empty()) text_.fail("a second header line " + in_quotes(keyword) + "; repair the file");
    std::vector<std::string_view>& words = lines_[key];
    for (std::string_view word = text_.next_on_line(); !word.empty(); word = text_.next_on_line()) {
      if (words.size() == kMaxFields) text_.fail("more than 256 words in a header line; remove fields");
      words.push_back(word);
    }
    if (words.empty()) text_.fail("nothing follows " + in_quotes(keyword));
  }

  const std::vector<std::string_view>& words(const std::string& key) {
    const std::vector<std::string_view>& found = lines_[key];
    if (found.empty()) throw InvalidInput(Place{name_}, "the header has no line '" + key + "'; add one");
    return found;
  }

  std::size_t whole(const std::string& key, std::size_t i, std::size_t most) {
    return text_.whole(words(key)[i], most, "a whole number");
  }

  StoredType type_of(std::string_view letter, std::size_t size) const {
    constexpr std::array<StoredType, 4> signed_types{StoredType::int8, StoredType::int16, StoredType::int32,
                                                     StoredType::int64};
    constexpr std::array<StoredType, 4> unsigned_types{StoredType::uint8, StoredType::uint16, StoredType::uint32,
                                                       StoredType::uint64};
    const std::size_t power = size == 1 ? 0 : (size == 2 ? 1 : (size == 4 ? 2 : 3));
    const bool fits = size == std::size_t{1} << power;
    if (fits && letter == "I") return signed_types[power];
    if (fits && letter == "U") return unsigned_types[power];
    if (letter == "F" && size == 4) return StoredType::float32;
    if (letter == "F" && size == 8) return StoredType::float64;
    throw InvalidInput(Place{name_}, "a field of type " + in_quotes(letter) + " and " + std::to_string(size) +
                                         " bytes is not known; expected F of 4 or 8, I or U of 1, 2, 4 or 8");
  }

  void make_fields() {
    const std::size_t n = words("FIELDS").size();
    for (const char* key : {"SIZE", "TYPE"}) {
      if (words(key).size() == n) continue;
      throw InvalidInput(Place{name_}, "'" + std::string(key) + "' and 'FIELDS' have different lengths");
    }
    const bool has_counts = !lines_["COUNT"].empty();
    if (has_counts && lines_["COUNT"].size() != n) {
      throw InvalidInput(Place{name_}, "'COUNT' and 'FIELDS' have different lengths");
    }
    for (std::size_t i = 0; i < n; ++i) {
      Field field;
      field.name = words("FIELDS")[i];
      field.type = type_of(words("TYPE")[i], whole("SIZE", i, 8));
      field.count = has_counts ? whole("COUNT", i, 1'000'000) : 1;
      field.offset = layout_.row_size;
      layout_.row_size += field.count * (layout_.ascii ? 1 : size_of(field.type));
      set_role(field);
      layout_.fields.push_back(std::move(field));
    }
    for (const char* axis : {"x", "y", "z"}) {
      const auto is_it = [&](const Field& field) { return field.role == Role::position && field.name == axis; };
      if (std::count_if(layout_.fields.begin(), layout_.fields.end(), is_it) == 1) continue;
      throw InvalidInput(Place{name_}, std::string("there is not one field '") + axis + "' of type F; add it");
    }
  }

  static void set_role(Field& field) {
    const bool is_real = field.count == 1 && !is_integer(field.type);
    for (std::size_t axis = 0; is_real && axis < 3; ++axis) {
      const std::string letter(1, "xyz"[axis]);
      if (field.name == letter) field.role = Role::position;
      if (field.name == "normal_" + letter) field.role = Role::normal;
      if (field.role != Role::other) field.axis = axis;
      if (field.role != Role::other) return;
    }
    const bool is_color = field.name == "rgb" || field.name == "rgba";
    if (is_color && field.count == 1 && size_of(field.type) == 4) field.role = Role::color;
  }

  void count_points() {
    const std::size_t width = whole("WIDTH", 0, kMaxElements - 1);
    const std::size_t height = lines_["HEIGHT"].empty() ? 1 : whole("HEIGHT", 0, kMaxElements - 1);
    const bool has_points = !lines_["POINTS"].empty();
    layout_.points = has_points ? whole("POINTS", 0, kMaxElements - 1) : width * height;
    if (width * height != layout_.points) {
      throw InvalidInput(Place{name_}, "WIDTH times HEIGHT is not POINTS; the header is damaged");
    }
    if (layout_.points == 0) throw InvalidInput(Place{name_}, "has no points; there is no shape in it");
  }

  const std::string& name_;
  TextCursor text_;
  std::map<std::string, std::vector<std::string_view>> lines_;
  Layout layout_;
};

}  // namespace

Layout parse_header(std::string_view bytes, const std::string& name) { return HeaderParser(bytes, name).run(); }

// PCD files with 'DATA binary_compressed': the sizes of the compressed and the whole numbers (two uint32), then the
// numbers of one field after those of the other, compressed by LZF (Marc Lehmann's liblzf). A byte c below 32 is
// followed by c + 1 bytes as they are. Any other repeats (c >> 5) + 2 earlier bytes; 9 plus the next byte of them if
// c >> 5 is 7. One more byte b gives how far back they begin: ((c & 31) << 8 | b) + 1.

namespace {

std::uint32_t uint32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return value;
}

// Returns `size` bytes, or fewer if the input is damaged.
std::string expand(std::string_view in, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&]() -> std::size_t { return at < in.size() ? static_cast<unsigned char>(in[at++]) : 0; };
  while (at < in.size()) {
    const std::size_t c = next();
    std::size_t length = c + 1;
    if (c < 32) {
      if (length > in.size() - at || length > size - out.size()) break;
      out.append(in.substr(at, length));
      at += length;
      continue;
    }
    length = (c >> 5) == 7 ? next() + 9 : (c >> 5) + 2;
    const std::size_t back = ((c & 31) << 8 | next()) + 1;
    if (back > out.size() || length > size - out.size()) break;
    for (std::size_t i = 0; i < length; ++i) out += out[out.size() - back];
  }
  return out;
}

}  // namespace

bool uncompress(std::string& bytes, const std::string& name) {
  const Layout layout = parse_header(bytes, name);
  if (layout.compressed == 0) return false;
  constexpr std::size_t kMaxGrowth = 88;  // three bytes repeat 264 at most
  const std::string_view body = std::string_view(bytes).substr(layout.body_begin);
  const std::size_t packed = body.size() < 8 ? 0 : std::min<std::size_t>(uint32_at(body, 0), body.size() - 8);
  const std::size_t whole = layout.points * layout.row_size;
  const bool is_sized = packed > 0 && whole / kMaxGrowth <= packed && uint32_at(body, 4) == whole;
  const std::string columns = is_sized ? expand(body.substr(8, packed), whole) : "";
  if (whole == 0 || columns.size() != whole) {
    throw InvalidInput(Place{name}, "the compressed points are damaged or cut short");
  }
  std::string rows(whole, '\0');
  const char* from = columns.data();
  for (const Field& field : layout.fields) {
    const std::size_t size = field.count * size_of(field.type);
    for (std::size_t i = 0; i < layout.points; ++i, from += size) {
      std::memcpy(rows.data() + i * layout.row_size + field.offset, from, size);
    }
  }
  bytes.resize(layout.body_begin);
  bytes.replace(layout.compressed, std::string_view("binary_compressed").size(), "binary");
  bytes += rows;
  return true;
}

// Reading PCD, and writing it back.

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
      if (!std::isfinite(value)) ++not_finite_;
      attribute.values[row * static_cast<std::size_t>(attribute.components) + component] =
          std::isfinite(value) ? value : 0;
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
    if (not_finite_ > 0) {
      shape_.notes.push_back(counted(not_finite_, "attribute value is not finite and is read as 0",
                                     "attribute values are not finite and are read as 0"));
    }
    shape_.notes.emplace_back("has no faces and is read as a point cloud");
  }

  static constexpr std::size_t kNone = ~std::size_t{0};

  ShapeFile& shape_;
  const std::string& name_;
  Layout layout_;
  Unplaced unplaced_;
  std::vector<std::size_t> attribute_;            // of each field
  std::vector<std::vector<double>> real_colors_;  // of each field: its numbers, if they are colors of type F
  std::size_t not_finite_ = 0;
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
      if (row - point < layout_.unplaced.size() && layout_.unplaced[row - point] == row) continue;
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

}  // namespace

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "pcd";
  if (uncompress(bytes, name)) shape.notes.emplace_back("the points are compressed and are written uncompressed");
  shape.bytes = std::move(bytes);
  set_layout(shape, Reader(shape, name).run());
  return shape;
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

}  // namespace knead::io_detail::pcd
