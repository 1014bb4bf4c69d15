// Writing STL: the source's bytes with some numbers replaced, or a new file.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "knead/io/binary_floats.h"
#include "knead/io/face_builder.h"
#include "knead/io/layout.h"
#include "knead/io/splice.h"
#include "knead/io/stl/layout.h"
#include "knead/io/stl/stl.h"
#include "knead/io/text.h"
#include "knead/math/error.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/triangulate.h"

namespace knead::io_detail::stl {
namespace {

constexpr std::endian kOrder = std::endian::little;

template <class T>
T little_endian(T value) {
  return kOrder == std::endian::native ? value : swap_bytes(value);
}

float float_at(const std::string& bytes, std::size_t at) {
  float stored = 0;
  std::memcpy(&stored, bytes.data() + at, sizeof stored);
  return little_endian(stored);
}

// The triangles of a source and where they go.
struct Moved {
  const ShapeFile& source;
  std::span<const Vec3d> positions;

  std::uint32_t vertex(std::size_t triangle, std::size_t corner) const {
    return source.mesh.corner_vertex[3 * triangle + corner];
  }

  bool any(std::size_t triangle) const {
    for (std::size_t c = 0; c < 3; ++c) {
      if (!(positions[vertex(triangle, c)] == source.mesh.positions[vertex(triangle, c)])) return true;
    }
    return false;
  }

  // On the side of the triangle where the old one is: some exporters write all of them inward.
  Vec3d normal(std::size_t triangle, const Vec3d& old) const {
    const Vec3d after = normal_among(positions, triangle);
    return dot(old, normal_among(source.mesh.positions, triangle)) < 0 ? Vec3d{} - after : after;
  }

  Vec3d normal_among(std::span<const Vec3d> vertices, std::size_t triangle) const {
    return facet_normal(vertices[vertex(triangle, 0)], vertices[vertex(triangle, 1)], vertices[vertex(triangle, 2)]);
  }
};

std::string rewrite_binary(const Moved& moved) {
  check_fits_floats(moved.positions);
  const ShapeFile& source = moved.source;
  std::string bytes = source.bytes;
  for (std::size_t t = 0; t < source.mesh.face_count(); ++t) {
    if (!moved.any(t)) continue;
    const std::size_t begin = kFirstTriangle + t * kTriangleBytes;
    const auto old = [&](std::size_t axis) { return double{float_at(source.bytes, begin + axis * sizeof(float))}; };
    const Vec3d old_normal{old(0), old(1), old(2)};
    if (!(old_normal == Vec3d{})) replace_floats(bytes, begin, old_normal, moved.normal(t, old_normal), kOrder);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t v = moved.vertex(t, c);
      replace_floats(bytes, begin + (c + 1) * 3 * sizeof(float), source.mesh.positions[v], moved.positions[v], kOrder);
    }
  }
  return bytes;
}

Vec3d parsed(const std::array<std::string_view, 3>& words) {
  Vec3d v;
  for (std::size_t axis = 0; axis < 3; ++axis) parse_real(words[axis], v[axis]);  // read before: well formed
  return v;
}

std::string rewrite_text(const Moved& moved, const WriteOptions& options) {
  const ShapeFile& source = moved.source;
  Splice splice(source.bytes, options.decimals);
  const auto words_of = [](const std::array<std::string_view, 3>& words) {
    return [&words, next = std::size_t{0}]() mutable { return words[next++]; };
  };
  FacetCursor facets(source.bytes, source.format);
  Facet facet;
  for (std::size_t t = 0; facets.next(facet); ++t) {
    if (!moved.any(t)) continue;
    const Vec3d old_normal = parsed(facet.normal);
    if (!(old_normal == Vec3d{})) {
      splice.replace_direction(old_normal, moved.normal(t, old_normal), words_of(facet.normal));
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t v = moved.vertex(t, c);
      splice.replace_changed(source.mesh.positions[v], moved.positions[v], words_of(facet.corner[c]));
    }
  }
  return splice.finish();
}

bool is_held(const Attribute& attribute) {
  return attribute.name == "attribute" && attribute.domain == Domain::face && attribute.type == NumberType::uint16 &&
         attribute.components == 1;
}

std::size_t count_unused(const Mesh& mesh) {
  std::vector<bool> used(mesh.vertex_count(), false);
  for (const std::uint32_t v : mesh.corner_vertex) used[v] = true;
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
}

bool are_floats(const Vec3d& p) { return fits_floats(p) && p == Vec3d(Vec3f(p)); }

}  // namespace

Vec3d facet_normal(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  Vec3d u = b - a;
  Vec3d v = c - a;
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max({largest, std::abs(u[axis]), std::abs(v[axis])});
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  u = u / largest;  // so that products neither overflow nor vanish
  v = v / largest;
  return is_degenerate({}, u, v) ? Vec3d{} : normalized(cross(u, v));
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d>,
                    const WriteOptions& options) {
  const Moved moved{source, positions};
  return layout_of<Layout>(source).binary ? rewrite_binary(moved) : rewrite_text(moved, options);
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  if (layout_of<Layout>(source).binary) return;
  FacetCursor facets(source.bytes, source.format);
  for (Facet facet; facets.next(facet);) {
    for (const auto& corner : facet.corner) {
      for (const std::string_view word : corner) visit(word);
    }
  }
}

std::string generate(const Mesh& mesh, const WriteOptions&) {
  if (mesh.face_count() == 0) throw InvalidInput("STL cannot hold points without faces; write PLY or XYZ");
  check_fits_floats(mesh.positions);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const auto held = std::find_if(mesh.attributes.begin(), mesh.attributes.end(), is_held);
  std::vector<std::uint32_t> faces;
  if (held != mesh.attributes.end()) faces = triangle_faces(mesh);
  std::string bytes(kFirstTriangle + kTriangleBytes * triangles.size(), '\0');
  std::memcpy(bytes.data(), "Knead", 5);
  const std::uint32_t count = little_endian(static_cast<std::uint32_t>(triangles.size()));
  std::memcpy(bytes.data() + kHeaderBytes, &count, sizeof count);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::size_t begin = kFirstTriangle + t * kTriangleBytes;
    const auto& [a, b, c] = triangles[t];
    const Vec3d rows[4] = {facet_normal(mesh.positions[a], mesh.positions[b], mesh.positions[c]), mesh.positions[a],
                           mesh.positions[b], mesh.positions[c]};
    for (std::size_t i = 0; i < 12; ++i) put_float(bytes, begin + i * sizeof(float), rows[i / 3][i % 3], kOrder);
    if (faces.empty()) continue;
    const std::uint16_t attribute = little_endian(static_cast<std::uint16_t>(held->values[faces[t]]));
    std::memcpy(bytes.data() + begin + 12 * sizeof(float), &attribute, sizeof attribute);
  }
  return bytes;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  if (mesh.face_count() == 0) losses.push_back("STL cannot hold points without faces");
  std::size_t polygons = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) polygons += mesh.face(f).size() > 3 ? 1 : 0;
  if (polygons > 0) {
    losses.push_back(counted(polygons, "polygon is cut into triangles", "polygons are cut into triangles"));
  }
  const std::size_t unused = mesh.face_count() > 0 ? count_unused(mesh) : 0;
  if (unused > 0) {
    losses.push_back(counted(unused, "vertex in no face is left out", "vertices in no face are left out"));
  }
  if (!std::all_of(mesh.positions.begin(), mesh.positions.end(), are_floats)) {
    losses.push_back("coordinates are rounded to floats");
  }
  for (const Attribute& attribute : mesh.attributes) {
    if (!is_held(attribute)) losses.push_back("STL cannot hold '" + attribute.name + "'");
  }
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const std::size_t solids = layout_of<Layout>(source).solids;
  if (solids < 2) return {};
  return {"the division into " + std::to_string(solids) + " solids is left out"};
}

bool stores_floats(const ShapeFile& source) { return layout_of<Layout>(source).binary; }

}  // namespace knead::io_detail::stl
