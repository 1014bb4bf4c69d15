// Gaussian splats under a Jacobian: covariances, axes and harmonics, against formulas written in another form.
#include "knead/mesh.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/replay.h"
#include "knead/stroke.h"
#include "knead/vec.h"
#include "math/geometry.h"
#include "support/scratch.h"

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

SplatJacobians splat_jacobians(const Mesh& mesh, const Flow& flow, const AdvectOptions& options) {
  const std::vector<Mat3d> all = jacobians(flow, mesh.positions, options);
  SplatJacobians result;
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    if (all[i] == Mat3d{}) continue;
    result.splats.push_back(i);
    result.jacobians.push_back(all[i]);
  }
  return result;
}

void apply(Mesh& mesh, const ChangedSplats& changed) {
  for (const Attribute& attribute : changed.attributes) {
    std::vector<double>& values = std::ranges::find(mesh.attributes, attribute.name, &Attribute::name)->values;
    for (std::size_t k = 0; k < changed.splats.size(); ++k) values[changed.splats[k]] = attribute.values[k];
  }
}

// Returns how many Jacobians are not the identity.
std::size_t deform_splats(Mesh& mesh, const Flow& flow, const AdvectOptions& options) {
  const ChangedSplats changed = deformed_splats(mesh, splat_jacobians(mesh, flow, options), options.threads);
  apply(mesh, changed);
  return changed.splats.size();
}

Mesh with_splats(const Mesh& mesh, const DeformedShape& shape) {
  Mesh result = mesh;
  result.positions = shape.positions();
  apply(result, deformed_splats(mesh, *shape.splats()));
  return result;
}

double value(const Mesh& mesh, const std::string& name, std::size_t i) { return mesh.find_attribute(name)->values[i]; }

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

void normalise_turns(Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    double size2 = 0;
    for (int k = 0; k < 4; ++k) size2 += std::pow(value(mesh, fmt::format("rot_{}", k), i), 2);
    for (Attribute& attribute : mesh.attributes) {
      if (attribute.name.starts_with("rot_")) attribute.values[i] /= std::sqrt(size2);
    }
  }
}

void expect_near(const Mesh& found, const Mesh& expected, double tolerance) {
  for (std::size_t i = 0; i < expected.vertex_count(); ++i) {
    EXPECT_LT(norm(found.positions[i] - expected.positions[i]), tolerance) << i;
    for (std::size_t a = 0; a < expected.attributes.size(); ++a) {
      EXPECT_NEAR(found.attributes[a].values[i], expected.attributes[a].values[i], tolerance)
          << expected.attributes[a].name << " " << i;
    }
  }
}

// A PLY file of text.
std::string text_of(const Mesh& mesh) {
  std::string text = fmt::format("ply\nformat ascii 1.0\nelement vertex {}\n", mesh.vertex_count());
  for (const char* axis : {"x", "y", "z"}) text += fmt::format("property double {}\n", axis);
  for (const Attribute& attribute : mesh.attributes) text += fmt::format("property float {}\n", attribute.name);
  text += "end_header\n";
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    text += fmt::format("{} {} {}", mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z);
    for (const Attribute& attribute : mesh.attributes) text += fmt::format(" {}", attribute.values[i]);
    text += "\n";
  }
  return text;
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
  std::vector<Mesh> frames;
  options.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(with_splats(before, frame.shape)); };
  Progress progress;
  options.progress = &progress;
  Replay run(borrow(before), session, options);
  const std::uint64_t work = run.work();
  const ReplayResult result = run.run();
  EXPECT_EQ(progress.done, work);
  Mesh expected = before;
  const AdvectOptions exact{.tolerance = 1e-10, .precision = Precision::float64};
  deform_splats(expected, flow_of(session), exact);
  advect(flow_of(session), expected.positions, exact);
  expect_near(with_splats(before, result.shape), expected, 1e-6);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[2].attributes, with_splats(before, result.shape).attributes);
  EXPECT_NE(frames[1].attributes, frames[2].attributes);
  EXPECT_EQ(frames[0].attributes, before.attributes);
}

// At the default accuracy: centres and all else come back to 1e-5, also where a flow turns what does not move.
TEST(Splats, AReplayBackwardsIsTheBeginning) {
  Mesh before = random_splats(500, 45);
  before.positions[0] = {0, 0, 0.5};
  normalise_turns(before);
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,1], "width": 1, "angle_deg": 70}
{"tool": "rotate", "center": [0, 0, 0.5], "axis": [0, 0, 1], "angle_deg": 80, "inner": 0.2, "outer": 0.9}
)",
      "s.knead");
  const ReplayResult there = replay(borrow(before), session, {});
  const Mesh bent = with_splats(before, there.shape);
  ReplayOptions backwards;
  backwards.part.direction = Direction::backwards;
  const ReplayResult back = replay(borrow(bent), session, backwards);
  EXPECT_NE(value(bent, "rot_0", 0), value(before, "rot_0", 0));
  expect_near(with_splats(bent, back.shape), before, 1e-5);
}

// A mesh and two clouds of splats in one flow: each is as it would be alone.
TEST(Splats, PartsOfSeveralShapesChangeAsAlone) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 600);
  const Mesh few = random_splats(100, 9);
  const Mesh many = random_splats(300, 0);
  const test::Scratch folder("splats");
  const Mesh* const meshes[] = {&few, &mesh, &many};
  const JoinedMeshes joined(meshes);
  ReplayOptions options;
  options.motion.diagonal = 3;
  options.splats = splats_among(meshes);
  ASSERT_EQ(options.splats.size(), 2U);
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,1], "width": 1, "angle_deg": 70}
)",
      "s.knead");
  for (const bool is_remeshed : {false, true}) {
    if (is_remeshed) options.remesh.settings.emplace();
    const ReplayResult result = replay(borrow(joined.mesh()), session, options);
    EXPECT_EQ(result.shape.is_remeshed(), is_remeshed);
    const ShapeState state = result.shape.state();
    for (const std::size_t part : {0, 2}) {
      const Mesh& own = *meshes[part];
      const ShapeFile source = parse_shape(serialize_mesh("ply", own, {.double_coordinates = true}), "ply", "own");
      write_part(folder.path() / "part.ply", {source, joined, part}, state);
      ReplayOptions alone;
      alone.motion.diagonal = 3;
      const ReplayResult expected = replay(borrow(own), session, alone);
      EXPECT_EQ(read_shape(folder.path() / "part.ply").bytes, serialize_deformed("ply", source, expected.shape))
          << part;
    }
  }
}

// The largest second difference of the flow over a standard deviation of the splat, by its largest one after the flow.
double bend_of(const Mesh& mesh, std::size_t i, const Flow& flow) {
  std::array<double, 4> turn{};
  for (std::size_t k = 0; k < 4; ++k) turn[k] = value(mesh, fmt::format("rot_{}", k), i);
  std::vector<Vec3d> points{mesh.positions[i]};
  double largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d arm = splat_axes(turn)[k] * std::exp(value(mesh, fmt::format("scale_{}", k), i));
    points.insert(points.end(), {points[0] + arm, points[0] - arm});
  }
  advect(flow, points, kExact);
  for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, norm(points[1 + 2 * k] - points[2 + 2 * k]) / 2);
  double bend = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    bend = std::max(bend, norm(points[1 + 2 * k] + points[2 + 2 * k] - points[0] * 2.0) / largest);
  }
  return bend;
}

std::optional<ShapeFile> split_of(ShapeFile shape, const Session& session, std::size_t max_splats,
                                  std::vector<std::string>* notes = nullptr) {
  const bool is_split = split_splats(shape, session, {}, max_splats, notes);
  return is_split ? std::optional(shape) : std::nullopt;
}

TEST(Splats, LongOnesAreSplitUntilTheyBend) {
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,1], "width": 1, "angle_deg": 70}
)",
      "s.knead");
  const Flow flow = flow_of(session);
  Mesh mesh = random_splats(200, 9);
  normalise_turns(mesh);
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.name.starts_with("scale_")) attribute.values[7] = attribute.name == "scale_1" ? -0.7 : -3;
  }
  mesh.positions[7] = {0.1, 0, 0.2};
  for (const bool is_text : {false, true}) {
    const std::string bytes = is_text ? text_of(mesh) : serialize_mesh("ply", mesh, {.double_coordinates = true});
    const ShapeFile source = parse_shape(bytes, "ply", "source.ply");
    const std::optional<ShapeFile> split = split_of(source, session, 3000);
    ASSERT_TRUE(split);
    ASSERT_GT(split->mesh.vertex_count(), 203U);
    for (std::size_t i = 0; i < split->mesh.vertex_count(); ++i) EXPECT_LT(bend_of(split->mesh, i, flow), 0.101) << i;
    for (std::size_t i = 0; i < 200; ++i) {
      if (bend_of(mesh, i, flow) > 0.1) continue;
      EXPECT_EQ(split->mesh.positions[i], source.mesh.positions[i]);
      EXPECT_EQ(value(split->mesh, "scale_0", i), value(source.mesh, "scale_0", i));
    }
    EXPECT_FALSE(split_of(source, session, 0));
    EXPECT_FALSE(split_of(*split, session, 10'000));
    std::vector<std::string> notes;
    EXPECT_LE(split_of(source, session, 210, &notes)->mesh.vertex_count(), 210U);
    EXPECT_EQ(notes.size(), 1U);
    EXPECT_NE(notes[0].find("at most 210 splats are allowed, too few"), std::string::npos);
  }
}

// A stamp that touches nothing resolves to no stroke, so the bend is the second stroke of the session only.
TEST(Splats, AreSplitWherePartOfASessionThatReadsTheSurfaceIsApplied) {
  const test::Scratch folder("splats");
  write_mesh(folder.path() / "tool.ply", make_shape(ShapeKind::sphere, 162));
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "stamp", "mesh": "tool.ply", "path": [[0, 0, 90], [0, 0, 80]]}
{"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,1], "width": 1, "angle_deg": 70}
)",
      (folder.path() / "s.knead").string());
  const Mesh mesh = random_splats(200, 9);
  const ShapeFile source = parse_shape(serialize_mesh("ply", mesh, {.double_coordinates = true}), "ply", "source.ply");
  const std::optional<ShapeFile> whole = split_of(source, session, 3000);
  ASSERT_TRUE(whole);
  ReplayOptions options;
  options.part.until = 2;
  ShapeFile shape = source;
  EXPECT_TRUE(split_splats(shape, session, options, 3000));
  EXPECT_EQ(shape.mesh.positions, whole->mesh.positions);
}

// The mesh of a split file is what the written file holds: in place or with wider rows, moved or not, split once or
// twice.
TEST(Splats, PiecesAreRowsOfTheFile) {
  const auto bend = [](int degrees) {
    return parse_session(
        fmt::format("{{\"knead\": 1}}\n{{\"tool\": \"bend\", \"center\": [0,0,0], \"axis\": [0,1,0], \"normal\": "
                    "[0,0,1], \"width\": 1, \"angle_deg\": {}}}\n",
                    degrees),
        "s.knead");
  };
  std::string bytes = serialize_mesh("ply", random_splats(200, 9));
  bytes.insert(bytes.find("end_header"), "element camera 1\nproperty uchar id\n");
  bytes += "\7";
  const ShapeFile source = parse_shape(bytes, "ply", "source.ply");
  const std::optional<ShapeFile> once = split_of(source, bend(40), 3000);
  ASSERT_TRUE(once);
  const std::optional<ShapeFile> twice = split_of(*once, bend(160), 3000);
  ASSERT_TRUE(twice);
  EXPECT_GT(twice->mesh.vertex_count(), once->mesh.vertex_count());
  for (const ShapeFile* split : {&*once, &*twice}) {
    for (const bool as_doubles : {false, true}) {
      for (const double shift : {0.0, 0.5}) {
        std::vector<Vec3d> positions = split->mesh.positions;
        for (Vec3d& p : positions) p.y = as_doubles ? p.y + shift : static_cast<float>(p.y + shift);
        const std::string written = serialize_shape("ply", *split, positions, {.double_coordinates = as_doubles});
        EXPECT_EQ(written.back(), '\7');
        const ShapeFile read = parse_shape(written, "ply", "written.ply");
        EXPECT_EQ(read.mesh.positions, positions);
        EXPECT_EQ(read.mesh.attributes, split->mesh.attributes);
      }
    }
  }
}

// Backwards the pieces are hardly split again (without regard to the way they came: into twice as many), and all
// numbers come back.
TEST(Splats, PiecesComeBackAsTheyWere) {
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,1], "width": 1, "angle_deg": 70}
{"tool": "rotate", "center": [0, 0, 0.5], "axis": [0, 0, 1], "angle_deg": 60, "inner": 0.2, "outer": 0.9}
)",
      "s.knead");
  Mesh mesh = random_splats(1000, 9);
  normalise_turns(mesh);
  const ShapeFile source = parse_shape(serialize_mesh("ply", mesh, {.double_coordinates = true}), "ply", "source.ply");
  const std::optional<ShapeFile> split = split_of(source, session, 10'000);
  ASSERT_TRUE(split);
  EXPECT_GT(split->mesh.vertex_count(), 1200U);
  const ReplayResult there = replay(borrow(split->mesh), session, {});
  const ShapeFile bent = parse_shape(serialize_deformed("ply", *split, there.shape), "ply", "bent.ply");
  ReplayOptions backwards;
  backwards.part.direction = Direction::backwards;
  ShapeFile again = bent;
  split_splats(again, session, backwards, 20'000);
  EXPECT_LE(again.mesh.vertex_count(), bent.mesh.vertex_count() + bent.mesh.vertex_count() / 500);
  const ReplayResult back = replay(borrow(bent.mesh), session, backwards);
  constexpr double kRounding = 3e-5;  // the file holds floats, and sizes differ by a factor of 1000
  const Mesh found = with_splats(bent.mesh, back.shape);
  for (std::size_t i = 0; i < found.vertex_count(); ++i) {  // turns about axes between equal sizes say nothing
    EXPECT_LT(norm(found.positions[i] - split->mesh.positions[i]), 1e-5);
    const Mat3d expected = covariance(split->mesh, i);
    EXPECT_LT(row_sum_norm(covariance(found, i) + expected * -1.0), kRounding * row_sum_norm(expected));
    for (std::size_t a = 0; a < found.attributes.size(); ++a) {
      if (found.attributes[a].name.starts_with("rot_")) continue;
      EXPECT_NEAR(found.attributes[a].values[i], split->mesh.attributes[a].values[i], kRounding);
    }
  }
}

// Points farther from the arc than half its radius run away: the splats that reach there stay as they were, and
// the others are split as without them.
TEST(Splats, OnlyThoseOfWhichAPartRunsAwayStayWhole) {
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "curve", "from": [[-1, 0, 0], [1, 0, 0]], "angle_deg": 180, "axis": [0, 1, 0]}
)",
      "s.knead");
  Mesh mesh = random_splats(1500, 0);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) mesh.positions[i] = mesh.positions[i] * 0.1;
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.name == "scale_0") attribute.values.assign(mesh.vertex_count(), std::log(0.15));
    if (attribute.name == "scale_1" || attribute.name == "scale_2") {
      attribute.values.assign(mesh.vertex_count(), std::log(0.01));
    }
    if (attribute.name.starts_with("rot_")) attribute.values.assign(mesh.vertex_count(), attribute.name == "rot_0");
    if (attribute.name == "opacity") attribute.values.assign(mesh.vertex_count(), 2);
  }
  const auto split_with = [&](std::vector<std::uint32_t> long_ones) {
    Mesh changed = mesh;
    for (Attribute& attribute : changed.attributes) {
      for (const std::uint32_t i : long_ones) {
        if (attribute.name == "scale_1" || attribute.name == "scale_2") attribute.values[i] = std::log(0.7);
      }
    }
    std::vector<std::string> notes;
    const ShapeFile source = parse_shape(serialize_mesh("ply", changed), "ply", "source.ply");
    const std::optional<ShapeFile> split = split_of(source, session, 100'000, &notes);
    return std::pair{split ? split->mesh : Mesh{}, notes};
  };
  const auto [all, no_notes] = split_with({});
  const auto [others, notes] = split_with({3, 700, 1499});
  EXPECT_TRUE(no_notes.empty());
  EXPECT_EQ(notes, std::vector<std::string>{"3 long splats kept whole: the strokes would take a part far away"});
  ASSERT_GT(all.vertex_count(), 3000U);
  EXPECT_LT(others.vertex_count(), all.vertex_count());
  EXPECT_GT(others.vertex_count(), all.vertex_count() - 3 * 20);
  EXPECT_EQ(others.positions[3], parse_shape(serialize_mesh("ply", mesh), "ply", "s").mesh.positions[3]);
  EXPECT_EQ(others.positions[4], all.positions[4]);
}

TEST(Splats, FilesOfTextAndWithRowsWithoutPlacesGetThem) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property float scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float opacity\n"
      "property float rot_0\nproperty float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n";
  const std::string still = "9 9 9 -1 -2 -3 0.50 1.0 0 0 0\n";
  const std::string odd = "nan 0 0 -1 -2 -3 0.5 1 0 0 0\n";
  const ShapeFile source = parse_shape(
      head + still + odd + "0 0 0 -1 -2 -3 0.50 1 0 0 0\n0 0.1 0 -1 -2 -3 0.5 1 0 0 0\n", "ply", "text.ply");
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "rotate", "center": [0,0,0], "axis": [0,0,1], "angle_deg": 90, "inner": 1, "outer": 2}
)",
      "s.knead");
  const ReplayResult result = replay(borrow(source.mesh), session, {});
  const std::string text = serialize_deformed("ply", source, result.shape);
  ASSERT_TRUE(text.starts_with(head + still + odd + "0 0 0 -1 -2 -3 0.50 0.7071") ||
              text.starts_with(head + still + odd + "0 0 0 -1.000"))
      << text;
  const ShapeFile moved = parse_shape(text, "ply", "moved.ply");
  EXPECT_NEAR(value(moved.mesh, "rot_3", 2), std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(moved.mesh.positions[2].x, -0.1, 1e-6);
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
  EXPECT_THROW(splat_degree(mesh), InvalidInput);
  EXPECT_THROW(replay(mesh, Session{}), InvalidInput);  // before anything is done
  mesh.attributes.erase(mesh.attributes.end() - 2);
  EXPECT_EQ(splat_degree(mesh), 1U);
  EXPECT_EQ(deformed_splats(mesh, {}).attributes.size(), 16U);
  EXPECT_THROW(deformed_splats(mesh, {{4}, {}}), InvalidInput);
  EXPECT_THROW(deformed_splats(mesh, {{5}, {Mat3d{}}}), InvalidInput);
  mesh.attributes.erase(mesh.attributes.begin());
  EXPECT_FALSE(are_splats(mesh));
  EXPECT_THROW(deformed_splats(mesh, {}), InvalidInput);
}

}  // namespace
}  // namespace knead::splats_test
