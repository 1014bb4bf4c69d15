#include <algorithm>
#include <cmath>

#include "fit/fit_parts.h"
#include "knead/error.h"

namespace knead::session_detail {

namespace {

constexpr std::size_t kGrain = 64;
// Matches count by the square of the cosine between their normals, from this cosine on.
constexpr double kMinCosine = 0.2;
// A match counts half where it is so many times farther than the mean one.
constexpr double kFar = 8;

Vec3d unit_or(const Vec3d& v, const Vec3d& otherwise) {
  const double length = norm(v);
  return length > 0 ? v / length : otherwise;
}

// From a sample to the nearest point of the other surface.
struct Found {
  SurfaceSample nearest;
  double distance = 0;
};

std::vector<Found> find(std::span<const SurfaceSample> samples, const FitSurface& surface, int threads,
                        const Progress* progress) {
  std::vector<Found> found(samples.size());
  parallel_for(samples.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && (progress == nullptr || !progress->cancel); ++i) {
      found[i].nearest = surface.closest(samples[i].point);
      found[i].distance = norm(found[i].nearest.point - samples[i].point);
    }
  });
  stop_if_cancelled(progress);
  return found;
}

double mean_of(std::span<const Found> a, std::span<const Found> b) {
  double sum = 0;
  for (const Found& each : a) sum += each.distance;
  for (const Found& each : b) sum += each.distance;
  return sum / static_cast<double>(a.size() + b.size());
}

// The direction is half way between the normals: the distance in it is right to second order where the surfaces roll on
// each other (Rusinkiewicz 2019).
void add(const SurfaceSample& from, const SurfaceSample& to, double distance, double usual, std::vector<Match>& all) {
  const double cosine = dot(from.normal, to.normal);
  if (cosine < kMinCosine) return;
  const Vec3d direction = unit_or(from.normal + to.normal, to.normal);
  const double far = usual > 0 ? distance / (kFar * usual) : 0;
  const double sure = 1 / (1 + far * far);
  all.push_back({from.point, direction, dot(to.point - from.point, direction), cosine * cosine * sure * sure});
}

}  // namespace

FitSurface::FitSurface(std::vector<Triangle> triangles, std::vector<Vec3d> positions)
    : triangles_(std::move(triangles)),
      positions_(std::move(positions)),
      normals_(positions_.size()),
      tree_(triangles_, positions_) {
  double edges = 0;
  for (const auto& [a, b, c] : triangles_) {
    const Vec3d normal = cross(positions_[b] - positions_[a], positions_[c] - positions_[a]) * 0.5;
    for (const std::uint32_t corner : {a, b, c}) normals_[corner] += normal;
    area_ += norm(normal);
    area_upto_.push_back(area_);
    edges +=
        norm(positions_[b] - positions_[a]) + norm(positions_[c] - positions_[b]) + norm(positions_[a] - positions_[c]);
  }
  mean_edge_ = edges / (3 * static_cast<double>(triangles_.size()));
  for (Vec3d& normal : normals_) normal = unit_or(normal, {0, 0, 0});
}

Vec3d FitSurface::normal_at(std::uint32_t triangle, const std::array<double, 3>& barycentric) const {
  const Triangle& t = triangles_[triangle];
  Vec3d normal{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) normal += normals_[t[i]] * barycentric[i];
  return unit_or(normal, {0, 0, 0});
}

// Areas in equal steps; within the triangles the points of the plastic number's sequence, folded into the triangle.
std::vector<SurfaceSample> FitSurface::samples(std::size_t count) const {
  constexpr double kFirst = 0.7548776662466927;
  constexpr double kSecond = 0.5698402909980532;
  std::vector<SurfaceSample> result;
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = static_cast<double>(i);
    const double area = area_ * (number + 0.5) / static_cast<double>(count);
    const auto place = std::upper_bound(area_upto_.begin(), area_upto_.end() - 1, area) - area_upto_.begin();
    double u = std::fmod(number * kFirst, 1.0);
    double v = std::fmod(number * kSecond, 1.0);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const auto triangle = static_cast<std::uint32_t>(place);
    const Triangle& t = triangles_[triangle];
    const Vec3d point = positions_[t[0]] * (1 - u - v) + positions_[t[1]] * u + positions_[t[2]] * v;
    result.push_back({point, normal_at(triangle, {1 - u - v, u, v})});
  }
  return result;
}

SurfaceSample FitSurface::closest(const Vec3d& p) const {
  const SurfacePoint found = *tree_.closest(p);
  return {found.point, normal_at(found.triangle, found.barycentric)};
}

Matches match(const FitSurface& source, std::span<const SurfaceSample> of_source, const FitSurface& target,
              std::span<const SurfaceSample> of_target, int threads, const Progress* progress) {
  const std::vector<Found> forwards = find(of_source, target, threads, progress);
  const std::vector<Found> backwards = find(of_target, source, threads, progress);
  Matches matches;
  matches.mean_distance = mean_of(forwards, backwards);
  const double usual = matches.mean_distance;
  for (std::size_t i = 0; i < forwards.size(); ++i) {
    add(of_source[i], forwards[i].nearest, forwards[i].distance, usual, matches.all);
  }
  for (std::size_t i = 0; i < backwards.size(); ++i) {
    add(backwards[i].nearest, of_target[i], backwards[i].distance, usual, matches.all);
  }
  return matches;
}

}  // namespace knead::session_detail
