// knead deform --set and --table: sessions with parameters.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "knead/io.h"
#include "knead/session.h"
#include "process.h"

namespace knead::command_test::parameters_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;
using Words = std::vector<std::string>;

const std::string kHeader = R"({"knead": 1, "parameters": {"length": {"value": 0.2, "min": 0, "max": 1}, "angle": 30}})"
                            "\n";
const std::string kStrokes =
    R"({"tool": "implicit", "path": [[0, 0, 1], [0, "$length", 1.2]], "inner": 0.2, "outer": 0.7})"
    "\n"
    R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 0, 1], "rate_deg": "$angle", "inner": -0.5, "outer": 0.5})"
    "\n";

std::string plain(const std::string& length, const std::string& angle) {
  std::string text = "{\"knead\": 1}\n" + kStrokes;
  text.replace(text.find("\"$length\""), 9, length);
  text.replace(text.find("\"$angle\""), 8, angle);
  return text;
}

class ParametersTest : public CommandTest {
 protected:
  ParametersTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kHeader + kStrokes);
  }

  void deform(const std::string& session, const std::string& out, const Words& more = {}) const {
    Words words{"deform", "a.ply", session, "-o", out, "-q"};
    words.insert(words.end(), more.begin(), more.end());
    knead_ok(words);
  }

  // What a session with these numbers in the place of the parameters makes.
  std::string expected(const std::string& length, const std::string& angle) const {
    write("plain.knead", plain(length, angle));
    deform("plain.knead", "plain.ply");
    return read("plain.ply");
  }

  Outcome batch(const std::string& out, const Words& more = {}) const {
    Words words{"deform", "a.ply", "s.knead", "--table", "t.csv", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    return knead(words);
  }
};

TEST_F(ParametersTest, AreSetByTheirNames) {
  deform("s.knead", "b.ply");
  EXPECT_EQ(read("b.ply"), expected("0.2", "30"));
  deform("s.knead", "b.ply", {"--set", "length=0.35", "--set", "angle=-12"});
  EXPECT_EQ(read("b.ply"), expected("0.35", "-12"));
  knead_ok({"resolve", "a.ply", "s.knead", "-q", "--set", "angle=5", "-o", "flow.knead"});
  EXPECT_EQ(read("flow.knead"), plain("0.2", "5"));
}

TEST_F(ParametersTest, ThatCannotBeSetAreErrors) {
  const auto with = [&](const std::string& set) {
    return knead({"deform", "a.ply", "s.knead", "-o", "b.ply", "--set", set});
  };
  expect_error(with("lenght=1"), 3, R"(knead: s.knead: no parameter "lenght"; the session has "length", "angle")");
  expect_error(with("length=1.5"), 3, R"(knead: s.knead: parameter "length" must be from 0 to 1, got 1.5)");
  expect_error(with("angle=inf"), 3, R"(knead: s.knead: parameter "angle" must be a finite number, got inf)");
  for (const std::string set : {"angle", "angle=", "=3", "angle=3deg", "angle=3,2", "angle = 3"}) {
    expect_error(with(set), 2, "knead: --set " + set + ": give a name and a number, as in --set length=0.3");
  }
  expect_error(knead({"deform", "a.ply", "s.knead", "-o", "b.ply", "--set", "angle=1", "--set", "angle=1"}), 2,
               "knead: --set angle=1: angle is given twice");
  EXPECT_FALSE(fs::exists(path("b.ply")));
}

TEST_F(ParametersTest, OfATableGiveAShapeForEachRow) {
  write("t.csv", "length;angle\n0,1;20\n0.3;\n\n# a note\n1;-40\n");
  EXPECT_EQ(batch("out").out, "out: 3 variants, 3 made, 0 kept, 0 failed\n");
  EXPECT_EQ(read("out/0001.ply"), expected("0.1", "20"));
  EXPECT_EQ(read("out/0002.ply"), expected("0.3", "30"));
  EXPECT_EQ(read("out/0003.ply"), expected("1", "-40"));
  EXPECT_TRUE(
      read("out/results.csv")
          .starts_with(
              "name,length,angle,file,moved_vertices,volume_error,greatest_stretch,flipped_triangles,inverted_cells,"
              "made_of,error\n"
              "0001,0.1,20,0001.ply,"));
}

// Also with --set for what the table does not name, and a number of threads.
TEST_F(ParametersTest, OfATableMayHaveNames) {
  write("t.csv", "name,length\nshort,0.1\n\"long, very\",0.9\n");
  const json counts = json::parse(batch("out", {"--set", "angle=7", "--threads", "1", "--json"}).out);
  EXPECT_EQ(counts, (json{{"variants", 2}, {"made", 2}, {"kept", 0}, {"failed", 0}}));
  EXPECT_EQ(read("out/short.ply"), expected("0.1", "7"));
  EXPECT_EQ(read("out/long, very.ply"), expected("0.9", "7"));
}

// On many systems they are one file.
TEST_F(ParametersTest, NamesThatDifferInCaseAloneAreRefused) {
  write("t.csv", "name,length\nV,0.1\nv,0.9\nResults,0.5\n");
  const json counts = json::parse(batch("out", {"--json"}).out);
  EXPECT_EQ(counts["made"], 2);
  EXPECT_EQ(counts["failed"], 1);
  EXPECT_NE(read("out/results.csv").find("line 2 has the name v, too, or one that differs in upper and lower case"),
            std::string::npos);
}

TEST_F(ParametersTest, OfATableGoOnWhereTheyWereLeft) {
  write("t.csv", "name,length\na,0.1\nb,0.2\n");
  EXPECT_EQ(batch("out").exit_code, 0);
  const std::string before = read("out/results.csv");
  write("out/a.ply", "not made again");
  EXPECT_EQ(batch("out").out, "out: 2 variants, 0 made, 2 kept, 0 failed\n");
  EXPECT_EQ(read("out/a.ply"), "not made again");
  EXPECT_EQ(read("out/results.csv"), before);
  write("t.csv", "name,length\nc,0.3\na,0.1\nb,0.25\n");  // another order, another value
  EXPECT_EQ(batch("out").out, "out: 3 variants, 2 made, 1 kept, 0 failed\n");
  EXPECT_EQ(read("out/b.ply"), expected("0.25", "30"));
  EXPECT_EQ(batch("out", {"--tolerance", "1e-6"}).out, "out: 3 variants, 3 made, 0 kept, 0 failed\n");
  fs::remove(path("out/c.ply"));
  EXPECT_EQ(batch("out", {"--tolerance", "1e-6"}).out, "out: 3 variants, 1 made, 2 kept, 0 failed\n");
  knead_ok({"make", "sphere", "-n", "162", "-o", "a.ply", "-q"});
  EXPECT_EQ(batch("out").out, "out: 3 variants, 3 made, 0 kept, 0 failed\n");
}

// Each with its line; the other rows are done.
TEST_F(ParametersTest, OfATableMayFailAlone) {
  write("t.csv", "name,length,angle\na,0.1,1\nb,two,1\nc,1.5,1\na,0.2,1\n../d,0.2,1\ne,0.2,1,3\nf,0.2,9\n");
  const Outcome outcome = batch("out", {"-q"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.err,
            "knead: t.csv:3: \"length\" must be a number, got two\n"
            "knead: t.csv:5: line 2 has the name a, too, or one that differs in upper and lower case alone, which are "
            "one file on many systems; give each row a name of its own\n"
            "knead: t.csv:6: \"name\" must be that of a file, without folders, got ../d\n"
            "knead: t.csv:7: the line has 4 fields, but the first line names 3\n"
            "knead: t.csv:4: s.knead: parameter \"length\" must be from 0 to 1, got 1.5\n"
            "knead: t.csv: 5 of 7 variants failed; out/results.csv says why\n");
  EXPECT_EQ(read("out/a.ply"), expected("0.1", "1"));
  EXPECT_EQ(read("out/f.ply"), expected("0.2", "9"));
  EXPECT_NE(read("out/results.csv")
                .find("c,1.5,1,,,,,,,,\"s.knead: parameter \"\"length\"\" must be from 0 to 1, got 1.5\"\n"),
            std::string::npos);
  write("t.csv", "name,length,angle\na,0.1,1\nc,0.5,1\n");
  EXPECT_EQ(batch("out").out, "out: 2 variants, 1 made, 1 kept, 0 failed\n");
}

// A block of two layers of tetrahedra, of which a strong turn inverts some whatever the points inside do.
TEST_F(ParametersTest, OfATableSayHowManyCellsAreInverted) {
  std::string nodes;
  std::string elements;
  const auto number = [](int i, int j, int k) { return 1 + i + 3 * (j + 3 * k); };
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) nodes += fmt::format("{} {} {} {}\n", number(i, j, k), i, j, k);
    }
  }
  int count = 0;
  for (int cell = 0; cell < 8; ++cell) {
    const auto at = [&](int bits) {
      return number(cell % 2 + bits % 2, cell / 2 % 2 + bits / 2 % 2, cell / 4 + bits / 4);
    };
    for (const auto& [a, b] : std::vector<std::pair<int, int>>{{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}) {
      elements += fmt::format("{} 4 2 1 1 {} {} {} {}\n", ++count, at(0), at(a), at(b), at(7));
    }
  }
  write("b.msh",
        fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n27\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
                    nodes, count, elements));
  write(
      "turn.knead",
      "{\"knead\": 1, \"parameters\": {\"a\": 5}}\n{\"tool\": \"rotate\", \"center\": [0, 0, 0], \"axis\": [1, 1, 0], "
      "\"inner\": 0.1, \"outer\": 3, \"angle_deg\": \"$a\"}\n");
  write("t.csv", "name,a\nsmall,5\nlarge,1500\n");
  const Outcome outcome = knead({"deform", "b.msh", "turn.knead", "--table", "t.csv", "-o", "cells", "-q"});
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.err.find("would be inverted; deform less"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(path("cells/large.msh")));
  const std::string results = read("cells/results.csv");
  EXPECT_NE(results.find(",0,0,"), std::string::npos) << results;
  const json report = json::parse(
      knead_ok({"deform", "b.msh", "turn.knead", "-o", "o.msh", "--json", "-q", "--require", "no-inverted-cells"}));
  EXPECT_EQ(report.at("volume_cells").at("inverted"), 0);
  EXPECT_EQ(report.at("certificate").at("inverted_cells_after"), 0);
  EXPECT_EQ(knead({"deform", "b.msh", "turn.knead", "--set", "a=1500", "-o", "p.msh", "-q"}).exit_code, 4);
  EXPECT_FALSE(fs::exists(path("p.msh")));
}

TEST_F(ParametersTest, OfATableMayMissQuality) {
  write("s.knead", R"({"knead": 1, "parameters": {"rate": 1}})"
                   "\n{\"remesh\": {\"max_vertices\": 700}}\n"
                   R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 0, 1], "rate_deg": "$rate", "inner": -0.5, )"
                   R"("outer": 0.5})"
                   "\n");
  write("t.csv", "rate\n1\n170\n");
  const Outcome outcome = batch("out", {"-q"});
  EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
  EXPECT_TRUE(outcome.err.starts_with("knead: t.csv:3: s.knead:3: ")) << outcome.err;
  EXPECT_TRUE(fs::exists(path("out/0001.ply")));
  EXPECT_FALSE(fs::exists(path("out/0002.ply")));
}

TEST_F(ParametersTest, OfATableMayBeTheFramesOfAnAnimation) {
  write("t.csv", "length\n0\n0.5\n1\n");
  EXPECT_EQ(batch("all.pc2").out, "all.pc2: 3 variants, 3 made, 0 kept, 0 failed\n");
  const std::string bytes = read("all.pc2");
  EXPECT_EQ(bytes.size(), 32U + 3 * 642 * 12);
  expected("1", "30");
  const Vec3d p = read_shape(path("plain.ply")).mesh.positions[17];
  float x = 0;
  std::memcpy(&x, bytes.data() + 32 + (2 * 642 + 17) * 12, sizeof x);
  EXPECT_EQ(x, static_cast<float>(p.x));
  write("t.csv", "length\n0\n2\n");
  const Outcome outcome = batch("none.pc2", {"-q"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_TRUE(outcome.err.ends_with("knead: t.csv: 1 of 2 variants failed; nothing was written\n")) << outcome.err;
  EXPECT_FALSE(fs::exists(path("none.pc2")));
}

TEST_F(ParametersTest, OfATableThatMeansNothingAreErrors) {
  write("t.csv", "length,width\n1,2\n");
  expect_error(batch("out"), 3, R"(knead: t.csv:1: s.knead: no parameter "width"; the session has "length", "angle")");
  write("t.csv", "length,length\n1,2\n");
  expect_error(batch("out"), 3, R"(knead: t.csv:1: the column "length" is there twice)");
  write("t.csv", "1,2\n");
  expect_error(batch("out"), 3, "knead: t.csv:1: the first line must name the columns by parameters");
  write("t.csv", "length\n");
  expect_error(batch("out"), 3, "knead: t.csv:1: it holds no row of values; give 1 or more");
  write("t.csv", "length\n0.5\n");
  expect_error(batch("out.ply"), 2, "knead: --output out.ply: with --table, give a folder, or an animation");
  expect_error(batch("out", {"--frames", "3"}), 2, "knead: --table: --frames is for a single result");
  expect_error(batch("-"), 2, "knead: --table: standard input or output is for a single result");
  fs::create_directory(path("out"));
  write("out/results.csv", "a,b\n1,2\n");
  expect_error(batch("out"), 3, "knead: out/results.csv: is no list of results of --table; move it, or give another");
  EXPECT_EQ(read("out/results.csv"), "a,b\n1,2\n");
}

// What is done when it is interrupted is kept.
TEST_F(ParametersTest, OfATableCanBeInterrupted) {
  knead_ok({"make", "sphere", "-n", "100000", "-o", "a.ply", "-q"});
  std::string rows = "length\n";
  for (int i = 0; i < 400; ++i) rows += "0." + std::to_string(1000 + i) + "\n";
  write("t.csv", rows);
  Process process({"deform", "a.ply", "s.knead", "--table", "t.csv", "-o", "out", "--precision", "double"}, folder());
  for (int i = 0; i < 600 && !fs::exists(path("out/0002.ply")); ++i) std::this_thread::sleep_for(50ms);
  process.send(SIGINT);
  expect_error(process.wait(), 130, "interrupted");
  std::size_t made = 0;
  for (const auto& entry : fs::directory_iterator(path("out"))) made += entry.path().extension() == ".ply" ? 1 : 0;
  EXPECT_GE(made, 1U);
  EXPECT_LT(made, 400U);
  std::string few = "length\n0.1000\n";
  write("t.csv", few);
  EXPECT_EQ(batch("out", {"--precision", "double"}).out, "out: 1 variant, 0 made, 1 kept, 0 failed\n");
}

}  // namespace
}  // namespace knead::command_test::parameters_test
