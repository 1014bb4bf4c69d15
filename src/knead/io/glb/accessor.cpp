#include "knead/io/glb/accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "knead/io/cursor.h"

namespace knead::io_detail::glb {
namespace {

struct ComponentType {
  std::size_t code;
  NumberType type;
  std::size_t size;
  double most;  // what 1 is stored as where the accessor is normalized
};

constexpr std::array<ComponentType, 6> kComponentTypes = {{{5120, NumberType::int8, 1, 127},
                                                           {5121, NumberType::uint8, 1, 255},
                                                           {5122, NumberType::int16, 2, 32767},
                                                           {5123, NumberType::uint16, 2, 65535},
                                                           {5125, NumberType::uint32, 4, 0},
                                                           {5126, NumberType::float32, 4, 0}}};

const ComponentType& component_type(NumberType type) {
  return *std::find_if(kComponentTypes.begin(), kComponentTypes.end(),
                       [&](const ComponentType& known) { return known.type == type; });
}

// Elements of `size` bytes in the buffer view that `user` (an accessor, or part of a sparse one) names.
DenseData find_elements(const Document& document, const Value& user, std::size_t count, std::size_t size) {
  const Value view = document.root().item("bufferViews", user.at("bufferView").whole());
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    if (view.find("extensions") && view.at("extensions").find(extension)) {
      view.fail(
          fmt::format("is compressed ({}), which this build cannot read; export it without compression", extension));
    }
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

double read_number(const Document& document, std::size_t position, NumberType type) {
  const auto read = [&](auto value) {
    std::memcpy(&value, document.bin.data() + position, sizeof value);
    return static_cast<double>(std::endian::native == std::endian::little ? value : swap_bytes(value));
  };
  switch (type) {
    case NumberType::int8:
      return read(std::int8_t{});
    case NumberType::uint8:
      return read(std::uint8_t{});
    case NumberType::int16:
      return read(std::int16_t{});
    case NumberType::uint16:
      return read(std::uint16_t{});
    case NumberType::uint32:
      return read(std::uint32_t{});
    default:
      return read(float{});
  }
}

void read_element(const Document& document, const Accessor& accessor, std::size_t position, double* to) {
  const std::size_t size = component_type(accessor.type).size;
  for (std::size_t c = 0; c < accessor.components; ++c) {
    to[c] = read_number(document, position + c * size, accessor.type);
  }
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
  data.indices = find_elements(document, indices, data.count, component_type(data.index_type).size);
  data.values = find_elements(document, sparse.at("values"), data.count, accessor.element_size());
  return data;
}

void replace_sparse(const Document& document, const Value& value, const Accessor& accessor,
                    std::vector<double>& numbers) {
  const SparseData& sparse = *accessor.sparse;
  double least = 0;
  for (std::size_t i = 0; i < sparse.count; ++i) {
    const double index = read_number(document, sparse.indices.begin + i * sparse.indices.stride, sparse.index_type);
    if (index < least || index >= static_cast<double>(accessor.count)) {
      value.fail(fmt::format("sparse index {} is out of order or range; repair the file", index));
    }
    least = index + 1;
    read_element(document, accessor, sparse.values.begin + i * sparse.values.stride,
                 numbers.data() + static_cast<std::size_t>(index) * accessor.components);
  }
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

std::size_t component_size(NumberType type) { return component_type(type).size; }

std::size_t Accessor::element_size() const { return components * component_size(type); }

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
  } else if (accessor.count > most_elements(document.bytes.size())) {
    value.fail(fmt::format("{} elements are more than the file can hold; the file is damaged", accessor.count));
  }
  if (const std::optional<Value> sparse = value.find("sparse")) {
    accessor.sparse = find_sparse(document, *sparse, accessor);
  }
  return accessor;
}

std::vector<double> read_accessor(const Document& document, std::size_t index, const Accessor& accessor, bool as_real) {
  std::vector<double> numbers(accessor.count * accessor.components, 0.0);
  for (std::size_t i = 0; accessor.dense && i < accessor.count; ++i) {
    read_element(document, accessor, accessor.dense->begin + i * accessor.dense->stride,
                 numbers.data() + i * accessor.components);
  }
  if (accessor.sparse) replace_sparse(document, document.root().item("accessors", index), accessor, numbers);
  const double most = component_type(accessor.type).most;
  if (!as_real || !accessor.normalized || most == 0) return numbers;
  // Rounded, so that what is written as floats in their place is the same number.
  for (double& number : numbers) number = double{static_cast<float>(std::fmax(number / most, -1.0))};
  return numbers;
}

}  // namespace knead::io_detail::glb
