#include "knead/io/gltf/codecs.h"

#ifdef KNEAD_HAS_DRACO
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#endif
#ifdef KNEAD_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace knead::io_detail::gltf {

#ifdef KNEAD_HAS_MESHOPTIMIZER
namespace {

constexpr std::size_t kMostPerByte = 512;  // the codec packs 256 elements of a byte into four bytes of header at best
constexpr std::size_t kLargestStride = 256;

using Filter = void (*)(void* buffer, std::size_t count, std::size_t stride);

struct NamedFilter {
  std::string_view name;
  Filter filter;
  bool (*allows)(std::size_t stride);
};

constexpr NamedFilter kFilters[] = {
    {"NONE", nullptr, [](std::size_t) { return true; }},
    {"OCTAHEDRAL", meshopt_decodeFilterOct, [](std::size_t stride) { return stride == 4 || stride == 8; }},
    {"QUATERNION", meshopt_decodeFilterQuat, [](std::size_t stride) { return stride == 8; }},
    {"EXPONENTIAL", meshopt_decodeFilterExp, [](std::size_t stride) { return stride % 4 == 0; }}};

bool is_index_mode(const MeshoptView& view) {
  return (view.mode == "TRIANGLES" && view.count % 3 == 0) || view.mode == "INDICES";
}

}  // namespace

bool has_meshopt() { return true; }

std::optional<std::string> decode_meshopt(std::string_view bytes, const MeshoptView& view) {
  if (view.count > bytes.size() * kMostPerByte) return std::nullopt;
  const auto* packed = reinterpret_cast<const unsigned char*>(bytes.data());
  if (is_index_mode(view)) {
    if ((view.stride != 2 && view.stride != 4) || view.filter != "NONE") return std::nullopt;
    std::string result(view.count * view.stride, '\0');
    const int failure = view.mode == "INDICES"
                            ? meshopt_decodeIndexSequence(result.data(), view.count, view.stride, packed, bytes.size())
                            : meshopt_decodeIndexBuffer(result.data(), view.count, view.stride, packed, bytes.size());
    if (failure != 0) return std::nullopt;
    return result;
  }
  if (view.mode != "ATTRIBUTES" || view.stride == 0 || view.stride % 4 != 0 || view.stride > kLargestStride) {
    return std::nullopt;
  }
  if (view.count > bytes.size() * kMostPerByte / view.stride) return std::nullopt;
  for (const NamedFilter& filter : kFilters) {
    if (filter.name != view.filter || !filter.allows(view.stride)) continue;
    std::string result(view.count * view.stride, '\0');
    if (meshopt_decodeVertexBuffer(result.data(), view.count, view.stride, packed, bytes.size()) != 0) break;
    if (filter.filter != nullptr) filter.filter(result.data(), view.count, view.stride);
    return result;
  }
  return std::nullopt;
}

#else

bool has_meshopt() { return false; }
std::optional<std::string> decode_meshopt(std::string_view, const MeshoptView&) { return std::nullopt; }

#endif

#ifdef KNEAD_HAS_DRACO
namespace {

constexpr std::size_t kMostDracoBytes = 64;  // of all attributes, for each vertex that a file of its size may have

template <class Number>
std::string numbers_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute, std::size_t components) {
  std::vector<Number> numbers(mesh.num_points() * components);
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    attribute.ConvertValue(attribute.mapped_index(draco::PointIndex(i)), static_cast<std::int8_t>(components),
                           numbers.data() + i * components);
  }
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

// A decoder that decodes attributes only if all together take at most so many bytes. It makes room for each of them
// before it looks for its numbers.
template <class Decoder>
class Bounded : public Decoder {
 public:
  explicit Bounded(std::size_t most_bytes) : most_bytes_(most_bytes) {}

 protected:
  bool DecodeAllAttributes() override {
    const draco::PointCloud& points = *this->point_cloud();
    std::size_t bytes = 0;
    for (std::int32_t a = 0; a < points.num_attributes(); ++a) {
      bytes += points.num_points() * static_cast<std::size_t>(points.attribute(a)->byte_stride());
    }
    return bytes <= most_bytes_ && Decoder::DecodeAllAttributes();
  }

 private:
  std::size_t most_bytes_;
};

// Takes the header. Returns whether a mesh of at most `most` vertices and corners follows. The decoder makes room for
// as many as the bytes say, before it looks for them.
bool says_at_most(draco::DecoderBuffer buffer, std::size_t most, draco::DracoHeader& header) {
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return false;
  // glTF asks for version 2.2; those before 2.0 have other numbers here.
  const int version = DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor);
  if (version < DRACO_BITSTREAM_VERSION(2, 0)) return false;
  buffer.set_bitstream_version(static_cast<std::uint16_t>(version));
  if ((header.flags & METADATA_FLAG_MASK) != 0) {
    draco::GeometryMetadata metadata;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return false;
  }
  const bool is_current = version >= DRACO_BITSTREAM_VERSION(2, 2);
  std::uint32_t faces = 0;
  std::uint32_t vertices = 0;
  if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING) {
    const auto take = [&](std::uint32_t& count) {
      return is_current ? draco::DecodeVarint(&count, &buffer) : buffer.Decode(&count);
    };
    if (!take(faces) || !take(vertices)) return false;
  } else {
    std::uint8_t traversal = 0;
    std::uint32_t split_vertices = 0;
    if (!buffer.Decode(&traversal) || (!is_current && !draco::DecodeVarint(&split_vertices, &buffer))) return false;
    if (!draco::DecodeVarint(&vertices, &buffer) || !draco::DecodeVarint(&faces, &buffer)) return false;
  }
  return vertices <= most && faces <= most / 3;
}

std::string bytes_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute, const DracoAttribute& wanted) {
  switch (wanted.type) {
    case NumberType::int8:
      return numbers_of<std::int8_t>(mesh, attribute, wanted.components);
    case NumberType::uint8:
      return numbers_of<std::uint8_t>(mesh, attribute, wanted.components);
    case NumberType::int16:
      return numbers_of<std::int16_t>(mesh, attribute, wanted.components);
    case NumberType::uint16:
      return numbers_of<std::uint16_t>(mesh, attribute, wanted.components);
    case NumberType::uint32:
      return numbers_of<std::uint32_t>(mesh, attribute, wanted.components);
    default:
      return numbers_of<float>(mesh, attribute, wanted.components);
  }
}

}  // namespace

bool has_draco() { return true; }

std::optional<DracoMesh> decode_draco(std::string_view bytes, const std::vector<DracoAttribute>& attributes,
                                      std::size_t most) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::DracoHeader header{};
  if (!says_at_most(buffer, most, header)) return std::nullopt;
  draco::Mesh mesh;
  const auto decode_by = [&](draco::MeshDecoder&& decoder) { return decoder.Decode({}, &buffer, &mesh).ok(); };
  const std::size_t most_bytes = most * kMostDracoBytes;
  const bool is_decoded = header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING
                              ? decode_by(Bounded<draco::MeshSequentialDecoder>(most_bytes))
                              : decode_by(Bounded<draco::MeshEdgebreakerDecoder>(most_bytes));
  if (!is_decoded) return std::nullopt;
  if (mesh.num_points() > most || mesh.num_faces() > most / 3) return std::nullopt;
  DracoMesh result;
  result.vertices = mesh.num_points();
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& v : mesh.face(draco::FaceIndex(f))) {
      if (v.value() >= mesh.num_points()) return std::nullopt;
      result.corners.push_back(v.value());
    }
  }
  for (const DracoAttribute& wanted : attributes) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(wanted.id);
    if (attribute == nullptr) return std::nullopt;
    result.attributes.push_back(bytes_of(mesh, *attribute, wanted));
  }
  return result;
}

#else

bool has_draco() { return false; }
std::optional<DracoMesh> decode_draco(std::string_view, const std::vector<DracoAttribute>&, std::size_t) {
  return std::nullopt;
}

#endif

}  // namespace knead::io_detail::gltf
