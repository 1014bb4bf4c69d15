#include "knead/remesh/relax_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "knead/math/elementary.h"
#include "knead/math/parallel.h"
#include "knead/remesh/shape.h"

namespace knead::remesh_detail {

namespace {

constexpr std::size_t kGrain = 1024;
constexpr int kMostRounds = 8;       // of letting vertices rest
constexpr int kMostCorrections = 8;  // steps of Newton's method; two or three are enough
constexpr double kStraight = 1e-9;   // sine of the angle at a vertex of a straight crease
const double kLeastCosine = elementary::cos(std::numbers::pi / 4);   // of the angle by which a triangle turns
const double kSound = elementary::tan(15 * std::numbers::pi / 180);  // a quality that need not be kept
constexpr double kSameQuality = 1 - 1e-9;

// One iteration on its way.
class Iteration {
 public:
  Iteration(RelaxPatch& patch, double amount, double surface, int threads)
      : patch_(patch), threads_(threads), from_(patch.positions), center_(from_.front()) {
    areas(from_, area_);
    plan(amount, surface);
  }

  void run() {
    const double volume = volume_of(from_);
    rests_.assign(patch_.moving(), false);
    for (int round = 0; round < kMostRounds; ++round) {
      for (std::size_t v = 0; v < patch_.moving(); ++v) {
        patch_.positions[v] = rests_[v] ? from_[v] : from_[v] + move_[v];
      }
      if (restore(volume) && !let_rest()) return;
    }
    patch_.positions = from_;
  }

 private:
  void areas(std::span<const Vec3d> x, std::vector<Vec3d>& result) const {
    result.resize(patch_.triangles.size());
    parallel_for(result.size(), kGrain, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const auto [a, b, c] = patch_.triangles[t];
        result[t] = cross(x[b] - x[a], x[c] - x[a]);
      }
    });
  }

  Vec3d star(std::size_t v, const std::vector<Vec3d>& area) const {
    Vec3d sum{};
    for (std::uint32_t i = patch_.begin[v]; i < patch_.begin[v + 1]; ++i) sum += area[patch_.corners[i] / 3];
    return sum;
  }

  // Finds how each vertex wants to move, and the direction in which it gives the volume back.
  void plan(double amount, double surface) {
    move_.resize(patch_.moving());
    along_.resize(patch_.moving());
    parallel_for(patch_.moving(), kGrain, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (patch_.crease[v][0] != kNone) {
          move_[v] = along_crease(v) * (amount * patch_.weight[v]);
          continue;
        }
        const Vec3d sum = star(v, area_);
        if (!(norm2(sum) > 0)) continue;
        const Vec3d normal = normalized(sum);
        const Vec3d d = to_mean(v);
        const double across = dot(normal, d);
        move_[v] = (d + normal * ((surface - 1) * across)) * (amount * patch_.weight[v]);
        along_[v] = normal * patch_.weight[v];
      }
    });
  }

  // The neighbours of a vertex in a closed fan are the next corners of its triangles.
  Vec3d to_mean(std::size_t v) const {
    Vec3d sum{};
    for (std::uint32_t i = patch_.begin[v]; i < patch_.begin[v + 1]; ++i) {
      const std::uint32_t corner = patch_.corners[i];
      sum += from_[patch_.triangles[corner / 3][(corner + 1) % 3]] - from_[v];
    }
    return sum / static_cast<double>(patch_.begin[v + 1] - patch_.begin[v]);
  }

  Vec3d along_crease(std::size_t v) const {
    const Vec3d a = from_[patch_.crease[v][0]] - from_[v];
    const Vec3d b = from_[patch_.crease[v][1]] - from_[v];
    const bool is_straight = dot(a, b) < 0 && norm(cross(a, b)) <= kStraight * norm(a) * norm(b);
    return is_straight ? (a + b) * 0.5 : Vec3d{};
  }

  // Six times the volume between the triangles and the centre.
  double volume_of(std::span<const Vec3d> x) const {
    double sum = 0;
    for (const auto& [a, b, c] : patch_.triangles) sum += dot(x[a] - center_, cross(x[b] - center_, x[c] - center_));
    return sum;
  }

  // Moves the vertices that do not rest along their normals until the volume is right. Returns false if that fails.
  bool restore(double volume) {
    std::vector<Vec3d>& x = patch_.positions;
    double missing = volume - volume_of(x);
    for (int i = 0; i < kMostCorrections && missing != 0; ++i) {
      areas(x, new_area_);
      double growth = 0;
      for (std::size_t v = 0; v < patch_.moving(); ++v) {
        if (!rests_[v]) growth += dot(star(v, new_area_), along_[v]);
      }
      if (!(growth > 0)) break;
      const std::vector<Vec3d> before = x;
      for (std::size_t v = 0; v < patch_.moving(); ++v) {
        if (!rests_[v]) x[v] += along_[v] * (missing / growth);
      }
      const double still = volume - volume_of(x);
      if (std::abs(still) >= std::abs(missing)) {
        x = before;
        break;
      }
      missing = still;
    }
    // Of the rounding of the sum; far below the volume of any triangle of a patch that can be seen.
    double size = 0;
    for (std::size_t t = 0; t < area_.size(); ++t) size += norm(area_[t]) * norm(x[patch_.triangles[t][0]] - center_);
    return std::abs(missing) <= 1e-12 * size;
  }

  // Lets the vertices of triangles that turn or shrink too much rest. Returns true if there are any.
  bool let_rest() {
    const std::vector<Vec3d>& x = patch_.positions;
    areas(x, new_area_);
    std::vector<char> is_bad(patch_.triangles.size());
    parallel_for(is_bad.size(), kGrain, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) is_bad[t] = turns_or_shrinks(t) ? 1 : 0;
    });
    bool any = false;
    for (std::size_t t = 0; t < is_bad.size(); ++t) {
      if (is_bad[t] == 0) continue;
      for (const std::uint32_t v : patch_.triangles[t]) {
        if (v >= patch_.moving() || rests_[v]) continue;
        rests_[v] = true;
        any = true;
      }
    }
    return any;
  }

  bool turns_or_shrinks(std::size_t t) const {
    const auto [a, b, c] = patch_.triangles[t];
    const std::vector<Vec3d>& x = patch_.positions;
    if (x[a] == from_[a] && x[b] == from_[b] && x[c] == from_[c]) return false;
    const double was = quality(from_[a], from_[b], from_[c]);
    if (quality(x[a], x[b], x[c]) < std::min(was, kSound) * kSameQuality) return true;
    if (was >= kThin) return dot(area_[t], new_area_[t]) < kLeastCosine * norm(area_[t]) * norm(new_area_[t]);
    return std::any_of(patch_.triangles[t].begin(), patch_.triangles[t].end(),
                       [&](std::uint32_t v) { return v < patch_.moving() && dot(star(v, area_), new_area_[t]) < 0; });
  }

  RelaxPatch& patch_;
  int threads_;
  std::vector<Vec3d> from_;
  Vec3d center_;
  std::vector<Vec3d> area_;  // twice the area vectors at the beginning
  std::vector<Vec3d> new_area_;
  std::vector<Vec3d> move_;
  std::vector<Vec3d> along_;
  std::vector<bool> rests_;
};

}  // namespace

void relax_once(RelaxPatch& patch, double amount, double surface, int threads) {
  if (patch.moving() > 0) Iteration(patch, amount, surface, threads).run();
}

}  // namespace knead::remesh_detail
