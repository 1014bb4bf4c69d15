// knead check, and deform --check.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"
#include "process.h"

namespace knead::command_test::check_test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

// A tetrahedron of volume 1/6 below a floor of one triangle, or with its tip through it.
std::string floor_and_tip(double height) {
  return fmt::format(
      "v -9 -9 0\nv 9 -9 0\nv 0 9 0\nv 0 0 {}\nv 1 0 {}\nv 0 1 {}\nv 0 0 {}\n"
      "f 1 2 3\nf 4 6 5\nf 4 5 7\nf 5 6 7\nf 6 4 7\n",
      height - 1, height - 1, height - 1, height);
}

class CheckTest : public CommandTest {
 protected:
  CheckTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply", "-q"});
    write("apart.obj", floor_and_tip(-0.5));
    write("through.obj", floor_and_tip(0.5));
  }

  json check(Words words) const {
    words.insert(words.begin(), "check");
    words.push_back("--json");
    return json::parse(knead_ok(words));
  }

  std::size_t intersections(const std::string& name) const {
    const Mesh mesh = read_shape(path(name)).mesh;
    return self_intersections(triangulate(mesh), mesh.positions).count;
  }
};

TEST_F(CheckTest, SaysAllThatInfoSaysAndMore) {
  json found = check({"s.ply"});
  const json info = json::parse(knead_ok({"info", "s.ply", "--json"}));
  for (const auto& [key, value] : info.items()) EXPECT_EQ(found[key], value) << key;
  for (const char* none : {"boundary_edges", "nonmanifold_edges", "nonmanifold_vertices", "misoriented_edges",
                           "self_intersections", "degenerate_triangles", "folded_edges"}) {
    EXPECT_EQ(found[none], 0) << none;
  }
  EXPECT_TRUE(found["flipped_triangles"].is_null());
  EXPECT_GT(found["smallest_angle_deg"], 40);  // of an icosahedron, subdivided
  EXPECT_LT(found["smallest_angle_deg"], 60);
  EXPECT_EQ(found.size(), info.size() + 9);

  const std::string table = knead_ok({"check", "s.ply"});
  EXPECT_TRUE(table.starts_with(knead_ok({"info", "s.ply"}))) << table;
  EXPECT_NE(table.find("\nself-intersections    0\n"), std::string::npos) << table;
  EXPECT_EQ(knead_ok({"check", "s.ply", "-q"}), "");
}

TEST_F(CheckTest, InfoOfAVolumeMeshListsPatchesAndCells) {
  const std::string points = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";
  const std::string names = "$PhysicalNames\n1\n2 5 \"wall\"\n$EndPhysicalNames\n";
  write("t.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names + points +
                     "$Elements\n2\n1 2 2 5 5 1 2 3\n2 4 2 6 6 1 2 3 4\n$EndElements\n");
  const json info = json::parse(knead_ok({"info", "t.msh", "--json"}));
  EXPECT_EQ(info["cells"], 1);
  EXPECT_EQ(info["patches"], json::parse(R"([{"name": "wall", "points": 3}, {"name": "6", "points": 4}])"));
  EXPECT_NE(knead_ok({"info", "t.msh"}).find("\npatch                 wall, 3 points\n"), std::string::npos);
  EXPECT_FALSE(json::parse(knead_ok({"info", "s.ply", "--json"})).contains("patches"));
  write("points", "FoamFile { format ascii; class vectorField; }\n1((0 0 0))");
  const json alone = json::parse(knead_ok({"info", "points", "--json"}));
  EXPECT_NE(alone["notes"].dump().find("its cells and patches are not read"), std::string::npos);
}

TEST_F(CheckTest, InfoWithoutTopologySaysTheSameOfWhatItSays) {
  write("t.ply", read("s.ply") + "after");
  for (const std::string name : {"t.ply", "apart.obj"}) {
    const json whole = json::parse(knead_ok({"info", name, "--json"}));
    const json summary = json::parse(knead_ok({"info", name, "--no-topology", "--json"}));
    for (const auto& [key, value] : summary.items()) {
      if (key == "notes") continue;  // those of edges are left out
      EXPECT_EQ(whole[key], value) << key;
    }
    for (const char* left_out : {"closed", "components", "euler", "volume", "area"}) {
      EXPECT_FALSE(summary.contains(left_out)) << left_out;
    }
    EXPECT_EQ(summary.size(), 9u);
  }
  const std::string table = knead_ok({"info", "t.ply", "--no-topology"});
  EXPECT_NE(table.find("\nvertices              642\n"), std::string::npos) << table;
  EXPECT_NE(table.find("5 bytes follow the last element"), std::string::npos) << table;
  EXPECT_EQ(table.find("closed"), std::string::npos) << table;
  write("cut.ply", read("s.ply").substr(0, 5000));
  expect_error(knead({"info", "cut.ply", "--no-topology"}), 3, "cut.ply");
}

TEST_F(CheckTest, CountsWhatIsWrong) {
  EXPECT_EQ(check({"apart.obj"})["self_intersections"], 0);
  EXPECT_EQ(check({"through.obj"})["self_intersections"], 3);  // the three sides of the tip
  write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0\nv 2 0 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  const json bad = check({"bad.obj"});
  EXPECT_EQ(bad["boundary_edges"], 6);
  EXPECT_EQ(bad["nonmanifold_edges"], 1);
  EXPECT_EQ(bad["degenerate_triangles"], 1);
  EXPECT_EQ(bad["self_intersections"], 2);  // 1 and 2 overlap; 3 has no area
  write("fold.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.001\nf 1 2 3\nf 2 1 4\n");
  EXPECT_EQ(check({"fold.obj"})["folded_edges"], 1);
}

TEST_F(CheckTest, ComparesWithTheShapeBefore) {
  knead_ok({"make", "sphere", "-n", "162", "-o", "a.ply", "-q"});
  ShapeFile shape = read_shape(path("a.ply"));
  std::vector<Vec3d> positions = shape.mesh.positions;
  const auto face = shape.mesh.face(20);  // one of its corners, drawn along an edge and far beyond the other
  positions[face[0]] = positions[face[0]] + (positions[face[1]] - positions[face[0]]) * 2.5;
  const std::size_t flipped = count_flipped(shape.mesh, shape.mesh.positions, positions);
  ASSERT_GT(flipped, 0u);
  write_shape(path("b.ply"), shape, positions);
  EXPECT_EQ(check({"b.ply", "--before", "a.ply"})["flipped_triangles"], flipped);
  EXPECT_EQ(check({"a.ply", "--before", "a.ply"})["flipped_triangles"], 0);
  const Outcome unmet = knead({"check", "b.ply", "-q", "--before", "a.ply", "--require", "no-flipped"});
  expect_error(unmet, 4, fmt::format("knead: b.ply: {} triangles flipped; ", flipped));
  expect_error(knead({"check", "b.ply", "--before", "s.ply"}), 3,
               "knead: s.ply: its faces differ from those of b.ply; ");
  expect_error(knead({"check", "b.ply", "--before", "none.ply"}), 3, "knead: none.ply: ");
}

TEST_F(CheckTest, RequirementsThatAreMetAreSilent) {
  knead_ok({"check", "s.ply", "--require",
            "closed,manifold,oriented,one-component,no-self-intersections,no-degenerate,no-folded,min-angle=40"});
  knead_ok({"check", "s.ply", "--before", "s.ply", "--require", "no-flipped"});
}

TEST_F(CheckTest, EveryUnmetRequirementIsALine) {
  write("bad.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0.01\nv 2 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 2 1 4\nf 1 2 5\nf 3 6 7\n");
  const Outcome all = knead(
      {"check", "bad.obj", "--json", "--require", "closed,manifold,oriented,one-component,no-degenerate,min-angle=60"});
  EXPECT_EQ(all.exit_code, 4);
  EXPECT_EQ(json::parse(all.out)["vertices"], 7);  // printed all the same
  EXPECT_EQ(std::count(all.err.begin(), all.err.end(), '\n'), 4) << all.err;
  for (const char* part : {"knead: bad.obj: not closed: ", "knead: bad.obj: not manifold: 1 edge with more",
                           "knead: bad.obj: 1 triangle without area", "knead: bad.obj: a triangle has an angle of "}) {
    EXPECT_NE(all.err.find(part), std::string::npos) << all.err;
  }
  struct Case {
    std::string file;
    std::string word;
    std::string part;
  };
  write("turned.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nf 1 2 3\nf 1 2 4\n");
  write("fold.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.001\nf 1 2 3\nf 2 1 4\n");
  for (const Case& each : {Case{"turned.obj", "oriented", "not oriented: 1 edge "},
                           Case{"through.obj", "one-component", "2 components, not one; "},
                           Case{"through.obj", "no-self-intersections", "3 pairs of triangles intersect; "},
                           Case{"fold.obj", "no-folded", "folded at 1 edge; "}}) {
    expect_error(knead({"check", each.file, "-q", "--require", each.word}), 4, each.part);
  }
}

TEST_F(CheckTest, UnknownRequirementsAreWrongUsage) {
  for (const std::string list : {"", "closed,", "closed,round", "min-angle", "min-angle=", "min-angle=0",
                                 "min-angle=61", "min-angle=5x", "min-angle=nan", "closed=1", "no-flipped"}) {
    expect_error(knead({"check", "s.ply", "--require", list}), 2, "knead: --require");
  }
  expect_error(knead({"check", "none.ply", "--require", "round"}), 2, "no requirement 'round'; choose from closed, ");
}

TEST_F(CheckTest, TheCountEndsAtAStatedNumber) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 5000; ++i) text += "f 1 2 3\n";  // 12497500 pairs
  write("same.obj", text);
  const json found = check({"same.obj"});
  EXPECT_EQ(found["self_intersections"], 10000000);
  EXPECT_NE(found["notes"].dump().find("more than 10000000 pairs of triangles intersect"), std::string::npos);
  expect_error(knead({"check", "same.obj", "-q", "--require", "no-self-intersections"}), 4, "more than 10000000 pairs");
}

TEST_F(CheckTest, CanBeInterrupted) {
  // All triangles of a polygon's fan meet in one corner: minutes of work.
  constexpr int corners = 60000;
  std::string text;
  std::string face = "f";
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * 3.141592653589793 * i / corners;
    text += fmt::format("v {} {} {}\n", 0.6 * std::cos(angle), std::sin(angle),
                        0.8 * std::cos(angle) + 0.1 * std::sin(angle));
    face += fmt::format(" {}", i + 1);
  }
  write("disc.obj", text + face + "\n");
  Process process({"check", "disc.obj"}, folder());
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  process.send(SIGINT);
  expect_error(process.wait(), 130, "interrupted");
}

// The tip moves through the floor, whose corners are far away and stay.
TEST_F(CheckTest, DeformCountsBeforeAndAfter) {
  write("up.knead",
        "{\"knead\": 1}\n"
        "{\"tool\": \"implicit\", \"inner\": 2, \"outer\": 4, \"path\": [[0, 0, -1], [0, 0, 0]]}\n");
  const Words deform{"deform", "apart.obj", "up.knead", "--keep-mesh", "-o", "out.obj"};
  const auto with = [&](const Words& more) {
    Words words = deform;
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const json report = json::parse(knead_ok(with({"--check", "--json"})));
  EXPECT_EQ(report["self_intersections_before"], 0);
  EXPECT_EQ(report["self_intersections_after"], 3);
  EXPECT_EQ(report["self_intersections_after"], intersections("out.obj"));
  EXPECT_TRUE(json::parse(knead_ok(with({"--json"})))["self_intersections_after"].is_null());
  const std::string line = "crossing 0 pairs of triangles before, 3 after\n";
  EXPECT_NE(knead_ok(with({"--check"})).find(line), std::string::npos);
  EXPECT_EQ(knead_ok(deform).find("crossing"), std::string::npos);
}

}  // namespace
}  // namespace knead::command_test::check_test
