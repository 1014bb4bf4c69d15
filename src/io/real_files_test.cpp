// Files as real programs write them.
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_promises.h"
#include "support/test_meshes.h"

namespace knead::real_files_test {
namespace {

struct Original {
  const char* file;
  std::size_t vertices, triangles;
  bool closed;
  double volume;

  friend std::ostream& operator<<(std::ostream& out, const Original& original) { return out << original.file; }
};

const Original kOriginals[] = {
    {"spider/spider.obj", 762, 1368, false, 0},
    {"pirate_quads_normals_uv.obj", 2889, 5010, false, 0},
    {"spot_quads_uv.obj", 2930, 5856, true, 0.717887},
    {"fuze.obj", 502, 1000, true, 0.000606689},
    {"cube_with_vertexcolors.obj", 8, 12, true, 1},
    {"concave_polygon.obj", 64, 64, false, 0},
    {"negative_indices.obj", 8, 12, true, 8},
    {"dragon_res4_ascii.ply", 5205, 11102, true, 0.000469288},
    {"suzanne_ngons_normals_uv_ascii.ply", 1966, 968, false, 0},
    {"reference_vertex_colors.ply", 845, 1610, false, 0},
    {"fixed_top_face_colors.ply", 2374, 4772, true, 26449.3},
    {"float_color_ascii.ply", 3, 1, false, 0},
    {"cow_tristrips.ply", 2903, 5804, true, 53.5674},
    {"torus_big_endian_double.ply", 2304, 4608, true, 1.21878},
    {"icosahedron_ascii.stl", 12, 20, true, 2.53615},
    {"icosahedron_binary.stl", 12, 20, true, 2.53615},
    {"spider_ascii.stl", 722, 1368, false, 0},
    {"spider_binary.stl", 722, 1368, false, 0},
    {"featuretype_binary.stl", 1722, 3476, true, 11.6277},
    {"fandisk_quads.off", 766, 1528, true, 20.2575},
    {"cow.off", 2762, 5520, true, 0.0534799},
    {"fairing_cross_binary.off", 4983, 9762, false, 0},
};

class OriginalFile : public testing::TestWithParam<Original> {};

TEST_P(OriginalFile, ReadsAsPublished) {
  const std::string file = std::string("originals/") + GetParam().file;
  KNEAD_NEEDS_TEST_MESH(file);
  const ShapeFile shape = read_shape(test_mesh(file));
  const Measures m = measure(shape.mesh);
  EXPECT_EQ(m.vertices, GetParam().vertices);
  EXPECT_EQ(m.triangles, GetParam().triangles);
  EXPECT_EQ(m.closed(), GetParam().closed);
  if (GetParam().closed) {
    EXPECT_NEAR(m.volume, GetParam().volume, 2e-5 * GetParam().volume);  // quads may be cut along the other diagonal
  }
}

std::string original_name(const testing::TestParamInfo<Original>& parameter) {
  std::string name = parameter.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Originals, OriginalFile, testing::ValuesIn(kOriginals), original_name);

bool is_bad(const std::filesystem::path& path) { return path.parent_path().filename() == "bad"; }

std::vector<std::filesystem::path> every_shape() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test_mesh(""))) {
    const std::string extension = entry.path().extension().string();
    const bool is_shape =
        extension == ".ply" || extension == ".obj" || extension == ".stl" || extension == ".off" || extension == ".glb";
    if (is_shape) paths.push_back(entry.path());
  }
  return paths;
}

TEST(RealFiles, WithNothingMovedEveryByteStays) {
  KNEAD_NEEDS_TEST_MESH("originals");
  std::size_t written = 0;
  for (const auto& path : every_shape()) {
    try {
      const ShapeFile shape = read_shape(path);
      const std::string bytes =
          serialize_shape(shape.format, shape, shape.mesh.positions, {.double_coordinates = true});
      EXPECT_TRUE(bytes == file_bytes(path)) << path;
      ++written;
    } catch (const InvalidInput&) {
      EXPECT_TRUE(is_bad(path)) << path;
    }
  }
  EXPECT_GE(written, 50u);
}

// Every third vertex moves to what any number type can hold exactly; the rest of the file stays.
TEST(RealFiles, WhatIsWrittenReadsBackAndNothingElseChanges) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const auto& path : every_shape()) {
    if (is_bad(path) || std::filesystem::file_size(path) > 3'000'000) continue;
    const ShapeFile shape = read_shape(path);
    if (shape.format == "glb") continue;  // its floats stand in the coordinates of nodes: glb_rewrite_test
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (std::size_t i = 0; i < positions.size(); i += 3) {
      const Vec3d& p = positions[i];
      positions[i] = {std::floor(p.x * 64) / 64, std::floor(p.y * 8), p.z};
    }
    Mesh moved = shape.mesh;
    moved.positions = positions;
    for (const bool as_doubles : {false, true}) {
      const std::string bytes = serialize_shape(shape.format, shape, positions, {.double_coordinates = as_doubles});
      const ShapeFile back = parse_shape(bytes, shape.format, "back");
      if (shape.format == "stl") {  // vertices that fall together are welded
        EXPECT_EQ(difference(moved, back, holds_floats(shape)), "") << path;
        continue;
      }
      EXPECT_EQ(back.mesh.positions, positions) << path;
      EXPECT_EQ(back.mesh.face_begin, shape.mesh.face_begin) << path;
      EXPECT_EQ(back.mesh.corner_vertex, shape.mesh.corner_vertex) << path;
      EXPECT_EQ(back.notes, shape.notes) << path;
      ASSERT_EQ(back.mesh.attributes.size(), shape.mesh.attributes.size()) << path;
      for (std::size_t a = 0; a < shape.mesh.attributes.size(); ++a) {
        if (shape.mesh.attributes[a].name == "normal") continue;
        EXPECT_EQ(back.mesh.attributes[a], shape.mesh.attributes[a]) << path;
      }
      // And the way back gives the source's bytes again where numbers have one spelling.
      const ShapeFile again =
          parse_shape(serialize_shape(shape.format, back, shape.mesh.positions), shape.format, "again");
      EXPECT_EQ(again.mesh.positions, shape.mesh.positions) << path;
    }
  }
}

TEST(RealFiles, EveryPromiseIsKeptInEveryFormat) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const auto& path : every_shape()) {
    if (path.string().find("/originals/") == std::string::npos) continue;
    EXPECT_EQ(broken_promise(read_shape(path)), "") << path;
  }
}

// The words of a text and what stands between them, in turn.
std::vector<std::string> pieces(const std::string& text) {
  std::vector<std::string> pieces(1);
  bool in_word = false;
  for (const char c : text) {
    const bool is_gap = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (is_gap == in_word) pieces.emplace_back();
    in_word = !is_gap;
    pieces.back() += c;
  }
  return pieces;
}

// Nothing differs but words that may, by their number.
void expect_changed(const std::string& before, const std::string& after, const std::vector<bool>& may_change) {
  const std::vector<std::string> from = pieces(before);
  const std::vector<std::string> to = pieces(after);
  ASSERT_EQ(from.size(), to.size());
  ASSERT_LE(may_change.size(), from.size() / 2);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const bool is_word = i % 2 == 1;
    if (!is_word || i / 2 >= may_change.size() || !may_change[i / 2]) {
      EXPECT_EQ(to[i], from[i]) << i;
    }
  }
}

TEST(RealFiles, InTextNoOtherWordChanges) {
  KNEAD_NEEDS_TEST_MESH("originals");
  const auto moved_x = [](const ShapeFile& shape) {
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (std::size_t i = 0; i < positions.size(); i += 7) positions[i].x += 0.3;
    return positions;
  };
  for (const char* file : {"originals/cow.off", "originals/fandisk_quads.off"}) {
    const ShapeFile off = read_shape(test_mesh(file));
    std::vector<bool> may_change(4 + 3 * off.mesh.vertex_count(), false);
    for (std::size_t i = 0; i < off.mesh.vertex_count(); i += 7) may_change[4 + 3 * i] = true;
    expect_changed(off.bytes, serialize_shape("off", off, moved_x(off)), may_change);
  }
  const ShapeFile stl = read_shape(test_mesh("originals/spider_ascii.stl"));
  std::vector<bool> may_change(2 + 21 * stl.mesh.face_count(), false);
  for (std::size_t c = 0; c < stl.mesh.corner_vertex.size(); ++c) {
    if (stl.mesh.corner_vertex[c] % 7 != 0) continue;
    const std::size_t facet = 2 + 21 * (c / 3);
    for (std::size_t axis = 0; axis < 3; ++axis) may_change[facet + 2 + axis] = true;  // the normal
    may_change[facet + 8 + 4 * (c % 3)] = true;                                        // x
  }
  expect_changed(stl.bytes, serialize_shape("stl", stl, moved_x(stl)), may_change);
}

}  // namespace
}  // namespace knead::real_files_test
