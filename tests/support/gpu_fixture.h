// For tests on a GPU: a shared GPU, and the comparison of points.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "knead/editor/gpu.h"
#include "knead/vec.h"
#include "support/outcome.h"

namespace knead::gpu {

using test::bits;

// Returns true if `failure` says that there is no GPU: then tests are skipped. A GPU that fails must fail the test.
inline bool says_none(const std::string& failure) { return failure.starts_with("no GPU"); }

// All tests of a suite share one GPU, because it compiles each shader once. Without OpenGL 4.3 the tests are skipped.
class GpuTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    try {
      shared() = std::make_unique<Gpu>();
      std::printf("GPU: %s\n", shared()->description().c_str());
    } catch (const GpuError& error) {
      reason() = error.what();
    }
  }
  static void TearDownTestSuite() { shared().reset(); }

  void SetUp() override {
    if (shared() != nullptr) return;
    if (says_none(reason())) GTEST_SKIP() << reason();
    FAIL() << reason();
  }

  static Gpu& gpu() { return *shared(); }

  static std::vector<Vec3d> on_gpu(const Flow& flow, std::vector<Vec3d> points, const AdvectOptions& options) {
    EXPECT_EQ(gpu().advect(flow, points, options).status, AdvectStatus::done);
    return points;
  }

 private:
  // Why there is no GPU.
  static std::string& reason() {
    static std::string text;
    return text;
  }

  static std::unique_ptr<Gpu>& shared() {
    static std::unique_ptr<Gpu> gpu;
    return gpu;
  }
};

inline AdvectOptions default_options(double diagonal) {
  AdvectOptions options;
  options.tolerance = 1e-5 * diagonal;
  return options;
}

inline std::vector<Vec3d> downloaded(Gpu& gpu, const GpuPoints& points) {
  std::vector<Vec3d> result(points.size());
  gpu.download(points, result);
  return result;
}

}  // namespace knead::gpu
