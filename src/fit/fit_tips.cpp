// Finds the ends of limbs of two surfaces, and the assignment of tips whose distances and poses agree best.
#include "fit/fit_tips.h"

#include <algorithm>
#include <cmath>

namespace knead::detail {

namespace {

constexpr std::size_t kMaxTips = 8;
constexpr std::size_t kMinTips = 3;
constexpr double kTipRadiusFraction = 0.2;    // of the greatest distance along the surface: a tip is the farthest there
constexpr double kMinRemoteness = 1.15;       // a tip's mean distance from all nodes, relative to the median node's
constexpr double kMaxDistanceMismatch = 0.5;  // relative difference of the distances between matched tips
constexpr std::size_t kMaxPosedSets = 12;     // sets of pairs whose poses are computed
constexpr std::size_t kMaxSets = 20'000;
constexpr double kMaxSquareRatio = 0.85;  // of the mean square distance after and before: more is no improvement
constexpr double kTipTolerance = 0.03;    // of a tip's position, of the diagonal

using Distances = std::vector<std::vector<double>>;

double sum_of(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double number : numbers) sum += number;
  return sum;
}

Distances between(const CoarseBody& body, const std::vector<std::uint32_t>& tips) {
  Distances result;
  for (const std::uint32_t from : tips) {
    const std::vector<double> all = body.distances_from(from);
    std::vector<double> row;
    for (const std::uint32_t to : tips) row.push_back(all[to]);
    result.push_back(std::move(row));
  }
  return result;
}

// The tip of the target for each tip of the source; -1: none.
struct Assignment {
  std::vector<int> to;
  double discord = 0;  // the mean relative difference of distances
};

// Finds all sets of pairs whose distances agree, with as many pairs as possible.
class Assigner {
 public:
  Assigner(const Distances& source, const Distances& target) : source_(source), target_(target) {}

  std::vector<Assignment> find() {
    for (std::size_t wanted = std::min(source_.size(), target_.size()); wanted >= kMinTips && found_.empty();
         --wanted) {
      std::vector<int> to;
      extend(to, wanted, 0);
    }
    std::sort(found_.begin(), found_.end(), [](const Assignment& a, const Assignment& b) {
      return std::pair(a.discord, a.to) < std::pair(b.discord, b.to);
    });
    return std::move(found_);
  }

 private:
  void extend(std::vector<int>& to, std::size_t wanted, std::size_t has) {
    if (found_.size() >= kMaxSets) return;
    if (has + source_.size() - to.size() < wanted) return;
    if (to.size() == source_.size()) {
      if (has == wanted) found_.push_back({to, discord_of(to)});
      return;
    }
    for (int k = 0; k < static_cast<int>(target_.size()); ++k) {
      if (std::find(to.begin(), to.end(), k) != to.end() || !agrees(to, k)) continue;
      to.push_back(k);
      extend(to, wanted, has + 1);
      to.pop_back();
    }
    to.push_back(-1);
    extend(to, wanted, has);
    to.pop_back();
  }

  static double difference(double a, double b) { return std::abs(a - b) / std::max(a, b); }

  bool agrees(const std::vector<int>& to, int next) const {
    const std::size_t i = to.size();
    for (std::size_t k = 0; k < i; ++k) {
      if (to[k] < 0) continue;
      const double a = source_[i][k];
      const double b = target_[static_cast<std::size_t>(next)][static_cast<std::size_t>(to[k])];
      if (difference(a, b) > kMaxDistanceMismatch) return false;
    }
    return true;
  }

  double discord_of(const std::vector<int>& to) const {
    double sum = 0;
    double count = 0;
    for (std::size_t i = 0; i < to.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (to[i] < 0 || to[k] < 0) continue;
        const auto a = static_cast<std::size_t>(to[i]);
        const auto b = static_cast<std::size_t>(to[k]);
        sum += difference(source_[i][k], target_[a][b]);
        count += 1;
      }
    }
    return sum / std::max(1.0, count);
  }

  const Distances& source_;
  const Distances& target_;
  std::vector<Assignment> found_;
};

// Returns the mean square of the distance: large distances count, and the small ones between samples hardly do.
double mean_square(const std::vector<SurfaceSample>& from, const SampleTree& to, double normal_length) {
  double sum = 0;
  for (const SurfaceSample& s : from) {
    const SurfaceSample& found = to[to.nearest(s)];
    sum += norm2(found.point - s.point) + normal_length * normal_length * norm2(found.normal - s.normal);
  }
  return sum / static_cast<double>(from.size());
}

}  // namespace

std::vector<std::uint32_t> tips_of(const CoarseBody& body) {
  const std::size_t count = body.nodes().size();
  Distances distances;
  std::vector<double> sums;
  double greatest = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    distances.push_back(body.distances_from(i));
    sums.push_back(sum_of(distances.back()));
    greatest = std::max(greatest, *std::max_element(distances.back().begin(), distances.back().end()));
  }
  std::vector<double> sorted = sums;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  std::vector<std::uint32_t> tips;
  for (std::uint32_t i = 0; i < count; ++i) {
    bool is_tip = sums[i] > kMinRemoteness * median;
    for (std::uint32_t k = 0; k < count && is_tip; ++k) {
      if (k != i && distances[i][k] < kTipRadiusFraction * greatest)
        is_tip = std::pair(sums[k], k) < std::pair(sums[i], i);
    }
    if (is_tip) tips.push_back(i);
  }
  std::sort(tips.begin(), tips.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(sums[b], a) < std::pair(sums[a], b); });
  if (tips.size() > kMaxTips) tips.resize(kMaxTips);
  return tips;
}

std::vector<std::vector<FitPair>> tip_sets(const CoarseBody& source, const CoarseBody& target, double diagonal) {
  const std::vector<std::uint32_t> from = tips_of(source);
  const std::vector<std::uint32_t> to = tips_of(target);
  if (std::min(from.size(), to.size()) < kMinTips) return {};
  const Distances of_source = between(source, from);
  const Distances of_target = between(target, to);
  std::vector<Assignment> sets = Assigner(of_source, of_target).find();
  if (sets.size() > kMaxPosedSets) sets.resize(kMaxPosedSets);
  std::vector<std::vector<FitPair>> result;
  for (const Assignment& set : sets) {
    std::vector<FitPair>& pairs = result.emplace_back();
    for (std::size_t i = 0; i < set.to.size(); ++i) {
      if (set.to[i] < 0) continue;
      const Vec3d& place = target.nodes()[to[static_cast<std::size_t>(set.to[i])]];
      pairs.push_back({source.nodes()[from[i]], place, kTipTolerance * diagonal});
    }
  }
  return result;
}

std::optional<std::vector<FitPair>> match_tips(const PosedSurface& source, const PosedSurface& target, double diagonal,
                                               const Progress* progress) {
  const double normal_length = kNormalLength * diagonal;
  const SampleTree tree(target.samples, normal_length);
  const auto distance_of = [&](const std::vector<SurfaceSample>& posed) {
    return mean_square(posed, tree, normal_length) +
           mean_square(target.samples, SampleTree(posed, normal_length), normal_length);
  };
  double best = kMaxSquareRatio * distance_of(source.samples);
  std::optional<std::vector<FitPair>> result;
  for (std::vector<FitPair>& pairs : tip_sets(source.body, target.body, diagonal)) {
    stop_if_cancelled(progress);
    std::vector<Anchor> anchors;
    for (const FitPair& pair : pairs) anchors.push_back({pair.source, pair.target});
    CoarseBody posed = source.body;
    posed.pose(anchors, progress);
    const double distance = distance_of(posed.posed(source.samples));
    if (!(distance < best)) continue;
    best = distance;
    result = std::move(pairs);
  }
  return result;
}

}  // namespace knead::detail
