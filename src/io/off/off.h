// OFF (Geomview, Object File Format), text and binary: its row of the format table (formats.h).
#pragma once

#include <bit>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/formats.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "knead/io.h"

namespace knead::io_detail::off {

// [ST][C][N][n]OFF, the letters in any order, or no keyword: the counts, then a vertex on each line, then a face on
// each. After x y z stand the normal, then the color, as Geomview says, or the color first, as MeshLab writes: what the
// numbers of most vertices can be. Attributes: "normal" (N), "uv" (ST), "color" of vertices (C, or three or four more
// numbers than the keyword says) and of faces, "color_index" of faces with one number each; colors are uint8 where all
// are whole numbers and one is above 1.
// OFF BINARY is read in either byte order, and with the count of color numbers after each face or without (as PMP
// writes), whichever takes up the whole file.
ShapeFile parse(std::string bytes, const std::string& name);

// Rounds numbers in a binary file to floats; throws InvalidInput for a position that does not fit.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new text file. A color of a vertex with three numbers gets an alpha: COFF means four.
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);
bool stores_floats(const ShapeFile& source);

// Where the vertices of an OFF file are, and what a mesh does not hold.

struct Layout {
  bool binary = false;
  std::endian order = std::endian::big;  // of a binary file
  bool color_counts = false;             // whether the faces of a binary file say how many color numbers follow
  std::size_t vertex_begin = 0;          // the first byte after the counts
  std::size_t width = 0;                 // numbers per vertex
  std::size_t uv = 0;                    // of them, the last ones
  bool colors_first = false;             // the normal stands after the color
  std::size_t faces_end = 0;             // the byte after the last face
  bool all_read = true;                  // every color and further number is an attribute of the mesh
};

// Making a mesh of the vertices and faces of an OFF file, text or binary.

// What the keyword says that each vertex has; texture coordinates are the last numbers.
struct Fields {
  bool normals = false;
  bool colors = false;  // three or four numbers; four in a binary file
  bool uv = false;

  std::size_t without_colors() const { return 3 + (normals ? 3 : 0) + (uv ? 2 : 0); }
};

// The beginning of a file.
struct Header {
  Fields fields;
  bool binary = false;
  bool lower_case = false;       // the keyword
  std::size_t counts_begin = 0;  // the byte where the counts may begin
};

// Throws InvalidInput for what is no OFF, or has other than three dimensions.
Header parse_header(std::string_view bytes, const std::string& name);

// Colors as they come, one vertex or face after the other.
class Colors {
 public:
  // are_whole: written as whole numbers.
  void add(std::span<const double> numbers, bool are_whole);

  // Whether attribute() is all that was added.
  bool readable(Domain domain) const;
  std::optional<Attribute> attribute(Domain domain) const;

 private:
  std::vector<double> values_;
  std::size_t width_ = 0;
  std::size_t elements_ = 0;
  bool same_width_ = true;
  bool whole_ = true;
};

class MeshBuilder {
 public:
  MeshBuilder(ShapeFile& shape, const Fields& fields) : shape_(shape), fields_(fields), faces_(shape.mesh) {}

  // All numbers of a vertex, as many as fields.without_colors() at least, the first three finite; the others are whole
  // numbers where is_whole says so.
  void add_vertex(std::span<const double> numbers, const std::vector<bool>& is_whole);

  // The vertices of a face, each of which there is, and the numbers of its color.
  void add_face(std::span<const std::uint32_t> vertices, std::span<const double> color, bool is_whole);

  // Adds attributes and notes to the shape. Whether every number is in an attribute.
  bool finish();

  // After finish(): whether the color stands before the normal.
  bool colors_first() const { return colors_first_; }

 private:
  void split_vertices();
  double finite(double value);
  void add_attribute(const char* name, int components, std::vector<double>& values);
  bool add_colors(const Colors& colors, Domain domain);

  ShapeFile& shape_;
  Fields fields_;
  FaceBuilder faces_;
  std::vector<std::uint32_t> face_;
  std::size_t width_ = 0;     // numbers after x y z
  std::vector<double> rest_;  // those of all vertices
  std::vector<bool> is_whole_;
  bool colors_first_ = false;
  std::vector<double> normals_;
  std::vector<double> uv_;
  Colors vertex_colors_;
  Colors face_colors_;
  std::size_t not_finite_ = 0;
};

// The rest of a file after its header. All of the layout but all_read and the order of the color.
Layout read_text(MeshBuilder& builder, const Header& header, ShapeFile& shape, const std::string& name);
Layout read_binary(MeshBuilder& builder, const Header& header, ShapeFile& shape, const std::string& name);

}  // namespace knead::io_detail::off
