// knead deform --also: several shapes in one flow; knead check --also.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "knead/io.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "process.h"

namespace knead::command_test::together_test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

// A sphere, and a skirt about it that is turned so that no vertex lies above another one.
class TogetherTest : public CommandTest {
 protected:
  TogetherTest() {
    knead_ok({"make", "sphere", "-n", "1002", "-o", "body.ply", "-q"});
    ShapeFile skirt = read_shape(path("body.ply"));
    for (Vec3d& p : skirt.mesh.positions) {
      p = Vec3d{0.8 * p.x - 0.6 * p.y, 0.48 * p.x + 0.64 * p.y - 0.6 * p.z, 0.36 * p.x + 0.48 * p.y + 0.8 * p.z} * 1.03;
    }
    skirt.mesh.attributes = {
        {"color", Domain::vertex, NumberType::uint8, 3, std::vector<double>(3 * skirt.mesh.vertex_count(), 200)}};
    write_mesh(path("skirt.ply"), skirt.mesh);
    write("eyes.xyz", "0 0 1.1 0 0 1\n0.1 0 1.1 0 0 1\n3 3 3 1 0 0\n");
    write("pull.knead",
          "{\"knead\": 1}\n{\"tool\": \"implicit\", \"path\": [[0, 0, 1], [0, 0, 1.7]], \"inner\": 0.2, \"outer\": "
          "0.9}\n");
    write("paint.knead",
          "{\"knead\": 1}\n{\"tool\": \"paint\", \"path\": [[0, 0, 1], [0.3, 0, 0.95]], \"outer\": 0.4, \"depth\": "
          "0.1}\n");
  }

  std::vector<std::string> files_in(const std::string& name) const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(name))) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  Words together(const Words& more) const {
    Words words{"deform", "body.ply", "pull.knead", "--also", "skirt.ply", "--also", "eyes.xyz", "-o", "posed", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(TogetherTest, EachShapeMovesAsIfAlone) {
  knead_ok(together({}));
  knead_ok({"deform", "body.ply", "pull.knead", "-o", "alone.ply", "-q"});
  EXPECT_EQ(read("posed/body.ply"), read("alone.ply"));
  const Mesh skirt = read_shape(path("posed/skirt.ply")).mesh;
  EXPECT_EQ(skirt.vertex_count(), 1002U);
  ASSERT_EQ(skirt.attributes.size(), 1U);
  EXPECT_EQ(skirt.attributes[0].values, std::vector<double>(3 * 1002, 200));
  const Mesh eyes = read_shape(path("posed/eyes.xyz")).mesh;
  ASSERT_EQ(eyes.vertex_count(), 3U);
  EXPECT_NEAR(eyes.positions[0].z, 1.8, 1e-4);  // in the core
  EXPECT_EQ(eyes.positions[2], (Vec3d{3, 3, 3}));
}

TEST_F(TogetherTest, CrossingsBetweenThemAreCountedAndRefinedAway) {
  const json plain = json::parse(knead_ok(together({"--json"})));
  EXPECT_GT(plain["crossings_between"], 50);
  EXPECT_EQ(
      json::parse(knead_ok({"check", "posed/body.ply", "--also", "posed/skirt.ply", "--json"}))["crossings_between"],
      plain["crossings_between"]);
  const json refined = json::parse(knead_ok(together({"--remesh", "--require", "crossings=0", "--json"})));
  EXPECT_EQ(refined["crossings_between"], 0);
  EXPECT_EQ(refined["self_intersections_after"], 0);
  const json checked = json::parse(knead_ok(
      {"check", "posed/body.ply", "--also", "posed/skirt.ply", "--require", "no-self-intersections", "--json"}));
  EXPECT_EQ(checked["crossings_between"], 0);
  EXPECT_EQ(checked["components"], 2);
  EXPECT_GT(read_shape(path("posed/skirt.ply")).mesh.vertex_count(), 1002U);
  EXPECT_EQ(read_shape(path("posed/eyes.xyz")).mesh.vertex_count(), 3U);
}

TEST_F(TogetherTest, BoundsThatAreNotMetWriteNothing) {
  expect_error(knead(together({"--require", "crossings=0"})), 4, "add --remesh");
  EXPECT_FALSE(std::filesystem::exists(path("posed")));
}

TEST_F(TogetherTest, StrokesReadTheSurfaceOfTheFirstShape) {
  knead_ok({"deform", "body.ply", "paint.knead", "--also", "skirt.ply", "-o", "posed", "-q"});
  knead_ok({"resolve", "body.ply", "paint.knead", "-o", "flow.knead", "-q"});
  for (const char* name : {"body.ply", "skirt.ply"}) {
    const std::string alone = std::string("alone_") + name;
    knead_ok({"deform", name, "flow.knead", "-o", alone, "-q", "--precision", "double", "--tolerance", "1e-9"});
    const Mesh expected = read_shape(path(alone)).mesh;
    const Mesh found = read_shape(path(std::string("posed/") + name)).mesh;
    double greatest = 0;
    for (std::size_t i = 0; i < expected.vertex_count(); ++i) {
      greatest = std::max(greatest, norm(expected.positions[i] - found.positions[i]));
    }
    EXPECT_LT(greatest, 2e-5) << name;
  }
}

TEST_F(TogetherTest, AStrokeThatReadsTheSurfaceStopsEarly) {
  write("two.knead", read("paint.knead") +
                         R"({"tool": "lattice", "mode": "volume", "origin": [-2, -2, -2], "lengths": [4, 4, 4], )"
                         R"("counts": [2, 2, 2], "displacements": [[0, 0, 0], [0, 0, 0.2], [0, 0, 0], )"
                         R"([0, 0, 0.2], [0, 0, 0], [0, 0, 0], [0, 0, 0], [0.2, 0, 0]]})"
                         "\n");
  for (const std::string until : {"0.4", "1.3", "2"}) {
    knead_ok({"deform", "body.ply", "two.knead", "--until", until, "-o", "alone.ply", "-q"});
    knead_ok({"deform", "body.ply", "two.knead", "--until", until, "--also", "skirt.ply", "-o", "posed", "-q"});
    EXPECT_EQ(read("posed/body.ply"), read("alone.ply")) << until;
  }
}

TEST_F(TogetherTest, ARelaxIsRefused) {
  write("relax.knead", R"({"knead": 1}
{"relax": {"points": [[0, 0, 1]], "radius": 0.3}}
)");
  expect_error(knead({"deform", "body.ply", "relax.knead", "--also", "skirt.ply", "-o", "posed", "-q"}), 3,
               "a relax is no flow, so other shapes cannot follow it");
}

TEST_F(TogetherTest, GoesBackwards) {
  knead_ok(together({"--precision", "double", "--tolerance", "1e-9"}));
  knead_ok({"deform", "posed/body.ply", "pull.knead", "--inverse", "--also", "posed/skirt.ply", "-o", "back", "-q"});
  const Mesh before = read_shape(path("skirt.ply")).mesh;
  const Mesh after = read_shape(path("back/skirt.ply")).mesh;
  for (std::size_t i = 0; i < before.vertex_count(); ++i) {
    ASSERT_LT(norm(before.positions[i] - after.positions[i]), 1e-4) << i;
  }
}

// A format that holds an animation gives one file, any other a file for each frame. Each frame is that of the shape
// alone.
TEST_F(TogetherTest, FramesOfAllShapes) {
  write_mesh(path("shirt.glb"), read_shape(path("skirt.ply")).mesh);
  knead_ok(together({"--frames", "4", "--also", "shirt.glb"}));
  EXPECT_EQ(files_in("posed"),
            (std::vector<std::string>{"body_0000.ply", "body_0001.ply", "body_0002.ply", "body_0003.ply",
                                      "eyes_0000.xyz", "eyes_0001.xyz", "eyes_0002.xyz", "eyes_0003.xyz", "shirt.glb",
                                      "skirt_0000.ply", "skirt_0001.ply", "skirt_0002.ply", "skirt_0003.ply"}));
  knead_ok({"deform", "body.ply", "pull.knead", "-o", "alone_%d.ply", "--frames", "4", "-q"});
  for (const char* frame : {"0", "1", "2", "3"}) {
    EXPECT_EQ(read(std::string("posed/body_000") + frame + ".ply"), read(std::string("alone_") + frame + ".ply"));
  }
  const std::string animation = read("posed/shirt.glb");
  EXPECT_NE(animation.find("\"targets\""), std::string::npos);
  knead_ok({"deform", "body.ply", "pull.knead", "--also", "shirt.glb", "--frames", "3", "--remesh", "--require",
            "crossings=0", "-o", "refined", "-q"});
  EXPECT_EQ(files_in("refined").size(), 4U);
  const std::size_t refined = read_shape(path("refined/shirt.glb")).mesh.vertex_count();
  EXPECT_GT(refined, 1002U);
  for (const char* frame : {"0", "1", "2"}) {
    EXPECT_EQ(read_shape(path(std::string("refined/body_000") + frame + ".ply")).mesh.face_count(),
              read_shape(path("refined/body_0002.ply")).mesh.face_count())
        << "all frames have the faces of the result";
  }
}

// A file that cannot be written leaves no other, nor the folder.
TEST_F(TogetherTest, AllResultsOrNone) {
  const std::size_t body = read("body.ply").size();
  const std::size_t skirt = read("skirt.ply").size();
  ASSERT_GT(skirt, body + 1000);
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  rlimit small = old;
  small.rlim_cur = (body + skirt) / 2;  // enough for the first result only
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const Outcome outcome = knead(together({}));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  expect_error(outcome, 5, "skirt.ply");
  EXPECT_FALSE(std::filesystem::exists(path("posed")));
  std::filesystem::create_directory(path("posed"));
  write("posed/body.ply", "old");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_EQ(knead(together({})).exit_code, 5);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  EXPECT_EQ(files_in("posed"), std::vector<std::string>{"body.ply"});
  EXPECT_EQ(read("posed/body.ply"), "old");
}

// However long it takes, an interruption leaves all results or none.
TEST_F(TogetherTest, InterruptionsLeaveAllResultsOrNone) {
  knead_ok({"make", "sphere", "-n", "40000", "-o", "large.ply", "-q"});
  std::set<std::size_t> counts;
  for (int delay = 0; delay < 400; delay += 25) {
    std::filesystem::remove_all(path("posed"));
    Process process({"deform", "body.ply", "pull.knead", "--also", "large.ply", "-o", "posed"}, folder());
    std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    process.send(SIGINT);
    process.wait();
    counts.insert(std::filesystem::exists(path("posed")) ? files_in("posed").size() : 0);
  }
  for (const std::size_t count : counts) EXPECT_TRUE(count == 0 || count == 2) << count;
}

// A session that was made on several shapes reads the surface of all, as it did when it was made.
TEST_F(TogetherTest, SessionOfSeveralShapesReadsAll) {
  write("both.knead", "{\"knead\": 1, \"mesh\": \"body.ply\", \"also\": [\"skirt.ply\"]}\n" +
                          read("paint.knead").substr(read("paint.knead").find('\n') + 1));
  const Session session = read_session(path("both.knead"));
  ASSERT_EQ(session.also, std::vector<std::string>{"skirt.ply"});
  EXPECT_EQ(parse_session(serialize_session(session), session.name).also, session.also);
  const Words words{"deform", "body.ply", "both.knead", "--also", "skirt.ply", "-o", "posed", "-q"};
  knead_ok(words);
  const ShapeFile body = read_shape(path("body.ply"));
  const ShapeFile skirt = read_shape(path("skirt.ply"));
  const std::vector<const Mesh*> meshes{&body.mesh, &skirt.mesh};
  const JoinedMeshes joined(meshes);
  const ReplayResult expected = replay(joined.mesh(), session);
  const std::span<const Vec3d> all = expected.shape.positions();
  const Mesh found = read_shape(path("posed/skirt.ply")).mesh;
  for (std::size_t v = 0; v < found.vertex_count(); ++v) {
    ASSERT_LT(norm(found.positions[v] - joined.vertices_of(1, all)[v]), 1e-6) << v;
  }
  knead_ok({"deform", "body.ply", "paint.knead", "--also", "skirt.ply", "-o", "first", "-q"});
  EXPECT_NE(read("first/skirt.ply"), read("posed/skirt.ply"));
}

TEST_F(TogetherTest, WrongWordsAreOneLine) {
  expect_error(knead({"deform", "body.ply", "pull.knead", "--also", "skirt.ply", "-o", "posed.ply"}), 2, "folder");
  expect_error(knead({"deform", "body.ply", "pull.knead", "--also", "./body.ply", "-o", "posed"}), 2, "this name");
  expect_error(knead({"deform", "body.ply", "pull.knead", "--also", "none.ply", "-o", "posed"}), 3, "none.ply");
  expect_error(knead({"check", "body.ply", "--also", "skirt.ply", "--before", "body.ply"}), 2, "--before");
  EXPECT_FALSE(std::filesystem::exists(path("posed")));
}

}  // namespace
}  // namespace knead::command_test::together_test
