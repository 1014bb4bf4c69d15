// Tests of the tool "curve": thicker or thinner between two points, and tapers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "session/curve_bar.h"
#include "support/random_fields.h"

namespace knead::curve_test {

// The middle of a part: exactly so thick, and the volume or the length stays; beyond its ends it is rigid. With an axis
// the other direction stays.
TEST(Curve, GetsThickerByALength) {
  const double half_z = 0.3;
  const Mesh mesh = bar(12, 0.5, half_z);
  for (const std::string keep : {"", " keep=length"}) {
    for (const std::string axis : {"", " axis=0,0,1"}) {
      for (const double by : {0.4, -0.3}) {
        SCOPED_TRACE(fmt::format("{}{} {}", keep, axis, by));
        const double factor = 1 + by / (2 * half_z);
        const double wider = axis.empty() ? factor : 1;
        const std::vector<Vec3d> part =
            after(mesh, fmt::format("curve from=-4,0,0;4,0,0 fixed=start thicker_by={}{}{}", by, keep, axis));
        for (std::size_t i = 0; i < part.size(); ++i) {
          const Vec3d& before = mesh.positions[i];
          if (!keep.empty()) {
            EXPECT_NEAR(part[i].x, before.x, 1e-12);
          }
          if (before.x <= -4) {
            EXPECT_EQ(part[i], before);
          }
          if (before.x >= 4) {
            EXPECT_LE(
                norm(part[i] - part[mesh.positions.size() - 4] + mesh.positions[mesh.positions.size() - 4] - before),
                1e-9);
          }
          if (std::abs(before.x) > 4 * (1 - 6.0 / 32)) continue;
          EXPECT_NEAR(part[i].z, before.z * factor, 1e-9);
          EXPECT_NEAR(part[i].y, before.y * wider, 1e-9);
        }
        const double volume = measure_volume_and_area(mesh, part).volume;
        const double same = measure_volume_and_area(mesh, mesh.positions).volume;
        if (keep.empty()) {
          EXPECT_NEAR(volume / same, 1, 1e-3) << "of straight edges";
        } else {
          EXPECT_EQ(volume > same, by > 0);
        }
        const std::vector<Vec3d> whole =
            after(mesh, fmt::format("curve thickness={}{}{}", 2 * half_z + by, keep, axis));
        for (std::size_t i = 0; i < whole.size(); ++i) {
          const double longer = keep.empty() ? 1 / (factor * wider) : 1;
          const Vec3d& before = mesh.positions[i];
          EXPECT_LE(norm(whole[i] - Vec3d{before.x * longer, before.y * wider, before.z * factor}), 1e-9);
        }
      }
    }
  }
}

// The end, and what is beyond it, exactly so thick; between the points a straight cone.
TEST(Curve, TapersToAThickness) {
  const Mesh mesh = bar(12, 0.5, 0.3);
  for (const std::string keep : {"", " keep=length"}) {
    for (const double to : {0.2, 1.5}) {
      SCOPED_TRACE(fmt::format("{} {}", keep, to));
      const double factor = to / 0.6;
      const std::vector<Vec3d> moved =
          after(mesh, fmt::format("curve from=-4,0,0;3,0,0 fixed=start taper=true thickness={}{}", to, keep));
      if (keep.empty()) {
        EXPECT_NEAR(measure_volume_and_area(mesh, moved).volume / 7.2, 1, 1e-3);
      }
      for (std::size_t i = 0; i < moved.size(); ++i) {
        const Vec3d& before = mesh.positions[i];
        if (before.x <= -4) {
          EXPECT_EQ(moved[i], before);
        }
        if (before.x < 3) continue;
        EXPECT_NEAR(moved[i].z, before.z * factor, 1e-9);
        EXPECT_NEAR(moved[i].y, before.y * factor, 1e-9);
      }
      // A straight line between the soft ends.
      const Vec3d& first = moved[4 * 56];
      const Vec3d& last = moved[4 * 120];
      for (std::size_t ring = 56; ring < 120; ++ring) {
        const Vec3d& p = moved[4 * ring];
        const double share = (p.x - first.x) / (last.x - first.x);
        EXPECT_NEAR(p.z, first.z + (last.z - first.z) * share, 2e-4);
      }
    }
  }
  const std::vector<Vec3d> whole = after(mesh, "curve taper=true thicker_by=-0.3 fixed=start");
  EXPECT_EQ(whole.front(), mesh.positions.front());
  EXPECT_NEAR(std::abs(whole.back().z), 0.15, 1e-9);
}

// Rods of several sizes and directions with coarse sides: what is measured on the result is what was asked for, and the
// resolved stroke takes it back.
TEST(Curve, AnyRodGetsTheThicknessThatWasAskedFor) {
  test::Random random(3);
  for (int i = 0; i < 10; ++i) {
    const double size = std::pow(10.0, i % 7 - 3);
    Mesh mesh = bar(12, random.uniform(0.2, 1), random.uniform(0.2, 1));
    const double thin = 2 * std::min(mesh.positions[2].y, mesh.positions[2].z);
    const RigidMotion turn = rotation_about(random.in_box(3), random.in_box(1), random.uniform(0, 3));
    for (Vec3d& p : mesh.positions) p = turn(p) * size;
    CurveStroke stroke;
    stroke.from = {turn(Vec3d{-5, 0, 0}) * size, turn(Vec3d{random.uniform(0, 6), 0, 0}) * size};
    stroke.taper = i % 2 == 0;
    stroke.keep = i % 3 == 0 ? CurveKeeps::length : CurveKeeps::volume;
    stroke.thickness = thin * size * random.uniform(0.4, 2);
    Session session;
    session.strokes.resize(1);
    session.strokes[0].stroke = stroke;
    const ReplayResult there = Replay(borrow(mesh), session, {}).run();
    EXPECT_NEAR(*std::get<CurveStroke>(there.resolved.at(0).stroke).thickness_before, thin * size, 1e-9 * size);
    const auto& moved = there.shape.positions();
    const double middle =
        dot(stroke.from[1] - turn(Vec3d{0, 0, 0}) * size, normalized(stroke.from[1] - stroke.from[0])) / size;
    const double wanted = stroke.taper ? 6 : 0.5 * (middle - 5);
    const auto ring = static_cast<std::size_t>(std::lround((wanted + 6) / 12 * (kRings - 1)));
    const double across =
        std::min(norm(moved[4 * ring + 1] - moved[4 * ring]), norm(moved[4 * ring + 2] - moved[4 * ring + 1]));
    EXPECT_NEAR(across, *stroke.thickness, 1e-9 * size);
    Session resolved;
    resolved.strokes = there.resolved;
    ReplayOptions back;
    back.part.direction = Direction::backwards;
    const Mesh made = there.shape.to_mesh();
    const ReplayResult restored = Replay(borrow(made), resolved, back).run();
    for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
      ASSERT_LE(norm(restored.shape.positions()[k] - mesh.positions[k]), 1e-9 * size);
    }
  }
}

TEST(Curve, RefusesAThicknessThatCannotBe) {
  const Mesh mesh = bar(12, 0.5, 0.3);
  const auto refused = [&](const std::string& keys) { return refusal_of(mesh, "curve " + keys); };
  EXPECT_NE(refused("thicker_by=-0.6").find("0.6 thick"), std::string::npos);
  EXPECT_NE(refused("thickness=7").find("from 0.06 to 6"), std::string::npos);
  EXPECT_NE(refused("taper=true thickness=1 from=0,0,0;8,0,0").find("no thickness at the line's end"),
            std::string::npos);
  EXPECT_NE(refused("thickness=1 angle_deg=20").find("another stroke"), std::string::npos);
  EXPECT_NE(refused("thickness=1 thicker_by=2").find("exclude each other"), std::string::npos);
  EXPECT_NE(refused("thickness=1 keep=thickness").find("\"keep\" must be"), std::string::npos);
  EXPECT_NE(refused("taper=true twist_deg=3").find("\"taper\" needs"), std::string::npos);
  EXPECT_NE(refused("keep=length twist_deg=3").find("\"keep\" \"length\" needs"), std::string::npos);
}

}  // namespace knead::curve_test
