// knead deform and resolve on real files.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/flow.h"
#include "knead/io.h"
#include "knead/replay.h"
#include "process.h"

namespace knead::command_test::deform_test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

class DeformTest : public CommandTest {
 protected:
  DeformTest() {
    knead_ok({"make", "sphere", "-n", "2562", "-o", "a.ply", "-q"});
    write("none.knead", kNoStrokes);
    write("one.knead", kOneStroke);
    write("two.knead", kTwoStrokes);
  }

  std::vector<Vec3d> positions(const std::string& name) const { return read_shape(path(name)).mesh.positions; }

  double largest_distance(const std::string& a, const std::string& b) const {
    const std::vector<Vec3d> p = positions(a);
    const std::vector<Vec3d> q = positions(b);
    EXPECT_EQ(p.size(), q.size());
    double largest = 0;
    for (std::size_t i = 0; i < p.size(); ++i) largest = std::max(largest, norm(p[i] - q[i]));
    return largest;
  }
};

TEST_F(DeformTest, NoStrokesWriteTheSameBytes) {
  knead_ok({"deform", "a.ply", "none.knead", "-o", "b.ply", "-q"});
  EXPECT_EQ(read("b.ply"), read("a.ply"));
  knead_ok({"make", "torus", "-o", "t.obj", "-q"});
  knead_ok({"deform", "t.obj", "none.knead", "-o", "u.obj", "-q", "--precision", "double"});
  EXPECT_EQ(read("u.obj"), read("t.obj"));
}

TEST_F(DeformTest, AgreesWithTheLibrary) {
  knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "-q"});
  const ShapeFile shape = read_shape(path("a.ply"));
  const ReplayResult result = replay(shape.mesh, read_session(path("two.knead")));
  EXPECT_EQ(read("b.ply"), serialize_shape("ply", shape, result.shape.positions()));
  EXPECT_GT(largest_distance("a.ply", "b.ply"), 0.1);
}

TEST_F(DeformTest, TheInstructionSetIsChosenByTheEnvironment) {
  knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "-q", "--report", "b.json"});
  RunOptions scalar;
  scalar.environment = {"KNEAD_SIMD=scalar"};
  const Outcome done = knead({"deform", "a.ply", "two.knead", "-o", "c.ply", "-q", "--report", "c.json"}, scalar);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(read("b.ply"), read("c.ply"));
  EXPECT_EQ(json::parse(read("b.json")).at("simd"), simd_name());
  EXPECT_EQ(json::parse(read("c.json")).at("simd"), "scalar");
  RunOptions nonsense;
  nonsense.environment = {"KNEAD_SIMD=nonsense"};
  for (const std::string session : {"none.knead", "two.knead"}) {
    expect_error(knead({"deform", "a.ply", session, "-o", "d.ply"}, nonsense), 3,
                 "knead: KNEAD_SIMD is nonsense, which this machine does not have; use one of scalar");
    EXPECT_FALSE(std::filesystem::exists(path("d.ply")));
  }
}

TEST_F(DeformTest, ThreadsAndOutputFolderDoNotMatter) {
  std::filesystem::create_directory(path("sub"));
  knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "-q", "--threads", "1"});
  knead_ok({"deform", "a.ply", "two.knead", "-o", "sub/c.PLY", "-q", "--threads", "5"});
  EXPECT_EQ(read("b.ply"), read("sub/c.PLY"));
}

TEST_F(DeformTest, EveryIntegratorByBothNames) {
  knead_ok({"deform", "a.ply", "one.knead", "-o", "b.ply", "-q", "--tolerance", "1e-7", "--precision", "double"});
  const std::vector<std::pair<std::string, std::string>> names{{"rk4", "runge-kutta"}, {"tsit5", "tsitouras"}};
  for (const auto& [name, long_name] : names) {
    const Words words{"-q", "--tolerance", "1e-7", "--precision", "double", "--integrator"};
    const auto run = [&](const std::string& integrator, const std::string& out) {
      Words all{"deform", "a.ply", "one.knead", "-o", out};
      all.insert(all.end(), words.begin(), words.end());
      all.push_back(integrator);
      knead_ok(all);
    };
    run(name, "c.ply");
    run(long_name, "d.ply");
    EXPECT_EQ(read("c.ply"), read("d.ply")) << name;
    // 1e-7 of the diagonal (2 sqrt 3) for each of 2 segments and 2 methods, times 10: errors grow along the way
    EXPECT_LT(largest_distance("b.ply", "c.ply"), 1.4e-5) << name;
  }
}

TEST_F(DeformTest, InverseTakesBack) {
  const Words exact{"-q", "--precision", "double", "--tolerance", "1e-9"};
  Words there{"deform", "a.ply", "two.knead", "-o", "b.ply"};
  Words back{"deform", "b.ply", "two.knead", "-o", "c.ply", "--inverse"};
  there.insert(there.end(), exact.begin(), exact.end());
  back.insert(back.end(), exact.begin(), exact.end());
  knead_ok(there);
  knead_ok(back);
  EXPECT_GT(largest_distance("a.ply", "b.ply"), 0.1);
  // 1e-9 of the diagonal (under 4) for each of 3 segments, both ways, times 10: errors grow along the way
  EXPECT_LT(largest_distance("a.ply", "c.ply"), 2.4e-7);
}

TEST_F(DeformTest, DoublePrecisionWritesDoubles) {
  knead_ok({"deform", "a.ply", "one.knead", "-o", "b.ply", "-q", "--precision", "double"});
  EXPECT_NE(read("a.ply").find("property float x\n"), std::string::npos);
  EXPECT_NE(read("b.ply").find("property double x\n"), std::string::npos);
}

TEST_F(DeformTest, UntilStopsEarly) {
  knead_ok({"deform", "a.ply", "two.knead", "-o", "zero.ply", "-q", "--until", "0"});
  knead_ok({"deform", "a.ply", "two.knead", "-o", "first.ply", "-q", "--until", "1"});
  knead_ok({"deform", "a.ply", "one.knead", "-o", "one.ply", "-q"});
  knead_ok({"deform", "a.ply", "two.knead", "-o", "all.ply", "-q", "--until", "2"});
  knead_ok({"deform", "a.ply", "two.knead", "-o", "two.ply", "-q"});
  knead_ok({"deform", "a.ply", "two.knead", "-o", "half.ply", "-q", "--until", "1.5"});
  EXPECT_EQ(read("zero.ply"), read("a.ply"));
  EXPECT_EQ(read("first.ply"), read("one.ply"));
  EXPECT_EQ(read("all.ply"), read("two.ply"));
  EXPECT_NE(read("half.ply"), read("two.ply"));
  EXPECT_NE(read("half.ply"), read("one.ply"));
}

// Strokes that read the surface become several others; --until counts those of the session.
TEST_F(DeformTest, UntilTakesBackTheSameStrokes) {
  knead_ok({"make", "box", "-n", "100", "-o", "tool.ply", "-q"});
  write("reads.knead",
        R"({"knead": 1, "mesh": "a.ply"}
{"tool": "rotate", "center": [0, 0, 1], "axis": [0, 0, 1], "angle_deg": 40, "inner": 0.2, "outer": 0.6, "strength": 0}
{"tool": "stamp", "mesh": "tool.ply", "pose": [[0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]], "path": [[0, 0, 1.3], [0, 0, 0.8]]}
{"tool": "stretch", "center": [1, 0, 0], "axis": [0, 1, 0], "factor": 1.5, "inner": 0.2, "outer": 0.8}
)");
  for (const std::string until : {"0.5", "1.4", "2", "2.6", "3"}) {
    knead_ok({"deform", "a.ply", "reads.knead", "-o", "b.ply", "-q", "--until", until});
    knead_ok({"deform", "b.ply", "reads.knead", "-o", "c.ply", "-q", "--until", until, "--inverse"});
    EXPECT_EQ(largest_distance("a.ply", "b.ply") > 0.005, std::stod(until) > 1) << until;
    EXPECT_LT(largest_distance("a.ply", "c.ply"), 1e-4) << until;
  }
}

TEST_F(DeformTest, MayOverwriteItsInput) {
  knead_ok({"deform", "a.ply", "one.knead", "-o", "b.ply", "-q"});
  knead_ok({"deform", "a.ply", "one.knead", "-o", "a.ply", "-q"});
  EXPECT_EQ(read("a.ply"), read("b.ply"));
  EXPECT_EQ(files(), (Words{"a.ply", "b.ply", "none.knead", "one.knead", "two.knead"}));
}

TEST_F(DeformTest, QuietIsSilentAndSpeakingIsShort) {
  EXPECT_EQ(knead_ok({"deform", "a.ply", "one.knead", "-o", "b.ply", "-q"}), "");
  const std::string text = knead_ok({"deform", "a.ply", "one.knead", "-o", "b.ply"});
  EXPECT_TRUE(text.starts_with("b.ply: ")) << text;
  EXPECT_NE(text.find("vertices moved by 1 stroke"), std::string::npos) << text;
}

TEST_F(DeformTest, CutOffLastLineIsANote) {
  write("cut.knead", kOneStroke + "{\"tool\": \"impl");
  const Outcome outcome = knead({"deform", "a.ply", "cut.knead", "-o", "b.ply"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(outcome.err.starts_with("knead: note: cut.knead:3: ")) << outcome.err;
  EXPECT_EQ(knead_ok({"deform", "a.ply", "cut.knead", "-o", "c.ply", "-q"}), "");
  EXPECT_EQ(read("b.ply"), read("c.ply"));
}

TEST_F(DeformTest, OddFileNames) {
  for (const std::string name : {"with space.ply", "\xc3\xbc\xe2\x82\xac.ply", "..%2f.ply", "%d%s%n.ply", "a;b&c.ply",
                                 "[x].ply", "{x}.ply", "deform"}) {
    SCOPED_TRACE(name);
    const bool is_shape = name.ends_with(".ply");
    std::filesystem::copy_file(path(is_shape ? "a.ply" : "one.knead"), path(name));
    knead_ok({"deform", is_shape ? name : "a.ply", is_shape ? "one.knead" : name, "-o", "out " + name + ".ply", "-q"});
    EXPECT_TRUE(std::filesystem::exists(path("out " + name + ".ply")));
  }
  std::filesystem::copy_file(path("a.ply"), path("-a.ply"));
  std::filesystem::copy_file(path("one.knead"), path("--json"));
  knead_ok({"deform", "-q", "-o", "-b.ply", "--", "-a.ply", "--json"});
  knead_ok({"deform", "-q", "--output=-c.ply", "./-a.ply", "./--json"});
  EXPECT_EQ(read("-b.ply"), read("-c.ply"));
  EXPECT_NE(knead_ok({"info", "--json", "--", "-a.ply"}), "");
}

using Check = bool (*)(const json&);
bool is_count(const json& value) { return value.is_number_unsigned(); }
bool is_number(const json& value) { return value.is_number(); }
bool is_text(const json& value) { return value.is_string(); }
bool is_null(const json& value) { return value.is_null(); }

void expect_complete(const json& report) {
  const std::vector<std::pair<std::string, Check>> keys{{"vertices", is_count},
                                                        {"faces", is_count},
                                                        {"moved_vertices", is_count},
                                                        {"strokes", is_count},
                                                        {"segments", is_count},
                                                        {"steps_mean", is_number},
                                                        {"steps_max", is_count},
                                                        {"vertex_steps", is_count},
                                                        {"evaluations", is_count},
                                                        {"rejected_steps", is_count},
                                                        {"threads", is_count},
                                                        {"simd", is_text},
                                                        {"backend", is_text},
                                                        {"precision", is_text},
                                                        {"tolerance", is_number},
                                                        {"volume_before", is_number},
                                                        {"volume_after", is_number},
                                                        {"volume_error", is_number},
                                                        {"area_before", is_number},
                                                        {"area_after", is_number},
                                                        {"max_displacement", is_number},
                                                        {"greatest_stretch", is_number},
                                                        {"flipped_triangles", is_count},
                                                        {"self_intersections_before", is_null},
                                                        {"self_intersections_after", is_null}};
  for (const auto& [key, check] : keys) {
    ASSERT_TRUE(report.contains(key)) << key;
    EXPECT_TRUE(check(report[key])) << key << ": " << report[key];
  }
  ASSERT_TRUE(report.contains("seconds"));
  for (const std::string key : {"read", "deform", "write", "measure", "total"}) {
    ASSERT_TRUE(report["seconds"].contains(key)) << key;
    EXPECT_GE(report["seconds"][key].get<double>(), 0) << key;
  }
  EXPECT_EQ(report.size(), keys.size() + 1);
}

TEST_F(DeformTest, ReportHasEveryKey) {
  knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "-q", "--report", "r.json", "--threads", "1"});
  const json report = json::parse(read("r.json"));
  expect_complete(report);
  EXPECT_EQ(report["vertices"], 2562);
  EXPECT_EQ(report["strokes"], 2);
  EXPECT_EQ(report["segments"], 3);
  EXPECT_EQ(report["threads"], 1);
  EXPECT_EQ(report["precision"], "float");
  EXPECT_EQ(report["tolerance"], 1e-5);
  EXPECT_GT(report["moved_vertices"], 0);
  const double total = report["seconds"]["total"];
  const double parts = report["seconds"]["read"].get<double>() + report["seconds"]["deform"].get<double>() +
                       report["seconds"]["write"].get<double>() + report["seconds"]["measure"].get<double>();
  EXPECT_LE(parts, total * 1.001);
}

TEST_F(DeformTest, ReportOnStandardOutput) {
  for (const Words& words : {Words{"--report", "-"}, Words{"--json"}, Words{"--json", "--report", "-", "-q"}}) {
    Words all{"deform", "a.ply", "one.knead", "-o", "b.ply"};
    all.insert(all.end(), words.begin(), words.end());
    expect_complete(json::parse(knead_ok(all)));
  }
}

TEST_F(DeformTest, ResolvedSessionsDoTheSame) {
  write("note.knead", "{\"knead\": 1, \"mesh\": \"elsewhere.ply\", \"note\": \"for you\"}\n" + kTwoStrokes.substr(13));
  knead_ok({"resolve", "a.ply", "note.knead", "-o", "flow.knead", "-q"});
  const std::string text = read("flow.knead");
  EXPECT_EQ(text.find("elsewhere"), std::string::npos) << text;
  EXPECT_NE(text.find("for you"), std::string::npos) << text;
  knead_ok({"deform", "a.ply", "note.knead", "-o", "b.ply", "-q"});
  knead_ok({"deform", "a.ply", "flow.knead", "-o", "c.ply", "-q"});
  EXPECT_EQ(read("b.ply"), read("c.ply"));
  const json counts = json::parse(knead_ok({"resolve", "a.ply", "note.knead", "-o", "flow.knead", "--json"}));
  EXPECT_EQ(counts["strokes"], 2);
  EXPECT_EQ(counts["segments"], 3);
}

// A path finds the surface of a cloud by its normals.
TEST_F(DeformTest, ResolvesStrokesOnACloudWithNormals) {
  std::string cloud;
  for (const Vec3d& p : positions("a.ply")) cloud += fmt::format("{0} {1} {2} {0} {1} {2}\n", p.x, p.y, p.z);
  write("c.xyz", cloud);
  write("paint.knead",
        R"({"knead": 1}
{"tool": "paint", "path": [[0, 0, 1], [0.3, 0, 0.95]], "outer": 0.4, "depth": 0.1}
)");
  knead_ok({"resolve", "c.xyz", "paint.knead", "-o", "flow.knead", "-q"});
  knead_ok({"deform", "c.xyz", "paint.knead", "-o", "b.xyz", "-q"});
  knead_ok({"deform", "c.xyz", "flow.knead", "-o", "c2.xyz", "-q"});
  EXPECT_NE(read("b.xyz"), read("c.xyz"));
  EXPECT_EQ(read("b.xyz"), read("c2.xyz"));
}

TEST_F(DeformTest, PointCloudsHaveNoVolume) {
  write("p.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "end_header\n0.9 0 0\n5 5 5\n");
  const json report = json::parse(knead_ok({"deform", "p.ply", "one.knead", "-o", "q.ply", "--json", "-q"}));
  EXPECT_TRUE(report["volume_error"].is_null());
  EXPECT_EQ(report["moved_vertices"], 1);
}

}  // namespace
}  // namespace knead::command_test::deform_test
