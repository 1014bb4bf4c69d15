// Exit codes and messages: one line each, whatever goes wrong.
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "process.h"
#include "support/test_meshes.h"

namespace knead::command_test::errors_test {
namespace {

using Words = std::vector<std::string>;

class ErrorsTest : public CommandTest {
 protected:
  ErrorsTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kOneStroke);
  }
};

TEST_F(ErrorsTest, WhatStandsInTheWrongPlaceIsNamed) {
  const Outcome order = knead({"deform", "s.knead", "a.ply", "-o", "b.ply"});
  EXPECT_EQ(order.exit_code, 2);
  EXPECT_NE(order.err.find("a session stands where the shape belongs; write a.ply s.knead"), std::string::npos)
      << order.err;
  EXPECT_NE(knead({"deform", "a.ply", "a.ply", "-o", "b.ply"}).err.find("a shape stands where the session belongs"),
            std::string::npos);
  EXPECT_NE(knead({"info", "s.knead"}).err.find("is a session, not a shape"), std::string::npos);
  const Outcome folder = knead({"info", "."});
  EXPECT_EQ(folder.exit_code, 3);
  EXPECT_NE(folder.err.find(".: is a folder; name a file in it"), std::string::npos) << folder.err;
  const Outcome session = knead({"deform", "a.ply", ".", "-o", "b.ply"});
  EXPECT_NE(session.err.find("is a folder"), std::string::npos) << session.err;
  const Outcome output = knead({"deform", "a.ply", "s.knead", "-o", "b.step"});
  EXPECT_NE(
      output.err.find("ends in .ply, .obj, .glb, .gltf, .stl, .3mf, .off, for points .ply, .obj, .glb, .gltf, .off, "
                      ".xyz, .pcd, or as the shape's"),
      std::string::npos)
      << output.err;
  const Outcome solver = knead({"deform", "a.ply", "s.knead", "-o", "b.msh"});
  EXPECT_EQ(solver.exit_code, 3);
  EXPECT_NE(solver.err.find("write .ply, .obj, .glb, .gltf, .stl, .3mf or .off"), std::string::npos) << solver.err;
}

TEST_F(ErrorsTest, WrongUsageIsOneLineThatPointsToHelp) {
  const std::vector<Words> wrong{
      {},
      {"-x"},
      {"nonsense"},
      {"--"},
      {""},
      {"deform"},
      {"deform", "a.ply", "-o", "b.ply"},
      {"deform", "a.ply", "s.knead"},
      {"deform", "a.ply", "s.knead", "more", "-o", "b.ply"},
      {"deform", "a.ply", "s.knead", "-o"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--max-edge", "0"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--max-angle", "200"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--max-chord", "2"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--min-edge", "-1"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--remesh-iterations", "101"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--require", "beauty=1"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--require", ""},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--require", "volume"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--require", "volume=-1"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--require", "crossings=0.5"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--require", "min-angle=61"},
      {"remesh"},
      {"remesh", "a.ply"},
      {"remesh", "a.ply", "-o", "b.dxf"},
      {"remesh", "a.ply", "-o", "b.ply", "--max-edge", "-1"},
      {"remesh", "a.ply", "-o", "b.ply", "--iterations", "1000"},
      {"remesh", "a.ply", "-o", "b.ply", "--threads", "0"},
      {"deform", "a.ply", "s.knead", "-o", "b.dxf"},
      {"deform", "a.ply", "s.knead", "-o", "b"},
      {"deform", "a.ply", "s.knead", "-o", ""},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--tolerance", "0"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--tolerance", "-1e-5"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--tolerance", "nan"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--tolerance", "inf"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--tolerance", "fine"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--tolerance", "1e-5mm"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--integrator", "euler"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--integrator", "dp54"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--precision", "half"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--threads", "0"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--threads", "99999999999999"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--until", "-1"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--until", "1.5"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--frames", "3"},
      {"deform", "a.ply", "s.knead", "-o", "b_%04d.ply", "--frames", "0"},
      {"deform", "a.ply", "s.knead", "-o", "s.knead.ply", "--report", "s.knead.ply"},
      {"deform", "a.ply", "s.knead", "-o", "b.ply", "--report", "a.ply"},
      {"resolve", "a.ply", "s.knead", "-o", "b.ply"},
      {"info"},
      {"info", "a.ply", "a.ply"},
      {"check"},
      {"check", "a.ply", "--require"},
      {"make", "-o", "b.ply"},
      {"make", "teapot", "-o", "b.ply"},
      {"make", "sphere", "-o", "b.ply", "-n", "3"},
      {"make", "sphere", "-o", "b.ply", "-n", "0"},
      {"make", "sphere", "-o", "b.ply", "-n", "-5"},
      {"make", "sphere", "-o", "b.png"},
      {"render", "-o", "b.png"},
      {"render", "a.ply", "-o", "b.gif"},
      {"render", "a.ply", "-o", "b.png", "--size", "800"},
      {"render", "a.ply", "-o", "b.png", "--size", "800x600x3"},
      {"render", "a.ply", "-o", "b.png", "--size", "0x600"},
      {"render", "a.ply", "-o", "b.png", "--view", "sideways"},
      {"render", "a.ply", "-o", "b.png", "--view", "10,95"},
      {"render", "a.ply", "-o", "b.png", "--up", "x"},
      {"render", "a.ply", "-o", "b.png", "--background", "pink"},
      {"render", "a.ply", "-o", "b.png", "--background", "#12345"},
      {"render", "a.ply", "-o", "b.png", "--material", "velvet"},
      {"render", "a.ply", "-o", "b.png", "--quality", "best"},
      {"render", "a.ply", "-o", "b.png", "--perspective", "0.5"},
      {"render", "a.ply", "-o", "b.png", "--perspective", "170"},
      {"render", "a.ply", "-o", "b.png", "--stroke", "1"},
      {"render", "a.ply", "-o", "b.png", "--until", "0"},
      {"render", "a.ply", "-o", "b.png", "--session", "s.knead", "--until", "half"},
      {"render", "a.ply", "a.ply", "-o", "b.png", "--session", "s.knead", "--until", "0,1"},
      {"render", "a.ply", "-o", "b.png", "--session", "s.knead", "--tools", "each"},
      {"render", "a.ply", "-o", "b.png", "--session", "s.knead", "--tools", "last"},
      {"render", "a.ply", "-o", "b.png", "--cut", "1,0,0"},
      {"render", "a.ply", "-o", "b.png", "--cut", "0,0,0,1"},
      {"render", "a.ply", "-o", "b.png", "--close-up", "0,0,0,0"},
      {"render", "a.ply", "-o", "b.png", "--close-up", "0,0,0,1", "--same-scale"},
      {"render", "a.ply", "-o", "b.jpg", "--background", "transparent"},
  };
  for (const Words& words : wrong) {
    SCOPED_TRACE(::testing::PrintToString(words));
    expect_error(knead(words), 2, " --help");
  }
  EXPECT_EQ(files(), (Words{"a.ply", "s.knead"}));
}

TEST_F(ErrorsTest, UnknownBackends) {
  expect_error(knead({"deform", "a.ply", "s.knead", "-o", "b.ply", "--backend", "tpu"}), 2, "--backend tpu: say cpu");
#ifndef KNEAD_HAS_GPU
  expect_error(knead({"deform", "a.ply", "s.knead", "-o", "b.ply", "--backend", "gpu"}), 2, "leave --backend out");
#endif
}

TEST_F(ErrorsTest, UnknownSubcommands) { expect_error(knead({"sculpt", "a.ply"}), 2, "no command 'sculpt'"); }

TEST_F(ErrorsTest, HelpHasExamples) {
  for (const Words& words :
       {Words{"--help"}, Words{"deform", "--help"}, Words{"resolve", "-h"}, Words{"info", "--help"},
        Words{"check", "--help"}, Words{"make", "--help"}, Words{"remesh", "--help"}, Words{"render", "--help"}}) {
    EXPECT_NE(knead_ok(words).find("Examples:\n  knead "), std::string::npos) << ::testing::PrintToString(words);
  }
  EXPECT_TRUE(knead_ok({"--version"}).starts_with("knead "));
}

// Of two walls that face each other one is no mirror: points are put back onto it, which is no flow.
TEST_F(ErrorsTest, WallsThatAreNoMirrorsCannotBeResolvedOrCertified) {
  write("box.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"low\"\n2 2 \"high\"\n3 3 \"fluid\"\n"
        "$EndPhysicalNames\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n"
        "$EndNodes\n$Elements\n3\n1 3 2 1 1 1 2 3 4\n2 3 2 2 2 5 6 7 8\n3 5 2 3 3 1 2 3 4 5 6 7 8\n$EndElements\n");
  write("walls.knead", R"({"knead": 1, "walls": [{"patch": "low", "slide": true}, {"patch": "high", "slide": true}]})"
                       "\n"
                       R"({"tool": "implicit", "path": [[0, 0, 0.5], [0.1, 0, 0.6]], "inner": 0.5, "outer": 2})"
                       "\n");
  knead_ok({"deform", "box.msh", "walls.knead", "-q", "-o", "moved.msh"});
  expect_error(knead({"resolve", "box.msh", "walls.knead", "-q", "-o", "b.knead"}), 3, "cannot be resolved");
  expect_error(knead({"deform", "box.msh", "walls.knead", "-q", "-o", "b.msh", "--check"}), 3, "no certificate");
  EXPECT_FALSE(std::filesystem::exists(path("b.knead")));
  EXPECT_FALSE(std::filesystem::exists(path("b.msh")));
}

TEST_F(ErrorsTest, UnreadableInput) {
  write("garbage.ply", "this is no mesh\n");
  write("thing.stl", "solid\n");
  std::filesystem::create_directory(path("folder.ply"));
  expect_error(knead({"deform", "none.ply", "s.knead", "-o", "b.ply"}), 3, "knead: none.ply: ");
  expect_error(knead({"deform", "a.ply", "none.knead", "-o", "b.ply"}), 3, "knead: none.knead: ");
  expect_error(knead({"resolve", "none.ply", "s.knead", "-o", "b.knead"}), 3, "knead: none.ply: ");
  expect_error(knead({"info", "none.ply"}), 3, "knead: none.ply: ");
  expect_error(knead({"info", "garbage.ply"}), 3, "knead: garbage.ply:1: ");
  expect_error(knead({"info", "thing.stl"}), 3, "thing.stl");
  expect_error(knead({"info", "folder.ply"}), 3, "knead: folder.ply: ");
  std::filesystem::create_symlink("/dev/zero", path("endless.ply"));
  expect_error(knead({"info", "endless.ply"}), 3, "knead: endless.ply: is a device");
  EXPECT_EQ(files(), (Words{"a.ply", "endless.ply", "folder.ply", "garbage.ply", "s.knead", "thing.stl"}));
}

TEST_F(ErrorsTest, BadSessionsNameFileAndLine) {
  const std::vector<std::string> lines{
      R"({"tool": "smudge"})",
      R"({"tool": "implicit", "inner": 0.3, "outer": 0.9})",
      R"({"tool": "implicit", "inner": 0.9, "outer": 0.3, "path": [[0, 0, 0], [1, 0, 0]]})",
      R"({"tool": "implicit", "inner": 0.3, "outer": 0.9, "path": [[0, 0, 0], [1, 0, 0]], "colour": 1})",
      R"({"tool": "implicit", "inner": "x", "outer": 0.9, "path": [[0, 0, 0], [1, 0, 0]]})",
      R"({"tool": "implicit", "inner": 0.3, "outer": 1e999, "path": [[0, 0, 0], [1, 0, 0]]})",
      R"({"tool": "implicit", )",
      R"({"undo": 5})",
      R"([1, 2])",
  };
  for (const std::string& line : lines) {
    SCOPED_TRACE(line);
    write("bad.knead", "{\"knead\": 1}\n" + line + "\n");
    expect_error(knead({"deform", "a.ply", "bad.knead", "-o", "b.ply"}), 3, "knead: bad.knead:2: ");
    EXPECT_FALSE(std::filesystem::exists(path("b.ply")));
  }
  write("bad.knead", "");
  expect_error(knead({"deform", "a.ply", "bad.knead", "-o", "b.ply"}), 3, "knead: bad.knead");
}

TEST_F(ErrorsTest, UnwritableOutputIsFoundBeforeTheInputIsRead) {
  write("file", "");
  std::filesystem::create_directory(path("folder.ply"));
  for (const std::string out : {"no/such/b.ply", "file/b.ply", "folder.ply"}) {
    expect_error(knead({"deform", "none.ply", "none.knead", "-o", out}), 5, "knead: " + out + ": ");
    expect_error(knead({"make", "hand", "-o", out}), 5, "knead: " + out + ": ");
  }
  expect_error(knead({"resolve", "none.ply", "none.knead", "-o", "no/b.knead"}), 5, "knead: no/b.knead: ");
  expect_error(knead({"deform", "none.ply", "none.knead", "-o", "b.ply", "--report", "no/r.json"}), 5,
               "knead: no/r.json: ");
  expect_error(knead({"deform", "none.ply", "none.knead", "-o", "no/%d.ply", "--frames", "4"}), 5, "knead: no/0.ply: ");
  expect_error(knead({"make", "sphere", "-o", std::string(300, 'x') + ".ply"}), 5, "xxx.ply: ");
}

TEST_F(ErrorsTest, UnwritableFolder) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  std::filesystem::create_directory(path("locked"));
  std::filesystem::permissions(path("locked"), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  expect_error(knead({"deform", "none.ply", "none.knead", "-o", "locked/b.ply"}), 5, "knead: locked/b.ply: ");
}

TEST_F(ErrorsTest, FilesBeyondTheLimitOfTheProcess) {
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{10'000, old.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);  // the command inherits it
  const Outcome outcome = knead({"deform", "a.ply", "s.knead", "-q", "-o", "b.ply"});
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  expect_error(outcome, 5, "knead: b.ply: cannot be written");
  EXPECT_EQ(files(), (Words{"a.ply", "s.knead"}));
}

TEST_F(ErrorsTest, AStackThatIsTooSmall) {
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_STACK, &old), 0);
  const rlimit small{64 << 10, old.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_STACK, &small), 0);  // the command inherits it
  const Outcome outcome = knead({"deform", "a.ply", "s.knead", "-q", "-o", "b.ply"});
  ASSERT_EQ(::setrlimit(RLIMIT_STACK, &old), 0);
  expect_error(outcome, 1, "knead: the stack is limited to 64 KiB; allow at least 256: ulimit -s 8192");
}

TEST_F(ErrorsTest, FullOrClosedStandardOutput) {
  RunOptions full;
  full.stdout_path = "/dev/full";
  expect_error(knead({"info", "a.ply"}, full), 5, "knead: standard output: ");
  RunOptions closed;
  closed.closed_pipe = true;
  const Outcome outcome = knead({"info", "a.ply"}, closed);
  EXPECT_EQ(outcome.exit_code, 5);
  EXPECT_EQ(outcome.err, "") << "as where `head` has enough";
  expect_error(knead({"--help"}, full), 5, "knead: standard output: ");
}

TEST_F(ErrorsTest, ControlCharactersInNamesStayOnTheLine) {
  expect_error(knead({"info", "two\nlines\x1b[31m.ply"}), 3, "two\\x0alines\\x1b[31m.ply");
  expect_error(knead({"two\nlines"}), 2, "two\\x0alines");
}

TEST_F(ErrorsTest, DamagedFilesAreOneLineOrAreRead) {
  KNEAD_NEEDS_TEST_MESH("bad");
  for (const auto& entry : std::filesystem::directory_iterator(test_mesh("bad"))) {
    SCOPED_TRACE(entry.path());
    const Outcome outcome = knead({"info", entry.path().string()});
    if (outcome.exit_code != 0) expect_error(outcome, 3, entry.path().filename().string());
  }
}

}  // namespace
}  // namespace knead::command_test::errors_test
