// A bar for tests of the tool "curve", and what a stroke makes of it.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::curve_test {

inline constexpr std::uint32_t kRings = 193;

// A closed bar along x from -length / 2 on, in rings of four corners: (-y, -z), (y, -z), (y, z), (-y, z).
inline void add_bar(Mesh& mesh, double length, double y, double z, const Vec3d& at = {0, 0, 0}) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t i = 0; i < kRings; ++i) {
    const double x = length * (i / (kRings - 1.0) - 0.5);
    for (const auto& [v, w] : {std::pair(-y, -z), std::pair(y, -z), std::pair(y, z), std::pair(-y, z)})
      mesh.positions.push_back(at + Vec3d{x, v, w});
  }
  for (std::uint32_t i = 0; i + 1 < kRings; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t a = first + 4 * i + k;
      const std::uint32_t b = first + 4 * i + (k + 1) % 4;
      mesh.add_face(std::array{a, b, a + 4});
      mesh.add_face(std::array{b, b + 4, a + 4});
    }
  }
  const std::uint32_t end = first + 4 * (kRings - 1);
  for (const auto& face : {std::array{0U, 1U, 2U}, std::array{0U, 2U, 3U}}) {
    mesh.add_face(std::array{first + face[2], first + face[1], first + face[0]});
    mesh.add_face(std::array{end + face[0], end + face[1], end + face[2]});
  }
}

inline Mesh bar(double length, double y, double z) {
  Mesh mesh;
  add_bar(mesh, length, y, z);
  return mesh;
}

// The positions after a stroke.
inline std::vector<Vec3d> after(const Mesh& mesh, const std::string& stroke) {
  Session session;
  session.strokes = {parse_stroke(stroke, "stroke")};
  const ReplayResult result = Replay(borrow(mesh), session, {}).run();
  EXPECT_EQ(result.status, AdvectStatus::done);
  const auto& positions = result.shape.positions();
  return {positions.begin(), positions.end()};
}

inline std::string refusal_of(const Mesh& mesh, const std::string& stroke) {
  try {
    after(mesh, stroke);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "not refused";
}

}  // namespace knead::curve_test
