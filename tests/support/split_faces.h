// Meshes with other connectivity than the file they came from. For tests and fuzzers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "io/codec.h"
#include "io/gltf/gltf.h"
#include "io/stl/stl.h"
#include "knead/io.h"

namespace knead {

// A mesh and for each face the face of the source's mesh that it lies in.
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
    if (values.size() == 4 && length > 0) values[3] = values[3] < 0 ? -1 : 1;
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
  const detail::gltf::Layout* glb = detail::find_layout<detail::gltf::Layout>(source);
  const detail::stl::Layout* stl = detail::find_layout<detail::stl::Layout>(source);
  if (source.format == "obj" || source.format == "3mf" || (stl != nullptr && !stl->binary)) return face;
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

}  // namespace knead
