#include "knead/gpu/packed_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "knead/flow/culling.h"
#include "knead/flow/point_tree.h"
#include "knead/flow/sum_error.h"

namespace knead::gpu {

namespace {

using detail::PointTree;

// Fewer points than this are as soon added up as a tree is walked.
constexpr std::size_t kTreePoints = 1000;
// Of float, several times: a node's ball holds its points whatever is rounded.
constexpr double kRounding = 1e-6;
// How many places tell whether a tree pays.
constexpr std::size_t kSamples = 16;

// The relative error of a sum that is allowed wherever r < outer.
double error_allowed(const Field& field, const Segment& segment, const AdvectOptions& options) {
  const auto& set = std::get<PointSet<double>>(field.region);
  const double inner = field.thresholds.inner;
  const double outer = field.thresholds.outer;
  const detail::Surround ball = detail::surround_of(set);
  const double arm = norm(ball.center) + ball.radius + detail::support_reach(set, outer);
  const double duration = segment.barrel ? 1 : std::abs(segment.end - segment.begin);
  const double way = norm(std::get<Translation<double>>(field.motion).velocity) * duration;
  const double error =
      detail::kSumsShareOfTolerance * options.tolerance / static_cast<double>(segment.fields.size()) / way;
  const double epsilon = options.precision == Precision::float32 ? std::numeric_limits<float>::epsilon()
                                                                 : std::numeric_limits<double>::epsilon();
  return detail::sum_error_allowed({field.thresholds, set.exponent, inner, outer, arm}, error, epsilon);
}

// The node that follows each one's own.
std::vector<std::uint32_t> nodes_after(const PointTree& tree) {
  std::vector<std::uint32_t> after(tree.nodes().size());
  after[0] = static_cast<std::uint32_t>(after.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    const PointTree::Node& node = tree.nodes()[i];
    if (node.left == 0) continue;
    after[node.left] = node.right;
    after[node.right] = after[i];
  }
  return after;
}

// How many nodes the shader's walk comes to at d, where r is about `scale`, and fours of points.
std::size_t rounds_at(const PointTree& tree, const std::vector<std::uint32_t>& after, const Vec3d& d, double scale,
                      double error_of_one, int exponent) {
  std::size_t rounds = 0;
  for (std::uint32_t i = 0; i < after.size(); ++rounds) {
    const PointTree::Node& node = tree.nodes()[i];
    const double nearest = norm(d - node.centroid) - node.radius;
    const double term = std::pow(scale / nearest, exponent);
    const double remainder = term * 0.5 * exponent * (exponent + 1) * node.mean_square / (nearest * nearest);
    const bool is_far = nearest > 0 && std::min(term, remainder) <= error_of_one;
    if (!is_far && node.left == 0) rounds += (node.end - node.begin + 3) / 4;
    i = is_far || node.left == 0 ? after[i] : i + 1;
  }
  return rounds;
}

// Of places half the reach away from points of the set.
bool pays(const PointTree& tree, const std::vector<std::uint32_t>& after, double error_of_one, double outer,
          int exponent) {
  std::size_t rounds = 0;
  for (std::size_t k = 0; k < kSamples; ++k) {
    const auto side = [k](std::size_t bit) { return (k >> bit & 1) != 0 ? 0.5 : -0.5; };
    const Vec3d away = Vec3d{side(0), side(1), side(2)} * (outer / std::sqrt(3.0));
    const Vec3d& p = tree.points()[k * tree.size() / kSamples];
    rounds += rounds_at(tree, after, p + away, 0.5 * outer, error_of_one, exponent);
  }
  return rounds < kSamples * tree.size() / 4;
}

}  // namespace

bool may_have_tree(const Field& field, const Segment& segment) {
  const auto* set = std::get_if<PointSet<double>>(&field.region);
  return set != nullptr && set->curves.empty() && set->points.size() >= kTreePoints &&
         segment.time_law == TimeLaw::swept && std::holds_alternative<Translation<double>>(field.motion);
}

PackedTree pack_tree(const Field& field, const Segment& segment, const AdvectOptions& options) {
  const auto& set = std::get<PointSet<double>>(field.region);
  const PointTree tree(set.points);
  const std::vector<std::uint32_t> after = nodes_after(tree);
  PackedTree packed;
  packed.error_of_one = error_allowed(field, segment, options) / static_cast<double>(tree.size());
  if (!pays(tree, after, packed.error_of_one, field.thresholds.outer, set.exponent)) return packed;
  packed.nodes = static_cast<std::int32_t>(after.size());
  packed.points.assign(tree.points().begin(), tree.points().end());
  const double m = set.exponent;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const PointTree::Node& node = tree.nodes()[i];
    const double radius = node.radius + kRounding * (node.radius + norm(node.centroid));
    packed.numbers.insert(packed.numbers.end(), {node.centroid.x, node.centroid.y, node.centroid.z, radius,
                                                 0.5 * m * (m + 1) * node.mean_square});
    for (const std::uint32_t number : {after[i], 3 * node.begin, 3 * node.end, node.right}) {
      packed.entries.push_back(static_cast<std::int32_t>(number));
    }
  }
  return packed;
}

}  // namespace knead::gpu
