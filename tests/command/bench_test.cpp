// knead bench.
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "process.h"

namespace knead::command_test::bench_test {
namespace {

using nlohmann::json;

using BenchTest = CommandTest;

// The keys that scripts read; that every figure is one, and that what is measured is right.
TEST_F(BenchTest, OfAMeshHasEveryKey) {
  knead_ok({"make", "sphere", "-n", "300", "-o", "s.ply", "-q"});
  const json bench = json::parse(knead_ok({"bench", "--json", "--mesh", "s.ply"}));
  for (const char* key : {"threads", "fma_gflops", "fma_scaling", "copy_gigabytes_per_s"}) {
    EXPECT_GT(bench.at(key).get<double>(), 0) << key;
  }
  EXPECT_TRUE(bench.at("simd").is_string());
  ASSERT_EQ(bench.at("rows").size(), 1u);
  const json& row = bench.at("rows")[0];
  EXPECT_EQ(row.at("scene"), "s.ply");
  EXPECT_EQ(row.at("tool"), "ball");
  EXPECT_EQ(row.at("precision"), "float");
  EXPECT_EQ(row.at("threads"), 1);
  const json info = json::parse(knead_ok({"info", "s.ply", "--json"}));
  EXPECT_EQ(row.at("vertices"), info.at("vertices"));
  EXPECT_EQ(row.at("touched"), info.at("vertices"));  // nobody is outside
  for (const char* key : {"steps_mean", "seconds", "steps_per_s", "vertex_steps_per_s", "reference_vertex_steps_per_s",
                          "ratio", "peak_fraction", "max_error", "reference_max_error"}) {
    EXPECT_GT(row.at(key).get<double>(), 0) << key;
  }
  EXPECT_GE(row.at("steps_mean").get<double>(), 20);  // segments
  EXPECT_LT(row.at("max_error").get<double>(), 1e-5);
  EXPECT_LT(row.at("reference_max_error").get<double>(), 1e-5);
}

// Ours keeps what is beyond the brush; those that people would use instead do not.
TEST_F(BenchTest, ComparesStrokesOnClosedMeshes) {
  knead_ok({"make", "sphere", "-n", "300", "-o", "s.ply", "-q"});
  knead_ok({"make", "sphere", "-n", "300", "-o", "p.xyz", "-q"});
  EXPECT_EQ(json::parse(knead_ok({"bench", "--json", "--mesh", "p.xyz"})).at("peers"), json::array());
  const json peers = json::parse(knead_ok({"bench", "--json", "--mesh", "s.ply"})).at("peers");
  ASSERT_EQ(peers.size(), 9u);
  for (const json& row : peers) {
    const bool ours = row.at("method") == "knead";
    EXPECT_GT(row.at("seconds").get<double>(), 0);
    EXPECT_LT(std::abs(row.at("volume_error").get<double>()), 0.2);
    EXPECT_EQ(row.at("self_intersections_before"), 0);
    EXPECT_TRUE(row.at("self_intersections_after").is_number_unsigned());
    EXPECT_EQ(row.at("motion_beyond_outer").get<double>() == 0, ours) << row;
  }
}

TEST_F(BenchTest, SaysWhichIntegratorIsSoonest) {
  knead_ok({"make", "sphere", "-n", "12", "-o", "s.ply", "-q"});
  const json bench = json::parse(knead_ok({"bench", "--integrators", "--json", "--mesh", "s.ply"}));
  EXPECT_GE(bench.at("integrators").size(), 7u * 2 * (4 + 4));  // scenes, methods, tolerances but for slow ones
  for (const json& run : bench.at("integrators")) {
    EXPECT_GT(run.at("seconds").get<double>(), 0) << run;
    EXPECT_LT(run.at("max_error").get<double>(), std::max(1e-6, 10 * run.at("tolerance").get<double>())) << run;
  }
  ASSERT_EQ(bench.at("times_to_error").size(), 4u + 6u);
  for (const json& times : bench.at("times_to_error")) EXPECT_EQ(times.at("seconds").size(), 2u);
  EXPECT_EQ(bench.at("soonest_by_default"), bench.at("times_to_error")[2].at("soonest"));
}

TEST_F(BenchTest, RefusesWhatItCannotRead) { EXPECT_EQ(knead({"bench", "--mesh", "absent.ply"}).exit_code, 3); }

// A copy of the command, apart from the other programs of the build.
class BenchProgramTest : public CommandTest {
 protected:
  BenchProgramTest() { std::filesystem::copy_file(KNEAD_COMMAND, path("knead")); }

  // Runs it with these words. Leaves what it prints in the files out and err.
  int run(const std::string& words) const {
    const std::string line = "cd '" + folder().string() + "' && PATH=/absent ./knead " + words + " >out 2>err";
    return WEXITSTATUS(std::system(line.c_str()));
  }
};

TEST_F(BenchProgramTest, IsAskedForWhereItIsAbsent) {
  EXPECT_EQ(run("bench --json --mesh s.ply"), 1);
  EXPECT_EQ(read("out"), "");
  const std::string err = read("err");
  EXPECT_EQ(err.find("knead: knead-bench was found neither next to this command nor on PATH; "), 0u) << err;
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_EQ(run("bench --help"), 0);
  EXPECT_NE(read("out").find("--integrators"), std::string::npos);
  EXPECT_EQ(run("bench --colour"), 2);
}

TEST_F(BenchProgramTest, GetsTheWordsAndGivesTheExitCode) {
  write("knead-bench", "#!/bin/sh\nprintf '%s|' \"$@\"\nexit 4\n");
  std::filesystem::permissions(path("knead-bench"), std::filesystem::perms::owner_all);
  EXPECT_EQ(run("bench --json --mesh 'a b.ply' --mesh c.ply"), 4);
  EXPECT_EQ(read("out"), "--json|--mesh|a b.ply|--mesh|c.ply|");
  EXPECT_EQ(run("bench"), 4);
}

}  // namespace
}  // namespace knead::command_test::bench_test
