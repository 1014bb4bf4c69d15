// Files that are not what their names say: each is refused with what it is.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "math/system.h"
#include "support/shape_promises.h"
#include "support/shape_text.h"

namespace knead::other_kinds_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
constexpr const char* kPage = "\n<!doctype HTML>\n<html lang=\"en\">\n<body>404</body>\n</html>\n";

void expect_refusal(const std::string& bytes, const std::string& format, const std::string& says) {
  const std::string message = refusal(bytes, format, "a." + format);
  EXPECT_NE(message.find(says), std::string::npos) << format << ": " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(OtherKinds, PointersPagesAndUtf16InEveryFormat) {
  for (const std::string format : kEveryFormat) {
    expect_refusal(kPointer, format, "is a pointer of Git LFS, not the file itself; run git lfs pull");
    expect_refusal(kPage, format, "is a web page");
    expect_refusal(std::string("\xff\xfe#\0\n\0", 6), format, "is UTF-16 text");
    EXPECT_THROW(parse_summary(kPointer, format, "a"), InvalidInput);
    if (format != "3mf") expect_refusal("PK\x03\x04 a.stl", format, "is a ZIP archive");
    expect_refusal("(0 \"Grid\")\n(2 3)\n(10 (0 1 4 0 3))\n", format, "is a mesh of Fluent");
    expect_refusal("{\"knead\": 1}\n{\"undo\": 1}\n", format, "is a session, not a shape");
  }
}

// A sample of each format under the name of each other one: it is refused as what it is where it cannot be read.
TEST(OtherKinds, FilesUnderOtherNamesAreNamed) {
  const std::string obj = "# cube\nmtllib a.mtl\no cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
  for (const std::string format : {"stl", "ply", "off", "glb", "gltf", "pcd", "msh", "su2", "foam", "unv"}) {
    expect_refusal(obj, format, "is an OBJ file by another name; let its name end in .obj");
  }
  for (const std::string real : {"ply", "glb", "gltf", "pcd", "msh", "foam", "unv", "3mf"}) {
    for (const std::string format : {"stl", "ply", "off", "glb", "gltf", "pcd", "msh", "su2", "foam", "unv", "xyz"}) {
      if (real != format) expect_refusal(samples_of(real)[0].bytes, format, "let its name end in ." + real);
    }
  }
  const std::string stl = serialize_mesh("stl", parse_shape(obj, "obj", "a").mesh);
  for (const std::string format : {"obj", "ply", "off", "xyz"}) expect_refusal(stl, format, "is an STL file");
  expect_refusal("OFF\n1 0 0\n0 0 0\n", "obj", "is an OFF file");
}

TEST(OtherKinds, DamagedFilesOfTheirOwnFormatKeepTheirMessages) {
  expect_refusal("solid a\nfacet normal 0 0\n", "stl", "a.stl:3: the file ends where a number is expected");
  expect_refusal("OFF\n9 9 9\n", "off", "are declared");
  expect_refusal("v 0 0 0\nf 1 2 3\n", "obj", "out of range");
  expect_refusal("PK\x03\x04 a.stl", "3mf", "is no ZIP archive, or is cut short");
}

TEST(OtherKinds, FoldersAreNoFiles) {
  const fs::path folder = fs::temp_directory_path() / ("knead_folder_" + std::to_string(::getpid()) + ".ply");
  fs::create_directories(folder / "constant" / "polyMesh");
  const auto complaint = [&](const auto& read) -> std::string {
    try {
      read();
    } catch (const IoError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(complaint([&] { read_shape(folder); }).find("is a folder; name a file in it"), std::string::npos);
  EXPECT_NE(complaint([&] { read_summary(folder / "constant"); }).find("is a folder"), std::string::npos);
  EXPECT_NE(complaint([&] { read_text(folder); }).find("is a folder"), std::string::npos);
  std::ofstream(folder / "constant" / "polyMesh" / "points") << "FoamFile";
  EXPECT_NE(complaint([&] { read_shape(folder); }).find((folder / "constant/polyMesh/points").string()),
            std::string::npos);
  fs::remove_all(folder);
}

TEST(OtherKinds, TextHasNoMark) {
  const fs::path file = fs::temp_directory_path() / ("knead_text_" + std::to_string(::getpid()) + ".csv");
  std::ofstream(file, std::ios::binary) << "\xef\xbb\xbf"
                                           "a,b\n";
  EXPECT_EQ(read_text(file), "a,b\n");
  std::ofstream(file, std::ios::binary) << kPointer;
  EXPECT_THROW(read_text(file), InvalidInput);
  fs::remove(file);
}

}  // namespace
}  // namespace knead::other_kinds_test
