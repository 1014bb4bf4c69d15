// Writing glTF: a new GLB file, or the bytes of one with some numbers replaced.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/text.h"
#include "knead/mesh.h"

namespace knead::detail::gltf {
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

// How an accessor's elements lie in the buffer.
struct Packing {
  std::size_t target = kVertexData;
  bool is_normalized = false;
  int stride = 0;  // bytes from one element to the next; 0: as many as an element has
};

class Generator {
 public:
  explicit Generator(const Mesh& mesh)
      : mesh_(mesh), held_(writable_attributes(mesh).attributes), split_(split_vertices(mesh, held_)) {
    if (!are_splats(mesh)) return;
    splats_ = local_splats({}, mesh, split_.original);
    std::set<std::string> written;
    for (const SplatNumbers& numbers : splats_) written.insert(numbers.names.begin(), numbers.names.end());
    std::erase_if(held_, [&](const WritableAttribute& held) {  // also normals for which a file only has room
      const std::vector<double>& values = held.attribute.values;
      const bool is_empty = std::all_of(values.begin(), values.end(), [](double x) { return x == 0; });
      return written.contains(held.attribute.name) || (held.key == "NORMAL" && is_empty);
    });
  }

  std::string run() {
    Json json{{"asset", Json{{"version", "2.0"}, {"generator", "Knead"}}},
              {"scene", 0},
              {"scenes", list_of(Json{{"nodes", list_of(0)}})}};
    if (!splats_.empty()) json.set("extensionsUsed", list_of(kSplatting));
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
    return with_header(std::move(chunks));
  }

 private:
  static Json list_of(Json item) { return std::vector<Json>{std::move(item)}; }

  Json primitive() {
    Json attributes{{"POSITION", positions()}};
    for (const WritableAttribute& held : held_) attributes.set(held.key, values(held));
    for (const SplatNumbers& numbers : splats_) attributes.set(numbers.key, values(numbers));
    Json primitive{{"attributes", attributes}};
    if (mesh_.face_count() > 0) primitive.set("indices", indices());
    primitive.set("mode", mesh_.face_count() > 0 ? kTriangles : kPoints);
    if (!splats_.empty()) {
      const Json kind{{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}};
      primitive.set("extensions", Json{{kSplatting, kind}});
    }
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
    for (const float value : floats) append_number(bin_, NumberType::float32, double{value});
    return append_accessor(begin,
                           {{"componentType", 5126},
                            {"count", split_.original.size()},
                            {"type", "VEC3"},
                            {"min", parse_json(least_text(floats, 3))},
                            {"max", parse_json(greatest_text(floats, 3))}},
                           {kVertexData});
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
                            {"type", vector_type(n)}},
                           {kVertexData, is_integer, is_integer && n == 3 ? (is_bytes ? 4 : 8) : 0});
  }

  std::size_t values(const SplatNumbers& numbers) {
    const std::size_t begin = bin_.size();
    for (const float value : numbers.values) append_number(bin_, NumberType::float32, double{value});
    const std::string type = vector_type(numbers.names.size());
    return append_accessor(begin, {{"componentType", 5126}, {"count", split_.original.size()}, {"type", type}}, {});
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

  // Integers are those of colors.
  void append_value(NumberType type, double value) {
    const NumberType stored = type == NumberType::float64 ? NumberType::float32 : type;
    const double most =
        visit_type(stored, [](auto number) { return double{std::numeric_limits<decltype(number)>::max()}; });
    append_number(bin_, stored, std::clamp(value, is_integer(stored) ? 0 : -most, most));
  }

  std::size_t indices() {
    const std::vector<std::uint32_t> indices = triangle_indices(mesh_, split_);
    const bool is_short = split_.original.size() < 65535;  // the greatest number is not allowed
    const std::size_t begin = bin_.size();
    for (const std::uint32_t index : indices) {
      append_number(bin_, is_short ? NumberType::uint16 : NumberType::uint32, index);
    }
    return append_accessor(begin,
                           {{"componentType", is_short ? 5123 : 5125}, {"count", indices.size()}, {"type", "SCALAR"}},
                           {kIndexData});
  }

  const Mesh& mesh_;
  std::vector<WritableAttribute> held_;
  SplitVertices split_;
  std::vector<SplatNumbers> splats_;
  std::vector<Vec3d> surface_normals_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
  std::string bin_;
};

// New values of one attribute of a block, local: those that differ from the file.
struct Change {
  std::string key;
  std::size_t accessor = 0;
  NewElements now;
};

bool same_values(const Change& a, const Change& b) {
  return a.accessor == b.accessor && a.now.elements == b.now.elements &&
         std::memcmp(a.now.values.data(), b.now.values.data(), a.now.values.size() * sizeof(float)) == 0;
}

using Changes = std::vector<Change>;  // of a block, by key

bool same_changes(const std::vector<Changes>& changes, std::span<const std::size_t> a, std::span<const std::size_t> b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!std::equal(changes[a[i]].begin(), changes[a[i]].end(), changes[b[i]].begin(), changes[b[i]].end(),
                    same_values)) {
      return false;
    }
  }
  return true;
}

std::vector<Vec3d> vectors_of(const Mesh& mesh, const char* name) {
  const Attribute* attribute = mesh.find_attribute(name);
  std::vector<Vec3d> vectors;
  if (attribute == nullptr) return vectors;
  const std::size_t n = static_cast<std::size_t>(attribute->components);
  for (std::size_t i = 0; i < attribute->values.size(); i += n) {
    vectors.push_back({attribute->values[i], attribute->values[i + 1], attribute->values[i + 2]});
  }
  return vectors;
}

// What differs, in local coordinates.
class Comparison {
 public:
  Comparison(const ShapeFile& source, const Document& document, std::span<const Vec3d> positions,
             std::span<const Vec3d> normals, const WriteOptions& options)
      : source_(source),
        document_(document),
        edits_(source.layout->edits),
        positions_(positions),
        normals_(normals),
        options_(options) {
    if (normals.empty()) return;
    old_normals_ = vectors_of(source.mesh, "normal");
    old_tangents_ = vectors_of(source.mesh, "tangent");
    if (!old_tangents_.empty()) tangents_ = transport_tangents(source.mesh, positions, old_tangents_, normals);
  }

  Changes of(const Block& block) const {
    const Mat3d& linear = block.placement.linear;
    const Mat3d transposed(linear.column(0), linear.column(1), linear.column(2));
    Changes changes;
    add(changes, compared({"POSITION", block.position}, source_.mesh.positions, positions_, block, edits_.vertices,
                          [&](const Vec3d& p) { return block.placement.inverse * (p - block.placement.offset); }));
    if (!normals_.empty() && block.normal) {
      add(changes, compared({"NORMAL", *block.normal}, old_normals_, normals_, block, {},
                            [&](const Vec3d& n) { return direction(transposed * n); }));
    }
    if (!tangents_.empty() && block.normal && block.tangent) {
      add(changes, compared({"TANGENT", *block.tangent}, old_tangents_, tangents_, block, {},
                            [&](const Vec3d& t) { return direction(block.placement.inverse * t); }));
    }
    if (!block.splats.empty()) add_splats(changes, block);
    return changes;
  }

 private:
  static void add(Changes& changes, Change change) {
    if (!change.now.elements.empty()) changes.push_back(std::move(change));
  }

  void add_splats(Changes& changes, const Block& block) const {
    const std::span<const std::uint32_t> all = options_.changed;
    const auto begin = std::lower_bound(all.begin(), all.end(), block.first);
    const auto end = std::lower_bound(begin, all.end(), block.first + block.count + edits_.copied.size());
    std::vector<std::uint32_t> splats;
    std::set_union(begin, end, edits_.vertices.begin(), edits_.vertices.end(), std::back_inserter(splats));
    if (splats.empty()) return;
    const std::vector<SplatNumbers> all_numbers = local_splats(block.placement, source_.mesh, splats, options_);
    for (std::uint32_t& splat : splats) splat -= static_cast<std::uint32_t>(block.first);
    for (const SplatNumbers& numbers : all_numbers) {
      const auto accessor = block.splats.find(numbers.key);
      if (accessor == block.splats.end()) continue;
      const std::size_t n = numbers.names.size();
      add(changes, changed(numbers.key, accessor->second, splats, [&](std::size_t k, std::span<float> to) {
            std::copy_n(numbers.values.data() + k * n, n, to.begin());
          }));
    }
  }

  // accessor: its key and number. edited: vertices that differ from the file even if nothing moved them.
  template <class ToLocal>
  Change compared(const std::pair<const char*, std::size_t>& accessor, std::span<const Vec3d> before,
                  std::span<const Vec3d> after, const Block& block, std::span<const std::uint32_t> edited,
                  ToLocal to_local) const {
    std::vector<std::uint32_t> elements;
    auto next = edited.begin();
    for (std::size_t i = 0; i < block.count + edits_.copied.size(); ++i) {
      const std::size_t vertex = block.first + i;
      const bool is_edited = next != edited.end() && *next == vertex;
      if (is_edited) ++next;
      if (is_edited || before[vertex] != after[vertex]) elements.push_back(static_cast<std::uint32_t>(i));
    }
    if (elements.empty()) return {};
    return changed(accessor.first, accessor.second, elements, [&](std::size_t k, std::span<float> to) {
      const std::size_t vertex = block.first + elements[k];
      const Vec3d local = to_local(after[vertex]);
      for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = as_float(local[axis], vertex);
    });
  }

  static float as_float(double coordinate, std::size_t vertex) {
    if (fits_float(coordinate)) return static_cast<float>(coordinate);
    throw InvalidInput(
        fmt::format("the new coordinates of vertex {} do not fit in floats, the only type that GLB has for them; write "
                    "another format",
                    vertex));
  }

  // Returns those of the elements whose numbers are others than in the file, and those after its last one.
  // put_numbers(k, to) puts the numbers of elements[k].
  template <class PutNumbers>
  Change changed(const std::string& key, std::size_t index, std::span<const std::uint32_t> elements,
                 const PutNumbers& put_numbers) const {
    const Accessor accessor = find_accessor(document_, index);
    const std::size_t n = accessor.components;
    Change change{key, index, {n, {}, {}}};
    std::array<float, 4> now{0, 0, 0, 1};
    const auto keep = [&](std::uint32_t element) {
      change.now.elements.push_back(element);
      change.now.values.insert(change.now.values.end(), now.begin(), now.begin() + n);
    };
    std::size_t k = 0;
    const auto compare = [&](std::size_t first, std::span<const double> numbers) {
      for (; k < elements.size() && elements[k] < first + numbers.size() / n; ++k) {
        std::array<float, 4> old{};
        for (std::size_t c = 0; c < n; ++c) old[c] = static_cast<float>(numbers[(elements[k] - first) * n + c]);
        now = old;
        put_numbers(k, now);
        if (!std::equal(now.begin(), now.begin() + n, old.begin())) keep(elements[k]);
      }
    };
    read_in_parts(document_, index, accessor, true, compare);
    for (; k < elements.size(); ++k) {
      put_numbers(k, now);
      keep(elements[k]);
    }
    return change;
  }

  const ShapeFile& source_;
  const Document& document_;
  const VertexEdits& edits_;
  std::span<const Vec3d> positions_;
  std::span<const Vec3d> normals_;
  const WriteOptions& options_;
  std::vector<Vec3d> old_normals_;
  std::vector<Vec3d> old_tangents_;
  std::vector<Vec3d> tangents_;
};

class Rewriter {
 public:
  Rewriter(const ShapeFile& source, const Document& document, std::vector<Changes> changes)
      : layout_(layout_of<Layout>(source)),
        copied_(source.layout->edits.copied),
        document_(document),
        changes_(std::move(changes)),
        uses_(find_uses(document)),
        readers_(document),
        edit_(document, layout_) {}

  void run(const ByteSink& out) {
    if (copied_.empty()) {
      const std::map<std::size_t, std::size_t> placed = count_placements(document_);
      for (const auto& [mesh, nodes] : blocks_by_node(layout_)) rewrite_mesh(nodes, placed.at(mesh) > nodes.size());
      for (const auto& [accessor, blocks] : claims_) rewrite_accessor(accessor, blocks);
    } else {
      lengthen();
    }
    edit_.finish(out);
  }

 private:
  using Claim = std::pair<std::size_t, const Change*>;  // a block's change of the accessor that it has in the file

  // The mesh in the file stays that of the nodes that did not move. If all did, the first one keeps it.
  void rewrite_mesh(const std::vector<std::vector<std::size_t>>& nodes, bool is_placed_elsewhere) {
    const auto is_unchanged = [&](const std::vector<std::size_t>& blocks) {
      return std::all_of(blocks.begin(), blocks.end(), [&](std::size_t b) { return changes_[b].empty(); });
    };
    const bool stays = is_placed_elsewhere || std::any_of(nodes.begin(), nodes.end(), is_unchanged);
    if (!stays) {
      for (const std::size_t b : nodes.front()) {
        for (const Change& change : changes_[b]) claims_[change.accessor].emplace_back(b, &change);
      }
    }
    for (const std::vector<std::size_t>& blocks : nodes) {
      if (stays ? !is_unchanged(blocks) : !same_changes(changes_, nodes.front(), blocks)) copy_mesh(blocks);
    }
  }

  void copy_mesh(const std::vector<std::size_t>& blocks) {
    const Block& first = layout_.blocks[blocks.front()];
    std::vector<Patch> patches;
    for (const std::size_t b : blocks) {
      for (const Change& change : changes_[b]) {
        const std::size_t accessor = edit_.append_accessor(all_values(change), change.now.components);
        const std::vector<Patch> own =
            edit_.attribute_patches(first.mesh, layout_.blocks[b].primitives, change.key, accessor);
        patches.insert(patches.end(), own.begin(), own.end());
      }
    }
    edit_.copy_mesh(first.node, first.mesh, std::move(patches));
  }

  void rewrite_accessor(std::size_t index, const std::vector<Claim>& claims) {
    const Accessor accessor = find_accessor(document_, index);
    if (all_agree(index, claims) && accessor.type == NumberType::float32 && accessor.dense && !accessor.sparse &&
        !readers_.others_read(index)) {
      const Change& change = *claims.front().second;
      edit_.overwrite(*accessor.dense, change.now);
      if (edit_.has_bounds(index)) edit_.set_bounds(index, all_values(change), change.now.components);
      return;
    }
    for (const auto& [b, change] : claims) {
      const std::size_t appended = edit_.append_accessor(all_values(*change), change->now.components);
      const Block& block = layout_.blocks[b];
      edit_.patch(edit_.attribute_patches(block.mesh, block.primitives, change->key, appended));
    }
  }

  // Whether everybody who uses the accessor wants the same new values.
  bool all_agree(std::size_t index, const std::vector<Claim>& claims) const {
    std::set<std::tuple<std::size_t, std::size_t, std::string>> known;
    for (const auto& [b, change] : claims) {
      if (!same_values(*change, *claims.front().second)) return false;
      for (const std::size_t p : layout_.blocks[b].primitives) known.insert({layout_.blocks[b].mesh, p, change->key});
    }
    const std::vector<AccessorUse>& uses = uses_.at(index);
    return std::all_of(uses.begin(), uses.end(), [&](const AccessorUse& use) {
      return known.count({use.mesh, use.primitive, use.key}) > 0;
    });
  }

  // Returns the numbers of the accessor, also of copies that are new.
  std::vector<float> all_values(const Change& change) const {
    const auto& [n, elements, values] = change.now;
    const Accessor accessor = find_accessor(document_, change.accessor);
    std::vector<float> all;
    all.reserve((accessor.count + copied_.size()) * n);
    read_in_parts(document_, change.accessor, accessor, true, [&](std::size_t, std::span<const double> numbers) {
      all.insert(all.end(), numbers.begin(), numbers.end());
    });
    for (const std::uint32_t from : copied_) {
      for (std::size_t c = 0; c < n; ++c) all.push_back(all[from * n + c]);
    }
    for (std::size_t k = 0; k < elements.size(); ++k)
      std::copy_n(values.data() + k * n, n, all.data() + elements[k] * n);
    return all;
  }

  // Gives the only primitive attributes with the copies.
  void lengthen() {
    const Block& block = layout_.blocks.front();
    const Value meshes = document_.root().item("meshes", block.mesh);
    const Value attributes = meshes.item("primitives", block.primitives.front()).at("attributes");
    edit_.reuse(unused_after(document_, {{block.mesh, block.primitives.front()}}));
    for (const JsonMember& member : attributes.json().members()) {
      const std::size_t index = attributes.at(member.key.c_str()).whole();
      if (find_accessor(document_, index).count != block.count) continue;
      const auto change = std::find_if(changes_.front().begin(), changes_.front().end(),
                                       [&](const Change& each) { return each.key == member.key; });
      const bool is_changed = change != changes_.front().end();
      const std::size_t longer = is_changed ? append_changed(*change) : append_longer(index);
      edit_.patch(edit_.attribute_patches(block.mesh, block.primitives, member.key, longer));
    }
  }

  // Appends an accessor of floats, which are read when they are written.
  std::size_t append_changed(const Change& change) {
    const std::size_t n = change.now.components;
    const std::size_t count = find_accessor(document_, change.accessor).count + copied_.size();
    const auto write = [this, &change](const ByteSink& out) {
      constexpr std::size_t most = std::size_t{1} << 20;
      std::string bytes;
      for (const float value : all_values(change)) {
        append_number(bytes, NumberType::float32, double{value});
        if (bytes.size() < most) continue;
        out(bytes);
        bytes.clear();
      }
      out(bytes);
    };
    const std::size_t view = edit_.append_view(LazyBytes{count * n * sizeof(float), write}, 0, kVertexData);
    std::string text = fmt::format(R"("bufferView":{},"componentType":5126,"count":{})", view, count);
    if (edit_.has_bounds(change.accessor)) {
      const std::vector<float> values = all_values(change);
      text += fmt::format(R"(,"min":{},"max":{})", least_text(values, n), greatest_text(values, n));
    }
    constexpr std::array<std::string_view, 4> kOfNumbers{"componentType", "normalized", "min", "max"};
    return edit_.append_accessor("{" + text + other_members(change.accessor, kOfNumbers) + "}");
  }

  // Appends an accessor with the copies, otherwise the same.
  std::size_t append_longer(std::size_t index) {
    const Accessor accessor = find_accessor(document_, index);
    const std::vector<double> numbers = read_accessor(document_, index, accessor, false);
    const std::size_t stride = (accessor.element_size() + 3) / 4 * 4;
    std::string elements;
    for (std::size_t i = 0; i < accessor.count + copied_.size(); ++i) {
      const std::size_t from = accessor.components * (i < accessor.count ? i : copied_[i - accessor.count]);
      for (std::size_t c = 0; c < accessor.components; ++c) append_number(elements, accessor.type, numbers[from + c]);
      elements.resize((i + 1) * stride, '\0');
    }
    const std::size_t view = edit_.append_view(elements, stride == accessor.element_size() ? 0 : stride, kVertexData);
    const std::string text = fmt::format(R"("bufferView":{},"count":{})", view, accessor.count + copied_.size());
    return edit_.append_accessor("{" + text + other_members(index, {}) + "}");
  }

  // Returns the text of the members of an accessor that do not say where its elements are, without some others.
  std::string other_members(std::size_t index, std::span<const std::string_view> without) const {
    constexpr std::array<std::string_view, 4> kPlace{"bufferView", "byteOffset", "count", "sparse"};
    const auto is_in = [](std::span<const std::string_view> keys, std::string_view key) {
      return std::find(keys.begin(), keys.end(), key) != keys.end();
    };
    std::string text;
    for (const Member& member : members(document_.text, edit_.item("accessors", index))) {
      if (is_in(kPlace, member.key) || is_in(without, member.key)) continue;
      const Span& span = member.value;
      text += fmt::format(",{}:{}", to_text(member.key), document_.text.substr(span.begin, span.end - span.begin));
    }
    return text;
  }

  const Layout& layout_;
  const std::vector<std::uint32_t>& copied_;
  const Document& document_;
  std::vector<Changes> changes_;
  std::map<std::size_t, std::vector<AccessorUse>> uses_;
  ByteReaders readers_;
  Edit edit_;
  std::map<std::size_t, std::vector<Claim>> claims_;  // by accessor
};

}  // namespace

// A new file: one node, one mesh, one primitive of triangles (of points, if there are no faces) with float coordinates.
// A vertex whose corners differ in an attribute becomes several at the end of the list. Other attributes per vertex
// become
// "_NAME".
std::string generate_glb(const Mesh& mesh, const WriteOptions& /*options*/) { return Generator(mesh).run(); }

// Numbers in the file are local floats: a vertex that did not move keeps its bits. Only its numbers, the tangents, the
// bounds of its accessors and what those need are replaced. Data that the file stores as integers, sparsely, or in
// bytes that something else reads too, is appended as new floats; a mesh that several nodes place gets copies where
// they moved differently.
void rewrite_glb(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                 const WriteOptions& options, const ByteSink& out) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_source(source);
  const Comparison comparison(source, document, positions, normals, options);
  std::vector<Changes> changes;
  bool is_changed = false;
  for (const Block& block : layout.blocks) {
    changes.push_back(comparison.of(block));
    is_changed = is_changed || !changes.back().empty();
  }
  if (is_changed) return Rewriter(source, document, std::move(changes)).run(out);
  SourceBytes bytes(source);
  document.bytes.empty() ? bytes.copy(0, bytes.size(), out) : out(document.bytes);
}

std::vector<std::string> losses(const Mesh& mesh) {
  WritableAttributes held = writable_attributes(mesh);
  std::vector<std::string> losses = std::move(held.losses);
  std::size_t cut = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) cut += mesh.face(f).size() > 3 ? 1 : 0;
  const bool has_seams = std::any_of(held.attributes.begin(), held.attributes.end(),
                                     [](const WritableAttribute& h) { return h.attribute.domain == Domain::corner; });
  if (has_seams) losses.push_back("GLB holds one value of an attribute at a vertex; vertices along seams are split");
  if (mesh.face_count() > 0 && have_splats(mesh)) losses.push_back("a new GLB file holds no splats beside faces");
  if (cut > 0) losses.push_back("GLB holds triangles only; faces with more than three corners are cut");
  if (!are_floats(mesh.positions)) losses.push_back("GLB holds floats only; coordinates are rounded to seven digits");
  return losses;
}

}  // namespace knead::detail::gltf
