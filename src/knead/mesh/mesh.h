// A polygon mesh: positions in double precision, faces with any number of corners, attributes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knead/math/vec3.h"

namespace knead {

// The kind of element that an attribute has a value for.
enum class Domain { vertex, corner, face };

// The number type of an attribute in its file; it is written with the same type.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

// Numbers for each vertex, corner or face, e.g. "normal" (3 components), "uv" (2), "color" (3 or 4; from 0 to the
// maximum of an integer type, or from 0 to 1 for floats).
struct Attribute {
  std::string name;
  Domain domain = Domain::vertex;
  NumberType type = NumberType::float32;
  int components = 1;
  std::vector<double> values;  // `components` numbers for each element, in the order of the elements

  friend bool operator==(const Attribute&, const Attribute&) = default;
};

// A polygon mesh, or a point cloud if it has no faces. Face f has the corners [face_begin[f], face_begin[f + 1]);
// corner_vertex holds the vertex of each corner. Corners are counter-clockwise seen from outside.
//
// Invariants: face_begin is never empty, begins with 0, never decreases and ends with corner_vertex.size(). Every entry
// of corner_vertex is below positions.size(). Readers and makers give such meshes; validate() checks others.
struct Mesh {
  std::vector<Vec3d> positions;
  std::vector<std::uint32_t> face_begin{0};
  std::vector<std::uint32_t> corner_vertex;
  std::vector<Attribute> attributes;

  // Returns the number of vertices.
  std::size_t vertex_count() const { return positions.size(); }
  // Returns the number of faces.
  std::size_t face_count() const { return face_begin.size() - 1; }

  // Returns the vertices of face f, in order.
  std::span<const std::uint32_t> face(std::size_t f) const {
    return {corner_vertex.data() + face_begin[f], face_begin[f + 1] - face_begin[f]};
  }

  // Appends a face. The caller appends its values to corner and face attributes.
  void add_face(std::span<const std::uint32_t> vertices) {
    corner_vertex.insert(corner_vertex.end(), vertices.begin(), vertices.end());
    face_begin.push_back(static_cast<std::uint32_t>(corner_vertex.size()));
  }

  // Returns the first attribute of that name, or null.
  const Attribute* find_attribute(const std::string& name) const {
    for (const Attribute& attribute : attributes) {
      if (attribute.name == name) return &attribute;
    }
    return nullptr;
  }
};

// Throws InvalidInput, with the number of the first vertex, face or corner at fault, unless the invariants hold, every
// coordinate is finite, and every attribute has its numbers. Time: linear.
void validate(const Mesh& mesh);

}  // namespace knead
