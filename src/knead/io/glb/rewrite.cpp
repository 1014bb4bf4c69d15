// Writing a GLB file back: its bytes with some numbers replaced.
#include <fmt/format.h>
#include <algorithm>

#include <array>
#include <cstring>
#include <set>

#include "knead/io/glb/attributes.h"
#include "knead/io/glb/edit.h"
#include "knead/io/glb/glb.h"
#include "knead/io/glb/uses.h"
#include "knead/io/layout.h"
#include "knead/io/text.h"
#include "knead/mesh/normals.h"

namespace knead::io_detail::glb {
namespace {

// New values of one attribute of a block.
struct Change {
  const char* key = nullptr;
  std::size_t accessor = 0;
  std::size_t components = 3;
  std::vector<float> values;          // of the whole accessor, local
  std::vector<std::size_t> elements;  // that differ from the file
};

bool same_values(const Change& a, const Change& b) {
  return a.accessor == b.accessor && a.values.size() == b.values.size() &&
         std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)) == 0;
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
             std::span<const Vec3d> normals)
      : source_(source), document_(document), positions_(positions), normals_(normals) {
    if (normals.empty()) return;
    old_normals_ = vectors_of(source.mesh, "normal");
    old_tangents_ = vectors_of(source.mesh, "tangent");
    if (!old_tangents_.empty()) tangents_ = transport_tangents(source.mesh, positions, old_tangents_, normals);
  }

  Changes of(const Block& block) const {
    const Mat3d& linear = block.placement.linear;
    const Mat3d transposed(linear.column(0), linear.column(1), linear.column(2));
    Changes changes;
    add(changes, compared("POSITION", block.position, source_.mesh.positions, positions_, block,
                          [&](const Vec3d& p) { return block.placement.inverse * (p - block.placement.offset); }));
    if (!normals_.empty() && block.normal) {
      add(changes, compared("NORMAL", *block.normal, old_normals_, normals_, block,
                            [&](const Vec3d& n) { return direction(transposed * n); }));
    }
    if (!tangents_.empty() && block.normal && block.tangent) {
      add(changes, compared("TANGENT", *block.tangent, old_tangents_, tangents_, block,
                            [&](const Vec3d& t) { return direction(block.placement.inverse * t); }));
    }
    return changes;
  }

 private:
  static void add(Changes& changes, Change change) {
    if (!change.elements.empty()) changes.push_back(std::move(change));
  }

  template <class ToLocal>
  Change compared(const char* key, std::size_t index, std::span<const Vec3d> before, std::span<const Vec3d> after,
                  const Block& block, ToLocal to_local) const {
    Change change;
    change.key = key;
    change.accessor = index;
    bool is_equal = true;
    for (std::size_t i = block.first; is_equal && i < block.first + block.count; ++i) is_equal = before[i] == after[i];
    if (is_equal) return change;
    const Accessor accessor = find_accessor(document_, index);
    change.components = accessor.components;
    for (const double value : read_accessor(document_, index, accessor, true)) {
      change.values.push_back(static_cast<float>(value));
    }
    for (std::size_t i = 0; i < block.count; ++i) {
      const std::size_t vertex = block.first + i;
      if (before[vertex] == after[vertex]) continue;
      if (set_element(&change.values[i * change.components], to_local(after[vertex]), vertex)) {
        change.elements.push_back(i);
      }
    }
    return change;
  }

  // Whether the floats became others.
  static bool set_element(float* to, const Vec3d& local, std::size_t vertex) {
    bool differs = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!fits_float(local[axis])) {
        throw InvalidInput(
            fmt::format("the new coordinates of vertex {} do not fit in floats, the only type that GLB has for them; "
                        "write another format",
                        vertex));
      }
      const float value = static_cast<float>(local[axis]);
      differs = differs || value != to[axis];
      to[axis] = value;
    }
    return differs;
  }

  const ShapeFile& source_;
  const Document& document_;
  std::span<const Vec3d> positions_;
  std::span<const Vec3d> normals_;
  std::vector<Vec3d> old_normals_;
  std::vector<Vec3d> old_tangents_;
  std::vector<Vec3d> tangents_;
};

class Rewriter {
 public:
  Rewriter(const ShapeFile& source, const Document& document, std::vector<Changes> changes)
      : layout_(layout_of<Layout>(source)),
        document_(document),
        changes_(std::move(changes)),
        uses_(find_uses(document)),
        readers_(document),
        edit_(document, layout_) {}

  std::string run() {
    const std::map<std::size_t, std::size_t> placed = count_placements(document_);
    for (const auto& [mesh, nodes] : blocks_by_node(layout_)) rewrite_mesh(nodes, placed.at(mesh) > nodes.size());
    for (const auto& [accessor, blocks] : claims_) rewrite_accessor(accessor, blocks);
    return edit_.finish();
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
        const std::size_t accessor = edit_.append_accessor(change.values, change.components);
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
      for (const std::size_t i : change.elements) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          edit_.overwrite(accessor.dense->begin + i * accessor.dense->stride + 4 * axis,
                          change.values[i * change.components + axis]);
        }
      }
      edit_.set_bounds(index, change.values, change.components);
      return;
    }
    for (const auto& [b, change] : claims) {
      const std::size_t appended = edit_.append_accessor(change->values, change->components);
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

  const Layout& layout_;
  const Document& document_;
  std::vector<Changes> changes_;
  std::map<std::size_t, std::vector<AccessorUse>> uses_;
  ByteReaders readers_;
  Edit edit_;
  std::map<std::size_t, std::vector<Claim>> claims_;  // by accessor
};

}  // namespace

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& /*options*/) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_document(source.bytes, layout, "source");
  const Comparison comparison(source, document, positions, normals);
  std::vector<Changes> changes;
  bool is_changed = false;
  for (const Block& block : layout.blocks) {
    changes.push_back(comparison.of(block));
    is_changed = is_changed || !changes.back().empty();
  }
  if (!is_changed) return source.bytes;
  return Rewriter(source, document, std::move(changes)).run();
}

}  // namespace knead::io_detail::glb
