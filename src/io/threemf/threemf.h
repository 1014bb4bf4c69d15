// 3MF (3MF Consortium, Core Specification 1.3, Production Extension 1.1): a ZIP archive with parts of XML, which hold
// objects and where they are placed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/codec.h"
#include "io/threemf/xml.h"
#include "knead/io.h"
#include "knead/vec.h"

namespace knead::detail::threemf {

// The mesh is what the items of <build> place, in their order, in the model's unit: an object once for each place.
// Components of other parts are read, too, as slicers write them. Colors of <basematerials> and <colorgroup> become the
// attribute "color" of faces, or of corners where these differ.
void read(ShapeFile& shape, const std::string& name);

std::string remeshed(const NewMesh& shape, const WriteOptions& options);

// The placement of an object: x -> turn x + shift. A row vector of the file is a column here.
struct Placement {
  Mat3d turn;
  Vec3d shift{0, 0, 0};

  Vec3d operator()(const Vec3d& p) const { return is_identity() ? p : turn * p + shift; }
  Vec3d inverse_image(const Vec3d& p) const;
  bool is_identity() const { return turn == Mat3d{} && shift == Vec3d{0, 0, 0}; }
  friend Placement operator*(const Placement& a, const Placement& b) {
    return {a.turn * b.turn, a.turn * b.shift + a.shift};
  }
};

// The text of a mesh: the bytes between <vertices> and </vertices>, and between <triangles> and </triangles>.
struct MeshText {
  std::string id;  // of its object
  std::size_t vertices_begin = 0, vertices_end = 0;
  std::size_t triangles_begin = 0, triangles_end = 0;
  bool has_more = false;  // other elements, which may number its vertices or triangles
};

// A part with a model.
struct Part {
  std::string name;
  std::string text;
  std::vector<MeshText> meshes{};
};

// An object with a mesh at a place.
struct Instance {
  std::size_t part = 0;
  std::size_t mesh = 0;  // of the part
  Placement placement;
  std::uint32_t first_vertex = 0, vertices = 0;  // of the shape
  std::uint32_t first_face = 0, faces = 0;
  // A placement that mirrors turns the triangles over.
  bool is_mirrored() const { return determinant(placement.turn) < 0; }
};

struct Layout {
  std::vector<Part> parts;
  std::vector<Instance> instances;
  std::vector<std::uint32_t> labels;  // of faces: equal where the triangles have the same properties; empty: all have
  bool has_metadata = false;
};

// The words of a vertex or triangle.
struct Numbers {
  std::string_view words[3];  // x y z, or v1 v2 v3
  std::string properties;     // the other attributes, as they are spelled
};
// Reads a tag <vertex> or <triangle> with attributes of these names. Throws InvalidInput if one is missing.
void take_numbers(const TagCursor& cursor, const Tag& tag, const std::string_view (&names)[3], Numbers& numbers);
inline constexpr std::string_view kVertexNames[3] = {"x", "y", "z"};
inline constexpr std::string_view kTriangleNames[3] = {"v1", "v2", "v3"};

}  // namespace knead::detail::threemf
