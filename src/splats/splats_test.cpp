#include "knead/splats.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "knead/error.h"
#include "knead/replay.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead::splats_test {
namespace {

constexpr AdvectOptions kExact{.tolerance = 1e-11, .precision = Precision::float64};
const Stroke kBend = BendStroke{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 70, BendThresholds{-1, 1}};
const Stroke kTurnAll = RotateStroke{{0.1, 0, 0}, {1, 2, -1}, 130, 50, 60};

// Splats with random places in a box of 2 units, sizes from 1e-4 to 1e-1, turns and colours.
Mesh random_splats(std::size_t count, std::size_t harmonics) {
  std::mt19937 random(7);
  const auto number = [&](double least, double greatest) {
    return std::uniform_real_distribution<double>(least, greatest)(random);
  };
  Mesh mesh;
  for (std::size_t i = 0; i < count; ++i) mesh.positions.push_back({number(-1, 1), number(-1, 1), number(-1, 1)});
  const auto add = [&](const std::string& name, double least, double greatest) {
    Attribute& attribute = mesh.attributes.emplace_back(Attribute{name, Domain::vertex, NumberType::float32, 1, {}});
    for (std::size_t i = 0; i < count; ++i) attribute.values.push_back(number(least, greatest));
  };
  for (int i = 0; i < 3; ++i) add(fmt::format("scale_{}", i), std::log(1e-4), std::log(1e-1));
  for (int i = 0; i < 4; ++i) add(fmt::format("rot_{}", i), -1, 1);
  for (std::size_t i = 0; i < harmonics; ++i) add(fmt::format("f_rest_{}", i), -1, 1);
  add("opacity", -3, 3);
  return mesh;
}

// Returns how many Jacobians are not the identity.
std::size_t deform_splats(Mesh& mesh, const Flow& flow, const AdvectOptions& options) {
  const std::vector<Mat3d> all = jacobians(flow, mesh.positions, options);
  for (const Attribute& changed : deformed_splats(mesh, all, options.threads)) {
    for (Attribute& attribute : mesh.attributes) {
      if (attribute.name == changed.name) attribute = changed;
    }
  }
  return all.size() - static_cast<std::size_t>(std::count(all.begin(), all.end(), Mat3d{}));
}

double value(const Mesh& mesh, const std::string& name, std::size_t i) { return mesh.find_attribute(name)->values[i]; }

Mat3d transposed(const Mat3d& m) { return {m.column(0), m.column(1), m.column(2)}; }

Mat3d rotation_of(const Mesh& mesh, std::size_t i) {
  double w = value(mesh, "rot_0", i);
  Vec3d v{value(mesh, "rot_1", i), value(mesh, "rot_2", i), value(mesh, "rot_3", i)};
  const double size = std::sqrt(w * w + norm2(v));
  w /= size;
  v = v / size;
  const auto turned = [&](const Vec3d& e) { return e + cross(v, cross(v, e) + e * w) * 2.0; };
  return transposed({turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})});
}

Mat3d covariance(const Mesh& mesh, std::size_t i) {
  const Mat3d r = rotation_of(mesh, i);
  Mat3d sum{{}, {}, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    const double deviation = std::exp(value(mesh, fmt::format("scale_{}", k), i));
    sum = sum + outer_product(r.column(k), r.column(k)) * (deviation * deviation);
  }
  return sum;
}

// By central differences, to about 1e-9.
Mat3d jacobian_at(const Flow& flow, const Vec3d& p) {
  constexpr double h = 1e-4;
  std::vector<Vec3d> points;
  for (const Vec3d& e : {Vec3d{h, 0, 0}, Vec3d{0, h, 0}, Vec3d{0, 0, h}}) {
    points.insert(points.end(), {p + e, p - e});
  }
  advect(flow, points, {.tolerance = 1e-14, .precision = Precision::float64});
  const auto column = [&](std::size_t i) { return (points[2 * i] - points[2 * i + 1]) / (2 * h); };
  return transposed({column(0), column(1), column(2)});
}

// The colour that the harmonics of one channel add, seen along d: as associated Legendre functions give it.
double colour(const Mesh& mesh, std::size_t i, std::size_t channel, std::size_t degree, const Vec3d& d) {
  const std::size_t count = degree * (degree + 2);
  const double angle = std::atan2(d.y, d.x);
  double sum = 0;
  for (int l = 1; l <= static_cast<int>(degree); ++l) {
    for (int m = -l; m <= l; ++m) {
      const int k = std::abs(m);
      const double size =
          std::sqrt((2 * l + 1) / (4 * std::numbers::pi) * std::tgamma(l - k + 1) / std::tgamma(l + k + 1));
      const double legendre =
          (k % 2 == 0 ? 1 : -1) * std::assoc_legendre(static_cast<unsigned>(l), static_cast<unsigned>(k), d.z);
      const double turn = m == 0 ? 1 : std::numbers::sqrt2 * (m < 0 ? std::sin(k * angle) : std::cos(k * angle));
      const auto index = channel * count + static_cast<std::size_t>(l * l - 1 + l + m);
      sum += value(mesh, fmt::format("f_rest_{}", index), i) * size * legendre * turn;
    }
  }
  return sum;
}

TEST(Splats, CovariancesAreThoseOfTheJacobian) {
  const Mesh before = random_splats(200, 0);
  Mesh after = before;
  const Flow flow = flow_of(kBend);
  EXPECT_GT(deform_splats(after, flow, kExact), 50U);
  for (std::size_t i = 0; i < before.vertex_count(); ++i) {
    const Mat3d j = jacobian_at(flow, before.positions[i]);
    const Mat3d expected = j * covariance(before, i) * transposed(j);
    const Mat3d difference = covariance(after, i) + expected * -1.0;
    EXPECT_LT(row_sum_norm(difference), 1e-6 * row_sum_norm(expected)) << i;
    double sum = 0;  // a flow keeps the volume of a splat
    for (int k = 0; k < 3; ++k) {
      sum += value(after, fmt::format("scale_{}", k), i) - value(before, fmt::format("scale_{}", k), i);
    }
    EXPECT_NEAR(sum, 0, 1e-7) << i;
    EXPECT_EQ(value(after, "opacity", i), value(before, "opacity", i));
  }
}

// The axes keep their order, and of the two quaternions of a turn that near the old one comes.
TEST(Splats, SmallTurnsChangeNumbersLittle) {
  const Mesh before = random_splats(200, 0);
  Mesh after = before;
  deform_splats(after, flow_of(Stroke(RotateStroke{{0, 0, 0}, {1, 1, 0}, 0.01, 50, 60})), kExact);
  for (std::size_t i = 0; i < before.vertex_count(); ++i) {
    double size = 0;
    for (int k = 0; k < 4; ++k) size += std::pow(value(before, fmt::format("rot_{}", k), i), 2);
    for (int k = 0; k < 4; ++k) {
      const std::string name = fmt::format("rot_{}", k);
      EXPECT_NEAR(value(after, name, i), value(before, name, i) / std::sqrt(size), 2e-4);
    }
    for (int k = 0; k < 3; ++k) {
      const std::string name = fmt::format("scale_{}", k);
      EXPECT_NEAR(value(after, name, i), value(before, name, i), 1e-12);
    }
  }
}

TEST(Splats, ColoursTurnWithTheirSurroundings) {
  const Vec3d axis = normalized(Vec3d{1, 2, -1});
  const auto turned = [&](const Vec3d& d) {
    const double angle = 130 * std::numbers::pi / 180;
    return d * std::cos(angle) + cross(axis, d) * std::sin(angle) + axis * (dot(axis, d) * (1 - std::cos(angle)));
  };
  for (const std::size_t degree : {1, 2, 3}) {
    const Mesh before = random_splats(20, 3 * degree * (degree + 2));
    Mesh after = before;
    EXPECT_EQ(deform_splats(after, flow_of(kTurnAll), kExact), 20U);
    for (std::size_t i = 0; i < 20; ++i) {
      for (const Vec3d& d : {Vec3d{0.3, -0.5, 0.8}, Vec3d{-0.9, 0.1, 0.2}, Vec3d{0.1, 0.7, -0.6}}) {
        const Vec3d unit = normalized(d);
        for (const std::size_t channel : {0, 1, 2}) {
          EXPECT_NEAR(colour(after, i, channel, degree, turned(unit)), colour(before, i, channel, degree, unit), 1e-9);
        }
      }
    }
  }
}

TEST(Splats, ThereAndBackIsTheBeginning) {
  const Mesh before = random_splats(300, 45);
  Mesh mesh = before;
  const Flow flow = flow_of(kBend);
  deform_splats(mesh, flow, kExact);
  advect(flow, mesh.positions, kExact);
  deform_splats(mesh, inverse(flow), kExact);
  for (std::size_t a = 0; a < before.attributes.size(); ++a) {
    if (before.attributes[a].name.starts_with("rot_") || before.attributes[a].name.starts_with("scale_")) continue;
    for (std::size_t i = 0; i < before.vertex_count(); ++i) {
      EXPECT_NEAR(mesh.attributes[a].values[i], before.attributes[a].values[i], 1e-5);
    }
  }
  for (std::size_t i = 0; i < before.vertex_count(); ++i) {
    const Mat3d expected = covariance(before, i);
    EXPECT_LT(row_sum_norm(covariance(mesh, i) + expected * -1.0), 1e-5 * row_sum_norm(expected));
  }
}

TEST(Splats, WhatIsShiftedOnlyKeepsEveryBit) {
  const Mesh before = random_splats(100, 24);
  Mesh after = before;
  const Flow flow = flow_of(Stroke(ImplicitStroke{{{0, 0, 0}, {0.3, 1, 0}}, 20, 30}));
  EXPECT_EQ(deform_splats(after, flow, kExact), 0U);
  EXPECT_EQ(after.attributes, before.attributes);
}

// Several strokes, with a mask and frames: the flows of all strokes one after the other.
TEST(Splats, AReplayChangesThemAsItsFlowDoes) {
  const Mesh before = random_splats(500, 9);
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "rotate", "center": [0, 0, 0.5], "axis": [0, 0, 1], "angle_deg": 80, "inner": 0.2, "outer": 0.9}
{"mask": {"points": [[0.5, 0, 0]], "width": 0.3}}
{"tool": "implicit", "path": [[0, 0, 0], [0.4, 0, 0], [0.4, 0.3, 0]], "inner": 0.2, "outer": 0.8}
)",
      "s.knead");
  ReplayOptions options;
  options.motion.relative_tolerance = 1e-9;
  options.motion.precision = Precision::float64;
  options.frames.count = 3;
  std::vector<std::vector<Attribute>> frames;
  options.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(frame.shape.splats()); };
  Progress progress;
  options.progress = &progress;
  Replay run(borrow(before), session, options);
  const std::uint64_t work = run.work();
  const ReplayResult result = run.run();
  EXPECT_EQ(progress.done, work);
  const AdvectOptions exact{.tolerance = 1e-10, .precision = Precision::float64};
  const std::vector<Mat3d> all = jacobians(flow_of(session), before.positions, exact);
  const std::vector<Attribute> expected = deformed_splats(before, all);
  const std::vector<Attribute> found = result.shape.splats();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t a = 0; a < found.size(); ++a) {
    for (std::size_t i = 0; i < before.vertex_count(); ++i) {
      EXPECT_NEAR(found[a].values[i], expected[a].values[i], 1e-5) << found[a].name;
    }
  }
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[2], found);
  EXPECT_NE(frames[1], found);
  EXPECT_EQ(frames[0][0], *before.find_attribute("scale_0"));
}

TEST(Splats, TheSameBitsForEveryNumberOfThreads) {
  Mesh one = random_splats(10'000, 9);
  Mesh three = one;
  AdvectOptions options{.tolerance = 1e-5};
  options.threads = 1;
  deform_splats(one, flow_of(kBend), options);
  options.threads = 3;
  deform_splats(three, flow_of(kBend), options);
  EXPECT_EQ(one.attributes, three.attributes);
}

TEST(Splats, WhatAreNoneIsRefused) {
  Mesh mesh = random_splats(5, 10);
  EXPECT_TRUE(are_splats(mesh));
  const std::vector<Mat3d> still(5);
  EXPECT_THROW(deformed_splats(mesh, still), InvalidInput);  // harmonics
  mesh.attributes.erase(mesh.attributes.end() - 2);
  EXPECT_EQ(deformed_splats(mesh, still).size(), 16U);
  EXPECT_THROW(deformed_splats(mesh, std::span(still).first(4)), InvalidInput);
  mesh.attributes.erase(mesh.attributes.begin());
  EXPECT_FALSE(are_splats(mesh));
  EXPECT_THROW(deformed_splats(mesh, still), InvalidInput);
}

}  // namespace
}  // namespace knead::splats_test
