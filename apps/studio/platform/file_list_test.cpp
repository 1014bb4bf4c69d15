#include "platform/file_list.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace knead::studio {
namespace {

namespace fs = std::filesystem;

TEST(FileList, FoldersComeFirstAndOnlyTheFormatsAskedFor) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("knead_file_list_{}", ::getpid());
  fs::create_directories(folder / "zebra");
  fs::create_directories(folder / ".hidden");
  for (const char* name : {"b.ply", "A.PLY", "c.txt", ".d.ply"}) std::ofstream(folder / name) << "12345";
  const std::vector<std::string> shapes{".ply", ".obj"};
  const FileList list = list_files(folder, shapes);
  ASSERT_EQ(list.files.size(), 3U);
  EXPECT_EQ(list.files[0].name, "zebra");
  EXPECT_TRUE(list.files[0].is_folder);
  EXPECT_EQ(list.files[1].name, "A.PLY");
  EXPECT_EQ(list.files[1].bytes, 5U);
  EXPECT_EQ(list.files[2].name, "b.ply");
  EXPECT_EQ(list.problem, "");
  EXPECT_EQ(list_files(folder, {}).files.size(), 4U);
  EXPECT_NE(list_files(folder / "nothing", {}).problem, "");
  fs::remove_all(folder);
}

TEST(FileList, NamesGetTheExtensionThatTheyLack) {
  const std::vector<std::string> shapes{".ply", ".obj"};
  EXPECT_EQ(with_extension("hand", shapes, ".ply"), "hand.ply");
  EXPECT_EQ(with_extension("hand.OBJ", shapes, ".ply"), "hand.OBJ");
  EXPECT_EQ(with_extension("hand.v2", shapes, ".ply"), "hand.v2.ply");
  EXPECT_EQ(with_extension("hand.xyzw", shapes, ".ply"), "hand.xyzw") << "there is no such format, which is said";
}

TEST(FileList, SizesAreShort) {
  EXPECT_EQ(size_text(0), "0 bytes");
  EXPECT_EQ(size_text(999), "999 bytes");
  EXPECT_EQ(size_text(1000), "1.0 KB");
  EXPECT_EQ(size_text(41'700), "42 KB");
  EXPECT_EQ(size_text(999'700), "1.0 MB");
  EXPECT_EQ(size_text(3'400'000'000), "3.4 GB");
}

}  // namespace
}  // namespace knead::studio
