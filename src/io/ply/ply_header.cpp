// The header of a PLY file, and what its properties mean to a mesh.
#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include "io/mesh_builder.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"

namespace knead::detail::ply {
namespace {

struct TypeName {
  std::string_view name;
  StoredType type;
};

constexpr std::array<TypeName, 18> kTypeNames = {{{"char", StoredType::int8},
                                                  {"uchar", StoredType::uint8},
                                                  {"short", StoredType::int16},
                                                  {"ushort", StoredType::uint16},
                                                  {"int", StoredType::int32},
                                                  {"uint", StoredType::uint32},
                                                  {"float", StoredType::float32},
                                                  {"double", StoredType::float64},
                                                  {"int8", StoredType::int8},
                                                  {"uint8", StoredType::uint8},
                                                  {"int16", StoredType::int16},
                                                  {"uint16", StoredType::uint16},
                                                  {"int32", StoredType::int32},
                                                  {"uint32", StoredType::uint32},
                                                  {"float32", StoredType::float32},
                                                  {"float64", StoredType::float64},
                                                  {"int64", StoredType::int64},
                                                  {"uint64", StoredType::uint64}}};

// Every name is compared with those before it, and every property of vertices and faces is an attribute.
constexpr std::size_t kMaxNames = 4096;

// Reads the header line by line.
class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& name)
      : bytes_(bytes), name_(name), position_(text_begin(bytes, name)) {}

  Layout parse() {
    if (position_ > 0) layout_.notes.emplace_back("begins with a byte order mark, which is kept");
    next_line();
    if (words_.size() != 1 || words_[0] != "ply") fail("does not begin with 'ply'; is it a PLY file?");
    bool has_format = false;
    for (next_line(); words_.empty() || words_[0] != "end_header" || words_.size() > 1; next_line()) {
      if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") continue;
      if (words_[0][0] == '#') {
        note_hash_lines();
      } else if (words_[0] == "format") {
        parse_format();
        has_format = true;
      } else if (words_[0] == "element") {
        parse_element();
      } else if (words_[0] == "property") {
        parse_property();
      } else {
        fail("unknown header line " + in_quotes(line_) + "; expected element, property, comment or end_header");
      }
    }
    if (!has_format) fail("the header has no line 'format'; add e.g. 'format ascii 1.0'");
    layout_.body_begin = position_;
    find_vertices();
    return std::move(layout_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InvalidInput(Place{name_, line_number_}, what); }

  // Splits the next line into words. A file whose first line ends with CR alone has such ends throughout; elsewhere a
  // binary body may begin with LF, so that CR then ends a line only together with LF.
  void next_line() {
    ++line_number_;
    line_begin_ = position_;
    const std::size_t end = bytes_.find_first_of(ends_, position_);
    if (end == std::string_view::npos) fail("the header ends without 'end_header'; the file is cut short or no PLY");
    line_ = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    if (line_number_ == 1) {
      const bool pair = bytes_[end] == '\r' && position_ < bytes_.size() && bytes_[position_] == '\n';
      ends_ = bytes_[end] == '\r' && !pair ? "\r" : "\n";
      if (pair) ++position_;
    }
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    split();
  }

  void split() {
    words_.clear();
    for (std::size_t i = 0; i < line_.size();) {
      if (is_blank(line_[i])) {
        ++i;
        continue;
      }
      const std::size_t end = token_end(line_, i);
      if (end == i) fail("a stray carriage return in the header; the file is damaged");
      words_.push_back(line_.substr(i, end - i));
      i = end;
    }
  }

  void note_hash_lines() {
    if (std::exchange(hash_lines_, true)) return;
    layout_.notes.emplace_back("header lines that begin with # are read as comments");
  }

  void parse_format() {
    if (words_.size() != 3) fail("expected 'format ENCODING 1.0'");
    if (words_[2] != "1.0") fail("PLY version " + in_quotes(words_[2]) + " is not known; only 1.0 is");
    if (words_[1] == "ascii") {
      layout_.encoding = Encoding::ascii;
    } else if (words_[1] == "binary_little_endian") {
      layout_.encoding = Encoding::little_endian;
    } else if (words_[1] == "binary_big_endian") {
      layout_.encoding = Encoding::big_endian;
    } else {
      fail("encoding " + in_quotes(words_[1]) +
           " is not known; expected ascii, binary_little_endian or binary_big_endian");
    }
  }

  void parse_element() {
    if (words_.size() != 3) fail("expected 'element NAME COUNT'");
    Element element;
    element.name = words_[1];
    element.line_begin = line_begin_;
    element.line_end = position_;
    element.count_begin = static_cast<std::size_t>(words_[2].data() - bytes_.data());
    element.count_end = element.count_begin + words_[2].size();
    const char* end = words_[2].data() + words_[2].size();
    const auto [stop, error] = std::from_chars(words_[2].data(), end, element.count);
    if (error != std::errc{} || stop != end) fail("the count " + in_quotes(words_[2]) + " is not a whole number");
    if (element.count > kMaxElements) fail("declares more than 4294967295 elements; split the shape");
    if (layout_.elements.size() == kMaxNames) fail("more than 4096 elements; remove some");
    for (const Element& other : layout_.elements) {
      if (other.name == element.name) fail("element " + in_quotes(element.name) + " is declared twice");
    }
    layout_.elements.push_back(std::move(element));
  }

  StoredType parse_type(std::string_view word) const {
    for (const TypeName& known : kTypeNames) {
      if (known.name == word) return known.type;
    }
    fail("number type " + in_quotes(word) +
         " is not known; expected char, uchar, short, ushort, int, uint, int64, uint64, float or double");
  }

  void parse_property() {
    if (layout_.elements.empty()) fail("a property before the first element");
    const bool is_list = words_.size() > 1 && words_[1] == "list";
    if (words_.size() != (is_list ? 5u : 3u)) fail("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
    Property property;
    property.is_list = is_list;
    if (is_list) property.count_type = parse_type(words_[2]);
    if (is_list && !is_integer(property.count_type)) fail("the length of a list must have an integer type");
    const std::string_view type = words_[words_.size() - 2];
    property.type = parse_type(type);
    property.type_begin = static_cast<std::size_t>(type.data() - bytes_.data());
    property.type_end = property.type_begin + type.size();
    property.line_begin = line_begin_;
    property.line_end = position_;
    property.name = words_.back();
    if (layout_.elements.back().properties.size() == kMaxNames) fail("more than 4096 properties; remove some");
    for (const Property& other : layout_.elements.back().properties) {
      if (other.name == property.name) fail("property " + in_quotes(property.name) + " is declared twice");
    }
    layout_.elements.back().properties.push_back(std::move(property));
  }

  void find_vertices() {
    for (std::size_t i = 0; i < layout_.elements.size(); ++i) {
      if (layout_.elements[i].name != "vertex") continue;
      layout_.vertex_element = i;
      return;
    }
    throw InvalidInput(Place{name_}, "the header declares no element 'vertex'; there is no shape in it");
  }

  std::string_view bytes_;
  const std::string& name_;
  const char* ends_ = "\r\n";
  std::size_t position_;
  bool hash_lines_ = false;
  std::size_t line_number_ = 0;
  std::size_t line_begin_ = 0;
  std::string_view line_;
  std::vector<std::string_view> words_;
  Layout layout_;
};

// Scalar properties that together make one attribute.
struct Group {
  std::string_view attribute;
  std::array<std::string_view, 4> properties;
  std::size_t needed;    // so many must be there
  std::size_t possible;  // and so many may
};

constexpr std::array<Group, 6> kGroups = {{{"normal", {"nx", "ny", "nz", ""}, 3, 3},
                                           {"uv", {"s", "t", "", ""}, 2, 2},
                                           {"uv", {"u", "v", "", ""}, 2, 2},
                                           {"uv", {"texture_u", "texture_v", "", ""}, 2, 2},
                                           {"uv", {"texture_s", "texture_t", "", ""}, 2, 2},
                                           {"color", {"red", "green", "blue", "alpha"}, 3, 4}}};

// The names of the list of a face's vertices; the first two are the usual ones.
constexpr std::array<std::string_view, 5> kIndexNames = {"vertex_indices", "vertex_index", "vertex_indexes", "indices",
                                                         "vertices"};

bool is_group_name(const std::string& name) {
  return std::any_of(kGroups.begin(), kGroups.end(), [&](const Group& group) { return group.attribute == name; });
}

std::optional<std::size_t> find_scalar(const Element& element, std::string_view name) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    if (element.properties[p].name == name && !element.properties[p].is_list) return p;
  }
  return std::nullopt;
}

class Planner {
 public:
  Planner(const Layout& layout, const std::string& name) : layout_(layout), name_(name) {}

  Plan run() {
    for (const Element& element : layout_.elements) {
      sinks_ = &plan_.sinks.emplace_back(element.properties.size());
      const bool is_vertex = &element == &layout_.elements[layout_.vertex_element];
      if (is_vertex) add_coordinates(element);
      if (element.name == "face" || element.name == "tristrips") add_indices(element);
      if (is_vertex || element.name == "face") add_attributes(element, is_vertex ? Domain::vertex : Domain::face);
    }
    return std::move(plan_);
  }

 private:
  void add_coordinates(const Element& element) {
    if (element.count == 0) throw InvalidInput(Place{name_}, "has no vertices; there is no shape in it");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string property(1, "xyz"[axis]);
      const std::optional<std::size_t> p = find_scalar(element, property);
      if (!p) throw InvalidInput(Place{name_}, "element 'vertex' has no property '" + property + "'; add one");
      (*sinks_)[*p] = {Sink::Kind::coordinate, 0, axis};
    }
  }

  void add_indices(const Element& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!is_index_list(element, element.properties[p])) continue;
      (*sinks_)[p].kind = element.name == "face" ? Sink::Kind::faces : Sink::Kind::strips;
      return;
    }
    if (element.count == 0) return;
    throw InvalidInput(Place{name_}, "element '" + element.name + "' has no list 'vertex_indices'; add one");
  }

  void add_attributes(const Element& element, Domain domain) {
    for (const Group& group : kGroups) add_group(element, domain, group);
    if (domain == Domain::face) add_corner_uv(element);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if ((*sinks_)[p].kind == Sink::Kind::skip && !property.is_list && !is_group_name(property.name)) {
        add_attribute(element, domain, property.name, {p});
      }
    }
  }

  void add_group(const Element& element, Domain domain, const Group& group) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < group.possible; ++i) {
      const std::optional<std::size_t> p = find_scalar(element, group.properties[i]);
      if (!p || element.properties[*p].type != element.properties[members.empty() ? *p : members[0]].type) break;
      members.push_back(*p);
    }
    const bool needs_reals = group.attribute != "color";
    if (members.size() < group.needed || (needs_reals && is_integer(element.properties[members[0]].type))) return;
    add_attribute(element, domain, std::string(group.attribute), members);
  }

  void add_attribute(const Element& element, Domain domain, const std::string& attribute,
                     const std::vector<std::size_t>& members) {
    for (std::size_t i = 0; i < members.size(); ++i) {
      (*sinks_)[members[i]] = {Sink::Kind::attribute, plan_.attributes.size(), i};
    }
    const NumberType type = number_type(element.properties[members[0]].type);
    plan_.attributes.push_back({attribute, domain, type, static_cast<int>(members.size()), {}});
  }

  void add_corner_uv(const Element& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!element.properties[p].is_list || element.properties[p].name != "texcoord") continue;
      (*sinks_)[p] = {Sink::Kind::corner_uv, plan_.attributes.size(), 0};
      plan_.attributes.push_back({"uv", Domain::corner, number_type(element.properties[p].type), 2, {}});
    }
  }

  const Layout& layout_;
  const std::string& name_;
  Plan plan_;
  std::vector<Sink>* sinks_ = nullptr;
};

}  // namespace

Layout parse_header(std::string_view bytes, const std::string& name) { return HeaderParser(bytes, name).parse(); }

std::string_view type_name(StoredType type) {
  for (const TypeName& known : kTypeNames) {
    if (known.type == type) return known.name;
  }
  return "double";
}

StoredType stored_type(NumberType type) {
  for (const TypeName& known : kTypeNames) {
    if (number_type(known.type) == type) return known.type;
  }
  return StoredType::float64;
}

Plan make_plan(const Layout& layout, const std::string& name) { return Planner(layout, name).run(); }

bool is_index_list(const Element& element, const Property& property) {
  return property.is_list && (element.name == "face" || element.name == "tristrips") &&
         std::find(kIndexNames.begin(), kIndexNames.end(), property.name) != kIndexNames.end();
}

}  // namespace knead::detail::ply
