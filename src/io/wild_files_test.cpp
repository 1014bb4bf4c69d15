// Files that other programs write and read although the formats' descriptions have no such thing: read with a note,
// kept byte for byte.
#include <gtest/gtest.h>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_promises.h"
#include "support/shape_text.h"

namespace knead::wild_files_test {
namespace {

// A file and a part of the note that is due.
struct Wild {
  const char* name;
  const char* format;
  std::string bytes;
  const char* note;
  std::size_t vertices;
  std::size_t faces;

  friend std::ostream& operator<<(std::ostream& out, const Wild& wild) { return out << wild.name; }
};

const std::string kPlyBeginning =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kPlyVertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

// A PLY text with that element of faces, vertices and faces.
std::string ply(const std::string& faces, const std::string& list, const std::string& rows,
                const std::string& vertices = kPlyVertices) {
  return kPlyBeginning + "element face " + faces + "\nproperty list " + list + "\nend_header\n" + vertices + rows;
}

std::string ply_with_bytes(const std::string& type, const std::vector<std::string>& indices) {
  std::string bytes = replaced(ply("1", "uchar " + type + " vertex_indices", "", ""), "ascii", "binary_little_endian");
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  bytes += '\3';
  for (const std::string& index : indices) bytes += index;
  return bytes;
}

template <class T>
std::string bytes_of(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

// Four points, the second seen by no scanner, in binary; and a face that does not use it.
std::string organised_ply() {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  std::string bytes = replaced(ply("1", "uchar int vertex_indices", "", ""), "ascii", "binary_little_endian");
  bytes = replaced(bytes, "property float z\n",
                   "property float z\nproperty uchar red\nproperty uchar green\n"
                   "property uchar blue\n");
  const float rows[4][3] = {{0, 0, 0}, {nan, infinity, 5}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 4; ++i) {
    for (const float number : rows[i]) bytes += bytes_of(number);
    bytes += std::string(3, static_cast<char>('a' + i));
  }
  return bytes + '\3' + bytes_of(std::int32_t{0}) + bytes_of(std::int32_t{2}) + bytes_of(std::int32_t{3});
}

const std::string kFacet = " facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet";
const std::string kOtherFacet =
    " facet normal 0 0 1 outer loop vertex 1 0 0 vertex 1 1 0 vertex 0 1 0 endloop endfacet";

// A binary STL of two triangles that declares so many.
std::string binary_stl(std::uint32_t declared) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  mesh.add_face(std::vector<std::uint32_t>{0, 2, 3});
  std::string bytes = serialize_mesh("stl", mesh);
  return bytes.replace(80, 4, bytes_of(declared));
}

std::vector<Wild> wild_ply() {
  const std::string face = "3 0 1 2\n";
  const auto named = [&](const std::string& name) { return ply("1", "uchar int " + name, face); };
  const std::string sound = named("vertex_indices");
  const std::string points = replaced(replaced(sound, face, ""), "element face 1", "element face 0");
  return {
      {"SurplusOfFaces", "ply", ply("2", "uchar int vertex_indices", "3 0 1 2 0.5 0.5 255\n3 0 1 3 7\n"),
       "2 lines have more numbers than the header declares", 4, 2},
      {"SurplusOfVertices", "ply", ply("1", "uchar int vertex_indices", face, "0 0 0 9\n1 0 0\n0 1 0 8 7\n0 0 1\n"),
       "2 lines have more numbers", 4, 1},
      {"VertexIndexes", "ply", named("vertex_indexes"), "the list 'vertex_indexes' is read", 4, 1},
      {"Indices", "ply", named("indices"), "the list 'indices' is read", 4, 1},
      {"Int64", "ply", replaced(sound, "uchar int", "uint64 int64"), "", 4, 1},
      {"Int64Binary", "ply",
       ply_with_bytes("int64", {bytes_of<std::int64_t>(0), bytes_of<std::int64_t>(2), bytes_of<std::int64_t>(3)}), "",
       4, 1},
      {"Uint64Binary", "ply",
       ply_with_bytes("uint64", {bytes_of<std::uint64_t>(0), bytes_of<std::uint64_t>(2), bytes_of<std::uint64_t>(3)}),
       "", 4, 1},
      {"Int64Property", "ply",
       replaced(ply("1", "uchar int vertex_indices", face, "0 0 0 9007199254740993\n1 0 0 1\n0 1 0 -2\n0 0 1 3\n"),
                "property float z\n", "property float z\nproperty int64 time\n"),
       "", 4, 1},
      {"ByteOrderMark", "ply", "\xef\xbb\xbf" + sound, "byte order mark", 4, 1},
      {"HashLines", "ply", replaced(sound, "element vertex", "# by hand\n#\nelement vertex"), "begin with #", 4, 1},
      {"FloatIndices", "ply", replaced(sound, "uchar int", "uchar float"), "have the type float", 4, 1},
      {"FloatIndicesBinary", "ply", ply_with_bytes("float", {bytes_of(0.f), bytes_of(2.f), bytes_of(3.f)}),
       "have the type float", 4, 1},
      {"NanUnused", "ply", ply("1", "uchar int vertex_indices", face, "0 0 0\n1 0 0\n0 1 0\nnan -1.#IND 1\n"),
       "1 vertex has coordinates that are not finite", 3, 1},
      {"NanPoints", "ply", replaced(points, kPlyVertices, "nan nan nan\n1 0 0\n0 1 inf\n0 0 1\n"),
       "2 vertices have coordinates that are not finite", 2, 0},
      {"NanBinary", "ply", organised_ply(), "1 vertex has coordinates that are not finite", 3, 1},
  };
}

std::vector<Wild> wild_obj() {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  return {
      {"NoNormals", "obj", v + "f 1//1 2//1 3//1\nf 1//2 2//2 4//2\n", "normals, of which the file has none", 4, 2},
      {"NoTextures", "obj", v + "f 1/1 2/2 3/3\n", "texture coordinates, of which the file has none", 4, 1},
      {"NoTexturesFromTheEnd", "obj", v + "vn 0 0 1\nf -4/-3/1 -3/-2/1 -2/-1/1\n", "of which the file has none", 4, 1},
      {"EndZeros", "obj", v + "f 1 2 3" + std::string(5, '\0'), "5 zero bytes end the file", 4, 1},
      {"NanUnused", "obj", "v 0 0 0 1 0 0\nv nan 0 0 0 1 0\nv 1 0 0 0 0 1\nv 0 1 0 1 1 1\nf 1 3 4\n",
       "1 vertex has coordinates that are not finite", 3, 1},
  };
}

std::vector<Wild> wild_stl() {
  const std::string split = replaced(replaced(kFacet, "endloop", "end loop"), "endfacet", "END  FACET");
  return {
      {"NoEndsolid", "stl", "solid a\n" + kFacet + "\n", "ends without 'endsolid'", 3, 1},
      {"OneLine", "stl", "solid a name" + kFacet + kOtherFacet + " endsolid a name", "on the line of its solid's name",
       4, 2},
      {"TwoOnOneLine", "stl", "solid a" + kFacet + " endsolid a solid solid b" + kOtherFacet + " endsolid",
       "on the line of its solid's name", 4, 2},
      {"Colors", "stl",
       "solid\ncolor 1 0.5 0\n" + replaced(kFacet, "outer", "color 1 0 0\nouter") + "\ncolor 0 0 1\nendsolid\n",
       "lines 'color' are kept", 3, 1},
      {"SplitWords", "stl", "solid\n" + split + "\nend solid\nsolid\n" + kOtherFacet + "\nendsolid",
       "'end loop' and the like", 4, 2},
      {"EndZeros", "stl", "solid a\n" + kFacet + "\nendsolid a" + std::string(200, '\0'), "200 zero bytes", 3, 1},
      {"NoTriangles", "stl", binary_stl(0), "declares 0 triangles; the 2 that fill", 4, 2},
      {"AllTriangles", "stl", binary_stl(0xffffffff), "declares 4294967295 triangles; the 2 that fill", 4, 2},
  };
}

std::vector<Wild> wild_off() {
  return {
      {"LowerCase", "off", "off\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "in lower case", 3, 1},
      {"MixedCase", "off", "COff\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n", "in lower case", 3,
       1},
      {"LowerCaseNormals", "off",
       "cnoff 3 1\n0 0 0 0 0 1 0.5 0 0 1\n1 0 0 0 0 1 0 0 1 1\n0 1 0 0 0 1 0 0 0 1\n3 0 1 2\n", "in lower case", 3, 1},
      {"HexadecimalFaces", "off", "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 0xff8000\n3 1 3 2 0x0000FF\n",
       "colors are in hexadecimal", 4, 2},
      {"HexadecimalVertices", "off", "COFF\n3 1 0\n0 0 0 0xff000080\n1 0 0 0x00ff0080\n0 1 0 0x0000ff80\n3 0 1 2\n",
       "colors are in hexadecimal", 3, 1},
  };
}

std::vector<Wild> wild_clouds() {
  return {
      {"Names", "xyz", "X Y Z\n0 0 0\n1 0 0\n", "names the columns", 2, 0},
      {"NamesByCommas", "xyz", "# c\n\"x\",\"y\",\"z\",\"label\"\n0,0,0,tree\n1,0.25,0,stone\n", "names the columns", 2,
       0},
      {"NamesInAComment", "xyz", "//X Y Z Scalar_field\n0 0 0 0.5\n1 0 0 0.25\n", "point cloud", 2, 0},
      {"CountAndNames", "xyz", "2\nx y z\n0 0 0\n1 0 0\n", "names the columns", 2, 0},
      {"NanRows", "xyz", "nan nan nan 7\n0 0 0 1\n1 nan 0 2\n1 0 0 3\n", "2 vertices have coordinates that are not", 2,
       0},
      {"LabelsLast", "xyz", "0 0 0 a 0 0 1\n1 0 0 b 0 0 1\n", "words that are no numbers", 2, 0},
      {"LabelsFirst", "xyz", "p1 0 0 0\n17 1 0 0\np3 nan 0 0\n", "words that are no numbers", 2, 0},
      {"Percents", "xyz", "% of MATLAB\n0 0 0\n1 0 0 % here\n", "point cloud", 2, 0},
  };
}

class WildFile : public testing::TestWithParam<Wild> {};

TEST_P(WildFile, IsReadWithANoteAndKeptByteForByte) {
  const Wild& wild = GetParam();
  const ShapeFile shape = parse_shape(wild.bytes, wild.format, "wild");
  EXPECT_EQ(shape.mesh.vertex_count(), wild.vertices);
  EXPECT_EQ(shape.mesh.face_count(), wild.faces);
  EXPECT_NE(text_of(shape.notes).find(wild.note), std::string::npos) << text_of(shape.notes);
  EXPECT_EQ(serialize_shape(wild.format, shape, shape.mesh.positions), wild.bytes);
}

// Moved, it is read back as moved: in its own format, in every other, and remeshed.
TEST_P(WildFile, KeepsThePromisesOfAllFiles) {
  const Wild& wild = GetParam();
  EXPECT_EQ(broken_promise(parse_shape(wild.bytes, wild.format, "wild")), "");
}

// Only numbers of vertices differ: with these taken out, the moved file is the same.
TEST_P(WildFile, OneVertexMovedChangesNoOther) {
  const Wild& wild = GetParam();
  const ShapeFile shape = parse_shape(wild.bytes, wild.format, "wild");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] += Vec3d{0.25, 0.5, 0.125};
  const ShapeFile back = parse_shape(serialize_shape(wild.format, shape, positions), wild.format, "moved");
  EXPECT_EQ(back.notes, shape.notes);
  EXPECT_EQ(back.mesh.positions, positions);
  EXPECT_EQ(back.mesh.corner_vertex, shape.mesh.corner_vertex);
}

TEST_P(WildFile, DamagedIsRefusedInOneLineOrSound) {
  const Wild& wild = GetParam();
  const auto check = [&](const std::string& bytes) {
    try {
      ASSERT_EQ(broken_promise(parse_shape(bytes, wild.format, "damaged")), "") << bytes;
    } catch (const InvalidInput& error) {
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  };
  for (std::size_t i = 0; i < wild.bytes.size(); ++i) {
    check(wild.bytes.substr(0, i));
    std::string bytes = wild.bytes;
    for (const char value : {'\0', '\n', ' ', '9', '-', ',', 'x', '\xff'}) {
      bytes[i] = value;
      check(bytes);
    }
    check(std::string(wild.bytes).erase(i, 1));
  }
}

std::string test_name(const testing::TestParamInfo<Wild>& parameter) { return parameter.param.name; }

INSTANTIATE_TEST_SUITE_P(Ply, WildFile, testing::ValuesIn(wild_ply()), test_name);
INSTANTIATE_TEST_SUITE_P(Obj, WildFile, testing::ValuesIn(wild_obj()), test_name);
INSTANTIATE_TEST_SUITE_P(Stl, WildFile, testing::ValuesIn(wild_stl()), test_name);
INSTANTIATE_TEST_SUITE_P(Off, WildFile, testing::ValuesIn(wild_off()), test_name);
INSTANTIATE_TEST_SUITE_P(Clouds, WildFile, testing::ValuesIn(wild_clouds()), test_name);

}  // namespace
}  // namespace knead::wild_files_test
