// Runs the program that docs/tutorial.md consists of and compares what it prints with what the page says.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "knead/io.h"
#include "knead/mesh.h"
#include "support/scratch.h"
#include "support/test_meshes.h"

namespace knead::tutorial_test {
namespace {

// The lines between ```text and ``` in the page.
std::string output_in_page() {
  std::istringstream page(file_bytes(TUTORIAL_PAGE));
  std::string text;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (inside && line == "```") break;
    if (inside) text += line + "\n";
    if (line == "```text") inside = true;
  }
  return text;
}

TEST(Tutorial, PrintsWhatThePageSays) {
  const test::Scratch scratch("tutorial");
  const std::filesystem::path& folder = scratch.path();
  write_mesh(folder / "sphere.ply", make_shape(ShapeKind::sphere, 10000));
  write_mesh(folder / "fine.ply", make_shape(ShapeKind::sphere, 40000));
  const std::string command = "cd '" + folder.string() + "' && '" TUTORIAL_PROGRAM "' > output.txt";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(file_bytes(folder / "output.txt"), output_in_page());
  for (const char* name : {"deformed.ply", "fine_deformed.ply"}) {
    const Measures after = measure(read_shape(folder / name).mesh);
    EXPECT_TRUE(after.closed()) << name;
    EXPECT_GT(after.box.max.x, 1.3) << name;
  }
}

}  // namespace
}  // namespace knead::tutorial_test
