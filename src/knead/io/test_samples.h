// Small files of the formats STL, OFF and XYZ, each with something of its own, for tests of all of them.
#pragma once

#include <string>
#include <vector>

#include "knead/io/cursor.h"
#include "knead/io/shape_file.h"

namespace knead {

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
    const auto stored = order == std::endian::native ? value : swap_bytes(value);
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

inline std::vector<Sample> stl_off_and_xyz_samples() {
  std::vector<Sample> samples = stl_samples();
  for (const auto& more : {off_samples(), xyz_samples()}) samples.insert(samples.end(), more.begin(), more.end());
  return samples;
}

}  // namespace knead
