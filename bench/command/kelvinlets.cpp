// Regularised Kelvinlets: a grab brush, as a flow and as displacements.
#include "yardsticks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

// Compiled for what the machine has, as a program made for speed would be; the compiler finds the lanes. The choice is
// made before the thread sanitizer is ready; clang 19 leaves out functions that such copies call.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define KNEAD_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KNEAD_CLONES
#endif

namespace knead::bench {

namespace {

constexpr std::size_t kBlock = 256;

// Points beside each other, in float about the path's first point.
struct Block {
  std::array<float, kBlock> x{};
  std::array<float, kBlock> y{};
  std::array<float, kBlock> z{};
};

// A piece of the path about its first point.
struct Piece {
  Vec3f from;
  Vec3f way;
};

std::vector<Piece> pieces_of(const KelvinletBrush& brush) {
  std::vector<Piece> pieces;
  for (std::size_t i = 1; i < brush.path.size(); ++i) {
    pieces.push_back({Vec3f(brush.path[i - 1] - brush.path[0]), Vec3f(brush.path[i] - brush.path[i - 1])});
  }
  return pieces;
}

// k becomes the velocities at the points moved on by k h, with the tip at c.
KNEAD_CLONES void stage(const Block& __restrict points, float h, Vec3f c, Vec3f tip, float epsilon,
                        Block& __restrict k) {
  for (std::size_t i = 0; i < kBlock; ++i) {
    const Vec3f p = Vec3f{points.x[i], points.y[i], points.z[i]} + Vec3f{k.x[i], k.y[i], k.z[i]} * h;
    const Vec3f v = kelvinlet(p - c, tip, epsilon);
    k.x[i] = v.x;
    k.y[i] = v.y;
    k.z[i] = v.z;
  }
}

KNEAD_CLONES void add(Block& __restrict sum, const Block& __restrict k, float h) {
  for (std::size_t i = 0; i < kBlock; ++i) {
    sum.x[i] += k.x[i] * h;
    sum.y[i] += k.y[i] * h;
    sum.z[i] += k.z[i] * h;
  }
}

void rk4_step(Block& block, const Piece& piece, float epsilon, float t, float h) {
  const Block points = block;
  Block k;
  const auto take_stage = [&](float ahead, float weight) {
    stage(points, ahead, piece.from + piece.way * (t + ahead), piece.way, epsilon, k);
    add(block, k, weight);
  };
  take_stage(0, h / 6);
  take_stage(h / 2, h / 3);
  take_stage(h / 2, h / 3);
  take_stage(h, h / 6);
}

void displace(Block& block, const Piece& piece, float epsilon) {
  Block whole;
  stage(block, 0, piece.from, piece.way, epsilon, whole);
  add(block, whole, 1);
}

// Calls move(block, piece) for every piece of the path, a block of points after the other.
template <class Move>
void move_points(const KelvinletBrush& brush, std::span<Vec3d> points, const Move& move) {
  const std::vector<Piece> pieces = pieces_of(brush);
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    const std::span<Vec3d> some = points.subspan(begin, std::min(kBlock, points.size() - begin));
    Block block;
    for (std::size_t i = 0; i < some.size(); ++i) {
      const Vec3f p(some[i] - brush.path[0]);
      block.x[i] = p.x;
      block.y[i] = p.y;
      block.z[i] = p.z;
    }
    for (const Piece& piece : pieces) move(block, piece);
    for (std::size_t i = 0; i < some.size(); ++i) {
      some[i] = brush.path[0] + Vec3d(Vec3f{block.x[i], block.y[i], block.z[i]});
    }
  }
}

}  // namespace

void advect_kelvinlet(const KelvinletBrush& brush, std::span<Vec3d> points, int steps_per_piece) {
  const auto epsilon = static_cast<float>(brush.epsilon);
  const float h = 1 / static_cast<float>(steps_per_piece);
  move_points(brush, points, [&](Block& block, const Piece& piece) {
    for (int step = 0; step < steps_per_piece; ++step) {
      rk4_step(block, piece, epsilon, static_cast<float>(step) * h, h);
    }
  });
}

int sufficient_steps(const KelvinletBrush& brush) {
  double longest = 0;
  for (std::size_t i = 1; i < brush.path.size(); ++i) {
    longest = std::max(longest, norm(brush.path[i] - brush.path[i - 1]));
  }
  return std::max(1, static_cast<int>(std::ceil(longest / (0.7 * brush.epsilon))));
}

void displace_kelvinlet(const KelvinletBrush& brush, std::span<Vec3d> points) {
  const auto epsilon = static_cast<float>(brush.epsilon);
  move_points(brush, points, [&](Block& block, const Piece& piece) { displace(block, piece, epsilon); });
}

}  // namespace knead::bench
