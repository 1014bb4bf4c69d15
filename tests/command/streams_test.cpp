// Standard input and output, decimals, links, and values that are refused.
#include <fmt/format.h>

#include <sys/stat.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "process.h"

namespace knead::command_test::streams_test {
namespace {

using Words = std::vector<std::string>;

class StreamsTest : public CommandTest {
 protected:
  StreamsTest() {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kOneStroke);
  }

  Outcome piped(const Words& words, const std::string& input) const {
    return knead(words, {.stdin_path = path(input).string()});
  }
};

TEST_F(StreamsTest, DeformFromStandardInputToStandardOutput) {
  knead_ok({"deform", "a.ply", "s.knead", "-o", "b.ply", "-q"});
  const Outcome outcome = piped({"deform", "-", "s.knead", "--format", "ply", "-o", "-"}, "a.ply");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, read("b.ply"));
  const Outcome to_file = piped({"deform", "-", "s.knead", "--format", "ply", "-o", "c.ply", "-q"}, "a.ply");
  EXPECT_EQ(to_file.exit_code, 0) << to_file.err;
  EXPECT_EQ(read("c.ply"), read("b.ply"));
}

TEST_F(StreamsTest, OtherSubcommands) {
  EXPECT_EQ(knead({"make", "sphere", "-n", "642", "-o", "-", "--format", "ply"}).out, read("a.ply"));
  const std::string info = piped({"info", "-", "--format", "ply", "--json"}, "a.ply").out;
  EXPECT_EQ(info, knead_ok({"info", "a.ply", "--json"}));
  EXPECT_EQ(piped({"info", "-", "--format", "ply", "--no-topology"}, "a.ply").out,
            knead_ok({"info", "a.ply", "--no-topology"}));
  EXPECT_EQ(piped({"check", "-", "--format", "ply", "--require", "closed", "-q"}, "a.ply").exit_code, 0);
  EXPECT_EQ(piped({"resolve", "-", "s.knead", "--format", "ply", "-o", "r.knead", "-q"}, "a.ply").exit_code, 0);
  EXPECT_EQ(knead_ok({"resolve", "a.ply", "s.knead", "-o", "-"}), read("r.knead"));
  EXPECT_EQ(piped({"render", "-", "--format", "obj", "-o", "r.png", "-q"}, "a.ply").exit_code, 3) << "a PLY file";
  knead_ok({"remesh", "a.ply", "-o", "fine.ply", "-q"});
  EXPECT_EQ(piped({"remesh", "-", "--format", "ply", "-o", "-"}, "a.ply").out, read("fine.ply"));
}

TEST_F(StreamsTest, AClosedPipeIsNoMessage) {
  const auto shell = [&](const std::string& line) {
    const std::string command = fmt::format("cd '{}' && {}", path("").string(), line);
    return std::system(command.c_str());
  };
  EXPECT_EQ(
      shell(fmt::format("({} make sphere -n 100000 -o - --format obj 2> err.txt) | head -1 > out.txt", KNEAD_COMMAND)),
      0);
  EXPECT_EQ(read("err.txt"), "");
  EXPECT_EQ(read("out.txt").substr(0, 2), "v ");
  for (const char* const help : {"--help", "deform --help", "--version"}) {
    EXPECT_EQ(shell(fmt::format("(sleep 0.2; {} {} 2> err.txt) | true", KNEAD_COMMAND, help)), 0);
    EXPECT_EQ(read("err.txt"), "") << help;
  }
}

TEST_F(StreamsTest, APipeCannotBeReadInPieces) {
  ASSERT_EQ(::mkfifo(path("pipe.ply").c_str(), 0600), 0);
  expect_error(knead({"deform", "pipe.ply", "s.knead", "--stream", "-o", "b.ply"}), 3,
               "it is no plain file but a pipe");
}

TEST_F(StreamsTest, DoublesForFloatsAreRefusedAtOnce) {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  write("cloud.ply", ply + std::string(24, '\0'));
  expect_error(knead({"deform", "cloud.ply", "s.knead", "--stream", "--precision", "double", "-o", "b.ply"}), 2,
               "--precision double writes other types");
  knead_ok({"deform", "cloud.ply", "s.knead", "--stream", "-q", "-o", "b.ply"});
}

TEST_F(StreamsTest, WhatIsRefused) {
  const std::vector<std::pair<Words, std::string>> wrong{
      {{"info", "-"}, "add --format"},
      {{"info", "a.ply", "--format", "ply"}, "no file is -"},
      {{"resolve", "a.ply", "s.knead", "-o", "-", "--json"}, "standard output takes the result"},
      {{"render", "-", "-", "--format", "ply", "-o", "a.png"}, "only one shape can be -"},
      {{"info", "-", "--format", "step"}, "no such format"},
      {{"deform", "a.ply", "s.knead", "-o", "-", "--format", "ply", "--json"}, "standard output takes the result"},
      {{"deform", "a.ply", "s.knead", "-o", "-", "--format", "ply", "--report", "-"}, "takes the result"},
      {{"deform", "a.ply", "s.knead", "-o", "b.ply", "--threads", "100000"}, "give 1 to 1024"},
      {{"remesh", "a.ply", "-o", "b.ply", "--threads", "1025"}, "give 1 to 1024"},
      {{"deform", "a.ply", "s.knead", "-o", "b.ply", "--digits", "many"}, "auto, shortest, or a number"},
      {{"deform", "a.ply", "s.knead", "-o", "b.ply", "--digits", "18"}, "from 0 to 17"},
      {{"deform", "a.ply", "s.knead", "-o", "b.ply", "--digits", "4", "--check"}, "certificate"},
  };
  for (const auto& [words, part] : wrong) {
    SCOPED_TRACE(part);
    expect_error(knead(words), 2, part);
  }
  EXPECT_EQ(files(), (Words{"a.ply", "s.knead"}));
}

TEST_F(StreamsTest, EveryEmptyValueIsAnError) {
  const Words deform{"deform", "a.ply", "s.knead", "-o", "b.ply"};
  for (const std::string option : {"--until", "--tolerance", "--integrator", "--precision", "--backend", "--threads",
                                   "--require", "--frames", "--report", "--digits", "--format", "--max-edge"}) {
    SCOPED_TRACE(option);
    Words words = deform;
    words.insert(words.end(), {option, ""});
    expect_error(knead(words), 2, option);
    words = deform;
    words.push_back(option + "=");
    expect_error(knead(words), 2, option);
  }
  expect_error(knead({"info", ""}), 2, "empty");
  expect_error(knead({"deform", "a.ply", "s.knead", "-o", ""}), 2, "--output");
}

// Clouds that go through in pieces have the bytes of those that do not.
TEST_F(StreamsTest, CloudsInPiecesAreTheSame) {
  std::string scan = "// X Y Z Intensity\n";
  for (int i = 0; i < 900; ++i) {
    scan += fmt::format("{:.4f} {:.4f} {:.4f} {}\n", 0.7 + 0.0005 * i, 0.3 * std::sin(i), 0.3 * std::cos(i), i % 256);
  }
  write("scan.xyz", scan);
  knead_ok({"deform", "scan.xyz", "s.knead", "-o", "whole.xyz", "-q"});
  EXPECT_NE(read("whole.xyz"), scan);
  const Words stream{"deform", "scan.xyz", "s.knead", "--stream", "--piece-mb", "0.003", "-o", "pieces.xyz"};
  const std::string done = knead(stream).out;
  EXPECT_NE(done.find("vertices moved by 1 stroke, in 8 pieces"), std::string::npos) << done;
  EXPECT_EQ(read("pieces.xyz"), read("whole.xyz"));
  const auto with = [&](const Words& more) {
    Words words = stream;
    words.insert(words.end(), more.begin(), more.end());
    return knead(words);
  };
  expect_error(with({"--check"}), 2, "--stream: --check needs the whole cloud");
  expect_error(with({"--remesh"}), 2, "--remesh");
  expect_error(knead({"deform", "scan.xyz", "s.knead", "--stream", "-o", "b.ply"}), 2, "format of the cloud");
  expect_error(knead({"deform", "a.ply", "s.knead", "--stream", "-o", "b.ply"}), 3, "rows of 'face'");
  write("paint.knead",
        "{\"knead\": 1}\n{\"tool\": \"paint\", \"path\": [[0.9, 0, 0], [1, 0, 0]], \"outer\": 0.2, \"depth\": 0.1}\n");
  expect_error(knead({"deform", "scan.xyz", "paint.knead", "--stream", "-o", "b.xyz"}), 3, "knead resolve");
}

TEST_F(StreamsTest, AnOutputThatIsADanglingLinkCreatesItsTarget) {
  std::filesystem::create_directory(path("sub"));
  std::filesystem::create_symlink("sub/target.ply", path("link.ply"));
  std::filesystem::create_symlink("link.ply", path("second.ply"));
  knead_ok({"deform", "a.ply", "s.knead", "-o", "second.ply", "-q"});
  EXPECT_TRUE(std::filesystem::is_symlink(path("second.ply")));
  EXPECT_TRUE(std::filesystem::is_symlink(path("link.ply")));
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(path("sub/target.ply"))));
  std::filesystem::create_symlink("nowhere/target.ply", path("lost.ply"));
  expect_error(knead({"deform", "a.ply", "s.knead", "-o", "lost.ply", "-q"}), 5, "does not exist");
}

// Points of a scan with four decimals; a stroke moves some.
TEST_F(StreamsTest, DigitsOfTheFile) {
  write("scan.xyz", "0.9000 0.0000 0.0000\n100.0000 0.0000 0.0000\n0.9512 0.0100 0.0200\n");
  const auto digits = [&](const Words& more) {
    Words words{"deform", "scan.xyz", "s.knead", "-o", "out.xyz", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(knead(words).exit_code, 0);
    return read("out.xyz");
  };
  const auto longest = [](const std::string& text) {
    std::size_t most = 0;
    for (std::size_t point = text.find('.'); point != std::string::npos; point = text.find('.', point + 1)) {
      most = std::max(most, text.find_first_of(" \n", point) - point - 1);
    }
    return most;
  };
  const std::string automatic = digits({});
  EXPECT_EQ(longest(automatic), 4u);
  EXPECT_NE(automatic.find("\n100.0000 0.0000 0.0000\n"), std::string::npos);
  EXPECT_GT(longest(digits({"--tolerance", "1e-7"})), 6u);  // four decimals are coarser than that
  EXPECT_GT(longest(digits({"--digits", "shortest"})), 6u);
  EXPECT_GT(longest(digits({"--check"})), 6u);
  const std::string two = digits({"--digits", "2"});
  EXPECT_NE(two.find("\n100.0000 0.0000 0.0000\n"), std::string::npos);  // it did not move
  EXPECT_EQ(two.find(' ') - two.find('.'), 3u);
}

TEST_F(StreamsTest, AnInterruptionAfterTheOutputIsInPlaceExitsWithNothingWrong) {
  int in_place = 0;
  for (int i = 0; i < 40; ++i) {
    std::filesystem::remove(path("out.ply"));
    Process process({"make", "sphere", "-n", "20000", "-o", "out.ply"}, folder());
    for (int k = 0; k < 20000 && !std::filesystem::exists(path("out.ply")); ++k) {
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    ASSERT_TRUE(std::filesystem::exists(path("out.ply")));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    ++in_place;
  }
  EXPECT_EQ(in_place, 40);
}

TEST_F(StreamsTest, CoarseCoordinatesAreNoted) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n";
  for (const char* axis : {"x", "y", "z"}) text += std::string("property float ") + axis + "\n";
  text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  write("far.ply", text + "450000 5400000 300\n450001 5400000 300\n450000 5400001 300\n3 0 1 2\n");
  const Outcome far = knead({"info", "far.ply"});
  EXPECT_NE(far.out.find("floats that lie 0.5 apart where the shape stands, and its mean edge is 1.14"),
            std::string::npos)
      << far.out;
  write("near.ply", text + "45 54 300\n46 54 300\n45 55 300\n3 0 1 2\n");
  EXPECT_EQ(knead_ok({"info", "near.ply"}).find("apart"), std::string::npos);
}

}  // namespace
}  // namespace knead::command_test::streams_test
