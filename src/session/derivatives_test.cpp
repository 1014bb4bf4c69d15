// Derivatives with respect to parameters, against differences of path lines.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/replay.h"

namespace knead::derivatives_test {
namespace {

struct Case {
  std::string name;
  std::string parameters;
  std::string lines;
};

// Every tool that reads no surface, with parameters in all kinds of its numbers.
const std::vector<Case> kCases{
    {"pull", R"({"a": 0.3, "in": 0.15, "out": 0.6, "x": -0.4})",
     R"({"tool": "implicit", "path": [["$x", 0.1, 0], [0.1, "$a", 0], [0.3, 0.2, "$a"]], "inner": "$in", "outer": "$out"})"},
    {"capsule", R"({"h": 0.3, "g": 0.25, "a": 0.5})",
     R"({"tool": "implicit", "region": "capsule", "half_axis": [0.1, "$h", 0.1], "gauge": "$g", )"
     R"("path": [[-0.2, 0, 0], ["$a", 0.1, 0.1]], "inner": 0.15, "outer": 0.5})"},
    {"full gauge", R"({"g": 1})",
     R"({"tool": "implicit", "region": "capsule", "half_axis": [0.1, 0.3, 0.1], "gauge": "$g", )"
     R"("path": [[-0.2, 0, 0], [0.4, 0.1, 0.1]], "inner": 0.15, "outer": 0.5})"},
    {"blended", R"({"a": 0.4, "out": 0.6})",
     R"({"tool": "implicit", "time": "blended", "path": [[-0.2, 0, 0], [0.2, "$a", 0]], "inner": 0.2, "outer": "$out"})"},
    {"paint", R"({"depth": -0.2, "n": 0.4})",
     R"({"tool": "paint", "outer": 0.5, "depth": "$depth", "samples": [{"point": [0, 0.2, 0], "normal": [0, 1, "$n"]}]})"},
    {"rotate", R"({"angle": 50, "axis": 0.3, "in": 0.2, "out": 0.7, "y": 0.1})",
     R"({"tool": "rotate", "center": [0, "$y", 0], "axis": [0, 1, "$axis"], "angle_deg": "$angle", "inner": "$in", )"
     R"("outer": "$out", "gauge": 0.5})"},
    {"stretch", R"({"f": 1.4, "axis": 0.3})",
     R"({"tool": "stretch", "center": [0, 0.1, 0], "axis": [0, 1, "$axis"], "factor": "$f", "inner": 0.2, "outer": 0.7, )"
     R"("falloff": 6})"},
    {"twist", R"({"rate": 40, "in": -0.4, "n": 0.2})",
     R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 0, 1], "rate_deg": "$rate", "inner": "$in", "outer": 0.5, )"
     R"("normal": [0, "$n", 1], "falloff": 3})"},
    {"bend", R"({"angle": 60, "width": 0.8, "z": 0.05, "n": 0.1})",
     R"({"tool": "bend", "center": [0, 0, "$z"], "axis": [0, 1, 0], "normal": ["$n", 0, -1], "width": "$width", )"
     R"("angle_deg": "$angle"})"},
    {"points", R"({"p": 0.2, "d": 0.15, "out": 0.5, "in": 0.05})",
     R"({"tool": "points", "points": [["$p", 0.1, 0], [-0.2, 0.1, 0.1]], "curves": [[[0, 0, 0.1], [0.1, "$p", 0.2], )"
     R"([0.2, 0.3, 0.2]]], "outer": "$out", "inner": "$in", "displacements": [[0, "$d", 0], [0.1, 0, "$d"]]})"},
    {"moved handles", R"({"d": 0.2, "p": 0.4})",
     R"({"tool": "handles", "full": [[0, "$p", 0], [0.1, 0.4, 0]], "zero": [[0, -0.4, 0], [0.3, -0.4, 0]], )"
     R"("motion": {"translate": [0, 0.1, "$d"]}})"},
    {"turned handles", R"({"angle": 35, "c": 0.1})",
     R"({"tool": "handles", "full": [[0, 0.4, 0], [0.1, 0.4, 0]], "zero": [[0, -0.4, 0], [0.3, -0.4, 0]], )"
     R"("motion": {"rotate": [0, 0.2, 1], "center": [0, "$c", 0], "angle_deg": "$angle"}})"},
    {"pins", R"({"d": 0.2, "r": 0.8, "q": 0.3, "angle": 20})",
     R"({"tool": "pins", "points": [[0, "$q", 0], [0.5, 0, 0], [-0.3, -0.2, 0.1]], "radius": "$r", )"
     R"("to": [[0, 0.5, "$d"], [0.5, 0, 0], [-0.2, -0.2, "$d"]], )"
     R"("turn": [{"axis": [0, 0, 1], "angle_deg": "$angle"}, null, null]})"},
    {"mirrored", R"({"x": 0.25, "d": 0.3, "angle": 40})",
     R"({"tool": "implicit", "mirror": "x", "path": [["$x", 0, 0], [0.3, "$d", 0]], "inner": 0.1, "outer": 0.6})"
     "\n"
     R"({"tool": "rotate", "mirror": "xz", "center": ["$x", 0.1, 0.2], "axis": [0, 0, 1], "angle_deg": "$angle", )"
     R"("inner": 0.1, "outer": 0.5})"},
    {"beside a mask", R"({"d": 0.3})",
     R"({"mask": {"points": [[0.1, -0.4, 0], [-0.2, -0.4, 0.1]], "width": 0.3}})"
     "\n"
     R"({"tool": "implicit", "path": [[0, 0.1, 0], [0.1, "$d", 0]], "inner": 0.1, "outer": 0.25})"},
    {"half", R"({"s": 0.6, "angle": 40})",
     R"({"tool": "rotate", "strength": "$s", "center": [0, 0.1, 0], "axis": [0, 1, 0.2], "angle_deg": "$angle", )"
     R"("inner": 0.2, "outer": 0.7})"
     "\n"
     R"({"tool": "implicit", "strength": "$s", "path": [[-0.4, 0, 0], [0, 0.2, 0], [0.4, 0, 0.2]], "inner": 0.2, "outer": 0.6})"},
    {"more than whole", R"({"s": 1.2})",
     R"({"tool": "implicit", "strength": "$s", "path": [[-0.4, 0, 0], [0, 0.2, 0], [0.4, 0, 0.2]], "inner": 0.2, "outer": 0.6})"},
    {"after one another", R"({"angle": 30, "d": 0.3, "zero": 0})",
     R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 0, 1], "rate_deg": 50, "inner": -0.4, "outer": 0.5})"
     "\n"
     R"({"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, "$zero"], "normal": [0, 0, -1], "width": 0.8, "angle_deg": "$angle"})"
     "\n"
     R"({"tool": "implicit", "path": [[0, 0.1, 0], [0.1, "$d", "$zero"]], "inner": 0.1, "outer": 0.6})"
     "\n"
     R"({"tool": "rotate", "center": [0, 0.1, 0], "axis": [0, 1, 0], "angle_deg": "$angle", "inner": 0.2, "outer": 0.7})"},
};

Session session_of(const Case& c) {
  return parse_session(R"({"knead": 1, "parameters": )" + c.parameters + "}\n" + c.lines + "\n", "s.knead");
}

std::vector<Vec3d> points() {
  std::mt19937 random(47);
  std::vector<Vec3d> result;
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0 * 1.2 - 0.6; };
  for (int i = 0; i < 40; ++i) {
    const double x = number();
    const double y = number();
    result.push_back({x, y, number()});
  }
  return result;
}

std::vector<Vec3d> moved(const Session& session, const SessionPart& part = {}) {
  std::vector<Vec3d> result = points();
  AdvectOptions options;
  options.tolerance = 1e-13;
  options.precision = Precision::float64;
  EXPECT_EQ(advect(flow_of(session, part), result, options).status, AdvectStatus::done);
  return result;
}

// Central differences, twice extrapolated.
std::vector<Vec3d> difference(const Session& session, const Parameter& parameter, const SessionPart& part = {}) {
  const double size = parameter.value == 0 ? 1 : std::abs(parameter.value);
  std::array<std::vector<Vec3d>, 3> by_step;
  for (std::size_t level = 0; level < 3; ++level) {
    const double h = 1e-3 * size / static_cast<double>(1U << level);
    by_step[level] = moved(with_values(session, {{parameter.name, parameter.value + h}}), part);
    const std::vector<Vec3d> below = moved(with_values(session, {{parameter.name, parameter.value - h}}), part);
    for (std::size_t i = 0; i < below.size(); ++i) by_step[level][i] = (by_step[level][i] - below[i]) / (2 * h);
  }
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < by_step[0].size(); ++i) {
    const Vec3d coarse = by_step[1][i] + (by_step[1][i] - by_step[0][i]) / 3;
    const Vec3d fine = by_step[2][i] + (by_step[2][i] - by_step[1][i]) / 3;
    result.push_back(fine + (fine - coarse) / 15);
  }
  return result;
}

double greatest(const std::vector<Vec3d>& vectors) {
  double most = 0;
  for (const Vec3d& v : vectors) most = std::max(most, norm(v));
  return most;
}

std::vector<double> unit_of(const Session& session, std::size_t parameter) {
  std::vector<double> direction(session.parameters.size(), 0);
  direction[parameter] = 1;
  return direction;
}

void expect_derivatives(const Case& c, const SessionPart& part = {}, double allowed = 1e-8) {
  const Session session = session_of(c);
  const SessionDerivatives derivatives(session, part);
  for (std::size_t p = 0; p < session.parameters.size(); ++p) {
    const PointTangents found = derivatives.jvp(points(), unit_of(session, p), {.diagonal = 1});
    const std::vector<Vec3d> expected = difference(session, session.parameters[p], part);
    const std::vector<Vec3d> at = moved(session, part);
    const double most = greatest(expected);
    ASSERT_GT(most, 1e-5) << c.name << " " << session.parameters[p].name;
    double worst = 0;
    double apart = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      worst = std::max(worst, norm(expected[i] - found.tangents[i]) / most);
      apart = std::max(apart, norm(found.points[i] - at[i]));
    }
    EXPECT_LT(apart, 1e-9) << c.name;
    EXPECT_LT(worst, allowed) << c.name << " " << session.parameters[p].name;
  }
}

TEST(Derivatives, AreThoseOfDifferences) {
  for (const Case& c : kCases) expect_derivatives(c);
}

// A stroke of full strength: below it ends earlier, above it goes on.
TEST(Derivatives, WithRespectToAStrengthOfOne) {
  Case c{"whole", R"({"s": 1})", kCases.front().lines};
  c.lines = R"({"tool": "rotate", "strength": "$s", "center": [0, 0.1, 0], "axis": [0, 1, 0.2], "angle_deg": 40, )"
            R"("inner": 0.2, "outer": 0.7})";
  expect_derivatives(c);
}

// A stroke that does nothing has no segments.
TEST(Derivatives, AtAValueAtWhichNothingMoves) {
  expect_derivatives(
      {"pull by nothing", R"({"d": 0, "s": 0.4})",
       R"({"tool": "implicit", "path": [[0, 0.1, 0], [0, 0.1, "$d"]], "inner": 0.1, "outer": 0.6})"
       "\n"
       R"({"tool": "rotate", "center": [0, 0.1, 0], "axis": [0, 1, 0.2], "angle_deg": 40, "inner": 0.2, )"
       R"("outer": 0.7, "strength": "$s"})"});
  expect_derivatives(
      {"turn by nothing", R"({"d": 0})",
       R"({"tool": "rotate", "center": [0, 0.1, 0], "axis": [0, 1, 0.2], "angle_deg": "$d", "inner": 0.2, )"
       R"("outer": 0.7})"});
}

TEST(Derivatives, OfPartsAndBackwards) {
  expect_derivatives(kCases.back(), {Direction::backwards, std::nullopt});
  expect_derivatives(kCases.back(), {Direction::forwards, 2.5});
  expect_derivatives(kCases[0], {Direction::backwards, 0.7});
}

// Four parameters: more than are followed at a time.
TEST(Derivatives, BackwardsAreThoseForwards) {
  const Session session = session_of(kCases[0]);
  const SessionDerivatives derivatives(session);
  std::vector<Vec3d> gradient = points();
  for (Vec3d& g : gradient) g = cross(g, {0.3, 0.2, 1});
  const std::vector<double> found = derivatives.vjp(points(), gradient, {.diagonal = 1}).parameters;
  ASSERT_EQ(found.size(), 4U);
  for (std::size_t p = 0; p < 4; ++p) {
    const PointTangents forwards = derivatives.jvp(points(), unit_of(session, p), {.diagonal = 1});
    double sum = 0;
    for (std::size_t i = 0; i < gradient.size(); ++i) sum += dot(gradient[i], forwards.tangents[i]);
    EXPECT_NEAR(found[p], sum, 1e-7 * std::abs(sum));
  }
}

double number_in(std::mt19937& random, double least, double greatest) {
  return least + (greatest - least) * static_cast<double>(random()) / 4294967296.0;
}

// Strokes at random places, each with numbers of its own parameters.
class RandomSession {
 public:
  explicit RandomSession(unsigned seed) : random_(seed) {}

  // Returns a session of which the first `named` numbers are parameters.
  Session make(std::size_t strokes, std::size_t named) {
    named_ = named;
    for (std::size_t i = 0; i < strokes; ++i) add(i % 9);
    return parse_session(R"({"knead": 1, "parameters": {)" + parameters_ + "}}\n" + lines_, "random");
  }

 private:
  std::string number(double least, double greatest) {
    const double value = number_in(random_, least, greatest);
    if (count_ >= named_) return std::to_string(value);
    const std::string name = "p" + std::to_string(count_++);
    parameters_ += (count_ > 1 ? ", \"" : "\"") + name + "\": " + std::to_string(value);
    return "\"$" + name + "\"";
  }
  std::string place() {
    const std::string x = number(-0.5, 0.5);
    const std::string y = number(-0.5, 0.5);
    return "[" + x + ", " + y + ", " + number(-0.5, 0.5) + "]";
  }
  std::string direction() { return "[" + number(0.2, 1) + ", -0.3, " + number(-0.5, 0.5) + "]"; }
  std::string thresholds() { return R"("inner": )" + number(0.05, 0.2) + R"(, "outer": )" + number(0.4, 0.7); }
  std::string turned(const std::string& tool, const std::string& rest) {
    const std::string center = place();
    return R"({"tool": ")" + tool + R"(", "center": )" + center + R"(, "axis": )" + direction() + ", " + rest + "}";
  }

  void add(std::size_t kind) { lines_ += line(kind) + "\n"; }
  std::string line(std::size_t kind) {
    const std::string from = place();
    const std::string path = R"({"tool": "implicit", "path": [)" + from + ", " + place() + "], ";
    switch (kind) {
      case 0:
        return path + thresholds() + "}";
      case 1:
        return path + R"("region": "capsule", "half_axis": )" + direction() + R"(, "gauge": 0.4, )" + thresholds() +
               "}";
      case 2:
        return path + R"("falloff": "wide", "bump": )" + number(0.1, 0.3) + R"(, "outer": )" + number(0.4, 0.9) + "}";
      case 3:
        return R"({"tool": "paint", "outer": 0.5, "depth": )" + number(-0.2, -0.05) + R"(, "samples": [{"point": )" +
               from + R"(, "normal": [0, 1, 0.2]}, {"point": )" + place() + R"(, "normal": [1, 0, 0.2]}]})";
      case 4:
        return turned("rotate", R"("angle_deg": )" + number(10, 60) + ", " + thresholds());
      case 5:
        return turned("stretch", R"("factor": )" + number(1.1, 1.5) + ", " + thresholds());
      case 6:
        return turned("twist", R"("rate_deg": )" + number(20, 60) + R"(, "inner": -0.3, "outer": )" + number(0.4, 0.6));
      case 7:
        return R"({"tool": "bend", "center": [0, 0, 0.1], "axis": [0, 1, 0], "normal": [0.1, 0, -1], "width": )" +
               number(0.7, 1) + R"(, "angle_deg": )" + number(20, 70) + "}";
      default:
        return R"({"tool": "points", "points": [)" + from + ", " + place() + R"(], "displacements": [[0, )" +
               number(0.05, 0.2) + ", 0.1]], " + thresholds() + "}";
    }
  }

  std::mt19937 random_;
  std::size_t named_ = 0;
  std::size_t count_ = 0;
  std::string parameters_;
  std::string lines_;
};

// With respect to the parameters as forwards along a random direction, to the points as by jacobians(), whose steps
// pass kinks.
void expect_backwards_as_forwards(const Session& session, const std::string& what) {
  SCOPED_TRACE(what);
  std::mt19937 random(5);
  const SessionDerivatives derivatives(session);
  std::vector<Vec3d> gradient = points();
  for (Vec3d& g : gradient) g = cross(g, {0.3, 0.2, 1});
  const DerivativeOptions options{.relative_tolerance = 1e-9, .diagonal = 1};
  const SessionGradient found = derivatives.vjp(points(), gradient, options);
  std::vector<double> direction(session.parameters.size());
  double by_parameters = 0;
  for (std::size_t p = 0; p < direction.size(); ++p) {
    direction[p] = number_in(random, -1, 1);
    by_parameters += direction[p] * found.parameters[p];
  }
  const PointTangents forwards = derivatives.jvp(points(), direction, options);
  double sum = 0;
  double size = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    sum += dot(gradient[i], forwards.tangents[i]);
    size += std::abs(dot(gradient[i], forwards.tangents[i]));
  }
  EXPECT_GT(size, 1e-3);
  EXPECT_NEAR(by_parameters, sum, 1e-8 * size);
  AdvectOptions exact;
  exact.tolerance = 1e-11;
  exact.precision = Precision::float64;
  const std::vector<Mat3d> jacobian = jacobians(flow_of(session), points(), exact);
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const Vec3d& g = gradient[i];
    const Vec3d expected{dot(jacobian[i].column(0), g), dot(jacobian[i].column(1), g), dot(jacobian[i].column(2), g)};
    EXPECT_LT(norm(found.points[i] - expected), 3e-7 * std::max(1.0, norm(expected))) << i;
  }
}

TEST(Derivatives, BackwardsOfEveryTool) {
  for (const Case& c : kCases) expect_backwards_as_forwards(session_of(c), c.name);
}

TEST(Derivatives, BackwardsOfRandomSessions) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    expect_backwards_as_forwards(RandomSession(seed).make(9, 1), "one parameter, " + std::to_string(seed));
    expect_backwards_as_forwards(RandomSession(seed).make(27, 200), "200 parameters, " + std::to_string(seed));
  }
}

// More than are followed forwards.
TEST(Derivatives, BackwardsOfManyParametersOfOneStroke) {
  std::string names;
  std::string points;
  for (int i = 0; i < 5; ++i) {
    std::string place;
    for (const char axis : {'x', 'y', 'z'}) {
      const std::string name = axis + std::to_string(i);
      names += (names.empty() ? "\"" : ", \"") + name + "\": " + std::to_string(0.1 * i - (axis == 'y' ? 0.3 : 0.1));
      place += (place.empty() ? "\"$" : ", \"$") + name + "\"";
    }
    points += (points.empty() ? "[" : ", [") + place + "]";
  }
  const Case many{"many", "{" + names + "}",
                  R"({"tool": "points", "points": [)" + points +
                      R"(], "outer": 0.5, "inner": 0.05, "displacements": [[0, 0.2, 0.1], [0.1, 0, 0.2]]})"};
  expect_backwards_as_forwards(session_of(many), many.name);
}

// Rounding alone must not make steps so short that a path line ends early, and no step may pass a kink unseen.
TEST(Derivatives, JacobiansAtTheTightestTolerance) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Flow flow = flow_of(RandomSession(seed).make(27, 200));
    AdvectOptions exact;
    exact.precision = Precision::float64;
    exact.tolerance = 1e-11;
    const std::vector<Mat3d> expected = jacobians(flow, points(), exact);
    exact.tolerance = 1e-13;
    const std::vector<Mat3d> found = jacobians(flow, points(), exact);
    for (std::size_t i = 0; i < found.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d column = expected[i].column(k);
        EXPECT_LT(norm(found[i].column(k) - column), 3e-7 * std::max(1.0, norm(column))) << seed << " " << i;
      }
    }
  }
}

TEST(Derivatives, AreLinearInTheDirection) {
  const Session session = session_of(kCases[0]);
  const SessionDerivatives derivatives(session);
  const std::vector<double> direction{0.3, -2, 1, 0.5};
  const PointTangents found = derivatives.jvp(points(), direction, {.diagonal = 1});
  std::vector<Vec3d> sum(points().size());
  for (std::size_t p = 0; p < 4; ++p) {
    const PointTangents one = derivatives.jvp(points(), unit_of(session, p), {.diagonal = 1});
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one.tangents[i] * direction[p];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) EXPECT_LT(norm(found.tangents[i] - sum[i]), 1e-7);
}

// A point alone, and any number of threads, give the same bits.
TEST(Derivatives, OfAPointDependOnItAlone) {
  const SessionDerivatives derivatives(session_of(kCases.back()));
  const std::vector<double> direction{1, 0.5, -1};
  const PointTangents all = derivatives.jvp(points(), direction, {.diagonal = 1, .threads = 1});
  const std::vector<Vec3d> same = points();
  EXPECT_EQ(derivatives.jvp(points(), direction, {.diagonal = 1, .threads = 3}).tangents, all.tangents);
  for (std::size_t i = 0; i < same.size(); i += 7) {
    const PointTangents one = derivatives.jvp({&same[i], 1}, direction, {.diagonal = 1});
    EXPECT_EQ(one.tangents.front(), all.tangents[i]);
    EXPECT_EQ(one.points.front(), all.points[i]);
  }
  const std::vector<Vec3d> gradient(points().size(), {1, 2, 3});
  const SessionGradient backwards = derivatives.vjp(points(), gradient, {.threads = 1});
  EXPECT_EQ(derivatives.vjp(points(), gradient, {.threads = 4}).parameters, backwards.parameters);
  EXPECT_EQ(derivatives.vjp(points(), gradient, {.threads = 4}).points, backwards.points);
}

// Twice as far apart: a mask that acts, and a grid with a strength.
TEST(Derivatives, HoldForMasksAndGrids) {
  const std::string mask = R"({"mask": {"points": [[0.1, 0.05, 0], [-0.2, -0.1, 0.1]], "width": 0.4}})"
                           "\n";
  Case turned = kCases[5];  // a rotate
  turned.lines = mask + turned.lines;
  const Session session = session_of(turned);
  EXPECT_GT(greatest(moved(session)), 0);
  // Its constants are found by least squares, which do not change without a jump: there is a derivative, or none.
  try {
    const SessionDerivatives derivatives(session);
    const PointTangents found = derivatives.jvp(points(), unit_of(session, 0), {.diagonal = 1});
    const std::vector<Vec3d> expected = difference(session, session.parameters[0]);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_LT(norm(expected[i] - found.tangents[i]), 1e-5 * greatest(expected)) << i;
    }
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("no derivative"), std::string::npos);
  }
  const Case grid{"grid", R"({"s": 0.7})",
                  R"({"tool": "grid", "strength": "$s", "origin": [0, 0, 0], "spacing": 0.5, "counts": [1, 1, 1], )"
                  R"("coefficients": "AAAAAAAAAAAAAAAAAAAAAAAAAAAAANA/"})"};
  expect_derivatives(grid);
}

TEST(Derivatives, ThatDoNotExistAreErrors) {
  const auto error_of = [](const std::string& parameters, const std::string& lines) -> std::string {
    try {
      const SessionDerivatives derivatives(session_of({"", parameters, lines}));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string turn =
      R"({"tool": "rotate", "center": [0, 0, 0], "axis": [0, 1, 0], "angle_deg": 40, "inner": 0.2, "outer": 0.7)";
  const std::string no_derivative = "s.knead: the flow has no derivative with respect to ";
  EXPECT_TRUE(error_of(R"({"n": 4})", turn + R"(, "falloff": "$n"})").starts_with(no_derivative + "\"n\" at 4: "));
  EXPECT_TRUE(error_of(R"({"w": 0.2})", R"({"mask": {"points": [[0, 0, 0]], "width": "$w"}})"
                                        "\n" +
                                            turn + "}")
                  .starts_with(no_derivative + "\"w\" at 0.2: "));
  EXPECT_TRUE(error_of(R"({"d": 0.2})", R"({"tool": "paint", "outer": 0.3, "depth": "$d", "path": [[0, 1, 0]]})")
                  .starts_with("s.knead:2: this stroke reads the surface"));
  const Session session = session_of(kCases[0]);
  const SessionDerivatives derivatives(session);
  const std::vector<double> three{1, 1, 1};
  EXPECT_THROW(derivatives.jvp(points(), three, {}), InvalidInput);
  EXPECT_THROW(derivatives.jvp(points(), std::vector<double>{1, 1, 1, kInfinity}, {}), InvalidInput);
  EXPECT_THROW(derivatives.jvp(points(), unit_of(session, 0), {.relative_tolerance = 0}), InvalidInput);
  EXPECT_THROW(derivatives.vjp(points(), {}, {}), InvalidInput);
  Progress progress;
  progress.cancel = true;
  EXPECT_THROW(derivatives.jvp(points(), unit_of(session, 0), {.progress = &progress}), Cancelled);
  EXPECT_THROW(SessionDerivatives(session, {}, 0, &progress), Cancelled);
}

TEST(Derivatives, OfNoPointsAndNoParametersAreNone) {
  const SessionDerivatives none(session_of({"", "{}", kCases[1].lines.substr(0, 0) + R"({"mask": null})"}));
  EXPECT_EQ(none.jvp(points(), {}, {}).points, points());
  EXPECT_TRUE(none.vjp(points(), points(), {}).parameters.empty());
  EXPECT_EQ(none.vjp(points(), points(), {}).points, points());
  const Session session = session_of(kCases[0]);
  EXPECT_TRUE(SessionDerivatives(session).jvp({}, unit_of(session, 0), {}).points.empty());
}

// There the derivative is 0 or that of the pin's path, whatever the rounding of what cancels.
TEST(Derivatives, PointsOnPinsHaveThem) {
  const Session session = parse_session(R"({"knead": 1, "parameters": {"d": 0.1}})"
                                        "\n"
                                        R"({"tool": "pins", "points": [[0, 0, 0], [0.5, 0, 0], [0, 0.3, 0.2]], )"
                                        R"("to": [["$d", 0, 0], [0.5, 0, 0], [0, 0.3, "$d"]], "radius": 1})"
                                        "\n",
                                        "s");
  const SessionDerivatives derivatives(session);
  const std::vector<Vec3d> points{{0.5, 0, 0}, {0, 0, 0}, {0, 0.3, 0.2}};
  DerivativeOptions options;
  options.diagonal = 6;
  const PointTangents moved = derivatives.jvp(points, std::vector<double>{1}, options);
  const std::vector<Vec3d> expected{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT(norm(moved.tangents[i] - expected[i]), 1e-6) << i;
  EXPECT_NEAR(derivatives.vjp(points, std::vector<Vec3d>(3, {1, 0, 0}), options).parameters.front(), 1, 1e-6);
}

// An octahedron, and the tip of another above it.
struct Solid {
  std::vector<Vec3d> points{{1, 0.1, 0},   {-1, 0, 0.1}, {0, 1.2, 0},  {0.1, -1, 0},
                            {0, 0.1, 0.9}, {0, 0, -1},   {0.2, 0.1, 2}};
  std::vector<Triangle> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                  {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
};

TEST(SurfaceMeasures, DerivativesAreThoseOfDifferences) {
  const Solid solid;
  const std::vector<std::uint32_t> at{0, 4};
  const std::vector<std::uint32_t> tip{6};
  const auto all = [&](const std::vector<Vec3d>& points) {
    return std::vector<SurfaceMeasures>{
        volume_of(points, solid.triangles), area_of(points, solid.triangles), thickness_at(points, solid.triangles, at),
        curvature_at(points, solid.triangles, at), patch_distance(points, tip, solid.triangles)};
  };
  std::mt19937 random(9);
  std::vector<Vec3d> tangents;
  for (std::size_t i = 0; i < solid.points.size(); ++i) {
    const double x = number_in(random, -1, 1);
    const double y = number_in(random, -1, 1);
    tangents.push_back({x, y, number_in(random, -1, 1)});
  }
  const double step = 1e-6;
  std::vector<Vec3d> after = solid.points;
  std::vector<Vec3d> before = solid.points;
  for (std::size_t i = 0; i < after.size(); ++i) {
    after[i] += tangents[i] * step;
    before[i] -= tangents[i] * step;
  }
  const std::vector<SurfaceMeasures> here = all(solid.points);
  const std::vector<SurfaceMeasures> there = all(after);
  const std::vector<SurfaceMeasures> back = all(before);
  for (std::size_t m = 0; m < here.size(); ++m) {
    const std::vector<double> found = here[m].jvp(tangents);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i], (there[m].values[i] - back[m].values[i]) / (2 * step), 1e-8) << m << " " << i;
      std::vector<double> weights(found.size(), 0);
      weights[i] = 1;
      double sum = 0;
      const std::vector<Vec3d> gradient = here[m].vjp(weights);
      for (std::size_t k = 0; k < gradient.size(); ++k) sum += dot(gradient[k], tangents[k]);
      EXPECT_NEAR(sum, found[i], 1e-13) << m << " " << i;
    }
  }
  EXPECT_THROW(volume_of(solid.points, std::span(solid.triangles).first(7)), InvalidInput);
  EXPECT_THROW(area_of(std::span(solid.points).first(5), solid.triangles), InvalidInput);
}

}  // namespace
}  // namespace knead::derivatives_test
