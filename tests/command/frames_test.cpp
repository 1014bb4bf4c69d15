// knead deform --frames, and the progress bar.
#include <filesystem>
#include <string>
#include <vector>

#include "process.h"

namespace knead::command_test {
namespace {

using Words = std::vector<std::string>;

class FramesTest : public CommandTest {
 protected:
  FramesTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kTwoStrokes);
  }

  // A session that takes some seconds on a large sphere.
  void write_long_work() const {
    std::string text = kNoStrokes;
    for (int i = 0; i < 100; ++i) {
      text +=
          "{\"tool\": \"implicit\", \"inner\": 0.3, \"outer\": 9, \"path\": [[0.9, 0, 0], [1.1, 0, 0], [0.9, 0, 0]]}\n";
    }
    write("long.knead", text);
    knead_ok({"make", "sphere", "-n", "20000", "-o", "big.ply", "-q"});
  }
};

TEST_F(FramesTest, FromTheStartToTheResult) {
  knead_ok({"deform", "a.ply", "s.knead", "-o", "F_%04d.ply", "--frames", "5", "-q"});
  EXPECT_EQ(files(), (Words{"F_0000.ply", "F_0001.ply", "F_0002.ply", "F_0003.ply", "F_0004.ply", "a.ply", "s.knead"}));
  EXPECT_EQ(read("F_0000.ply"), read("a.ply"));
  knead_ok({"deform", "a.ply", "s.knead", "-o", "all.ply", "-q"});
  EXPECT_EQ(read("F_0004.ply"), read("all.ply"));
  for (const std::string until : {"0.5", "1", "1.5"}) {
    knead_ok({"deform", "a.ply", "s.knead", "-o", "until" + until + ".ply", "-q", "--until", until});
  }
  EXPECT_EQ(read("F_0001.ply"), read("until0.5.ply"));
  EXPECT_EQ(read("F_0002.ply"), read("until1.ply"));
  EXPECT_EQ(read("F_0003.ply"), read("until1.5.ply"));
}

TEST_F(FramesTest, OneFrameIsTheResult) {
  knead_ok({"deform", "a.ply", "s.knead", "-o", "100%%_%d.ply", "--frames", "1", "-q"});
  knead_ok({"deform", "a.ply", "s.knead", "-o", "all.ply", "-q"});
  EXPECT_EQ(read("100%_0.ply"), read("all.ply"));
}

TEST_F(FramesTest, PatternsNeedOneNumber) {
  for (const std::string pattern : {"F.ply", "F_%s.ply", "%d_%d.ply", "F_%4d.ply", "F_%00d.ply", "F_%", "..%2f_%d.ply",
                                    "F_%04x.ply", "F_%%d.ply", "F_%d.dxf", "F_%-4d.ply", "F_%0123d.ply"}) {
    expect_error(knead({"deform", "a.ply", "s.knead", "-o", pattern, "--frames", "2"}), 2, " --help");
  }
  EXPECT_EQ(files(), (Words{"a.ply", "s.knead"}));
}

TEST_F(FramesTest, ProgressBarOnATerminalOnly) {
  write_long_work();
  // More than half a second, on any machine.
  const Words words{"deform",      "big.ply", "long.knead",   "-o",   "b.ply",       "--threads", "1",
                    "--precision", "double",  "--integrator", "bs32", "--tolerance", "1e-10"};
  RunOptions terminal;
  terminal.stderr_is_terminal = true;
  terminal.environment = {"TERM=xterm", "NO_COLOR=1"};
  const std::string bar = knead(words, terminal).err;
  EXPECT_NE(bar.find("%"), std::string::npos) << bar;
  EXPECT_NE(bar.find("\r["), std::string::npos) << bar;
  EXPECT_EQ(bar.find('\x1b'), std::string::npos) << bar;
  EXPECT_TRUE(bar.ends_with("\r")) << bar;
  terminal.environment = {"TERM=dumb"};
  EXPECT_EQ(knead(words, terminal).err, "");
  EXPECT_EQ(knead(words).err, "");
}

}  // namespace
}  // namespace knead::command_test
