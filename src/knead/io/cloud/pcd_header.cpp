// The header of a PCD file.
#include <array>
#include <charconv>
#include <map>

#include "knead/io/cloud/pcd.h"
#include "knead/io/cursor.h"
#include "knead/io/face_builder.h"

namespace knead::io_detail::pcd {
namespace {

constexpr std::size_t kMostFields = 256;

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
      if (words.size() == kMostFields) text_.fail("more than 256 words in a header line; remove fields");
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
    const std::size_t width = whole("WIDTH", 0, kMostElements - 1);
    const std::size_t height = lines_["HEIGHT"].empty() ? 1 : whole("HEIGHT", 0, kMostElements - 1);
    const bool has_points = !lines_["POINTS"].empty();
    layout_.points = has_points ? whole("POINTS", 0, kMostElements - 1) : width * height;
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

}  // namespace knead::io_detail::pcd
