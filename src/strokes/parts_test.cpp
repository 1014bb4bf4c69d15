// Connected parts of points and curves, against a comparison of every pair.
#include "strokes/connected_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

namespace knead::detail::parts_test {
namespace {

using Numbers = std::vector<std::uint32_t>;

// Parts by comparing every pair, as sorted lists of points, to check against.
std::vector<Numbers> parts_by_pairs(const std::vector<Vec3d>& points, double reach) {
  Numbers part(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) part[i] = i;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (norm2(points[i] - points[j]) >= reach * reach || part[i] == part[j]) continue;
      const auto [low, high] = std::minmax({part[i], part[j]});
      std::replace(part.begin(), part.end(), high, low);
    }
  }
  std::vector<Numbers> result;
  for (std::uint32_t first = 0; first < points.size(); ++first) {
    if (part[first] != first) continue;
    result.emplace_back();
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (part[i] == first) result.back().push_back(i);
    }
  }
  return result;
}

TEST(Parts, OfNothingAreNone) { EXPECT_TRUE(connected_parts({}, {}, 1).empty()); }

TEST(Parts, AreTwoForTwoClusters) {
  const std::vector<Vec3d> points{{0, 0, 0}, {5, 0, 0}, {0.5, 0, 0}, {5.5, 0, 0}};
  const std::vector<Part> parts = connected_parts(points, {}, 1);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].points, (Numbers{0, 2}));
  EXPECT_EQ(parts[1].points, (Numbers{1, 3}));
}

TEST(Parts, AreOneForAChainAndNoneAtTheReachItself) {
  std::vector<Vec3d> points;
  for (int i = 0; i < 100; ++i) points.push_back({static_cast<double>(i), 0, 0});
  EXPECT_EQ(connected_parts(points, {}, 1.001).size(), 1u);
  EXPECT_EQ(connected_parts(points, {}, 1).size(), 100u);
}

TEST(Parts, TakeACurveAsFarAsItsNearestPoint) {
  const std::vector<std::vector<Vec3d>> curves{{{-10, 0, 0}, {10, 0, 0}, {10, 9, 0}}, {{0, 5, 3}, {0, 5, 9}}};
  const std::vector<Vec3d> points{{3, 0.4, 0}, {-20, 0, 0}, {9.8, 5, 0}};
  const std::vector<Part> parts = connected_parts(points, curves, 0.5);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].points, (Numbers{0, 2}));
  EXPECT_EQ(parts[0].curves, (Numbers{0}));
  EXPECT_EQ(parts[1].points, (Numbers{1}));
  EXPECT_EQ(parts[2].curves, (Numbers{1}));
}

TEST(Parts, JoinCurvesThatCrossFarFromTheirEnds) {
  const std::vector<std::vector<Vec3d>> curves{{{-10, 0, 0}, {10, 0, 0}}, {{0, -10, 0.3}, {0, 10, 0.3}}};
  EXPECT_EQ(connected_parts({}, curves, 0.31).size(), 1u);
  EXPECT_EQ(connected_parts({}, curves, 0.29).size(), 2u);
}

TEST(Parts, AreThoseOfEveryPairCompared) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(0, 1);
  for (const double reach : {0.02, 0.05, 0.08, 0.3}) {
    std::vector<Vec3d> points;
    for (int i = 0; i < 600; ++i) points.push_back({place(random), place(random), 0.1 * place(random)});
    const std::vector<Numbers> expected = parts_by_pairs(points, reach);
    const std::vector<Part> parts = connected_parts(points, {}, reach);
    ASSERT_EQ(parts.size(), expected.size()) << "reach " << reach;
    for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(parts[i].points, expected[i]);
  }
}

// It takes some 20 ms; the bound leaves room for sanitizers and busy machines.
TEST(Parts, OfManyPointsAreFoundQuickly) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<Vec3d> points;
  for (int i = 0; i < 20000; ++i) points.push_back({place(random), place(random), 0});
  for (const double reach : {0.001, 0.02, 10.0}) {
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t count = connected_parts(points, {}, reach).size();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(seconds.count(), 2.0) << count << " parts at reach " << reach;
  }
}

TEST(SegmentDistance, IsThatOfDenseSamples) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> place(-1, 1);
  const auto point = [&] { return Vec3d{place(random), place(random), place(random)}; };
  constexpr int kSamples = 100;
  for (int round = 0; round < 50; ++round) {
    const Vec3d a0 = point(), a1 = round % 5 == 0 ? a0 : point(), b0 = point();
    const Vec3d b1 = round % 7 == 0 ? b0 + (a1 - a0) : point();  // parallel
    double least = 1e9;
    for (int i = 0; i <= kSamples; ++i) {
      for (int j = 0; j <= kSamples; ++j) {
        const double s = static_cast<double>(i) / kSamples, t = static_cast<double>(j) / kSamples;
        least = std::min(least, norm(a0 + (a1 - a0) * s - b0 - (b1 - b0) * t));
      }
    }
    const double distance = std::sqrt(squared_segment_distance(a0, a1, b0, b1));
    EXPECT_LE(distance, least + 1e-12);
    EXPECT_GE(distance, least - 4.0 / kSamples);  // the samples' spacing
  }
}

}  // namespace
}  // namespace knead::detail::parts_test
