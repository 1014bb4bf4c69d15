// knead bend, twist and wrap: a coarse plate with a hole, as a CAD program writes it, becomes what a printer takes.
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"
#include "process.h"

namespace knead::command_test::makers_test {
namespace {

using Words = std::vector<std::string>;

// 120 x 20 x 4, with a hole of 20 x 8 through its middle; 32 triangles.
std::string plate() {
  std::string text;
  const auto add_ring = [&](double x0, double x1, double y0, double y1, double z) {
    for (const auto& [x, y] : {std::pair(x0, y0), std::pair(x1, y0), std::pair(x1, y1), std::pair(x0, y1)}) {
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    }
  };
  for (const double z : {0.0, 4.0}) {
    add_ring(0, 120, 0, 20, z);
    add_ring(50, 70, 6, 14, z);
  }
  const auto add_face = [&](std::array<int, 4> corners) {
    for (const std::size_t second : {1, 2}) {
      text += "f";
      for (const std::size_t corner : {std::size_t{0}, second, second + 1}) {
        text += " " + std::to_string(corners[corner] + 1);
      }
      text += "\n";
    }
  };
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    add_face({8 + i, 8 + j, 12 + j, 12 + i});
    add_face({i, 4 + i, 4 + j, j});
    add_face({i, j, 8 + j, 8 + i});
    add_face({4 + i, 12 + i, 12 + j, 4 + j});
  }
  return text;
}

class MakersTest : public CommandTest {
 protected:
  MakersTest() {
    write("plate.obj", plate());
    volume_ = measure(read_shape(path("plate.obj")).mesh).volume;
  }

  // Runs a command on the plate. The result is closed, and no two of its triangles cross.
  Mesh made(Words words, const std::string& output) const {
    words.insert(words.begin() + 1, {"plate.obj", "-o", output});
    knead_ok(words);
    knead_ok({"check", output, "-q", "--require", "closed,manifold,oriented,no-self-intersections,no-degenerate"});
    return read_shape(path(output)).mesh;
  }

  void expect_volume(const Mesh& mesh, double factor = 1, double error = 1e-5) const {
    EXPECT_NEAR(measure(mesh).volume / volume_, factor, error);
  }

  double volume_ = 0;
};

TEST_F(MakersTest, BendsTwistsAndWrapsKeepTheVolume) {
  EXPECT_NEAR(volume_, (120 * 20 - 20 * 8) * 4, 1e-9);
  for (const std::string extension : {"stl", "3mf"}) {
    expect_volume(made({"bend", "--angle", "90"}, "b90." + extension));
    expect_volume(made({"bend", "--angle", "270"}, "b270." + extension));
    expect_volume(made({"twist", "--angle", "180"}, "t180." + extension));
    expect_volume(made({"wrap", "--radius", "30"}, "w30." + extension));
  }
}

// The ends are nearer to each other than the plate is thick.
TEST_F(MakersTest, ARingNearlyCloses) {
  expect_volume(made({"bend", "--angle", "353"}, "ring.stl"));
  expect_error(knead({"bend", "plate.obj", "--angle", "380", "-o", "no.stl"}), 3, "the shape would meet itself");
}

TEST_F(MakersTest, ABendAlongAPathEndsThere) {
  write("path.csv", "x,y,z\n0,10,2\n50,10,2\n90,10,25\n100,40,50\n");
  const Mesh mesh = made({"bend", "--along", "path.csv", "--fit"}, "path.stl");
  expect_volume(mesh);
  double nearest = 1e9;
  for (const Vec3d& p : mesh.positions) nearest = std::min(nearest, norm(p - Vec3d{100, 40, 50}));
  EXPECT_LT(nearest, 11);
}

// Distances from the cylinder's axis are 30 below and 34 on top: the volume is that of an arc of a ring.
TEST_F(MakersTest, AWrapKeepsTheThicknessIfAsked) {
  const Mesh kept = made({"wrap", "--radius", "30", "--keep", "thickness"}, "kept.stl");
  expect_volume(kept, (34.0 * 34 - 30 * 30) / (2 * 30 * 4), 1e-4);
  const auto [least, greatest] = [&] {
    double low = 1e9;
    double high = 0;
    for (const Vec3d& p : kept.positions) {
      const double far = std::hypot(p.x - 60, p.z + 30);
      low = std::min(low, far);
      high = std::max(high, far);
    }
    return std::pair(low, high);
  }();
  EXPECT_NEAR(least, 30, 0.02);
  EXPECT_NEAR(greatest, 34, 0.02);
  const std::string line = knead_ok({"wrap", "plate.obj", "--radius", "30", "--keep", "thickness", "-o", "kept.stl"});
  EXPECT_NE(line.find("det J from 1"), std::string::npos) << line;
}

TEST_F(MakersTest, BecomesThickerByANumberThatIsPrinted) {
  expect_volume(made({"stretch", "--thicker", "2", "-q"}, "all.stl"));
  expect_volume(made({"stretch", "--thickness", "6", "--axis", "z", "--keep", "length", "-q"}, "top.stl"), 1.5);
  const Mesh taper = made({"taper", "--thickness", "10", "--axis", "y", "-q"}, "taper.stl");
  expect_volume(taper);
  double longest = 0;
  for (const Vec3d& p : taper.positions) longest = std::max(longest, p.x);
  Vec3d first{0, 0, 0};  // the greatest distances from the line, at the beginning and at the end
  Vec3d last{0, 0, 0};
  for (const Vec3d& p : taper.positions) {
    if (p.x < 1e-3) first = {0, std::max(first.y, std::abs(p.y - 10)), std::max(first.z, std::abs(p.z - 2))};
    if (p.x > longest - 1e-3) last = {0, std::max(last.y, std::abs(p.y - 10)), std::max(last.z, std::abs(p.z - 2))};
  }
  EXPECT_LE(norm(first - Vec3d{0, 10, 2}), 1e-3);
  EXPECT_LE(norm(last - Vec3d{0, 5, 2}), 1e-3);
  const std::string note = knead({"taper", "plate.obj", "--thickness", "10", "--axis", "y", "-o", "taper.stl"}).err;
  const std::size_t at = note.find("is 20 and becomes 10; the shape becomes ");
  ASSERT_NE(at, std::string::npos) << note;
  EXPECT_NEAR(std::stod(note.substr(at + 40)), longest - 120, 0.01);
  expect_error(knead({"stretch", "plate.obj", "--thicker", "-4", "-o", "no.stl"}), 3,
               "--thicker: where the shape is 4");
  expect_error(knead({"stretch", "plate.obj", "--thicker", "1", "--by", "2", "-o", "no.stl"}), 2, "give --by LENGTH");
  expect_error(knead({"taper", "plate.obj", "-o", "no.stl"}), 2, "give --thicker LENGTH");
}

// In the middle of the top is the hole; a bar of a picture goes beside it.
TEST_F(MakersTest, PrintsAPictureAndRaisesIt) {
  std::string picture = "P5\n40 20\n255\n";
  for (int i = 0; i < 800; ++i) picture += i / 40 >= 5 && i / 40 < 15 && i % 40 >= 5 && i % 40 < 35 ? '\xff' : '\0';
  write("bar.pgm", picture);
  const Words words{"print", "--file", "bar.pgm", "--at", "25,10,4", "--height", "12"};
  for (const double depth : {0.8, -0.8}) {
    Words own = words;
    own.insert(own.end(), {"--depth", std::to_string(depth)});
    const Mesh mesh = made(own, "printed.stl");
    expect_volume(mesh, 1, 1e-4);
    double farthest = 0;
    for (const Vec3d& p : mesh.positions) {
      if (std::hypot(p.x - 25, p.y - 10) < 2 && p.z > 2) farthest = std::max(farthest, std::abs(p.z - 4 + depth));
    }
    EXPECT_LT(farthest, 0.04);
  }
  expect_error(knead({"print", "plate.obj", "--height", "2", "--depth", "1", "-o", "no.stl"}), 2,
               "--text TEXT or --file");
  expect_error(knead({"print", "plate.obj", "--file", "bar.pgm", "--at", "1,2", "--height", "2", "--depth", "1", "-o",
                      "no.stl"}),
               2, "--at takes three numbers");
}

TEST_F(MakersTest, ErrorsNameTheOptionsThatWereTyped) {
  const std::string bent = knead({"bend", "plate.obj", "--angle", "700", "-o", "no.stl"}).err;
  EXPECT_NE(bent.find("--angle"), std::string::npos) << bent;
  EXPECT_EQ(bent.find("angle_deg"), std::string::npos) << bent;
  EXPECT_EQ(bent.find("--stroke"), std::string::npos) << bent;
  expect_error(knead({"print", "plate.obj", "--text", "A", "--font", "no such", "--height", "2", "--depth", "1", "-o",
                      "no.stl"}),
               3, "--font: there is no file");
}

// PyGeM's weights are multiples of the box's edges: the plate rises by 14 * 0.5 * 6 / 16 in its middle.
TEST_F(MakersTest, ReadsALatticeOfPygem) {
  std::string file = "[Box info]\nn control points x: 5\nn control points y: 2\nn control points z: 2\n";
  file += "box length x: 130\nbox length y: 30\nbox length z: 14\n";
  file += "box origin x: -5\nbox origin y: -5\nbox origin z: -5\n";
  file += "rotation angle x: 0\nrotation angle y: 0\nrotation angle z: 0\n[Parameters weights]\n";
  file += "parameter x: 0 0 0 0\nparameter y: 0 0 0 0\nparameter z: 2 0 0 0.5\n  2 0 1 0.5\n  2 1 0 0.5\n  2 1 1 0.5\n";
  write("box.prm", file);
  for (const std::string mode : {"spline", "volume", "rigid"}) {
    const Mesh mesh = made({"lattice", "--file", "box.prm", "--mode", mode, "-q"}, "moved.stl");
    expect_volume(mesh, 1, 1e-4);
    double top = 0;
    for (const Vec3d& p : mesh.positions) top = std::max(top, p.z - 4);
    EXPECT_NEAR(top, 14 * 0.5 * 0.375, mode == "spline" ? 0.01 : 0.3) << mode;
  }
  // The two layers of control points change their places.
  write("box.prm",
        file.substr(0, file.find("parameter z")) + "parameter z: 2 0 0 0.9\n  2 0 1 -0.9\n  2 1 0 0.9\n  2 1 1 -0.9\n");
  expect_error(knead({"lattice", "plate.obj", "--file", "box.prm", "-o", "no.stl", "-q"}), 4,
               "knead: --file: the shape came");
  expect_error(knead({"lattice", "plate.obj", "--file", "no.prm", "-o", "no.stl"}), 3, "--file: no.prm");
  write("box.prm", "n control points x: 5\n");
  expect_error(knead({"lattice", "plate.obj", "--file", "box.prm", "-o", "no.stl"}), 3, "are no parameters of PyGeM");
}

TEST_F(MakersTest, TheSessionDoesTheSame) {
  made({"bend", "--angle", "90", "--session", "bend.knead"}, "one.ply");
  knead_ok({"deform", "plate.obj", "bend.knead", "-q", "--max-chord", "1e-4", "-o", "two.ply"});
  EXPECT_EQ(read("one.ply"), read("two.ply"));
}

}  // namespace
}  // namespace knead::command_test::makers_test
