#include "knead/io/glb/edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "knead/io/cursor.h"
#include "knead/math/scalar.h"

namespace knead::io_detail::glb {
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

void pad(std::string& bytes, char with) { bytes.resize((bytes.size() + 3) / 4 * 4, with); }

}  // namespace

std::string least_text(const std::vector<float>& values, std::size_t components) {
  return bound_text(values, components, [](float a, float b) { return std::min(a, b); });
}

std::string greatest_text(const std::vector<float>& values, std::size_t components) {
  return bound_text(values, components, [](float a, float b) { return std::max(a, b); });
}

void append_uint32(std::string& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xffu);
}

void append_float(std::string& bytes, float value) { append_uint32(bytes, bit_cast<std::uint32_t>(value)); }

void append_chunk(std::string& bytes, std::uint32_t type, std::string_view contents) {
  append_uint32(bytes, static_cast<std::uint32_t>((contents.size() + 3) / 4 * 4));
  append_uint32(bytes, type);
  bytes += contents;
  pad(bytes, type == kJson ? ' ' : '\0');
}

std::string with_header(const std::string& chunks) {
  if (chunks.size() > std::numeric_limits<std::uint32_t>::max() - 16) {
    throw InvalidInput("the shape does not fit in a GLB file, which holds at most 4 GiB; use another format");
  }
  std::string bytes = "glTF";
  append_uint32(bytes, 2);
  append_uint32(bytes, static_cast<std::uint32_t>(12 + chunks.size()));
  return bytes + chunks;
}

Edit::Edit(const Document& document, const Layout& layout) : document_(document), layout_(layout), bin_(document.bin) {
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
                                           const char* key, std::size_t accessor) {
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

void Edit::overwrite(std::size_t position, float value) {
  std::string bytes;
  append_float(bytes, value);
  bin_.replace(position, bytes.size(), bytes);
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
  for (const float value : values) append_float(elements, value);
  return append_elements(
      elements, 0, kVertexData,
      fmt::format(R"("componentType":5126,"count":{},"type":"VEC{}","min":{},"max":{})", values.size() / components,
                  components, least_text(values, components), greatest_text(values, components)));
}

std::size_t Edit::append_elements(std::string_view elements, std::size_t stride, std::size_t target,
                                  const std::string& members) {
  return append_accessor(fmt::format(R"({{"bufferView":{},{}}})", append_view(elements, stride, target), members));
}

std::size_t Edit::append_view(std::string_view elements, std::size_t stride, std::size_t target) {
  pad(bin_, '\0');
  const std::size_t begin = bin_.size();
  bin_ += elements;
  const std::size_t view = next_number("bufferViews", unused_.views);
  views_.push_back({view, {begin, bin_.size()}, stride, target});
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
void Edit::cut_bytes() {
  if (views_.empty()) return;
  const std::vector<Member>& old = array("bufferViews").items;
  std::vector<bool> is_replaced(old.size(), false);
  for (const View& view : views_) {
    if (view.index < old.size()) is_replaced[view.index] = true;
  }
  const Cuts cuts(document_, is_replaced);
  if (cuts.empty()) return;
  const Value root = document_.root();
  for (std::size_t v = 0; v < old.size(); ++v) {
    const std::optional<Span> offset = member(document_.text, old[v].value, "byteOffset");
    const Value view = root.item("bufferViews", v);
    if (!offset || is_replaced[v] || view.whole("buffer").value_or(0) > 0) continue;
    const std::size_t begin = view.at("byteOffset").whole();
    if (cuts.moved(begin) != begin) patches_.push_back({*offset, std::to_string(cuts.moved(begin))});
  }
  for (View& view : views_) view.bytes = {cuts.moved(view.bytes.begin), cuts.moved(view.bytes.end)};
  bin_ = cuts.applied(bin_);
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

std::string Edit::finish() {
  cut_bytes();
  put_views();
  for (const Array& array : arrays_) {
    if (!array.appended.empty()) patches_.push_back(appended_item(document_.text, array.span, array.appended));
  }
  if (!views_.empty()) {  // also where there are as many bytes as before: the buffer may have been declared shorter
    patches_.push_back({*member(document_.text, item("buffers", 0), "byteLength"), std::to_string(bin_.size())});
  }
  std::string json = patched(document_.text, std::move(patches_));
  while (json.back() == ' ' || json.back() == '\0') json.pop_back();
  std::string chunks;
  for (std::size_t i = 0; i < layout_.chunks.size(); ++i) {
    const Chunk& chunk = layout_.chunks[i];
    const bool is_bin = layout_.bin == i;
    const std::string_view kept = document_.bytes.substr(chunk.begin, chunk.size);
    append_chunk(chunks, chunk.type, i == 0 ? json : (is_bin ? bin_ : kept));
  }
  return with_header(chunks) + std::string(document_.bytes.substr(layout_.end));
}

}  // namespace knead::io_detail::glb
