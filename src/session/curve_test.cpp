// Tests of the tool "curve": arcs, paths, twists, placing by the box, what is refused, and numbers that work.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <regex>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "session/curve_bar.h"

namespace knead::curve_test {

namespace {

// What a message says after these words.
std::string named(const std::string& message, const std::string& words) {
  std::smatch match;
  const bool is_there = std::regex_search(message, match, std::regex(words + " (-?[0-9.]+)"));
  EXPECT_TRUE(is_there) << message;
  return is_there ? match[1].str() : "0";
}

}  // namespace

// The whole bar is an arc: its end has turned by exactly the angle.
TEST(Curve, ABarBecomesAnArc) {
  const Mesh mesh = bar(12, 0.5, 0.5);
  for (const double angle : {90.0, 270.0, -120.0, 310.0}) {
    const std::vector<Vec3d> moved = after(mesh, "curve axis=0,0,1 angle_deg=" + std::to_string(angle));
    const double volume = measure_volume_and_area(mesh, moved).volume;
    EXPECT_NEAR(volume / 12, 1, 1e-3) << "of straight edges";
    const Vec3d from = moved[1] - moved[0];
    const Vec3d to = moved[4 * (kRings - 1) + 1] - moved[4 * (kRings - 1)];
    const double radians = angle * std::numbers::pi / 180;
    EXPECT_NEAR(dot(from, to) / norm2(from), std::cos(radians), 1e-9);
    EXPECT_NEAR(cross(from, to).z / norm2(from), std::sin(radians), 1e-9);
  }
}

// Slices across the line that hold a point or two have no normal, and so meet none.
TEST(Curve, FewPointsFollowALine) {
  for (const std::uint32_t count : {20U, 100U, 300U}) {
    Mesh cloud;
    for (std::uint32_t i = 0; i < count; ++i) {  // on a sphere, by the golden angle
      const double z = 1 - 2 * (i + 0.5) / count;
      const double r = std::sqrt(1 - z * z);
      cloud.positions.push_back({r * std::cos(i * 2.399963), r * std::sin(i * 2.399963), z});
    }
    for (const char* stroke : {"longer_by=0.2", "twist_deg=40", "longer_by=0.1 twist_deg=-60"}) {
      const std::string words = std::string("curve from=0,0.1,-0.3;0,-0.1,0.4 ") + stroke;
      EXPECT_EQ(refusal_of(cloud, words), "not refused") << count;
    }
  }
}

// A bend by more than 170 degrees of all of a bar needs no solve: its end has turned by exactly the angle, rigidly, and
// what is before the zone rests. A bar that is too thick for the arc is solved for, or refused.
TEST(Curve, TakesTheStrongBendOfAllOfAShape) {
  const Mesh mesh = bar(12, 0.5, 0.5);
  for (const double angle : {172.0, -180.0, 270.0}) {
    BendStroke bend;
    bend.center = {0, 0.2, 0};
    bend.axis = {0, 0, 1};
    bend.normal = {1, 0, 0};
    bend.angle_deg = angle;
    bend.extent = BendThresholds{-5.5, 5.5};
    Session session;
    session.strokes = {{bend}};
    const ReplayResult result = Replay(borrow(mesh), session, {}).run();
    ASSERT_EQ(result.resolved.size(), 1U);
    EXPECT_TRUE(std::holds_alternative<CurveStroke>(result.resolved[0].stroke));
    const std::vector<Vec3d> moved(result.shape.positions().begin(), result.shape.positions().end());
    EXPECT_NEAR(measure_volume_and_area(mesh, moved).volume / 12, 1, 1e-3) << "of straight edges";
    const double radians = angle * std::numbers::pi / 180;
    for (std::uint32_t ring = 0; ring < kRings; ++ring) {
      const std::uint32_t at = 4 * ring;
      if (mesh.positions[at].x > 5.51) {
        EXPECT_EQ(moved[at], mesh.positions[at]);
      }
      if (mesh.positions[at].x > -5.51) continue;
      const Vec3d side = moved[at + 1] - moved[at];
      EXPECT_NEAR(side.y, std::cos(radians), 1e-9);
      EXPECT_NEAR(side.x, -std::sin(radians), 1e-9);
    }
    EXPECT_LT(surface_stretch(triangulate(mesh), mesh.positions, moved).worst(), 1.5);
  }
}

// The face towards the cylinder lies on it, the other one where the volume takes it.
TEST(Curve, AFlatSolidIsWrappedRoundACylinder) {
  const Mesh mesh = bar(40, 3, 1);
  const std::vector<Vec3d> moved = after(mesh, "curve around=30");
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const double radius = std::hypot(moved[i].x, moved[i].z + 1 + 30);
    const bool is_below = mesh.positions[i].z < 0;
    EXPECT_NEAR(radius, is_below ? 30 : 30 * std::sqrt(1 + 4.0 / 30), 1e-9);
    EXPECT_NEAR(moved[i].y, mesh.positions[i].y, 1e-9);
  }
}

TEST(Curve, TheLineGoesThroughThePointsOfAPath) {
  const std::vector<Vec3d> path{{0, 0, 0}, {3, 0, 1}, {5, 2, 3}, {7, 2, 6}, {7, -1, 9}};
  CurveStroke stroke;
  stroke.from = {{10, 0, 0}, {22, 0, 0}};
  stroke.to = path;
  stroke.length = CurveLength::fit;
  std::vector<Vec3d> line;
  for (int i = 0; i <= 12'000; ++i) line.push_back({10 + 0.001 * i, 0, 0});
  AdvectOptions options;
  options.tolerance = 1e-5;
  ASSERT_EQ(advect(flow_of(stroke), line, options).status, AdvectStatus::done);
  EXPECT_LE(norm(line.front() - path.front()), 0.02);
  EXPECT_LE(norm(line.back() - path.back()), 0.02);
  for (const Vec3d& p : path) {
    double nearest = 1e9;
    for (const Vec3d& x : line) nearest = std::min(nearest, norm(x - p));
    EXPECT_LE(nearest, 0.02);
  }
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += norm(line[i] - line[i - 1]);
  stroke.length = CurveLength::keep;
  stroke.fixed = CurveFixed::start;
  std::vector<Vec3d> kept{{10, 0, 0}, {22, 0, 0}};
  ASSERT_EQ(advect(flow_of(stroke), kept, options).status, AdvectStatus::done);
  EXPECT_LE(norm(kept[0] - path[0]), 0.02);
  EXPECT_GT(length, 13) << "the path is longer, so that the shape ends on its way";
  EXPECT_GT(norm(kept[1] - path.back()), length - 12 - 0.2 - 2);
}

// A curve that goes back to the line from which it came is the inverse.
TEST(Curve, ABentLineBecomesStraightAgain) {
  CurveStroke there;
  there.from = {{0, 0, 0}, {12, 0, 0}};
  there.to = {{0, 0, 0}, {4, 0, 1}, {8, 1, 3}, {10, 2, 6}};
  there.fixed = CurveFixed::start;
  CurveStroke back = there;
  std::swap(back.from, back.to);
  std::vector<Vec3d> points;
  for (int i = 0; i < 100; ++i) points.push_back({0.12 * i, 0.3 * std::sin(i), 0.3 * std::cos(3 * i)});
  const std::vector<Vec3d> before = points;
  AdvectOptions options;
  options.tolerance = 1e-5;
  ASSERT_EQ(advect(flow_of(there), points, options).status, AdvectStatus::done);
  ASSERT_EQ(advect(flow_of(back), points, options).status, AdvectStatus::done);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].x, before[i].x, 0.03);
    EXPECT_NEAR(std::hypot(points[i].y, points[i].z), std::hypot(before[i].y, before[i].z), 0.03);
  }
}

TEST(Curve, ATwistTurnsTheEndAndLeavesTheFixedOne) {
  const Mesh mesh = bar(12, 0.5, 0.5);
  const std::vector<Vec3d> moved = after(mesh, "curve from=-5,0,0;5,0,0 twist_deg=90 fixed=start");
  EXPECT_EQ(moved[0], mesh.positions[0]);
  const std::size_t last = moved.size() - 4;
  EXPECT_NEAR(norm(moved[last] - Vec3d{6, 0.5, -0.5}), 0, 1e-9) << "(-y, -z) goes to (y, -z)";
}

// The ends of the shape, and what is beyond them, where no other end of a ring is near.
TEST(Curve, TwistsWeakBendsAndLengthsAreTakenBackEverywhere) {
  for (const std::string turn :
       {"twist_deg=180", "twist_deg=90", "axis=0,1,0 angle_deg=60", "axis=0,1,0 angle_deg=1", "longer_by=5",
        "longer_by=-5 keep=thickness", "axis=0,1,0 angle_deg=40 longer_by=3 keep=thickness"}) {
    const Flow flow = flow_of(parse_stroke("curve from=-6.4,0,0;0,0,0;6.4,0,0 " + turn, "stroke").stroke);
    std::vector<Vec3d> before;
    for (int i = 0; i <= 160; ++i) before.push_back({0.1 * (i - 80), 0.4 * std::sin(i), 0.4 * std::cos(3 * i)});
    std::vector<Vec3d> points = before;
    AdvectOptions options;
    options.tolerance = 1e-5;
    ASSERT_EQ(advect(flow, points, options).status, AdvectStatus::done);
    ASSERT_EQ(advect(inverse(flow), points, options).status, AdvectStatus::done);
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_LE(norm(points[i] - before[i]), 1e-8) << turn << ' ' << i;
  }
}

TEST(Curve, WhatIsTooThickIsRefusedWithAnAngleThatWorks) {
  const Mesh mesh = bar(12, 2, 0.5);
  const std::string message = refusal_of(mesh, "curve axis=0,0,1 angle_deg=270");
  EXPECT_NE(message.find("inner side"), std::string::npos) << message;
  const std::string angle = named(message, "at most");
  EXPECT_GT(std::stod(angle), 140);
  after(mesh, "curve axis=0,0,1 angle_deg=" + angle);
}

TEST(Curve, WhatMeetsItselfIsRefusedWithAnAngleThatWorks) {
  const Mesh mesh = bar(12, 0.5, 0.5);
  const std::string message = refusal_of(mesh, "curve axis=0,0,1 angle_deg=450");
  EXPECT_NE(message.find("meet itself"), std::string::npos) << message;
  const std::string angle = named(message, "at most");
  EXPECT_GT(std::stod(angle), 300);
  EXPECT_LE(std::stod(angle), 360);
  after(mesh, "curve axis=0,0,1 angle_deg=" + angle);
  after(mesh, "curve axis=0,0,1 angle_deg=450 strength=0.7");
  EXPECT_NE(refusal_of(mesh, "curve from=-6,0,0;6,0,0 to=-6,0,0;0,0,0;1,3,0;0,4,0;-1,3,0;0,0.2,0;6,0.3,0 fixed=start")
                .find("strength"),
            std::string::npos);
  const std::string path = "curve twist_deg=40 to=-6,0,0;-2,0,0;0,0,0.2;0.3,0,1;0.3,0,6";
  after(mesh, path + " strength=" + named(refusal_of(mesh, path), "at most"));
}

// Bars of several proportions become rings. The gap between their ends gets smaller than the bar is thick. The inverse
// brings every point back to its own end.
TEST(Curve, RingsThatNearlyCloseAreTakenBack) {
  for (const auto& [thick, angle] :
       {std::pair(0.5, 300.0), std::pair(0.5, 340.0), std::pair(0.3, 352.0), std::pair(0.1, 357.0)}) {
    const Mesh mesh = bar(12.2, 0.2, thick);
    const auto stroke = parse_stroke(
        "curve from=-6.4,0,0;0,0,0;6.4,0,0 axis=0,1,0 angle_deg=" + std::to_string(angle * 125 / 122), "stroke");
    const Flow flow = flow_of(stroke.stroke);
    std::vector<Vec3d> points = mesh.positions;
    AdvectOptions options;
    options.tolerance = 1e-5;
    ASSERT_EQ(advect(flow, points, options).status, AdvectStatus::done);
    ASSERT_EQ(advect(inverse(flow), points, options).status, AdvectStatus::done);
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_LE(norm(points[i] - mesh.positions[i]), 1e-9) << angle;
  }
  const Mesh mesh = bar(12, 0.5, 0.5);
  after(mesh, "curve axis=0,1,0 angle_deg=350");
  EXPECT_NE(refusal_of(mesh, "curve axis=0,1,0 angle_deg=365").find("meet itself"), std::string::npos);
}

// The stroke that makes a spring of three turns with radius 1 out of a bar.
Session spring(double pitch) {
  CurveStroke stroke;
  for (int i = 0; i <= 36; ++i) {
    const double turn = 2 * std::numbers::pi * i / 12;
    stroke.to.push_back({std::cos(turn), std::sin(turn), pitch * turn / (2 * std::numbers::pi)});
  }
  Session session;
  session.strokes.resize(1);
  session.strokes[0].stroke = stroke;
  return session;
}

// Also where a bar's corners are nearer to a station of the next turn than to one of their own. Bars that are as wide
// as the turns are apart have corners for which the next turn itself is nearer: they are refused.
TEST(Curve, SpringsAreTakenBackOrRefused) {
  for (const double wide : {0.2, 0.5, 0.75, 0.79}) {
    SCOPED_TRACE(wide);
    const Mesh mesh = bar(19.1, 0.5 * wide, 0.15);
    const ReplayResult there = Replay(borrow(mesh), spring(0.8), {}).run();
    Session resolved;
    resolved.strokes = there.resolved;
    ReplayOptions back;
    back.part.direction = Direction::backwards;
    const Mesh bent = there.shape.to_mesh();
    const auto restored = [&] { return Replay(borrow(bent), resolved, back).run(); };
    if (wide > 0.7) {
      EXPECT_THROW(restored(), InvalidInput);
      continue;
    }
    const ReplayResult result = restored();
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      ASSERT_LE(norm(result.shape.positions()[i] - mesh.positions[i]), 1e-8);
    }
  }
}

// A part of a bar, and the whole: exactly so much longer. The ends stay rigid; the middle gets thinner, or does not.
TEST(Curve, BecomesLongerByALength) {
  const Mesh mesh = bar(12, 0.5, 0.3);
  const auto across = [](const Vec3d& p) { return std::hypot(p.y, p.z); };
  for (const bool keeps : {false, true}) {
    const std::string keep = keeps ? " keep=thickness" : "";
    for (const double by : {2.0, -1.5}) {
      const std::vector<Vec3d> part =
          after(mesh, fmt::format("curve from=-2,0,0;2,0,0 fixed=start longer_by={}{}", by, keep));
      for (std::size_t i = 0; i < part.size(); ++i) {
        const Vec3d& before = mesh.positions[i];
        if (std::abs(before.x) >= 2) {
          const Vec3d rigid = before + Vec3d{before.x > 0 ? by : 0, 0, 0};
          EXPECT_LE(norm(part[i] - rigid), 1e-9) << before.x;
        } else if (keeps) {
          EXPECT_NEAR(across(part[i]), across(before), 1e-12);
        }
      }
    }
    const std::vector<Vec3d> whole = after(mesh, "curve longer_by=3" + keep);
    for (std::size_t i = 0; i < whole.size(); ++i) {
      EXPECT_NEAR(whole[i].x, mesh.positions[i].x * 15 / 12, 1e-9);
      EXPECT_NEAR(across(whole[i]), across(mesh.positions[i]) * (keeps ? 1 : std::sqrt(12.0 / 15)), 1e-9);
    }
  }
  EXPECT_NE(refusal_of(mesh, "curve longer_by=-11.9").find("can lose"), std::string::npos);
  EXPECT_NE(refusal_of(mesh, "curve around=30 longer_by=1").find("\"longer_by\" goes with"), std::string::npos);
}

// A relief on a cylinder keeps its height; with the volume kept it gets lower.
TEST(Curve, AWrapKeepsTheThicknessIfAsked) {
  const Mesh mesh = bar(12, 1, 0.25);
  const std::vector<Vec3d> kept = after(mesh, "curve around=3 axis=0,1,0 keep=thickness");
  const std::vector<Vec3d> lower = after(mesh, "curve around=3 axis=0,1,0");
  const double axis = -0.25 - 3;  // of the cylinder, below the bar
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const double far = std::hypot(kept[i].x, kept[i].z - axis);
    EXPECT_NEAR(far, 3 + mesh.positions[i].z + 0.25, 1e-9);
    EXPECT_LE(std::hypot(lower[i].x, lower[i].z - axis), far + 1e-9);
  }
}

TEST(Curve, OnlyWhatIsWithinTheRadiusMoves) {
  Mesh mesh = bar(12, 0.5, 0.5);
  const std::size_t first = mesh.positions.size();
  add_bar(mesh, 12, 0.5, 0.5, {0, 4, 0});
  const std::vector<Vec3d> moved = after(mesh, "curve from=-6,0,0;6,0,0 axis=0,0,1 angle_deg=-90 radius=auto");
  EXPECT_NE(moved[0], mesh.positions[0]);
  for (std::size_t i = first; i < moved.size(); ++i) EXPECT_EQ(moved[i], mesh.positions[i]);
  const std::string message = refusal_of(mesh, "curve from=-6,0,0;6,0,0 axis=0,0,1 angle_deg=-90 radius=0.6");
  EXPECT_NE(message.find("would tear"), std::string::npos) << message;
  after(mesh, "curve from=-6,0,0;6,0,0 axis=0,0,1 angle_deg=-90 radius=" + named(message, "triangles;"));
}

// All of the shape lies where the curvature of an arc is constant, so that its ends stay flat.
TEST(Curve, TheLongestAxisIsTheLineOfAnArcWithoutFrom) {
  const Mesh mesh = bar(12, 0.5, 0.4);
  const std::vector<Vec3d> axis = longest_axis(bounding_box(mesh.positions), 5);
  ASSERT_EQ(axis.size(), 5U);
  const double tip = 6 * 128 / 122.0;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT(norm(axis[i] - Vec3d{tip * (0.5 * static_cast<double>(i) - 1), 0, 0}), 1e-12) << i;
  }
  EXPECT_TRUE(longest_axis(Box{{1, 1, 1}, {1, 1, 1}}, 5).empty());
}

// All of the shape lies where stretch, twist and curvature of a path are those asked for, its ends too.
TEST(Curve, APathWithoutFromTakesAllOfTheShape) {
  const Mesh mesh = bar(12, 0.5, 0.4);
  const std::size_t last = mesh.positions.size() - 4;
  for (const double longer : {1.5, 0.6}) {
    const std::vector<Vec3d> moved =
        after(mesh, fmt::format("curve to=1,0,0;{},0,0 length=fit twist_deg=90", 1 + 12 * longer));
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const Vec3d& x = mesh.positions[i];
      EXPECT_NEAR(moved[i].x, 1 + (x.x + 6) * longer, 1e-9) << i;
      EXPECT_NEAR(std::hypot(moved[i].y, moved[i].z), std::hypot(x.y, x.z) / std::sqrt(longer), 1e-9) << i;
    }
    const double turned = dot(moved[1] - moved[0], moved[last + 1] - moved[last]) * longer;
    EXPECT_NEAR(turned, 0, 1e-9) << "the end has turned by 90 degrees against the start";
  }
  for (const auto& [fixed, start] : {std::pair("start", 0.0), std::pair("middle", 1.5), std::pair("end", 3.0)}) {
    const std::vector<Vec3d> kept = after(mesh, fmt::format("curve to=0,0,0;0,15,0 fixed={}", fixed));
    EXPECT_NEAR(kept[0].y, start, 1e-9) << fixed;
    EXPECT_NEAR(kept[last].y, start + 12, 1e-9) << fixed;
  }
}

TEST(Curve, TheFixedEndOfAnArcWithoutFromRests) {
  const Mesh mesh = bar(12, 0.5, 0.4);
  const std::size_t last = mesh.positions.size() - 4;
  for (const char* const aim : {"angle_deg=90", "around=10", "twist_deg=90", "longer_by=3 twist_deg=1"}) {
    // Sections change their size, but neither their plane nor their direction.
    const auto moved_by = [&](const char* fixed, std::size_t first) {
      const std::vector<Vec3d> moved = after(mesh, fmt::format("curve {} fixed={}", aim, fixed));
      double most = norm(normalized(moved[first + 1] - moved[first]) - Vec3d{0, 1, 0});
      for (std::size_t i = first; i < first + 4; ++i) most = std::max(most, std::abs(moved[i].x - mesh.positions[i].x));
      return most;
    };
    EXPECT_LT(moved_by("start", 0), 1e-9) << aim;
    EXPECT_LT(moved_by("end", last), 1e-9) << aim;
  }
}

// What a stroke becomes reads no surface, and gives the same bits.
TEST(Curve, APlacedPathIsResolvedToALineWithItsRamps) {
  const Mesh mesh = bar(12, 0.5, 0.4);
  Session session;
  session.strokes = {parse_stroke("curve to=0,0,0;5,0,1;9,2,4 length=fit twist_deg=30", "stroke")};
  const ReplayResult placed = Replay(borrow(mesh), session, {}).run();
  session.strokes = placed.resolved;
  const ReplayResult again = Replay(borrow(mesh), parse_session(serialize_session(session), "resolved"), {}).run();
  EXPECT_TRUE(std::ranges::equal(placed.shape.positions(), again.shape.positions()));
}

TEST(Curve, PointsOnALineHaveEqualLengthsBetweenThem) {
  const std::vector<Vec3d> points{{0, 0, 0}, {0, 0, 0}, {1, 0.5, 0}, {4, 0, 1}, {5, 3, 0}};
  const std::vector<Vec3d> coarse = points_on_line(points, 6);
  const std::vector<Vec3d> fine = points_on_line(points, 5001);
  EXPECT_EQ(coarse.front(), points.front());
  EXPECT_LT(norm(coarse.back() - points.back()), 1e-12);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_LT(norm(coarse[i] - fine[1000 * i]), 1e-9) << i;
  const auto is_on_line = [&](const Vec3d& p) {
    return std::any_of(fine.begin(), fine.end(), [&](const Vec3d& q) { return norm(p - q) < 2e-3; });
  };
  for (const Vec3d& p : points) EXPECT_TRUE(is_on_line(p));
  EXPECT_EQ(points_on_line({{1, 2, 3}, {1, 2, 3}}, 5).size(), 1U);
}

// A noisy arc of radius 3, drawn from the right to the left.
TEST(Curve, ADrawnArcLosesItsNoiseAndKeepsItsRadius) {
  const Mesh mesh = bar(9, 0.3, 0.3);
  std::vector<Vec3d> drawn;
  for (int i = 0; i <= 150; ++i) {
    const double angle = std::numbers::pi * i / 150;
    const double radius = 3 + 0.05 * std::sin(2.4 * i) + 0.03 * std::sin(1.1 * i * i);
    drawn.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  const std::vector<Vec3d> from = longest_axis(bounding_box(mesh.positions), 5);
  const std::vector<Vec3d> line = smoothed_line(drawn, from, mesh.positions);
  const std::vector<Vec3d> places = points_on_line(line, 301);
  for (std::size_t i = 30; i <= 270; ++i) EXPECT_NEAR(norm(places[i]), 3, 0.02) << i;
  EXPECT_LT(norm(line.front() - drawn.back()), 1e-12) << "the left end of the shape is at the left end of the line";
  EXPECT_TRUE(smoothed_line({{1, 0, 0}, {1, 0, 0}}, from, mesh.positions).empty());
}

// Two right angles, sharper than the bar can follow.
TEST(Curve, DrawnCornersBecomeBendsThatTheShapeFollows) {
  const Mesh mesh = bar(12, 0.5, 0.5);
  const std::vector<Vec3d> from = longest_axis(bounding_box(mesh.positions), 5);
  const std::vector<Vec3d> drawn{{-3, 4, 0}, {-3, 0, 0}, {3, 0, 0}, {3, 4, 0}};
  Session session;
  session.strokes = {{curve_between(from, smoothed_line(drawn, from, mesh.positions))}};
  EXPECT_EQ(Replay(borrow(mesh), session, {}).run().status, AdvectStatus::done);
  session.strokes = {{curve_between(from, {{-3, 4, 0}, {-3, 2, 0}, {-3, 0.1, 0}, {-2.9, 0, 0}, {0, 0, 0}, {3, 0, 0}})}};
  EXPECT_THROW(Replay(borrow(mesh), session, {}).run(), InvalidInput);
}

// On a straight line as the smooth line through its handles; on a winding one only what is near the handle moves.
TEST(Curve, AMovedHandleTakesTheLineAlongSmoothlyAndNoOtherHandle) {
  const std::vector<Vec3d> straight = points_on_line({{-6, 0, 0}, {6, 0, 0}}, kPointsOfLine);
  const std::vector<Vec3d> moved = with_handle_moved(straight, 4, 1, {0, 0.3, 0});
  const std::vector<Vec3d> smooth = points_on_line({{-6, 0, 0}, {-3, 0.3, 0}, {0, 0, 0}, {3, 0, 0}, {6, 0, 0}}, 2001);
  for (const Vec3d& p : moved) {
    double least = 1;
    for (const Vec3d& q : smooth) least = std::min(least, norm(p - q));
    EXPECT_LT(least, 0.01) << p.x;
  }
  std::vector<Vec3d> spiral;
  for (int i = 0; i <= 16; ++i) spiral.push_back({std::cos(0.7 * i), std::sin(0.7 * i), 0.2 * i});
  for (const std::size_t stride : {std::size_t(4), std::size_t(8)}) {
    for (std::size_t handle = 0; handle <= 16 / stride; ++handle) {
      const std::vector<Vec3d> after_it = with_handle_moved(spiral, stride, handle, {0.1, 0, 0.2});
      for (std::size_t i = 0; i <= 16; i += stride) {
        const Vec3d by = i == handle * stride ? Vec3d{0.1, 0, 0.2} : Vec3d{0, 0, 0};
        EXPECT_LT(norm(after_it[i] - spiral[i] - by), 1e-12) << handle << ' ' << i;
      }
    }
  }
}

TEST(Curve, ThickShapesHaveFewerHandles) {
  for (const auto& [thick, stride] : {std::pair(0.5, 4), std::pair(3.0, 8)}) {
    const Mesh mesh = bar(12, thick, thick);
    const std::vector<Vec3d> line = longest_axis(bounding_box(mesh.positions), kPointsOfLine);
    EXPECT_EQ(points_between_handles(line, mesh.positions), static_cast<std::size_t>(stride)) << thick;
  }
}

TEST(Curve, TheEndThatMovesLessIsFixed) {
  const std::vector<Vec3d> from{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_EQ(curve_between(from, {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}}).fixed, CurveFixed::start);
  EXPECT_EQ(curve_between(from, {{0, 1, 0}, {1, 0, 0}, {2, 0.2, 0}}).fixed, CurveFixed::end);
  EXPECT_EQ(curve_between(from, {{0, 0, 0}, {1, 1, 0}, {2, 0, 0}}).fixed, CurveFixed::middle);
  EXPECT_EQ(curve_between(from, from).from.size(), 2U) << "a straight line is given by its ends";
  const std::vector<Vec3d> bent{{0, 0, 0}, {1, 0.1, 0}, {2, 0, 0}};
  EXPECT_EQ(curve_between(bent, from).from, bent);
}

TEST(Curve, WrongKeysAreRefusedInOneLine) {
  const Mesh mesh = bar(12, 0.5, 0.5);
  EXPECT_NE(refusal_of(mesh, "curve from=0,0,0;1,0,0").find("\"to\" is missing"), std::string::npos);
  EXPECT_NE(refusal_of(mesh, "curve angle_deg=10 around=3").find("exclude"), std::string::npos);
  EXPECT_NE(refusal_of(mesh, "curve from=0,0,0;1,0,0 angle_deg=10").find("\"axis\" is missing"), std::string::npos);
  EXPECT_NE(refusal_of(mesh, "curve from=0,0,0;1,0,0 angle_deg=10 axis=1,0,0").find("across"), std::string::npos);
  EXPECT_NE(refusal_of(mesh, "curve twist_deg=10 mirror=x").find("\"mirror\""), std::string::npos);
  EXPECT_NE(refusal_of(mesh, "curve from=0,0,0;0,0,0 twist_deg=10").find("repeats"), std::string::npos);
}

}  // namespace knead::curve_test
