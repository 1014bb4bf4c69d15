// Writing glTF back with other vertices and triangles in its primitives.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::gltf {
namespace {

constexpr std::uint32_t kNoVertex = 0xffffffffu;

// The values of an attribute at a vertex as the file holds them: in the node's coordinates, v downwards.
std::vector<double> to_local(const Semantic& semantic, const Placement& placement, std::vector<double> values) {
  const std::string_view key = semantic.key;
  const auto set_direction = [&](const Mat3d& map) {
    const Vec3d unit = direction(map * Vec3d{values[0], values[1], values[2]});
    for (std::size_t axis = 0; axis < 3; ++axis) values[axis] = unit[axis];
  };
  if (key == "NORMAL") {
    const Mat3d& linear = placement.linear;
    set_direction(Mat3d(linear.column(0), linear.column(1), linear.column(2)));
  } else if (key == "TANGENT") {
    set_direction(placement.inverse);
    values[3] = (values[3] < 0 ? -1 : 1) * (determinant(placement.linear) < 0 ? -1 : 1);
  } else if (key == "TEXCOORD_0") {
    values[1] = 1 - values[1];
  }
  return values;
}

// Numbers of one type, appended as bytes.
struct Elements {
  NumberType type;
  std::size_t components;
  std::string bytes = {};

  void append(double value) { append_number(bytes, type, nearest_of(type, value)); }

  // Each element of vertices begins at a multiple of four bytes.
  void end_element() { bytes.resize((bytes.size() + 3) / 4 * 4, '\0'); }

  std::string members(std::size_t count) const {
    const int component_type = type == NumberType::uint8 ? 5121 : (type == NumberType::uint16 ? 5123 : 5126);
    return fmt::format(R"("componentType":{},"count":{},"type":"VEC{}"{})", component_type, count, components,
                       type == NumberType::float32 ? "" : R"(,"normalized":true)");
  }
};

// The vertices of a new mesh as numbers of a GLB file's primitives.
class NewVertices {
 public:
  // The shape and the document must outlive it.
  NewVertices(const NewMesh& shape, const Document& document);

  // Whether a face has the same corners as a face of the source: positions and attributes.
  bool is_same_face(std::size_t source_face, std::size_t face) const;

  // For a block of points and lines, whose vertices are in no face: its vertices in the new mesh. Empty where none of
  // them changed, or where the mesh has not as many vertices in no face as the source.
  std::vector<std::uint32_t> moved_points(const Block& block) const;

  // Appends an accessor for each attribute that the block has, of these vertices in this order; by key. Numbers of
  // vertices that are where a corner of their faces' sources was are the source's bits where they did not change.
  // Throws InvalidInput where a float cannot hold a coordinate.
  std::map<std::string, std::size_t> append(const Block& block, const std::vector<std::uint32_t>& vertices,
                                            Edit& edit) const;

 private:
  bool is_same_vertex(std::uint32_t before, std::uint32_t after) const;
  void find_origins();
  void find_points();
  std::size_t append_positions(const Block& block, const std::vector<std::uint32_t>& vertices, Edit& edit) const;
  std::size_t append_attribute(const Block& block, const Semantic& semantic, const std::vector<std::uint32_t>& vertices,
                               Edit& edit) const;
  void append_splats(const Block& block, const std::vector<std::uint32_t>& vertices,
                     std::map<std::string, std::size_t>& accessors, Edit& edit) const;

  const NewMesh& shape_;
  const Document& document_;
  std::vector<std::uint32_t> origin_;  // of each new vertex: the source's that was where it is, or kNone
  std::vector<std::uint32_t> point_;   // of each vertex of the source in no face: the new mesh's, or kNone
};

NewVertices::NewVertices(const NewMesh& shape, const Document& document) : shape_(shape), document_(document) {
  find_origins();
  find_points();
}

void NewVertices::find_origins() {
  const Mesh& before = shape_.source.mesh;
  origin_.assign(shape_.mesh.vertex_count(), kNoVertex);
  for (std::size_t f = 0; f < shape_.mesh.face_count(); ++f) {
    for (const std::uint32_t v : shape_.mesh.face(f)) {
      for (const std::uint32_t old : before.face(shape_.face_source[f])) {
        if (before.positions[old] == shape_.mesh.positions[v]) origin_[v] = old;
      }
    }
  }
}

void NewVertices::find_points() {
  point_.assign(shape_.source.mesh.vertex_count(), kNoVertex);
  const std::vector<std::uint32_t> before = vertices_in_no_face(shape_.source.mesh);
  const std::vector<std::uint32_t> after = vertices_in_no_face(shape_.mesh);
  if (before.size() != after.size()) return;
  for (std::size_t i = 0; i < before.size(); ++i) {
    point_[before[i]] = after[i];
    if (shape_.source.mesh.positions[before[i]] == shape_.mesh.positions[after[i]]) origin_[after[i]] = before[i];
  }
}

bool NewVertices::is_same_vertex(std::uint32_t before, std::uint32_t after) const {
  if (!(shape_.source.mesh.positions[before] == shape_.mesh.positions[after])) return false;
  for (std::size_t a = 0; a < shape_.mesh.attributes.size(); ++a) {
    const std::size_t n = static_cast<std::size_t>(shape_.mesh.attributes[a].components);
    const double* old_values = shape_.source.mesh.attributes[a].values.data() + before * n;
    const double* new_values = shape_.mesh.attributes[a].values.data() + after * n;
    if (!std::equal(old_values, old_values + n, new_values)) return false;
  }
  return true;
}

bool NewVertices::is_same_face(std::size_t source_face, std::size_t face) const {
  const std::span<const std::uint32_t> before = shape_.source.mesh.face(source_face);
  const std::span<const std::uint32_t> after = shape_.mesh.face(face);
  return std::equal(before.begin(), before.end(), after.begin(), after.end(),
                    [&](std::uint32_t a, std::uint32_t b) { return is_same_vertex(a, b); });
}

std::vector<std::uint32_t> NewVertices::moved_points(const Block& block) const {
  std::vector<std::uint32_t> vertices;
  bool moved = false;
  for (std::size_t i = block.first; i < block.first + block.count; ++i) {
    if (point_[i] == kNoVertex) return {};
    vertices.push_back(point_[i]);
    moved = moved || !is_same_vertex(static_cast<std::uint32_t>(i), point_[i]);
  }
  return moved ? vertices : std::vector<std::uint32_t>{};
}

std::map<std::string, std::size_t> NewVertices::append(const Block& block, const std::vector<std::uint32_t>& vertices,
                                                       Edit& edit) const {
  std::map<std::string, std::size_t> accessors{{"POSITION", append_positions(block, vertices, edit)}};
  for (const Semantic& semantic : kSemantics) {
    if (block.*semantic.accessor) accessors[semantic.key] = append_attribute(block, semantic, vertices, edit);
  }
  if (!block.splats.empty()) append_splats(block, vertices, accessors, edit);
  return accessors;
}

void NewVertices::append_splats(const Block& block, const std::vector<std::uint32_t>& vertices,
                                std::map<std::string, std::size_t>& accessors, Edit& edit) const {
  for (SplatNumbers& numbers : local_splats(block.placement, shape_.mesh, vertices)) {
    const auto accessor = block.splats.find(numbers.key);
    if (accessor == block.splats.end()) continue;
    const std::size_t n = numbers.names.size();
    const std::vector<double> old =
        read_accessor(document_, accessor->second, find_accessor(document_, accessor->second), true);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const std::uint32_t origin = origin_[vertices[k]];
      if (origin == kNoVertex || !is_same_vertex(origin, vertices[k])) continue;
      for (std::size_t c = 0; c < n; ++c) {
        numbers.values[k * n + c] = static_cast<float>(old[(origin - block.first) * n + c]);
      }
    }
    accessors[numbers.key] = edit.append_accessor(numbers.values, n);
  }
}

std::size_t NewVertices::append_positions(const Block& block, const std::vector<std::uint32_t>& vertices,
                                          Edit& edit) const {
  const std::vector<double> old =
      read_accessor(document_, block.position, find_accessor(document_, block.position), true);
  std::vector<float> floats;
  floats.reserve(3 * vertices.size());
  for (const std::uint32_t v : vertices) {
    const std::size_t origin = std::size_t{origin_[v]} - block.first;
    const bool is_old = origin_[v] != kNoVertex && origin < block.count;
    const Vec3d local = is_old ? Vec3d{old[3 * origin], old[3 * origin + 1], old[3 * origin + 2]}
                               : block.placement.inverse * (shape_.mesh.positions[v] - block.placement.offset);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!fits_float(local[axis])) {
        throw InvalidInput(
            fmt::format("the coordinates of vertex {} do not fit in floats, the only type that GLB has for them; "
                        "write another format",
                        v));
      }
      floats.push_back(static_cast<float>(local[axis]));
    }
  }
  return edit.append_accessor(floats, 3);
}

std::size_t NewVertices::append_attribute(const Block& block, const Semantic& semantic,
                                          const std::vector<std::uint32_t>& vertices, Edit& edit) const {
  const Attribute& before = *shape_.source.mesh.find_attribute(semantic.name);
  const Attribute& after = *shape_.mesh.find_attribute(semantic.name);
  const std::size_t index = *(block.*semantic.accessor);
  const Accessor accessor = find_accessor(document_, index);
  const std::vector<double> old = read_accessor(document_, index, accessor, after.type == NumberType::float32);
  const std::size_t n = static_cast<std::size_t>(after.components);
  Elements elements{after.type, accessor.components};
  for (const std::uint32_t v : vertices) {
    const std::size_t origin = std::size_t{origin_[v]} - block.first;
    const double* values = after.values.data() + v * n;
    const bool is_old = origin_[v] != kNoVertex && origin < block.count &&
                        std::equal(values, values + n, before.values.data() + std::size_t{origin_[v]} * n);
    const std::vector<double> local =
        is_old ? std::vector<double>(old.data() + origin * accessor.components,
                                     old.data() + (origin + 1) * accessor.components)
               : to_local(semantic, block.placement, std::vector<double>(values, values + accessor.components));
    for (const double value : local) elements.append(value);
    elements.end_element();
  }
  const std::size_t stride = elements.bytes.size() / vertices.size();
  const bool is_padded = stride != accessor.components * size_of(after.type);
  return edit.append_elements(elements.bytes, is_padded ? stride : 0, kVertexData, elements.members(vertices.size()));
}

// The number of a block's face list among all of the layout, by primitive.
using RunOfPrimitive = std::map<std::size_t, std::size_t>;

class Remesher {
 public:
  Remesher(const NewMesh& shape, const Document& document)
      : shape_(shape),
        layout_(layout_of<Layout>(shape.source)),
        document_(document),
        vertices_(shape, document),
        edit_(document, layout_) {}

  std::string run() {
    runs_.resize(layout_.blocks.size());
    for (std::size_t r = 0; r < layout_.faces.size(); ++r) {
      runs_[layout_.faces[r].block][layout_.faces[r].primitive] = r;
    }
    sort_triangles();
    for (std::size_t b = 0; b < layout_.blocks.size(); ++b) changes_.push_back(change_of(b));
    find_instances();
    edit_.reuse(unused_after(document_, replaced_primitives()));
    for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
      if (!changes_[b] || changes_[b]->vertices.empty()) continue;
      changes_[b]->accessors = vertices_.append(layout_.blocks[b], changes_[b]->vertices, edit_);
    }
    for (const auto& [mesh, instances] : meshes_) write_mesh(mesh, instances);
    return edit_.finish();
  }

 private:
  // The nodes of the scene that place a mesh.
  struct Instances {
    std::vector<std::vector<std::size_t>> nodes;  // the blocks of each
    bool is_free = false;                         // nothing that is not changed uses the mesh
  };

  // What the vertices of a block become; nothing where they stay as they are.
  struct Change {
    std::vector<std::uint32_t> vertices;           // of the new mesh
    std::map<std::string, std::size_t> accessors;  // by key
    bool has_faces = true;
  };

  // The new triangles by the primitive that they lie in.
  void sort_triangles() {
    run_triangles_.resize(layout_.faces.size());
    const std::vector<Triangle> triangles = triangulate(shape_.mesh);
    const std::vector<std::uint32_t> faces = triangle_faces(shape_.mesh);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      run_triangles_[run_of(shape_.face_source[faces[t]])].push_back(triangles[t]);
    }
    run_faces_.resize(layout_.faces.size());
    for (std::uint32_t f = 0; f < shape_.mesh.face_count(); ++f) run_faces_[run_of(shape_.face_source[f])].push_back(f);
  }

  std::size_t run_of(std::size_t source_face) const {
    const auto after = std::upper_bound(layout_.faces.begin(), layout_.faces.end(), source_face,
                                        [](std::size_t f, const Faces& faces) { return f < faces.first; });
    return static_cast<std::size_t>(after - layout_.faces.begin()) - 1;
  }

  std::size_t end_of(std::size_t run) const {
    return run + 1 < layout_.faces.size() ? layout_.faces[run + 1].first : shape_.source.mesh.face_count();
  }

  // Whether the faces of a primitive are the source's, with the same corners.
  bool is_unchanged(std::size_t run) const {
    const std::vector<std::uint32_t>& faces = run_faces_[run];
    const std::size_t first = layout_.faces[run].first;
    if (faces.size() != end_of(run) - first) return false;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (shape_.face_source[faces[i]] != first + i || !vertices_.is_same_face(first + i, faces[i])) return false;
    }
    return true;
  }

  std::optional<Change> change_of(std::size_t b) const {
    Change change;
    change.has_faces = !runs_[b].empty();
    if (!change.has_faces) {
      change.vertices = vertices_.moved_points(layout_.blocks[b]);
      return change.vertices.empty() ? std::nullopt : std::optional(std::move(change));
    }
    if (std::all_of(runs_[b].begin(), runs_[b].end(), [&](const auto& run) { return is_unchanged(run.second); })) {
      return std::nullopt;
    }
    change.vertices = vertices_of(b);
    return change;
  }

  // Those that the triangles of the block's primitives use, by number.
  std::vector<std::uint32_t> vertices_of(std::size_t b) const {
    std::vector<std::uint32_t> vertices;
    for (const auto& [primitive, run] : runs_[b]) {
      for (const Triangle& triangle : run_triangles_[run]) {
        vertices.insert(vertices.end(), triangle.begin(), triangle.end());
      }
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
  }

  bool is_unchanged_node(const std::vector<std::size_t>& blocks) const {
    return std::none_of(blocks.begin(), blocks.end(), [&](std::size_t b) { return changes_[b].has_value(); });
  }

  void find_instances() {
    for (auto& [mesh, nodes] : blocks_by_node(layout_)) meshes_[mesh].nodes = nodes;
    const std::map<std::size_t, std::size_t> placed = count_placements(document_);
    for (auto& [mesh, instances] : meshes_) {
      const auto& nodes = instances.nodes;
      instances.is_free = placed.at(mesh) == nodes.size() &&
                          std::none_of(nodes.begin(), nodes.end(), [&](const auto& n) { return is_unchanged_node(n); });
    }
  }

  // Those whose old attributes and indices no mesh will have: of the mesh and primitive.
  std::set<std::pair<std::size_t, std::size_t>> replaced_primitives() const {
    std::set<std::pair<std::size_t, std::size_t>> replaced;
    std::set<std::pair<std::size_t, std::size_t>> kept;
    for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
      const Block& block = layout_.blocks[b];
      const bool is_replaced = changes_[b] && changes_[b]->has_faces && meshes_.at(block.mesh).is_free;
      for (const std::size_t p : block.primitives) (is_replaced ? replaced : kept).insert({block.mesh, p});
    }
    for (const auto& primitive : kept) replaced.erase(primitive);
    return replaced;
  }

  // The mesh in the file stays that of the nodes for which nothing changed. If all did, the first one keeps it.
  void write_mesh(std::size_t mesh, const Instances& instances) {
    bool is_free = instances.is_free;
    const Span span = edit_.item("meshes", mesh);
    for (const std::vector<std::size_t>& blocks : instances.nodes) {
      if (is_unchanged_node(blocks)) continue;
      const Span list = *member(document_.text, span, "primitives");
      const Patch primitives{list, primitives_text(list, blocks, mesh)};
      if (is_free) {
        edit_.patch({primitives});
      } else {
        edit_.copy_mesh(layout_.blocks[blocks.front()].node, mesh, {primitives});
      }
      is_free = false;
    }
  }

  std::string primitives_text(const Span& list, const std::vector<std::size_t>& blocks, std::size_t mesh) {
    std::map<std::size_t, std::size_t> block_of;
    for (const std::size_t b : blocks) {
      for (const std::size_t p : layout_.blocks[b].primitives) block_of[p] = b;
    }
    std::string text;
    const std::vector<Member> items = members(document_.text, list);
    for (std::size_t p = 0; p < items.size(); ++p) {
      const std::string primitive = primitive_text(items[p].value, p, block_of.at(p));
      if (!primitive.empty()) text += (text.empty() ? "" : ",") + primitive;
    }
    if (text.empty()) {
      throw InvalidInput(fmt::format("mesh {} of the file would become empty; write another format", mesh));
    }
    return "[" + text + "]";
  }

  // Empty: nothing is left of it.
  std::string primitive_text(const Span& span, std::size_t primitive, std::size_t b) {
    std::string text(document_.text.substr(span.begin, span.end - span.begin));
    if (!changes_[b]) return text;
    const Change& change = *changes_[b];
    const auto run = runs_[b].find(primitive);
    const bool is_empty = run == runs_[b].end() || run_triangles_[run->second].empty();
    if (change.has_faces && is_empty) return "";
    std::vector<Patch> patches;
    const Span whole = root_span(text);
    const Span attributes = *member(text, whole, "attributes");
    patches.push_back({attributes, attributes_text(text, attributes, change)});
    if (change.has_faces) {
      put_member(text, whole, "indices", append_indices(run->second, change.vertices), patches);
      if (member(text, whole, "mode")) put_member(text, whole, "mode", kTriangles, patches);
    }
    return patched(text, std::move(patches));
  }

  // The old attributes with new numbers. Those that have none go, but where the vertices are the same ones.
  static std::string attributes_text(std::string_view text, const Span& attributes, const Change& change) {
    std::string result;
    for (const Member& attribute : members(text, attributes)) {
      const auto accessor = change.accessors.find(attribute.key);
      const bool is_new = accessor != change.accessors.end();
      if (!is_new && change.has_faces) continue;
      if (!result.empty()) result += ',';
      result += to_text(attribute.key);
      result += ':';
      const Span& old = attribute.value;
      result += is_new ? std::to_string(accessor->second) : std::string(text.substr(old.begin, old.end - old.begin));
    }
    return "{" + result + "}";
  }

  static void put_member(std::string_view text, const Span& object, const char* key, std::size_t value,
                         std::vector<Patch>& patches) {
    if (const std::optional<Span> old = member(text, object, key)) {
      patches.push_back({*old, std::to_string(value)});
    } else {
      patches.push_back({{object.begin + 1, object.begin + 1}, fmt::format(R"("{}":{},)", key, value)});
    }
  }

  // A node that mirrors its mesh has its triangles the other way round.
  std::size_t append_indices(std::size_t run, const std::vector<std::uint32_t>& vertices) {
    const bool is_mirrored = determinant(layout_.blocks[layout_.faces[run].block].placement.linear) < 0;
    const bool is_short = vertices.size() < 65535;  // the greatest number is not allowed
    std::string bytes;
    for (Triangle triangle : run_triangles_[run]) {
      if (is_mirrored) std::swap(triangle[1], triangle[2]);
      for (const std::uint32_t v : triangle) {
        const auto place = std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin();
        append_number(bytes, is_short ? NumberType::uint16 : NumberType::uint32, static_cast<double>(place));
      }
    }
    return edit_.append_elements(bytes, 0, kIndexData,
                                 fmt::format(R"("componentType":{},"count":{},"type":"SCALAR")", is_short ? 5123 : 5125,
                                             3 * run_triangles_[run].size()));
  }

  const NewMesh& shape_;
  const Layout& layout_;
  const Document& document_;
  NewVertices vertices_;
  Edit edit_;
  std::vector<RunOfPrimitive> runs_;                  // of each block
  std::vector<std::vector<Triangle>> run_triangles_;  // of the new mesh
  std::vector<std::vector<std::uint32_t>> run_faces_;
  std::map<std::size_t, Instances> meshes_;
  std::vector<std::optional<Change>> changes_;  // of each block
};

// A skeleton's weights and the displacements of morph targets are numbers of vertices that a mesh does not hold.
void refuse_bound_vertices(const Layout& layout, const Document& document) {
  for (const Faces& faces : layout.faces) {
    const Block& block = layout.blocks[faces.block];
    const bool is_skinned = document.root().item("nodes", block.node).find("skin").has_value();
    const bool is_morphed =
        document.root().item("meshes", block.mesh).item("primitives", faces.primitive).count("targets") > 0;
    if (!is_skinned && !is_morphed) continue;
    throw InvalidInput(
        fmt::format("mesh {} of the GLB file has {}, which cannot be extended to new vertices; leave "
                    "the remeshing out, or write another format",
                    block.mesh, is_skinned ? "a skeleton" : "morph targets"));
  }
}

}  // namespace

std::string remeshed_glb(const NewMesh& shape) {
  const Layout& layout = layout_of<Layout>(shape.source);
  const Document document = open_source(shape.source);
  refuse_bound_vertices(layout, document);
  return Remesher(shape, document).run();
}

std::vector<std::uint32_t> face_labels(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::uint32_t> labels(source.mesh.face_count());
  for (std::size_t i = 0; i < layout.faces.size(); ++i) {
    const auto begin = labels.begin() + static_cast<std::ptrdiff_t>(layout.faces[i].first);
    std::fill(begin, labels.end(), static_cast<std::uint32_t>(i));
  }
  return labels;
}

std::vector<std::string> remesh_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_source(source);
  refuse_bound_vertices(layout, document);
  std::set<std::string> losses;
  std::vector<bool> has_faces(layout.blocks.size(), false);
  for (const Faces& faces : layout.faces) has_faces[faces.block] = true;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    for (const std::size_t p : layout.blocks[b].primitives) {
      const Value primitive = document.root().item("meshes", layout.blocks[b].mesh).item("primitives", p);
      for (const auto& [key, accessor] : primitive.at("attributes").json().members()) {
        if (!is_read(key)) losses.insert("attribute " + in_quotes(key) + " is left out where the shape changes");
      }
      const bool is_triangles = primitive.whole("mode").value_or(kTriangles) >= kTriangles;
      if (!is_triangles && has_faces[b]) {
        losses.insert("points and lines among the vertices of faces are left out where the shape changes");
      }
    }
  }
  return {losses.begin(), losses.end()};
}

}  // namespace knead::detail::gltf
