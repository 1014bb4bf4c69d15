// knead make and info.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "process.h"

namespace knead::command_test::shapes_test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

using ShapesTest = CommandTest;

TEST_F(ShapesTest, EveryKindIsClosedAndManifold) {
  for (const std::string_view name : shape_names()) {
    const std::string kind(name);
    SCOPED_TRACE(kind);
    const std::size_t wish = std::max<std::size_t>(3000, shape_counts(shape_kind(kind)).minimum);
    for (const std::string extension : {".ply", ".obj"}) {
      const std::string file = kind + extension;
      EXPECT_EQ(knead_ok({"make", kind, "-n", std::to_string(wish), "-o", file, "-q"}), "");
      const json info = json::parse(knead_ok({"info", file, "--json"}));
      EXPECT_EQ(info["format"], extension.substr(1));
      EXPECT_TRUE(info["closed"].get<bool>());
      EXPECT_TRUE(info["manifold"].get<bool>());
      EXPECT_TRUE(info["oriented"].get<bool>());
      EXPECT_EQ(info["components"], 1);
      EXPECT_EQ(info["boundary_loops"], 0);
      EXPECT_GT(info["volume"].get<double>(), 0);
      EXPECT_GE(10 * info["vertices"].get<std::size_t>(), 9 * wish);
      EXPECT_LE(10 * info["vertices"].get<std::size_t>(), 11 * wish);
      EXPECT_EQ(info["notes"], json::array());
    }
  }
}

TEST_F(ShapesTest, MakeSaysWhatItMade) {
  EXPECT_EQ(knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply"}), "s.ply: 642 vertices, 1280 faces\n");
  const json made = json::parse(knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply", "--json"}));
  EXPECT_EQ(made["vertices"], 642);
}

TEST_F(ShapesTest, InfoOfASphere) {
  knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply", "-q"});
  const json info = json::parse(knead_ok({"info", "s.ply", "--json"}));
  const Words keys{"format",   "vertices",   "faces",          "triangles",  "closed", "manifold",
                   "oriented", "components", "boundary_loops", "euler",      "volume", "area",
                   "box_min",  "box_max",    "diagonal",       "attributes", "notes"};
  for (const std::string& key : keys) EXPECT_TRUE(info.contains(key)) << key;
  EXPECT_EQ(info.size(), keys.size());
  EXPECT_EQ(info["vertices"], 642);
  EXPECT_EQ(info["euler"], 2);
  EXPECT_EQ(info["box_min"].size(), 3u);
  const std::string table = knead_ok({"info", "s.ply"});
  EXPECT_NE(table.find("vertices              642\n"), std::string::npos) << table;
  EXPECT_EQ(knead_ok({"info", "s.ply", "-q"}), "");
}

TEST_F(ShapesTest, InfoOfAnOpenShape) {
  write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const json open = json::parse(knead_ok({"info", "open.obj", "--json"}));
  EXPECT_TRUE(open["volume"].is_null());
  EXPECT_EQ(open["boundary_loops"], 1);
  EXPECT_EQ(open["closed"], false);
}

}  // namespace
}  // namespace knead::command_test::shapes_test
