// Samples of surfaces, a tree over points with normals, and matches weighted by distance and normals.
#include "fit/surface_matches.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "knead/error.h"
#include "mesh/body_points.h"

namespace knead::detail {

namespace {

constexpr std::size_t kDensity = 8;  // samples from which each of the evenly spread ones is chosen
constexpr std::uint32_t kLeafSize = 8;
constexpr std::size_t kMatchGrain = 64;
constexpr double kSigmaFactor = 2.5;     // times the median distance
constexpr double kMinSigmaFactor = 0.5;  // times MatchOptions::far
constexpr double kMinSigma = 1e-9;       // a length
constexpr double kMinCosine = 0.1;

// Returns a number from 0 to 1: the bits of i in reverse order.
double reversed_bits(std::uint32_t i) {
  double result = 0;
  for (double by = 0.5; i != 0; i >>= 1, by /= 2) result += (i & 1) != 0 ? by : 0;
  return result;
}

double median_of(std::vector<double> numbers) {
  if (numbers.empty()) return 0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

}  // namespace

SurfaceSamples::SurfaceSamples(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                               std::size_t count) {
  std::vector<double> area_upto;
  double area = 0;
  for (const Triangle& t : triangles) {
    area += 0.5 * norm(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]));
    area_upto.push_back(area);
  }
  const std::size_t dense = kDensity * count;
  std::vector<TrianglePoint> places;
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < dense; ++i) {
    const double wanted = area * (static_cast<double>(i) + 0.5) / static_cast<double>(dense);
    const auto found = std::lower_bound(area_upto.begin(), area_upto.end(), wanted);
    const auto triangle = static_cast<std::uint32_t>(
        std::min<std::ptrdiff_t>(found - area_upto.begin(), static_cast<std::ptrdiff_t>(triangles.size()) - 1));
    double u = reversed_bits(static_cast<std::uint32_t>(i + 1));
    double v = std::fmod(static_cast<double>(i) * 0.61803398874989485, 1.0);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    places.push_back({triangle, {1 - u - v, u, v}});
    const Triangle& t = triangles[triangle];
    points.push_back(positions[t[0]] * (1 - u - v) + positions[t[1]] * u + positions[t[2]] * v);
  }
  for (const std::uint32_t i : spread_points(points, count)) places_.push_back(places[i]);
}

std::vector<SurfaceSample> SurfaceSamples::at(std::span<const Triangle> triangles,
                                              std::span<const Vec3d> positions) const {
  const std::vector<Vec3d> normals = area_weighted_normals(positions, triangles);
  std::vector<SurfaceSample> samples;
  samples.reserve(places_.size());
  for (const TrianglePoint& place : places_) {
    const Triangle& t = triangles[place.triangle];
    SurfaceSample sample{{0, 0, 0}, {0, 0, 0}};
    Vec3d normal{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      sample.point += positions[t[k]] * place.barycentric[k];
      const double length = norm(normals[t[k]]);
      if (length > 0) normal += normals[t[k]] * (place.barycentric[k] / length);
    }
    if (norm(normal) > 0) sample.normal = normalized(normal);
    samples.push_back(sample);
  }
  return samples;
}

std::vector<bool> SurfaceSamples::on_border(std::span<const Triangle> triangles,
                                            std::span<const Vec3d> positions) const {
  std::vector<std::array<std::uint32_t, 2>> edges;
  double area = 0;
  for (const Triangle& t : triangles) {
    area += 0.5 * norm(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]));
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back({std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])});
  }
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> border;
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t begin = i;
    while (i < edges.size() && edges[i] == edges[begin]) ++i;
    if (i == begin + 1) border.insert(border.end(), edges[begin].begin(), edges[begin].end());
  }
  const double near = 4 * area / static_cast<double>(places_.size());  // a length, squared
  std::vector<bool> result;
  for (const SurfaceSample& s : at(triangles, positions)) {
    result.push_back(std::any_of(border.begin(), border.end(),
                                 [&](std::uint32_t v) { return norm2(positions[v] - s.point) < near; }));
  }
  return result;
}

SampleTree::SampleTree(std::vector<SurfaceSample> samples, double normal_length)
    : samples_(std::move(samples)), normal_length_(normal_length), numbers_(samples_.size()) {
  std::iota(numbers_.begin(), numbers_.end(), 0U);
  for (const SurfaceSample& sample : samples_) points_.push_back(point_of(sample));
  build(0, static_cast<std::uint32_t>(samples_.size()));
  std::vector<Point> sorted;
  sorted.reserve(points_.size());
  for (const std::uint32_t i : numbers_) sorted.push_back(points_[i]);
  points_ = std::move(sorted);
}

SampleTree::Point SampleTree::point_of(const SurfaceSample& sample) const {
  const Vec3d n = sample.normal * normal_length_;
  return {sample.point.x, sample.point.y, sample.point.z, n.x, n.y, n.z};
}

std::uint32_t SampleTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({0, begin, end, 0, 0});
  if (end - begin <= kLeafSize) return number;
  std::uint32_t widest = 0;
  double width = -1;
  for (std::uint32_t axis = 0; axis < 6; ++axis) {
    double low = kInfinity;
    double high = -low;
    for (std::uint32_t i = begin; i < end; ++i) {
      low = std::min(low, points_[numbers_[i]][axis]);
      high = std::max(high, points_[numbers_[i]][axis]);
    }
    if (high - low > width) {
      width = high - low;
      widest = axis;
    }
  }
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::uint32_t i) { return numbers_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(points_[a][widest], a) < std::pair(points_[b][widest], b);
  });
  nodes_[number].axis = widest;
  nodes_[number].split = points_[numbers_[middle]][widest];
  build(begin, middle);
  const std::uint32_t upper = build(middle, end);
  nodes_[number].upper = upper;
  return number;
}

void SampleTree::search(std::uint32_t number, const Point& p, double& best, std::uint32_t& found) const {
  const Node& node = nodes_[number];
  if (node.upper == 0) {
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      double sum = 0;
      for (std::size_t axis = 0; axis < 6; ++axis) sum += (points_[i][axis] - p[axis]) * (points_[i][axis] - p[axis]);
      if (sum < best || (sum == best && numbers_[i] < found)) {
        best = sum;
        found = numbers_[i];
      }
    }
    return;
  }
  const double beyond = p[node.axis] - node.split;
  search(beyond < 0 ? number + 1 : node.upper, p, best, found);
  if (beyond * beyond <= best) search(beyond < 0 ? node.upper : number + 1, p, best, found);
}

std::uint32_t SampleTree::nearest(const SurfaceSample& to) const {
  double best = kInfinity;
  std::uint32_t found = 0;
  search(0, point_of(to), best, found);
  return found;
}

Matches match(const SampleTree& source, std::span<const SurfaceSample> of_source, const SampleTree& target,
              std::span<const SurfaceSample> of_target, const MatchOptions& options) {
  const std::size_t count = of_source.size() + of_target.size();
  std::vector<Match> all(count);
  std::vector<double> back(count);
  parallel_for(count, kMatchGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const bool forth = i < of_source.size();
      const SurfaceSample& asking = forth ? of_source[i] : of_target[i - of_source.size()];
      const SampleTree& there = forth ? target : source;
      const std::uint32_t number = there.nearest(asking);
      const SurfaceSample& found = there[number];
      const std::vector<bool>& border = forth ? options.target_border : options.source_border;
      const SampleTree& here = forth ? source : target;
      back[i] = norm(here[here.nearest(found)].point - asking.point);
      const SurfaceSample& a = forth ? asking : found;
      const SurfaceSample& b = forth ? found : asking;
      const double cosine = dot(a.normal, b.normal);
      all[i] = {a.point, b.point - a.point, b.normal, cosine > kMinCosine ? cosine * cosine : 0};
      if (!border.empty() && border[number]) all[i].weight = 0;
    }
  });
  std::vector<double> distances;
  std::vector<double> along;
  for (const Match& m : all) {
    distances.push_back(norm(m.by));
    along.push_back(std::abs(dot(m.normal, m.by)));
  }
  Matches result;
  result.median = median_of(distances);
  result.median_along = median_of(std::move(along));
  // If nearly all of the surface matches, the rest is what remains to be done: within `far` nothing is an outlier.
  const double sigma = std::max({kSigmaFactor * result.median, kMinSigmaFactor * options.far, kMinSigma});
  for (std::size_t i = 0; i < count; ++i) {
    // As exp(-ratio^2), from + and * only: the same bits on every machine.
    const double ratio = distances[i] / sigma;
    const double bell = std::max(0.0, 1 - 0.25 * ratio * ratio);
    all[i].weight *= bell * bell * bell * bell;
    if (!(back[i] <= options.far && all[i].weight > 1e-3)) continue;
    result.all.push_back(all[i]);
    result.matched += i < of_source.size() ? 1 / static_cast<double>(of_source.size()) : 0;
  }
  return result;
}

Matches match_in_order(std::span<const SurfaceSample> from, std::span<const SurfaceSample> to) {
  Matches result;
  std::vector<double> distances;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3d by = to[i].point - from[i].point;
    const double distance = norm(by);
    distances.push_back(distance);
    if (distance > 0) result.all.push_back({from[i].point, by, by / distance, 1});
  }
  result.median = median_of(std::move(distances));
  result.median_along = result.median;
  result.matched = 1;
  return result;
}

}  // namespace knead::detail
