#include "knead/io/glb/uses.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knead/math/error.h"

namespace knead::io_detail::glb {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

using Uses = std::map<std::size_t, std::vector<AccessorUse>>;

// Of the values of an object that are indices; parts of the file that the mesh does not need may be malformed.
template <class Visit>
void for_each_index(const std::optional<Value>& object, Visit visit) {
  if (!object || !object->json().is_object()) return;
  for (const auto& [key, value] : object->json().members()) {
    // As Value::whole takes them: -0 and 1.0 are whole, too.
    const double number = value.is_number() ? value.number() : -1;
    if (number >= 0 && number <= 0x1p53 && number == std::floor(number)) visit(static_cast<std::size_t>(number), key);
  }
}

template <class Visit>
void for_each_item(const std::optional<Value>& array, Visit visit) {
  if (!array || !array->json().is_array()) return;
  for (std::size_t i = 0; i < array->size(); ++i) visit(array->item(i), i);
}

std::optional<Value> find(const std::optional<Value>& object, const char* key) {
  return object ? object->find(key) : std::nullopt;
}

void add_meshes(const Value& root, Uses& uses) {
  for_each_item(root.find("meshes"), [&](const Value& mesh, std::size_t m) {
    for_each_item(mesh.find("primitives"), [&](const Value& primitive, std::size_t p) {
      for_each_index(primitive.find("attributes"), [&](std::size_t accessor, const std::string& key) {
        uses[accessor].push_back({m, p, key});
      });
      const auto other = [&](std::size_t accessor, const std::string&) { uses[accessor].push_back({m, p, {}}); };
      for_each_item(primitive.find("targets"),
                    [&](const Value& target, std::size_t) { for_each_index(target, other); });
      if (const std::optional<Value> indices = primitive.find("indices")) other(indices->whole(), {});
    });
  });
}

bool begins_with(const std::string& text, std::string_view beginning) {
  return std::string_view(text).substr(0, beginning.size()) == beginning;
}

}  // namespace

bool is_understood(const std::string& extension) {
  return extension == "KHR_mesh_quantization" || extension == "KHR_lights_punctual" ||
         extension == "EXT_mesh_gpu_instancing" || begins_with(extension, "KHR_materials_") ||
         begins_with(extension, "KHR_texture_") || begins_with(extension, "EXT_texture_");
}

Uses find_uses(const Document& document) {
  const Value root = document.root();
  Uses uses;
  add_meshes(root, uses);
  const auto other = [&](std::size_t accessor, const std::string&) { uses[accessor].emplace_back(); };
  for_each_item(root.find("skins"), [&](const Value& skin, std::size_t) { for_each_index(skin, other); });
  for_each_item(root.find("animations"), [&](const Value& animation, std::size_t) {
    for_each_item(animation.find("samplers"),
                  [&](const Value& sampler, std::size_t) { for_each_index(sampler, other); });
  });
  for_each_item(root.find("nodes"), [&](const Value& node, std::size_t) {
    const auto instancing = find(node.find("extensions"), "EXT_mesh_gpu_instancing");
    for_each_index(find(instancing, "attributes"), other);
  });
  return uses;
}

ByteReaders::ByteReaders(const Document& document) {
  add_accessors(document);
  add_images(document);
  std::sort(ranges_.begin(), ranges_.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
  std::size_t furthest = 0;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    furthest = std::max(furthest, ranges_[i].end);
    furthest_end_.push_back(furthest);
    if (ranges_[i].accessor != kNone) of_accessor_[ranges_[i].accessor] = i;
  }
}

void ByteReaders::add_accessors(const Document& document) {
  for (std::size_t i = 0; i < document.root().count("accessors"); ++i) {
    try {
      const Accessor accessor = find_accessor(document, i);
      const std::size_t size = accessor.element_size();
      if (accessor.dense)
        ranges_.push_back({i, accessor.dense->begin, accessor.dense->end, accessor.dense->stride, size});
      if (!accessor.sparse) continue;
      for (const DenseData& data : {accessor.sparse->indices, accessor.sparse->values}) {
        ranges_.push_back({kNone, data.begin, data.end, 1, 1});
      }
    } catch (const InvalidInput&) {
      continue;  // one that the mesh does not need, and that nobody can read
    }
  }
}

void ByteReaders::add_images(const Document& document) {
  const Value root = document.root();
  for_each_item(root.find("images"), [&](const Value& image, std::size_t) {
    for_each_index(image, [&](std::size_t v, const std::string& key) {
      if (key != "bufferView" || v >= root.count("bufferViews")) return;
      const Value view = root.item("bufferViews", v);
      const std::size_t begin = view.whole("byteOffset").value_or(0);
      ranges_.push_back({kNone, begin, begin + view.whole("byteLength").value_or(0), 1, 1});
    });
  });
}

// Elements of the same stride that never meet are interleaved; those of different strides are taken to meet.
bool ByteReaders::overlap(const Range& a, const Range& b) {
  if (a.end <= b.begin || b.end <= a.begin) return false;
  if (a.stride != b.stride) return true;
  const std::size_t phase = (b.begin + a.stride - a.begin % a.stride) % a.stride;
  return phase < a.size || phase + b.size > a.stride;
}

bool ByteReaders::others_read(std::size_t accessor) const {
  constexpr int kMostTests = 10000;
  const std::size_t own = of_accessor_.at(accessor);
  int tests = 0;
  for (std::size_t i = own + 1; i < ranges_.size() && ranges_[i].begin < ranges_[own].end; ++i) {
    if (++tests > kMostTests || overlap(ranges_[own], ranges_[i])) return true;
  }
  for (std::size_t i = own; i > 0 && furthest_end_[i - 1] > ranges_[own].begin; --i) {
    if (++tests > kMostTests || overlap(ranges_[own], ranges_[i - 1])) return true;
  }
  return false;
}

std::map<std::size_t, std::vector<std::vector<std::size_t>>> blocks_by_node(const Layout& layout) {
  std::map<std::size_t, std::vector<std::vector<std::size_t>>> result;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    auto& nodes = result[layout.blocks[b].mesh];
    if (nodes.empty() || layout.blocks[nodes.back().front()].node != layout.blocks[b].node) nodes.emplace_back();
    nodes.back().push_back(b);
  }
  return result;
}

std::map<std::size_t, std::size_t> count_placements(const Document& document) {
  std::map<std::size_t, std::size_t> count;
  const Value root = document.root();
  for (std::size_t n = 0; n < root.count("nodes"); ++n) {
    if (const std::optional<std::size_t> mesh = root.item("nodes", n).whole("mesh")) ++count[*mesh];
  }
  return count;
}

}  // namespace knead::io_detail::glb
