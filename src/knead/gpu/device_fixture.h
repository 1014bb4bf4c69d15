// What the tests of this room have in common: a device, and how points are compared.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "knead/gpu/device.h"
#include "knead/math/box.h"

namespace knead::gpu {

// Whether that is why there is no device: then tests are skipped. One that is there and fails must not pass for none.
inline bool says_none(const std::string& failure) { return failure.starts_with("no graphics device"); }

// The device is shared by all tests of a suite, as it compiles each shader once. Where there is no OpenGL 4.3 the tests
// say so and are skipped.

class DeviceTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    try {
      shared() = std::make_unique<Device>();
      std::printf("device: %s\n", shared()->description().c_str());
    } catch (const DeviceError& error) {
      reason() = error.what();
    }
  }
  static void TearDownTestSuite() { shared().reset(); }

  void SetUp() override {
    if (shared() != nullptr) return;
    if (says_none(reason())) GTEST_SKIP() << reason();
    FAIL() << reason();
  }

  static Device& device() { return *shared(); }

  static std::vector<Vec3d> on_device(const Flow& flow, std::vector<Vec3d> points, const AdvectOptions& options) {
    EXPECT_EQ(device().advect(flow, points, options).status, AdvectStatus::done);
    return points;
  }

 private:
  // Why there is no device.
  static std::string& reason() {
    static std::string text;
    return text;
  }

  static std::unique_ptr<Device>& shared() {
    static std::unique_ptr<Device> device;
    return device;
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

inline std::vector<Vec3d> downloaded(Device& device, const DevicePoints& points) {
  std::vector<Vec3d> result(points.size());
  device.download(points, result);
  return result;
}

}  // namespace knead::gpu
