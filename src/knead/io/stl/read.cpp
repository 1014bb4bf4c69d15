// Reading STL.
#include <algorithm>
#include <cmath>
#include <limits>

#include "knead/io/face_builder.h"
#include "knead/io/layout.h"
#include "knead/io/stl/layout.h"
#include "knead/io/stl/stl.h"
#include "knead/io/text.h"
#include "knead/io/welder.h"
#include "knead/math/error.h"
#include "knead/mesh/measures.h"

namespace knead::io_detail::stl {
namespace {

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
    std::string word(TextCursor(bytes_, name_, text_begin(bytes_, name_)).next().substr(0, 5));
    for (char& c : word) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return word == "solid";
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
    note_oddities(facets.oddities());
    return facets.solids();
  }

  void note_oddities(const Oddities& odd) {
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

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "stl";
  shape.bytes = std::move(bytes);
  set_layout(shape, Reader(shape, name).run());
  return shape;
}

}  // namespace knead::io_detail::stl
