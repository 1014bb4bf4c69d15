// Broken and hostile files: each is refused with one clear line, or read as its description says.
#include <gtest/gtest.h>

#include <optional>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/test_meshes.h"

namespace knead::bad_files_test {
namespace {

struct Refused {
  const char* file;
  std::size_t line;  // named in the message; 0: none, or a byte
  const char* says;

  friend std::ostream& operator<<(std::ostream& out, const Refused& refused) { return out << refused.file; }
};

const Refused kRefused[] = {
    {"garbage.ply", 1, "ply"},
    {"obj_empty.obj", 0, "no vertices"},
    {"obj_exponent_overflow.obj", 7, "does not fit"},
    {"obj_face_without_vertices.obj", 1, "out of range"},
    {"obj_index_out_of_range.obj", 28, "out of range"},
    {"obj_index_zero.obj", 0, "out of range"},
    {"obj_utf16_big_endian.obj", 1, "UTF-16"},
    {"off_claims_353_billion_vertices.off", 2, "353535235358 vertices are declared"},
    {"off_index_equals_count.off", 22, "a vertex index is '8', more than 7"},
    {"ply_body_cut_in_vertices.ply", 0, "cut short"},
    {"ply_claims_4_billion_vertices.ply", 0, "cut short"},
    {"ply_faces_missing_ascii.ply", 0, "cut short"},
    {"ply_header_cut_fuzzed.ply", 0, ""},
    {"ply_index_negative.ply", 0, "vertex index -1"},
    {"ply_index_out_of_range.ply", 0, "vertex index 8"},
    {"ply_list_count_huge.ply", 0, "4294967280"},
    {"ply_nan_coordinate.ply", 0, "not finite"},
    {"ply_vertex_count_too_small.ply", 0, ""},
    {"stl_ascii_cut.stl", 69, "cut short"},
    {"stl_binary_count_too_large.stl", 0, "2147483647 triangles are declared"},
};

class RefusedFile : public testing::TestWithParam<Refused> {};

TEST_P(RefusedFile, IsRefusedInOneLine) {
  const Refused& refused = GetParam();
  const std::string file = std::string("bad/") + refused.file;
  KNEAD_NEEDS_TEST_MESH(file);
  try {
    read_shape(test_mesh(file));
    FAIL() << "was read";
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_NE(message.find(refused.file), std::string::npos) << message;
    EXPECT_NE(message.find(refused.says), std::string::npos) << message;
    if (refused.line > 0) {
      EXPECT_NE(message.find(":" + std::to_string(refused.line) + ":"), std::string::npos) << message;
    }
  }
}

template <class T>
std::string file_name(const testing::TestParamInfo<T>& parameter) {
  const std::string file = parameter.param.file;
  return file.substr(0, file.find('.'));
}

INSTANTIATE_TEST_SUITE_P(Bad, RefusedFile, testing::ValuesIn(kRefused), file_name<Refused>);

struct Accepted {
  const char* file;
  std::size_t vertices, triangles;
  std::optional<double> volume;
  const char* note = nullptr;  // part of a note, where one is due

  friend std::ostream& operator<<(std::ostream& out, const Accepted& accepted) { return out << accepted.file; }
};

const Accepted kAccepted[] = {
    {"odd_name_dash_spaces_unicode.obj", 8, 12, 1.0},
    {"odd_name_percent_encoded_path.off", 8, 12, 1.0},
    {"obj_deep_negative_indices.obj", 400, 600, 50.0},
    {"obj_face_with_two_vertices.obj", 8, 12, 1.0, "2 faces have fewer than three"},
    {"obj_line_continuation_and_long_line.obj", 8, 12, 1.0},
    {"obj_mixed_line_endings.obj", 8, 12, 1.0},
    {"obj_mtllib_path_traversal.obj", 8, 12, 1.0},
    {"obj_three_faces_on_one_edge.obj", 5, 3, {}},
    {"obj_utf8_bom.obj", 8, 12, 1.0},
    {"off_all_degenerate.off", 7, 7, {}},
    {"off_unwelded_grid_and_bow_tie.off", 24, 21, {}},
    {"ply_binary_crlf_header.ply", 8, 12, {}},
    {"ply_comment_path_traversal.ply", 8, 12, 1.0},
    {"ply_concave_ngon.ply", 12, 20, 5.0},
    {"ply_face_with_two_vertices.ply", 8, 12, 1.0, "1 face has fewer than three"},
    {"ply_repeated_index_in_face.ply", 8, 14, 1.0, "2 faces repeat a vertex"},
    {"ply_zero_faces.ply", 8, 0, {}, "point cloud"},
    {"stl_binary_starts_with_solid.stl", 8, 12, 1.0},
};

class AcceptedFile : public testing::TestWithParam<Accepted> {};

TEST_P(AcceptedFile, IsReadAsDescribed) {
  const Accepted& accepted = GetParam();
  const std::string file = std::string("bad/") + accepted.file;
  KNEAD_NEEDS_TEST_MESH(file);
  const ShapeFile shape = read_shape(test_mesh(file));
  const Measures m = measure(shape.mesh);
  EXPECT_EQ(m.vertices, accepted.vertices);
  EXPECT_EQ(m.triangles, accepted.triangles);
  if (accepted.volume) {
    EXPECT_NEAR(m.volume, *accepted.volume, 1e-12 * *accepted.volume);
  }
  std::string notes;
  for (const std::string& note : shape.notes) notes += note + "\n";
  if (accepted.note == nullptr) {
    EXPECT_EQ(notes, "");
  } else {
    EXPECT_NE(notes.find(accepted.note), std::string::npos) << notes;
  }
}

INSTANTIATE_TEST_SUITE_P(Bad, AcceptedFile, testing::ValuesIn(kAccepted), file_name<Accepted>);

TEST(BadFiles, MeasuresOfTheOddOnes) {
  KNEAD_NEEDS_TEST_MESH("bad");
  const auto measured = [](const char* file) { return measure(read_shape(test_mesh(file)).mesh); };
  EXPECT_DOUBLE_EQ(measured("bad/ply_concave_ngon.ply").area, 22);
  EXPECT_EQ(measured("bad/ply_repeated_index_in_face.ply").degenerate_triangles, 2u);
  EXPECT_EQ(measured("bad/obj_three_faces_on_one_edge.obj").nonmanifold_edges, 1u);
  EXPECT_EQ(measured("bad/obj_deep_negative_indices.obj").components, 50u);
  EXPECT_EQ(measured("bad/off_all_degenerate.off").degenerate_triangles, 7u);
  EXPECT_EQ(measured("bad/off_unwelded_grid_and_bow_tie.off").components, 3u);
}

TEST(BadFiles, AnUnknownExtensionIsAnsweredWithTheKnownOnes) {
  try {
    read_shape("shape.step");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find(".ply, .obj"), std::string::npos);
  }
  EXPECT_EQ(format_of("A.PLY"), "ply");
  EXPECT_EQ(format_of("-a b.Obj"), "obj");
  EXPECT_THROW(format_of("ply"), InvalidInput);
}

TEST(BadFiles, AMissingFileIsNoInvalidInput) { EXPECT_THROW(read_shape("/absent/shape.ply"), IoError); }

}  // namespace
}  // namespace knead::bad_files_test
