// What the files of meshes with other connectivity than their source's must hold. For tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "io/test_samples.h"
#include "knead/io.h"
#include "support/split_faces.h"

namespace knead {

// Everything that a mesh has at a corner: position and attributes in the order of `names`.
inline std::vector<double> at_corner(const Mesh& mesh, std::size_t face, std::size_t corner,
                                     const std::vector<Attribute>& names) {
  const std::uint32_t v = mesh.corner_vertex[corner];
  std::vector<double> numbers{mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z};
  for (const Attribute& name : names) {
    for (const Attribute& a : mesh.attributes) {
      if (a.name != name.name || a.domain != name.domain) continue;
      const std::size_t element = a.domain == Domain::vertex ? v : (a.domain == Domain::corner ? corner : face);
      const std::size_t n = static_cast<std::size_t>(a.components);
      numbers.insert(numbers.end(), a.values.begin() + static_cast<std::ptrdiff_t>(element * n),
                     a.values.begin() + static_cast<std::ptrdiff_t>((element + 1) * n));
    }
  }
  return numbers;
}

// The state that a face of an OBJ file stands under: the lines of each of these keywords that come last before it. Or
// the material of a face of a GLB file. For each face.
inline std::vector<std::string> states_of(const ShapeFile& shape) {
  std::vector<std::string> states;
  if (const detail::gltf::Layout* glb = detail::find_layout<detail::gltf::Layout>(shape)) {
    const GlbJson json = json_of(shape.bytes);
    for (std::size_t r = 0; r < glb->faces.size(); ++r) {
      const detail::gltf::Block& block = glb->blocks[glb->faces[r].block];
      const GlbJson& primitive = json["meshes"][block.mesh]["primitives"][glb->faces[r].primitive];
      const std::string material = primitive.contains("material") ? primitive["material"].dump() : "none";
      const std::size_t end = r + 1 < glb->faces.size() ? glb->faces[r + 1].first : shape.mesh.face_count();
      states.resize(end, "node " + std::to_string(block.node) + " material " + material);
    }
    return states;
  }
  std::vector<std::string> last(5);
  std::istringstream lines(shape.bytes);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line);
    std::string keyword;
    words >> keyword;
    const std::vector<std::string> keywords{"usemtl", "g", "o", "s", "mtllib"};
    const auto found = std::find(keywords.begin(), keywords.end(), keyword);
    if (found != keywords.end()) last[static_cast<std::size_t>(found - keywords.begin())] = line;
    std::size_t corners = 0;
    for (std::string word; words >> word;) ++corners;
    if (keyword == "f" && corners >= 3) states.push_back(testing::PrintToString(last));
  }
  return states;
}

// The file has the faces of the new mesh with all that is at their corners. Numbers of the source's vertices are exact,
// those of others within a tolerance.
inline void expect_remade(const ShapeFile& source, const Remade& remade, const ShapeFile& back, double tolerance) {
  const std::vector<std::uint32_t> order = file_order(source, remade);
  ASSERT_EQ(back.mesh.face_count(), order.size());
  ASSERT_EQ(back.mesh.attributes.size(), source.mesh.attributes.size());
  const bool has_states = source.format == "obj" || source.format == "glb";
  const std::vector<std::string> before = has_states ? states_of(source) : std::vector<std::string>{};
  const std::vector<std::string> after = has_states ? states_of(back) : std::vector<std::string>{};
  std::size_t wrong = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::uint32_t f = order[k];
    ASSERT_EQ(back.mesh.face(k).size(), remade.mesh.face(f).size()) << k;
    if (has_states && !before.empty()) {
      ASSERT_EQ(after[k], before[remade.face_source[f]]) << k;
    }
    for (std::size_t i = 0; i < remade.mesh.face(f).size(); ++i) {
      const auto expected = at_corner(remade.mesh, f, remade.mesh.face_begin[f] + i, source.mesh.attributes);
      const auto found = at_corner(back.mesh, k, back.mesh.face_begin[k] + i, source.mesh.attributes);
      ASSERT_EQ(found.size(), expected.size());
      const bool is_new = remade.mesh.face(f)[i] >= source.mesh.vertex_count();
      for (std::size_t j = 0; j < found.size(); ++j) {
        if (!(std::abs(found[j] - expected[j]) <= (is_new ? tolerance : 0.0))) ++wrong;
      }
    }
  }
  EXPECT_EQ(wrong, 0u) << "numbers at corners";
}

}  // namespace knead
