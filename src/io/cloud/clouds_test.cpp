// PCD and PTX, and the extensions of point files.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "math/system.h"
#include "support/shape_text.h"

namespace knead::clouds_test {
namespace {

TEST(Pcd, TextWithNormalsColorsAndOtherFields) {
  const ShapeFile shape = parse_shape(pcd_samples()[1].bytes, "pcd", "a.pcd");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{5, 6, 7}, {1, 2, 3}}));
  EXPECT_EQ(vertex_normals_of(shape), (std::vector<Vec3d>{{0, 0, 1}, {0, 1, 0}}));
  ASSERT_NE(shape.mesh.find_attribute("color"), nullptr);
  EXPECT_EQ(shape.mesh.find_attribute("color")->components, 3);
  EXPECT_EQ(shape.mesh.find_attribute("id")->values, (std::vector<double>{9, 8}));
  EXPECT_EQ(shape.mesh.find_attribute("hist"), nullptr);
  EXPECT_EQ(text_of(conversion_losses("a.ply", shape)), "field 'hist' is left out\n");
}

TEST(Pcd, OnlyWordsThatChangeAreReplaced) {
  const std::string text = pcd_samples()[1].bytes;
  const ShapeFile shape = parse_shape(text, "pcd", "a.pcd");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1].y = 0.1;
  const std::vector<Vec3d> normals{{0, 0, 1}, {0.6, 0.8, 0}};
  const std::string expected = replaced(text, "0 1 -1.7e38 2 1 3 0", "0.6 1 -1.7e38 0.1 0.8 3 0");
  EXPECT_EQ(serialize_shape("pcd", shape, positions, {.normals = normals}), expected);
}

TEST(Pcd, BinaryPackedColorsAndPointsWithoutAPlace) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 2, 3}, {4, 5, 6}};
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 3, {1, 2, 3, 4, 5, 6, 255, 254, 253}});
  std::string bytes = serialize_mesh("pcd", mesh);
  EXPECT_NE(bytes.find("FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n"), std::string::npos);
  EXPECT_EQ(parse_shape(bytes, "pcd", "a").mesh.attributes, mesh.attributes);
  const std::size_t begin = bytes.find("DATA binary\n") + 12;
  bytes.replace(begin + 16, 4, std::string("\0\0\xc0\x7f", 4));  // NaN
  const ShapeFile shape = parse_shape(bytes, "pcd", "a");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {4, 5, 6}}));
  EXPECT_EQ(shape.mesh.attributes[0].values, (std::vector<double>{1, 2, 3, 255, 254, 253}));
  EXPECT_NE(text_of(shape.notes).find("1 vertex has coordinates that are not finite"), std::string::npos);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1].x = -4;
  std::string expected = bytes;
  expected[begin + 32 + 3] = '\xc0';
  EXPECT_EQ(serialize_shape("pcd", shape, positions), expected);
}

std::string pcd_with_color(const std::string& field, const std::string& type, const std::string& rows) {
  return "VERSION 0.7\nFIELDS x y z " + field + "\nSIZE 4 4 4 4\nTYPE F F F " + type +
         "\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n" + rows;
}

std::vector<double> colors_of(const std::string& bytes) {
  return parse_shape(bytes, "pcd", "a.pcd").mesh.find_attribute("color")->values;
}

TEST(Pcd, ColorsOfTypeFAreBitsOrWholeNumbers) {
  const std::vector<double> three{255, 0, 0, 0, 255, 0, 0, 0, 255};
  EXPECT_EQ(colors_of(pcd_with_color("rgb", "F", "0 0 0 16711680\n1 0 0 65280\n0 1 0 255\n")), three);
  EXPECT_EQ(colors_of(pcd_with_color("rgb", "F", "0 0 0 4294901760\n1 0 0 4278255360\n0 1 0 4278190335\n")), three);
  EXPECT_EQ(colors_of(pcd_with_color("rgb", "F", "0 0 0 -65536\n1 0 0 -16711936\n0 1 0 -16776961\n")), three);
  EXPECT_EQ(colors_of(pcd_with_color("rgb", "U", "0 0 0 16711680\n1 0 0 65280\n0 1 0 255\n")), three);
  // The floats whose bits are 00ff0000, 0000ff00 and 000000ff.
  EXPECT_EQ(colors_of(pcd_with_color("rgb", "F", "0 0 0 2.3418052e-38\n1 0 0 9.1476764e-41\n0 1 0 3.57331e-43\n")),
            three);
  EXPECT_EQ(colors_of(pcd_with_color("rgba", "F", "0 0 0 2164195328\n1 0 0 65280\n0 1 0 4278190335\n")),
            (std::vector<double>{255, 0, 0, 128, 0, 255, 0, 0, 0, 0, 255, 255}));
}

TEST(Pcd, BinaryColorsOfTypeF) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 2, 3}};
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 4, {1, 2, 3, 255, 254, 5, 6, 255}});
  const std::string packed = replaced(serialize_mesh("pcd", mesh), "TYPE F F F U", "TYPE F F F F");
  EXPECT_EQ(colors_of(packed), mesh.attributes[0].values);
  std::string whole = packed;
  const float numbers[2] = {16711680.0F, 65280.0F};
  for (std::size_t i = 0; i < 2; ++i) {
    std::memcpy(&whole[whole.find("DATA binary\n") + 12 + 16 * i + 12], &numbers[i], sizeof(float));
  }
  EXPECT_EQ(colors_of(whole), (std::vector<double>{255, 0, 0, 0, 0, 255, 0, 0}));
}

std::string uint32_bytes(std::size_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

// Three points of floats whose columns are 0 0 0, 1 1 1 and 0 1 2, compressed by hand.
TEST(Pcd, CompressedPointsAreReadAndWrittenUncompressed) {
  const std::string one("\0\0\x80\x3f", 4);
  const std::string packed = std::string("\0\0\xe0\x02\0", 5) +       // a zero, 11 times the byte before
                             "\3" + one + std::string("\xc0\3", 2) +  // 1, 8 bytes from 4 back
                             std::string("\3\0\0\0\0", 5) + std::string("\x40\x07", 2) + "\3" +
                             std::string("\0\0\0\x40", 4);
  const std::string header =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA binary";
  const std::string bytes = header + "_compressed\n" + uint32_bytes(packed.size()) + uint32_bytes(36) + packed;
  const ShapeFile shape = parse_shape(bytes, "pcd", "a.pcd");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 1, 0}, {0, 1, 1}, {0, 1, 2}}));
  EXPECT_NE(text_of(shape.notes).find("are compressed and are written uncompressed"), std::string::npos);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1].x = 5;
  const std::string written = serialize_shape("pcd", shape, positions);
  EXPECT_EQ(written.size(), header.size() + 1 + 36);
  EXPECT_EQ(parse_shape(written, "pcd", "b.pcd").mesh.positions, positions);
  for (std::size_t i = header.size() + 12; i < bytes.size(); ++i) {
    EXPECT_NE(refusal(bytes.substr(0, i), "pcd", "a.pcd").find("damaged or cut short"), std::string::npos) << i;
  }
}

TEST(Pcd, ErrorsInOneLine) {
  const std::string text = pcd_samples()[0].bytes;
  const auto error_of = [&](const std::string& from, const std::string& to) {
    return refusal(replaced(text, from, to), "pcd", "a.pcd");
  };
  EXPECT_NE(error_of("DATA ascii", "DATA binary_compressed").find("damaged or cut short"), std::string::npos);
  EXPECT_NE(error_of("POINTS 3", "POINTS 4").find("WIDTH times HEIGHT is not POINTS"), std::string::npos);
  EXPECT_NE(error_of("FIELDS x y z", "FIELDS x y w").find("not one field 'z'"), std::string::npos);
  EXPECT_NE(error_of("TYPE F F F", "TYPE F F I").find("not one field 'z'"), std::string::npos);
  EXPECT_NE(error_of("SIZE 4 4 4", "SIZE 4 4 3").find("3 bytes is not known"), std::string::npos);
  EXPECT_NE(error_of("1 0 1.5", "1 0 1.5 6").find("a.pcd:14: more numbers"), std::string::npos);
  EXPECT_NE(error_of("1 0 1.5", "1 0").find("expected a number"), std::string::npos);
  EXPECT_NE(error_of("VERSION", "VERSO").find("unknown header line"), std::string::npos);
}

TEST(Ptx, PointsStandWhereTheMatrixPutsThem) {
  const std::string text = ptx_samples()[2].bytes;
  const ShapeFile shape = parse_shape(text, "ptx", "a.ptx");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{10, 21, 30.5}, {9, 20, 33.5}}));
  EXPECT_EQ(shape.mesh.find_attribute("intensity")->values, (std::vector<double>{0.5, 0.25}));
  EXPECT_EQ(shape.mesh.find_attribute("color")->values, (std::vector<double>{255, 0, 9, 1, 2, 3}));
  EXPECT_NE(text_of(shape.notes).find("1 direction has no point; its line is kept"), std::string::npos);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] += Vec3d{0, 0, 0.5};
  EXPECT_EQ(serialize_shape("ptx", shape, positions), replaced(text, "0 1 3 0.25", "0 1 3.5 0.25"));
}

TEST(Ptx, ScansTogetherAndWhatIsRefused) {
  const std::string text = ptx_samples()[3].bytes;
  const ShapeFile shape = parse_shape(text, "ptx", "a.ptx");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{1, 5, 0}, {10, 21, 34.5}}));
  EXPECT_NE(text_of(shape.notes).find("2 scans are read as one shape"), std::string::npos);
  EXPECT_NE(refusal(replaced(text, "0 0 1 0\n0 0 0 1", "0 0 0 0\n0 0 0 1"), "ptx", "a").find("has no inverse"),
            std::string::npos);
  EXPECT_NE(refusal("1000000\n1000000\n" + text.substr(4), "ptx", "a.ptx").find("cut short"), std::string::npos);
  EXPECT_THROW(serialize_mesh("ptx", shape.mesh), InvalidInput);
  EXPECT_THROW(conversion_losses("a.ptx", parse_shape("0 0 0\n", "xyz", "a")), InvalidInput);
}

TEST(PointFiles, Extensions) {
  for (const char* extension : {"txt", "asc", "pts", "csv", "xyzn", "xyzrgb", "XYZ"}) {
    EXPECT_EQ(format_of(std::string("scan.") + extension), "xyz");
  }
  EXPECT_EQ(format_of("scan.pcd"), "pcd");
  EXPECT_EQ(format_of("scan.ptx"), "ptx");
  const std::vector<std::string_view> all = shape_extensions();
  EXPECT_NE(std::find(all.begin(), all.end(), "asc"), all.end());
}

ShapeFile parse_points(const std::string& bytes) { return parse_shape(bytes, "xyz", "a.csv"); }

TEST(PointFiles, ColumnsAreTakenByTheirNames) {
  const std::vector<Vec3d> points{{0, 1, 2}, {3.5, 4, 5}};
  for (const char* text : {
           "id,x,y,z\n101,0,1,2\n102,3.5,4,5\n",
           ",x,y,z\n0,0.0,1.0,2.0\n1,3.5,4.0,5.0\n",
           "\"\",\"x\",\"y\",\"z\"\r\n\"a, b\",\"0\",\"1\",\"2\"\r\n\"c\",\"3.5\",\"4\",\"5\"\r\n",
           "time;Z;Y;X\n2026-11-25 10:00:00;2;1;0\n2026-11-25 10:00:01;5;4;3.5\n",
           "t\tX [m]\tY [m]\tZ [m]\n0.1\t0\t1\t2\n0.2\t3.5\t4\t5\n",
           "//Intensity,X,Y,Z\n7,0,1,2\n8,3.5,4,5\n",
           "//X Y Z R\n0 1 2 7\n3.5 4 5 8\n",
           "# id x y z\n1 0 1 2\n2 3.5 4 5\n",
           "2\nid x y z\n1 0 1 2\n2 3.5 4 5\n",
           "Point,Northing,Easting,Height\nP1,1,0,2\nP2,4,3.5,5\n",
           "\"x\" \"y\" \"z\"\n\"1\" 0 1 2\n\"2\" 3.5 4 5\n",
           "\"Points:2\",\"Points:0\",\"Points:1\"\n2,0,1\n5,3.5,4\n",
           "2\na molecule\nO 0 1 2\nH 3.5 4 5\n",
           "2\n\n8 0 1 2\n1 3.5 4 5\n",
           "2\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=id:I:1:species:S:1:pos:R:3\n1 O 0 1 2\n2 H 3.5 4 5\n",
       }) {
    EXPECT_EQ(parse_points(text).mesh.positions, points) << text;
  }
}

TEST(PointFiles, OtherColumnsKeepTheirNames) {
  const ShapeFile shape =
      parse_points("id,x,y,z,B,G,R,nx,ny,nz,what\n5,0,0,0,1,2,3,0,0,1,wall\n,1,0,0,4,5,6,0,1,0,door\n");
  EXPECT_EQ(shape.mesh.find_attribute("id")->values, (std::vector<double>{5, 0}));
  EXPECT_EQ(shape.mesh.find_attribute("color")->values, (std::vector<double>{3, 2, 1, 6, 5, 4}));
  EXPECT_EQ(vertex_normals_of(shape), (std::vector<Vec3d>{{0, 0, 1}, {0, 1, 0}}));
  EXPECT_EQ(shape.mesh.find_attribute("what"), nullptr);
  EXPECT_EQ(shape.notes[0], "a line names the columns: x y z are the columns 2, 3 and 4");
}

TEST(PointFiles, OnlyNumbersOfTheTableAreReplaced) {
  const std::string text = "nz,\"z\",id, y ,x,nx,ny\n1,\"2\",7, 1.50 ,0,0,0\n0,,8,,,0,1\n0,5,9,4,3,1,0\n";
  const ShapeFile shape = parse_points(text);
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 1.5, 2}, {3, 4, 5}}));
  EXPECT_EQ(serialize_shape("xyz", shape, shape.mesh.positions), text);
  const std::vector<Vec3d> positions{{0, 1.5, 2.25}, {3.5, 4, 5}};
  const std::vector<Vec3d> normals{{0, 0, 1}, {0, 0, 1}};
  std::string expected = replaced(text, "\"2\"", "\"2.25\"");
  expected = replaced(expected, "0,5,9,4,3,1,0", "1,5,9,4,3.5,0,0");
  EXPECT_EQ(serialize_shape("xyz", shape, positions, {.normals = normals}), expected);
}

TEST(PointFiles, ColumnsWithoutNamesAreTakenByPositionAndANoteSaysWhich) {
  EXPECT_EQ(parse_points("101,0,1,2\n102,3,4,5\n").notes[0],
            "x y z are the columns 1, 2 and 3; a line with names can say otherwise");
  EXPECT_EQ(parse_points("\"7\",\"0\",\"1\"\n").mesh.positions, (std::vector<Vec3d>{{7, 0, 1}}));
}

TEST(PointFiles, NamesOfOtherColumnsAreRefused) {
  const auto error_of = [](const char* text) { return refusal(text, "xyz", "a.csv"); };
  EXPECT_EQ(error_of("id,lon,lat,height\n1,8.1,50.2,300\n")
                .find("a.csv:1: longitude and latitude are angles, not lengths; project the points"),
            0u);
  EXPECT_NE(error_of("Longitude;Latitude\n8.1;50.2\n").find("longitude and latitude are angles"), std::string::npos);
  EXPECT_NE(error_of("id,x,y\n1,2,3\n").find("none is 'z'"), std::string::npos);
  EXPECT_NE(error_of("id,u,v,w\n1,2,3,4\n").find("no three columns are named x, y and z"), std::string::npos);
  EXPECT_NE(error_of("x;y;z\n0,5;1;2\n").find("write decimals with points, not commas"), std::string::npos);
  EXPECT_NE(error_of("id,x,y,z\n1,2,3\n").find("a.csv:2: the line has no column 4"), std::string::npos);
}

TEST(PointFiles, DecimalCommasAreRefusedWithASentence) {
  for (const char* text : {"0,0 1,5 0,0\n", "1 2 3\n0,5\t1,5\t2,5\n"}) {
    EXPECT_NE(refusal(text, "xyz", "a.txt").find("write decimals with points, not commas"), std::string::npos) << text;
  }
  EXPECT_EQ(refusal("0.5, 1.5, 2.5\n1 ,2 ,3\n", "xyz", "a.csv"), "none");
}

// A file that is removed at the end.
class CloudFile {
 public:
  CloudFile(const std::string& name, const std::string& bytes)
      : path(std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + name)) {
    std::ofstream(path, std::ios::binary) << bytes;
  }
  ~CloudFile() { std::filesystem::remove(path); }
  CloudFile(const CloudFile&) = delete;
  CloudFile& operator=(const CloudFile&) = delete;

  std::filesystem::path path;
};

std::vector<Vec3d> turned(std::span<const Vec3d> points) {
  std::vector<Vec3d> result;
  for (const Vec3d& p : points) result.push_back(p.x > 0.5 ? Vec3d{p.y, -p.x, p.z + 0.125} : p);
  return result;
}

// Read in pieces of any size, a cloud has the points of the whole; written in pieces, it has the bytes.
void expect_the_whole(const std::string& name, const std::string& bytes, std::size_t least = 1) {
  const CloudFile file(name, bytes);
  const std::string format = format_of(file.path);
  const ShapeFile whole = parse_shape(bytes, format, name);
  std::vector<Vec3d> normals = vertex_normals_of(whole);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (whole.mesh.positions[i].x > 0.5) normals[i] = {normals[i].y, -normals[i].x, normals[i].z};
  }
  WriteOptions options;
  options.decimals = 2;
  options.normals = normals;
  const std::string expected = serialize_shape(format, whole, turned(whole.mesh.positions), options);
  for (const std::size_t size : {std::size_t{1}, std::size_t{40}, std::size_t{97}, bytes.size(), 2 * bytes.size()}) {
    if (size < least) continue;
    CloudPieces cloud(file.path, size);
    for (int round = 0; round < 2; ++round) {
      std::vector<Vec3d> points;
      std::string written = cloud.head();
      while (const std::optional<ShapeFile> piece = cloud.next()) {
        const auto first = normals.begin() + static_cast<std::ptrdiff_t>(normals.empty() ? 0 : points.size());
        const std::vector<Vec3d> own(first, normals.empty() ? first : first + std::ssize(piece->mesh.positions));
        options.normals = own;
        points.insert(points.end(), piece->mesh.positions.begin(), piece->mesh.positions.end());
        written += cloud.rows(*piece, serialize_shape(piece->format, *piece, turned(piece->mesh.positions), options));
      }
      EXPECT_EQ(points, whole.mesh.positions) << name << " " << size;
      written += cloud.tail();
      EXPECT_EQ(written, expected) << name << " " << size;
      EXPECT_EQ(cloud.position() + cloud.tail().size(), cloud.size());
      cloud.rewind();
    }
  }
}

TEST(CloudPieces, GiveThePointsAndTheBytesOfTheWhole) {
  expect_the_whole("plain.xyz", "0 0 0\n1.25 0 1\n0.5 -1 3\n9 8 7\n0.75 0.5 0.25");
  expect_the_whole("head.xyz",
                   "# a scan\r\n3\r\nX Y Z I\r\n0 0 0 7\r\n1.25 0 1 8\r\n\r\n# between\r\n0.5 -1 3 9\r\n\r\n\r\n");
  expect_the_whole("comma.csv", "x,y,z\n450000.125,5400000.25,300.5\n450001.125,5400000.25,301.5\n");
  expect_the_whole("id.csv", "2\nid,x,y,z\n1,450000.125,5400000.25,300.5\n2,450001.125,5400000.25,301.5\n");
  expect_the_whole("quotes.csv", "\"\",\"z\",\"y\",\"x\"\n\"1\",\"5\",\"4\",\"3\"\n\"2\",\"1\",\"2\",\"0\"\n");
  expect_the_whole("normals.xyz", "0 0 0 0 0 1\n1.25 0 1 1 0 0\n0.5 -1 3 0 1 0\n9 8 7 0.6 0 0.8\n");
  expect_the_whole("labels.txt",
                   "a 0 0 0 red and long enough to stand in a piece of its own\nb nan 0 0 blue\nc 2 2 2 red\n",
                   97);  // a piece needs a point with a place
  Mesh mesh;
  Attribute normal{"normal", Domain::vertex, NumberType::float32, 3, {}};
  Attribute level{"level", Domain::vertex, NumberType::uint8, 1, {}};
  for (int i = 0; i < 120; ++i) {
    mesh.positions.push_back({0.01 * i, 0.5, -1.0 * i});
    for (const double n : {0.0, 0.0, 1.0}) normal.values.push_back(n);
    level.values.push_back(i);
  }
  mesh.attributes = {normal, level};
  std::string ply = serialize_mesh("ply", mesh);
  const std::size_t faces = ply.find("element face");  // a cloud may declare that it has none
  if (faces == std::string::npos) {
    ply.insert(ply.find("end_header"), "element face 0\nproperty list uchar int vertex_indices\n");
  }
  expect_the_whole("points.ply", ply);
}

TEST(CloudPieces, RefuseWhatIsNoPlainCloud) {
  const auto refusal = [](const std::string& name, const std::string& bytes) -> std::string {
    const CloudFile file(name, bytes);
    try {
      CloudPieces cloud(file.path);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "taken";
  };
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(refusal("p.ply", serialize_mesh("ply", mesh)), "taken");
  EXPECT_NE(refusal("p.ply", serialize_mesh("ply", mesh) + "x").find("bytes follow"), std::string::npos);
  std::string cut = serialize_mesh("ply", mesh);
  cut.pop_back();
  EXPECT_NE(refusal("p.ply", cut).find("cut short"), std::string::npos);
  EXPECT_NE(refusal("p.obj", "v 0 0 0\n").find("neither binary PLY nor"), std::string::npos);
  EXPECT_NE(refusal("p.xyz", "hello\n").find("no row"), std::string::npos);
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  EXPECT_NE(refusal("p.ply", serialize_mesh("ply", mesh)).find("rows of 'face'"), std::string::npos);
}

}  // namespace
}  // namespace knead::clouds_test
