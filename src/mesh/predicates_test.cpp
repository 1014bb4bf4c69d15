// Orientation tests are exact, also where rounding hides the sign.
#include "mesh/predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace knead::predicates_test {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Points = std::array<Vec3d, 4>;

struct ExactPoint {
  explicit ExactPoint(const Vec3d& p) : x(p.x), y(p.y), z(p.z) {}
  ExactPoint(Rational x_, Rational y_, Rational z_) : x(std::move(x_)), y(std::move(y_)), z(std::move(z_)) {}
  Rational x, y, z;
};

ExactPoint operator-(const ExactPoint& a, const ExactPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

ExactPoint cross(const ExactPoint& a, const ExactPoint& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

ExactPoint exact_normal(const Points& p) {
  const ExactPoint a(p[0]);
  return cross(ExactPoint(p[1]) - a, ExactPoint(p[2]) - a);
}

int exact_orient3d(const Points& p) {
  const ExactPoint n = exact_normal(p);
  const ExactPoint d = ExactPoint(p[3]) - ExactPoint(p[0]);
  return Rational(n.x * d.x + n.y * d.y + n.z * d.z).sign();
}

// Difficult points: on a plane or a line of a small grid, some coordinates a few units in the last
// place away, all of them times `scale`.
class HardPoints {
 public:
  explicit HardPoints(unsigned seed) : random_(seed) {}

  Points next(double scale) {
    const Vec3d u = grid_point();
    const Vec3d v = pick(3) == 0 ? u : grid_point();
    const Vec3d origin = grid_point() * 0.1;
    Points points;
    for (Vec3d& p : points) {
      p = origin + u * (0.1 * pick(7)) + v * (0.3 * pick(7));
      for (std::size_t k = 0; k < 3; ++k) p[k] = near(p[k]) * scale;
    }
    return points;
  }

 private:
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  double grid() { return pick(9) - 4; }
  Vec3d grid_point() { return {grid(), grid(), grid()}; }
  double near(double x) {
    for (int i = pick(4); i > 0; --i) x = std::nextafter(x, pick(2) == 0 ? -1e9 : 1e9);
    return std::abs(x) < 1e-9 ? 0 : x;
  }

  std::mt19937 random_;
};

// The ends of the stated range: the coordinates above are between 1e-9 and 20.
constexpr std::array kScales{1.0, 0x1p-218, 0x1p245};

// How often each sign occurred: a test without one of them shows little.
struct Tally {
  std::array<int, 3> counts{};
  void add(int sign) { ++counts[static_cast<std::size_t>(sign + 1)]; }
  void expect_all() const {
    for (const int count : counts) EXPECT_GT(count, 400);
  }
};

TEST(Predicates, Orient3dIsThatOfRationalNumbers) {
  for (const double scale : kScales) {
    HardPoints points(1);
    Tally tally;
    for (int i = 0; i < 20000; ++i) {
      const Points p = points.next(scale);
      const int sign = orient3d(p[0], p[1], p[2], p[3]);
      ASSERT_EQ(sign, exact_orient3d(p)) << "scale " << scale << ", points " << i;
      tally.add(sign);
    }
    tally.expect_all();
  }
}

TEST(Predicates, Orient2dIsThatOfRationalNumbers) {
  for (const double scale : kScales) {
    HardPoints points(2);
    Tally tally;
    for (int i = 0; i < 20000; ++i) {
      const Points p = points.next(scale);
      const ExactPoint normal = exact_normal(p);
      ASSERT_EQ(orient2d(p[0], p[1], p[2], 0), normal.x.sign()) << "scale " << scale << ", points " << i;
      ASSERT_EQ(orient2d(p[0], p[1], p[2], 1), normal.y.sign()) << "scale " << scale << ", points " << i;
      ASSERT_EQ(orient2d(p[0], p[1], p[2], 2), normal.z.sign()) << "scale " << scale << ", points " << i;
      tally.add(normal.z.sign());
    }
    tally.expect_all();
  }
}

TEST(Predicates, AnExchangeOfTwoPointsTurnsTheSign) {
  HardPoints points(3);
  for (int n = 0; n < 5000; ++n) {
    const Points p = points.next(1);
    const int sign = orient3d(p[0], p[1], p[2], p[3]);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        Points q = p;
        std::swap(q[i], q[j]);
        ASSERT_EQ(orient3d(q[0], q[1], q[2], q[3]), -sign);
        if (j == 3) continue;
        ASSERT_EQ(orient2d(q[0], q[1], q[2], 1), -orient2d(p[0], p[1], p[2], 1));
      }
    }
  }
}

// Exact numbers have room for finite products only: more terms were written beyond their end.
TEST(Predicates, NumbersBeyondAllProductsAreNotComputedExactly) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, kInfinity, 1e300}) {
    const Points p{Vec3d{bad, 1, 0.1}, Vec3d{0.3, bad, 7}, Vec3d{0.7, 0.2, bad}, Vec3d{bad, -bad, 0.3}};
    EXPECT_LE(std::abs(orient3d(p[0], p[1], p[2], p[3])), 1);
    for (const int axis : {0, 1, 2}) EXPECT_LE(std::abs(orient2d(p[0], p[1], p[2], axis)), 1);
  }
  EXPECT_EQ(orient2d({nan, nan, nan}, {1, 0, 0}, {0, 1, 0}, 2), 0);
  EXPECT_EQ(orient3d({nan, nan, nan}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 0);
}

TEST(Predicates, SidesAreNamedAsStated) {
  const Vec3d o{0, 0, 0};
  const Vec3d x{1, 0, 0};
  const Vec3d y{0, 1, 0};
  const Vec3d z{0, 0, 1};
  EXPECT_EQ(orient3d(o, x, y, z), 1);
  EXPECT_EQ(orient2d(o, x, y, 2), 1);
  EXPECT_EQ(orient2d(o, y, z, 0), 1);
  EXPECT_EQ(orient2d(o, z, x, 1), 1);
}

}  // namespace
}  // namespace knead::predicates_test
