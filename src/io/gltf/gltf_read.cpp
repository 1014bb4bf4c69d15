// Reading glTF: the triangles of a GLB file's scene, and what it holds besides.
#include <fmt/format.h>

#include <map>
#include <numeric>
#include <set>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::gltf {
namespace {

class Reader {
 public:
  Reader(ShapeFile& shape, Layout layout, std::string_view glb, const std::string& name)
      : shape_(shape),
        layout_(std::move(layout)),
        document_(open_document(glb, layout_, name, shape.file.get())),
        faces_(shape.mesh) {}

  Layout run() {
    note_extensions();
    for (const Instance& instance : find_instances(document_, shape_.notes)) read_instance(instance);
    if (shape_.mesh.positions.empty()) {
      throw InvalidInput(Place{document_.source.file}, "there are no vertices in the scene; check what was exported");
    }
    shape_.mesh.attributes = read_attributes(document_, layout_.blocks, shape_.notes);
    read_splats(document_, layout_.blocks, shape_.mesh, shape_.notes);
    append_notes();
    return std::move(layout_);
  }

 private:
  Value root() const { return document_.root(); }

  void note_extensions() {
    for (std::size_t i = 0; i < root().count("extensionsRequired"); ++i) {
      const std::string extension = root().item("extensionsRequired", i).text();
      if (is_understood(extension)) continue;
      shape_.notes.push_back(
          fmt::format("the file requires the extension {}, which is kept but not understood", in_quotes(extension)));
    }
  }

  // Bounds what a small file unfolds into.
  void take(std::size_t elements) {
    const std::size_t most = most_elements(document_.size);
    if (elements > most || taken_ > most - elements) {
      throw InvalidInput(Place{document_.source.file},
                         fmt::format("its nodes unfold into more than {} vertices and corners, too many for a file of "
                                     "this size; place fewer copies",
                                     most));
    }
    taken_ += elements;
  }

  void read_instance(const Instance& instance) {
    const Value mesh = root().item("meshes", instance.mesh);
    std::multimap<std::size_t, std::size_t> blocks;  // of this instance by their POSITION
    for (std::size_t p = 0; p < mesh.at("primitives").size(); ++p) {
      constexpr std::size_t kBookkeeping = 64;  // what a primitive costs even if its vertices are there already
      take(kBookkeeping);
      const Value primitive = mesh.item("primitives", p);
      refuse_compression(primitive);
      if (primitive.count("targets") > 0) ++morphed_;
      Block wanted = described(instance, primitive);
      const std::size_t b = find_or_add(blocks, std::move(wanted));
      layout_.blocks[b].primitives.push_back(p);
      const std::size_t first = shape_.mesh.face_count();
      read_faces(primitive, layout_.blocks[b]);
      if (shape_.mesh.face_count() > first) layout_.faces.push_back({first, b, p});
    }
  }

  static void refuse_compression(const Value& primitive) {
    const std::optional<Value> extensions = primitive.find("extensions");
    if (!extensions || !extensions->find(kDraco)) return;
    primitive.fail(
        fmt::format("is compressed ({}), which this build cannot read; export it without compression", kDraco));
  }

  static Block described(const Instance& instance, const Value& primitive) {
    Block block;
    block.node = instance.node;
    block.mesh = instance.mesh;
    block.placement = instance.placement;
    const Value attributes = primitive.at("attributes");
    block.position = attributes.at("POSITION").whole();
    for (const Semantic& semantic : kSemantics) block.*semantic.accessor = attributes.whole(semantic.key);
    block.splats = splat_accessors(primitive);
    return block;
  }

  // Primitives share vertices if they share positions and no attribute of one contradicts the other's.
  std::size_t find_or_add(std::multimap<std::size_t, std::size_t>& blocks, Block wanted) {
    const auto [begin, end] = blocks.equal_range(wanted.position);
    for (auto known = begin; known != end; ++known) {
      take(1);
      Block& block = layout_.blocks[known->second];
      bool fits = block.splats == wanted.splats;
      for (const Semantic& semantic : kSemantics) {
        const auto& a = block.*semantic.accessor;
        const auto& b = wanted.*semantic.accessor;
        fits = fits && (!a || !b || *a == *b);
      }
      if (!fits) continue;
      for (const Semantic& semantic : kSemantics) {
        if (!(block.*semantic.accessor)) block.*semantic.accessor = wanted.*semantic.accessor;
      }
      return known->second;
    }
    blocks.emplace(wanted.position, layout_.blocks.size());
    add_vertices(wanted);
    layout_.blocks.push_back(std::move(wanted));
    return layout_.blocks.size() - 1;
  }

  void add_vertices(Block& block) {
    const Accessor accessor = find_accessor(document_, block.position);
    const Value value = root().item("accessors", block.position);
    if (accessor.components != 3) value.fail("is used as POSITION, but is not of type VEC3; repair the file");
    if (accessor.type == NumberType::uint32) {  // glTF 2.0 has it for indices only
      value.fail("is used as POSITION, but is of component type 5125 (UNSIGNED_INT); repair the file");
    }
    take(accessor.count);
    block.first = shape_.mesh.positions.size();
    block.count = accessor.count;
    const std::vector<double> local = read_accessor(document_, block.position, accessor, true);
    for (std::size_t i = 0; i < local.size(); i += 3) {
      const Vec3d world = block.placement.linear * Vec3d{local[i], local[i + 1], local[i + 2]} + block.placement.offset;
      if (!is_finite(world)) value.fail(fmt::format("position {} is not finite; repair the file", i / 3));
      shape_.mesh.positions.push_back(world);
    }
  }

  std::vector<std::uint32_t> read_indices(const Value& primitive, const Block& block) {
    std::vector<std::uint32_t> indices;
    const std::optional<std::size_t> index = primitive.whole("indices");
    if (!index) {
      take(block.count);
      indices.resize(block.count);
      std::iota(indices.begin(), indices.end(), static_cast<std::uint32_t>(block.first));
      return indices;
    }
    const Accessor accessor = find_accessor(document_, *index);
    const Value value = root().item("accessors", *index);
    const bool is_whole = accessor.type == NumberType::uint8 || accessor.type == NumberType::uint16 ||
                          accessor.type == NumberType::uint32;
    if (!is_whole || accessor.components != 1) value.fail("is no list of indices; repair the file");
    const double restart = accessor.type == NumberType::uint8    ? 0xff
                           : accessor.type == NumberType::uint16 ? 0xffff
                                                                 : 0xffffffff;
    take(accessor.count);
    for (const double number : read_accessor(document_, *index, accessor, false)) {
      if (number >= static_cast<double>(block.count) || number == restart) {
        value.fail(fmt::format("vertex index {} is out of range; there are {} vertices; repair the file", number,
                               block.count));
      }
      indices.push_back(static_cast<std::uint32_t>(block.first) + static_cast<std::uint32_t>(number));
    }
    return indices;
  }

  void read_faces(const Value& primitive, const Block& block) {
    const std::size_t mode = primitive.whole("mode").value_or(kTriangles);
    if (mode > kTriangleFan) primitive.fail(fmt::format("has the unknown mode {}; repair the file", mode));
    if (mode == kPoints) return;
    const std::vector<std::uint32_t> v = read_indices(primitive, block);
    if (mode < kTriangles) {
      ++lines_;
      return;
    }
    const bool is_mirrored = determinant(block.placement.linear) < 0;
    const std::size_t triangles = mode == kTriangles ? v.size() / 3 : (v.size() < 3 ? 0 : v.size() - 2);
    if (mode == kTriangles && v.size() % 3 != 0) ++incomplete_;
    take(2 * triangles);
    for (std::size_t i = 0; i < triangles; ++i) {
      std::vector<std::uint32_t> face;
      if (mode == kTriangles) face = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
      if (mode == kTriangleStrip) face = {v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]};
      if (mode == kTriangleFan) face = {v[i + 1], v[i + 2], v[0]};
      const bool is_stitch = mode == kTriangleStrip && (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]);
      if (is_mirrored) std::swap(face[1], face[2]);
      if (!is_stitch) faces_.add(face);
    }
  }

  void append_notes() {
    std::vector<std::string>& notes = shape_.notes;
    faces_.append_notes(notes);
    const auto say = [&](std::size_t count, const char* one, const char* many) {
      if (count > 0) notes.push_back(counted(count, one, many));
    };
    say(incomplete_, "primitive ends within a triangle, which is left out",
        "primitives end within a triangle, which is left out");
    say(lines_, "primitive is lines; its vertices move with the shape",
        "primitives are lines; their vertices move with the shape");
    say(morphed_, "primitive has morph targets, whose displacements stay as they are",
        "primitives have morph targets, whose displacements stay as they are");
    if (shape_.mesh.face_count() == 0) notes.push_back("a point cloud: there are no faces");
    if (layout_.end < document_.size) {
      notes.push_back(counted(document_.size - layout_.end, "byte follows", "bytes follow") +
                      " the end of the shape and is kept");
    }
  }

  ShapeFile& shape_;
  Layout layout_;
  Document document_;
  FaceBuilder faces_;
  std::size_t taken_ = 0;
  std::size_t lines_ = 0;
  std::size_t morphed_ = 0;
  std::size_t incomplete_ = 0;
};

struct Kind {
  const char* key;  // of an array at the top of the file
  const char* loss;
};

constexpr Kind kKinds[] = {{"materials", "materials are left out"},   {"textures", "textures are left out"},
                           {"animations", "animations are left out"}, {"skins", "skeletons are left out"},
                           {"cameras", "cameras are left out"},       {"extensionsUsed", "extensions are left out"}};

void add_primitive_losses(const Value& primitive, std::set<std::string>& losses) {
  if (primitive.count("targets") > 0) losses.insert("morph targets are left out");
  const std::size_t mode = primitive.whole("mode").value_or(kTriangles);
  if (mode != kPoints && mode < kTriangles) losses.insert("lines are left out");
  for (const auto& [key, accessor] : primitive.at("attributes").json().members()) {
    if (!is_read(key)) losses.insert("attribute " + in_quotes(key) + " is left out");
  }
}

}  // namespace

Layout read_scene(ShapeFile& shape, Layout layout, std::string_view glb, const std::string& name) {
  return Reader(shape, std::move(layout), glb, name).run();
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_source(source);
  const Value root = document.root();
  std::vector<std::string> losses;
  for (const Kind& kind : kKinds) {
    const bool is_kept =
        kind.key == std::string_view("extensionsUsed") && are_splats(source.mesh) && root.count(kind.key) == 1;
    if (root.find(kind.key) && !is_kept) losses.emplace_back(kind.loss);
  }
  if (root.count("nodes") > 1) losses.emplace_back("the tree of nodes is left out; every mesh is placed where it is");
  if (document.text.find("\"extras\"") != std::string_view::npos) losses.emplace_back("extras are left out");
  std::set<std::string> more;
  for (const Block& block : layout.blocks) {
    for (const std::size_t p : block.primitives) {
      add_primitive_losses(root.item("meshes", block.mesh).item("primitives", p), more);
    }
  }
  losses.insert(losses.end(), more.begin(), more.end());
  return losses;
}

}  // namespace knead::detail::gltf
