// knead deform and bench with --backend gpu. Where there is no OpenGL 4.3 what needs it is skipped.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/io.h"
#include "process.h"
#include "support/sanitized.h"

namespace knead::command_test::backend_test {
namespace {

using nlohmann::json;

class BackendTest : public CommandTest {
 protected:
  BackendTest() {
    knead_ok({"make", "sphere", "-n", "600", "-o", "a.ply", "-q"});
    write("one.knead", kOneStroke);
  }
};

TEST_F(BackendTest, TheGpuAgreesWithTheCpu) {
  knead_ok({"deform", "a.ply", "one.knead", "-o", "cpu.ply", "-q", "--report", "cpu.json"});
  const Outcome done = knead({"deform", "a.ply", "one.knead", "-o", "gpu.ply", "--backend", "gpu", "--report", "-"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json report = json::parse(done.out);
  if (report.at("backend") == "cpu") {
    // Only where there is no GPU: a GPU that fails must not pass for none.
    ASSERT_NE(done.err.find("no GPU"), std::string::npos) << done.err;
    GTEST_SKIP() << done.err;
  }
  EXPECT_EQ(report.at("backend"), "gpu");
  EXPECT_EQ(json::parse(read("cpu.json")).at("backend"), "cpu");
  for (const char* key : {"strokes", "segments", "moved_vertices"}) {
    EXPECT_EQ(report.at(key), json::parse(read("cpu.json")).at(key)) << key;
  }
  EXPECT_GT(report.at("vertex_steps").get<double>(), 0);
  const std::vector<Vec3d> before = read_shape(path("a.ply")).mesh.positions;
  const std::vector<Vec3d> cpu = read_shape(path("cpu.ply")).mesh.positions;
  const std::vector<Vec3d> gpu = read_shape(path("gpu.ply")).mesh.positions;
  ASSERT_EQ(cpu.size(), gpu.size());
  double furthest = 0;
  for (std::size_t i = 0; i < cpu.size(); ++i) {
    furthest = std::max(furthest, norm(cpu[i] - gpu[i]));
    EXPECT_EQ(cpu[i] == before[i], gpu[i] == before[i]) << i;
  }
  EXPECT_LT(furthest, 2e-5 * 3.46);  // of the diagonal
}

TEST_F(BackendTest, WithoutAGpuTheCpuDoesIt) {
  RunOptions blind;
  blind.environment = {"__EGL_VENDOR_LIBRARY_FILENAMES=/absent.json"};
  knead_ok({"deform", "a.ply", "one.knead", "-o", "cpu.ply", "-q"});
  const Outcome done =
      knead({"deform", "a.ply", "one.knead", "-o", "gpu.ply", "--backend", "gpu", "--report", "-"}, blind);
  EXPECT_EQ(done.exit_code, 0);
  if (json::parse(done.out).at("backend") == "gpu") GTEST_SKIP() << "this EGL is not to be blinded";
  EXPECT_EQ(done.err,
            "knead: note: no GPU with OpenGL 4.3 was found through EGL; install its driver, or Mesa's for the CPU; "
            "the CPU moves the points instead\n");
  EXPECT_EQ(read("gpu.ply"), read("cpu.ply"));
  const Outcome quiet = knead({"deform", "a.ply", "one.knead", "-o", "gpu.ply", "--backend", "gpu", "-q"}, blind);
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.err, "");
}

RunOptions failing(const std::string& how) {
  RunOptions options;
  options.environment = {"LD_PRELOAD=" KNEAD_FAILING_GPU, how};
  return options;
}

// Wherever the GPU is lost: the file is there, the GPU's or the CPU's, and a note says which.
TEST_F(BackendTest, AGpuThatIsLostUnderWayLosesNothing) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer's library must be the first";
  knead_ok({"deform", "a.ply", "one.knead", "-o", "cpu.ply", "-q"});
  const Outcome well = knead({"deform", "a.ply", "one.knead", "-o", "gpu.ply", "--backend", "gpu", "--report", "-"});
  if (well.err.find("no GPU") != std::string::npos) GTEST_SKIP() << well.err;
  ASSERT_EQ(json::parse(well.out).at("backend"), "gpu") << well.err;
  int lost = 0;
  for (int call = 1; call <= 8; ++call) {
    SCOPED_TRACE(call);
    const Outcome done = knead({"deform", "a.ply", "one.knead", "-o", "b.ply", "--backend", "gpu", "--report", "-"},
                               failing("KNEAD_TEST_LOSE_AT=" + std::to_string(call)));
    EXPECT_EQ(done.exit_code, 0);
    const bool by_cpu = json::parse(done.out).at("backend") == "cpu";
    EXPECT_EQ(read("b.ply"), read(by_cpu ? "cpu.ply" : "gpu.ply"));
    EXPECT_EQ(done.err.empty(), !by_cpu) << done.err;
    if (done.err ==
        "knead: note: the GPU does not answer; start again, or use the CPU; the CPU moves the points instead\n") {
      ++lost;
    }
  }
  EXPECT_GE(lost, 2);
}

TEST_F(BackendTest, AGpuWithoutMemoryLosesNothing) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer's library must be the first";
  knead_ok({"make", "sphere", "-n", "1500000", "-o", "a.ply", "-q"});  // buffers that malloc maps, each for itself
  const Outcome done = knead({"deform", "a.ply", "one.knead", "-o", "b.ply", "--backend", "gpu", "--report", "-"},
                             failing("KNEAD_TEST_STARVE=33554432"));
  EXPECT_EQ(done.exit_code, 0);
  if (json::parse(done.out).at("backend") == "gpu") {
    knead_ok({"make", "sphere", "-n", "200", "-o", "small.ply", "-q"});
    const Outcome bench = knead({"bench", "--backend", "gpu", "--json", "--mesh", "small.ply"});
    ASSERT_EQ(json::parse(bench.out).at("is_software"), false) << "memory that is the process's was to be had";
    GTEST_SKIP() << "the GPU's memory is its own";
  }
  if (done.err.find("no GPU") != std::string::npos) GTEST_SKIP() << done.err;
  EXPECT_EQ(done.err.find("knead: note: the GPU has too little memory left for "), 0u) << done.err;
  knead_ok({"deform", "a.ply", "one.knead", "-o", "cpu.ply", "-q"});
  EXPECT_EQ(read("b.ply"), read("cpu.ply"));
}

TEST_F(BackendTest, BenchHasEveryKey) {
  const Outcome done = knead({"bench", "--backend", "gpu", "--json", "--mesh", "a.ply"});
  if (done.err.find("no GPU") != std::string::npos) GTEST_SKIP() << done.err;
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json bench = json::parse(done.out);
  EXPECT_TRUE(bench.at("device").is_string());
  EXPECT_TRUE(bench.at("is_software").is_boolean());
  EXPECT_GT(bench.at("peak_gflops").get<double>(), 0);
  ASSERT_EQ(bench.at("rows").size(), 1u);
  const json& row = bench.at("rows")[0];
  EXPECT_EQ(row.at("scene"), "a.ply");
  for (const char* key : {"vertices", "steps_mean", "seconds", "ms_per_segment", "vertex_steps_per_s", "upload_seconds",
                          "download_seconds", "first_seconds", "cpu_seconds", "ratio", "peak_fraction", "max_error"}) {
    EXPECT_GT(row.at(key).get<double>(), 0) << key;
  }
  EXPECT_GE(row.at("steps_mean").get<double>(), 20);  // segments
  EXPECT_LT(row.at("max_error").get<double>(), 1e-5);
  EXPECT_LT(row.at("peak_fraction").get<double>(), 1);
  const json knot = json::parse(knead_ok({"bench", "--backend", "gpu", "--json", "-n", "2000"})).at("rows");
  ASSERT_EQ(knot.size(), 1u);
  EXPECT_EQ(knot[0].at("scene"), "knot 2000");
  EXPECT_NEAR(knot[0].at("vertices").get<double>(), 2000, 200);
  expect_error(knead({"bench", "--backend", "gpu", "--integrators"}), 2, "leave --backend out");
  expect_error(knead({"bench", "-n", "2000"}), 2, "--vertices is for --backend gpu");
}

}  // namespace
}  // namespace knead::command_test::backend_test
