// knead deform --frames, and the progress bar.
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "knead/io.h"
#include "process.h"

namespace knead::command_test::frames_test {
namespace {

using Words = std::vector<std::string>;

class FramesTest : public CommandTest {
 protected:
  FramesTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kTwoStrokes);
  }

  // Writes a session of so many strokes that the words take at least a second, on any machine.
  void write_long_work(const Words& words) const {
    using Clock = std::chrono::steady_clock;
    std::string strokes;
    for (int i = 0; i < 100; ++i) {
      strokes +=
          "{\"tool\": \"implicit\", \"inner\": 0.3, \"outer\": 9, \"path\": [[0.9, 0, 0], [1.1, 0, 0], [0.9, 0, 0]]}\n";
    }
    for (int doublings = 0; doublings < 6; ++doublings) {
      write("long.knead", kNoStrokes + strokes);
      const Clock::time_point start = Clock::now();
      knead_ok(words);
      if (Clock::now() - start > std::chrono::seconds(1)) return;
      strokes += strokes;
    }
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

// PC2: a header of 32 bytes, and each frame's coordinates as floats.
TEST_F(FramesTest, OneFileHasTheFramesOfThePattern) {
  for (const Words& more : {Words{}, Words{"--ease", "smooth", "--hold", "2"}, Words{"--remesh"}}) {
    Words pattern{"deform", "a.ply", "s.knead", "-q", "--frames", "5", "-o", "F_%d.ply"};
    Words one{"deform", "a.ply", "s.knead", "-q", "--frames", "5", "-o", "all.pc2"};
    pattern.insert(pattern.end(), more.begin(), more.end());
    one.insert(one.end(), more.begin(), more.end());
    knead_ok(pattern);
    knead_ok(one);
    const std::size_t frames = more.size() > 1 ? 9 : 5;
    const std::string last = "F_" + std::to_string(frames - 1) + ".ply";
    const bool is_remeshed = more == Words{"--remesh"};
    const std::size_t size = 3 * sizeof(float) * read_shape(path(is_remeshed ? last : "a.ply")).mesh.vertex_count();
    const std::string bytes = read("all.pc2");
    ASSERT_EQ(bytes.size(), 32 + frames * size);
    for (std::size_t k = is_remeshed ? frames - 1 : 0; k < frames; ++k) {
      std::string expected;
      for (const Vec3d& p : read_shape(path("F_" + std::to_string(k) + ".ply")).mesh.positions) {
        for (const double x : {p.x, p.y, p.z}) {
          const auto number = static_cast<float>(x);
          expected.append(reinterpret_cast<const char*>(&number), sizeof number);
        }
      }
      EXPECT_TRUE(bytes.substr(32 + k * size, size) == expected) << k;
    }
  }
}

TEST_F(FramesTest, EveryAnimationIsWritten) {
  for (const std::string name : {"o.pc2", "o.mdd", "o.glb", "o.usda", "o.pvd"}) {
    knead_ok({"deform", "a.ply", "s.knead", "-o", name, "--frames", "3", "--fps", "30", "-q"});
    EXPECT_GT(read(name).size(), 100u) << name;
  }
  EXPECT_GT(read("o_0002.vtp").size(), read("a.ply").size());
}

TEST_F(FramesTest, OptionsOfAnAnimationAreChecked) {
  const Words start{"deform", "a.ply", "s.knead", "-o", "o.pc2"};
  for (const Words& wrong :
       {Words{}, Words{"--frames", "0"}, Words{"--frames", "3", "--fps", "0"}, Words{"--frames", "3", "--fps", "-1"},
        Words{"--frames", "3", "--hold", "-1"}, Words{"--frames", "3", "--ease", "bouncing"}}) {
    Words words = start;
    words.insert(words.end(), wrong.begin(), wrong.end());
    expect_error(knead(words), 2, " --help");
  }
  expect_error(knead({"deform", "a.ply", "s.knead", "-o", "o.ply", "--fps", "30"}), 2, "--frames N");
  EXPECT_EQ(files(), (Words{"a.ply", "s.knead"}));
}

TEST_F(FramesTest, ProgressBarOnATerminalOnly) {
  const Words words{"deform",      "big.ply", "long.knead",   "-o",  "b.ply",       "--threads", "1",
                    "--precision", "double",  "--integrator", "rk4", "--tolerance", "1e-10"};
  knead_ok({"make", "sphere", "-n", "60000", "-o", "big.ply", "-q"});
  write_long_work(words);
  RunOptions terminal;
  terminal.stderr_is_terminal = true;
  terminal.environment = {"TERM=xterm", "NO_COLOR=1"};
  const std::string bar = knead(words, terminal).err;
  EXPECT_NE(bar.find("%"), std::string::npos) << bar;
  EXPECT_NE(bar.find("\r["), std::string::npos) << bar;
  EXPECT_EQ(bar.find('\x1b'), std::string::npos) << bar;
  EXPECT_TRUE(bar.ends_with("\r")) << bar;
  EXPECT_EQ(bar.find("frames"), std::string::npos) << bar;
  Words frames = words;
  frames[4] = "b_%04d.ply";
  frames.insert(frames.end(), {"--frames", "3"});
  const std::string counted = knead(frames, terminal).err;
  EXPECT_NE(counted.find(" of 3 frames"), std::string::npos) << counted;
  terminal.environment = {"TERM=dumb"};
  EXPECT_EQ(knead(words, terminal).err, "");
  EXPECT_EQ(knead(words).err, "");
}

}  // namespace
}  // namespace knead::command_test::frames_test
