// Tests of the tool "lattice": its modes on shapes, what is refused, images, PyGeM's files, session lines, derivatives.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "support/random_fields.h"
#include "support/scratch.h"

namespace knead::lattice_test {

namespace {

using test::Random;

const Mesh& sphere() {
  static const Mesh mesh = make_shape(ShapeKind::sphere, 10'000);
  return mesh;
}

Mesh scaled(const Mesh& mesh, double by) {
  Mesh result = mesh;
  for (Vec3d& p : result.positions) p *= by;
  return result;
}

// A turned box about the unit sphere, times a size. The outer layers at its faces rest, if they are to.
LatticeStroke about_sphere(Random& random, double size, double amount, LatticeMode mode, bool is_closed) {
  LatticeStroke stroke;
  const Vec3d x = random.unit();
  const Vec3d y = any_orthogonal(x);
  stroke.axes = {x * 2, y, cross(x, y)};
  const double half = is_closed ? 1.4 : 1.01;
  stroke.origin = (x + y + cross(x, y)) * (-half * size);
  stroke.lengths = Vec3d{2, 2, 2} * (half * size);
  for (int& count : stroke.counts) count = random.integer(is_closed ? 5 : 2, is_closed ? 7 : 4);
  const auto [nx, ny, nz] = stroke.counts;
  for (int n = 0; n < nx * ny * nz; ++n) {
    const std::array<int, 3> at{n / (ny * nz), n / nz % ny, n % nz};
    bool rests = false;
    for (std::size_t axis = 0; axis < 3; ++axis) rests = rests || at[axis] < 2 || at[axis] >= stroke.counts[axis] - 2;
    stroke.displacements.push_back(is_closed && rests ? Vec3d{} : random.in_box(amount * size));
  }
  stroke.mode = mode;
  return stroke;
}

ReplayResult replayed(const Mesh& mesh, const std::vector<SessionStroke>& strokes, const ReplayOptions& options = {}) {
  Session session;
  session.strokes = strokes;
  ReplayResult result = Replay(borrow(mesh), session, options).run();
  EXPECT_EQ(result.status, AdvectStatus::done);
  return result;
}

std::vector<Vec3d> after(const Mesh& mesh, const Stroke& stroke) {
  const ReplayResult result = replayed(mesh, {{stroke}});
  return {result.shape.positions().begin(), result.shape.positions().end()};
}

std::string refusal_of(const Mesh& mesh, const Stroke& stroke) {
  try {
    after(mesh, stroke);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "not refused";
}

std::size_t crossings(const Mesh& mesh, const std::vector<Vec3d>& positions) {
  return self_intersections(triangulate(mesh), positions, {}).count;
}

double greatest_distance(std::span<const Vec3d> a, std::span<const Vec3d> b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, norm(a[i] - b[i]));
  return most;
}

// Shears by a wave, and so keeps volumes nearly: control points of a box about the sphere move across by their place.
LatticeStroke shear(LatticeMode mode) {
  LatticeStroke stroke;
  stroke.origin = {-1.1, -1.1, -1.1};
  stroke.lengths = {2.2, 2.2, 2.2};
  stroke.counts = {5, 3, 3};
  for (int n = 0; n < 45; ++n) stroke.displacements.push_back({0, 0, n / 9 % 2 == 0 ? 0.2 : -0.2});
  stroke.mode = mode;
  return stroke;
}

constexpr const char* kPrm = R"(
[Box info]
# n control points indicates the number of control points in each direction.
n control points x: 3
n control points y: 2
N Control Points z: 2

box length x: 2.0
box length y: 1.5
box length z: 3.0

box origin x: -1.0
box origin y: 0.5
box origin z: 0.25

rotation angle x: 20
rotation angle y: -10.5
rotation angle z: 33


[Parameters weights]
# | x index | y index | z index | weight |
parameter x: 0   0   0   0.0
             1   0   1   0.25

parameter y: 0   0   0   0.0
             2   1   1   -0.1
parameter z: 0   0   0   0.125
)";

}  // namespace

// The volume is that of the flow; crossings would be a fold.
TEST(Lattice, AVolumeLatticeKeepsTheVolume) {
  Random random(11);
  for (int n = 0; n < 10; ++n) {
    const double size = std::pow(10.0, 6.0 * n / 9 - 3);
    const bool is_closed = n % 2 == 0;
    const Mesh mesh = scaled(sphere(), size);
    const LatticeStroke stroke = about_sphere(random, size, is_closed ? 0.5 : 0.2, LatticeMode::volume, is_closed);
    const std::vector<Vec3d> moved = after(mesh, stroke);
    const double before = measure_volume_and_area(mesh, mesh.positions).volume;
    EXPECT_NEAR(measure_volume_and_area(mesh, moved).volume / before, 1, 1e-4) << n;
    EXPECT_EQ(crossings(mesh, moved), 0U) << n;
    // Nearer to the places than at rest. A tenth of the displacements does not fold the box.
    LatticeStroke tenth = stroke;
    tenth.mode = LatticeMode::spline;
    for (Vec3d& d : tenth.displacements) d *= 0.1;
    const std::vector<Vec3d> part = after(mesh, tenth);
    double miss = 0;
    double way = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Vec3d wanted = (part[i] - mesh.positions[i]) * 10;
      way += norm2(wanted);
      miss += norm2(wanted - (moved[i] - mesh.positions[i]));
    }
    EXPECT_LT(miss, 0.95 * way) << n;
  }
}

// Of displacements that nearly keep volumes the flow misses little; of others it says how much.
TEST(Lattice, AFlowComesNearWhereVolumesAllow) {
  const std::vector<Vec3d> aim = after(sphere(), shear(LatticeMode::spline));
  const ReplayResult near = replayed(sphere(), {{shear(LatticeMode::volume)}});
  EXPECT_LT(greatest_distance(near.shape.positions(), aim), 0.02);
  LatticeStroke grows = shear(LatticeMode::volume);
  for (int n = 0; n < 45; ++n) {
    const int layer = n / 9;
    grows.displacements[static_cast<std::size_t>(n)] = {0.2 * layer - 0.4, 0, 0};
  }
  const ReplayResult far = replayed(sphere(), {{grows}});
  ASSERT_EQ(far.warnings.size(), 1U);
  EXPECT_NE(far.warnings[0].find("the displacements change the volume: the shape comes within"), std::string::npos);
  grows.mode = LatticeMode::spline;
  const std::vector<Vec3d> wide = after(sphere(), grows);
  EXPECT_NEAR(measure_volume_and_area(sphere(), wide).volume / (4.18879 * 1.3636), 1, 0.01) << "by 0.8 in 2.2";
}

// The displacements move the end of a cylinder sidewards and press it, which changes the volume.
TEST(Lattice, APointCloudFollows) {
  Mesh cloud;
  cloud.positions = sphere().positions;
  const std::vector<Vec3d> wanted = after(cloud, shear(LatticeMode::spline));
  const double most = greatest_distance(cloud.positions, wanted);
  EXPECT_GT(most, 0.1);
  EXPECT_LT(greatest_distance(after(cloud, shear(LatticeMode::volume)), wanted), 0.2 * most);
}

TEST(Lattice, AFlatEndStaysFlat) {
  const Mesh cylinder = make_shape(ShapeKind::cylinder, 5000);
  const Box box = shape_box(cylinder);
  const Vec3d size = box.max - box.min;
  const std::size_t along = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  const double radius = 0.5 * size[(along + 1) % 3];
  LatticeStroke stroke;
  stroke.origin = box.min - size * 0.1;
  stroke.lengths = size * 1.2;
  stroke.counts = {3, 3, 3};
  stroke.counts[along] = 6;
  const auto [nx, ny, nz] = stroke.counts;
  for (int n = 0; n < nx * ny * nz; ++n) {
    const std::array<int, 3> at{n / (ny * nz), n / nz % ny, n % nz};
    const double up = at[along] / 5.0;
    Vec3d d{0, 0, 0};
    d[(along + 1) % 3] = 1.8 * radius * up * up;
    d[along] = -0.5 * radius * up * up;
    stroke.displacements.push_back(d);
  }
  const std::vector<Vec3d> moved = after(cylinder, stroke);
  Vec3d middle{0, 0, 0};
  Vec3d normal{0, 0, 0};
  std::vector<Vec3d> end;
  for (const Triangle& t : triangulate(cylinder)) {
    if (std::any_of(t.begin(), t.end(), [&](std::uint32_t v) {
          return cylinder.positions[v][along] < box.max[along] - 1e-9 * size[along];
        })) {
      continue;
    }
    normal += cross(moved[t[1]] - moved[t[0]], moved[t[2]] - moved[t[0]]);
    for (const std::uint32_t v : t) {
      end.push_back(moved[v]);
      middle += moved[v];
    }
  }
  ASSERT_GT(end.size(), 100U);
  middle *= 1 / static_cast<double>(end.size());
  for (const Vec3d& p : end) EXPECT_LT(std::abs(dot(p - middle, normalized(normal))), 0.02 * radius);
}

// Displacements so strong that steps would make triangles cross.
TEST(Lattice, TheMotionEndsBeforeItSpoilsTheShape) {
  const Mesh box = make_shape(ShapeKind::box, 4000);
  Random random(17);
  int short_ones = 0;
  for (int n = 0; n < 4; ++n) {
    LatticeStroke stroke;
    const Box around = shape_box(box);
    stroke.origin = around.min - (around.max - around.min) * 0.02;
    stroke.lengths = (around.max - around.min) * 1.04;
    stroke.counts = {2, 2, 2};
    for (int k = 0; k < 8; ++k) stroke.displacements.push_back(random.in_box(0.7 * stroke.lengths.x));
    const ReplayResult result = replayed(box, {{stroke}});
    const std::vector<Vec3d> moved(result.shape.positions().begin(), result.shape.positions().end());
    EXPECT_EQ(crossings(box, moved), 0U) << n;
    if (result.shortfalls.empty()) continue;
    ++short_ones;
    EXPECT_NE(result.shortfalls[0].find("\"displacements\": the shape came "), std::string::npos);
    EXPECT_GT(greatest_distance(moved, box.positions), 0.1) << "what was sound has moved";
  }
  EXPECT_GT(short_ones, 0);
}

// An ellipsoid along x that an arc of 60 degrees bends: the rigid one follows with less strain than the other modes.
TEST(Lattice, ARigidLatticeStrainsLess) {
  Mesh ellipsoid = sphere();
  for (Vec3d& p : ellipsoid.positions) p.x *= 4;
  LatticeStroke stroke;
  stroke.origin = {-4.1, -1.1, -1.1};
  stroke.lengths = {8.2, 2.2, 2.2};
  stroke.counts = {7, 3, 3};
  for (int n = 0; n < 63; ++n) {
    const int layer = n / 9;
    const Vec3d p = stroke.origin + Vec3d{8.2 * layer / 6, 1.1 * (n / 3 % 3), 1.1 * (n % 3)};
    const SinCos<double> turn = sincos(p.x / 8);
    stroke.displacements.push_back(Vec3d{(8 - p.y) * turn.sin, 8 - (8 - p.y) * turn.cos, p.z} - p);
  }
  const auto stretch = [&](const std::vector<Vec3d>& moved) {
    return surface_stretch(triangulate(ellipsoid), ellipsoid.positions, moved).worst();
  };
  const std::vector<Vec3d> by_volume = after(ellipsoid, stroke);
  stroke.mode = LatticeMode::spline;
  const std::vector<Vec3d> aim = after(ellipsoid, stroke);
  stroke.mode = LatticeMode::rigid;
  const std::vector<Vec3d> rigid = after(ellipsoid, stroke);
  EXPECT_LT(stretch(rigid) - 1, 0.9 * (stretch(by_volume) - 1));
  const double way = greatest_distance(ellipsoid.positions, aim);
  EXPECT_LT(greatest_distance(by_volume, aim), 0.1 * way);
  EXPECT_LT(greatest_distance(rigid, aim), 0.5 * way);
  EXPECT_NEAR(
      measure_volume_and_area(ellipsoid, rigid).volume / measure_volume_and_area(ellipsoid, ellipsoid.positions).volume,
      1, 1e-4);
}

TEST(Lattice, NothingOutsideOfClosedFacesMoves) {
  for (const LatticeMode mode : {LatticeMode::volume, LatticeMode::rigid, LatticeMode::spline}) {
    Random random(12);
    LatticeStroke stroke = about_sphere(random, 1, 0.5, mode, true);
    stroke.origin += Vec3d{0.9, 0, 0};
    if (mode == LatticeMode::spline) {
      for (Vec3d& d : stroke.displacements) d *= 0.4;
    }
    const std::vector<Vec3d> moved = after(sphere(), stroke);
    int outside = 0;
    int inside = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const Vec3d d = sphere().positions[i] - stroke.origin;
      bool is_inside = true;
      for (const Vec3d& axis : {stroke.axes.row0, stroke.axes.row1, stroke.axes.row2}) {
        const double u = dot(normalized(axis), d) / stroke.lengths.x;
        is_inside = is_inside && u >= 0 && u <= 1;
      }
      if (is_inside) inside += moved[i] != sphere().positions[i] ? 1 : 0;
      if (is_inside) continue;
      ++outside;
      EXPECT_EQ(moved[i], sphere().positions[i]);
    }
    EXPECT_GT(outside, 100);
    EXPECT_GT(inside, 100);
    EXPECT_EQ(crossings(sphere(), moved), 0U);
  }
}

TEST(Lattice, AShapeThroughAnOpenFaceIsRefused) {
  for (const LatticeMode mode : {LatticeMode::volume, LatticeMode::rigid, LatticeMode::spline}) {
    LatticeStroke stroke = shear(mode);
    stroke.lengths.z = 1.5;
    const std::string message = refusal_of(sphere(), stroke);
    EXPECT_NE(message.find("at the upper end of axis 2, and the shape reaches through that face"), std::string::npos)
        << message;
  }
}

TEST(Lattice, AFoldIsRefusedWithAStrengthThatWorks) {
  LatticeStroke stroke = shear(LatticeMode::spline);
  for (int n = 0; n < 45; ++n) stroke.displacements[static_cast<std::size_t>(n)] = {0, 1.5 * (1 - n / 3 % 3), 0};
  const std::string message = refusal_of(sphere(), stroke);
  EXPECT_NE(message.find("\"displacements\" fold the box at ["), std::string::npos) << message;
  const std::size_t at = message.find("; 0.");
  ASSERT_NE(at, std::string::npos) << message;
  SessionStroke less{stroke};
  less.strength = std::stod(message.substr(at + 2));
  EXPECT_NEAR(less.strength, 2.2 / 3, 0.02);
  for (Vec3d& d : stroke.displacements) d *= less.strength;
  EXPECT_EQ(refusal_of(sphere(), stroke), "not refused");
}

TEST(Lattice, BitsDependNeitherOnThreadsNorOnTheMode) {
  Random random(13);
  const LatticeStroke stroke = about_sphere(random, 1, 0.4, LatticeMode::volume, true);
  ReplayOptions one;
  one.motion.threads = 1;
  ReplayOptions many;
  many.motion.threads = 3;
  const ReplayResult a = replayed(sphere(), {{stroke}}, one);
  const ReplayResult b = replayed(sphere(), {{stroke}}, many);
  EXPECT_TRUE(std::equal(a.shape.positions().begin(), a.shape.positions().end(), b.shape.positions().begin()));
  const ReplayResult again = replayed(sphere(), a.resolved);
  EXPECT_TRUE(std::equal(a.shape.positions().begin(), a.shape.positions().end(), again.shape.positions().begin()));
}

// The image of the stroke does to the image of the shape what the stroke does to the shape.
TEST(Lattice, AnImageMovesTheImage) {
  Random random(14);
  const LatticeStroke spline = about_sphere(random, 1, 0.15, LatticeMode::spline, false);
  const std::vector<RigidMotion> motions{rotation_about({1, 2, 3}, {1, -1, 2}, 0.7),
                                         reflection_in({0, 1, 0}, {1, 1, 0})};
  const std::vector<Vec3d> moved = after(sphere(), spline);
  for (const RigidMotion& motion : motions) {
    Mesh image = sphere();
    for (Vec3d& p : image.positions) p = motion(p);
    std::vector<Vec3d> aim = moved;
    for (Vec3d& p : aim) p = motion(p);
    EXPECT_LE(greatest_distance(after(image, transformed(spline, motion)), aim), 1e-12);
  }
  const Stroke once = mirrored(spline, 1);
  EXPECT_EQ(std::get<LatticeStroke>(mirrored(once, 1)), spline);
}

TEST(Lattice, TheKeyMirrorMovesBothSides) {
  LatticeStroke stroke = shear(LatticeMode::volume);
  stroke.origin = {0.2, -1.4, -1.4};
  stroke.lengths = {1.2, 2.8, 2.8};
  stroke.counts = {5, 5, 5};
  stroke.displacements.assign(125, {});
  stroke.displacements[62] = {0.2, 0.3, 0};
  Session session;
  session.strokes = {{stroke}};
  session.strokes[0].mirror = coordinate_mirror("x");
  const ReplayResult result = Replay(borrow(sphere()), session, {}).run();
  double left = 0;
  double right = 0;
  for (std::size_t i = 0; i < sphere().positions.size(); ++i) {
    const Vec3d by = result.shape.positions()[i] - sphere().positions[i];
    (sphere().positions[i].x < 0 ? left : right) += by.x;
  }
  EXPECT_GT(right, 1);
  EXPECT_NEAR(left / right, -1, 1e-3);
  session.strokes[0].stroke = shear(LatticeMode::spline);
  EXPECT_THROW(Replay(borrow(sphere()), session, {}).run(), InvalidInput);
}

TEST(Lattice, ARemeshFollows) {
  Session session = parse_session("{\"knead\": 1}\n{\"remesh\": {\"max_chord\": 0.0005}}\n" +
                                      stroke_line(SessionStroke{shear(LatticeMode::spline)}),
                                  "session");
  const ReplayResult result = Replay(borrow(sphere()), session, {}).run();
  EXPECT_EQ(result.status, AdvectStatus::done);
  EXPECT_TRUE(result.shape.is_remeshed());
  EXPECT_EQ(self_intersections(result.shape.triangles(), result.shape.positions(), {}).count, 0U);
}

TEST(Lattice, AMaskThatItMovesIsRefused) {
  Session session;
  MaskStroke mask;
  mask.points = {{0, 0, 1}};
  mask.width = 0.2;
  session.strokes = {{mask}, {shear(LatticeMode::spline)}};
  EXPECT_THROW(Replay(borrow(sphere()), session, {}).run(), InvalidInput);
  session.strokes[1].stroke = shear(LatticeMode::volume);
  const ReplayResult result = Replay(borrow(sphere()), session, {}).run();
  for (std::size_t i = 0; i < sphere().positions.size(); ++i) {
    if (sphere().positions[i] == Vec3d{0, 0, 1}) {
      EXPECT_EQ(result.shape.positions()[i], sphere().positions[i]);
    }
  }
}

TEST(Lattice, SessionLinesKeepEveryNumber) {
  Random random(15);
  for (const LatticeMode mode : {LatticeMode::volume, LatticeMode::rigid, LatticeMode::spline}) {
    LatticeStroke stroke = about_sphere(random, 1, 0.3, mode, false);
    stroke.degree = mode == LatticeMode::rigid ? 2 : 0;
    EXPECT_EQ(parse_stroke(stroke_line(SessionStroke{stroke}), "line").stroke, Stroke(stroke));
  }
}

TEST(Lattice, WrongNumbersAreRefusedByTheirKey) {
  const auto refused = [](const std::string& line, const std::string& begin) {
    try {
      parse_stroke(line, "line");
      ADD_FAILURE() << "not refused: " << line;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(begin), std::string::npos) << error.what();
    }
  };
  const std::string box = R"({"tool": "lattice", "lengths": [1, 1, 1], )";
  const std::string zeros = R"("displacements": [[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]], )";
  parse_stroke(box + zeros + R"("counts": [2, 2, 2]})", "line");
  refused(R"({"tool": "lattice"})", "\"counts\" must be three whole numbers from 2 to 64");
  refused(box + R"("counts": [2, 2, 2]})", "\"displacements\" must hold a vector for each of the 8 control points");
  refused(box + R"("counts": [2, 17, 2]})", "\"degree\" is missing");
  refused(box + zeros + R"("counts": [2, 2, 2], "degree": 16})", "\"degree\" must be from 1 to 15");
  refused(box + zeros + R"("counts": [2, 2, 2], "axes": [[1, 0, 0], [1, 1, 0], [0, 0, 1]]})", "\"axes\" must be three");
  refused(R"({"tool": "lattice", "counts": [2, 2, 2], "lengths": [1, 0, 1]})", "\"lengths\" must be three lengths");
  refused(R"({"tool": "lattice", "file": "a.prm", "counts": [2, 2, 2]})", "\"file\" gives the box");
}

// x at (1, 0, 1), y at (2, 1, 1), z at (0, 0, 0), along the turned edges, as multiples of their lengths.
TEST(Lattice, ReadsTheParametersOfPygem) {
  const test::Scratch scratch("lattice");
  write_file_atomically(scratch.path() / "box.prm", kPrm);
  Session session =
      parse_session("{\"knead\": 1}\n{\"tool\": \"lattice\", \"file\": \"box.prm\", \"mode\": \"spline\"}",
                    (scratch.path() / "s.knead").string());
  Mesh cloud;
  const double x = 20 * 0.017453292519943295;
  const double y = -10.5 * 0.017453292519943295;
  const double z = 33 * 0.017453292519943295;
  // The edges as the product Rx Ry Rz has them.
  const auto turned = [&](Vec3d v) {
    v = {v.x * std::cos(z) - v.y * std::sin(z), v.x * std::sin(z) + v.y * std::cos(z), v.z};
    v = {v.x * std::cos(y) + v.z * std::sin(y), v.y, v.z * std::cos(y) - v.x * std::sin(y)};
    return Vec3d{v.x, v.y * std::cos(x) - v.z * std::sin(x), v.y * std::sin(x) + v.z * std::cos(x)};
  };
  std::vector<Vec3d> aim;
  Random random(16);
  for (int n = 0; n < 50; ++n) {
    const Vec3d u = (random.in_box(1) + Vec3d{1, 1, 1}) * 0.5;
    const Vec3d p = Vec3d{-1, 0.5, 0.25} + turned({2 * u.x, 1.5 * u.y, 3 * u.z});
    const double wx = 2 * u.x * (1 - u.x) * (1 - u.y) * u.z * 0.25 * 2;
    const double wy = u.x * u.x * u.y * u.z * -0.1 * 1.5;
    const double wz = (1 - u.x) * (1 - u.x) * (1 - u.y) * (1 - u.z) * 0.125 * 3;
    cloud.positions.push_back(p);
    aim.push_back(p + turned({wx, wy, wz}));
  }
  const ReplayResult result = Replay(borrow(cloud), session, {}).run();
  EXPECT_LE(greatest_distance(result.shape.positions(), aim), 1e-14 * 10);
  ASSERT_EQ(result.resolved.size(), 1U);
  EXPECT_TRUE(std::get<LatticeStroke>(result.resolved[0].stroke).file.empty()) << "needs no file";
  write_file_atomically(scratch.path() / "box.prm", "[Box info]\nn control points x: 3\n");
  try {
    Replay(borrow(cloud), session, {}).run();
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("\"file\": box.prm: \"n control points y\" is missing"), std::string::npos)
        << error.what();
  }
}

// About a shape lies a lattice at rest; its control points move by their displacements, and linear ones move all
// linearly.
TEST(Lattice, ALatticeAboutAShapeIsMovedByItsControlPoints) {
  Random random(23);
  for (const double size : {1e-3, 1.0, 1e3}) {
    const Mesh mesh = scaled(sphere(), size);
    LatticeStroke stroke =
        lattice_about(bounding_box(mesh.positions), {random.integer(2, 6), random.integer(2, 6), random.integer(2, 6)});
    const std::vector<Vec3d> places = control_points(stroke);
    const Box box = bounding_box(places);
    for (const Vec3d& p : mesh.positions) ASSERT_TRUE(contains(box, p));
    const Mat3d linear = Mat3d{} + Mat3d{random.in_box(0.2), random.in_box(0.2), random.in_box(0.2)};
    for (std::size_t i = 0; i < places.size(); ++i) stroke.displacements[i] = linear * places[i] - places[i];
    const std::vector<Vec3d> moved = control_points(stroke);
    for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LE(norm(moved[i] - linear * places[i]), 1e-14 * size);
    stroke.mode = LatticeMode::spline;
    const std::vector<Vec3d> now = after(mesh, stroke);
    for (std::size_t v = 0; v < now.size(); ++v) {
      ASSERT_LE(norm(now[v] - linear * mesh.positions[v]), 1e-13 * size) << v;
    }
  }
}

TEST(Lattice, AFlatShapeGetsABoxWithAHeight) {
  const LatticeStroke stroke = lattice_about({{-1, 0, 2}, {1, 3, 2}}, {3, 3, 2});
  EXPECT_GT(stroke.lengths.z, 0);
  EXPECT_LT(stroke.lengths.z, 0.1);
  EXPECT_EQ(control_points(stroke).size(), 18U);
  EXPECT_THROW(lattice_about({{1, 1, 1}, {1, 1, 1}}, {3, 3, 3}), InvalidInput);
  EXPECT_THROW(lattice_about({}, {3, 3, 3}), InvalidInput);
}

// Parameters may be any of the displacements.
TEST(Lattice, DisplacementsMayBeParameters) {
  std::string line =
      R"({"tool": "lattice", "mode": "spline", "lengths": [1, 1, 1], "counts": [2, 2, 2], "displacements": [)";
  std::string parameters;
  for (int n = 0; n < 24; ++n) {
    line += fmt::format("{}\"$d{}\"{}", n % 3 == 0 ? "[" : "", n, n % 3 == 2 ? (n == 23 ? "]" : "], ") : ", ");
    parameters += fmt::format("{}\"d{}\": {}", n == 0 ? "" : ", ", n, 0.01 * (n % 5));
  }
  const Session session =
      parse_session("{\"knead\": 1, \"parameters\": {" + parameters + "}}\n" + line + "]}\n", "session");
  Random random(17);
  std::vector<Vec3d> points(30);
  for (Vec3d& p : points) p = (random.in_box(1) + Vec3d{1, 1, 1}) * 0.5;
  const SessionDerivatives derivatives(session);
  std::vector<double> direction(24);
  for (double& number : direction) number = random.uniform(-1, 1);
  const PointTangents there = derivatives.jvp(points, direction, {});
  std::vector<Vec3d> gradient;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& u = points[i];
    Vec3d aim{0, 0, 0};
    for (std::size_t n = 0; n < 24; ++n) {
      const std::size_t corner = n / 3;
      aim[n % 3] += direction[n] * (corner / 4 == 1 ? u.x : 1 - u.x) * (corner / 2 % 2 == 1 ? u.y : 1 - u.y) *
                    (corner % 2 == 1 ? u.z : 1 - u.z);
    }
    EXPECT_LE(norm(there.tangents[i] - aim), 1e-10);
    gradient.push_back(random.in_box(1));
    sum += dot(gradient.back(), there.tangents[i]);
  }
  const SessionGradient back = derivatives.vjp(points, gradient, {});
  double same = 0;
  for (std::size_t n = 0; n < 24; ++n) same += direction[n] * back.parameters[n];
  EXPECT_NEAR(same, sum, 1e-10);
}

}  // namespace knead::lattice_test
