// A polygon mesh: positions in double, faces with any number of corners, attributes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knead/math/vec3.h"

namespace knead {

// What an attribute has one value for.
enum class Domain { vertex, corner, face };

// The number type that an attribute had in its file, and is written with.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

// Numbers carried by vertices, corners or faces, e.g. "normal" (3), "uv" (2), "color" (3 or 4; integer types 0 to their
// maximum, floats 0 to 1).
struct Attribute {
  std::string name;
  Domain domain = Domain::vertex;
  NumberType type = NumberType::float32;
  int components = 1;
  std::vector<double> values;  // components per element, in the elements' order

  friend bool operator==(const Attribute&, const Attribute&) = default;
};

// Faces are stored one after the other: face f has the corners [face_begin[f], face_begin[f + 1]), and corner_vertex
// names the vertex of each corner, counter-clockwise seen from outside. A mesh without faces is a point cloud.
// Invariants: face_begin is never empty, begins with 0, does not decrease and ends with corner_vertex.size(); every
// corner_vertex is below positions.size().
struct Mesh {
  std::vector<Vec3d> positions;
  std::vector<std::uint32_t> face_begin{0};
  std::vector<std::uint32_t> corner_vertex;
  std::vector<Attribute> attributes;

  std::size_t vertex_count() const { return positions.size(); }
  std::size_t face_count() const { return face_begin.size() - 1; }

  // The vertices of face f, in order.
  std::span<const std::uint32_t> face(std::size_t f) const {
    return {corner_vertex.data() + face_begin[f], face_begin[f + 1] - face_begin[f]};
  }

  void add_face(std::span<const std::uint32_t> vertices) {
    corner_vertex.insert(corner_vertex.end(), vertices.begin(), vertices.end());
    face_begin.push_back(static_cast<std::uint32_t>(corner_vertex.size()));
  }

  // The attribute of that name, or null.
  const Attribute* find_attribute(const std::string& name) const {
    for (const Attribute& attribute : attributes) {
      if (attribute.name == name) return &attribute;
    }
    return nullptr;
  }
};

}  // namespace knead
