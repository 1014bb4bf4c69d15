// Walls of meshes that solvers read: two dimensions, and cells of the second order.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::solver_walls_test {
namespace {

using Map = std::function<Vec3d(double, double, double)>;  // from the unit cube
using Node = std::array<int, 3>;                           // of a lattice

// A quarter of a pipe of the radii 0.25 and 1 about the z axis.
Vec3d in_pipe(double x, double y, double z) {
  const double angle = 1.5707963267948966 * y;
  const double radius = 0.25 + 0.75 * x;
  return {radius * std::cos(angle), radius * std::sin(angle), 2 * z};
}

// Gmsh's file of the cells of a block, of which a node is at each point of a lattice. Groups of faces: 1 has x = 1, 2
// has z = 0.
class GmshFile {
 public:
  // A cell goes over two steps of the lattice: hexahedra of 27 nodes, or squares of nine, which lie at z = 0.
  GmshFile(int cells, bool is_flat, Map map) : last_(2 * cells), map_(std::move(map)), is_flat_(is_flat) {
    for (int x = 0; x < last_; x += 2) {
      for (int y = 0; y < last_; y += 2) {
        if (is_flat) {
          element(10, 3, square({x, y, 0}, {2, 0, 0}, {0, 2, 0}));
          if (x == 0) element(8, 1, {{last_, y, 0}, {last_, y + 2, 0}, {last_, y + 1, 0}});
          continue;
        }
        element(10, 1, square({last_, x, y}, {0, 2, 0}, {0, 0, 2}));
        element(10, 2, square({x, y, 0}, {0, 2, 0}, {2, 0, 0}));
        for (int z = 0; z < last_; z += 2) element(12, 3, hexahedron({x, y, z}));
      }
    }
  }

  std::string text() const {
    const std::string dimension = is_flat_ ? "1" : "2";
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n" + dimension + " 1 \"outer\"\n" + dimension +
           " 2 \"bottom\"\n$EndPhysicalNames\n$Nodes\n" + std::to_string(numbers_.size()) + "\n" + nodes_ +
           "$EndNodes\n$Elements\n" + std::to_string(elements_) + "\n" + lines_ + "$EndElements\n";
  }

 private:
  static Node at(const Node& start, const Node& u, const Node& v, int i, int j) {
    return {start[0] + (i * u[0] + j * v[0]) / 2, start[1] + (i * u[1] + j * v[1]) / 2,
            start[2] + (i * u[2] + j * v[2]) / 2};
  }

  static std::vector<Node> square(const Node& start, const Node& u, const Node& v) {
    std::vector<Node> nodes;
    for (const auto& [i, j] : std::initializer_list<std::array<int, 2>>{
             {0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}, {1, 1}}) {
      nodes.push_back(at(start, u, v, i, j));
    }
    return nodes;
  }

  static std::vector<Node> hexahedron(const Node& start) {
    std::vector<Node> nodes;
    for (const Node& step : std::initializer_list<Node>{
             {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0},
             {0, 1, 0}, {0, 0, 1}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0}, {2, 2, 1}, {0, 2, 1}, {1, 0, 2}, {0, 1, 2},
             {2, 1, 2}, {1, 2, 2}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}, {1, 1, 1}}) {
      nodes.push_back({start[0] + step[0], start[1] + step[1], start[2] + step[2]});
    }
    return nodes;
  }

  int number(const Node& node) {
    const auto [found, is_new] = numbers_.try_emplace(node, static_cast<int>(numbers_.size()) + 1);
    if (is_new) {
      const Vec3d p = map_(1.0 * node[0] / last_, 1.0 * node[1] / last_, is_flat_ ? 0 : 1.0 * node[2] / last_);
      std::array<char, 128> line{};
      std::snprintf(line.data(), line.size(), "%d %.17g %.17g %.17g\n", found->second, p.x, p.y, p.z);
      nodes_ += line.data();
    }
    return found->second;
  }

  void element(int type, int group, const std::vector<Node>& nodes) {
    lines_ += std::to_string(++elements_) + " " + std::to_string(type) + " 2 " + std::to_string(group) + " 1";
    for (const Node& node : nodes) lines_ += " " + std::to_string(number(node));
    lines_ += "\n";
  }

  int last_;
  Map map_;
  bool is_flat_;
  std::map<Node, int> numbers_;
  std::string nodes_;
  std::string lines_;
  int elements_ = 0;
};

// SU2's file of a plane of triangles; the marker "outer" has x = 1.
std::string su2_file(int n, const Map& map) {
  std::string elements;
  std::string points;
  std::string marker;
  for (int i = 0; i < (n + 1) * (n + 1); ++i) {
    const int x = i % (n + 1);
    const int y = i / (n + 1);
    const Vec3d p = map(1.0 * x / n, 1.0 * y / n, 0);
    std::array<char, 128> line{};
    std::snprintf(line.data(), line.size(), "%.17g %.17g %d\n", p.x, p.y, i);
    points += line.data();
    if (y == n) continue;
    if (x == n) {
      marker += fmt::format("3 {} {}\n", i, i + n + 1);
    } else {
      elements += fmt::format("5 {0} {1} {3}\n5 {0} {3} {2}\n", i, i + 1, i + n + 1, i + n + 2);
    }
  }
  return "NDIME= 2\nNELEM= " + std::to_string(2 * n * n) + "\n" + elements +
         "NPOIN= " + std::to_string((n + 1) * (n + 1)) + "\n" + points +
         "NMARK= 1\nMARKER_TAG= outer\nMARKER_ELEMS= " + std::to_string(n) + "\n" + marker;
}

constexpr const char* kOuterSlides = R"({"patch": "outer", "slide": true})";
constexpr const char* kTurn =
    R"({"tool": "rotate", "center": [0.6, 0.6, 1], "axis": [0.2, 0.1, 1], "angle_deg": 12, "inner": 0.2, "outer": 0.9})";
constexpr const char* kPull =
    R"({"tool": "implicit", "path": [[0.8, 0.3, 0], [0.75, 0.4, 0]], "inner": 0.1, "outer": 0.5})";

struct Deformed {
  std::vector<Vec3d> before;
  std::vector<Vec3d> after;
  std::vector<Patch> patches;

  const Patch& outer() const {
    return *std::find_if(patches.begin(), patches.end(), [](const Patch& p) { return p.name == "outer"; });
  }
  double slid() const {
    double greatest = 0;
    for (const std::uint32_t i : outer().points) greatest = std::max(greatest, norm(after[i] - before[i]));
    return greatest;
  }
};

Deformed deformed(const std::string& text, const char* format, const std::string& walls, const char* stroke) {
  const std::string name = std::string("a.") + format;
  const ShapeFile shape = parse_shape(text, format, name);
  Deformed result{shape.mesh.positions, {}, read_patches(name, shape)};
  const auto cells = std::make_shared<const VolumeCells>(read_cells(name, shape));
  const Session session = on_walls(parse_session("{\"knead\": 1, \"walls\": [" + walls + "]}\n" + stroke + "\n", "a"),
                                   result.patches, shape.mesh.positions, {0, nullptr, cells});
  result.after = replay(shape.mesh, session, {}).shape.positions();
  return result;
}

void expect_on_cylinder(const Deformed& result) {
  for (const std::uint32_t i : result.outer().points) {
    EXPECT_NEAR(std::hypot(result.after[i].x, result.after[i].y), 1, 1e-12) << i;
  }
  EXPECT_GT(result.slid(), 0.03);
}

TEST(SolverWalls, NodesOfTheSecondOrderSlideAsCornersDo) {
  const std::string walls = std::string(kOuterSlides) + R"(, {"patch": "bottom", "slide": true})";
  const Deformed result = deformed(GmshFile(5, false, in_pipe).text(), "msh", walls, kTurn);
  EXPECT_EQ(result.outer().points.size(), 11U * 11U);
  expect_on_cylinder(result);
}

TEST(SolverWalls, OfTwoDimensionsSlideOnACircle) {
  for (const auto& [text, format, points] :
       {std::tuple{GmshFile(6, true, in_pipe).text(), "msh", 13U}, std::tuple{su2_file(12, in_pipe), "su2", 13U}}) {
    SCOPED_TRACE(format);
    const Deformed result = deformed(text, format, kOuterSlides, kPull);
    EXPECT_EQ(result.outer().points.size(), points);
    expect_on_cylinder(result);
    for (const Vec3d& p : result.after) EXPECT_EQ(p.z, 0);
  }
}

// The side is no circle: its points stay on its edges as they were, and its ends where they are.
TEST(SolverWalls, OfTwoDimensionsSlideOnACurve) {
  const auto wavy = [](double x, double y, double) { return Vec3d{x + 0.1 * x * std::sin(5 * y), y, 0}; };
  for (const auto& [text, format] :
       {std::tuple{GmshFile(6, true, wavy).text(), "msh"}, std::tuple{su2_file(12, wavy), "su2"}}) {
    SCOPED_TRACE(format);
    const Deformed result = deformed(text, format, kOuterSlides, kPull);
    const SurfaceTree side(result.outer().faces, result.before);
    for (const std::uint32_t i : result.outer().points) {
      EXPECT_LT(side.closest(result.after[i])->distance, 1e-12) << i;
      const Vec3d& p = result.before[i];
      if (p.y == 0 || p.y == 1) {
        EXPECT_EQ(result.after[i], p);
      }
    }
    EXPECT_GT(result.slid(), 0.02);
    for (const Vec3d& p : result.after) EXPECT_EQ(p.z, 0);
  }
}

// A straight side stays in its line, however it lies.
TEST(SolverWalls, OfTwoDimensionsSlideOnALine) {
  const auto slanted = [](double x, double y, double) { return Vec3d{x + 0.3 * y, y, 0}; };
  const Deformed result = deformed(su2_file(12, slanted), "su2", kOuterSlides, kPull);
  for (const std::uint32_t i : result.outer().points) {
    EXPECT_NEAR(result.after[i].x - 0.3 * result.after[i].y, 1, 1e-12) << i;
  }
  EXPECT_GT(result.slid(), 0.02);
}

// One point is taken beyond its neighbours, between two of them.
constexpr const char* kTearOut =
    R"({"tool": "implicit", "path": [[0.5, 0.5, 0], [0.8, 0.58, 0]], "inner": 0.02, "outer": 0.05})";
constexpr const char* kOuterHeld = R"({"patch": "outer", "hold": true})";

std::string refusal(const std::string& text, const char* format, const std::string& walls, const char* stroke) {
  try {
    deformed(text, format, walls, stroke);
  } catch (const QualityLimit& error) {
    return error.what();
  }
  return "nothing";
}

TEST(SolverWalls, InvertedCellsOfTwoDimensionsAreRefused) {
  const auto square = [](double x, double y, double) { return Vec3d{x, y, 0}; };
  for (const auto& [text, format] :
       {std::tuple{su2_file(6, square), "su2"}, std::tuple{GmshFile(4, true, square).text(), "msh"}}) {
    SCOPED_TRACE(format);
    const std::string what = refusal(text, format, kOuterHeld, kTearOut);
    EXPECT_NE(what.find("would be inverted; deform less"), std::string::npos) << what;
    EXPECT_EQ(refusal(text, format, kOuterHeld, kPull), "nothing");
  }
}

// Files may have their cells in either direction, or some in each.
TEST(SolverWalls, CellsOfTwoDimensionsMayLookToBothSides) {
  const auto square = [](double x, double y, double) { return Vec3d{x, y, 0}; };
  std::string text = su2_file(6, square);
  const std::size_t first = text.find("5 0 1 8");
  ASSERT_NE(first, std::string::npos);
  text.replace(first, 7, "5 1 0 8");
  EXPECT_EQ(refusal(text, "su2", kOuterHeld, kPull), "nothing");
  EXPECT_NE(refusal(text, "su2", kOuterHeld, kTearOut), "nothing");
}

}  // namespace
}  // namespace knead::solver_walls_test
