// Writing a mesh as a new GLB file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "knead/io/glb/attributes.h"
#include "knead/io/glb/edit.h"
#include "knead/io/glb/glb.h"
#include "knead/io/glb/writable.h"
#include "knead/io/text.h"
#include "knead/mesh/normals.h"
#include "knead/mesh/triangulate.h"

namespace knead::io_detail::glb {
namespace {

// Triangles of file vertices; triangulate cuts each face by its corners' numbers here, so that corners stay apart.
std::vector<std::uint32_t> triangle_indices(const Mesh& mesh, const SplitVertices& split) {
  Mesh cut;
  cut.face_begin = mesh.face_begin;
  cut.corner_vertex = split.corner_index;
  for (const std::uint32_t v : split.original) cut.positions.push_back(mesh.positions[v]);
  std::vector<std::uint32_t> indices;
  for (const Triangle& triangle : triangulate(cut)) indices.insert(indices.end(), triangle.begin(), triangle.end());
  return indices;
}

constexpr int kVertices = 34962;  // OpenGL's ARRAY_BUFFER
constexpr int kIndices = 34963;   // and ELEMENT_ARRAY_BUFFER

// How an accessor's elements lie in the buffer.
struct Packing {
  int target = kVertices;
  bool is_normalized = false;
  int stride = 0;  // bytes from one element to the next; 0: as many as an element has
};

class Generator {
 public:
  explicit Generator(const Mesh& mesh)
      : mesh_(mesh), held_(writable_attributes(mesh).attributes), split_(split_vertices(mesh, held_)) {}

  std::string run() {
    Json json{{"asset", Json{{"version", "2.0"}, {"generator", "Knead"}}},
              {"scene", 0},
              {"scenes", list_of(Json{{"nodes", list_of(0)}})}};
    if (mesh_.positions.empty()) {
      json.set("nodes", list_of(Json::object()));
    } else {
      const Json mesh{{"primitives", list_of(primitive())}};
      json.set("nodes", list_of(Json{{"mesh", 0}}));
      json.set("meshes", list_of(mesh));
      json.set("bufferViews", views_);
      json.set("accessors", accessors_);
      json.set("buffers", list_of(Json{{"byteLength", bin_.size()}}));
    }
    std::string chunks;
    append_chunk(chunks, kJson, to_text(json));
    if (!bin_.empty()) append_chunk(chunks, kBin, bin_);
    return with_header(chunks);
  }

 private:
  static Json list_of(Json item) { return std::vector<Json>{std::move(item)}; }

  Json primitive() {
    Json attributes{{"POSITION", positions()}};
    for (const WritableAttribute& held : held_) attributes.set(held.key, values(held));
    Json primitive{{"attributes", attributes}};
    if (mesh_.face_count() > 0) primitive.set("indices", indices());
    primitive.set("mode", mesh_.face_count() > 0 ? kTriangles : kPoints);
    return primitive;
  }

  // Adds an accessor of what was appended since `begin`, and its view. Returns the accessor's number.
  std::size_t append_accessor(std::size_t begin, Json accessor, const Packing& packing) {
    bin_.resize((bin_.size() + 3) / 4 * 4, '\0');
    Json view{{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bin_.size() - begin}, {"target", packing.target}};
    if (packing.stride > 0) view.set("byteStride", packing.stride);
    accessor.set("bufferView", views_.items().size());
    if (packing.is_normalized) accessor.set("normalized", true);
    views_.push_back(std::move(view));
    accessors_.push_back(std::move(accessor));
    return accessors_.items().size() - 1;
  }

  std::size_t positions() {
    std::vector<float> floats;
    for (const std::uint32_t v : split_.original) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double value = mesh_.positions[v][axis];
        if (!fits_float(value)) {
          throw InvalidInput(
              "a coordinate does not fit in a float, the only type that GLB has for it; write another format");
        }
        floats.push_back(static_cast<float>(value));
      }
    }
    const std::size_t begin = bin_.size();
    for (const float value : floats) append_float(bin_, value);
    return append_accessor(begin,
                           {{"componentType", 5126},
                            {"count", split_.original.size()},
                            {"type", "VEC3"},
                            {"min", parse_json(least_text(floats, 3))},
                            {"max", parse_json(greatest_text(floats, 3))}},
                           {kVertices});
  }

  std::size_t values(const WritableAttribute& held) {
    const Attribute& attribute = held.attribute;
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    const bool is_color = held.key == "COLOR_0";
    const bool is_bytes = is_color && attribute.type == NumberType::uint8;
    const bool is_shorts = is_color && attribute.type == NumberType::uint16;
    const std::size_t begin = bin_.size();
    for (std::size_t i = 0; i < split_.original.size(); ++i) {
      append_element(held, i);
      bin_.resize((bin_.size() + 3) / 4 * 4, '\0');
    }
    const bool is_integer = is_bytes || is_shorts;
    return append_accessor(begin,
                           {{"componentType", is_bytes ? 5121 : (is_shorts ? 5123 : 5126)},
                            {"count", split_.original.size()},
                            {"type", n == 1 ? "SCALAR" : fmt::format("VEC{}", n)}},
                           {kVertices, is_integer, is_integer && n == 3 ? (is_bytes ? 4 : 8) : 0});
  }

  void append_element(const WritableAttribute& held, std::size_t i) {
    const Attribute& attribute = held.attribute;
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    std::vector<double> element(n, 0.0);
    const bool is_corner = attribute.domain == Domain::corner;
    if (!is_corner || split_.corner[i] != SplitVertices::kNone) {
      const double* from = attribute.values.data() + n * (is_corner ? split_.corner[i] : split_.original[i]);
      std::copy(from, from + n, element.begin());
    }
    if (held.key == "NORMAL" || held.key == "TANGENT") make_unit(held.key, element, i);
    if (held.key == "TEXCOORD_0") element[1] = 1 - element[1];
    for (const double value : element)
      append_value(held.key == "COLOR_0" ? attribute.type : NumberType::float32, value);
  }

  // glTF allows no direction of zero: the surface's own stands in.
  void make_unit(const std::string& key, std::vector<double>& element, std::size_t i) {
    Vec3d unit = direction({element[0], element[1], element[2]});
    if (unit == Vec3d{} && key == "NORMAL") {
      if (surface_normals_.empty()) surface_normals_ = vertex_normals(mesh_);
      unit = surface_normals_[split_.original[i]];
    }
    if (unit == Vec3d{}) unit = key == "NORMAL" ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) element[axis] = unit[axis];
    if (key == "TANGENT") element[3] = element[3] < 0 ? -1 : 1;
  }

  // Colors of other integer types become floats from 0 to 1.
  void append_value(NumberType type, double value) {
    const auto integer = [&](double most) { return static_cast<unsigned>(std::clamp(value, 0.0, most)); };
    const auto real = [&](double one) {
      constexpr double most = std::numeric_limits<float>::max();
      append_float(bin_, static_cast<float>(std::clamp(value / one, -most, most)));
    };
    switch (type) {
      case NumberType::uint8:
        bin_ += static_cast<char>(integer(255));
        break;
      case NumberType::uint16:
        bin_ += static_cast<char>(integer(65535) & 0xffu);
        bin_ += static_cast<char>(integer(65535) >> 8);
        break;
      case NumberType::int8:
        real(127);
        break;
      case NumberType::int16:
        real(32767);
        break;
      case NumberType::int32:
        real(std::numeric_limits<std::int32_t>::max());
        break;
      case NumberType::uint32:
        real(std::numeric_limits<std::uint32_t>::max());
        break;
      default:
        real(1);
    }
  }

  std::size_t indices() {
    const std::vector<std::uint32_t> indices = triangle_indices(mesh_, split_);
    const bool is_short = split_.original.size() < 65535;  // the greatest number is not allowed
    const std::size_t begin = bin_.size();
    for (const std::uint32_t index : indices) {
      bin_ += static_cast<char>(index & 0xffu);
      bin_ += static_cast<char>((index >> 8) & 0xffu);
      if (is_short) continue;
      bin_ += static_cast<char>((index >> 16) & 0xffu);
      bin_ += static_cast<char>(index >> 24);
    }
    return append_accessor(
        begin, {{"componentType", is_short ? 5123 : 5125}, {"count", indices.size()}, {"type", "SCALAR"}}, {kIndices});
  }

  const Mesh& mesh_;
  std::vector<WritableAttribute> held_;
  SplitVertices split_;
  std::vector<Vec3d> surface_normals_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
  std::string bin_;
};

}  // namespace

std::string generate(const Mesh& mesh, const WriteOptions& /*options*/) { return Generator(mesh).run(); }

}  // namespace knead::io_detail::glb
