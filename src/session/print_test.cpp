// Prints: letters, pictures and text in spheres, plates and cylinders.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <string>

#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"
#include "support/scratch.h"

namespace knead::print_test {
namespace {

// Numbers of a floor, or of what is raised.
struct Floor {
  double off = 0;  // mean against what is wanted
  double rough = 0;
  std::size_t vertices = 0;
};

Mesh plate(double size = 1) {
  Mesh mesh;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-0.6, 0.6}) {
      for (const double z : {-0.3, 0.0}) mesh.positions.push_back(Vec3d{x, y, z} * size);
    }
  }
  for (const Triangle& t : std::vector<Triangle>{{0, 1, 3},
                                                 {0, 3, 2},
                                                 {4, 6, 7},
                                                 {4, 7, 5},
                                                 {0, 4, 5},
                                                 {0, 5, 1},
                                                 {2, 3, 7},
                                                 {2, 7, 6},
                                                 {0, 2, 6},
                                                 {0, 6, 4},
                                                 {1, 5, 7},
                                                 {1, 7, 3}}) {
    mesh.add_face(t);
  }
  return mesh;
}

class Print : public testing::Test {
 protected:
  Print() {
    write_mesh(folder_ / "y.ply", make_shape(ShapeKind::letter_y, 2000));
    write_picture("bar.pgm", [](int x, int y) { return x >= 20 && x < 100 && y >= 20 && y < 40 ? 255 : 0; });
  }

  // 120 x 60 pixels.
  template <class Grey>
  void write_picture(const std::string& name, const Grey& grey) const {
    std::ofstream file(folder_ / name, std::ios::binary);
    file << "P5\n120 60\n255\n";
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 120; ++x) file.put(static_cast<char>(grey(x, y)));
    }
  }

  Session session(const std::string& keys) const {
    return parse_session("{\"knead\": 1}\n{\"tool\": \"print\", " + keys + "}\n", (folder_ / "s.knead").string());
  }

  ReplayResult printed(const Mesh& mesh, const std::string& keys, const ReplayOptions& options = {}) const {
    ReplayResult result = replay(mesh, session(keys), options);
    EXPECT_EQ(result.status, AdvectStatus::done);
    return result;
  }

  static ReplayOptions remeshing() {
    ReplayOptions options;
    options.remesh.settings = RemeshSettings{};
    options.remesh.settings->max_chord = 1e-4;  // as knead print
    return options;
  }

  std::string error_of(const Mesh& mesh, const std::string& keys) const {
    try {
      replay(mesh, session(keys), {});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  // What the bar of bar.pgm, 0.2 high where the picture is 0.6 high, does to the plate's top.
  static Floor floor_of_bar(const Mesh& mesh, double depth, double inside, double size = 1) {
    Floor floor;
    double sum2 = 0;
    for (const Vec3d& p : mesh.positions) {
      const Vec3d q = p / size;
      if (q.z < -0.2 || std::abs(q.x) > 0.4 - inside || std::abs(q.y) > 0.1 - inside) continue;
      floor.off += q.z + depth;
      sum2 += (q.z + depth) * (q.z + depth);
      ++floor.vertices;
    }
    const auto count = static_cast<double>(floor.vertices);
    floor.off /= count;
    floor.rough = std::sqrt(std::max(0.0, sum2 / count - floor.off * floor.off));
    return floor;
  }

  test::Scratch scratch_{"print"};
  const std::filesystem::path& folder_ = scratch_.path();
  const std::string bar_ = R"("file": "bar.pgm", "point": [0, 0, 0], "height": 0.6, "bump": 0.04, "depth": )";
};

double volume_change(const Mesh& before, const Mesh& after) {
  return measure(after).volume / measure(before).volume - 1;
}

std::size_t crossings(const Mesh& mesh) { return self_intersections(triangulate(mesh), mesh.positions).count; }

// The letter of the brief: 0.6 high, 0.1 deep, on the unit sphere.
TEST_F(Print, ALetterHasAFlatFloorAndLowRims) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 60'000);
  Mesh after = sphere;
  after.positions =
      printed(sphere, R"("file": "y.ply", "point": [0, 0, 1], "height": 0.6, "depth": 0.1, "bump": 0.05, "outer": 1)")
          .shape.positions();
  const Mesh letter = make_shape(ShapeKind::letter_y, 20'000);
  const SurfaceTree tree(triangulate(letter), letter.positions);
  constexpr double kScale = 0.6 / 0.8;
  double rim = 0;
  double sum = 0;
  double sum2 = 0;
  double count = 0;
  for (const Vec3d& p : after.positions) {
    rim = std::max(rim, norm(p) - 1);
    const Vec3d at{p.x / kScale, p.y / kScale, 0};
    if (p.z < 0 || tree.hits(at, {0, 0, 1}).size() % 2 == 0) continue;
    if (norm(tree.closest(at)->point - at) * kScale < 0.045) continue;
    const double off = p.z - std::sqrt(1 - p.x * p.x - p.y * p.y) + 0.1;
    sum += off;
    sum2 += off * off;
    count += 1;
  }
  ASSERT_GT(count, 30);
  EXPECT_LT(rim, 0.012);
  EXPECT_LT(std::abs(sum / count), 0.005);
  EXPECT_LT(std::sqrt(sum2 / count - sum * sum / count / count), 0.004);
  EXPECT_LT(std::abs(volume_change(sphere, after)), 1e-4);
  EXPECT_EQ(crossings(after), 0U);
}

// Of twelve triangles, in any unit, deeper and raised.
TEST_F(Print, TheMeshOfACoarsePlateFollows) {
  for (const auto& [size, depth] : {std::pair(1.0, 0.06), {1e-3, 0.1}, {1e3, -0.08}}) {
    const Mesh before = plate(size);
    const std::string keys = fmt::format(R"("file": "bar.pgm", "height": {}, "depth": {}, "bump": {})", 0.6 * size,
                                         depth * size, 0.04 * size);
    const ReplayResult result = printed(before, keys, remeshing());
    EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
    Mesh after = result.shape.mesh();
    after.positions = result.shape.positions();
    const Floor floor = floor_of_bar(after, depth, 0.045, size);
    EXPECT_GT(floor.vertices, 40U);
    EXPECT_LT(std::abs(floor.off), 0.05 * std::abs(depth)) << size;
    EXPECT_LT(floor.rough, 0.04 * std::abs(depth)) << size;
    EXPECT_LT(std::abs(volume_change(before, after)), 1e-4);
    EXPECT_EQ(crossings(after), 0U);
  }
}

// Only under the print are the faces looked at as finely as it is.
TEST_F(Print, ASmallPrintNeedsNoFineFaces) {
  const ReplayResult result =
      printed(plate(), R"("file": "bar.pgm", "height": 0.06, "depth": 0.005, "bump": 0.004)", remeshing());
  double sum = 0;
  int count = 0;
  for (const Vec3d& p : result.shape.positions()) {
    if (p.z < -0.2 || std::abs(p.x) > 0.035 || std::abs(p.y) > 0.005) continue;
    sum += p.z;
    ++count;
  }
  ASSERT_GT(count, 20);
  EXPECT_NEAR(sum / count, -0.005, 0.0004);
}

TEST_F(Print, GreyIsPartOfTheDepth) {
  write_picture("grey.pgm", [](int x, int y) { return y < 20 || y >= 40 ? 0 : x < 60 ? 51 : 204; });
  const ReplayResult result =
      printed(plate(), R"("file": "grey.pgm", "height": 0.6, "depth": 0.1, "bump": 0.04)", remeshing());
  for (const double x : {-0.35, 0.35}) {
    double sum = 0;
    int count = 0;
    for (const Vec3d& p : result.shape.positions()) {
      if (p.z < -0.29 || std::abs(p.x - x) > 0.15 || std::abs(p.y) > 0.05) continue;
      sum += p.z;
      ++count;
    }
    EXPECT_NEAR(sum / count, x < 0 ? -0.02 : -0.08, 0.004);
  }
}

// A face that slants away prints less deep by as much as it lies behind its lowest place, in the size of the print.
TEST_F(Print, ASlantingFaceOfAMeshPrintsASlope) {
  Mesh face;
  face.positions = {{-2, -1, 0}, {2, -1, 0.4}, {2, 1, 0.4}, {-2, 1, 0}};
  for (const Triangle& t : std::vector<Triangle>{{0, 2, 1}, {0, 3, 2}}) face.add_face(t);
  write_mesh(folder_ / "slant.ply", face);
  const ReplayResult result =
      printed(plate(), R"("file": "slant.ply", "height": 0.6, "depth": 0.1, "bump": 0.04)", remeshing());
  for (const double x : {-0.35, 0.15}) {
    double sum = 0;
    int count = 0;
    for (const Vec3d& p : result.shape.positions()) {
      if (p.z < -0.29 || std::abs(p.x - x) > 0.1 || std::abs(p.y) > 0.15) continue;
      sum += p.z - 0.1 * (p.x - x);  // as deep as at x
      ++count;
    }
    ASSERT_GT(count, 4);
    EXPECT_NEAR(sum / count, x < 0 ? -0.075 : -0.025, 0.005);
  }
}

// Each letter is pressed against the normal there.
TEST_F(Print, AWordGoesRoundACylinder) {
  const Mesh cylinder = make_shape(ShapeKind::cylinder, 60'000);
  const std::string keys =
      R"("text": "DIVERGENCE", "point": [0.5, 0, 0], "up": [0, 0, 1], "height": 0.25, "depth": 0.025)";
  ReplayResult result;
  try {
    result = printed(cylinder, keys, remeshing());
  } catch (const InvalidInput& error) {
    GTEST_SKIP() << error.what();  // without FreeType or a font
  }
  Mesh after = result.shape.mesh();
  after.positions = result.shape.positions();
  EXPECT_EQ(crossings(after), 0U);
  EXPECT_LT(std::abs(volume_change(cylinder, after)), 1e-4);
  std::vector<double> deepest(12, 0.0);  // by angle
  for (const Vec3d& p : after.positions) {
    if (std::abs(p.z) > 0.12) continue;
    const double turn = std::atan2(p.y, p.x) / (2 * 3.14159265358979) + 0.5;
    double& sector = deepest[static_cast<std::size_t>(turn * 11.999)];
    sector = std::max(sector, 0.5 - std::hypot(p.x, p.y));
  }
  EXPECT_GE(std::count_if(deepest.begin(), deepest.end(), [](double d) { return std::abs(d - 0.025) < 0.004; }), 8);
  EXPECT_LT(*std::max_element(deepest.begin(), deepest.end()), 0.029);
}

TEST_F(Print, ResolvedGoesBackAndKeepsVolumesAtEveryPoint) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 10'000);
  ReplayOptions options;
  options.motion.precision = Precision::float64;
  options.motion.relative_tolerance = 1e-10;
  const ReplayResult there =
      printed(sphere, R"("file": "y.ply", "point": [0, 0, 1], "height": 0.8, "depth": 0.1)", options);
  Session resolved;
  resolved.strokes = there.resolved;
  Mesh moved = sphere;
  moved.positions = there.shape.positions();
  options.part.direction = Direction::backwards;
  const ReplayResult back = replay(moved, resolved, options);
  Flow flow;
  for (const SessionStroke& stroke : resolved.strokes) {
    for (const Segment& segment : flow_of(stroke.stroke).segments) flow.segments.push_back(segment);
  }
  std::vector<Vec3d> some;
  for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
    EXPECT_LT(norm(back.shape.positions()[i] - sphere.positions[i]), 1e-8);
    if (i % 50 == 0) some.push_back(sphere.positions[i]);
  }
  AdvectOptions accurate;
  accurate.tolerance = 1e-9;
  for (const Mat3d& j : jacobians(flow, some, accurate)) EXPECT_NEAR(determinant(j), 1, 1e-6);
}

TEST_F(Print, AnyNumberOfThreadsGivesTheSameBits) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 5'000);
  const std::string keys = R"("file": "y.ply", "point": [0.3, 0.2, 0.9], "height": 0.8, "depth": -0.1)";
  ReplayOptions options;
  options.motion.threads = 1;
  const ReplayResult one = printed(sphere, keys, options);
  options.motion.threads = 7;
  EXPECT_TRUE(printed(sphere, keys, options).shape.positions() == one.shape.positions());
}

// On an edge and at a corner several triangles are the nearest one. The bound is that of a push at the plate's edge,
// which rounding takes in or leaves out.
TEST_F(Print, TheOrderOfTrianglesDoesNotMatter) {
  const Mesh before = plate();
  std::vector<Triangle> triangles = triangulate(before);
  for (const std::string point : {"[1, 0.6, 0]", "[0.2, 0.6, 0]", "[1.1, 0.1, 0.2]"}) {
    const std::string keys =
        R"("file": "bar.pgm", "height": 0.6, "depth": 0.03, "up": [0.2, 0.3, 1], "point": )" + point;
    const ReplayResult first = printed(before, keys);
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
      std::shuffle(triangles.begin(), triangles.end(), std::mt19937(seed));
      Mesh shuffled;
      shuffled.positions = before.positions;
      for (const Triangle& t : triangles) shuffled.add_face(t);
      const ReplayResult other = printed(shuffled, keys);
      for (std::size_t i = 0; i < before.positions.size(); ++i) {
        EXPECT_LT(norm(other.shape.positions()[i] - first.shape.positions()[i]), 1e-5) << point << " " << i;
      }
    }
  }
}

TEST_F(Print, StrengthScalesTheDepth) {
  const Mesh before = plate();
  for (const double strength : {0.5, 1.5}) {
    const ReplayResult result = printed(before, bar_ + fmt::format("0.05, \"strength\": {}", strength), remeshing());
    Mesh after = result.shape.mesh();
    after.positions = result.shape.positions();
    EXPECT_LT(std::abs(floor_of_bar(after, 0.05 * strength, 0.045).off), 0.004) << strength;
  }
}

TEST_F(Print, AMirrorMakesAnImageAndNoDoubleDepth) {
  const Mesh before = plate();
  for (const char* const point : {"[0, 0, 0]", "[0.15, 0, 0]"}) {
    const ReplayResult result = printed(
        before,
        fmt::format(R"("file": "bar.pgm", "point": {}, "height": 0.6, "bump": 0.04, "depth": 0.05, "mirror": "x")",
                    point),
        remeshing());
    Mesh after = result.shape.mesh();
    after.positions = result.shape.positions();
    const Floor floor = floor_of_bar(after, 0.05, 0.045);
    EXPECT_LT(std::abs(floor.off), 0.004) << point;
    EXPECT_LT(floor.rough, 0.006) << point;
  }
}

TEST_F(Print, AMaskHoldsItsPart) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 5'000);
  const Session masked = parse_session(
      "{\"knead\": 1}\n"
      R"({"mask": {"points": [[0.3, 0, 0.95], [0.2, 0.1, 0.97], [0.2, -0.1, 0.97]], "width": 0.1}})"
      "\n"
      R"({"tool": "print", "file": "y.ply", "point": [0, 0, 1], "height": 0.8, "depth": 0.1})"
      "\n",
      (folder_ / "s.knead").string());
  const std::vector<Vec3d> after = replay(sphere, masked, {}).shape.positions();
  std::size_t held = 0;
  double deepest = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    deepest = std::max(deepest, 1 - norm(after[i]));
    if (norm(sphere.positions[i] - Vec3d{0.3, 0, 0.95}) > 0.02) continue;
    EXPECT_EQ(after[i], sphere.positions[i]);
    ++held;
  }
  EXPECT_GT(held, 0U);
  EXPECT_GT(deepest, 0.08);
}

// The image of the stroke does to the image of the shape what the stroke does to the shape.
TEST_F(Print, ImagesOfTheStrokeMoveImagesOfTheShape) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 5'000);
  Stroke stroke = session(R"("file": "y.ply", "point": [0.3, 0.2, 0.9], "up": [1, 2, 0], "height": 0.8, "depth": 0.1)")
                      .strokes.front()
                      .stroke;
  const ReplayResult plain =
      replay(sphere,
             session(R"("file": "y.ply", "point": [0.3, 0.2, 0.9], "up": [1, 2, 0], "height": 0.8, "depth": 0.1)"), {});
  Mesh image = sphere;
  for (Vec3d& p : image.positions) p.x = -p.x;
  Mesh flipped;
  flipped.positions = image.positions;
  for (std::size_t f = 0; f < image.face_count(); ++f) {
    const auto face = image.face(f);
    flipped.add_face(Triangle{face[0], face[2], face[1]});
  }
  Session of_image;
  of_image.name = (folder_ / "s.knead").string();
  of_image.strokes = {SessionStroke{mirrored(stroke, 0)}};
  const ReplayResult seen = replay(flipped, of_image, {});
  for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
    const Vec3d& p = plain.shape.positions()[i];
    EXPECT_LT(norm(seen.shape.positions()[i] - Vec3d{-p.x, p.y, p.z}), 1e-3);
  }
}

TEST_F(Print, SaysWhatIsWrong) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 1'000);
  const std::string place = R"("point": [0, 0, 1], "height": 0.5, "depth": 0.1)";
  const auto expect = [&](const Mesh& mesh, const std::string& keys, const std::string& message) {
    const std::string got = [&]() -> std::string {
      try {
        return error_of(mesh, keys);
      } catch (const std::exception& error) {
        return std::string("another exception: ") + error.what();
      }
    }();
    EXPECT_NE(got.find(message), std::string::npos) << keys << ": " << got;
  };
  write_picture("black.pgm", [](int, int) { return 0; });
  std::ofstream(folder_ / "no.png") << "nothing";
  std::ofstream(folder_ / "no.ttf") << "nothing";
  expect(sphere, R"("file": "black.pgm", )" + place, "there is nothing in it to print");
  expect(sphere, R"("file": "no.png", )" + place, "is no picture that can be read");
  expect(sphere, R"("file": "missing.pgm", )" + place, "\"file\": ");
  expect(sphere, R"("file": "missing.ply", )" + place, "\"file\": ");
  expect(sphere, R"("file": "bar.pgm", "point": [0, 0, 1], "up": [0, 0, 1], "height": 0.5, "depth": 0.1)",
         "\"up\" must");
  expect(sphere, R"("file": "bar.pgm", "bump": 1e-4, )" + place, "\"bump\": 0.0001 is too fine");
  expect(sphere, R"("file": "bar.pgm", "bump": 1e-12, )" + place, "is too fine");
  expect(sphere, R"("file": "bar.pgm", "bump": 0.02, "point": [0, 0, 1], "height": 0.5, "depth": 4)",
         "\"depth\" must be");
  expect(sphere, R"("file": "bar.pgm", "bump": 0.1, "direction": [0, 0, 1], )" + place,
         "no surface is under the pattern");
  Mesh cloud;
  cloud.positions = sphere.positions;
  expect(cloud, R"("file": "bar.pgm", )" + place, "a cloud has none");
  for (const auto& [keys, message] : {std::pair(R"("text": "a", "file": "bar.pgm", )", "one of them"),
                                      {"", "one of them"},
                                      {R"("font": "x", "file": "bar.pgm", )", "\"font\" needs \"text\""},
                                      {R"("file": "a.png", "bump": 0.2, "outer": 0.1, )", "\"outer\" must"}}) {
    try {
      session(keys + place);
      ADD_FAILURE() << keys;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

// The bar of bar.pgm is 80 by 20 pixels, the picture 60 high.
TEST_F(Print, TheOutlineGoesRoundThePattern) {
  PrintStroke stroke;
  stroke.file = "bar.pgm";
  stroke.height = stroke.depth = 1;
  double length = 0;
  for (const auto& [from, to] : print_outline(stroke, folder_)) {
    length += std::hypot(to[0] - from[0], to[1] - from[1]);
    for (const auto& [x, y] : {from, to}) {
      EXPECT_NEAR(std::max(std::abs(x) - 40.0 / 60, std::abs(y) - 10.0 / 60), 0, 0.025) << x << ", " << y;
    }
  }
  EXPECT_NEAR(length, 200.0 / 60, 0.15);
}

TEST_F(Print, AFontIsFoundByItsNameAsByItsFile) {
  PrintStroke stroke;
  stroke.height = stroke.depth = 1;
  stroke.text = "Rag";
  for (const auto& [name, file] : font_files()) {
    try {
      stroke.font = name;
      const std::vector<PlaneLine> by_name = print_outline(stroke, {});
      stroke.font = file.string();
      EXPECT_EQ(print_outline(stroke, {}), by_name) << name;
      EXPECT_GT(by_name.size(), 20U);
      return;
    } catch (const InvalidInput&) {
      continue;  // a font of symbols
    }
  }
  GTEST_SKIP() << "no font with letters in the usual folders; install one, such as fonts-dejavu-core";
}

TEST_F(Print, SaysWhereTextCannotBeSet) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 1'000);
  const std::string place = R"("point": [0, 0, 1], "height": 0.3, "depth": 0.02)";
  if (error_of(sphere, "\"text\": \"A\", " + place).find("FreeType") != std::string::npos) {
    GTEST_SKIP() << "the build has no FreeType";
  }
  std::ofstream(folder_ / "no.ttf") << "nothing";
  EXPECT_NE(error_of(sphere, R"("text": "A", "font": "no such font", )" + place).find("\"font\": there is no file"),
            std::string::npos);
  EXPECT_NE(error_of(sphere, R"("text": "A", "font": "no.ttf", )" + place).find("no font with outlines"),
            std::string::npos);
  if (error_of(sphere, "\"text\": \"A\", " + place).find("no usual font") != std::string::npos) {
    GTEST_SKIP() << "the computer has no usual font";
  }
  EXPECT_NE(error_of(sphere, R"("text": "\uE000", )" + place).find("lacks the character U+E000"), std::string::npos);
  EXPECT_NE(error_of(sphere, R"("text": "A\nB", )" + place).find("one line"), std::string::npos);
  EXPECT_NE(error_of(sphere, R"("text": "  ", )" + place).find("nothing in it to print"), std::string::npos);
}

TEST_F(Print, SaysWhereItCannotBeSeen) {
  const auto has = [](const ReplayResult& result, const std::string& text) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(has(printed(plate(), bar_ + "0.05"), "the edges under the print are longer"));
  EXPECT_TRUE(has(printed(plate(), R"("file": "bar.pgm", "height": 0.6, "bump": 0.2, "depth": 0.05)", remeshing()),
                  "the thinnest strokes are "));
  EXPECT_TRUE(
      has(printed(plate(), R"("file": "bar.pgm", "point": [0.9, 0, 0], "height": 0.6, "depth": 0.05)", remeshing()),
          "lies beside the surface"));
}

}  // namespace
}  // namespace knead::print_test
