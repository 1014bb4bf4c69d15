// Reading STL, text and binary.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/stl/stl.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::stl {
namespace {

// Keywords stand in any letter case.
bool is_keyword(std::string_view word, std::string_view keyword) {
  return word.size() == keyword.size() && lower(word) == keyword;
}

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name)
      : shape_(shape), bytes_(shape.bytes), name_(name), welder_(shape.mesh.positions), faces_(shape.mesh) {}

  Layout run() {
    Layout layout;
    layout.binary = is_binary();
    if (layout.binary) {
      read_binary();
    } else {
      layout.solids = read_text();
    }
    if (shape_.mesh.face_count() == 0) throw InvalidInput(Place{name_}, "has no triangles; there is no shape in it");
    faces_.append_notes(shape_.notes);
    join_around_zero();
    return layout;
  }

 private:
  bool is_binary() const {
    const std::string_view text = without_end_zeros(bytes_).substr(0, kFirstTriangle);
    const bool is_text = begins_with_solid() && text.find('\0') == std::string_view::npos;
    if (bytes_.size() >= kFirstTriangle &&
        std::uint64_t{triangles()} * kTriangleBytes <= bytes_.size() - kFirstTriangle)
      return !is_text || declared() > 0;
    if (is_text) return false;
    if (bytes_.size() < kFirstTriangle) {
      throw InvalidInput(Place{name_}, "is not STL: neither text that begins with 'solid' nor the " +
                                           std::to_string(kFirstTriangle) + " bytes at least of a binary file");
    }
    fail_at_byte(name_, kHeaderBytes,
                 std::to_string(declared()) + " triangles are declared, which take " +
                     std::to_string(kFirstTriangle + std::uint64_t{declared()} * kTriangleBytes) +
                     " bytes, but the file has " + std::to_string(bytes_.size()) + "; it is cut short or damaged");
  }

  std::uint32_t declared() const {
    return ByteCursor(bytes_.substr(kHeaderBytes), name_).take<std::uint32_t>("the count of triangles");
  }

  // As declared, or as many as fill the file where what is declared cannot be meant.
  std::uint32_t triangles() const {
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    const std::size_t left = bytes_.size() - kFirstTriangle;
    const bool is_meant = declared() != 0 && declared() != none;
    if (is_meant || left == 0 || left % kTriangleBytes != 0 || left / kTriangleBytes >= none) return declared();
    return static_cast<std::uint32_t>(left / kTriangleBytes);
  }

  bool begins_with_solid() const {
    return lower(TextCursor(bytes_, name_, text_begin(bytes_, name_)).next().substr(0, 5)) == "solid";
  }

  void read_binary() {
    const std::size_t count = triangles();
    if (count != declared()) {
      shape_.notes.push_back("the header declares " + counted(declared(), "triangle", "triangles") + "; the " +
                             std::to_string(count) + " that fill the file are read");
    }
    reserve(count);
    ByteCursor cursor(bytes_, name_);
    cursor.take_bytes(kFirstTriangle, "the header");
    std::vector<double> attribute(count);
    for (std::size_t t = 0; t < count; ++t) {
      cursor.take_bytes(3 * sizeof(float), "a normal");
      for (std::uint32_t& corner : corners_) {
        const std::size_t begin = cursor.position();
        Vec3d p;
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = double{cursor.take<float>("a coordinate")};
        if (!is_finite(p)) {
          fail_at_byte(name_, begin,
                       "a coordinate of triangle " + std::to_string(t) + " is not finite; repair the file");
        }
        corner = welder_.vertex_at(p);
      }
      faces_.add(corners_);
      attribute[t] = static_cast<double>(cursor.take<std::uint16_t>("the attribute of a triangle"));
    }
    if (cursor.left() > 0) {
      shape_.notes.push_back(
          counted(cursor.left(), "byte follows the last triangle", "bytes follow the last triangle"));
    }
    if (std::all_of(attribute.begin(), attribute.end(), [](double a) { return a == 0; })) return;
    shape_.mesh.attributes.push_back({"attribute", Domain::face, NumberType::uint16, 1, std::move(attribute)});
  }

  // The number of solids.
  std::size_t read_text() {
    FacetCursor facets(bytes_, name_);
    for (Facet facet; facets.next(facet);) {
      for (const std::string_view word : facet.normal) facets.text().real(word, "a number");
      for (std::size_t c = 0; c < 3; ++c) {
        Vec3d p;
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = facets.text().coordinate(facet.corner[c][axis]);
        corners_[c] = welder_.vertex_at(p);
      }
      faces_.add(corners_);
    }
    note_defects(facets.defects());
    return facets.solids();
  }

  void note_defects(const Defects& odd) {
    const auto say = [&](bool is_so, const char* what) {
      if (is_so) shape_.notes.emplace_back(what);
    };
    say(odd.open_end, "ends without 'endsolid'; it may be cut short");
    say(odd.on_one_line, "a triangle stands on the line of its solid's name");
    say(odd.colors, "lines 'color' are kept but not read");
    say(odd.split_words, "'end loop' and the like are read as one word");
    const std::size_t zeros = bytes_.size() - without_end_zeros(bytes_).size();
    if (zeros > 0) shape_.notes.push_back(counted(zeros, "zero byte ends the file", "zero bytes end the file"));
  }

  // Returns whether a mesh with joined vertices has fewer open edges, and no triangle has lost a corner: what is
  // smaller than rounding may be meant.
  bool is_joined_well(const Mesh& whole) const {
    for (std::size_t c = 0; c < whole.corner_vertex.size(); c += 3) {
      const std::uint32_t* const t = &whole.corner_vertex[c];
      const std::uint32_t* const before = &shape_.mesh.corner_vertex[c];
      const auto repeats = [](const std::uint32_t* v) { return v[0] == v[1] || v[1] == v[2] || v[2] == v[0]; };
      if (repeats(t) && !repeats(before)) return false;
    }
    return measure(whole).boundary_edges < measure(shape_.mesh).boundary_edges;
  }

  // Joins vertices whose coordinates differ only by rounding around 0, as CAD programs write 1e-17 for it. Each has the
  // place of the first.
  void join_around_zero() {
    Mesh& mesh = shape_.mesh;
    std::vector<double> sizes;
    for (const Vec3d& p : mesh.positions) sizes.push_back(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());  // so that a vertex far away does not count
    const double dust = 1e-15 * *middle;
    const auto is_dust = [&](double x) { return x != 0 && std::abs(x) <= dust; };
    const auto has_dust = [&](const Vec3d& p) { return is_dust(p.x) || is_dust(p.y) || is_dust(p.z); };
    if (std::none_of(mesh.positions.begin(), mesh.positions.end(), has_dust)) return;
    const auto cleaned = [&](double x) { return is_dust(x) ? 0.0 : x; };
    std::vector<Vec3d> places;  // without the dust
    Welder welder(places);
    std::vector<Vec3d> kept;
    std::vector<std::uint32_t> joined;
    for (const Vec3d& p : mesh.positions) {
      joined.push_back(welder.vertex_at({cleaned(p.x), cleaned(p.y), cleaned(p.z)}));
      if (places.size() > kept.size()) kept.push_back(p);
    }
    const std::size_t gone = mesh.positions.size() - kept.size();
    Mesh whole;
    whole.positions = std::move(kept);
    whole.face_begin = mesh.face_begin;
    for (const std::uint32_t v : mesh.corner_vertex) whole.corner_vertex.push_back(joined[v]);
    if (gone < 2 || !is_joined_well(whole)) return;  // one alone is damage, not how a program rounds
    mesh.positions = std::move(whole.positions);
    mesh.corner_vertex = std::move(whole.corner_vertex);
    shape_.notes.push_back(counted(gone, "vertex differs from another one by rounding around 0 and is joined with it",
                                   "vertices differ from others by rounding around 0 and are joined with them"));
  }

  void reserve(std::size_t count) {
    shape_.mesh.positions.reserve(count / 2 + 2);  // of a closed surface (Euler)
    shape_.mesh.face_begin.reserve(count + 1);
    shape_.mesh.corner_vertex.reserve(3 * count);
  }

  ShapeFile& shape_;
  std::string_view bytes_;
  const std::string& name_;
  Welder welder_;
  FaceBuilder faces_;
  std::vector<std::uint32_t> corners_{0, 0, 0};
};

}  // namespace

void FacetCursor::fail_expected(const std::string& what, std::string_view found) const {
  if (found.empty()) text_.fail("the file ends where " + what + " is expected; it is cut short");
  text_.fail("expected " + what + ", found " + in_quotes(found));
}

// The next word that is no color: `end` and what follows it are one word.
std::string_view FacetCursor::next_keyword() {
  std::string_view word = text_.next();
  while (is_keyword(word, "color")) {
    defects_.colors = true;
    for (double value = 0; parse_real(word = text_.next(), value) != ParseResult::malformed;) continue;
  }
  if (!is_keyword(word, "end")) return word;
  const std::size_t begin = text_.word_begin();
  const std::string_view second = text_.next();
  for (const std::string_view whole : {"endloop", "endfacet", "endsolid"}) {
    if (!is_keyword(second, whole.substr(3))) continue;
    defects_.split_words = true;
    return whole;
  }
  text_.take(begin, begin + word.size());
  return word;
}

void FacetCursor::expect(std::string_view keyword) {
  const std::string_view word = next_keyword();
  if (!is_keyword(word, keyword)) fail_expected(in_quotes(keyword), word);
}

// Whether `facet normal` and a number follow on the line. Stays where it is.
bool FacetCursor::is_at_facet() {
  const std::size_t begin = text_.position();
  double value = 0;
  const bool found = is_keyword(text_.next_on_line(), "facet") && is_keyword(text_.next_on_line(), "normal") &&
                     parse_real(text_.next_on_line(), value) == ParseResult::ok;
  text_.take(begin, begin);
  return found;
}

// Goes past the name after `solid` or `endsolid`, which may have blanks, or be a keyword: to the end of the line, or to
// the facet, or the next `solid` and its facet, that stand on it.
void FacetCursor::end_name(bool of_begin) {
  const std::size_t begin = text_.position();
  std::optional<std::size_t> solid;  // where the last word `solid` begins
  while (true) {
    if ((of_begin || solid) && is_at_facet()) {
      defects_.on_one_line = true;
      const std::size_t at = solid.value_or(text_.position());
      text_.take(at, at);
      return;
    }
    const std::string_view word = text_.next_on_line();
    if (word.empty()) break;
    if (!of_begin && is_keyword(word, "solid")) solid = text_.word_begin();
  }
  text_.take(begin, begin);
  text_.next_line();
}

// Goes past the next `facet`, and the ends and beginnings of solids before it; false at the end of the file.
bool FacetCursor::begin_facet() {
  while (true) {
    const std::string_view word = next_keyword();
    if (in_solid_ && is_keyword(word, "facet")) return true;
    const bool may_end = in_solid_ ? facets_ > 0 : solids_ > 0;
    if (word.empty() && may_end) {
      defects_.open_end = in_solid_;
      return false;
    }
    if (!is_keyword(word, in_solid_ ? "endsolid" : "solid")) {
      fail_expected(in_solid_ ? "'facet' or 'endsolid'" : "'solid'", word);
    }
    in_solid_ = !in_solid_;
    if (in_solid_) ++solids_;
    end_name(in_solid_);
  }
}

bool FacetCursor::next(Facet& facet) {
  if (!begin_facet()) return false;
  ++facets_;
  facet.begin = text_.word_begin();
  const auto take_vector = [&](std::array<std::string_view, 3>& words) {
    for (std::string_view& word : words) {
      word = text_.next();
      if (word.empty()) fail_expected("a number", word);
    }
  };
  expect("normal");
  take_vector(facet.normal);
  expect("outer");
  expect("loop");
  for (auto& corner : facet.corner) {
    expect("vertex");
    take_vector(corner);
  }
  expect("endloop");
  expect("endfacet");
  facet.end = text_.position();
  return true;
}

void read(ShapeFile& shape, const std::string& name) { set_layout(shape, Reader(shape, name).run()); }

}  // namespace knead::detail::stl
