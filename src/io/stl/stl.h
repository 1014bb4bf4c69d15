// STL (3D Systems, StereoLithography Interface Specification, 1989), text and binary: where a file has its parts, and
// the triangles of a text file.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "io/codec.h"
#include "io/text.h"
#include "knead/io.h"

namespace knead::detail::stl {

// The corners of the mesh are those of the file, in its order.
struct Layout {
  bool binary = false;
  std::size_t solids = 1;  // a text may have several
};

// Binary where the count of triangles fits into the file, even if it begins with "solid"; else text if it does. A
// binary file whose count is 0 or 2^32 - 1 has as many triangles as its length says, if they fill it.
// Corners at equal positions become one vertex; every triangle becomes a face, also one without area. Attribute
// "attribute" of faces: the 16 bits after each triangle of a binary file, if any are not 0.
void read(ShapeFile& shape, const std::string& name);

// Where a binary file has its parts, in bytes.
inline constexpr std::size_t kHeaderBytes = 80;  // then the count of triangles in 32 bits
inline constexpr std::size_t kFirstTriangle = 84;
inline constexpr std::size_t kTriangleBytes = 50;  // normal and corners as 12 floats, then 16 bits

// The words of a triangle in a text file.
struct Facet {
  std::size_t begin = 0;  // the bytes from `facet` to `endfacet`
  std::size_t end = 0;
  std::array<std::string_view, 3> normal;
  std::array<std::array<std::string_view, 3>, 3> corner;
};

// Deviations of text files from the specification, which the reader accepts.
struct Defects {
  bool open_end = false;     // no `endsolid` at the end
  bool on_one_line = false;  // a facet follows the name of its solid on the line
  bool colors = false;       // `color` and numbers
  bool split_words = false;  // `end loop`, `end facet`, `end solid`
};

// The triangles of a text file, one after the other.
class FacetCursor {
 public:
  // The bytes and the name must outlive this.
  FacetCursor(std::string_view bytes, const std::string& name)
      : text_(without_end_zeros(bytes), name, text_begin(bytes, name)) {}

  // The next triangle; false at the end of the file. Throws InvalidInput where something else stands. That its words
  // are numbers is for the caller to find out.
  bool next(Facet& facet);

  const TextCursor& text() const { return text_; }
  std::size_t solids() const { return solids_; }       // so far
  const Defects& defects() const { return defects_; }  // so far

 private:
  bool begin_facet();
  void end_name(bool of_begin);
  bool is_at_facet();
  std::string_view next_keyword();
  void expect(std::string_view keyword);
  [[noreturn]] void fail_expected(const std::string& what, std::string_view found) const;

  TextCursor text_;
  Defects defects_;
  bool in_solid_ = false;
  std::size_t solids_ = 0;
  std::size_t facets_ = 0;
};

}  // namespace knead::detail::stl
