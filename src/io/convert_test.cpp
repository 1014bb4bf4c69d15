// From one format to the other and back.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "math/system.h"
#include "support/shape_text.h"
#include "support/test_meshes.h"

namespace knead::convert_test {
namespace {

ShapeFile through(const std::string& format, const ShapeFile& shape) {
  return parse_shape(serialize_shape(format, shape, shape.mesh.positions), format, "converted." + format);
}

void expect_same_shape(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.face_begin, b.face_begin);
  EXPECT_EQ(a.corner_vertex, b.corner_vertex);
}

// The values of an attribute at every corner, whether it belongs to corners or vertices.
std::vector<double> at_corners(const Mesh& mesh, const std::string& name) {
  std::vector<double> values;
  const Attribute* attribute = mesh.find_attribute(name);
  if (attribute == nullptr) return values;
  const auto n = static_cast<std::size_t>(attribute->components);
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    const std::size_t element = attribute->domain == Domain::corner ? c : mesh.corner_vertex[c];
    for (std::size_t i = 0; i < n; ++i) values.push_back(attribute->values[element * n + i]);
  }
  return values;
}

TEST(Convert, EveryRealShapeThereAndBack) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const char* file :
       {"sphere_642.ply", "spider_762_open.ply", "originals/spider/spider.obj", "originals/pirate_quads_normals_uv.obj",
        "originals/spot_quads_uv.obj", "originals/cube_with_vertexcolors.obj", "originals/negative_indices.obj",
        "originals/suzanne_ngons_normals_uv_ascii.ply", "originals/reference_vertex_colors.ply",
        "originals/fixed_top_face_colors.ply", "originals/float_color_ascii.ply", "originals/cow_tristrips.ply",
        "originals/torus_big_endian_double.ply"}) {
    const ShapeFile shape = read_shape(test_mesh(file));
    const std::string other = shape.format == "ply" ? "obj" : "ply";
    const ShapeFile there = through(other, shape);
    expect_same_shape(there.mesh, shape.mesh);
    expect_same_shape(through(shape.format, there).mesh, shape.mesh);
    const std::vector<double> uv = at_corners(shape.mesh, "uv");
    const std::vector<double> uv_there = at_corners(there.mesh, "uv");
    ASSERT_EQ(uv.size(), uv_there.size()) << file;
    for (std::size_t i = 0; i < uv.size(); ++i)
      EXPECT_EQ(static_cast<float>(uv[i]), static_cast<float>(uv_there[i])) << file;
    if (shape.format == "ply") {
      EXPECT_EQ(at_corners(there.mesh, "normal"), at_corners(shape.mesh, "normal")) << file;
    }
  }
}

TEST(Convert, SaysWhatIsLost) {
  const ShapeFile obj = parse_shape(
      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvn 0 0 1\nvn 1 0 0\nusemtl b\n"
      "f 1//1 2//1 3//1\nf 2//2 4//2 3//2\n",
      "obj", "a.obj");
  EXPECT_TRUE(conversion_losses("x.obj", obj).empty());
  EXPECT_EQ(conversion_losses("x.ply", obj),
            (std::vector<std::string>{"PLY cannot hold 'normal' that differs between the faces at a vertex",
                                      "lines 'mtllib' are left out", "lines 'usemtl' are left out"}));
  const ShapeFile ply = parse_shape(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nproperty float quality\n"
      "property list uchar int links\nelement face 1\nproperty list uchar int vertex_indices\nproperty int id\n"
      "element edge 1\nproperty int a\nend_header\n"
      "0 0 0 255 0 51 9 1 0\n1 0 0 1 2 3 9 1 0\n0 1 0 1 2 3 9 1 0\n3 0 1 2 5\n7\n",
      "ply", "a.ply");
  EXPECT_EQ(conversion_losses("x.obj", ply),
            (std::vector<std::string>{"OBJ cannot hold the alpha of colors", "OBJ cannot hold 'quality'",
                                      "OBJ cannot hold 'id' per face", "list 'links' is left out",
                                      "element 'edge' is left out"}));
  EXPECT_EQ(serialize_shape("obj", ply, ply.mesh.positions).substr(0, 16), "v 0 0 0 1 0 0.2\n");
}

TEST(Convert, NormalsFollowIntoTheOtherFormat) {
  const ShapeFile obj = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", "obj", "a.obj");
  const std::vector<Vec3d> positions{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  const ShapeFile ply = parse_shape(serialize_shape("ply", obj, positions), "ply", "a.ply");
  EXPECT_EQ(ply.mesh.positions, positions);
  EXPECT_NEAR(ply.mesh.find_attribute("normal")->values[0], 1, 1e-7);
}

// The attribute as a file holds it whose numbers have its type.
Attribute as_stored(Attribute attribute) {
  if (attribute.type != NumberType::float32) return attribute;
  for (double& value : attribute.values) value = double{static_cast<float>(value)};
  return attribute;
}

TEST(Convert, AttributesOfTheOtherFormatsGoThroughPly) {
  std::vector<Sample> samples;
  for (const char* format : {"stl", "off", "xyz"}) {
    for (Sample& sample : samples_of(format)) samples.push_back(std::move(sample));
  }
  for (const Sample& sample : samples) {
    const ShapeFile shape = parse_shape(sample.bytes, sample.format, "sample");
    const ShapeFile there = through("ply", shape);
    const ShapeFile back = through(sample.format, there);
    ASSERT_EQ(there.mesh.attributes.size(), shape.mesh.attributes.size()) << sample.bytes;
    for (const Attribute& attribute : shape.mesh.attributes) {
      const auto has_it = [&](const Mesh& mesh) {
        return std::any_of(mesh.attributes.begin(), mesh.attributes.end(),
                           [&](const Attribute& other) { return as_stored(other) == as_stored(attribute); });
      };
      EXPECT_TRUE(has_it(there.mesh)) << attribute.name << " of " << sample.bytes;
      if (attribute.name.substr(0, 6) == "column") continue;  // which a new XYZ file has no place for
      const bool gets_alpha = sample.format == "off" && attribute.name == "color" && attribute.components == 3;
      if (gets_alpha && attribute.domain == Domain::vertex) continue;  // tested with OFF
      EXPECT_TRUE(has_it(back.mesh)) << attribute.name << " of " << sample.bytes;
    }
  }
}

TEST(WriteMesh, EveryAttributeThatPlyHolds) {
  Mesh mesh;
  mesh.positions = {{0.1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1.0 / 3}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  mesh.add_face(std::vector<std::uint32_t>{1, 3, 2});
  mesh.attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, std::vector<double>(12, 0.5)});
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 4, std::vector<double>(16, 200)});
  mesh.attributes.push_back({"uv", Domain::corner, NumberType::float32, 2, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}});
  mesh.attributes.push_back({"part", Domain::face, NumberType::int32, 1, {-3, 4}});
  const std::string bytes = serialize_mesh("ply", mesh, {.double_coordinates = true});
  const ShapeFile shape = parse_shape(bytes, "ply", "made.ply");
  expect_same_shape(shape.mesh, mesh);
  for (const Attribute& attribute : mesh.attributes) {
    ASSERT_NE(shape.mesh.find_attribute(attribute.name), nullptr) << attribute.name;
    EXPECT_EQ(*shape.mesh.find_attribute(attribute.name), attribute);
  }
  const ShapeFile floats = parse_shape(serialize_mesh("ply", mesh), "ply", "made.ply");
  EXPECT_EQ(floats.mesh.positions[0].x, double{0.1f});
  mesh.positions[0].x = 1e60;
  EXPECT_THROW(serialize_mesh("ply", mesh), InvalidInput);
}

TEST(WriteMesh, PolygonsOfManyCorners) {
  for (const std::uint32_t corners : {127u, 128u, 255u, 256u, 1000u}) {
    Mesh mesh;
    std::vector<std::uint32_t> face;
    for (std::uint32_t i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
      face.push_back(i);
    }
    mesh.add_face(face);
    std::vector<double> uv(std::size_t{2} * corners);
    for (std::size_t i = 0; i < uv.size(); ++i) uv[i] = static_cast<double>(i);
    mesh.attributes.push_back({"uv", Domain::corner, NumberType::float32, 2, uv});
    for (const char* format : {"ply", "obj"}) {
      const std::string bytes = serialize_mesh(format, mesh, {.double_coordinates = true});
      const ShapeFile shape = parse_shape(bytes, format, "made");
      expect_same_shape(shape.mesh, mesh);
      EXPECT_EQ(at_corners(shape.mesh, "uv"), uv);
    }
  }
}

TEST(WriteMesh, FilesOfEveryName) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("knead_names_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  for (const char* name : {"-a b, é.PLY", "..%2f..%2fescape.off", "..%2f..%2fescape.obj", "a.Stl", "two.dots.Obj"}) {
    write_mesh(folder / name, mesh);
    const ShapeFile shape = read_shape(folder / name);
    expect_same_shape(shape.mesh, mesh);
    write_shape(folder / name, shape, shape.mesh.positions);
    EXPECT_EQ(file_bytes(folder / name), shape.bytes);
  }
  EXPECT_THROW(write_mesh(folder / "x.step", mesh), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(folder / "x.step"));
  std::filesystem::remove_all(folder);
}

TEST(Convert, WhatAFormatCannotHoldAtAllIsSaidBeforehand) {
  const ShapeFile points = parse_shape("0 0 0\n1 0 0\n", "xyz", "points.xyz");
  const auto complaint = [](const char* path, const ShapeFile& shape) -> std::string {
    try {
      conversion_losses(path, shape);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(
      complaint("out.stl", points),
      "out.stl: a file .stl holds faces, and this shape has none; write .ply, .obj, .glb, .gltf, .off, .xyz or .pcd");
  EXPECT_TRUE(conversion_losses("out.ply", points).empty());
  const ShapeFile mesh = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj", "a.obj");
  for (const char* path : {"out.ptx", "out.msh", "out.bdf", "points"}) {
    EXPECT_NE(complaint(path, mesh).find("; write .ply, .obj, .glb, .gltf, .stl, .3mf or .off"), std::string::npos)
        << path;
  }
  EXPECT_EQ(text_of(conversion_losses("out.xyz", mesh)), "XYZ cannot hold faces\n");
}

// Colors of any type and scale are from 0 to 1, or bytes or shorts, in the other format.
TEST(Convert, ColorsAreScaledByTheGreatest) {
  const auto in_glb = [](const std::string& type, const std::string& rows) {
    std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    for (const char* name : {"red", "green", "blue"}) ply += "property " + type + " " + name + "\n";
    ply += "element face 1\nproperty list uchar int vertex_indices\nend_header\n" + rows + "3 0 1 2\n";
    const ShapeFile source = parse_shape(ply, "ply", "a.ply");
    EXPECT_EQ(serialize_shape("ply", source, source.mesh.positions), ply);
    Attribute color = *through("glb", source).mesh.find_attribute("color");
    EXPECT_EQ(color.components, 3);
    return color;
  };
  const std::string whole = "0 0 0 255 0 0\n1 0 0 0 128 0\n0 1 0 0 0 255\n";
  for (const char* type : {"float", "double", "int", "uchar"}) {
    const Attribute color = in_glb(type, whole);
    EXPECT_EQ(color.type, NumberType::uint8) << type;
    EXPECT_EQ(color.values, (std::vector<double>{255, 0, 0, 0, 128, 0, 0, 0, 255})) << type;
  }
  EXPECT_EQ(in_glb("float", "0 0 0 65535 0 0\n1 0 0 0 257 0\n0 1 0 0 0 1\n").type, NumberType::uint16);
  const Attribute mean = in_glb("float", "0 0 0 127.5 0 0\n1 0 0 0 255 0\n0 1 0 0 0 51\n");
  EXPECT_EQ(mean.type, NumberType::float32);
  EXPECT_NEAR(mean.values[0], 0.5, 1e-6);
  EXPECT_NEAR(mean.values[8], 0.2, 1e-6);
  EXPECT_EQ(in_glb("float", "0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 0\n").values[0], 1);
  // Light brighter than white is white.
  EXPECT_EQ(in_glb("float", "0 0 0 1.5 0 0\n1 0 0 0 0.25 0\n0 1 0 -1 0 0\n").values,
            (std::vector<double>{1, 0, 0, 0, 0.25, 0, 0, 0, 0}));
}

TEST(Convert, NothingIsSaidTwice) {
  const ShapeFile colored =
      parse_shape("COFF\n3 1 0\n0 0 0 1 2 3 4\n1 0 0 1 2 3 4\n0 1 0 1 2 3 4\n3 0 1 2 9 9 9\n", "off", "a.off");
  EXPECT_EQ(colored.mesh.attributes.size(), 2u);
  EXPECT_EQ(conversion_losses("x.stl", colored), (std::vector<std::string>{"STL cannot hold 'color'"}));
}

TEST(Convert, SeamsAreSplitInGlbWithANote) {
  const ShapeFile seam =
      parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 2/2 4/2 3/2\n", "obj", "a.obj");
  EXPECT_EQ(conversion_losses("x.glb", seam).size(), 1u);
  EXPECT_EQ(through("glb", seam).mesh.vertex_count(), 6u);
}

TEST(Decimals, OfAFileAndOfWhatIsWritten) {
  const auto decimals = [](const std::string& text, const std::string& format) {
    return decimals_of(parse_shape(text, format, "a"));
  };
  EXPECT_EQ(decimals("0.1000 0 0\n1.25 0 0\n", "xyz"), 4);
  EXPECT_EQ(decimals("1.25e1 1e-5 0\n0 0 0\n", "xyz"), 5);
  EXPECT_EQ(decimals("1 2 3 0.55555\n4 5 6 0.1\n", "xyz"), 0);
  EXPECT_EQ(decimals("v 0.10 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0.1234 1\nf 1 2 3\n", "obj"), 2);
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  EXPECT_EQ(decimals(serialize_mesh("ply", mesh), "ply"), std::nullopt);
  EXPECT_EQ(decimals(serialize_mesh("stl", mesh), "stl"), std::nullopt);
}

// Every text format: three decimals where a number moved, the old spelling elsewhere, also of what rounds to it.
TEST(Decimals, MovedCoordinatesHaveThemInEveryTextFormat) {
  const std::string pose = "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string pcd = "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n";
  const std::vector<std::array<std::string, 3>> files{{"xyz", "", "0.5 1e0 2\n4 5 6.0\n"},
                                                      {"obj", "v ", "0.5 1e0 2\nv 4 5 6.0\n"},
                                                      {"off", "OFF\n2 0 0\n", "0.5 1e0 2\n4 5 6.0\n"},
                                                      {"ply", ply, "0.5 1e0 2\n4 5 6.0\n"},
                                                      {"pcd", pcd, "0.5 1e0 2\n4 5 6.0\n"},
                                                      {"ptx", pose, "0.5 1e0 2\n4 5 6.0\n"},
                                                      {"su2", "NDIME= 3\nNPOIN= 2\n", "0.5 1e0 2\n4 5 6.0\n"}};
  for (const auto& [format, head, body] : files) {
    SCOPED_TRACE(format);
    const ShapeFile shape = parse_shape(head + body, format, "a");
    std::vector<Vec3d> positions = shape.mesh.positions;
    positions[0] = {1.0 / 3, 1.0001, 2.5};
    EXPECT_EQ(serialize_shape(format, shape, positions, {.decimals = 3}),
              head + replaced(replaced(body, "0.5", "0.333"), " 2\n", " 2.500\n"));
  }
  const ShapeFile stl = parse_shape(
      "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1.0 0 endloop endfacet\nendsolid\n",
      "stl", "a");
  std::vector<Vec3d> positions = stl.mesh.positions;
  positions[1] = {1.23456, 0, 0.98765};
  const std::string text = serialize_shape("stl", stl, positions, {.decimals = 2});
  EXPECT_NE(text.find("vertex 1.23 0 0.99 vertex 0 1.0 0"), std::string::npos) << text;
  EXPECT_NE(text.find("normal -0."), std::string::npos);  // six decimals
  EXPECT_THROW(serialize_shape("stl", stl, positions, {.decimals = 18}), InvalidInput);
  EXPECT_THROW(serialize_shape("stl", stl, positions, {.decimals = -1}), InvalidInput);
}

}  // namespace
}  // namespace knead::convert_test
