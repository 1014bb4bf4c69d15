// The unit of length does not matter: a shape and its session scaled by a power of two give the scaled bits.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "surveys/random_strokes.h"

namespace knead::scale_test {
namespace {

constexpr int kStrokes = 2;

Mesh scaled(Mesh mesh, double scale) {
  for (Vec3d& p : mesh.positions) p = p * scale;
  return mesh;
}

class EveryUnit : public testing::TestWithParam<const Tool*> {
 protected:
  // A random stroke on a sphere of this size, its lengths in the same parts of the sphere for every size; then a pull
  // across it. What is refused has no positions.
  std::vector<Vec3d> result(double scale, unsigned seed, bool remesh) const {
    const Mesh base = make_shape(ShapeKind::sphere, 642);
    const Mesh mesh = scaled(base, scale);
    std::mt19937_64 random(seed);
    Session session;
    session.name = (folder_ / "s.knead").string();
    const std::vector<Vec3d> normals = vertex_normals(base);
    session.strokes.push_back(
        {surveys::random_stroke(std::string(GetParam()->name), mesh, normals, "stamp.ply", random), 2});
    session.strokes.push_back(
        {ImplicitStroke{{Vec3d{0, 0, 0.75} * scale, Vec3d{0.25, 0, 1.25} * scale}, 0.25 * scale, 0.75 * scale}, 3});
    if (remesh) {
      for (SessionStroke& stroke : session.strokes) stroke.remesh = RemeshSettings{};
    }
    try {
      const ReplayResult replayed = replay(mesh, session);
      return replayed.status == AdvectStatus::done ? replayed.shape.positions() : std::vector<Vec3d>{};
    } catch (const InvalidInput&) {
      return {};
    }
  }

  void SetUp() override {
    std::filesystem::create_directories(folder_);
    write_mesh(folder_ / "stamp.ply", make_shape(ShapeKind::sphere, 162), {true, {}});
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("knead_scale_" + std::to_string(::getpid()));
};

TEST_P(EveryUnit, GivesTheSameShape) {
  int done = 0;
  for (unsigned seed = 1; seed <= kStrokes; ++seed) {
    for (const bool remesh : {false, true}) {
      const std::vector<Vec3d> expected = result(1, seed, remesh);
      done += expected.empty() ? 0 : 1;
      const double scale = seed % 2 == 0 ? 0x1p-20 : 0x1p20;
      const std::vector<Vec3d> found = result(scale, seed, remesh);
      ASSERT_EQ(found.size(), expected.size()) << seed << " " << remesh << " " << scale;
      std::size_t different = 0;
      for (std::size_t i = 0; i < found.size(); ++i) different += found[i] == expected[i] * scale ? 0 : 1;
      EXPECT_EQ(different, 0U) << seed << " " << remesh << " " << scale;
    }
  }
  EXPECT_GE(done, kStrokes) << "most strokes are refused";
}

INSTANTIATE_TEST_SUITE_P(Tools, EveryUnit, testing::ValuesIn(tools().begin(), tools().end()),
                         [](const auto& test) { return std::string(test.param->name); });

}  // namespace
}  // namespace knead::scale_test
