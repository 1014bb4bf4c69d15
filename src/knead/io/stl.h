// STL (3D Systems, StereoLithography Interface Specification, 1989), text and binary: reading, writing back, writing
// anew.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/cursor.h"
#include "knead/io/shape_file.h"

namespace knead {

// Binary where the count of triangles fits into the file, even if it begins with "solid"; else text if it does.
// Corners at equal positions become one vertex; every triangle becomes a face, also one without area. Attribute
// "attribute" of faces: the 16 bits after each triangle of a binary file, if any are not 0.
ShapeFile parse_stl(std::string bytes, const std::string& name);

// The source with other positions. The normal of a triangle of which a corner moved becomes that of the new triangle,
// on the side where it was, of unit length, or zero where it has no area; one that is zero stays. Positions in a binary
// file are rounded to floats; throws InvalidInput where one does not fit.
std::string rewrite_stl(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions& options);

// A new binary file of the triangles of triangulate(). Throws InvalidInput for a mesh without faces and for a
// coordinate that does not fit in a float.
std::string generate_stl(const Mesh& mesh, const WriteOptions& options);

// What generate_stl leaves out, a sentence each.
std::vector<std::string> stl_losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> stl_source_losses(const ShapeFile& source);

// The normal of a triangle, of unit length; zero for one without area.
Vec3d facet_normal(const Vec3d& a, const Vec3d& b, const Vec3d& c);

// Where a binary file has its parts, in bytes.
inline constexpr std::size_t kStlHeader = 80;  // then the count of triangles in 32 bits
inline constexpr std::size_t kStlFirst = 84;
inline constexpr std::size_t kStlTriangle = 50;  // normal and corners as 12 floats, then 16 bits

// The words of a triangle in a text file.
struct StlFacet {
  std::size_t begin = 0;  // the bytes from `facet` to `endfacet`
  std::size_t end = 0;
  std::array<std::string_view, 3> normal;
  std::array<std::array<std::string_view, 3>, 3> corner;
};

// The triangles of a text file, one after the other.
class StlFacets {
 public:
  // The bytes and the name must outlive this.
  StlFacets(std::string_view bytes, const std::string& name) : text_(bytes, name, text_begin(bytes, name)) {}

  // The next triangle; false at the end of the file. Throws InvalidInput where something else stands. That its words
  // are numbers is for the caller to find out.
  bool next(StlFacet& facet);

  const TextCursor& text() const { return text_; }
  std::size_t solids() const { return solids_; }  // so far

 private:
  bool begin_facet();
  void expect(std::string_view keyword);
  [[noreturn]] void fail_expected(const std::string& what, std::string_view found) const;

  TextCursor text_;
  bool in_solid_ = false;
  std::size_t solids_ = 0;
};

}  // namespace knead
