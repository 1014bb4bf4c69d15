// The material files that are copied with an OBJ file.
#include <gtest/gtest.h>

#include <fstream>

#include "knead/io.h"
#include "math/system.h"
#include "support/test_meshes.h"

namespace knead::materials_test {
namespace {

namespace fs = std::filesystem;

class Materials : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("knead_materials_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "in" / "deeper");
    fs::create_directories(folder_ / "out");
    put("in/a.mtl", "newmtl a");
    put("in/two words.mtl", "newmtl b");
    put("in/deeper/c.mtl", "newmtl c");
    put("in/secret.txt", "secret");
    put("outside.mtl", "newmtl d");
    fs::create_symlink("/dev/zero", folder_ / "in" / "endless.mtl");
    fs::create_symlink("secret.txt", folder_ / "in" / "link.mtl");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  // The names copied for a shape with these lines.
  std::vector<std::string> copied(const std::string& lines) const {
    const ShapeFile shape = parse_shape(lines + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj", "a.obj");
    std::vector<std::string> names;
    for (const fs::path& path : copy_material_files(shape, folder_ / "in" / "a.obj", folder_ / "out" / "b.obj")) {
      EXPECT_EQ(path.parent_path(), folder_ / "out");
      EXPECT_EQ(file_bytes(path), file_bytes(folder_ / "in" / path.filename()));
      names.push_back(path.filename().string());
    }
    return names;
  }

  fs::path folder_;
};

TEST_F(Materials, AreCopiedOnceByName) {
  EXPECT_EQ(copied("mtllib a.mtl two words.mtl"), (std::vector<std::string>{"a.mtl"}));
  EXPECT_EQ(copied("mtllib two words.mtl\r\nmtllib ./a.mtl"), (std::vector<std::string>{"two words.mtl"}));
  put("out/a.mtl", "other");
  EXPECT_TRUE(copied("mtllib a.mtl").empty());
  EXPECT_EQ(file_bytes(folder_ / "out" / "a.mtl"), "other");
}

TEST_F(Materials, NotesSayWhatCameOfThem) {
  put("in/map.mtl", "newmtl m\nmap_Kd m.png");
  put("out/a.mtl", "other");
  const auto notes = [&](const std::string& line) {
    const ShapeFile shape = parse_shape(line + "\nv 0 0 0\n", "obj", "a.obj");
    std::vector<std::string> list;
    copy_material_files(shape, folder_ / "in" / "a.obj", folder_ / "out" / "b.obj", &list);
    EXPECT_EQ(list.size(), 1u);
    return list.empty() ? "" : list[0];
  };
  const auto out = [&](const std::string& text) { return (folder_ / "out" / text).string(); };
  EXPECT_EQ(notes("mtllib \"two words.mtl\""), out("two words.mtl: the materials were copied too"));
  EXPECT_EQ(notes("mtllib a.mtl"), out("a.mtl: is another file of materials, and was kept"));
  EXPECT_EQ(notes("mtllib map.mtl"), out("map.mtl: the materials were copied too, but not their textures"));
  EXPECT_NE(notes("mtllib deeper/c.mtl").find("the materials were not copied"), std::string::npos);
  EXPECT_EQ(copied("mtllib \"a.mtl\" \"map.mtl\""), std::vector<std::string>{});
  fs::remove_all(folder_ / "out");
  fs::create_directories(folder_ / "out");
  EXPECT_EQ(copied("mtllib \"a.mtl\" \"map.mtl\""), (std::vector<std::string>{"a.mtl", "map.mtl"}));
}

TEST_F(Materials, NothingElseIsOpened) {
  for (const char* name : {"../outside.mtl", "deeper/c.mtl", "secret.txt", "endless.mtl", "link.mtl", "absent.mtl",
                           "/etc/passwd", "..", ".mtl", ""}) {
    EXPECT_TRUE(copied(std::string("mtllib ") + name).empty()) << name;
  }
  EXPECT_TRUE(fs::is_empty(folder_ / "out"));
}

TEST_F(Materials, StayWhereTheyAreInTheSameFolder) {
  const ShapeFile shape = parse_shape("mtllib a.mtl\nv 0 0 0\n", "obj", "a.obj");
  EXPECT_TRUE(copy_material_files(shape, folder_ / "in" / "a.obj", folder_ / "out" / ".." / "in" / "b.obj").empty());
}

}  // namespace
}  // namespace knead::materials_test
