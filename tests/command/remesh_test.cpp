// knead deform --remesh, --check and --require, knead remesh and knead refine.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "process.h"

namespace knead::command_test::remesh_test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

class RemeshTest : public CommandTest {
 protected:
  RemeshTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("two.knead", kTwoStrokes);
  }

  Mesh mesh(const std::string& name) const { return read_shape(path(name)).mesh; }

  json deform(Words words) const {
    const Words first{"deform", "a.ply", "two.knead", "-o", "b.ply", "--json"};
    words.insert(words.begin(), first.begin(), first.end());
    return json::parse(knead_ok(words));
  }
};

TEST_F(RemeshTest, DeformAgreesWithTheLibrary) {
  const json report = deform({"--remesh"});
  const ShapeFile shape = read_shape(path("a.ply"));
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  const ReplayResult result = replay(shape.mesh, read_session(path("two.knead")), options);
  ASSERT_TRUE(result.shape.is_remeshed());
  const Provenance& provenance = *result.shape.provenance();
  EXPECT_EQ(read("b.ply"), serialize_remeshed("ply", shape, result.shape.mesh(), provenance.face_source));
  EXPECT_EQ(report["vertices"], result.shape.mesh().vertex_count());
  EXPECT_EQ(report["faces"], result.shape.mesh().face_count());
  EXPECT_EQ(report["remesh"]["splits"], provenance.counts.splits);
  EXPECT_EQ(report["remesh"]["collapses"], provenance.counts.collapses);
  EXPECT_EQ(report["remesh"]["flips"], provenance.counts.flips);
  EXPECT_TRUE(report["remesh"]["complete"]);
  EXPECT_FALSE(report.contains("certificate"));
  const Measures measures = measure(mesh("b.ply"));
  EXPECT_TRUE(measures.closed() && measures.manifold() && measures.oriented());
  EXPECT_EQ(measures.euler, 2);
  EXPECT_LT(std::abs(report["volume_error"].get<double>()), 1e-5);
  EXPECT_GT(std::abs(report["remesh"]["volume_error_uncompensated"].get<double>()),
            std::abs(report["volume_error"].get<double>()));
}

TEST_F(RemeshTest, CoarseFacesAreRefusedUnlessTheMeshIsToBeKept) {
  knead_ok({"make", "box", "-n", "28", "-o", "box.ply", "-q"});
  write("twist.knead",
        "{\"knead\": 1}\n"
        R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 0, 1], "rate_deg": 90, "inner": -1, "outer": 1})");
  expect_error(knead({"deform", "box.ply", "twist.knead", "-o", "c.ply"}), 4, "--keep-mesh");
  EXPECT_FALSE(std::filesystem::exists(path("c.ply")));
  const Outcome kept = knead({"deform", "box.ply", "twist.knead", "-o", "c.ply", "--keep-mesh"});
  EXPECT_EQ(kept.exit_code, 0);
  EXPECT_NE(kept.err.find("note: twist.knead: the faces cannot follow"), std::string::npos) << kept.err;
}

TEST_F(RemeshTest, WithoutItVerticesAndFacesStay) {
  const json report = deform({});
  EXPECT_FALSE(report.contains("remesh"));
  EXPECT_TRUE(mesh("b.ply").corner_vertex == mesh("a.ply").corner_vertex);
}

TEST_F(RemeshTest, MoreVerticesThanAllowedAreRefusedWithWhatWouldDo) {
  const Words words{"deform",     "a.ply", "two.knead",      "-o",  "b.ply", "-q",
                    "--max-edge", "0.01",  "--max-vertices", "5000"};
  expect_error(knead(words), 4, "two.knead:");
  expect_error(knead(words), 4, "\"max_edge\" of ");
  EXPECT_FALSE(std::filesystem::exists(path("b.ply")));
  expect_error(knead({"remesh", "a.ply", "-o", "c.ply", "--max-edge", "0.01", "--max-vertices", "700"}), 4,
               "\"max_vertices\" (700)");
  expect_error(knead({"deform", "a.ply", "two.knead", "-o", "b.ply", "--max-vertices", "0"}), 2, "--max-vertices");
}

// Floats are half a unit apart there, so the triangles cross when rounded to them; a double PLY file is not rounded.
TEST_F(RemeshTest, TheCertificateJudgesTheNumbersThatAreWritten) {
  Mesh far = mesh("a.ply");
  for (Vec3d& p : far.positions) p += Vec3d{4.5e5, 5.4e6, 300};
  write("far.ply", serialize_mesh("ply", far, {.double_coordinates = true}));
  write("far.knead",
        "{\"knead\": 1}\n{\"tool\": \"implicit\", \"inner\": 0.2, \"outer\": 0.6, "
        "\"path\": [[450000, 5400000, 301], [450000.2, 5400000, 301.3]]}\n");
  const Words words{"deform", "far.ply", "far.knead", "--remesh", "-q", "--require", "crossings=0", "-o"};
  Words as_double = words;
  as_double.push_back("moved.ply");
  knead_ok(as_double);
  knead_ok({"check", "moved.ply", "--require", "no-self-intersections"});
  Words as_float = words;
  as_float.push_back("moved.stl");
  expect_error(knead(as_float), 4, "refining makes them more");
}

// Its two sides are pressed together until floats do not tell them apart.
TEST_F(RemeshTest, ExitCode0NeverStandsBesideCrossingsThatWereMade) {
  Mesh thin = make_shape(ShapeKind::box, shape_counts(ShapeKind::box).minimum);
  for (Vec3d& p : thin.positions) p = {0.01 * p.x, 0.01 * p.y, 1 + 1e-6 * p.z};
  write("thin.ply", serialize_mesh("ply", thin));
  write("press.knead",
        "{\"knead\": 1}\n{\"tool\": \"stretch\", \"center\": [0, 0, 1], \"axis\": [0, 0, 1], \"factor\": 0.02, "
        "\"inner\": 0.4, \"outer\": 0.8}\n");
  const Words words{"deform", "thin.ply", "press.knead", "--remesh", "-q", "-o", "pressed.ply"};
  expect_error(knead(words), 4, "press.knead:2: ");
  EXPECT_FALSE(std::filesystem::exists(path("pressed.ply")));
  Words allowed = words;
  allowed.insert(allowed.end(), {"--require", "crossings=1000000"});
  knead_ok(allowed);
  EXPECT_TRUE(std::filesystem::exists(path("pressed.ply")));
}

TEST_F(RemeshTest, EveryOptionImpliesItAndDoesWhatItSays) {
  const std::size_t standard = deform({"--remesh"})["vertices"];
  EXPECT_GT(deform({"--max-edge", "0.05"})["vertices"], standard);
  EXPECT_GT(deform({"--max-chord", "1e-4"})["vertices"], standard);
  EXPECT_GT(deform({"--max-angle", "5"})["vertices"], standard);
  EXPECT_LT(deform({"--min-edge", "0.08"})["vertices"], standard);
  const json still = deform({"--remesh-iterations", "0"});
  EXPECT_EQ(still["remesh"]["flips"], 0);
  EXPECT_GT(still["remesh"]["splits"], 0);
}

TEST_F(RemeshTest, ASessionSaysItForItsOwnStrokes) {
  std::string text = kTwoStrokes;
  text.insert(text.find('\n') + 1, "{\"remesh\": {\"max_edge\": 0.1}}\n");
  write("own.knead", text);
  knead_ok({"deform", "a.ply", "own.knead", "-o", "own.ply", "-q"});
  knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "-q", "--max-edge", "0.1"});
  EXPECT_EQ(read("own.ply"), read("b.ply"));
  knead_ok({"resolve", "a.ply", "own.knead", "-o", "r.knead", "-q"});
  EXPECT_NE(read("r.knead").find("{\"remesh\": {\"max_edge\": 0.1}}\n"), std::string::npos);
  knead_ok({"deform", "a.ply", "r.knead", "-o", "r.ply", "-q"});
  EXPECT_EQ(read("r.ply"), read("b.ply"));
}

TEST_F(RemeshTest, FramesAreRemeshedToo) {
  knead_ok({"deform", "a.ply", "two.knead", "-o", "F_%d.ply", "--frames", "3", "--remesh", "-q"});
  EXPECT_EQ(read("F_0.ply"), read("a.ply"));
  for (const std::string until : {"1", "2"}) {
    knead_ok({"deform", "a.ply", "two.knead", "-o", "u.ply", "--remesh", "-q", "--until", until});
    EXPECT_EQ(read("F_" + until + ".ply"), read("u.ply"));
  }
}

TEST_F(RemeshTest, PointCloudsAndInversesSaySo) {
  write("p.xyz", "0.9 0 0\n0 1 0\n");
  const Outcome points = knead({"deform", "p.xyz", "two.knead", "-o", "q.xyz", "--remesh"});
  EXPECT_EQ(points.exit_code, 0);
  EXPECT_NE(points.err.find("note: a point cloud has no faces"), std::string::npos) << points.err;
  const Outcome back = knead({"deform", "a.ply", "two.knead", "-o", "b.ply", "--remesh", "--inverse"});
  EXPECT_EQ(back.exit_code, 0);
  EXPECT_NE(back.err.find("note: a session that is applied backwards"), std::string::npos) << back.err;
  EXPECT_EQ(mesh("b.ply").vertex_count(), 642u);
}

TEST_F(RemeshTest, CheckProvesWhatTheResultIs) {
  for (const Words& words : {Words{"--check"}, Words{"--check", "--remesh"}}) {
    const json report = deform(words);
    const json& certificate = report["certificate"];
    const Measures measures = measure(mesh("b.ply"));
    EXPECT_EQ(certificate["euler_after"], measures.euler);
    EXPECT_EQ(certificate["closed_after"], measures.closed());
    EXPECT_NEAR(certificate["smallest_angle_after"].get<double>(), *measures.smallest_angle_deg, 1e-9);
    EXPECT_NEAR(certificate["volume_error"].get<double>(), measures.volume / report["volume_before"].get<double>() - 1,
                1e-12);
    EXPECT_EQ(certificate["crossings_after"], report["self_intersections_after"]);
    EXPECT_EQ(certificate["motion_outside"], 0);
    ASSERT_EQ(certificate["strokes"].size(), 2u);
    EXPECT_EQ(certificate["strokes"][0]["line"], 2);
    EXPECT_GT(certificate["strokes"][1]["distance_max"], 0);
  }
  // Certified as floats where the file holds floats.
  const auto volume_error = [&](const std::string& out, const std::string& precision) -> double {
    const json report = json::parse(knead_ok({"deform", "a.ply", "two.knead", "-o", out, "--json", "-q", "--check",
                                              "--tolerance", "1e-5", "--precision", precision}));
    return report["certificate"]["volume_error"].get<double>() - report["volume_error"].get<double>();
  };
  EXPECT_LT(std::abs(volume_error("b.ply", "double")), 1e-14);
  EXPECT_GT(std::abs(volume_error("b.stl", "double")), 1e-12);
  const std::string text = knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "--check", "--remesh"});
  EXPECT_NE(text.find("\ncertificate 0 pairs crossing"), std::string::npos) << text;
}

TEST_F(RemeshTest, RequireIsMetOrNothingIsWritten) {
  const Words plain{"deform", "a.ply", "two.knead", "-o", "out.ply", "-q", "--require"};
  const auto with = [&](const std::string& bounds, bool remesh) {
    Words words = plain;
    words.push_back(bounds);
    if (remesh) words.insert(words.end(), {"--max-chord", "1e-3"});
    return knead(words);
  };
  expect_error(with("volume=1e-5", false), 4, "more than 1e-05; add --remesh");
  EXPECT_EQ(files(), (Words{"a.ply", "two.knead"}));
  expect_error(with("crossings=0,distance=1e-12", true), 4, "even after 3 refinements");
  EXPECT_EQ(files(), (Words{"a.ply", "two.knead"}));
  expect_error(knead({"deform", "a.ply", "two.knead", "-o", "F_%d.ply", "--frames", "3", "--require", "volume=1e-9"}),
               4, "more than 1e-09");
  EXPECT_EQ(files(), (Words{"a.ply", "two.knead"}));
  write("p.xyz", "0.9 0 0\n0 1 0\n");
  expect_error(knead({"deform", "p.xyz", "two.knead", "-o", "out.xyz", "-q", "--require", "volume=1"}), 4,
               "the shape has no volume because it is not closed and oriented; leave this bound out");
  std::filesystem::remove(path("p.xyz"));
  EXPECT_EQ(with("volume=1e-5,crossings=0,flipped=0,min-angle=5", true).exit_code, 0);
  EXPECT_EQ(files(), (Words{"a.ply", "out.ply", "two.knead"}));
}

TEST_F(RemeshTest, SecondsKeepTheBestSoFarUnlessABoundIsMissed) {
  const Words words{"deform", "a.ply", "two.knead", "-o", "b.ply", "--remesh", "--remesh-seconds"};
  const auto with = [&](const std::string& seconds, const Words& more) {
    Words all = words;
    all.push_back(seconds);
    all.insert(all.end(), more.begin(), more.end());
    return knead(all);
  };
  for (const std::string wrong : {"0", "-1", "nan"}) expect_error(with(wrong, {}), 2, "--remesh-seconds");
  expect_error(with("1e-9", {"-q", "--require", "volume=1e-5"}), 4, "and --remesh-seconds ended the remeshing");
  EXPECT_EQ(files(), (Words{"a.ply", "two.knead"}));
  const Outcome best = with("1e-9", {"--json"});
  EXPECT_EQ(best.exit_code, 0);
  EXPECT_NE(best.err.find("note: two.knead:2: the mesh was not improved to the end"), std::string::npos) << best.err;
  EXPECT_TRUE(json::parse(best.out)["remesh"]["out_of_time"]);
  EXPECT_TRUE(measure(mesh("b.ply")).closed());
  const Outcome enough = with("1000", {"-q"});
  EXPECT_EQ(enough.exit_code, 0) << enough.err;
  const std::string unlimited = read("b.ply");
  EXPECT_FALSE(deform({"--remesh"})["remesh"]["out_of_time"]);
  EXPECT_EQ(read("b.ply"), unlimited);
  const Outcome idle = knead({"deform", "a.ply", "two.knead", "-o", "b.ply", "--remesh-seconds", "1"});
  EXPECT_NE(idle.err.find("nothing is remeshed"), std::string::npos) << idle.err;
}

TEST_F(RemeshTest, FramesComeOnceTheBoundsAreMet) {
  knead_ok({"deform", "a.ply", "two.knead", "-o", "F_%d.ply", "--frames", "3", "--remesh", "-q", "--require",
            "volume=1e-5,crossings=0"});
  EXPECT_EQ(files(), (Words{"F_0.ply", "F_1.ply", "F_2.ply", "a.ply", "two.knead"}));
  knead_ok({"deform", "a.ply", "two.knead", "-o", "b.ply", "--remesh", "-q"});
  EXPECT_EQ(read("F_2.ply"), read("b.ply"));
}

// A bound that the first try misses makes the chords shorter: here until the second or third try.
TEST_F(RemeshTest, RequireRefinesUntilItIsMet) {
  const json first = deform({"--remesh", "--check"});
  const double distance = first["certificate"]["distance_rms"];
  const std::string bound = "distance=" + std::to_string(0.7 * distance);
  const Outcome outcome =
      knead({"deform", "a.ply", "two.knead", "-o", "b.ply", "--remesh", "--json", "--require", bound});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("trying again with a finer mesh"), std::string::npos) << outcome.err;
  const json refined = json::parse(outcome.out);
  EXPECT_LE(refined["certificate"]["distance_rms"].get<double>(), 0.7 * distance);
  EXPECT_GT(refined["vertices"], first["vertices"]);
  EXPECT_EQ(mesh("b.ply").vertex_count(), refined["vertices"]);
}

TEST_F(RemeshTest, RemeshAloneRefinesAndKeepsTheVolume) {
  const json report = json::parse(knead_ok({"remesh", "a.ply", "--max-edge", "0.05", "-o", "fine.ply", "--json"}));
  const Mesh fine = mesh("fine.ply");
  EXPECT_EQ(report["vertices"], fine.vertex_count());
  EXPECT_EQ(report["faces"], fine.face_count());
  EXPECT_GT(report["splits"], 1000);
  EXPECT_GT(fine.vertex_count(), 4 * mesh("a.ply").vertex_count());
  EXPECT_NEAR(measure(fine).volume / measure(mesh("a.ply")).volume, 1, 1e-5);
  const std::string text = knead_ok({"remesh", "a.ply", "-o", "same.obj"});
  EXPECT_NE(text.find("same.obj: "), std::string::npos) << text;
  EXPECT_NE(text.find(" faces; "), std::string::npos) << text;
}

// A plate with a coarse hole: every corner keeps its bits, and new vertices lie on the edges and faces that were.
TEST_F(RemeshTest, RefineMovesNothing) {
  knead_ok({"make", "letter-y", "-n", "1000", "-o", "y.ply", "-q"});
  for (const std::string& name : Words{"a", "y"}) {
    const Mesh before = mesh(name + ".ply");
    const json report =
        json::parse(knead_ok({"refine", name + ".ply", "--max-edge", "0.04", "-o", name + ".obj", "--json"}));
    const Mesh fine = mesh(name + ".obj");
    EXPECT_EQ(report["vertices"], fine.vertex_count());
    EXPECT_GT(report["splits"], 500);
    EXPECT_EQ(report["flips"] > 0, name == "y");  // inside its flat faces
    EXPECT_EQ(report["collapses"], 0);
    EXPECT_TRUE(report["complete"]);
    EXPECT_LT(report["distance"], name == "y" ? 3e-8 : 1e-15);  // float rounding of its flat faces
    for (std::size_t v = 0; v < before.vertex_count(); ++v) ASSERT_EQ(fine.positions[v], before.positions[v]);
    EXPECT_NEAR(measure(fine).volume, measure(before).volume, name == "y" ? 1e-8 : 1e-11);
    for (std::size_t f = 0; f < fine.face_count(); ++f) {
      const auto face = fine.face(f);
      for (std::size_t c = 0; c < face.size(); ++c) {
        EXPECT_LE(norm(fine.positions[face[c]] - fine.positions[face[(c + 1) % face.size()]]), 0.04);
      }
    }
  }
  expect_error(knead({"refine", "a.ply", "-o", "b.ply"}), 2, "--max-edge");
}

TEST_F(RemeshTest, RemeshRefusesPoints) {
  write("p.xyz", "0 0 0\n0 1 0\n");
  expect_error(knead({"remesh", "p.xyz", "-o", "q.xyz"}), 3, "p.xyz: it has no faces");
  expect_error(knead({"remesh", "none.ply", "-o", "b.ply"}), 3, "none.ply");
}

}  // namespace
}  // namespace knead::command_test::remesh_test
