// Decompresses glTF files, with the libraries draco and meshoptimizer where this build has them. Source: Khronos,
// KHR_draco_mesh_compression and EXT_meshopt_compression.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/text.h"

#ifdef KNEAD_HAS_DRACO
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#endif
#ifdef KNEAD_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace knead::detail::gltf {
namespace {

#ifdef KNEAD_HAS_MESHOPTIMIZER
constexpr std::size_t kMaxPerByte = 512;  // the codec packs 256 elements of a byte into four bytes of header at best
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

#endif

#ifdef KNEAD_HAS_DRACO
constexpr std::size_t kMaxDracoBytes = 64;  // of all attributes, for each vertex that a file of its size may have

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
  return visit_type(wanted.type,
                    [&](auto number) { return numbers_of<decltype(number)>(mesh, attribute, wanted.components); });
}

#endif

constexpr const char* kMeshopt[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

bool is_codec(std::string_view extension) {
  return extension == kDraco || extension == kMeshopt[0] || extension == kMeshopt[1];
}

// Returns the object without that member.
Json without(const Json& object, std::string_view key) {
  Json result = Json::object();
  for (const JsonMember& member : object.members()) {
    if (member.key != key) result.set(member.key, member.value);
  }
  return result;
}

// Returns the object without the extensions that compress.
Json without_codecs(const Json& object) {
  const Json* extensions = object.find("extensions");
  if (extensions == nullptr) return object;
  Json others = *extensions;
  for (const JsonMember& member : extensions->members()) {
    if (is_codec(member.key)) others = without(others, member.key);
  }
  Json result = without(object, "extensions");
  if (!others.members().empty()) result.set("extensions", others);
  return result;
}

std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

// Elements of `size` bytes side by side, each at a multiple of four bytes.
std::string spread(const std::string& elements, std::size_t size) {
  if (size == aligned(size)) return elements;
  std::string result(elements.size() / size * aligned(size), '\0');
  for (std::size_t i = 0; i * size < elements.size(); ++i) {
    std::memcpy(result.data() + i * aligned(size), elements.data() + i * size, size);
  }
  return result;
}

std::string as_indices(const std::vector<std::uint32_t>& corners, std::size_t size) {
  std::string result(corners.size() * size, '\0');
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t b = 0; b < size; ++b) result[i * size + b] = static_cast<char>(corners[i] >> (8 * b) & 0xff);
  }
  return result;
}

// Little-endian floats side by side.
std::vector<float> floats_in(std::string_view bytes) {
  std::vector<float> floats;
  const std::string name = kDraco;
  ByteCursor cursor(bytes, name);
  while (cursor.left() >= sizeof(float)) floats.push_back(cursor.take<float>("a float"));
  return floats;
}

class Decompressor {
 public:
  Decompressor(std::string_view bytes, const std::string& name)
      : layout_(parse_chunks(bytes, name)),
        document_(open_document(bytes, layout_, name)),
        views_(root().count("bufferViews")) {
    for (std::size_t v = 0; v < views_.size(); ++v) views_[v].json = root().item("bufferViews", v).json();
  }

  // Returns what was decompressed, as words.
  std::vector<std::string> run() {
    std::vector<std::string> done;
    if (has_meshopt()) {
      for (std::size_t v = 0; v < views_.size(); ++v) decode_view(v);
      if (decoded_ > 0) done.push_back("meshopt");
    }
    decoded_ = 0;
    if (has_draco()) {
      for (std::size_t m = 0; m < root().count("meshes"); ++m) decode_mesh(root().item("meshes", m));
      if (decoded_ > 0) done.push_back("Draco");
    }
    return done;
  }

  std::string file() const {
    std::string bin;
    const Json views = place_views(bin);
    Json json = Json::object();
    for (const JsonMember& member : document_.json.members()) json.set(member.key, member.value);
    json.set("buffers", Json(std::vector<Json>{Json({{"byteLength", bin.size()}})}));
    json.set("bufferViews", views);
    if (json.has("accessors")) json.set("accessors", accessors());
    if (json.has("meshes")) json.set("meshes", meshes());
    for (const char* key : {"extensionsUsed", "extensionsRequired"}) json = with_others(std::move(json), key);
    std::string chunks;
    append_chunk(chunks, kJson, to_text(json));
    append_chunk(chunks, kBin, bin);
    return with_header(std::move(chunks));
  }

 private:
  struct View {
    Json json;
    std::optional<std::string> bytes;  // that replace what it has
    std::size_t stride = 0;            // of new views, or 0
  };

  Value root() const { return document_.root(); }

  // The bytes that a buffer view, or the extension that compresses one, names.
  Span range(const Value& view) const {
    const std::size_t begin = view.whole("byteOffset").value_or(0);
    const std::size_t size = view.at("byteLength").whole();
    const std::size_t all = document_.bin.size();
    if (view.at("buffer").whole() != 0 || begin > all || size > all - begin) {
      view.fail(fmt::format("ends after its buffer of {} bytes; the file is damaged", all));
    }
    return {begin, begin + size};
  }

  std::string_view bytes_of(const Span& span) const {
    std::string none;  // they are in memory
    return document_.bin.piece(span.begin, span.end - span.begin, none);
  }

  void decode_view(std::size_t v) {
    const Value value = root().item("bufferViews", v);
    const char* key = meshopt_extension(value.json());
    if (key == nullptr) return;
    const Value packed = value.at("extensions").at(key);
    const std::optional<Value> filter = packed.find("filter");
    const MeshoptView view{packed.at("byteStride").whole(), packed.at("count").whole(), packed.at("mode").text(),
                           filter ? filter->text() : "NONE"};
    const Span span = range(packed);
    views_[v].bytes = decode_meshopt(bytes_of(span), view);
    if (!views_[v].bytes) {
      packed.fail("cannot be decompressed; the file is damaged, or uses a newer version of the codec");
    }
    gone_.push_back(span);
    ++decoded_;
  }

  void decode_mesh(const Value& mesh) {
    for (std::size_t p = 0; p < mesh.count("primitives"); ++p) {
      const Value primitive = mesh.item("primitives", p);
      const std::optional<Value> extensions = primitive.find("extensions");
      const std::optional<Value> packed = extensions ? extensions->find(kDraco) : std::nullopt;
      if (packed) decode_primitive(primitive, *packed);
    }
  }

  void decode_primitive(const Value& primitive, const Value& packed) {
    const std::size_t view = packed.at("bufferView").whole();
    const Span span = range(root().item("bufferViews", view));
    std::vector<DracoAttribute> wanted;
    std::vector<std::size_t> accessors;
    for (const JsonMember& member : packed.at("attributes").json().members()) {
      accessors.push_back(primitive.at("attributes").at(member.key.c_str()).whole());
      const Value accessor = root().item("accessors", accessors.back());
      wanted.push_back({static_cast<std::uint32_t>(packed.at("attributes").at(member.key.c_str()).whole()),
                        component_type(accessor.at("componentType")), component_count(accessor.at("type"))});
    }
    const auto mesh = decode_draco(bytes_of(span), wanted, most_elements(document_.size));
    if (!mesh) packed.fail("cannot be decompressed; the file is damaged");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
      require_count(accessors[i], mesh->vertices);
      const std::size_t size = wanted[i].components * size_of(wanted[i].type);
      if (wanted[i].type == NumberType::float32) {
        floats_of_[accessors[i]] = {floats_in(mesh->attributes[i]), wanted[i].components};
      }
      add_data(accessors[i], view, spread(mesh->attributes[i], size), aligned(size), kVertexData);
    }
    const std::size_t indices = primitive.at("indices").whole();
    require_count(indices, mesh->corners.size());
    const Value type = root().item("accessors", indices).at("componentType");
    const std::size_t size = size_of(component_type(type));
    if (size < 4 && mesh->vertices > std::size_t{1} << (8 * size)) type.fail("is too small for the indices");
    add_data(indices, view, as_indices(mesh->corners, size), 0, kIndexData);
    gone_.push_back(span);
    ++decoded_;
  }

  void require_count(std::size_t accessor, std::size_t count) const {
    const Value stated = root().item("accessors", accessor).at("count");
    if (stated.whole() == count) return;
    stated.fail(fmt::format("should be {}, as in the compressed mesh; the file is damaged", count));
  }

  // Gives an accessor a view of its own; the first one gets that of the compressed bytes.
  void add_data(std::size_t accessor, std::size_t compressed, std::string bytes, std::size_t stride,
                std::size_t target) {
    if (view_of_.count(accessor) > 0) return;
    const bool is_first = !views_[compressed].bytes;
    const std::size_t number = is_first ? compressed : views_.size();
    if (!is_first) views_.emplace_back();
    view_of_[accessor] = number;
    views_[number] = {Json({{"target", target}}), std::move(bytes), stride};
  }

  // The views after decompression; their bytes go to `bin`. Compressed bytes are left out unless others use them.
  Json place_views(std::string& bin) const {
    const std::vector<Span> cuts = find_cuts();
    std::size_t kept = 0;
    for (const Span& cut : cuts) {
      bin += bytes_of({kept, cut.begin});
      kept = cut.end;
    }
    bin += bytes_of({kept, document_.bin.size()});
    Json result = Json::array();
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Json json = without_codecs(views_[v].json);
      if (views_[v].bytes) {
        bin.resize(aligned(bin.size()), '\0');
        json.set("buffer", 0);
        json.set("byteOffset", bin.size());
        json.set("byteLength", views_[v].bytes->size());
        if (views_[v].stride != 0) json.set("byteStride", views_[v].stride);
        bin += *views_[v].bytes;
      } else if (const std::size_t begin = root().item("bufferViews", v).whole("byteOffset").value_or(0); begin > 0) {
        json.set("byteOffset", begin - cut_before(cuts, begin));
      }
      result.push_back(std::move(json));
    }
    return result;
  }

  // Disjoint and ascending; whole words, so that what follows stays aligned.
  std::vector<Span> find_cuts() const {
    std::vector<Span> used;
    for (std::size_t v = 0; v < root().count("bufferViews"); ++v) {
      if (!views_[v].bytes) used.push_back(range(root().item("bufferViews", v)));
    }
    std::vector<Span> cuts;
    for (const Span& span : gone_) {
      const Span cut{aligned(span.begin), span.end / 4 * 4};
      const auto meets = [&](const Span& other) { return cut.begin < other.end && other.begin < cut.end; };
      if (cut.begin < cut.end && std::none_of(used.begin(), used.end(), meets)) cuts.push_back(cut);
    }
    const auto earlier = [](const Span& a, const Span& b) { return a.begin < b.begin; };
    std::sort(cuts.begin(), cuts.end(), earlier);
    std::vector<Span> disjoint;
    for (const Span& cut : cuts) {
      if (disjoint.empty() || cut.begin >= disjoint.back().end) disjoint.push_back(cut);
    }
    return disjoint;
  }

  static std::size_t cut_before(const std::vector<Span>& cuts, std::size_t position) {
    std::size_t sum = 0;
    for (const Span& cut : cuts) sum += cut.end <= position ? cut.end - cut.begin : 0;
    return sum;
  }

  Json accessors() const {
    Json result = Json::array();
    for (std::size_t a = 0; a < root().count("accessors"); ++a) {
      Json json = root().item("accessors", a).json();
      const auto view = view_of_.find(a);
      if (view != view_of_.end()) {
        json.set("bufferView", view->second);
        json.set("byteOffset", 0);
      }
      if (const auto values = floats_of_.find(a); values != floats_of_.end()) {
        const auto& [floats, components] = values->second;
        if (json.has("min")) json.set("min", parse_json(least_text(floats, components)));
        if (json.has("max")) json.set("max", parse_json(greatest_text(floats, components)));
      }
      result.push_back(std::move(json));
    }
    return result;
  }

  Json meshes() const {
    Json result = Json::array();
    for (std::size_t m = 0; m < root().count("meshes"); ++m) {
      Json mesh = root().item("meshes", m).json();
      Json primitives = Json::array();
      for (const Json& primitive : mesh.at("primitives").items()) primitives.push_back(without_codecs(primitive));
      mesh.set("primitives", primitives);
      result.push_back(std::move(mesh));
    }
    return result;
  }

  static Json with_others(Json json, const char* key) {
    const Json* extensions = json.find(key);
    if (extensions == nullptr) return json;
    std::vector<Json> others;
    for (const Json& extension : extensions->items()) {
      if (!extension.is_text() || !is_codec(extension.text())) others.push_back(extension);
    }
    if (others.empty()) return without(json, key);
    json.set(key, Json(others));
    return json;
  }

  Layout layout_;
  Document document_;
  std::vector<View> views_;
  std::map<std::size_t, std::size_t> view_of_;  // of accessors with new data
  // Of accessors with new floats: these, and how many make a vector. The bounds in the file are those before
  // compression.
  std::map<std::size_t, std::pair<std::vector<float>, std::size_t>> floats_of_;
  std::vector<Span> gone_;  // bytes that were decompressed
  std::size_t decoded_ = 0;
};

}  // namespace

#ifdef KNEAD_HAS_MESHOPTIMIZER

bool has_meshopt() { return true; }

std::optional<std::string> decode_meshopt(std::string_view bytes, const MeshoptView& view) {
  if (view.count > bytes.size() * kMaxPerByte) return std::nullopt;
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
  if (view.count > bytes.size() * kMaxPerByte / view.stride) return std::nullopt;
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

bool has_draco() { return true; }

std::optional<DracoMesh> decode_draco(std::string_view bytes, const std::vector<DracoAttribute>& attributes,
                                      std::size_t most) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::DracoHeader header{};
  if (!says_at_most(buffer, most, header)) return std::nullopt;
  draco::Mesh mesh;
  const auto decode_by = [&](draco::MeshDecoder&& decoder) { return decoder.Decode({}, &buffer, &mesh).ok(); };
  const std::size_t most_bytes = most * kMaxDracoBytes;
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

const char* meshopt_extension(const Json& view) {
  const Json* extensions = view.find("extensions");
  if (extensions == nullptr) return nullptr;
  for (const char* key : kMeshopt) {
    if (extensions->has(key)) return key;
  }
  return nullptr;
}

bool names_codec(std::string_view text) {
  return (has_draco() && text.find(kDraco) != std::string_view::npos) ||
         (has_meshopt() &&
          (text.find(kMeshopt[0]) != std::string_view::npos || text.find(kMeshopt[1]) != std::string_view::npos));
}

std::string decompressed(std::string bytes, const std::string& name, std::vector<std::string>& notes) {
  Decompressor decompressor(bytes, name);
  const std::vector<std::string> done = decompressor.run();
  if (done.empty()) return bytes;
  notes.push_back(fmt::format("it is compressed with {}; if a vertex moves, it is written without compression",
                              fmt::join(done, " and ")));
  return decompressor.file();
}

}  // namespace knead::detail::gltf
