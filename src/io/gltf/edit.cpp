// Changing a GLB file: what its parts use, what becomes unused, and the new file.
#include "io/gltf/edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "io/text.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail::gltf {
namespace {

template <class Better>
std::string bound_text(const std::vector<float>& values, std::size_t components, Better better) {
  std::string text = "[";
  for (std::size_t c = 0; c < components; ++c) {
    std::optional<float> bound;
    for (std::size_t i = c; i < values.size(); i += components) {
      if (std::isfinite(values[i])) bound = better(bound.value_or(values[i]), values[i]);
    }
    if (c > 0) text += ",";
    append_real(text, double{bound.value_or(0.0f)});  // as a double: the same number, read as a double or as a float
  }
  return text + "]";
}

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

void pad(std::string& bytes, char with) { bytes.resize(padded(bytes.size()), with); }

// Returns what stands before the contents of a chunk of that size.
std::string chunk_head(std::uint32_t type, std::size_t size) {
  std::string bytes;
  append_number(bytes, NumberType::uint32, static_cast<double>(padded(size)));
  append_number(bytes, NumberType::uint32, type);
  return bytes;
}

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

// By view, how often a value and all that is in it name it.
std::map<std::size_t, std::size_t> count_views(const Json& value) {
  std::map<std::size_t, std::size_t> count;
  std::vector<const Json*> waiting{&value};
  while (!waiting.empty()) {
    const Json& next = *waiting.back();
    waiting.pop_back();
    if (next.is_object()) {
      const Json* view = next.find("bufferView");
      if (view != nullptr && view->is_whole()) ++count[view->whole()];
      for (const JsonMember& member : next.members()) waiting.push_back(&member.value);
    } else if (next.is_array()) {
      for (const Json& item : next.items()) waiting.push_back(&item);
    }
  }
  return count;
}

bool uses_known_extensions(const Value& root) {
  for (std::size_t i = 0; i < root.count("extensionsUsed"); ++i) {
    const Json& name = root.item("extensionsUsed", i).json();
    if (!name.is_text() || !is_understood(name.text())) return false;
  }
  return true;
}

// Where a view lies in the binary chunk; an empty span in another buffer. Nothing where that is not said properly.
std::optional<Span> range_of(const Document& document, const Json& view) {
  const auto whole = [&](const char* key, std::size_t otherwise) -> std::optional<std::size_t> {
    if (!view.is_object()) return std::nullopt;
    const Json* found = view.find(key);
    if (found == nullptr) return otherwise;
    if (!found->is_whole()) return std::nullopt;
    return found->whole();
  };
  const std::optional<std::size_t> buffer = whole("buffer", 0);
  const std::optional<std::size_t> begin = whole("byteOffset", 0);
  const std::optional<std::size_t> size = whole("byteLength", 0);
  if (!buffer || !begin || !size) return std::nullopt;
  if (*buffer > 0) return Span{};
  const std::size_t all = document.bin.size();
  if (*begin > all || *size > all - *begin) return std::nullopt;
  return Span{*begin, *begin + *size};
}

// In order, overlapping ones as one.
std::vector<Span> merged(std::vector<Span> spans) {
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.begin < b.begin; });
  std::vector<Span> result;
  for (const Span& span : spans) {
    if (span.begin == span.end) continue;
    if (result.empty() || result.back().end < span.begin) result.push_back(span);
    result.back().end = std::max(result.back().end, span.end);
  }
  return result;
}

}  // namespace

std::string least_text(const std::vector<float>& values, std::size_t components) {
  return bound_text(values, components, [](float a, float b) { return std::min(a, b); });
}

std::string greatest_text(const std::vector<float>& values, std::size_t components) {
  return bound_text(values, components, [](float a, float b) { return std::max(a, b); });
}

std::string vector_type(std::size_t components) {
  return components == 1 ? "SCALAR" : fmt::format("VEC{}", components);
}

void append_number(std::string& bytes, NumberType type, double value) {
  append_binary(bytes, type, value, std::endian::native != std::endian::little);
}

void append_chunk(std::string& bytes, std::uint32_t type, std::string_view contents) {
  bytes += chunk_head(type, contents.size());
  bytes += contents;
  pad(bytes, type == kJson ? ' ' : '\0');
}

std::string file_header(std::size_t chunks_size) {
  if (chunks_size > std::numeric_limits<std::uint32_t>::max() - 16) {
    throw InvalidInput("the shape does not fit in a GLB file, which holds at most 4 GiB; use another format");
  }
  std::string bytes = "glTF";
  append_number(bytes, NumberType::uint32, 2);
  append_number(bytes, NumberType::uint32, static_cast<double>(12 + chunks_size));
  return bytes;
}

std::string with_header(std::string chunks) { return std::move(chunks.insert(0, file_header(chunks.size()))); }

Edit::Edit(const Document& document, const Layout& layout)
    : document_(document), layout_(layout), bin_size_(document.bin.size()) {
  const std::vector<Member> top = members(document.text, root_span(document.text));
  for (const char* key : {"accessors", "bufferViews", "buffers", "meshes", "nodes"}) {
    const auto found = std::find_if(top.begin(), top.end(), [&](const Member& m) { return m.key == key; });
    if (found == top.end()) continue;
    std::vector<Member> items = members(document.text, found->value);
    const std::size_t count = items.size();
    arrays_.push_back({key, found->value, std::move(items), {}, count});
  }
}

Edit::Array& Edit::array(const char* key) {
  return *std::find_if(arrays_.begin(), arrays_.end(), [&](const Array& a) { return std::string_view(a.key) == key; });
}

const Edit::Array& Edit::array(const char* key) const {
  return *std::find_if(arrays_.begin(), arrays_.end(), [&](const Array& a) { return std::string_view(a.key) == key; });
}

Span Edit::item(const char* key, std::size_t i) const { return array(key).items[i].value; }

std::vector<Patch> Edit::attribute_patches(std::size_t mesh, const std::vector<std::size_t>& primitives,
                                           const std::string& key, std::size_t accessor) {
  std::vector<Patch> patches;
  std::vector<Member>& items = primitives_[mesh];
  if (items.empty()) items = members(document_.text, *member(document_.text, item("meshes", mesh), "primitives"));
  for (const std::size_t p : primitives) {
    const Span attributes = *member(document_.text, items[p].value, "attributes");
    const std::optional<Span> number = member(document_.text, attributes, key);
    if (number) patches.push_back({*number, std::to_string(accessor)});
  }
  return patches;
}

void Edit::overwrite(const DenseData& data, const NewElements& elements) { overwrites_.push_back({data, &elements}); }

bool Edit::has_bounds(std::size_t accessor) const {
  const Span object = item("accessors", accessor);
  return member(document_.text, object, "min") || member(document_.text, object, "max");
}

void Edit::set_bounds(std::size_t accessor, const std::vector<float>& values, std::size_t components) {
  const Span object = item("accessors", accessor);
  if (const std::optional<Span> least = member(document_.text, object, "min")) {
    patches_.push_back({*least, least_text(values, components)});
  }
  if (const std::optional<Span> greatest = member(document_.text, object, "max")) {
    patches_.push_back({*greatest, greatest_text(values, components)});
  }
}

std::size_t Edit::append_accessor(const std::vector<float>& values, std::size_t components) {
  std::string elements;
  for (const float value : values) append_number(elements, NumberType::float32, double{value});
  return append_elements(
      elements, 0, kVertexData,
      fmt::format(R"("componentType":5126,"count":{},"type":"{}","min":{},"max":{})", values.size() / components,
                  vector_type(components), least_text(values, components), greatest_text(values, components)));
}

std::size_t Edit::append_elements(std::string_view elements, std::size_t stride, std::size_t target,
                                  const std::string& members) {
  return append_accessor(fmt::format(R"({{"bufferView":{},{}}})", append_view(elements, stride, target), members));
}

std::size_t Edit::append_view(std::string_view elements, std::size_t stride, std::size_t target) {
  const auto write = [bytes = std::string(elements)](const ByteSink& out) { out(bytes); };
  return append_view({elements.size(), write}, stride, target);
}

std::size_t Edit::append_view(LazyBytes elements, std::size_t stride, std::size_t target) {
  const std::size_t begin = padded(bin_size_);
  bin_size_ = begin + elements.size;
  appended_.push_back(std::move(elements));
  const std::size_t view = next_number("bufferViews", unused_.views);
  views_.push_back({view, {begin, bin_size_}, stride, target});
  return view;
}

void Edit::append_animation(const std::string& text) {
  const Span root = root_span(document_.text);
  if (const std::optional<Span> animations = member(document_.text, root, "animations")) {
    patches_.push_back(appended_item(document_.text, *animations, text));
  } else {
    patches_.push_back({{root.end - 1, root.end - 1}, fmt::format(R"(,"animations":[{}])", text)});
  }
}

std::size_t Edit::append_accessor(const std::string& text) {
  const std::size_t accessor = next_number("accessors", unused_.accessors);
  put("accessors", accessor, text);
  return accessor;
}

std::size_t Edit::next_number(const char* key, std::vector<std::size_t>& unused) {
  if (unused.empty()) return array(key).count++;
  const std::size_t number = unused.front();
  unused.erase(unused.begin());
  return number;
}

void Edit::put(const char* key, std::size_t number, const std::string& item) {
  Array& target = array(key);
  if (number < target.items.size()) {
    patches_.push_back({target.items[number].value, item});
    return;
  }
  if (!target.appended.empty()) target.appended += ",";
  target.appended += item;
}

std::size_t Edit::append_mesh(const std::string& text) {
  put("meshes", array("meshes").count, text);
  return array("meshes").count++;
}

void Edit::copy_mesh(std::size_t node, std::size_t mesh, std::vector<Patch> patches) {
  const Span span = item("meshes", mesh);
  for (Patch& patch : patches) patch.span = {patch.span.begin - span.begin, patch.span.end - span.begin};
  const std::string_view text = document_.text.substr(span.begin, span.end - span.begin);
  const std::size_t own = append_mesh(patched(text, std::move(patches)));
  patches_.push_back({*member(document_.text, item("nodes", node), "mesh"), std::to_string(own)});
}

// Bytes that only views with new numbers held go, and what follows them moves forward.
Cuts Edit::cut_bytes() {
  if (views_.empty()) return {};
  const std::vector<Member>& old = array("bufferViews").items;
  std::vector<bool> is_replaced(old.size(), false);
  for (const View& view : views_) {
    if (view.index < old.size()) is_replaced[view.index] = true;
  }
  Cuts cuts(document_, is_replaced);
  if (cuts.empty()) return cuts;
  const Value root = document_.root();
  for (std::size_t v = 0; v < old.size(); ++v) {
    const std::optional<Span> offset = member(document_.text, old[v].value, "byteOffset");
    const Value view = root.item("bufferViews", v);
    if (!offset || is_replaced[v] || view.whole("buffer").value_or(0) > 0) continue;
    const std::size_t begin = view.at("byteOffset").whole();
    if (cuts.moved(begin) != begin) patches_.push_back({*offset, std::to_string(cuts.moved(begin))});
  }
  for (View& view : views_) view.bytes = {cuts.moved(view.bytes.begin), cuts.moved(view.bytes.end)};
  bin_size_ -= cuts.size();
  return cuts;
}

void Edit::put_views() {
  for (const View& view : views_) {
    const std::string stride = view.stride > 0 ? fmt::format(R"(,"byteStride":{})", view.stride) : "";
    const std::string target = view.target > 0 ? fmt::format(R"(,"target":{})", view.target) : "";
    put("bufferViews", view.index,
        fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{}{}{}}})", view.bytes.begin,
                    view.bytes.end - view.bytes.begin, stride, target));
  }
}

void Edit::put_over(const Overwrite& overwrite, std::size_t begin, std::string& piece) {
  const std::size_t components = overwrite.elements->components;
  const auto& elements = overwrite.elements->elements;
  const auto& values = overwrite.elements->values;
  const auto begin_of = [&](std::uint32_t i) { return overwrite.data.begin + i * overwrite.data.stride; };
  const auto first = std::partition_point(elements.begin(), elements.end(), [&](std::uint32_t i) {
    return begin_of(i) + components * sizeof(float) <= begin;
  });
  std::string bytes(components * sizeof(float), '\0');
  for (auto next = first; next != elements.end() && begin_of(*next) < begin + piece.size(); ++next) {
    const float* const from = values.data() + static_cast<std::size_t>(next - elements.begin()) * components;
    for (std::size_t c = 0; c < components; ++c) {
      put_float(bytes, c * sizeof(float), double{from[c]}, std::endian::little);
    }
    const std::size_t at = begin_of(*next);
    const std::size_t skipped = std::max(at, begin) - at;
    const std::size_t count = std::min(at + bytes.size(), begin + piece.size()) - at - skipped;
    std::copy_n(bytes.data() + skipped, count, piece.data() + (at + skipped - begin));
  }
}

void Edit::write_bin(const Cuts& cuts, const ByteSink& out) const {
  constexpr std::size_t most = std::size_t{1} << 20;
  std::size_t written = 0;
  const auto pass_on = [&](std::string_view bytes) {
    written += bytes.size();
    out(bytes);
  };
  const auto fill = [&] { pass_on(std::string_view("\0\0\0", padded(written) - written)); };
  std::string buffer;
  std::string piece;
  for (const Span& span : cuts.rest(document_.bin.size())) {
    for (std::size_t begin = span.begin; begin < span.end; begin += piece.size()) {
      piece = document_.bin.piece(begin, std::min(most, span.end - begin), buffer);
      for (const Overwrite& overwrite : overwrites_) put_over(overwrite, begin, piece);
      pass_on(piece);
    }
  }
  for (const LazyBytes& bytes : appended_) {
    fill();
    bytes.write(pass_on);
  }
  fill();
}

std::string Edit::finish() {
  std::string bytes;
  reserve_large(bytes, document_.size - document_.bin.size() + bin_size_);
  finish([&](std::string_view piece) { bytes += piece; });
  return bytes;
}

void Edit::finish(const ByteSink& out) {
  const Cuts cuts = cut_bytes();
  put_views();
  for (const Array& array : arrays_) {
    if (!array.appended.empty()) patches_.push_back(appended_item(document_.text, array.span, array.appended));
  }
  if (!views_.empty()) {  // also where there are as many bytes as before: the buffer may have been declared shorter
    patches_.push_back({*member(document_.text, item("buffers", 0), "byteLength"), std::to_string(bin_size_)});
  }
  std::string json = patched(document_.text, std::move(patches_));
  while (json.back() == ' ' || json.back() == '\0') json.pop_back();
  const auto is_bin = [&](std::size_t i) { return layout_.bin == i; };
  const auto size_of_chunk = [&](std::size_t i) {
    return i == 0 ? json.size() : is_bin(i) ? bin_size_ : layout_.chunks[i].size;
  };
  std::size_t size = 0;
  for (std::size_t i = 0; i < layout_.chunks.size(); ++i) size += chunk_head(0, 0).size() + padded(size_of_chunk(i));
  out(file_header(size));
  for (std::size_t i = 0; i < layout_.chunks.size(); ++i) {
    const Chunk& chunk = layout_.chunks[i];
    if (is_bin(i)) {
      out(chunk_head(chunk.type, bin_size_));
      write_bin(cuts, out);
      continue;
    }
    std::string bytes;
    append_chunk(bytes, chunk.type, i == 0 ? json : document_.bytes.substr(chunk.begin, chunk.size));
    out(bytes);
  }
  if (!document_.bytes.empty()) out(document_.bytes.substr(layout_.end));
}

bool is_understood(const std::string& extension) {
  return extension == "KHR_mesh_quantization" || extension == kSplatting || extension == "KHR_lights_punctual" ||
         extension == "EXT_mesh_gpu_instancing" || extension.starts_with("KHR_materials_") ||
         extension.starts_with("KHR_texture_") || extension.starts_with("EXT_texture_");
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
      continue;  // an invalid accessor that the mesh does not need
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
  constexpr int kMaxTests = 10000;
  const std::size_t own = of_accessor_.at(accessor);
  int tests = 0;
  for (std::size_t i = own + 1; i < ranges_.size() && ranges_[i].begin < ranges_[own].end; ++i) {
    if (++tests > kMaxTests || overlap(ranges_[own], ranges_[i])) return true;
  }
  for (std::size_t i = own; i > 0 && furthest_end_[i - 1] > ranges_[own].begin; --i) {
    if (++tests > kMaxTests || overlap(ranges_[own], ranges_[i - 1])) return true;
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

Unused unused_after(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives) {
  Unused unused;
  if (!uses_known_extensions(document.root())) return unused;
  std::map<std::size_t, std::size_t> named;  // views, by the accessors that are unused
  for (const auto& [accessor, uses] : find_uses(document)) {
    const bool is_unused = std::all_of(uses.begin(), uses.end(), [&](const AccessorUse& use) {
      return primitives.count({use.mesh, use.primitive}) > 0;
    });
    if (!is_unused || accessor >= document.root().count("accessors")) continue;
    unused.accessors.push_back(accessor);
    for (const auto& [view, count] : count_views(document.root().item("accessors", accessor).json())) {
      named[view] += count;
    }
  }
  const std::map<std::size_t, std::size_t> all = count_views(document.json);
  for (const auto& [view, count] : named) {
    if (all.at(view) == count && view < document.root().count("bufferViews")) unused.views.push_back(view);
  }
  return unused;
}

Cuts::Cuts(const Document& document, const std::vector<bool>& is_replaced) {
  const Value root = document.root();
  std::vector<Span> kept;
  std::vector<Span> left;
  for (std::size_t v = 0; v < is_replaced.size(); ++v) {
    const std::optional<Span> range = range_of(document, root.item("bufferViews", v).json());
    if (!range) return;
    (is_replaced[v] ? left : kept).push_back(*range);
  }
  kept = merged(std::move(kept));
  for (const Span& range : merged(std::move(left))) subtract(range, kept);
}

// Adds the range without what is kept.
void Cuts::subtract(Span range, const std::vector<Span>& kept) {
  auto next = std::upper_bound(kept.begin(), kept.end(), range.begin,
                               [](std::size_t begin, const Span& span) { return begin < span.end; });
  for (; next != kept.end() && next->begin < range.end; ++next) {
    if (range.begin < next->begin) add({range.begin, next->begin});
    range.begin = std::min(range.end, next->end);
  }
  add(range);
}

void Cuts::add(Span span) {
  span = {(span.begin + 3) / 4 * 4, span.end / 4 * 4};
  if (span.begin >= span.end) return;
  through_.push_back((through_.empty() ? 0 : through_.back()) + span.end - span.begin);
  spans_.push_back(span);
}

std::size_t Cuts::moved(std::size_t position) const {
  const auto next = std::upper_bound(spans_.begin(), spans_.end(), position,
                                     [](std::size_t p, const Span& span) { return p < span.end; });
  return next == spans_.begin() ? position : position - through_[static_cast<std::size_t>(next - spans_.begin()) - 1];
}

std::vector<Span> Cuts::rest(std::size_t size) const {
  std::vector<Span> result;
  std::size_t begin = 0;
  for (const Span& cut : spans_) {
    result.push_back({begin, cut.begin});
    begin = cut.end;
  }
  result.push_back({begin, size});
  return result;
}

}  // namespace knead::detail::gltf
