// Shapes whose bytes are freed after reading and read again for writing.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "math/system.h"
#include "support/split_faces.h"

namespace knead::source_bytes_test {
namespace {

namespace fs = std::filesystem;

class FreedBytes : public testing::Test {
 protected:
  FreedBytes() : folder_(fs::temp_directory_path() / ("knead_freed_" + std::to_string(::getpid()))) {
    fs::create_directory(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path path(const std::string& name) const { return folder_ / name; }
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  std::string read(const std::string& name) const {
    std::ifstream stream(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::size_t count_files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

 private:
  fs::path folder_;
};

constexpr ReadOptions kFree{.most_kept_bytes = 0};

std::vector<Vec3d> moved(const ShapeFile& shape) {
  std::vector<Vec3d> positions = shape.mesh.positions;
  for (std::size_t i = 0; i < positions.size(); i += 3) positions[i] = positions[i] * 0.5 + Vec3d{0.25, 0, -1};
  return positions;
}

// Two pieces and a half, with a list of attributes, normals and bytes after the last element.
std::string large_ply() {
  Mesh mesh = make_shape(ShapeKind::sphere, 20'000);
  Attribute normal{"normal", Domain::vertex, NumberType::float32, 3, {}};
  for (const Vec3d& p : mesh.positions) normal.values.insert(normal.values.end(), {p.x, p.y, p.z});
  mesh.attributes.push_back(std::move(normal));
  return serialize_mesh("ply", mesh) + "after";
}

TEST_F(FreedBytes, EveryWriterGivesTheSameBytes) {
  std::vector<Sample> samples = samples_of("ply");
  samples.push_back({"ply", large_ply()});
  std::size_t freed_samples = 0;
  for (const Sample& sample : samples) {
    const fs::path file = write("a.ply", sample.bytes);
    const ShapeFile kept = read_shape(file);
    const ShapeFile freed = read_shape(file, kFree);
    EXPECT_EQ(freed.file != nullptr, freed.bytes.empty());
    freed_samples += freed.bytes.empty() ? 1 : 0;
    EXPECT_EQ(serialize_shape("ply", freed, freed.mesh.positions), sample.bytes);
    const std::vector<Vec3d> positions = moved(kept);
    for (const bool doubles : {false, true}) {
      const WriteOptions options{.double_coordinates = doubles};
      const std::string expected = serialize_shape("ply", kept, positions, options);
      EXPECT_NE(expected, sample.bytes);
      EXPECT_EQ(serialize_shape("ply", freed, positions, options), expected);
      write_shape(path("b.ply"), freed, positions, options);
      EXPECT_EQ(read("b.ply"), expected);
    }
    EXPECT_EQ(serialize_shape("obj", freed, positions), serialize_shape("obj", kept, positions));
    if (kept.mesh.face_count() == 0) continue;
    EXPECT_EQ(remesh_losses("b.ply", freed), remesh_losses("b.ply", kept));
    const Remade remade = split_faces(kept.mesh, [](std::uint32_t f) { return f % 2 == 0; });
    EXPECT_EQ(serialize_remeshed("ply", freed, remade.mesh, remade.face_source),
              serialize_remeshed("ply", kept, remade.mesh, remade.face_source));
  }
  EXPECT_GE(freed_samples, 3U);
}

TEST_F(FreedBytes, TheSourceMayBeReplacedByTheResult) {
  const std::string bytes = large_ply();
  const ShapeFile shape = read_shape(write("a.ply", bytes), kFree);
  const std::vector<Vec3d> positions = moved(shape);
  const std::string expected = serialize_shape("ply", shape, positions);
  write_shape(path("a.ply"), shape, positions);
  EXPECT_EQ(read("a.ply"), expected);
  write_shape(path("a.ply"), shape, shape.mesh.positions);
  EXPECT_EQ(read("a.ply"), bytes);
}

TEST_F(FreedBytes, AFileThatHasChangedIsRefusedAndNothingIsWritten) {
  const std::string bytes = large_ply();
  const auto refused = [&](const std::string& other) {
    const ShapeFile shape = read_shape(write("a.ply", bytes), kFree);
    fs::last_write_time(path("a.ply"), fs::last_write_time(path("a.ply")) - std::chrono::hours(1));
    const ShapeFile again = read_shape(path("a.ply"), kFree);
    write("a.ply", other);
    for (const ShapeFile* each : {&shape, &again}) {
      try {
        write_shape(path("b.ply"), *each, moved(*each));
        ADD_FAILURE() << "a changed file was written";
      } catch (const IoError& error) {
        EXPECT_EQ(error.operation(), IoError::Operation::read);
        EXPECT_NE(std::string(error.what()).find("has changed while it was in use"), std::string::npos) << error.what();
      }
    }
    EXPECT_EQ(count_files(), 1U);
  };
  refused(bytes);                              // as long
  refused(bytes.substr(0, bytes.size() / 2));  // shorter
  refused(bytes + bytes);                      // longer
}

TEST_F(FreedBytes, PositionsOutOfRangeTouchNoFile) {
  const ShapeFile shape = read_shape(write("a.ply", large_ply()), kFree);
  write("b.ply", "old");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions.back().x = 1e39;
  EXPECT_THROW(write_shape(path("b.ply"), shape, positions), InvalidInput);
  EXPECT_EQ(read("b.ply"), "old");
  EXPECT_EQ(count_files(), 2U);
}

// Rows that end in the next piece, a face and a header that are longer than a piece.
TEST_F(FreedBytes, PiecesAreReadAsTheWholeIs) {
  Mesh mesh = make_shape(ShapeKind::sphere, 60'000);
  std::vector<std::uint32_t> polygon(400'000);
  for (std::size_t i = 0; i < polygon.size(); ++i) polygon[i] = static_cast<std::uint32_t>(i % mesh.vertex_count());
  for (std::uint32_t f = 0; f < 100'000; ++f) {
    if (f == 70'000) mesh.add_face(polygon);
    mesh.add_face(std::span(polygon).subspan(f, f % 7 < 3 ? 3 : 4 + f % 2));
  }
  std::string ply = serialize_mesh("ply", mesh);
  for (const bool is_long : {false, true}) {
    if (is_long) {
      std::string comments;
      while (comments.size() < 3 << 19) comments += "comment " + std::string(60, 'c') + "\n";
      ply.insert(ply.find("element"), comments);
    }
    const fs::path file = write("a.ply", ply);
    const ShapeFile kept = read_shape(file);
    const ShapeFile freed = read_shape(file, kFree);
    ASSERT_TRUE(freed.bytes.empty());
    EXPECT_EQ(freed.mesh.positions, kept.mesh.positions);
    EXPECT_EQ(freed.mesh.face_begin, kept.mesh.face_begin);
    EXPECT_EQ(freed.mesh.corner_vertex, kept.mesh.corner_vertex);
    EXPECT_EQ(freed.notes, kept.notes);
    const ShapeSummary summary = read_summary(file);
    EXPECT_EQ(summary.faces, kept.mesh.face_count());
    EXPECT_EQ(summary.box.max, shape_box(kept.mesh).max);
  }
}

TEST_F(FreedBytes, DamageIsToldAsOfTheWhole) {
  const std::string ply = large_ply();
  for (const std::size_t size : {ply.size() - 10, ply.size() / 2, ply.find("end_header") + 4}) {
    const fs::path file = write("a.ply", ply.substr(0, size));
    std::string whole;
    std::string pieces;
    for (std::string* message : {&whole, &pieces}) {
      try {
        read_shape(file, message == &pieces ? kFree : ReadOptions{});
      } catch (const InvalidInput& refusal) {
        *message = refusal.what();
      }
    }
    EXPECT_FALSE(whole.empty());
    EXPECT_EQ(pieces, whole);
  }
}

TEST_F(FreedBytes, OtherFilesKeepThem) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 100);
  for (const std::string format : {"obj", "stl", "off", "glb"}) {
    const ShapeFile shape = read_shape(write("a." + format, serialize_mesh(format, mesh)), kFree);
    EXPECT_EQ(shape.file, nullptr);
    EXPECT_EQ(shape.bytes, read("a." + format));
  }
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 "
      "0\n";
  EXPECT_EQ(read_shape(write("text.ply", text), kFree).bytes, text);
  const std::string ply = serialize_mesh("ply", mesh);
  EXPECT_EQ(read_shape(write("small.ply", ply), {.most_kept_bytes = ply.size()}).bytes, ply);
}

}  // namespace
}  // namespace knead::source_bytes_test
