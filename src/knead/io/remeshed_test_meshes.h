// Meshes with other connectivity than the file they came from, and what their files must hold. For tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "knead/io/glb_test_files.h"
#include "knead/io/remeshed.h"

namespace knead {

struct Remade {
  Mesh mesh;
  std::vector<std::uint32_t> face_source;
};

inline Remade same_again(const Mesh& mesh) {
  Remade remade{mesh, std::vector<std::uint32_t>(mesh.face_count())};
  std::iota(remade.face_source.begin(), remade.face_source.end(), 0u);
  return remade;
}

// A number as its type holds it.
inline double as_held(NumberType type, double value) {
  if (type == NumberType::float32) return double{static_cast<float>(value)};
  return type == NumberType::float64 ? value : std::round(value);
}

// A mean as the attribute may hold it: directions are of length 1, with a hand of -1 or 1.
inline void make_valid(const Attribute& attribute, std::vector<double>& values) {
  if (attribute.name == "normal" || attribute.name == "tangent") {
    const double length = norm(Vec3d{values[0], values[1], values[2]});
    for (std::size_t k = 0; k < 3 && length > 0; ++k) values[k] /= length;
    if (values.size() == 4) values[3] = values[3] < 0 ? -1 : 1;
  }
  for (double& value : values) value = as_held(attribute.type, value);
}

// Cuts every face for which `is_cut` says so into triangles around its middle, to which it gives the mean of positions
// and attributes; the other faces stay, and come where they were.
template <class IsCut>
Remade split_faces(const Mesh& mesh, IsCut is_cut) {
  Remade result;
  Mesh& made = result.mesh;
  made.positions = mesh.positions;
  std::vector<std::vector<std::size_t>> corner_of;    // of each new corner: the old ones that it is the mean of
  std::vector<std::vector<std::uint32_t>> vertex_of;  // of each new vertex after the old ones
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    std::vector<std::size_t> corners(face.size());
    std::iota(corners.begin(), corners.end(), std::size_t{mesh.face_begin[f]});
    if (!is_cut(f)) {
      made.add_face(face);
      result.face_source.push_back(f);
      for (const std::size_t c : corners) corner_of.push_back({c});
      continue;
    }
    const std::uint32_t middle = static_cast<std::uint32_t>(made.positions.size());
    Vec3d sum;
    for (const std::uint32_t v : face) sum += mesh.positions[v];
    made.positions.push_back(Vec3d(Vec3f(sum / static_cast<double>(face.size()))));
    vertex_of.emplace_back(face.begin(), face.end());
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::size_t j = (i + 1) % face.size();
      made.add_face(std::vector<std::uint32_t>{face[i], face[j], middle});
      result.face_source.push_back(f);
      corner_of.push_back({corners[i]});
      corner_of.push_back({corners[j]});
      corner_of.push_back(corners);
    }
  }
  for (const Attribute& attribute : mesh.attributes) {
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    Attribute& to = made.attributes.emplace_back(attribute);
    const auto append_mean = [&](const auto& elements) {
      std::vector<double> mean(n, 0.0);
      for (std::size_t k = 0; k < n; ++k) {
        for (const auto e : elements) mean[k] += attribute.values[e * n + k] / static_cast<double>(elements.size());
      }
      if (elements.size() > 1) make_valid(attribute, mean);
      to.values.insert(to.values.end(), mean.begin(), mean.end());
    };
    if (attribute.domain == Domain::vertex) {
      for (const auto& vertices : vertex_of) append_mean(vertices);
      continue;
    }
    to.values.clear();
    if (attribute.domain == Domain::corner) {
      for (const auto& corners : corner_of) append_mean(corners);
    } else {
      for (const std::uint32_t f : result.face_source) append_mean(std::vector<std::uint32_t>{f});
    }
  }
  return result;
}

inline Remade split_all(const Mesh& mesh) {
  return split_faces(mesh, [](std::uint32_t) { return true; });
}

// The list of faces of the source in one primitive; the face's own for other formats that put faces where their source
// was.
inline std::size_t place_of(const ShapeFile& source, std::uint32_t face) {
  const GlbLayout* glb = std::get_if<GlbLayout>(&source.layout);
  const StlLayout* stl = std::get_if<StlLayout>(&source.layout);
  if (source.format == "obj" || (stl != nullptr && !stl->binary)) return face;
  if (glb == nullptr) return 0;
  std::size_t run = 0;
  while (run + 1 < glb->faces.size() && glb->faces[run + 1].first <= face) ++run;
  return run;
}

// The new faces in the order in which the file has them.
inline std::vector<std::uint32_t> file_order(const ShapeFile& source, const Remade& remade) {
  std::vector<std::uint32_t> order(remade.mesh.face_count());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return place_of(source, remade.face_source[a]) < place_of(source, remade.face_source[b]);
  });
  return order;
}

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
  if (const GlbLayout* glb = std::get_if<GlbLayout>(&shape.layout)) {
    const GlbJson json = json_of(shape.bytes);
    for (std::size_t r = 0; r < glb->faces.size(); ++r) {
      const GlbBlock& block = glb->blocks[glb->faces[r].block];
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
