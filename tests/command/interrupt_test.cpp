// Interruptions leave nothing half-written.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "process.h"

namespace knead::command_test::interrupt_test {
namespace {

using namespace std::chrono_literals;
using Words = std::vector<std::string>;

class InterruptTest : public CommandTest {
 protected:
  // Minutes of work.
  InterruptTest() {
    std::string text = kNoStrokes;
    for (int i = 0; i < 20000; ++i) {
      text +=
          "{\"tool\": \"implicit\", \"inner\": 0.3, \"outer\": 9, \"path\": [[0.9, 0, 0], [1.1, 0, 0], [0.9, 0, 0]]}\n";
    }
    write("long.knead", text);
    knead_ok({"make", "sphere", "-n", "200000", "-o", "big.ply", "-q"});
  }
};

TEST_F(InterruptTest, LeavesNoFile) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Process process({"deform", "big.ply", "long.knead", "-o", "out.ply", "--report", "r.json"}, folder());
    std::this_thread::sleep_for(1500ms);
    process.send(signal);
    expect_error(process.wait(), 130, "interrupted");
    EXPECT_EQ(files(), (Words{"big.ply", "long.knead"}));
  }
}

TEST_F(InterruptTest, AtAnyMoment) {
  for (const auto delay : {20ms, 60ms, 120ms, 250ms, 400ms}) {
    Process process({"deform", "big.ply", "long.knead", "-o", "out.ply"}, folder());
    std::this_thread::sleep_for(delay);
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    const bool before_main = outcome.exit_code == -SIGINT;  // on a busy machine
    if (!before_main) expect_error(outcome, 130, "interrupted");
    EXPECT_EQ(files(), (Words{"big.ply", "long.knead"}));
  }
}

TEST_F(InterruptTest, KeepsTheOldOutput) {
  write("out.ply", "old");
  Process process({"deform", "big.ply", "long.knead", "-o", "out.ply"}, folder());
  std::this_thread::sleep_for(1000ms);
  process.send(SIGINT);
  EXPECT_EQ(process.wait().exit_code, 130);
  EXPECT_EQ(read("out.ply"), "old");
}

// The file is not there or whole: an interruption that comes after the renaming finds it whole.
TEST_F(InterruptTest, WhileWriting) {
  const Words make{"make", "sphere", "-n", "300000", "-q", "-o"};
  const auto run = [&](const std::string& name) {
    Words words = make;
    words.push_back(name);
    return words;
  };
  const auto start = std::chrono::steady_clock::now();
  knead_ok(run("whole.obj"));
  const auto whole_time = std::chrono::steady_clock::now() - start;
  const std::string whole = read("whole.obj");
  constexpr int moments = 16;
  for (int i = 1; i <= moments; ++i) {
    Process process(run("out.obj"), folder());
    std::this_thread::sleep_for(whole_time * i / moments);
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 130 || outcome.exit_code == -SIGINT)
        << outcome.exit_code;
    const bool written = std::filesystem::exists(path("out.obj"));
    EXPECT_TRUE(!written || read("out.obj") == whole);
    std::filesystem::remove(path("out.obj"));
    EXPECT_TRUE(written || outcome.exit_code != 0);
    EXPECT_EQ(files(), (Words{"big.ply", "long.knead", "whole.obj"}));
  }
}

// An interruption after the last file is in place is none.
TEST_F(InterruptTest, WhileFramesAreWritten) {
  knead_ok({"make", "sphere", "-n", "20000", "-q", "-o", "a.ply"});
  write("s.knead",
        kNoStrokes + R"({"tool": "implicit", "inner": 0.3, "outer": 0.9, "path": [[0, 0, 1], [0, 0.5, 1.2]]})");
  const Words words{"deform", "a.ply", "s.knead", "--frames", "30", "-q", "-o", "o.glb"};
  const auto start = std::chrono::steady_clock::now();
  knead_ok(words);
  const auto whole_time = std::chrono::steady_clock::now() - start;
  const std::string whole = read("o.glb");
  constexpr int moments = 20;
  for (int i = 1; i <= moments; ++i) {
    write("o.glb", "old");
    Process process(words, folder());
    std::this_thread::sleep_for(whole_time * (moments + i) / (2 * moments));
    process.send(SIGTERM);
    const Outcome outcome = process.wait();
    EXPECT_EQ(read("o.glb"), outcome.exit_code == 0 ? whole : "old") << outcome.exit_code;
  }
}

}  // namespace
}  // namespace knead::command_test::interrupt_test
