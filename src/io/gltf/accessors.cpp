// The accessors of a glTF file: where their numbers are, and the attributes of a mesh as they hold them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <set>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"
#include "io/text.h"

namespace knead::detail::gltf {
namespace {

struct ComponentType {
  std::size_t code;
  NumberType type;
  double most;  // what 1 is stored as where the accessor is normalized
};

constexpr std::array<ComponentType, 6> kComponentTypes = {{{5120, NumberType::int8, 127},
                                                           {5121, NumberType::uint8, 255},
                                                           {5122, NumberType::int16, 32767},
                                                           {5123, NumberType::uint16, 65535},
                                                           {5125, NumberType::uint32, 0},
                                                           {5126, NumberType::float32, 0}}};

constexpr std::size_t kElementsAtOnce = std::size_t{1} << 16;

// Elements of `size` bytes in the buffer view that `user` (an accessor, or part of a sparse one) names.
DenseData find_elements(const Document& document, const Value& user, std::size_t count, std::size_t size) {
  const Value view = document.root().item("bufferViews", user.at("bufferView").whole());
  if (const char* const extension = meshopt_extension(view.json())) {
    view.fail(
        fmt::format("is compressed ({}), which this build cannot read; export it without compression", extension));
  }
  const std::size_t buffer = view.at("buffer").whole();
  if (buffer != 0 || document.root().item("buffers", 0).find("uri")) {
    view.fail(fmt::format("lies in buffer {}, outside of the file's binary chunk; export it as one .glb file", buffer));
  }
  const std::size_t buffer_size = document.root().item("buffers", 0).at("byteLength").whole();
  if (buffer_size > document.bin.size()) {
    document.root()
        .item("buffers", 0)
        .fail(fmt::format("is {} bytes long, but the binary chunk has {}; the file is damaged", buffer_size,
                          document.bin.size()));
  }
  const std::size_t view_begin = view.whole("byteOffset").value_or(0);
  const std::size_t view_size = view.at("byteLength").whole();
  if (view_begin > buffer_size || view_size > buffer_size - view_begin) {
    view.fail(fmt::format("ends after its buffer of {} bytes; the file is damaged", buffer_size));
  }
  const std::size_t stride = view.whole("byteStride").value_or(size);
  const std::size_t offset = user.whole("byteOffset").value_or(0);
  const bool starts_within = offset <= view_size && size <= view_size - offset;
  if (stride < size) view.fail(fmt::format("has a stride of {}, below its elements' size; repair the file", stride));
  if (count > 0 && (!starts_within || (count - 1) > (view_size - offset - size) / stride)) {
    user.fail(
        fmt::format("{} elements end after their buffer view of {} bytes; the file is damaged", count, view_size));
  }
  const std::size_t begin = view_begin + offset;
  return {begin, stride, count == 0 ? begin : begin + (count - 1) * stride + size};
}

double read_number(const char* from, NumberType type) {
  return read_binary(from, type, std::endian::native != std::endian::little);
}

void read_element(const char* from, const Accessor& accessor, double* to) {
  const std::size_t size = size_of(accessor.type);
  for (std::size_t c = 0; c < accessor.components; ++c) to[c] = read_number(from + c * size, accessor.type);
}

SparseData find_sparse(const Document& document, const Value& sparse, const Accessor& accessor) {
  SparseData data;
  data.count = sparse.at("count").whole();
  const Value indices = sparse.at("indices");
  data.index_type = component_type(indices.at("componentType"));
  if (data.index_type != NumberType::uint8 && data.index_type != NumberType::uint16 &&
      data.index_type != NumberType::uint32) {
    indices.fail("must be unsigned integers; repair the file");
  }
  data.indices = find_elements(document, indices, data.count, size_of(data.index_type));
  data.values = find_elements(document, sparse.at("values"), data.count, accessor.element_size());
  return data;
}

void replace_sparse(const Document& document, const Value& value, const Accessor& accessor,
                    std::vector<double>& numbers) {
  const SparseData& sparse = *accessor.sparse;
  const auto bytes_of = [&](const DenseData& data, std::string& buffer) {
    return document.bin.piece(data.begin, data.end - data.begin, buffer).data();
  };
  std::string index_buffer;
  std::string value_buffer;
  const char* const indices = bytes_of(sparse.indices, index_buffer);
  const char* const values = bytes_of(sparse.values, value_buffer);
  double least = 0;
  for (std::size_t i = 0; i < sparse.count; ++i) {
    const double index = read_number(indices + i * sparse.indices.stride, sparse.index_type);
    if (index < least || index >= static_cast<double>(accessor.count)) {
      value.fail(fmt::format("sparse index {} is out of order or range; repair the file", index));
    }
    least = index + 1;
    read_element(values + i * sparse.values.stride, accessor,
                 numbers.data() + static_cast<std::size_t>(index) * accessor.components);
  }
}

// Divides normalised integers by their maximum.
void make_real(const Accessor& accessor, std::span<double> numbers) {
  const auto* const known = std::find_if(kComponentTypes.begin(), kComponentTypes.end(),
                                         [&](const ComponentType& each) { return each.type == accessor.type; });
  const double most = known->most;
  if (!accessor.normalized || most == 0) return;
  // Rounded, so that what is written as floats in their place is the same number.
  for (double& number : numbers) number = double{static_cast<float>(std::fmax(number / most, -1.0))};
}

struct AttributeData {
  std::size_t accessor = 0;
  Accessor found;
};

class AttributeReader {
 public:
  AttributeReader(const Document& document, const std::vector<Block>& blocks) : document_(document), blocks_(blocks) {}

  // Nothing if no block has it.
  std::optional<Attribute> read(const Semantic& semantic, std::vector<std::string>& notes) {
    const std::vector<std::optional<AttributeData>> sources = find_sources(semantic);
    Attribute attribute = described(semantic, sources);
    if (attribute.components == 0) return std::nullopt;
    std::size_t missing = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (!sources[b]) missing += blocks_[b].count;
      const std::vector<double> values =
          sources[b] ? values_of(*sources[b], attribute, blocks_[b])
                     : std::vector<double>(blocks_[b].count * static_cast<std::size_t>(attribute.components),
                                           attribute.name == "color" ? one(attribute.type) : 0.0);
      attribute.values.insert(attribute.values.end(), values.begin(), values.end());
    }
    for (double& value : attribute.values) {
      if (std::isfinite(value)) continue;
      value = 0;
      ++not_finite_;
    }
    if (missing > 0) {
      const char* as = attribute.name == "color" ? "white" : "0";
      notes.push_back(counted(missing, "vertex has", "vertices have") + " no " + attribute.name +
                      ", which is read as " + as);
    }
    return attribute;
  }

  void append_notes(std::vector<std::string>& notes) const {
    if (not_finite_ == 0) return;
    notes.push_back(counted(not_finite_, "number of an attribute is", "numbers of attributes are") +
                    " not finite and read as 0");
  }

 private:
  static double one(NumberType type) {
    return type == NumberType::float32 ? 1 : (type == NumberType::uint8 ? 255 : 65535);
  }

  std::vector<std::optional<AttributeData>> find_sources(const Semantic& semantic) const {
    std::vector<std::optional<AttributeData>> sources;
    for (const Block& block : blocks_) {
      const std::optional<std::size_t>& index = block.*semantic.accessor;
      sources.emplace_back();
      if (!index) continue;
      sources.back() = AttributeData{*index, find_accessor(document_, *index)};
      const Accessor& found = sources.back()->found;
      const std::string name = semantic.name;
      const bool fits = found.components == (name == "uv" ? 2u : 3u) || (name == "color" && found.components == 4);
      const bool is_tangent = name == "tangent" && found.components == 4;
      if (found.count != block.count || (name == "tangent" ? !is_tangent : !fits)) {
        document_.root()
            .item("accessors", *index)
            .fail(fmt::format("does not fit {} of {} vertices; repair the file", semantic.key, block.count));
      }
    }
    return sources;
  }

  // The attribute without its values; without components if there is none.
  static Attribute described(const Semantic& semantic, const std::vector<std::optional<AttributeData>>& sources) {
    Attribute attribute{semantic.name, Domain::vertex, NumberType::float32, 0, {}};
    std::optional<NumberType> type;
    for (const std::optional<AttributeData>& source : sources) {
      if (!source) continue;
      attribute.components = std::max(attribute.components, static_cast<int>(source->found.components));
      const bool kept = source->found.normalized &&
                        (source->found.type == NumberType::uint8 || source->found.type == NumberType::uint16);
      const NumberType held = kept ? source->found.type : NumberType::float32;
      type = type.value_or(held) == held ? held : NumberType::float32;
    }
    if (type && attribute.name == "color") attribute.type = *type;
    return attribute;
  }

  std::vector<double> values_of(const AttributeData& source, const Attribute& attribute, const Block& block) {
    const bool as_real = attribute.type == NumberType::float32;
    std::vector<double> values = read_accessor(document_, source.accessor, source.found, as_real);
    if (attribute.name == "normal") place_normals(values, block.placement);
    if (attribute.name == "tangent") place_tangents(values, block.placement);
    if (attribute.name == "uv") {
      for (std::size_t i = 1; i < values.size(); i += 2) values[i] = 1 - values[i];
    }
    if (attribute.name == "color" && source.found.components < static_cast<std::size_t>(attribute.components)) {
      std::vector<double> opaque;
      for (std::size_t i = 0; i < values.size(); ++i) {
        opaque.push_back(values[i]);
        if (i % 3 == 2) opaque.push_back(one(attribute.type));
      }
      return opaque;
    }
    return values;
  }

  void set_direction(double* to, const Vec3d& v) {
    if (!is_finite(v)) ++not_finite_;
    const Vec3d unit = direction(v);
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = unit[axis];
  }

  void place_normals(std::vector<double>& values, const Placement& placement) {
    const Mat3d& inverse = placement.inverse;
    const Mat3d transposed(inverse.column(0), inverse.column(1), inverse.column(2));
    for (std::size_t i = 0; i < values.size(); i += 3) {
      set_direction(&values[i], transposed * direction({values[i], values[i + 1], values[i + 2]}));
    }
  }

  // A mirror changes the hand.
  void place_tangents(std::vector<double>& values, const Placement& placement) {
    const double hand = determinant(placement.linear) < 0 ? -1 : 1;
    for (std::size_t i = 0; i < values.size(); i += 4) {
      set_direction(&values[i], placement.linear * direction({values[i], values[i + 1], values[i + 2]}));
      values[i + 3] *= hand;
    }
  }

  const Document& document_;
  const std::vector<Block>& blocks_;
  std::size_t not_finite_ = 0;
};

// "_NAME", the way that applications name their own attributes.
std::string custom_key(const std::string& name) {
  std::string key = upper(name);
  std::replace_if(
      key.begin(), key.end(), [](char c) { return !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9'); }, '_');
  return key.insert(0, 1, '_');
}

std::string key_of(const Attribute& attribute) {
  for (const Semantic& semantic : kSemantics) {
    if (attribute.name != semantic.name) continue;
    const int n = attribute.components;
    const bool fits = attribute.name == "normal" ? n == 3 : attribute.name == "uv" ? n == 2 : n == 4;
    if (fits || (attribute.name == "color" && n == 3)) return semantic.key;
  }
  return custom_key(attribute.name);
}

bool differs_at_corners(const std::vector<WritableAttribute>& held, std::size_t a, std::size_t b) {
  return std::any_of(held.begin(), held.end(), [&](const WritableAttribute& h) {
    if (h.attribute.domain != Domain::corner) return false;
    const std::size_t n = static_cast<std::size_t>(h.attribute.components);
    const double* values = h.attribute.values.data();
    return !std::equal(values + a * n, values + (a + 1) * n, values + b * n);
  });
}

// Whether corner a comes before b: by vertex, values, number.
bool comes_before(const Mesh& mesh, const std::vector<WritableAttribute>& held, std::size_t a, std::size_t b) {
  if (mesh.corner_vertex[a] != mesh.corner_vertex[b]) return mesh.corner_vertex[a] < mesh.corner_vertex[b];
  for (const WritableAttribute& h : held) {
    if (h.attribute.domain != Domain::corner) continue;
    const std::size_t n = static_cast<std::size_t>(h.attribute.components);
    const double* values = h.attribute.values.data();
    for (std::size_t i = 0; i < n; ++i) {
      if (values[a * n + i] != values[b * n + i]) return values[a * n + i] < values[b * n + i];
    }
  }
  return a < b;
}

}  // namespace

NumberType component_type(const Value& code) {
  const std::size_t number = code.whole();
  for (const ComponentType& known : kComponentTypes) {
    if (known.code == number) return known.type;
  }
  code.fail(fmt::format("{} is no component type of glTF; repair the file", number));
}

std::size_t component_count(const Value& type) {
  const std::string text = type.text();
  for (const auto& [name, count] :
       {std::pair{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}) {
    if (text == name) return static_cast<std::size_t>(count);
  }
  type.fail("must be SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4; repair the file");
}

std::size_t Accessor::element_size() const { return components * size_of(type); }

Accessor find_accessor(const Document& document, std::size_t index) {
  const Value value = document.root().item("accessors", index);
  Accessor accessor;
  accessor.count = value.at("count").whole();
  accessor.type = component_type(value.at("componentType"));
  accessor.normalized = value.flag("normalized");
  accessor.components = component_count(value.at("type"));
  if (value.find("bufferView")) {
    accessor.dense = find_elements(document, value, accessor.count, accessor.element_size());
  } else if (!value.find("sparse")) {
    value.fail("holds no data; an extension that is not supported may hold it; export it without");
  } else if (accessor.count > most_elements(document.size)) {
    value.fail(fmt::format("{} elements are more than the file can hold; the file is damaged", accessor.count));
  }
  if (const std::optional<Value> sparse = value.find("sparse")) {
    accessor.sparse = find_sparse(document, *sparse, accessor);
  }
  return accessor;
}

void read_in_parts(const Document& document, std::size_t index, const Accessor& accessor, bool as_real,
                   const TakeNumbers& take) {
  const std::size_t most = accessor.sparse ? accessor.count : kElementsAtOnce;
  std::string buffer;
  std::vector<double> numbers;
  for (std::size_t first = 0; first < accessor.count; first += most) {
    const std::size_t count = std::min(most, accessor.count - first);
    numbers.assign(count * accessor.components, 0.0);
    if (accessor.dense) {
      const auto& [begin, stride, end] = *accessor.dense;
      const std::size_t size = (count - 1) * stride + accessor.element_size();
      const char* const from = document.bin.piece(begin + first * stride, size, buffer).data();
      for (std::size_t i = 0; i < count; ++i) {
        read_element(from + i * stride, accessor, numbers.data() + i * accessor.components);
      }
    }
    if (accessor.sparse) replace_sparse(document, document.root().item("accessors", index), accessor, numbers);
    if (as_real) make_real(accessor, numbers);
    take(first, numbers);
  }
}

std::vector<double> read_accessor(const Document& document, std::size_t index, const Accessor& accessor, bool as_real) {
  std::vector<double> all;
  all.reserve(accessor.count * accessor.components);
  read_in_parts(document, index, accessor, as_real, [&](std::size_t, std::span<const double> numbers) {
    all.insert(all.end(), numbers.begin(), numbers.end());
  });
  return all;
}

bool is_read(const std::string& key) {
  return key == "POSITION" || key.starts_with(kSplatting) ||
         std::any_of(kSemantics.begin(), kSemantics.end(), [&](const Semantic& s) { return key == s.key; });
}

Vec3d direction(const Vec3d& v) {
  const double largest = std::fmax(std::abs(v.x), std::fmax(std::abs(v.y), std::abs(v.z)));
  if (!(largest > 0) || !is_finite(v)) return {};
  return normalized(v / largest);  // scaled first, so that squares neither overflow nor vanish
}

std::vector<Attribute> read_attributes(const Document& document, const std::vector<Block>& blocks,
                                       std::vector<std::string>& notes) {
  AttributeReader reader(document, blocks);
  std::vector<Attribute> attributes;
  for (const Semantic& semantic : kSemantics) {
    std::optional<Attribute> attribute = reader.read(semantic, notes);
    if (attribute) attributes.push_back(*std::move(attribute));
  }
  reader.append_notes(notes);
  return attributes;
}

WritableAttributes writable_attributes(const Mesh& mesh) {
  WritableAttributes held;
  std::set<std::string> keys;
  for (const Attribute& attribute : mesh.attributes) {
    const std::string key = key_of(attribute);
    std::optional<Attribute> kept = attribute;
    if (attribute.domain == Domain::corner) kept = merge_corners(mesh, attribute);
    if (!kept && key.front() != '_') kept = attribute;  // its vertices are split
    if (attribute.domain == Domain::face) {
      held.losses.push_back("GLB cannot hold '" + attribute.name + "' per face");
    } else if (!kept) {
      held.losses.push_back("GLB cannot hold '" + attribute.name + "' that differs between the faces at a vertex");
    } else if (attribute.components > 4 || !keys.insert(key).second) {
      held.losses.push_back("GLB cannot hold '" + attribute.name + "'");
    } else {
      held.attributes.push_back({key, *std::move(kept)});
    }
  }
  return held;
}

SplitVertices split_vertices(const Mesh& mesh, const std::vector<WritableAttribute>& held) {
  SplitVertices split;
  split.original.resize(mesh.vertex_count());
  std::iota(split.original.begin(), split.original.end(), 0u);
  split.corner.assign(mesh.vertex_count(), SplitVertices::kNone);
  split.corner_index = mesh.corner_vertex;
  const bool has_corners = std::any_of(held.begin(), held.end(),
                                       [](const WritableAttribute& h) { return h.attribute.domain == Domain::corner; });
  if (!has_corners) return split;
  std::vector<std::size_t> order(mesh.corner_vertex.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return comes_before(mesh, held, a, b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t c = order[i];
    const std::uint32_t v = mesh.corner_vertex[c];
    if (split.corner[v] == SplitVertices::kNone) {
      split.corner[v] = c;
    } else if (differs_at_corners(held, c, order[i - 1])) {
      split.corner_index[c] = static_cast<std::uint32_t>(split.original.size());
      split.original.push_back(v);
      split.corner.push_back(c);
      continue;
    } else {
      split.corner_index[c] = split.corner_index[order[i - 1]];
      continue;
    }
    split.corner_index[c] = v;
  }
  return split;
}

}  // namespace knead::detail::gltf
