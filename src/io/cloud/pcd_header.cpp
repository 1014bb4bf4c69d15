// The header of a PCD file, and compressed points.
#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "io/cloud/cloud.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "knead/error.h"

namespace knead::detail::pcd {
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

Layout parse_header(std::string_view bytes, const std::string& name) { return HeaderParser(bytes, name).run(); }

// PCD files with 'DATA binary_compressed': the sizes of the compressed and the whole numbers (two uint32), then the
// numbers of one field after those of the other, compressed by LZF (Marc Lehmann's liblzf). A byte c below 32 is
// followed by c + 1 bytes as they are. Any other repeats (c >> 5) + 2 earlier bytes; 9 plus the next byte of them if
// c >> 5 is 7. One more byte b gives how far back they begin: ((c & 31) << 8 | b) + 1.
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

}  // namespace knead::detail::pcd
