// Writing an STL file anew with its header or solids and another mesh.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "knead/io/binary_floats.h"
#include "knead/io/layout.h"
#include "knead/io/new_mesh.h"
#include "knead/io/number_types.h"
#include "knead/io/stl/layout.h"
#include "knead/io/stl/stl.h"
#include "knead/mesh/triangulate.h"

namespace knead::io_detail::stl {
namespace {

constexpr std::endian kOrder = std::endian::little;

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

Vec3d vector_at(const std::string& bytes, std::size_t at) {
  Vec3d v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float number = 0;
    std::memcpy(&number, bytes.data() + at + axis * sizeof number, sizeof number);
    v[axis] = double{kOrder == std::endian::native ? number : swap_bytes(number)};
  }
  return v;
}

void append_number(std::string& bytes, auto value) {
  const auto stored = kOrder == std::endian::native ? value : swap_bytes(value);
  bytes.append(reinterpret_cast<const char*>(&stored), sizeof stored);
}

void append_vector(std::string& bytes, const Vec3d& v) {
  for (std::size_t axis = 0; axis < 3; ++axis) append_number(bytes, static_cast<float>(v[axis]));
}

std::string write_binary(const Facets& facets) {
  const Mesh& mesh = facets.shape.mesh;
  const std::string& source = facets.shape.source.bytes;
  check_fits_floats(mesh.positions);
  const Attribute* attribute = mesh.find_attribute("attribute");
  std::string bytes = source.substr(0, kHeaderBytes);
  bytes.reserve(kFirstTriangle + kTriangleBytes * facets.triangles.size());
  append_number(bytes, static_cast<std::uint32_t>(facets.triangles.size()));
  for (std::size_t t = 0; t < facets.triangles.size(); ++t) {
    append_vector(bytes, facets.normal(t, vector_at(source, kFirstTriangle + kTriangleBytes * facets.source[t])));
    for (const std::uint32_t v : facets.triangles[t]) append_vector(bytes, mesh.positions[v]);
    const double bits = attribute == nullptr ? 0 : attribute->values[facets.face[t]];
    append_number(bytes, static_cast<std::uint16_t>(nearest_of(NumberType::uint16, bits)));
  }
  return bytes + source.substr(kFirstTriangle + kTriangleBytes * facets.shape.source.mesh.face_count());
}

Vec3d parsed(const std::array<std::string_view, 3>& words) {
  Vec3d v;
  for (std::size_t axis = 0; axis < 3; ++axis) parse_real(words[axis], v[axis]);  // read before: well formed
  return v;
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

}  // namespace

std::string remeshed(const NewMesh& shape, const WriteOptions& options) {
  const Facets facets(shape);
  return layout_of<Layout>(shape.source).binary ? write_binary(facets) : TextWriter(facets, options.decimals).run();
}

std::vector<std::string> remesh_losses(const ShapeFile& /*source*/) { return {}; }

}  // namespace knead::io_detail::stl
