// Every session in examples/ applies to its shape, at a size that is quick; the guide shows those of the tools.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "process.h"
#include "support/test_meshes.h"

namespace knead::command_test::examples_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kRoot = KNEAD_SOURCE_DIR;

std::vector<std::string> lines_of(const fs::path& path) {
  std::istringstream text(file_bytes(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::vector<fs::path> sessions() {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "examples")) {
    if (entry.path().extension() != ".knead") continue;
    const bool has_walls = json::parse(lines_of(entry.path()).front()).contains("walls");
    if (!has_walls) paths.push_back(entry.path());  // else for the mesh of a case: test_solver_loop.py
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

// The files that a session names: its shape, and the tools of stamps and prints.
std::vector<std::string> meshes_of(const fs::path& session) {
  std::vector<std::string> names;
  for (const std::string& line : lines_of(session)) {
    const json object = json::parse(line);
    for (const char* const key : {"mesh", "file"}) {
      if (object.contains(key)) names.push_back(object[key]);
    }
  }
  return names;
}

class ExamplesTest : public CommandTest, public ::testing::WithParamInterface<fs::path> {
 protected:
  // Makes the shape of that name, "sphere_fine.ply" of the kind sphere, or takes a real mesh; false where that is
  // absent.
  bool provide(const std::string& name) const {
    if (fs::exists(path(name))) return true;
    const std::string stem = fs::path(name).stem().string();
    const std::string kind = stem.substr(0, stem.find('_'));
    const auto kinds = shape_names();
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end() ||
        (kind == "hand" && stem != kind && stem != "hand_coarse")) {
      if (!has_test_mesh(name)) return false;
      fs::copy(test_mesh(name), path(name));
      return true;
    }
    const std::size_t count = std::max<std::size_t>(6000, shape_counts(shape_kind(kind)).minimum);
    knead_ok({"make", kind, "-n", std::to_string(count), "-q", "-o", name});
    return true;
  }
};

TEST_P(ExamplesTest, AppliesToItsShape) {
  fs::copy(GetParam(), path("session.knead"));
  const std::vector<std::string> meshes = meshes_of(GetParam());
  ASSERT_FALSE(meshes.empty()) << "the header names no mesh";
  for (const std::string& name : meshes) {
    if (!provide(name)) GTEST_SKIP() << test_mesh(name) << " is absent";
  }
  // The shapes are coarser than those of the gallery.
  const std::vector<std::string> words{"deform", meshes.front(), "session.knead", "-q", "--keep-mesh", "--report",
                                       "-",      "-o",           "out.ply"};
  const Outcome outcome = knead(words);
  for (const char* const missing : {"FreeType", "\"font\""}) {
    if (outcome.err.find(missing) != std::string::npos) GTEST_SKIP() << outcome.err;
  }
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_GT(report["moved_vertices"], 0);
  EXPECT_GT(report["strokes"], 0);
}

class HeadTest : public CommandTest {};

// What examples/head.script made with Studio, at the size at which it was made.
TEST_F(HeadTest, IsCleanAndKeepsItsVolume) {
  knead_ok({"make", "sphere", "-n", "60000", "-q", "-o", "sphere.ply"});
  fs::copy(kRoot / "examples" / "head.knead", path("head.knead"));
  const json report =
      json::parse(knead_ok({"deform", "sphere.ply", "head.knead", "-q", "--report", "-", "-o", "head.ply"}));
  EXPECT_LT(std::abs(report["volume_error"].get<double>()), 1e-5);
  EXPECT_GT(report["remesh"]["splits"], 5000);
  EXPECT_GT(report["max_displacement"], 0.5);
  const json checked = json::parse(knead_ok({"check", "head.ply", "--json"}));
  EXPECT_EQ(checked["self_intersections"], 0);
  EXPECT_EQ(checked["degenerate_triangles"], 0);
}

INSTANTIATE_TEST_SUITE_P(All, ExamplesTest, ::testing::ValuesIn(sessions()), [](const auto& tested) {
  std::string name = tested.param.parent_path().filename().string() + "_" + tested.param.stem().string();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

TEST(Guide, ShowsOrLinksTheExampleOfEveryTool) {
  const std::string guide = file_bytes(kRoot / "docs" / "guide.md");
  for (const std::string tool :
       {"implicit", "paint", "points", "stamp", "rotate", "stretch", "twist", "bend", "pins", "pose"}) {
    const std::vector<std::string> lines = lines_of(kRoot / "examples" / "tools" / (tool + ".knead"));
    ASSERT_GE(lines.size(), 2u) << tool;
    const bool is_linked = guide.find("(../examples/tools/" + tool + ".knead)") != std::string::npos;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      EXPECT_TRUE(is_linked || guide.find("    " + lines[i] + "\n") != std::string::npos) << lines[i];
      EXPECT_EQ(json::parse(lines[i])["tool"], tool);
    }
    EXPECT_NE(guide.find("images/guide/" + tool + ".jpg"), std::string::npos) << tool;
  }
}

}  // namespace
}  // namespace knead::command_test::examples_test
