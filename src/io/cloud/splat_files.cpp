// Packed files of Gaussian splats: .splat (32 bytes a splat) and .spz (Niantic's, versions 2 and 3, compressed). Both
// are blocks of rows, one row for each splat.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "knead/error.h"
#include "math/elementary.h"

namespace knead::detail::packed_splats {
namespace {

constexpr double kDegreeZero = 0.28209479177387814;  // the spherical harmonic, 1 / sqrt(4 pi)
constexpr double kSpzColor = 0.15;
constexpr std::size_t kSplatRow = 32;
constexpr std::size_t kSpzHeader = 16;
constexpr std::size_t kSpzCount = 8;  // where the header has the number of splats
constexpr std::size_t kMaxDegree = 3;
constexpr std::uint32_t kSmallestThreeMask = 511;

using Turn = std::array<double, 4>;  // w, x, y, z

// One number of each splat: in a byte, a float or 24 bits.
struct Column {
  enum class Kind { real, logarithm, fixed24, byte, opacity };

  std::string name;  // of the attribute; "x", "y" and "z"
  Kind kind = Kind::byte;
  std::size_t begin = 0;  // of the first row's
  std::size_t stride = 0;
  double factor = 1;  // a stored whole number is factor * value + offset
  double offset = 0;
};

// Rows that lie one after the other.
struct Block {
  std::size_t begin = 0;
  std::size_t stride = 0;
};

enum class Turns { four_bytes, first_three, smallest_three };

struct Layout {
  bool is_spz = false;
  std::string bytes;  // not compressed
  std::size_t count = 0;
  std::vector<Block> blocks;
  std::vector<Column> columns;
  Block turns;
  Turns turns_as = Turns::four_bytes;
};

std::uint8_t byte_at(const std::string& bytes, std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); }

double read_number(const Layout& layout, const Column& column, std::size_t row) {
  const std::size_t at = column.begin + row * column.stride;
  const bool is_swapped = std::endian::native == std::endian::big;
  switch (column.kind) {
    case Column::Kind::real:
      return read_binary(layout.bytes.data() + at, StoredType::float32, is_swapped);
    case Column::Kind::logarithm:
      return elementary::log(std::max(read_binary(layout.bytes.data() + at, StoredType::float32, is_swapped),
                                      double{std::numeric_limits<float>::min()}));
    case Column::Kind::fixed24: {
      const std::int32_t low = byte_at(layout.bytes, at) | byte_at(layout.bytes, at + 1) << 8;
      const std::int32_t high = byte_at(layout.bytes, at + 2);
      return ((high < 128 ? high : high - 256) * 65536 + low) / column.factor;
    }
    case Column::Kind::opacity:  // a byte at the end stands for what rounds to it
      return elementary::logit(std::clamp(byte_at(layout.bytes, at) / 255.0, 1.0 / 1024, 1 - 1.0 / 1024));
    case Column::Kind::byte:
      break;
  }
  return (byte_at(layout.bytes, at) - column.offset) / column.factor;
}

void put_byte(std::string& bytes, std::size_t at, double value) {
  bytes[at] = static_cast<char>(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))));
}

void put_number(Layout& layout, const Column& column, std::size_t row, double value) {
  const std::size_t at = column.begin + row * column.stride;
  switch (column.kind) {
    case Column::Kind::real:
      return put_float(layout.bytes, at, value, std::endian::little);
    case Column::Kind::logarithm:
      return put_float(layout.bytes, at, elementary::exp(std::clamp(value, -87.0, 88.0)), std::endian::little);
    case Column::Kind::fixed24: {
      constexpr double most = (1 << 23) - 1;
      const double whole = value * column.factor;
      if (!(std::abs(whole) <= most)) {
        throw InvalidInput("splat " + std::to_string(row) +
                           " has moved beyond the range of this file; write a PLY file");
      }
      const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(whole)));
      for (std::size_t i = 0; i < 3; ++i) layout.bytes[at + i] = static_cast<char>(bits >> (8 * i) & 255);
      return;
    }
    case Column::Kind::opacity:
      return put_byte(layout.bytes, at, 255 * elementary::sigmoid(value));
    case Column::Kind::byte:
      return put_byte(layout.bytes, at, column.factor * value + column.offset);
  }
}

// The number in the last bits is that of the last of the three.
Turn smallest_three(std::uint32_t bits) {
  std::array<double, 4> xyzw{};
  const std::size_t largest = bits >> 30;
  double sum = 0;
  for (std::size_t i = 4; i-- > 0;) {
    if (i == largest) continue;
    const double size = (bits & kSmallestThreeMask) / (kSmallestThreeMask * std::sqrt(2.0));
    xyzw[i] = (bits >> 9 & 1) != 0 ? -size : size;
    sum += size * size;
    bits >>= 10;
  }
  xyzw[largest] = std::sqrt(std::max(0.0, 1 - sum));
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

std::uint32_t smallest_three(const Turn& turn) {
  const std::array<double, 4> xyzw{turn[1], turn[2], turn[3], turn[0]};
  const auto is_smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto* const found = std::max_element(xyzw.begin(), xyzw.end(), is_smaller);
  const auto largest = static_cast<std::size_t>(found - xyzw.begin());
  auto bits = static_cast<std::uint32_t>(largest);
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const bool is_negative = (xyzw[i] < 0) != (*found < 0);
    const long size = std::lround(kSmallestThreeMask * std::sqrt(2.0) * std::abs(xyzw[i]));
    const auto kept = static_cast<std::uint32_t>(std::min<long>(size, kSmallestThreeMask));
    bits = bits << 10 | (is_negative ? 1U << 9 : 0U) | kept;
  }
  return bits;
}

Turn read_turn(const Layout& layout, std::size_t row) {
  const std::size_t at = layout.turns.begin + row * layout.turns.stride;
  const auto byte = [&](std::size_t i) { return byte_at(layout.bytes, at + i); };
  switch (layout.turns_as) {
    case Turns::four_bytes:
      return {(byte(0) - 128) / 128.0, (byte(1) - 128) / 128.0, (byte(2) - 128) / 128.0, (byte(3) - 128) / 128.0};
    case Turns::first_three: {
      const Vec3d v{byte(0) / 127.5 - 1, byte(1) / 127.5 - 1, byte(2) / 127.5 - 1};
      return {std::sqrt(std::max(0.0, 1 - norm2(v))), v.x, v.y, v.z};
    }
    case Turns::smallest_three:
      break;
  }
  std::uint32_t bits = 0;
  for (std::size_t i = 4; i-- > 0;) bits = bits << 8 | byte(i);
  return smallest_three(bits);
}

// turn: a unit quaternion.
void put_turn(Layout& layout, std::size_t row, const Turn& turn) {
  const std::size_t at = layout.turns.begin + row * layout.turns.stride;
  const double sign = turn[0] < 0 ? -1 : 1;
  switch (layout.turns_as) {
    case Turns::four_bytes:
      for (std::size_t i = 0; i < 4; ++i) put_byte(layout.bytes, at + i, 128 * turn[i] + 128);
      return;
    case Turns::first_three:
      for (std::size_t i = 0; i < 3; ++i) put_byte(layout.bytes, at + i, 127.5 * (sign * turn[i + 1] + 1));
      return;
    case Turns::smallest_three:
      break;
  }
  const std::uint32_t bits = smallest_three(turn);
  for (std::size_t i = 0; i < 4; ++i) layout.bytes[at + i] = static_cast<char>(bits >> (8 * i) & 255);
}

void add_three(Layout& layout, const char* name, const Column& first, std::size_t step) {
  for (std::size_t i = 0; i < 3; ++i) {
    Column column = first;
    column.name = name + std::to_string(i);
    column.begin += i * step;
    layout.columns.push_back(std::move(column));
  }
}

Layout splat_layout(std::string bytes) {
  Layout layout;
  layout.count = bytes.size() / kSplatRow;
  layout.bytes = std::move(bytes);
  layout.blocks = {{0, kSplatRow}};
  layout.turns = {28, kSplatRow};
  using enum Column::Kind;
  for (std::size_t i = 0; i < 3; ++i) layout.columns.push_back({{"xyz"[i]}, real, 4 * i, kSplatRow});
  add_three(layout, "f_dc_", {{}, byte, 24, kSplatRow, 255 * kDegreeZero, 127.5}, 1);
  layout.columns.push_back({"opacity", opacity, 27, kSplatRow});
  add_three(layout, "scale_", {{}, logarithm, 12, kSplatRow}, 4);
  return layout;
}

// The bytes have a whole header. Fails where rows are missing.
Layout spz_layout(std::string bytes, const std::string& name) {
  const auto header = [&](std::size_t at) { return byte_at(bytes, at); };
  const std::uint32_t version = header(4);
  const std::size_t degree = header(12);
  const bool is_known = bytes.starts_with("NGSP") && (version == 2 || version == 3) && degree <= kMaxDegree &&
                        (header(14) & 2) == 0 && header(13) < 24;
  if (!is_known)
    throw InvalidInput(Place{name}, "is no .spz file of version 2 or 3 without extensions; convert it to PLY");
  Layout layout;
  layout.is_spz = true;
  for (std::size_t i = 4; i-- > 0;) layout.count = layout.count << 8 | header(kSpzCount + i);
  const std::size_t harmonics = degree * (degree + 2);
  std::size_t end = kSpzHeader;
  const auto add = [&](std::size_t stride) {
    layout.blocks.push_back({end, stride});
    end += layout.count * stride;
    return layout.blocks.back();
  };
  using enum Column::Kind;
  const Block places = add(9);
  const double unit = std::ldexp(1.0, header(13));
  for (std::size_t i = 0; i < 3; ++i) layout.columns.push_back({{"xyz"[i]}, fixed24, places.begin + 3 * i, 9, unit});
  const Block alphas = add(1);
  const Block colors = add(3);
  const Block scales = add(3);
  layout.turns_as = version == 3 ? Turns::smallest_three : Turns::first_three;
  layout.turns = add(version == 3 ? 4 : 3);
  const Block rest = add(3 * harmonics);
  add_three(layout, "f_dc_", {{}, byte, colors.begin, 3, 255 * kSpzColor, 127.5}, 1);
  for (std::size_t i = 0; i < 3 * harmonics; ++i) {  // those of red first; the file has those of a splat together
    const std::size_t at = rest.begin + 3 * (i % harmonics) + i / harmonics;
    layout.columns.push_back({"f_rest_" + std::to_string(i), byte, at, rest.stride, 128, 128});
  }
  layout.columns.push_back({"opacity", opacity, alphas.begin, 1});
  add_three(layout, "scale_", {{}, byte, scales.begin, 3, 16, 160}, 1);
  if (bytes.size() < end) throw InvalidInput(Place{name}, "is cut short: it has fewer splats than its header says");
  layout.bytes = std::move(bytes);
  return layout;
}

void read_columns(ShapeFile& shape, Layout layout, const std::string& name) {
  Mesh& mesh = shape.mesh;
  mesh.positions.resize(layout.count);
  for (const Column& column : layout.columns) {
    const std::size_t axis = std::string_view("xyz").find(column.name);
    Attribute attribute{column.name, Domain::vertex, NumberType::float32, 1, {}};
    for (std::size_t i = 0; i < layout.count; ++i) {
      const double value = read_number(layout, column, i);
      if (!std::isfinite(value)) {
        throw InvalidInput(Place{name},
                           "splat " + std::to_string(i) + " has a number that is not finite; repair the file");
      }
      axis < 3 ? mesh.positions[i][axis] = value : attribute.values.emplace_back(value);
    }
    if (axis >= 3) mesh.attributes.push_back(std::move(attribute));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    Attribute& attribute =
        mesh.attributes.emplace_back(Attribute{"rot_" + std::to_string(k), Domain::vertex, NumberType::float32, 1, {}});
    for (std::size_t i = 0; i < layout.count; ++i) attribute.values.push_back(read_turn(layout, i)[k]);
  }
  set_layout(shape, std::move(layout));
}

void read_splat(ShapeFile& shape, const std::string& name) {
  if (shape.bytes.empty() || shape.bytes.size() % kSplatRow != 0) {
    throw InvalidInput(Place{name},
                       "holds " + std::to_string(shape.bytes.size()) +
                           " bytes, which are no splats of 32 bytes; the file is cut short or no .splat file");
  }
  read_columns(shape, splat_layout(shape.bytes), name);
}

void read_spz(ShapeFile& shape, const std::string& name) {
  std::string bytes = unzipped(shape.bytes, name);
  if (bytes.size() < kSpzHeader) throw InvalidInput(Place{name}, "is cut short: it has no whole header");
  Layout layout = spz_layout(std::move(bytes), name);
  if (layout.count == 0) throw InvalidInput(Place{name}, "holds no splats");
  read_columns(shape, std::move(layout), name);
}

std::string file_of(Layout layout) { return layout.is_spz ? zipped(layout.bytes, "output") : std::move(layout.bytes); }

// Puts the places that differ, and the values of attributes.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d>,
                    const WriteOptions& options) {
  Layout layout = layout_of<Layout>(source);
  check_fits_floats(positions);
  std::array<const Attribute*, 4> turns{};
  for (const Column& column : layout.columns) {
    const std::size_t axis = std::string_view("xyz").find(column.name);
    for (std::size_t i = 0; axis < 3 && i < layout.count; ++i) {
      if (positions[i][axis] != source.mesh.positions[i][axis]) put_number(layout, column, i, positions[i][axis]);
    }
    for (const Attribute& attribute : options.attributes) {
      for (std::size_t k = 0; attribute.name == column.name && k < options.changed.size(); ++k) {
        put_number(layout, column, options.changed[k], attribute.values[k]);
      }
    }
  }
  for (const Attribute& attribute : options.attributes) {
    if (attribute.name.starts_with("rot_")) turns.at(static_cast<std::size_t>(attribute.name[4] - '0')) = &attribute;
  }
  for (std::size_t k = 0; turns[0] != nullptr && k < options.changed.size(); ++k) {
    put_turn(layout, options.changed[k],
             {turns[0]->values[k], turns[1]->values[k], turns[2]->values[k], turns[3]->values[k]});
  }
  return file_of(std::move(layout));
}

std::string with_copies(const ShapeFile& source, std::span<const std::uint32_t> vertices) {
  const auto& layout = layout_of<Layout>(source);
  Layout result;
  result.is_spz = layout.is_spz;
  result.bytes = layout.bytes.substr(0, layout.blocks.front().begin);
  const std::size_t count = layout.count + vertices.size();
  for (std::size_t i = 0; layout.is_spz && i < 4; ++i) {
    result.bytes[kSpzCount + i] = static_cast<char>(count >> (8 * i) & 255);
  }
  std::size_t end = 0;
  for (const Block& block : layout.blocks) {
    end = block.begin + layout.count * block.stride;
    result.bytes.append(layout.bytes, block.begin, layout.count * block.stride);
    for (const std::uint32_t v : vertices)
      result.bytes.append(layout.bytes, block.begin + v * block.stride, block.stride);
  }
  result.bytes += layout.bytes.substr(end);
  return file_of(std::move(result));
}

std::string generate_splat(const Mesh& mesh, const WriteOptions&) {
  check_fits_floats(mesh.positions);
  Layout layout = splat_layout(std::string(kSplatRow * mesh.vertex_count(), '\xff'));
  for (const Column& column : layout.columns) {
    const std::size_t axis = std::string_view("xyz").find(column.name);
    const Attribute* const attribute = mesh.find_attribute(column.name);
    for (std::size_t i = 0; i < layout.count; ++i) {
      if (axis < 3) put_number(layout, column, i, mesh.positions[i][axis]);
      if (attribute != nullptr) put_number(layout, column, i, attribute->values[i]);
    }
  }
  std::array<const Attribute*, 4> turns{};
  for (std::size_t k = 0; k < 4; ++k) turns[k] = mesh.find_attribute("rot_" + std::to_string(k));
  for (std::size_t i = 0; i < layout.count; ++i) {
    Turn turn{turns[0]->values[i], turns[1]->values[i], turns[2]->values[i], turns[3]->values[i]};
    double size2 = 0;
    for (const double number : turn) size2 += number * number;
    for (double& number : turn) number = size2 > 0 ? number / std::sqrt(size2) : 0;
    put_turn(layout, i, turn);
  }
  return std::move(layout.bytes);
}

std::vector<std::string> splat_losses(const Mesh& mesh) {
  std::vector<std::string> losses{"a .splat file holds sizes as floats, and turns, colours and opacities in bytes"};
  for (const Attribute& attribute : mesh.attributes) {
    const auto begins = [&](const char* with) { return attribute.name.starts_with(with); };
    if (begins("scale_") || begins("rot_") || begins("f_dc_") || attribute.name == "opacity") continue;
    const std::string what = begins("f_rest_") ? "spherical harmonics above degree 0" : "'" + attribute.name + "'";
    const std::string loss = "a .splat file has no " + what;
    if (losses.back() != loss) losses.push_back(loss);
  }
  return losses;
}

std::vector<std::string> no_losses(const ShapeFile&) { return {}; }

bool stores_floats(const ShapeFile&) { return true; }

}  // namespace
}  // namespace knead::detail::packed_splats

const knead::detail::Codec knead::detail::splat_codec{.name = "splat",
                                                      .read = packed_splats::read_splat,
                                                      .rewrite = packed_splats::rewrite,
                                                      .with_copies = packed_splats::with_copies,
                                                      .generate = packed_splats::generate_splat,
                                                      .losses = packed_splats::splat_losses,
                                                      .source_losses = packed_splats::no_losses,
                                                      .stores_floats = packed_splats::stores_floats,
                                                      .generates_floats = true,
                                                      .is_for_splats = true};

const knead::detail::Codec knead::detail::spz_codec{.name = "spz",
                                                    .read = packed_splats::read_spz,
                                                    .rewrite = packed_splats::rewrite,
                                                    .with_copies = packed_splats::with_copies,
                                                    .source_losses = packed_splats::no_losses,
                                                    .stores_floats = packed_splats::stores_floats};
