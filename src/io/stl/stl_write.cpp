// Writing STL: the source's bytes with some numbers replaced, or a new file.
#include <algorithm>
#include <cmath>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/stl/stl.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::stl {
namespace {

constexpr std::endian kOrder = std::endian::little;
constexpr bool kSwapped = kOrder != std::endian::native;

Vec3d vector_at(const std::string& bytes, std::size_t at) {
  Vec3d v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    v[axis] = read_binary(bytes.data() + at + axis * sizeof(float), NumberType::float32, kSwapped);
  }
  return v;
}

// The normal of a triangle, of unit length; zero for one without area.
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

void append_vector(std::string& bytes, const Vec3d& v) {
  for (std::size_t axis = 0; axis < 3; ++axis) append_binary(bytes, NumberType::float32, v[axis], kSwapped);
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
    const Vec3d old_normal = vector_at(source.bytes, begin);
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

// The normal of a triangle with a moved corner becomes that of the new triangle, of unit length and on the side where
// it was; zero for a triangle without area. A zero normal stays zero.
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

// A new binary file of the triangles of triangulate().
std::string generate(const Mesh& mesh, const WriteOptions&) {
  if (mesh.face_count() == 0) throw InvalidInput("STL cannot hold points without faces; write PLY or XYZ");
  check_fits_floats(mesh.positions);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const auto held = std::find_if(mesh.attributes.begin(), mesh.attributes.end(), is_held);
  std::vector<std::uint32_t> faces;
  if (held != mesh.attributes.end()) faces = triangle_faces(mesh);
  std::string bytes = "Knead";
  bytes.resize(kHeaderBytes, '\0');
  bytes.reserve(kFirstTriangle + kTriangleBytes * triangles.size());
  append_binary(bytes, NumberType::uint32, static_cast<double>(triangles.size()), kSwapped);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto corner = [&](std::size_t c) { return mesh.positions[triangles[t][c]]; };
    append_vector(bytes, facet_normal(corner(0), corner(1), corner(2)));
    for (std::size_t c = 0; c < 3; ++c) append_vector(bytes, corner(c));
    append_binary(bytes, NumberType::uint16, faces.empty() ? 0 : held->values[faces[t]], kSwapped);
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
  const std::vector<bool> used = mesh.face_count() > 0 ? used_vertices(mesh) : std::vector<bool>();
  const auto unused = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  if (unused > 0) {
    losses.push_back(counted(unused, "vertex in no face is left out", "vertices in no face are left out"));
  }
  if (!are_floats(mesh.positions)) losses.push_back("coordinates are rounded to floats");
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

// A file like the source, with its header or solids, and another mesh.

// The new triangles and the facet of the source that each lies in.
struct Facets {
  const NewMesh& shape;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> source;
  std::vector<std::uint32_t> face;

  explicit Facets(const NewMesh& of) : shape(of), triangles(triangulate(of.mesh)), face(triangle_faces(of.mesh)) {
    for (const std::uint32_t f : face) source.push_back(shape.face_source[f]);
  }

  // Of the source's facet where the triangle is the same; else the triangle's own, on the side where the old one is,
  // or zero as that is.
  Vec3d normal(std::size_t t, const Vec3d& old) const {
    const std::span<const std::uint32_t> facet = shape.source.mesh.face(source[t]);
    const auto before = [&](std::size_t c) { return shape.source.mesh.positions[facet[c]]; };
    const auto after = [&](std::size_t c) { return shape.mesh.positions[triangles[t][c]]; };
    const bool is_same = before(0) == after(0) && before(1) == after(1) && before(2) == after(2);
    if (is_same || old == Vec3d{}) return old;
    const Vec3d unit = facet_normal(after(0), after(1), after(2));
    return dot(old, facet_normal(before(0), before(1), before(2))) < 0 ? Vec3d{} - unit : unit;
  }
};

std::string write_binary(const Facets& facets) {
  const Mesh& mesh = facets.shape.mesh;
  const std::string& source = facets.shape.source.bytes;
  check_fits_floats(mesh.positions);
  const Attribute* attribute = mesh.find_attribute("attribute");
  std::string bytes = source.substr(0, kHeaderBytes);
  bytes.reserve(kFirstTriangle + kTriangleBytes * facets.triangles.size());
  append_binary(bytes, NumberType::uint32, static_cast<double>(facets.triangles.size()), kSwapped);
  for (std::size_t t = 0; t < facets.triangles.size(); ++t) {
    append_vector(bytes, facets.normal(t, vector_at(source, kFirstTriangle + kTriangleBytes * facets.source[t])));
    for (const std::uint32_t v : facets.triangles[t]) append_vector(bytes, mesh.positions[v]);
    const double bits = attribute == nullptr ? 0 : attribute->values[facets.face[t]];
    append_binary(bytes, NumberType::uint16, nearest_of(NumberType::uint16, bits), kSwapped);
  }
  return bytes + source.substr(kFirstTriangle + kTriangleBytes * facets.shape.source.mesh.face_count());
}

class TextWriter {
 public:
  TextWriter(const Facets& facets, std::optional<int> decimals)
      : decimals_(decimals),
        facets_(facets),
        mesh_(facets.shape.mesh),
        bytes_(facets.shape.source.bytes),
        new_facets_(facets.source, facets.shape.source.mesh.face_count()) {}

  std::string run() {
    FacetCursor source(bytes_, facets_.shape.source.format);
    std::size_t copied = 0;
    Facet facet;
    for (std::size_t f = 0; source.next(facet); ++f) {
      const std::size_t gap = gap_before(facet.begin);
      result_.append(bytes_, copied, gap - copied);
      for (const std::uint32_t t : new_facets_.of(f)) append_facet(facet, gap, t);
      copied = facet.end;
    }
    result_.append(bytes_, copied);
    return std::move(result_);
  }

 private:
  // Where the blanks before a facet begin.
  std::size_t gap_before(std::size_t begin) const {
    while (begin > 0 && (is_blank(bytes_[begin - 1]) || is_line_end(bytes_[begin - 1]))) --begin;
    return begin;
  }

  // As the source's facet is spelled, from the byte `gap` before it.
  void append_facet(const Facet& facet, std::size_t gap, std::uint32_t t) {
    const std::string_view text = std::string_view(bytes_).substr(0, facet.end);
    std::size_t copied = gap;
    const auto replace = [&](std::string_view word, double from, double to, std::optional<int> decimals) {
      if (from == to) return;
      const std::size_t begin = static_cast<std::size_t>(word.data() - text.data());
      result_ += text.substr(copied, begin - copied);
      append_decimals(result_, to, decimals);
      copied = begin + word.size();
    };
    const Vec3d old_normal = parsed(facet.normal);
    const Vec3d normal = is_finite(old_normal) ? facets_.normal(t, old_normal) : old_normal;
    for (std::size_t axis = 0; axis < 3 && is_finite(normal); ++axis)
      replace(facet.normal[axis], old_normal[axis], normal[axis], direction_decimals(decimals_));
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d from = parsed(facet.corner[c]);
      const Vec3d& to = mesh_.positions[facets_.triangles[t][c]];
      for (std::size_t axis = 0; axis < 3; ++axis) replace(facet.corner[c][axis], from[axis], to[axis], decimals_);
    }
    result_ += text.substr(copied);
  }

  std::optional<int> decimals_;
  const Facets& facets_;
  const Mesh& mesh_;
  const std::string& bytes_;
  BySource new_facets_;
  std::string result_;
};

std::string remeshed(const NewMesh& shape, const WriteOptions& options) {
  const Facets facets(shape);
  return layout_of<Layout>(shape.source).binary ? write_binary(facets) : TextWriter(facets, options.decimals).run();
}

std::vector<std::string> remesh_losses(const ShapeFile& /*source*/) { return {}; }

}  // namespace
}  // namespace knead::detail::stl

const knead::detail::Codec knead::detail::stl_codec{.name = "stl",
                                                    .read = stl::read,
                                                    .rewrite = stl::rewrite,
                                                    .generate = stl::generate,
                                                    .losses = stl::losses,
                                                    .source_losses = stl::source_losses,
                                                    .remeshed = stl::remeshed,
                                                    .remesh_losses = stl::remesh_losses,
                                                    .stores_floats = stl::stores_floats,
                                                    .generates_floats = true,
                                                    .needs_faces = true,
                                                    .visit_coordinates = stl::visit_coordinates};
