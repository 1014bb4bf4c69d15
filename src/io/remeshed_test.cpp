// Files of remeshed shapes, in every format.
#include "knead/io.h"

#include <fmt/format.h>

#include "io/codec.h"
#include "io/obj/obj.h"
#include "io/off/off.h"
#include "io/test_samples.h"
#include "knead/error.h"
#include "math/system.h"
#include "support/remade_files.h"
#include "support/shape_promises.h"
#include "support/shape_text.h"
#include "support/test_meshes.h"

namespace knead::remeshed_test {
namespace {

std::string written(const ShapeFile& source, const Remade& remade, const WriteOptions& options = {}) {
  return serialize_remeshed(source.format, source, remade.mesh, remade.face_source, options);
}

ShapeFile through(const ShapeFile& source, const Remade& remade, const WriteOptions& options = {}) {
  return parse_shape(written(source, remade, options), source.format, "written");
}

// As serialize_remeshed, also where nothing changed.
std::string written_anew(const ShapeFile& source, const Remade& remade) {
  const detail::NewMesh shape{source, remade.mesh, remade.face_source};
  return detail::codec_named(source.format, "source").remeshed(shape, {});
}

std::vector<ShapeFile> samples_with_faces() {
  std::vector<ShapeFile> shapes;
  for (const char* format : {"ply", "obj", "stl", "off", "glb"}) {
    for (const Sample& sample : samples_of(format)) {
      ShapeFile shape = parse_shape(sample.bytes, format, "sample");
      if (shape.mesh.face_count() > 0) shapes.push_back(std::move(shape));
    }
  }
  return shapes;
}

// GLB: normals, texture coordinates and placed positions go through other numbers, in float.
double tolerance_for(const ShapeFile& shape) { return shape.format == "glb" ? 1e-5 : 0; }

TEST(Remeshed, TheSameMeshIsTheSource) {
  const std::vector<ShapeFile> shapes = samples_with_faces();
  EXPECT_GE(shapes.size(), 20u);
  for (const ShapeFile& shape : shapes) EXPECT_EQ(written(shape, same_again(shape.mesh)), shape.bytes);
}

TEST(Remeshed, WrittenAnewTheSameMeshIsReadBack) {
  for (const ShapeFile& shape : samples_with_faces()) {
    const ShapeFile back = parse_shape(written_anew(shape, same_again(shape.mesh)), shape.format, "written");
    EXPECT_EQ(back.mesh.positions, shape.mesh.positions) << shape.bytes;
    EXPECT_EQ(back.mesh.face_begin, shape.mesh.face_begin) << shape.bytes;
    EXPECT_EQ(back.mesh.corner_vertex, shape.mesh.corner_vertex) << shape.bytes;
    EXPECT_EQ(back.mesh.attributes, shape.mesh.attributes) << shape.bytes;
    expect_remade(shape, same_again(shape.mesh), back, 0);
  }
}

TEST(Remeshed, SplitFacesKeepWhatIsAtTheirCornersAndTheirState) {
  for (const ShapeFile& shape : samples_with_faces()) {
    SCOPED_TRACE(shape.format + ": " + shape.bytes);
    const Remade all = split_all(shape.mesh);
    expect_remade(shape, all, through(shape, all), tolerance_for(shape));
    const Remade some = split_faces(shape.mesh, [](std::uint32_t f) { return f % 2 == 1; });
    expect_remade(shape, some, through(shape, some), tolerance_for(shape));
  }
}

TEST(Remeshed, InAnyOrderAndWithFacesLeftOut) {
  for (const ShapeFile& shape : samples_with_faces()) {
    SCOPED_TRACE(shape.format + ": " + shape.bytes);
    Remade remade = split_all(shape.mesh);
    const Mesh forward = remade.mesh;
    const std::size_t kept = forward.face_count() - 1;
    remade.mesh.face_begin = {0};
    remade.mesh.corner_vertex.clear();
    for (std::size_t f = kept; f-- > 0;) remade.mesh.add_face(forward.face(f));
    remade.face_source.resize(kept);
    std::reverse(remade.face_source.begin(), remade.face_source.end());
    for (Attribute& a : remade.mesh.attributes) {
      if (a.domain == Domain::vertex) continue;
      const std::size_t n = static_cast<std::size_t>(a.components) * (a.domain == Domain::corner ? 3 : 1);
      std::vector<double> values;
      for (std::size_t f = kept; f-- > 0;) {
        values.insert(values.end(), a.values.begin() + static_cast<std::ptrdiff_t>(f * n),
                      a.values.begin() + static_cast<std::ptrdiff_t>((f + 1) * n));
      }
      a.values = values;
    }
    expect_remade(shape, remade, through(shape, remade), tolerance_for(shape));
  }
}

TEST(Remeshed, RealFiles) {
  KNEAD_NEEDS_TEST_MESH("originals");
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test_mesh("originals"))) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".ply" && extension != ".obj" && extension != ".stl" && extension != ".off" && extension != ".glb")
      continue;
    const ShapeFile shape = read_shape(entry.path());
    if (shape.mesh.face_count() == 0 || shape.bytes.size() > 3'000'000) continue;
    SCOPED_TRACE(entry.path());
    const Remade same = same_again(shape.mesh);
    expect_remade(shape, same, parse_shape(written_anew(shape, same), shape.format, "written"), 0);
    const Remade some = split_faces(shape.mesh, [](std::uint32_t f) { return f % 3 != 0; });
    expect_remade(shape, some, through(shape, some), tolerance_for(shape));
    ++count;
  }
  EXPECT_GE(count, 15u);
}

TEST(Remeshed, AnotherFormatIsGenerated) {
  const ShapeFile shape = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0.1\ng a\nf 1 2 3\n", "obj", "a.obj");
  const Remade remade = split_all(shape.mesh);
  const std::string bytes = serialize_remeshed("ply", shape, remade.mesh, remade.face_source);
  EXPECT_EQ(parse_shape(bytes, "ply", "a").mesh.positions, remade.mesh.positions);  // 0.1 needs doubles
  EXPECT_EQ(text_of(remesh_losses("a.ply", shape)), "lines 'g' are left out\n");
  EXPECT_EQ(text_of(remesh_losses("a.obj", shape)), "");
}

TEST(Remeshed, WhatDoesNotFitIsRefused) {
  const ShapeFile shape = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n", "obj", "a.obj");
  Remade remade = split_all(shape.mesh);
  EXPECT_NO_THROW(written(shape, remade));
  remade.face_source[1] = 1;
  EXPECT_THROW(written(shape, remade), InvalidInput);
  remade.face_source.pop_back();
  EXPECT_THROW(written(shape, remade), InvalidInput);
  remade = split_all(shape.mesh);
  remade.mesh.attributes[0].values.pop_back();
  EXPECT_THROW(written(shape, remade), InvalidInput);
  remade.mesh.attributes.clear();
  EXPECT_THROW(written(shape, remade), InvalidInput);
  remade = split_all(shape.mesh);
  remade.mesh.positions[3].y = kInfinity;
  EXPECT_THROW(written(shape, remade), InvalidInput);
  const ShapeFile points = parse_shape("0 0 0\n1 0 0\n", "xyz", "a.xyz");
  EXPECT_THROW(written(points, {points.mesh, {}}), InvalidInput);
  EXPECT_THROW(remesh_losses("a.xyz", points), InvalidInput);
  EXPECT_THROW(remesh_losses("a.step", shape), InvalidInput);
}

TEST(Remeshed, PlyKeepsItsHeader) {
  const std::string text =
      "ply\r\nformat ascii 1.0\r\ncomment TextureFile a.png\r\nelement camera 1\r\nproperty float fov\r\n"
      "property uchar on\r\nobj_info x\r\nelement vertex 3\r\nproperty uint8 red\r\nproperty uint8 green\r\n"
      "property uint8 blue\r\nproperty double x\r\nproperty float32 y\r\nproperty int32 z\r\n"
      "property list uchar int extra\r\nelement edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\n"
      "element face 1\r\nproperty uchar flag\r\nproperty list uchar int vertex_index\r\nend_header\r\n"
      "50 1\r\n1 2 3 0 0 0 0\r\n1 2 3 1 0.1 0 2 7 8\r\n1 2 9 0 1 1 0\r\n0 1\r\n7 3 0 1 2\r\nmore\r\n";
  const ShapeFile shape = parse_shape(text, "ply", "a.ply");
  Remade remade = split_all(shape.mesh);
  remade.mesh.positions[3] = {0.25, 0.5, 0.125};
  const std::string expected =
      "ply\r\nformat ascii 1.0\r\ncomment TextureFile a.png\r\nelement camera 1\r\nproperty float fov\r\n"
      "property uchar on\r\nobj_info x\r\nelement vertex 4\r\nproperty uint8 red\r\nproperty uint8 green\r\n"
      "property uint8 blue\r\nproperty double x\r\nproperty float32 y\r\nproperty float64 z\r\n"
      "element face 3\r\nproperty uchar flag\r\nproperty list uchar int vertex_index\r\nend_header\r\n"
      "50 1\r\n1 2 3 0 0 0\r\n1 2 3 1 0.1 0\r\n1 2 9 0 1 1\r\n1 2 5 0.25 0.5 0.125\r\n"
      "7 3 0 1 3\r\n7 3 1 2 3\r\n7 3 2 0 3\r\nmore\r\n";
  EXPECT_EQ(written(shape, remade), expected);
  EXPECT_EQ(written(shape, remade, {.double_coordinates = true}),
            replaced(expected, "float32 y", "float64 y")
                .replace(expected.find("1 2 3 1 0.1 0"), 13, "1 2 3 1 " + fmt::format("{}", double{0.1f}) + " 0"));
  EXPECT_EQ(text_of(remesh_losses("b.ply", shape)), "list 'extra' is left out\nelement 'edge' is left out\n");
}

TEST(Remeshed, PlyIndicesGetTheTypeThatTheyNeed) {
  Mesh strip;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const std::uint32_t column = i / 2;
    strip.positions.push_back({static_cast<double>(column), static_cast<double>(i % 2), 0});
    if (i >= 2) strip.add_face(std::vector<std::uint32_t>{i, i - 1 - i % 2, i - 2 + i % 2});
  }
  std::string bytes =
      "ply\nformat ascii 1.0\nelement vertex 200\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 198\nproperty list uchar uchar vertex_indices\nend_header\n";
  for (const Vec3d& p : strip.positions) bytes += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  for (std::size_t f = 0; f < 198; ++f) {
    bytes += fmt::format("3 {} {} {}\n", strip.face(f)[0], strip.face(f)[1], strip.face(f)[2]);
  }
  const ShapeFile shape = parse_shape(bytes, "ply", "a.ply");
  const Remade one = split_faces(shape.mesh, [](std::uint32_t f) { return f == 3; });
  EXPECT_NE(written(shape, one).find("list uchar uchar vertex_indices"), std::string::npos);
  const Remade all = split_all(shape.mesh);
  EXPECT_NE(written(shape, all).find("list uchar int vertex_indices"), std::string::npos);
  expect_remade(shape, all, through(shape, all), 0);
}

TEST(Remeshed, ObjFacesStandWhereTheirSourceStood) {
  const std::string text =
      "# head\r\nmtllib a.mtl\r\no thing\r\nv 0 0 0\r\nv 1 0 0\r\nvt 0 0\r\nvt 1 0\r\nvt 0.5 1\r\n# between\r\n"
      "usemtl red\r\ns 1\r\ng left\r\nf 1/1 2/2 3/3\r\nl 1 2 \\\r\n 3\r\nusemtl blue\r\ng right\r\ns off\r\n"
      "f 2 4 3\r\nv 0 1 0 0.5\r\nv 1 1 0\r\n# tail";
  const ShapeFile shape = parse_shape(text, "obj", "a.obj");
  const Remade remade = split_faces(shape.mesh, [](std::uint32_t f) { return f == 0; });
  const Vec3d& m = remade.mesh.positions[4];
  const std::string third = fmt::format("{}", m.x);
  const double uv = double{static_cast<float>(1.0 / 3)};
  const std::string expected =
      "# head\r\nmtllib a.mtl\r\no thing\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 1 1 0\r\nv " + third + " " + third +
      " 0\r\nvt 0 0\r\nvt 1 0\r\nvt 0.5 " + fmt::format("{}\r\nvt 0.5 1\r\n", uv) +
      "# between\r\nusemtl red\r\ns 1\r\ng left\r\nf 1/1 2/2 5/3\r\nf 2/2 3/4 5/3\r\nf 3/4 1/1 5/3\r\n"
      "usemtl blue\r\ng right\r\ns off\r\nf 2 4 3\r\n# tail";
  EXPECT_EQ(written(shape, remade), expected);
  EXPECT_EQ(text_of(remesh_losses("b.obj", shape)), "weights of vertices are left out\nlines 'l' are left out\n");
}

TEST(Remeshed, FacesAreLabelledByWhatKeepsThemTogether) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\ng left\nf 1 2 3\nf 1 3 4\nusemtl blue\nf 1 2 4\n"
      "usemtl red\n# back again\nf 2 3 4\ng right\nf 1 2 3\n";
  EXPECT_EQ(face_labels(parse_shape(text, "obj", "a.obj")), (std::vector<std::uint32_t>{0, 0, 1, 0, 2}));
  EXPECT_TRUE(face_labels(parse_shape("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "off", "a.off")).empty());
}

TEST(Remeshed, ObjMaterialFilesAreFoundAsBefore) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("knead_remeshed_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder / "to");
  const std::string text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
  write_file_atomically(folder / "a.obj", text);
  write_file_atomically(folder / "a.mtl", "newmtl red\n");
  const ShapeFile shape = read_shape(folder / "a.obj");
  const Remade remade = split_all(shape.mesh);
  write_remeshed(folder / "to/b.obj", shape, remade.mesh, remade.face_source);
  EXPECT_EQ(copy_material_files(shape, folder / "a.obj", folder / "to/b.obj").size(), 1u);
  const ShapeFile back = read_shape(folder / "to/b.obj");
  expect_remade(shape, remade, back, 0);
  EXPECT_EQ(detail::layout_of<detail::obj::Layout>(back).material_files,
            detail::layout_of<detail::obj::Layout>(shape).material_files);
  std::filesystem::remove_all(folder);
}

TEST(Remeshed, StlKeepsItsHeaderBitsAndSpelling) {
  const std::string binary = binary_stl_sample("solid of bytes") + "end";
  const ShapeFile shape = parse_shape(binary, "stl", "a.stl");
  const Remade remade = split_all(shape.mesh);
  const std::string bytes = written(shape, remade);
  EXPECT_EQ(bytes.substr(0, 80), binary.substr(0, 80));
  EXPECT_EQ(bytes.substr(bytes.size() - 3), "end");
  EXPECT_EQ(bytes.size(), 84u + 6 * 50 + 3);
  EXPECT_EQ(bytes.substr(84 + 3 * 50, 12), std::string(12, '\0'));  // the second one's normal is zero
  const ShapeFile text = parse_shape(
      "solid a b\n facet normal 0 0 -1.0\n  outer loop\n   vertex 0.00 0 0\n   vertex 3 0 0\n   vertex 0 3 0\n"
      "  endloop\n endfacet\n facet normal 0 0 1.0 outer loop\tvertex 3 0 0 vertex 3 3 0 vertex 0 3 0 endloop "
      "endfacet\n"
      "endsolid a b\n",
      "stl", "a.stl");
  const Remade half = split_faces(text.mesh, [](std::uint32_t f) { return f == 0; });
  const std::string facet = " facet normal 0 0 -1.0\n  outer loop\n   vertex ";
  const std::string end = "\n   vertex 1 1 0\n  endloop\n endfacet\n";
  EXPECT_EQ(written(text, half), "solid a b\n" + facet + "0.00 0 0\n   vertex 3 0 0" + end + facet +
                                     "3 0 0\n   vertex 0 3 0" + end + facet + "0.00 3 0\n   vertex 0 0 0" + end +
                                     " facet normal 0 0 1.0 outer loop\tvertex 3 0 0 vertex 3 3 0 vertex 0 3 0 endloop "
                                     "endfacet\nendsolid a b\n");
}

TEST(Remeshed, OffKeepsItsKeywordAndOrder) {
  const ShapeFile text = parse_shape(
      "# made by hand\nCOFF\n3 1 0\n0 0 0 10 20 30\n1 0 0 10 20 30\n0 1 0 10 20 60\n3 0 1 2 0.5 0.5 1.0\nmore", "off",
      "a.off");
  Remade remade = split_all(text.mesh);
  remade.mesh.positions[3] = {0.25, 0.25, 0};
  EXPECT_EQ(written(text, remade),
            "# made by hand\nCOFF\n4 3 0\n0 0 0 10 20 30\n1 0 0 10 20 30\n0 1 0 10 20 60\n0.25 0.25 0 10 20 40\n"
            "3 0 1 3 0.5 0.5 1.0\n3 1 2 3 0.5 0.5 1.0\n3 2 0 3 0.5 0.5 1.0\nmore");
  for (const std::endian order : {std::endian::big, std::endian::little}) {
    const ShapeFile binary = parse_shape(binary_off_sample(order, order == std::endian::big), "off", "a.off");
    const ShapeFile back = through(binary, split_all(binary.mesh));
    EXPECT_EQ(detail::layout_of<detail::off::Layout>(back).order, order);
    EXPECT_EQ(detail::layout_of<detail::off::Layout>(back).color_counts, order == std::endian::big);
  }
  const ShapeFile ended = parse_shape(binary_off_sample(std::endian::big, true) + "\x01\x02", "off", "a.off");
  EXPECT_EQ(text_of(remesh_losses("a.off", ended)),
            "2 bytes after the last face are left out\n1 face has fewer than three vertices and is left out\n");
  expect_remade(ended, split_all(ended.mesh), through(ended, split_all(ended.mesh)), 0);
  const ShapeFile odd = parse_shape("COFF\n3 1 0\n0 0 0 1 2 3 # c\n1 0 0 1 2 3\n0 1 0 1 2 999\n3 0 1 2\n", "off", "a");
  EXPECT_EQ(text_of(remesh_losses("a.off", odd)),
            "numbers that are not colors of one kind are left out\ncomments after the counts are left out\n");
  expect_remade(odd, split_all(odd.mesh), through(odd, split_all(odd.mesh)), 0);
}

}  // namespace
}  // namespace knead::remeshed_test
