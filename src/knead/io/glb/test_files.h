// Small GLB files for tests.
#pragma once

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

using GlbJson = nlohmann::ordered_json;

inline std::string little_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xffu);
  return bytes;
}

inline std::string glb_chunk(std::uint32_t type, std::string contents, char padding) {
  contents.resize((contents.size() + 3) / 4 * 4, padding);
  return little_endian(static_cast<std::uint32_t>(contents.size())) + little_endian(type) + contents;
}

inline std::string glb_with_header(const std::string& chunks) {
  return "glTF" + little_endian(2) + little_endian(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

inline std::string glb_file(const std::string& json, const std::string& bin) {
  return glb_with_header(glb_chunk(0x4E4F534A, json, ' ') + glb_chunk(0x004E4942, bin, '\0'));
}

// The raw numbers of a list, little endian on every machine that the tests run on.
template <class T>
std::string raw(const std::vector<T>& numbers) {
  std::string bytes(numbers.size() * sizeof(T), '\0');
  if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

// A file in the making; `json` may be changed at will.
struct GlbFile {
  GlbJson json = GlbJson::parse(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{}}]}],"accessors":[],"bufferViews":[],"buffers":[{"byteLength":0}]})");
  std::string bin;

  std::size_t add_view(const std::string& bytes) {
    bin.resize((bin.size() + 3) / 4 * 4, '\0');
    json["bufferViews"].push_back(
        GlbJson::object({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}}));
    bin += bytes;
    return json["bufferViews"].size() - 1;
  }

  // An accessor over a view of its own.
  template <class T>
  std::size_t add(int component_type, const char* type, std::size_t components, const std::vector<T>& numbers) {
    const std::size_t view = add_view(raw(numbers));
    json["accessors"].push_back(GlbJson::object({{"bufferView", view},
                                                 {"componentType", component_type},
                                                 {"count", numbers.size() / components},
                                                 {"type", type}}));
    return json["accessors"].size() - 1;
  }

  std::size_t add_vec3(const std::vector<float>& numbers) { return add(5126, "VEC3", 3, numbers); }

  GlbJson& primitive(std::size_t i = 0) { return json["meshes"][0]["primitives"][i]; }
  GlbJson& accessor(std::size_t i) { return json["accessors"][i]; }

  std::string bytes() {
    json["buffers"][0]["byteLength"] = bin.size();
    return glb_file(json.dump(), bin);
  }

  ShapeFile parse() { return parse_shape(bytes(), "glb", "made.glb"); }
};

// Two triangles of a square in the plane z = 0, with normals, tangents and bounds.
inline GlbFile square_glb() {
  GlbFile file;
  GlbJson& attributes = file.primitive()["attributes"];
  attributes["POSITION"] = file.add_vec3({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  file.accessor(0)["min"] = {0, 0, 0};
  file.accessor(0)["max"] = {1, 1, 0};
  attributes["NORMAL"] = file.add_vec3({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  attributes["TANGENT"] = file.add<float>(5126, "VEC4", 4, {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1});
  file.primitive()["indices"] = file.add<std::uint16_t>(5123, "SCALAR", 1, {0, 1, 2, 0, 2, 3});
  return file;
}

// The JSON and the binary chunk of a file.
inline GlbJson json_of(const std::string& bytes) {
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  return GlbJson::parse(bytes.substr(20, size));
}

inline std::string bin_of(const std::string& bytes) {
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  return bytes.substr(28 + size);
}

}  // namespace knead
