// Where the points of SU2's, gmsh's and OpenFOAM's files stand.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>

#include "io/mesh_builder.h"
#include "io/solver/solver.h"
#include "knead/error.h"

namespace knead::io_detail::solver {
namespace {

// SU2

// The first word of the next line that is no comment; empty at the end of the file.
std::string_view next_line_word(TextCursor& text) {
  std::string_view word = text.next();
  while (word.starts_with('%') || word.starts_with('#')) {
    if (!text.next_line()) return {};
    word = text.next();
  }
  return word;
}

// A line KEY= VALUE, with or without blanks.
struct KeyLine {
  std::string_view key;
  std::string_view value;  // the first word after the sign
};

std::optional<KeyLine> key_line(std::string_view bytes, std::size_t begin) {
  const std::size_t end = std::min(bytes.find_first_of("\r\n", begin), bytes.size());
  const std::size_t sign = bytes.substr(0, end).find('=', begin);
  if (sign == std::string_view::npos) return std::nullopt;
  std::size_t value = sign + 1;
  while (value < end && is_blank(bytes[value])) ++value;
  return KeyLine{trimmed(bytes.substr(begin, sign - begin)), bytes.substr(value, token_end(bytes, value) - value)};
}

// The words of a line whose first one is given.
PointSite words_from(std::string_view first, std::size_t dimensions, TextCursor& text) {
  PointSite site;
  site.dimensions = dimensions;
  site.words[0] = first;
  for (std::size_t axis = 0; axis < dimensions; ++axis) {
    if (axis > 0) site.words[axis] = text.next_on_line();
    if (site.words[axis].empty()) text.coordinate({});  // fails
  }
  return site;
}

void scan_su2_points(std::size_t dimensions, std::size_t count, std::string_view bytes, TextCursor& text,
                     const PointVisitor& visit) {
  if (dimensions == 0) text.fail("NDIME= must come before NPOIN=; is it an SU2 mesh?");
  text.next_line();
  require_room(count, bytes.size() - text.position(), 2 * dimensions, text);
  for (std::size_t i = 0; i < count; ++i) {
    visit(words_from(next_line_word(text), dimensions, text));
    text.next_line();
  }
}

// gmsh

// What stands between $MeshFormat and its end.
struct GmshHead {
  bool is_4 = false;
  std::optional<std::endian> order;  // of a binary file
};

class GmshScan {
 public:
  GmshScan(std::string_view bytes, const std::string& name, const PointVisitor& visit)
      : bytes_(bytes), name_(name), visit_(visit), text_(bytes, name, text_begin(bytes, name)) {}

  void run() {
    std::optional<GmshHead> head;
    for (std::string_view section = text_.next(); !section.empty(); section = text_.next()) {
      if (section == "$NOD") text_.fail("is of gmsh's version 1; save it as version 2.2 or 4.1");
      if (!section.starts_with('$')) text_.fail("expected a section, such as $Nodes, found " + in_quotes(section));
      const bool is_parametric = section == "$ParametricNodes";
      if (section == "$MeshFormat") {
        head = read_head();
      } else if (section == "$Nodes" || is_parametric) {
        if (!head) text_.fail("$MeshFormat must come before " + std::string(section));
        head->is_4 ? read_nodes_4(*head) : read_nodes_2(*head, is_parametric);
      }
      skip_to_end_of(section);
    }
    if (!head) throw InvalidInput(Place{name_}, "has no $MeshFormat; is it a file of gmsh?");
  }

 private:
  void skip_to_end_of(std::string_view section) {
    const std::string end = "$End" + std::string(section.substr(1));
    std::size_t at = bytes_.find(end, text_.position());
    while (at != bytes_.npos && !is_line_end(bytes_[at - 1]) && !is_binary_) at = bytes_.find(end, at + 1);
    if (at == bytes_.npos) text_.fail("the section " + std::string(section) + " has no " + end);
    text_.take(at, at + end.size());
    text_.next_line();
  }

  GmshHead read_head() {
    const std::string_view version = text_.next();
    if (version != "2" && version != "2.1" && version != "2.2" && version != "4.1") {
      text_.fail("is of gmsh's version " + in_quotes(version) + "; save it as version 2.2 or 4.1");
    }
    GmshHead head{version == "4.1", std::nullopt};
    is_binary_ = text_.whole(text_.next_on_line(), 1, "the type of the file, 0 or 1,") == 1;
    if (text_.whole(text_.next_on_line(), 8, "the size of a number") != 8) text_.fail("the size of a number must be 8");
    if (!is_binary_) return head;
    text_.next_line();
    ByteCursor one(bytes_, name_);
    one.take_bytes(text_.position(), "the header");
    head.order = one.take<std::int32_t>("the number 1") == 1 ? std::endian::little : std::endian::big;
    return head;
  }

  // Binary: the bytes after this line.
  ByteCursor begin_binary(const GmshHead& head) {
    ByteCursor cursor(bytes_, name_, *head.order);
    cursor.take_bytes(text_.position(), "the header");
    return cursor;
  }

  void end_binary(const ByteCursor& cursor) { text_.take(cursor.position(), cursor.position()); }

  static void require_left(std::uint64_t points, std::size_t bytes_for_each, const ByteCursor& cursor) {
    if (points > cursor.left() / bytes_for_each) {
      cursor.fail(std::to_string(points) + " points are declared, but only " + std::to_string(cursor.left()) +
                  " bytes follow; the file is cut short or damaged");
    }
  }

  void visit_doubles(ByteCursor& cursor, const GmshHead& head) {
    PointSite site;
    site.spelling = Spelling::float64;
    site.swapped = *head.order != std::endian::native;
    for (std::string_view& word : site.words) word = cursor.take_bytes(sizeof(double), "a coordinate");
    visit_(site);
  }

  void read_nodes_2(const GmshHead& head, bool is_parametric) {
    const std::size_t count = text_.whole(text_.next(), kMaxElements, "the number of points");
    text_.next_line();
    if (!is_binary_) {
      require_room(count, bytes_.size() - text_.position(), 8, text_);
      for (std::size_t i = 0; i < count; ++i, text_.next_line()) {
        text_.next();
        visit_(words_from(text_.next_on_line(), 3, text_));
      }
      return;
    }
    ByteCursor cursor = begin_binary(head);
    require_left(count, sizeof(std::int32_t) + 3 * sizeof(double), cursor);
    for (std::size_t i = 0; i < count; ++i) {
      cursor.take<std::int32_t>("the number of a point");
      visit_doubles(cursor, head);
      if (!is_parametric) continue;
      const auto dimension = cursor.take<std::int32_t>("a dimension");
      cursor.take<std::int32_t>("the number of an entity");
      const bool has_parameters = dimension == 1 || dimension == 2;
      cursor.take_bytes((has_parameters ? static_cast<std::size_t>(dimension) : 0) * sizeof(double), "parameters");
    }
    end_binary(cursor);
  }

  void read_nodes_4(const GmshHead& head) {
    if (is_binary_) return read_binary_nodes_4(head);
    const std::size_t blocks = text_.whole(text_.next(), kMaxElements, "the number of blocks");
    require_room(blocks, bytes_.size() - text_.position(), 8, text_);
    text_.next_line();
    for (std::size_t block = 0; block < blocks; ++block) {
      text_.next();  // dimension, number of the entity, whether parameters follow
      for (int i = 0; i < 2; ++i) text_.next_on_line();
      const std::size_t count = text_.whole(text_.next_on_line(), kMaxElements, "the number of points");
      require_room(count, bytes_.size() - text_.position(), 8, text_);
      text_.next_line();
      for (std::size_t i = 0; i < count; ++i, text_.next_line()) {
        text_.whole(text_.next(), SIZE_MAX, "the number of a point");
      }
      for (std::size_t i = 0; i < count; ++i, text_.next_line()) visit_(words_from(text_.next(), 3, text_));
    }
  }

  void read_binary_nodes_4(const GmshHead& head) {
    text_.next_line();
    ByteCursor cursor = begin_binary(head);
    const auto blocks = cursor.take<std::uint64_t>("the number of blocks");
    for (int i = 0; i < 3; ++i) cursor.take<std::uint64_t>("the number of points");
    for (std::uint64_t block = 0; block < blocks; ++block) {
      const auto dimension = cursor.take<std::int32_t>("a dimension");
      cursor.take<std::int32_t>("the number of an entity");
      const bool is_parametric = cursor.take<std::int32_t>("whether parameters follow") != 0;
      if (dimension < 0 || dimension > 3) cursor.fail("a dimension must be 0 to 3");
      const auto count = cursor.take<std::uint64_t>("the number of points");
      require_left(count, sizeof(std::uint64_t) + 3 * sizeof(double), cursor);
      cursor.take_bytes(count * sizeof(std::uint64_t), "the numbers of points");
      for (std::uint64_t i = 0; i < count; ++i) {
        visit_doubles(cursor, head);
        const std::size_t parameters = is_parametric ? static_cast<std::size_t>(dimension) : 0;
        cursor.take_bytes(parameters * sizeof(double), "parameters");
      }
    }
    end_binary(cursor);
  }

  std::string_view bytes_;
  const std::string& name_;
  const PointVisitor& visit_;
  TextCursor text_;
  bool is_binary_ = false;
};

// OpenFOAM

class FoamScan {
 public:
  FoamScan(std::string_view bytes, const std::string& name, const PointVisitor& visit)
      : bytes_(bytes), visit_(visit), text_(bytes, name, text_begin(bytes, name)) {}

  void run() {
    if (next() != "FoamFile") text_.fail("expected FoamFile; is it a file `points` of OpenFOAM?");
    read_head();
    const std::size_t count = text_.whole(next(), kMaxElements, "the number of points");
    expect("(");
    if (is_binary_) return read_binary_points(count);
    require_room(count, bytes_.size() - text_.position(), 7, text_);
    for (std::size_t i = 0; i < count; ++i) {
      PointSite site;
      expect("(");
      for (std::string_view& word : site.words) word = next();
      expect(")");
      visit_(site);
    }
    expect(")");
  }

 private:
  static bool ends_word(char c) {
    return is_blank(c) || is_line_end(c) || std::string_view("(){};").find(c) != std::string_view::npos;
  }

  // Passes over blanks and comments.
  std::size_t skip_gap(std::size_t at) const {
    while (at < bytes_.size()) {
      if (is_blank(bytes_[at]) || is_line_end(bytes_[at])) {
        ++at;
      } else if (bytes_.substr(at, 2) == "//") {
        at = std::min(bytes_.find_first_of("\r\n", at), bytes_.size());
      } else if (bytes_.substr(at, 2) == "/*") {
        const std::size_t end = bytes_.find("*/", at + 2);
        at = end == bytes_.npos ? bytes_.size() : end + 2;
      } else {
        break;
      }
    }
    return at;
  }

  // The next word, a bracket or a semicolon; empty at the end of the file.
  std::string_view next() {
    const std::size_t begin = skip_gap(text_.position());
    std::size_t end = begin;
    while (end < bytes_.size() && !ends_word(bytes_[end])) ++end;
    return text_.take(begin, end == begin && end < bytes_.size() ? end + 1 : end);
  }

  void expect(std::string_view word) {
    const std::string_view found = next();
    if (found == word) return;
    text_.fail("expected '" + std::string(word) + "', found " +
               (found.empty() ? "the end of the file" : in_quotes(found)));
  }

  void read_head() {
    expect("{");
    for (std::string_view key = next(); key != "}"; key = next()) {
      if (key.empty()) text_.fail("the header FoamFile has no end");
      const std::size_t begin = skip_gap(text_.position());
      const std::size_t end = bytes_.find(';', begin);
      if (end == bytes_.npos) text_.fail("expected ';' after " + in_quotes(key));
      read_entry(key, bytes_.substr(begin, end - begin));
      text_.take(end, end + 1);
    }
  }

  void read_entry(std::string_view key, std::string_view value) {
    const auto has = [&](const char* part) { return value.find(part) != value.npos; };
    if (key == "format") {
      is_binary_ = value == "binary";
      if (!is_binary_ && value != "ascii") text_.fail("the format must be ascii or binary, found " + in_quotes(value));
    } else if (key == "class" && value != "vectorField") {
      text_.fail("holds " + in_quotes(value) + "; the points of a mesh are a vectorField");
    } else if (key == "arch") {
      site_.spelling = has("scalar=32") ? Spelling::float32 : Spelling::float64;
      site_.swapped = (has("MSB") ? std::endian::big : std::endian::little) != std::endian::native;
    }
  }

  void read_binary_points(std::size_t count) {
    const std::size_t size = site_.spelling == Spelling::float32 ? sizeof(float) : sizeof(double);
    const std::size_t begin = text_.position();
    if (count > (bytes_.size() - begin) / (3 * size)) {
      text_.fail(std::to_string(count) + " points are declared, but only " + std::to_string(bytes_.size() - begin) +
                 " bytes follow; the file is cut short or damaged");
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        site_.words[axis] = bytes_.substr(begin + (3 * i + axis) * size, size);
      visit_(site_);
    }
    text_.take(begin, begin + 3 * size * count);
    expect(")");
  }

  std::string_view bytes_;
  const PointVisitor& visit_;
  TextCursor text_;
  bool is_binary_ = false;
  PointSite site_{{}, 3, Spelling::float64, std::endian::native != std::endian::little};  // of a binary file
};

}  // namespace

void scan_su2(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  TextCursor text(bytes, name, text_begin(bytes, name));
  std::size_t dimensions = 0;
  bool has_points = false;
  for (std::string_view word = next_line_word(text); !word.empty(); word = next_line_word(text)) {
    const std::optional<KeyLine> line = key_line(bytes, text.word_begin());
    if (line && line->key == "NDIME") {
      dimensions = text.whole(line->value, 3, "the number of dimensions, NDIME=");
      if (dimensions < 2) text.fail("NDIME= must be 2 or 3");
    } else if (line && line->key == "NPOIN") {
      const std::size_t count = text.whole(line->value, kMaxElements, "the number of points, NPOIN=");
      scan_su2_points(dimensions, count, bytes, text, visit);
      has_points = true;
      continue;
    }
    if (!text.next_line()) break;
  }
  if (!has_points) throw InvalidInput(Place{name}, "has no points (NPOIN=); is it an SU2 mesh?");
}

void scan_gmsh(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  GmshScan(bytes, name, visit).run();
}

void scan_foam(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  FoamScan(bytes, name, visit).run();
}

}  // namespace knead::io_detail::solver
