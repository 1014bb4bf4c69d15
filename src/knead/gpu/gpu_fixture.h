// What the tests of this room have in common: a GPU, and how points are compared.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "knead/gpu/gpu.h"
#include "knead/math/box.h"

namespace knead::gpu {

// Whether that is why there is no GPU: then tests are skipped. One that is there and fails must not pass for none.
inline bool says_none(const std::string& failure) { return failure.starts_with("no GPU"); }

// The GPU is shared by all tests of a suite, as it compiles each shader once. Where there is no OpenGL 4.3 the tests
// say so and are skipped.

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

inline std::vector<std::uint64_t> bits(const std::vector<Vec3d>& points) {
  std::vector<std::uint64_t> result;
  for (const Vec3d& p : points) {
    for (const double x : {p.x, p.y, p.z}) result.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return result;
}

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
