// The tool "stamp": contact with a surface, depth, the support radius and refusals.
#include "strokes/stamp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"

namespace knead::stamp_test {
namespace {

using detail::Contact;
using detail::find_contacts;
using detail::StampTool;

// A shape under a stamp, and the strokes that it was given.
class Bench {
 public:
  explicit Bench(const Mesh& shape)
      : shape_(shape), positions_(shape.positions), triangles_(triangulate(shape)), start_(positions_) {}

  StampResult stamp(const StampStroke& stroke, const Mesh& tool, int threads = 0) {
    return knead::stamp(stroke, tool, surface(), threads);
  }

  LiveSurface surface() {
    LiveSurface surface;
    surface.positions = positions_;
    surface.triangles = triangles_;
    surface.apply = [this](const Stroke& stroke) {
      apply(stroke);
      return strokes_.size() < limit_;
    };
    return surface;
  }

  void apply(const Stroke& stroke) {
    strokes_.push_back(stroke);
    AdvectOptions options;
    options.tolerance = 1e-5;
    advect(flow_of(stroke), positions_, options);
  }

  void stop_after(std::size_t strokes) { limit_ = strokes; }

  const std::vector<Vec3d>& positions() const { return positions_; }
  const std::vector<Stroke>& strokes() const { return strokes_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  bool moved(std::size_t vertex) const { return positions_[vertex] != start_[vertex]; }
  bool moved() const { return positions_ != start_; }
  double volume_error() const {
    return measure_volume_and_area(shape_, positions_).volume / measure_volume_and_area(shape_, start_).volume - 1;
  }

 private:
  Mesh shape_;
  std::vector<Vec3d> positions_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3d> start_;
  std::vector<Stroke> strokes_;
  std::size_t limit_ = 1'000'000;
};

Mesh sphere(std::size_t vertices) { return make_shape(ShapeKind::sphere, vertices); }

Mat3d scaling(double s) { return {{s, 0, 0}, {0, s, 0}, {0, 0, s}}; }

// A ball of radius 0.4, pressed 0.1 deep into the unit sphere from above.
StampStroke ball_from_above() {
  StampStroke stroke;
  stroke.mesh = "ball.ply";
  stroke.path = {{0, 0, 1.45}, {0, 0, 1.3}};
  stroke.pose = scaling(0.4);
  stroke.outer = 0.6;
  return stroke;
}

// A quarter of the step of outer / 25 = 0.024: so late may a place be pushed.
TEST(Stamp, PushesTheSurfaceOutOfTheTool) {
  Bench bench(sphere(4002));
  const StampResult result = bench.stamp(ball_from_above(), sphere(642));
  EXPECT_EQ(result.outer, 0.6);
  EXPECT_EQ(result.step, 0.6 / 25);
  EXPECT_EQ(result.steps, 7U);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_LT(result.penetration, 0.006);
  EXPECT_GT(std::count_if(bench.positions().begin(), bench.positions().end(),
                          [](const Vec3d& p) {
                            return norm(p - Vec3d{0, 0, 1.3}) < 0.42;
                          }),
            20);
  EXPECT_EQ(self_intersections(bench.triangles(), bench.positions()).count, 0U);
  // By sampling: a dent some 20 edges wide (method, section 3, has 1e-3 at 10,000 vertices for a stronger pull).
  EXPECT_LT(std::abs(bench.volume_error()), 3e-4);
}

TEST(Stamp, BecomesPointsStrokesThatRepeatIt) {
  Bench stamped(sphere(4002));
  const StampStroke stroke = ball_from_above();
  stamped.stamp(stroke, sphere(642));
  EXPECT_LE(stamped.strokes().size(), stamp_segments(stroke, sphere(642)));
  Bench replayed(sphere(4002));
  for (const Stroke& points : stamped.strokes()) {
    ASSERT_TRUE(std::holds_alternative<PointsStroke>(points));
    EXPECT_EQ(std::get<PointsStroke>(points).exponent, 16);
    EXPECT_EQ(std::get<PointsStroke>(points).center, PointsCenter::parts);
    replayed.apply(points);
  }
  EXPECT_EQ(stamped.positions(), replayed.positions());
}

TEST(Stamp, IsTheSameForEveryNumberOfThreads) {
  Bench one(sphere(4002));
  Bench two(sphere(4002));
  one.stamp(ball_from_above(), sphere(642), 1);
  two.stamp(ball_from_above(), sphere(642), 2);
  EXPECT_EQ(one.positions(), two.positions());
}

TEST(Stamp, LeavesAloneWhatItDoesNotTouch) {
  Bench bench(sphere(642));
  StampStroke stroke = ball_from_above();
  stroke.path = {{0, 0, 2}, {0, 0, 1.41}, {2, 0, 1.41}};
  const StampResult result = bench.stamp(stroke, sphere(642));
  EXPECT_TRUE(bench.strokes().empty());
  EXPECT_FALSE(bench.moved());
  EXPECT_EQ(result.penetration, 0);
}

// What lies farther than `outer` from every contact stays; the underside does.
TEST(Stamp, ReachesNoFartherThanOuter) {
  Bench bench(sphere(4002));
  bench.stamp(ball_from_above(), sphere(642));
  for (std::size_t i = 0; i < bench.positions().size(); ++i) {
    EXPECT_FALSE(bench.positions()[i].z < 0 && bench.moved(i));
  }
}

TEST(Stamp, SkipsPiecesWithoutLength) {
  StampStroke stroke = ball_from_above();
  Bench straight(sphere(642));
  straight.stamp(stroke, sphere(642));
  stroke.path = {stroke.path[0], stroke.path[0], stroke.path[1], stroke.path[1]};
  Bench with_rests(sphere(642));
  with_rests.stamp(stroke, sphere(642));
  EXPECT_TRUE(straight.moved());
  EXPECT_EQ(straight.positions(), with_rests.positions());
  stroke.path = {stroke.path[0], stroke.path[0]};
  stroke.outer = std::nullopt;
  Bench at_rest(sphere(642));
  EXPECT_EQ(at_rest.stamp(stroke, sphere(642)).steps, 0U);
}

// Back the way that it came the tool meets nothing.
TEST(Stamp, LeavesTheDentWhenItRetreats) {
  StampStroke stroke = ball_from_above();
  Bench there(sphere(4002));
  there.stamp(stroke, sphere(642));
  stroke.path.push_back(stroke.path.front());
  Bench and_back(sphere(4002));
  and_back.stamp(stroke, sphere(642));
  EXPECT_EQ(there.positions(), and_back.positions());
}

TEST(Stamp, PushesObliquely) {
  StampStroke stroke = ball_from_above();
  stroke.path = {{-0.15, 0, 1.45}, {0, 0, 1.3}};
  Bench bench(sphere(4002));
  EXPECT_LT(bench.stamp(stroke, sphere(642)).penetration, 0.006);
  EXPECT_EQ(self_intersections(bench.triangles(), bench.positions()).count, 0U);
}

TEST(Stamp, EndsWhenTold) {
  Bench bench(sphere(642));
  bench.stop_after(3);
  const StampResult result = bench.stamp(ball_from_above(), sphere(642));
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(bench.strokes().size(), 3U);
}

TEST(Stamp, TakesPointClouds) {
  Mesh cloud;
  cloud.positions = sphere(4002).positions;
  Bench bench(cloud);
  const StampResult result = bench.stamp(ball_from_above(), sphere(642));
  EXPECT_TRUE(bench.moved());
  EXPECT_LT(result.penetration, 0.006);
}

// One with few triangles is met by samples on them.
TEST(Stamp, PushesLargeTriangles) {
  Bench bench(sphere(162));
  StampStroke stroke = ball_from_above();
  stroke.pose = scaling(0.1);
  stroke.path = {{0.1, 0.05, 1.2}, {0.1, 0.05, 1.0}};
  bench.stamp(stroke, sphere(642));
  EXPECT_TRUE(bench.moved());
}

TEST(Stamp, WarnsOfWhatIsInsideFromTheStart) {
  Bench bench(sphere(642));
  StampStroke stroke = ball_from_above();
  stroke.path = {{0, 0, 1.2}, {0, 0, 1.19}};
  const StampResult result = bench.stamp(stroke, sphere(642));
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find("begin the path outside"), std::string::npos);
}

TEST(Stamp, WarnsOfAnOuterThatBendsTheWalls) {
  Bench bench(sphere(642));
  StampStroke stroke = ball_from_above();
  stroke.outer = 0.43;
  const StampResult narrow = bench.stamp(stroke, sphere(642));
  ASSERT_EQ(narrow.warnings.size(), 1U);
  EXPECT_NE(narrow.warnings[0].find("\"outer\" is 0.43"), std::string::npos);
}

// 1.5 times half the tool's width across the motion, and a 25th of it.
TEST(Stamp, ChoosesItsLengths) {
  Bench bench(sphere(642));
  StampStroke stroke = ball_from_above();
  stroke.outer = std::nullopt;
  const StampResult result = bench.stamp(stroke, sphere(642));
  EXPECT_GE(result.outer, 0.9 * 0.4 - 2e-3);
  EXPECT_LE(result.outer, 1.5 * 0.4);
  EXPECT_DOUBLE_EQ(result.step, result.outer / 50);
  for (const StampContact contact : {StampContact::stick, StampContact::slip}) {
    stroke.contact = contact;
    const StampResult named = bench.stamp(stroke, sphere(642));
    EXPECT_NEAR(named.outer, 0.6, 2e-3);
    EXPECT_DOUBLE_EQ(named.step, named.outer / 25);
  }
}

std::string refusal(StampStroke stroke) {
  try {
    validate(Stroke{std::move(stroke)});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

// A ball of radius 0.3, pressed 0.1 deep into the unit sphere and dragged round it by `angle`.
StampStroke dragged_ball(double angle, StampContact contact) {
  StampStroke stroke;
  stroke.mesh = "ball.ply";
  stroke.path = {{0, 0, 1.32}};
  constexpr int pieces = 30;
  for (int i = 0; i <= pieces; ++i) {
    const double at = angle * i / pieces;
    stroke.path.push_back(Vec3d{std::sin(at), 0, std::cos(at)} * 1.2);
  }
  stroke.pose = scaling(0.3);
  stroke.contact = contact;
  return stroke;
}

// How deep the groove of that drag is near an angle, at the vertices.
double depth_at(const Bench& bench, double angle) {
  double deepest = 0;
  for (const Vec3d& p : bench.positions()) {
    if (std::abs(std::atan2(p.x, p.z) - angle) > 0.05 || std::abs(p.y) > 0.05) continue;
    deepest = std::max(deepest, 1 - norm(p));
  }
  return deepest;
}

TEST(Stamp, ThatSlipsLeavesAnEvenGroove) {
  Bench bench(sphere(8000));
  const StampResult result = bench.stamp(dragged_ball(1, StampContact::slip), sphere(642));
  EXPECT_LT(result.penetration, 0.003);
  EXPECT_EQ(self_intersections(bench.triangles(), bench.positions()).count, 0U);
  EXPECT_LT(std::abs(bench.volume_error()), 2e-4);
  for (const double angle : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) EXPECT_NEAR(depth_at(bench, angle), 0.1, 0.01) << angle;
  // What the groove is for: a tool that sticks takes the surface along, and folds it.
  Bench stuck(sphere(8000));
  stuck.stamp(dragged_ball(1, StampContact::stick), sphere(642));
  EXPECT_GT(self_intersections(stuck.triangles(), stuck.positions()).count, 100U);
}

TEST(Stamp, ThatSlipsBecomesPinsThatRepeatIt) {
  const StampStroke stroke = dragged_ball(0.2, StampContact::slip);
  Bench one(sphere(4002));
  Bench two(sphere(4002));
  one.stamp(stroke, sphere(642), 1);
  two.stamp(stroke, sphere(642), 2);
  EXPECT_EQ(one.positions(), two.positions());
  EXPECT_GT(one.strokes().size(), 10U);
  EXPECT_LE(one.strokes().size(), stamp_segments(stroke, sphere(642)));
  Bench replayed(sphere(4002));
  std::size_t held = 0;
  for (const Stroke& each : one.strokes()) {
    const auto& pins = std::get<PinsStroke>(each);
    EXPECT_NEAR(*pins.radius, 1.5 * 0.3, 1e-3);
    for (std::size_t i = 0; i < pins.points.size(); ++i) held += pins.points[i] == pins.to[i] ? 1 : 0;
    replayed.apply(each);
  }
  EXPECT_GT(held, one.strokes().size());
  EXPECT_EQ(one.positions(), replayed.positions());
}

TEST(Stamp, ThatSlipsPushesOutWhatIsInsideFromTheStart) {
  Bench bench(sphere(4002));
  StampStroke stroke = ball_from_above();
  stroke.contact = StampContact::slip;
  stroke.path = {{0, 0, 1.3}, {0.1, 0, 1.3}};
  const StampResult result = bench.stamp(stroke, sphere(642));
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("step by step"), std::string::npos) << result.warnings[0];
  EXPECT_LT(result.penetration, 0.005);
  for (const Stroke& each : bench.strokes()) {
    const auto& pins = std::get<PinsStroke>(each);
    // Pins are radius / 5 apart: these cannot meet.
    for (std::size_t i = 0; i < pins.to.size(); ++i) EXPECT_LE(norm(pins.to[i] - pins.points[i]), 0.081 * *pins.radius);
  }
  EXPECT_EQ(self_intersections(bench.triangles(), bench.positions()).count, 0U);
}

// --- prints ----------------------------------------------------------------------------------------------------------

// A tool's print from above, 0.2 deep below the top of the unit sphere, with nothing but the path given.
StampStroke pressed_print() {
  StampStroke stroke;
  stroke.mesh = "tool.ply";
  stroke.path = {{0, 0, 1.12}, {0, 0, 0.9}};
  return stroke;
}

// A star with five points, 0.2 thick like the letter.
Mesh star() {
  Mesh mesh;
  constexpr std::size_t corners = 10;
  for (const double z : {-0.1, 0.1}) {
    for (std::size_t k = 0; k < corners; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k) / 5;
      const double radius = k % 2 == 0 ? 0.38 : 0.16;
      mesh.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
    mesh.positions.push_back({0, 0, z});
  }
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    const std::array corner{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                            static_cast<std::uint32_t>(c)};
    mesh.add_face(corner);
  };
  for (std::size_t k = 0; k < corners; ++k) {
    const std::size_t next = (k + 1) % corners;
    const std::size_t above = corners + 1;
    add(corners, next, k);
    add(above + corners, above + k, above + next);
    add(k, next, above + next);
    add(k, above + next, above + k);
  }
  return mesh;
}

// How a print turned out: its floor against the plane z = 0.8, and what has sunk beside it.
struct Print {
  double rough = 0;  // standard deviation of the floor's heights
  double off = 0;    // mean of them
  double sunk = 0;   // which part of the near side, farther than 0.1 from the outline, lies deeper than before
  std::size_t floor = 0;
};

Print measured_print(const Bench& bench, const Mesh& mesh, const Mesh& before) {
  const StampTool tool(mesh, scaling(1));
  const auto is_under = [&](double x, double y) { return tool.depth({x, y, 0}) > 0; };
  Print print;
  double sum = 0;
  double squares = 0;
  double near = 0;
  for (std::size_t i = 0; i < before.positions.size(); ++i) {
    const Vec3d& p = bench.positions()[i];
    if (p.z < 0) continue;
    near += 1;
    constexpr double margin = 0.02;
    if (is_under(p.x + margin, p.y) && is_under(p.x - margin, p.y) && is_under(p.x, p.y + margin) &&
        is_under(p.x, p.y - margin)) {
      ++print.floor;
      sum += p.z - 0.8;
      squares += (p.z - 0.8) * (p.z - 0.8);
    } else if (!is_under(p.x, p.y) && tool.distance({p.x, p.y, 0}) > 0.1 &&
               norm(p) < norm(before.positions[i]) - 0.002) {
      print.sunk += 1;
    }
  }
  const auto count = static_cast<double>(print.floor);
  print.off = sum / count;
  print.rough = std::sqrt(squares / count - print.off * print.off);
  print.sunk /= near;
  return print;
}

void expect_a_clear_print(const Bench& bench, const Mesh& tool, const Mesh& before) {
  const Print print = measured_print(bench, tool, before);
  EXPECT_GT(print.floor, 100U);
  EXPECT_LT(print.rough, 0.004);
  EXPECT_LT(std::abs(print.off), 0.01);
  EXPECT_LT(print.sunk, 0.005);
  EXPECT_EQ(self_intersections(bench.triangles(), bench.positions()).count, 0U);
  EXPECT_LT(std::abs(bench.volume_error()), 1e-4);
}

TEST(Stamp, LeavesAPrintThatCanBeRead) {
  const Mesh before = sphere(64000);
  for (const Mesh& tool : {make_shape(ShapeKind::letter_y), star()}) {
    Bench bench(before);
    bench.stamp(pressed_print(), tool);
    expect_a_clear_print(bench, tool, before);
  }
}

// As a drag is applied: each piece is a stroke of its own, which holds what the one before it has pressed.
TEST(Stamp, LeavesTheSamePrintInPieces) {
  const Mesh before = sphere(64000);
  const Mesh tool = make_shape(ShapeKind::letter_y);
  Bench bench(before);
  StampStroke stroke = pressed_print();
  constexpr int pieces = 15;
  const Vec3d step = (stroke.path[1] - stroke.path[0]) / pieces;
  for (int i = 0; i < pieces; ++i) {
    stroke.path = {Vec3d{0, 0, 1.12} + step * i, Vec3d{0, 0, 1.12} + step * (i + 1)};
    bench.stamp(stroke, tool);
  }
  expect_a_clear_print(bench, tool, before);
}

TEST(Stamp, ChoosesItsReachByTheWidthOfItsStrokes) {
  const StampStroke stroke = pressed_print();
  const auto outer = [&](const Mesh& tool, double scale) {
    StampStroke scaled = stroke;
    scaled.pose = scaling(scale);
    Bench bench(sphere(42));
    scaled.path = {{0, 0, 9}, {0, 0, 8}};
    return bench.stamp(scaled, tool).outer;
  };
  EXPECT_NEAR(outer(star(), 0.5), outer(star(), 1) / 2, 1e-9);
  const double letter = outer(make_shape(ShapeKind::letter_y), 1);
  EXPECT_GE(letter, 0.9 * 0.4);
  EXPECT_LT(letter, 0.5) << "1.5 times its half extent is above 0.6";
}

// What was written before stamps slipped gives what it gave.
TEST(Stamp, SticksWhereNumbersOfStickingAreGiven) {
  StampStroke stroke;
  EXPECT_EQ(contact_of(stroke), StampContact::slip);
  stroke.falloff = 5;
  EXPECT_EQ(contact_of(stroke), StampContact::stick);
  stroke = {};
  stroke.exponent = 8;
  EXPECT_EQ(contact_of(stroke), StampContact::stick);
  stroke.contact = StampContact::slip;
  EXPECT_EQ(contact_of(stroke), StampContact::slip);
  stroke = ball_from_above();
  Bench old(sphere(4002));
  old.stamp(stroke, sphere(642));
  stroke.contact = StampContact::stick;
  Bench stuck(sphere(4002));
  stuck.stamp(stroke, sphere(642));
  EXPECT_EQ(old.positions(), stuck.positions());
  EXPECT_TRUE(std::holds_alternative<PointsStroke>(old.strokes().front()));
}

TEST(Stamp, RefusesNumbersThatMeanNothing) {
  const StampStroke good = ball_from_above();
  EXPECT_EQ(refusal(good), "none");
  StampStroke stroke = good;
  stroke.path.resize(1);
  EXPECT_EQ(refusal(stroke).substr(0, 6), "\"path\"");
  stroke = good;
  stroke.pose = scaling(-1);
  EXPECT_EQ(refusal(stroke), "\"pose\" must turn and scale the tool, and this mirrors it (determinant -1)");
  stroke.pose.row0 = stroke.pose.row1;
  EXPECT_EQ(refusal(stroke), "\"pose\" must turn and scale the tool, and this flattens it (determinant 0)");
  stroke = good;
  stroke.outer = 0;
  EXPECT_EQ(refusal(stroke).substr(0, 7), "\"outer\"");
  stroke = good;
  stroke.step = -1;
  EXPECT_EQ(refusal(stroke).substr(0, 6), "\"step\"");
  for (const int exponent : {2, 5, 0, -4}) {
    stroke = good;
    stroke.exponent = exponent;
    EXPECT_EQ(refusal(stroke).substr(0, 10), "\"exponent\"");
  }
  stroke = good;
  stroke.contact = StampContact::slip;
  EXPECT_EQ(refusal(stroke), "none");
  stroke.falloff = 5;
  EXPECT_EQ(refusal(stroke).substr(0, 9), "\"falloff\"");
  stroke = good;
  stroke.step = 1e-9;
  Bench bench(sphere(42));
  EXPECT_THROW(bench.stamp(stroke, sphere(42)), InvalidInput);
  EXPECT_FALSE(bench.moved());
}

// Contacts are apart by the spacing, cover what is inside, and are sorted by when they are hit.
TEST(Contacts, AreSpreadEvenly) {
  Bench bench(sphere(16002));
  const StampTool tool(sphere(642), scaling(0.4));
  const detail::StampStep step{{0, 0, 1.35}, {0, 0, -0.03}, 0.03};
  const std::vector<Contact> contacts = find_contacts(tool, bench.surface(), step);
  ASSERT_GT(contacts.size(), 20U);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    EXPECT_LE(contacts[i == 0 ? 0 : i - 1].tau, contacts[i].tau);
    EXPECT_EQ(contacts[i].point, contacts[i].place.at(bench.positions()));
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE(norm(contacts[i].point - contacts[j].point), step.spacing);
  }
  for (const Vec3d& p : bench.positions()) {
    if (norm(p - step.to) > 0.39) continue;
    EXPECT_TRUE(std::any_of(contacts.begin(), contacts.end(),
                            [&](const Contact& contact) { return norm(contact.point - p) < step.spacing; }));
  }
}

// On the axis the sphere is hit where the tool's lowest point passes it: at 1 - 0.95 of a step that is 0.05 long.
TEST(Contacts, KnowWhenTheyAreHit) {
  Bench bench(sphere(4002));
  const StampTool tool(sphere(4002), scaling(0.4));
  const auto first = [&](double to) {
    return find_contacts(tool, bench.surface(), {{0, 0, to}, {0, 0, -0.05}, 0.01}).at(0).tau;
  };
  EXPECT_NEAR(first(1.39), 0.8, 0.02);
  EXPECT_NEAR(first(1.36), 0.2, 0.02);
  EXPECT_NEAR(first(1.3), -1, 0.02);
}

// A ring over the sphere's top: nothing in its hole is a contact, though it lies within the tool's box.
TEST(Contacts, AreNotMadeByHoles) {
  Bench bench(sphere(16002));
  const StampTool ring(make_shape(ShapeKind::torus), scaling(0.3));
  const auto contacts = find_contacts(ring, bench.surface(), {{0, 0, 1}, {0, 0, -0.02}, 0.03});
  ASSERT_GT(contacts.size(), 20U);
  for (const Contact& contact : contacts) {
    const double from_axis = std::sqrt(contact.point.x * contact.point.x + contact.point.y * contact.point.y);
    EXPECT_GT(from_axis, 0.3 - 0.09 - 1e-12);
    EXPECT_LT(from_axis, 0.3 + 0.09 + 1e-12);
  }
}

// A face that looks sideways does not push: the tool slides past.
TEST(Contacts, AreNotMadeByTheSides) {
  Bench bench(sphere(4002));
  const StampTool bar(make_shape(ShapeKind::box), scaling(0.2));
  const auto contacts = find_contacts(bar, bench.surface(), {{0, 0, 1.08}, {0.01, 0, 0}, 0.02});
  EXPECT_TRUE(contacts.empty());
}

}  // namespace
}  // namespace knead::stamp_test
