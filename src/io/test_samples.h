// Small GLB files for tests.
#pragma once

#include <nlohmann/json.hpp>

#include <cstring>
#include <string>
#include <vector>

#include "io/gltf/gltf.h"
#include "io/text.h"
#include "io/threemf/zip.h"
#include "knead/io.h"

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

// Small files of every format, each with something of its own, for tests of all of them.

struct Sample {
  std::string format;
  std::string bytes;
};

// Two triangles, the second without a normal, with attributes.
inline std::string binary_stl_sample(const std::string& header) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  mesh.add_face(std::vector<std::uint32_t>{0, 2, 3});
  mesh.attributes.push_back({"attribute", Domain::face, NumberType::uint16, 1, {513, 0}});
  std::string bytes = serialize_mesh("stl", mesh);
  bytes.replace(0, header.size(), header);
  bytes.replace(84 + 50, 12, std::string(12, '\0'));
  return bytes;
}

inline std::vector<Sample> stl_samples() {
  return {
      {"stl",
       "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 1 1e-3 0\nvertex 0 1. -0\nendloop\nendfacet\n"
       "endsolid\n"},
      {"stl",
       "SOLID a b #1\r\n FACET NORMAL nan 0 1\r\n  OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 0 0\r\n"
       "  ENDLOOP ENDFACET\r\nENDSOLID a b #1\r\n\r\nsolid facet\r facet normal 1 0 0 outer loop\r"
       "vertex 5 5 5 vertex 6 5 5 vertex 5 6 +5 endloop endfacet\rendsolid"},
      {"stl", binary_stl_sample("")},
      {"stl", binary_stl_sample("solid of bytes") + "end"},
      {"stl", serialize_mesh("stl", parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n", "obj", "a").mesh)}};
}

// A square of two triangles and a face of two vertices. colors: the count of color numbers after each face.
inline std::string binary_off_sample(std::endian order, bool colors) {
  std::string bytes = "OFF BINARY\n";
  const auto put = [&](auto value) {
    static_assert(sizeof value == 4);
    const auto stored = order == std::endian::native ? value : detail::swap_bytes(value);
    bytes.append(reinterpret_cast<const char*>(&stored), sizeof stored);
  };
  for (const std::int32_t count : {4, 3, 0}) put(count);
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 1.f, 1.f, 0.5f}) put(number);
  for (const std::vector<std::int32_t>& face : {std::vector<std::int32_t>{0, 1, 2}, {1, 3, 2}, {0, 1}}) {
    put(static_cast<std::int32_t>(face.size()));
    for (const std::int32_t v : face) put(v);
    if (!colors) continue;
    put(std::int32_t{3});
    for (const float number : {0.5f, 0.25f, 1.f}) put(number);
  }
  return bytes;
}

inline std::vector<Sample> off_samples() {
  return {{"off", "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1e0 0\n0 0 1.\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
          {"off",
           "# c\r\nCOFF 4 2\r\n\r\n0 0 0 255 0 0 255 # red\r\n1 0 0 0 255 0 255\r1 1 0 0 0 255 255\n"
           "0 1 -0 9 9 9 9\n4 0 1 2 3 1 2 3\n3 0 1 2 4 5 6\nmore"},
          {"off", "STNOFF\n3 1 0\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 nan\n3 0 1 2 0.5 0.25 0 1\n"},
          {"off", "3 3\n0 0 0 0.5 1 1\n1 0 0 0 0 0\n0 1 0 1 1 1\n3 0 1 2 7\n2 0 1\n3 2 1 0 8"},
          {"off", "nOFF3\n3 1 0\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 0 2 1 2\n"},
          {"off", binary_off_sample(std::endian::big, true)},
          {"off", binary_off_sample(std::endian::little, false)}};
}

inline std::vector<Sample> xyz_samples() {
  return {{"xyz", "0 0 0\n1.5 0 0\n0 1e1 -0\n"},
          {"xyz", "# c\r\n3\r\n0,0, 0,0,0,1\r\n// c\r1 0 0 0 0.6 -0.8 # x\n0;1;0;1;0;0;\n"},
          {"xyz", "0 0 0 255 0 0\n1 0 0 0 255 1\n\n0 1 0 0 0 7"},
          {"xyz", "0 0 0 0.5 nan\n1 0 0 7 1e3\n"},
          {"xyz",
           "\xef\xbb\xbf"
           "0 0 0 1\n1 0 0 2 3\n2 0 0\n"}};
}

inline std::string square_ply(const std::string& format, const std::string& end) {
  return "ply" + end + "format " + format + " 1.0" + end + "element vertex 4" + end + "property float x" + end +
         "property float y" + end + "property float z" + end + "element face 1" + end +
         "property list uchar int vertex_indices" + end + "end_header" + end;
}

inline std::vector<Sample> ply_samples() {
  const std::string elaborate =
      "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\n"
      "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty list uchar short extra\nelement face 2\nproperty list uchar int vertex_indices\n"
      "property list uchar float texcoord\nproperty uchar flag\nelement tristrips 1\n"
      "property list int int vertex_indices\nend_header\n0 0 0 0 0 1 1 2 3 2 7 8\n1 0 0 0 0 1 1 2 3 0\n"
      "0 1 0 0 0 1 1 2 3 1 5\n1 1e-3 1 0 0 1 1 2 3 0\n3 0 1 2 6 0 0 1 0 0 1 9\n3 1 3 2 6 0 0 1 0 0 1 9\n"
      "5 0 1 2 -1 3\n";
  const std::string points =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
      "0 0 0\n1 1e-3 -0\n";
  std::string big = square_ply("binary_big_endian", "\r\n");
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.5f}) {
    const std::string little = raw(std::vector<float>{number});
    big.append(little.rbegin(), little.rend());
  }
  big += std::string("\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\3", 17);
  const Mesh mesh = parse_shape(elaborate, "ply", "a").mesh;
  return {{"ply", elaborate},
          {"ply", points},
          {"ply", big},
          {"ply", square_ply("ascii", "\r") + "0 0 0\r1 0 0\r1 1 0\r0 1 0\r4 0 1 2 3"},
          {"ply", serialize_mesh("ply", mesh, {.double_coordinates = false})}};
}

inline std::vector<Sample> obj_samples() {
  return {{"obj",
           "# c\nv 0 0 0 1 1 1\nv 1.5 0 0\nv 0 1e1 0\nv 0 0 -1 \\\n\nvt 0 0\nvn 0 0 1\ng a\n"
           "f 1/1/1 2/1/1 3/1/1\nf -1//-1 -2//1 1//1 2\nf 1 4 2\n"},
          {"obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
          {"obj",
           "\xef\xbb\xbf"
           "v 0 0 0\r\nv 1 0 0\rv 0 1 \\\r\n-0 1\r\ns off\r\nf -3 -2 -1\r\nf 1 2"},
          {"obj", "mtllib a.mtl b c.mtl\nusemtl m\nv 1 2 3\nv 4 5 6 0.5\nl 1 2\n"},
          {"obj", "f 1/2 2/1 3/2 4/1\nvt 0.5 nan\nvt 1\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 0 0.5 1 1\n"}};
}

inline std::string triangle_glb() {
  GlbFile file;
  file.primitive()["attributes"]["POSITION"] = file.add_vec3({0, 0, 0, 1, 0, 0, 1, 1, 0});
  return file.bytes();
}

// Two nodes, sparse and quantized data.
inline std::string elaborate_glb() {
  GlbFile file = square_glb();
  const std::size_t indices = file.add_view(raw(std::vector<std::uint8_t>{1}));
  const std::size_t values = file.add_view(raw(std::vector<float>{7, 8, 9}));
  file.accessor(0)["sparse"] = {{"count", 1},
                                {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                {"values", {{"bufferView", values}}}};
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add<std::uint16_t>(5123, "VEC2", 2, {0, 0, 9, 0, 9, 9, 0, 9});
  file.json["accessors"].back()["normalized"] = true;
  file.json["nodes"].push_back(GlbJson::parse(R"({"children":[2],"rotation":[0.6,0,0,0.8]})"));
  file.json["nodes"].push_back(GlbJson::parse(R"({"mesh":0,"scale":[2,3,-4]})"));
  file.json["scenes"][0]["nodes"].push_back(1);
  return file.bytes();
}

// Two Gaussian splats in a node that turns and stretches them.
inline std::string splats_glb() {
  GlbFile file;
  GlbJson& attributes = file.primitive()["attributes"];
  attributes["POSITION"] = file.add_vec3({0, 0, 0, 1, 2, 3});
  attributes["KHR_gaussian_splatting:ROTATION"] = file.add<std::int8_t>(5120, "VEC4", 4, {127, 0, 0, 0, 0, 90, 0, 90});
  file.json["accessors"].back()["normalized"] = true;
  attributes["KHR_gaussian_splatting:SCALE"] = file.add_vec3({1, 2, 3, 0, 0.5, 0.25});
  attributes["KHR_gaussian_splatting:OPACITY"] = file.add<float>(5126, "SCALAR", 1, {0.5, 1});
  attributes["KHR_gaussian_splatting:SH_DEGREE_0_COEF_0"] = file.add_vec3({1, 0, -1, 0.5, 0, 2});
  file.primitive()["mode"] = 0;
  file.primitive()["extensions"]["KHR_gaussian_splatting"]["kernel"] = "ellipse";
  file.json["nodes"][0] = GlbJson::parse(R"({"mesh":0,"rotation":[0.6,0,0,0.8],"scale":[2,3,-4]})");
  return file.bytes();
}

inline std::vector<Sample> glb_samples() {
  GlbFile strip;
  strip.primitive()["attributes"]["POSITION"] = strip.add_vec3({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  strip.primitive()["mode"] = 5;
  const Mesh colored =
      parse_shape("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvn 0 0 1\nvt 0 1\nf 1/1/1 2/1/1 3/1/1\n", "obj", "a")
          .mesh;
  const Mesh points = parse_shape("0 0 0 1 2 3\n1 0 0 4 5 6\n", "xyz", "a").mesh;
  return {{"glb", triangle_glb()},
          {"glb", elaborate_glb()},
          {"glb", strip.bytes()},
          {"glb", serialize_mesh("glb", colored)},
          {"glb", serialize_mesh("glb", points)},
          {"glb", splats_glb()}};
}

inline std::vector<Sample> pcd_samples() {
  const std::string text =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 0\nnan nan nan\n1 0 1.5\n";
  const std::string columns =
      "VERSION .7\r\nFIELDS normal_x x rgb y normal_y z normal_z hist id\r\nSIZE 4 8 4 8 4 8 4 4 8\r\n"
      "TYPE F F F F F F F F U\r\nCOUNT 1 1 1 1 1 1 1 2 1\r\nWIDTH 1\r\nHEIGHT 2\r\nPOINTS 2\r\nDATA ascii\r\n"
      "0 5 4.2108e+06 6 0 7 1 1 2 9\r\n0 1 -1.7e38 2 1 3 0 3 4 8";
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 2, 3}};
  const std::string plain = serialize_mesh("pcd", mesh);
  mesh.attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, {0, 0, 1, 1, 0, 0}});
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 4, {1, 2, 3, 4, 255, 0, 255, 9}});
  mesh.attributes.push_back({"ring", Domain::vertex, NumberType::int16, 1, {-7, 300}});
  return {{"pcd", text},
          {"pcd", columns},
          {"pcd", plain},
          {"pcd", serialize_mesh("pcd", mesh) + "end"},
          {"pcd", serialize_mesh("pcd", mesh, {.double_coordinates = true})}};
}

inline std::string ptx_pose(const std::string& matrix) { return "0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + matrix; }

inline std::vector<Sample> ptx_samples() {
  const std::string identity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string turned = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30.5 1\n";
  const std::string poses = ptx_pose(identity);
  return {{"ptx", "1\n2\n" + poses + "1 0 0\n0 1 1\n"},
          {"ptx", "2\n1\n" + poses + "1 0 0 0.5\n0 0 0 0.5\n"},
          {"ptx", "1\n3\n" + ptx_pose(turned) + "1 0 0 0.5 255 0 9\nnan 0 0 0.5 0 0 0\n0 1 3 0.25 1 2 3"},
          {"ptx", "1\n1\n" + poses + "1 5 0 0.5\n1\n1\n" + ptx_pose(turned) + "1 0 4 1\n"},
          {"ptx", "1\r\n2\r\n" + poses + "1 1 0 0.5 7\r\n3 0 1\r\n"}};
}

// The parts of a GLB file as text, with the buffer as a data URI.
inline std::string embedded(const GlbFile& file, int indent = 1) {
  GlbJson json = file.json;
  json["buffers"][0] = {{"uri", "data:application/octet-stream;base64," + detail::to_base64(file.bin)},
                        {"byteLength", file.bin.size()}};
  return json.dump(indent) + "\n";
}

// The first is short: tests damage each of its bytes in every way.
inline std::vector<Sample> gltf_samples() {
  GlbFile triangle;
  triangle.primitive()["attributes"]["POSITION"] = triangle.add_vec3({0, 0, 0, 1, 0, 0, 1, 1, 0});
  GlbFile two = square_glb();
  two.json["buffers"] = GlbJson::array();
  const std::string tail = two.bin.substr(48);
  for (const std::string& part : {two.bin.substr(0, 48), tail}) {
    two.json["buffers"].push_back({{"byteLength", part.size()}, {"uri", "data:;base64," + detail::to_base64(part)}});
  }
  for (std::size_t v = 1; v < two.json["bufferViews"].size(); ++v) {
    GlbJson& view = two.json["bufferViews"][v];
    view["buffer"] = 1;
    view["byteOffset"] = view["byteOffset"].get<std::size_t>() - 48;
    if (view["byteOffset"] == 0) view.erase("byteOffset");
  }
  const Mesh cloud = parse_shape("0 0 0 1 2 3\n1 0 0 4 5 6\n", "xyz", "a").mesh;
  return {{"gltf", embedded(triangle, -1)},
          {"gltf", embedded(square_glb())},
          {"gltf", two.json.dump()},
          {"gltf", "\xef\xbb\xbf" + embedded(triangle)},
          {"gltf", serialize_mesh("gltf", cloud)}};
}

inline std::vector<Sample> su2_samples() {
  const std::string cells = "NDIME= 3\nNELEM= 1\n10 0 1 2 3 0\n";
  const std::string markers = "NMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n5 0 1 2\n";
  const std::string points = "0 0 0 0\n1 0 0 1\n0 1.0 0 2\n0 0 1e0 3\n";
  return {{"su2", cells + "NPOIN= 4\n" + points + markers},
          {"su2", "% made by hand\n" + cells + "%\n NPOIN = 4 4\n" + points + "% end\n" + markers},
          {"su2", "NDIME=3\r\nNPOIN=2\r\n1 2 3\r\n% one more\r\n\r\n4 5 6"},
          {"su2", "NZONE= 2\nIZONE= 1\n" + cells + "NPOIN= 4\n" + points + "IZONE= 2\n" + cells + "NPOIN= 4\n" +
                      points + markers},
          {"su2", "NDIME= 3\nNPOIN= 1\n1 2 3 0\nNELEM= 0\nFFD_NBOX= 1\nFFD_TAG= a\n"}};
}

inline std::vector<Sample> msh_samples() {
  const std::string four = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  const std::string cells = "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";
  const std::string binary_4 = "$MeshFormat\n4.1 1 8\n" + raw(std::vector<std::int32_t>{1}) +
                               "\n$EndMeshFormat\n$Nodes\n" + raw(std::vector<std::uint64_t>{2, 3, 1, 3}) +
                               raw(std::vector<std::int32_t>{0, 1, 0}) + raw(std::vector<std::uint64_t>{1, 1}) +
                               raw(std::vector<double>{0, 0.5, 1}) + raw(std::vector<std::int32_t>{2, 1, 1}) +
                               raw(std::vector<std::uint64_t>{2, 2, 3}) +
                               raw(std::vector<double>{1, 2, 3, 0.5, 0.25, 4, 5, 6, 0, 1}) + "\n$EndNodes\n";
  std::string binary_2 = "$MeshFormat\n2.2 1 8\n" + raw(std::vector<std::int32_t>{1}) + "\n$EndMeshFormat\n$Nodes\n2\n";
  for (const int i : {1, 2}) {
    binary_2 += raw(std::vector<std::int32_t>{i}) + raw(std::vector<double>{i * 1.0, 2.5, 0});
  }
  return {{"msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 1 2.50 3\n$EndNodes\n"},
          {"msh", four + "$Nodes\n1 1 1 1\n0 1 0 1\n1\n0.5 1e0 2\n$EndNodes\n"},
          {"msh", "$Comments\n$Nodes\n$EndComments\n" + four +
                      "$Nodes\r\n2 4 1 4\r\n1 1 1 2\r\n1\r\n2\r\n0 0 0 0.5\r\n1 0 0 1\r\n3 1 0 2\n3\n4\n0 1.0 0\n"
                      "0 0 1\n$EndNodes\n" +
                      cells},
          {"msh", binary_4},
          {"msh", binary_2 + "\n$EndNodes\n" + cells}};
}

inline std::string foam_head(const std::string& entries) {
  return "FoamFile\n{\n    version 2.0;\n    class vectorField;\n" + entries + "    object points;\n}\n// * //\n";
}

inline std::vector<Sample> foam_samples() {
  std::string big;
  for (const float number : {0.f, 1.f, 2.5f}) {
    const std::string little = raw(std::vector<float>{number});
    big.append(little.rbegin(), little.rend());
  }
  return {{"foam", "FoamFile{format ascii;}1((0 1 2.50))"},
          {"foam", "/* made\nby hand */\n" + foam_head("format ascii;\n") +
                       "\n2\n(\n(0 0 0)\n(1e0 0.5 2) // a\n)\n\n// *** //\n"},
          {"foam", foam_head("format binary; arch \"LSB;label=32;scalar=64\";\n") + "2\n(" +
                       raw(std::vector<double>{0, 1, 2, 3, 4, 5.5}) + ")\n"},
          {"foam", foam_head("format binary;\narch \"LSB;label=64;scalar=32\";\n") + "2\n(" +
                       raw(std::vector<float>{0, 1, 2, 3, 4, 5.5f}) + ")\n"},
          {"foam", foam_head("format binary;\narch \"MSB;label=32;scalar=32\";\n") + "1(" + big + ")"}};
}

inline std::vector<Sample> bdf_samples() {
  return {{"bdf", "GRID,1,,.5,1.0,2.\n"},
          {"bdf", "GRID           1              .5      1.     2.0\n"},
          {"bdf",
           "SOL 101\nCEND\nGRID = ALL\nBEGIN BULK\n$ GRID    9       0       1.      1.      1.\n"
           "GRID    1       0       0.00E+001.5+3   -1.0    \r\nGRID    2                       1.      2.      123\n"
           "CTRIA3  1       1       1       2       3\nENDDATA\nGRID,9,,x\n"},
          {"bdf",
           "grid*   1               0               0.              1.\n*       2.5D0\n"
           "GRID*                  2                             0.0 1.000000000E+00+A\n"
           "*A                   -3.\n"},
          {"bdf", "GRID*,3,,1.,2.\n*,3.\nGRID,4,0,,1.e-3,$\ngrid, 5 , 0 , 1. , -2. , .3 , 0\n"}};
}

inline std::vector<Sample> inp_samples() {
  return {{"inp", "*NODE\n1,.5,1.0,2\n"},
          {"inp", "*Node\n1, 0., 1e0\n2, , -1.,\n"},
          {"inp",
           "*HEADING\n made by hand, 1, 2\n** *NODE\n*NODE, NSET=all,\n SYSTEM=R\n      1,   0.,  0.5,   1.50\n"
           "2, 1., 0., 0., 0., 0., 1.\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n*NODE\n3, 1D-1, 2, 3\n"
           "*NODE OUTPUT\nU, RF\n"},
          {"inp", "*Part, name=a\r\n*Node\r\n1,1,2,3\r\n*End Part\r\n*Instance, name=b, part=a\r\n*End Instance\r\n"},
          {"inp", "*node,nset=n\n1,-0.12345678901234568,1.2345678901234567e-5,3"}};
}

inline std::vector<Sample> unv_samples() {
  const std::string node = "         1         1         1        11\n";
  const std::string end = "    -1\n";
  return {{"unv", "-1\n2411\n1 1 1 1\n0 .5 1D0\n-1\n"},
          {"unv", "-1\r\n2411\r\n1 1 1 1\r\n 0.0 5.E-1 1\r\n-1\r\n"},
          {"unv", end + "   151\nmade by hand\n" + end + end + "  2411\n" + node +
                      "   0.0000000000000000D+00   1.5000000000000000D+00  -1.0000000000000000D-10\n" + end + end +
                      "  2412\n         1        11         1         1         7         1\n         1\n" + end},
          {"unv", end + "  2411\n" + node + "   1.0D+00   2.0D+00   3.0D+00\n" + node + "4 5 6\n" + end},
          {"unv", end + "  2411\n" + node + " 1 2 3\n" + end + end + "  2411\n" + node + " 4 5 6\n" + end}};
}

// An archive with these parts beside the one that names the model.
inline std::string threemf_file(std::vector<std::pair<std::string, std::string>> parts,
                                const std::string& model = "3D/3dmodel.model") {
  parts.emplace_back("_rels/.rels",
                     "<Relationships><Relationship Type=\"http://schemas.microsoft.com/3dmanufacturing/"
                     "2013/01/3dmodel\" Target='/" +
                         model + "'/></Relationships>");
  return detail::zip::archive_of(parts);
}

inline std::string threemf_mesh(const std::string& triangles) {
  return "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0.50\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>\n<vertex y=\"1\" "
         "x=\"0\" z=\"+0\"/></vertices><triangles>" +
         triangles + "</triangles></mesh>";
}

inline std::vector<Sample> threemf_samples() {
  const std::string triangle = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";
  const std::string plain = "<model><resources><object id=\"1\">" + threemf_mesh(triangle) +
                            "</object></resources><build><item objectid=\"1\"/></build></model>";
  const std::string colored =
      "<?xml version=\"1.0\"?>\r\n<!-- <object/> --><model unit='inch' xmlns:m=\"m\"><metadata "
      "name='a'>&lt;b></metadata>\r\n"
      "<resources><m:colorgroup id='5'><m:color color='#FF0000'/><m:color color='#00ff0080'/></m:colorgroup>\r\n"
      "<object id='2' pid='5' pindex='1'>" +
      threemf_mesh(
          "<triangle v1='0' v2='1' v3='2' pid='5' p1='0' p2='1' p3='1' paint_color=\"8\" /><triangle v1='0' v2='2' "
          "v3='1'/>") +
      "</object></resources><build><item objectid='2' partnumber='x'/></build></model>";
  const std::string placed =
      "<model><resources><object id=\"3\"><components><component objectid=\"1\" p:path=\"/3D/o.model\" "
      "transform=\"0 2 0 -2 0 0 0 0 2 1 1 1\"/></components></object><object id=\"4\">" +
      threemf_mesh(triangle) +
      "</object></resources><build><item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 -1 5 0 0.1\"/><item "
      "objectid=\"4\"/></build></model>";
  const Mesh quad = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n", "obj", "a").mesh;
  return {{"3mf", threemf_file({{"3D/3dmodel.model", plain}})},
          {"3mf", threemf_file({{"m", plain}, {"Metadata/a.png", "\x89PNG"}}, "m")},
          {"3mf", threemf_file({{"3D/3dmodel.model", colored}})},
          {"3mf", threemf_file({{"3D/3dmodel.model", placed}, {"3D/o.model", plain}})},
          {"3mf", serialize_mesh("3mf", quad)}};
}

inline std::vector<Sample> samples_of(const std::string& format) {
  if (format == "ply") return ply_samples();
  if (format == "obj") return obj_samples();
  if (format == "stl") return stl_samples();
  if (format == "3mf") return threemf_samples();
  if (format == "off") return off_samples();
  if (format == "gltf") return gltf_samples();
  if (format == "pcd") return pcd_samples();
  if (format == "ptx") return ptx_samples();
  if (format == "su2") return su2_samples();
  if (format == "msh") return msh_samples();
  if (format == "foam") return foam_samples();
  if (format == "bdf") return bdf_samples();
  if (format == "inp") return inp_samples();
  if (format == "unv") return unv_samples();
  return format == "glb" ? glb_samples() : xyz_samples();
}

}  // namespace knead
