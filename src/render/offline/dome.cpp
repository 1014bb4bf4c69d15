// The shapes that cast shadows, and the lights of the studio.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "knead/vec.h"
#include "render/offline/passes.h"

namespace knead::render {
namespace {

void append(const DrawSurface& surface, Occluder& occluder) {
  if (surface.indices.empty()) {
    for (const DrawVertex& vertex : surface.vertices) occluder.points.push_back(vertex.position);
    return;
  }
  const auto first = static_cast<std::uint32_t>(occluder.positions.size());
  for (const DrawVertex& vertex : surface.vertices) occluder.positions.push_back(vertex.position);
  for (const std::uint32_t index : surface.indices) occluder.indices.push_back(first + index);
}

void measure(Occluder& occluder, const Vec3d& up, double point_radius) {
  Box box;
  double ground = kInfinity;
  const auto visit = [&](const Vec3f& p) {
    box.extend(Vec3d(p));
    ground = std::min(ground, dot(up, Vec3d(p)));
  };
  std::for_each(occluder.positions.begin(), occluder.positions.end(), visit);
  std::for_each(occluder.points.begin(), occluder.points.end(), visit);
  if (box.empty()) return;
  occluder.ground = ground;
  occluder.center = box.center();
  double radius = 0;
  const auto reach = [&](const Vec3f& p, double more) {
    radius = std::max(radius, norm(Vec3d(p) - occluder.center) + more);
  };
  for (const Vec3f& p : occluder.positions) reach(p, 0);
  for (const Vec3f& p : occluder.points) reach(p, point_radius);
  occluder.radius = std::max(radius * 1.01, 1e-6);
}

void merge_cells(Occluder& occluder, double cell) {
  std::unordered_map<std::uint64_t, std::uint32_t> cells;
  std::vector<Vec3d> sums;
  std::vector<double> counts;
  std::vector<std::uint32_t> merged;
  merged.reserve(occluder.positions.size());
  // Shifted to positive numbers, so that casts round down.
  const auto index = [&](float x) { return static_cast<std::uint64_t>(x / cell + 1048576) & 0x1fffff; };
  for (const Vec3f& p : occluder.positions) {
    const std::uint64_t key = index(p.x) | index(p.y) << 21 | index(p.z) << 42;
    const auto [at, is_new] = cells.try_emplace(key, static_cast<std::uint32_t>(sums.size()));
    if (is_new) {
      sums.emplace_back();
      counts.push_back(0);
    }
    sums[at->second] += Vec3d(p);
    counts[at->second] += 1;
    merged.push_back(at->second);
  }
  occluder.positions.clear();
  for (std::size_t i = 0; i < sums.size(); ++i) occluder.positions.emplace_back(sums[i] / counts[i]);
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    const std::uint32_t a = merged[occluder.indices[i]];
    const std::uint32_t b = merged[occluder.indices[i + 1]];
    const std::uint32_t c = merged[occluder.indices[i + 2]];
    if (a != b && b != c && c != a) kept.insert(kept.end(), {a, b, c});
  }
  occluder.indices = std::move(kept);
}

double beyond(const std::array<float, 4>& plane, const Vec3f& p) {
  return double{plane[0]} * p.x + double{plane[1]} * p.y + double{plane[2]} * p.z - double{plane[3]};
}

// Returns the corners of the rest of a triangle, at most four.
std::vector<Vec3f> clipped(const std::array<Vec3f, 3>& triangle, const std::array<float, 4>& plane) {
  std::vector<Vec3f> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f& a = triangle[i];
    const Vec3f& b = triangle[(i + 1) % 3];
    const double at_a = beyond(plane, a);
    const double at_b = beyond(plane, b);
    if (at_a <= 0) kept.push_back(a);
    if ((at_a <= 0) != (at_b <= 0)) kept.push_back(Vec3f(Vec3d(a) + (Vec3d(b) - Vec3d(a)) * (at_a / (at_a - at_b))));
  }
  return kept;
}

// The studio, which is fixed relative to the camera: up is the ground's, `back` points from the scene to the viewer.
struct Studio {
  Vec3d up;
  Vec3d right;
  Vec3d back;

  Vec3d direction(double to_right, double to_up, double to_back) const {
    return normalized(right * to_right + up * to_up + back * to_back);
  }
};

Studio make_studio(const View& view) {
  Vec3d right = cross(view.frame.forward, view.ground_up);
  right = norm(right) > 1e-6 ? normalized(right) : view.frame.right;
  return {view.ground_up, right, normalized(cross(right, view.ground_up))};
}

struct Point2 {
  double x;
  double y;
};

// Roberts' R2 sequence: any run of consecutive points covers the unit square evenly.
Point2 r2(int i) {
  constexpr double plastic = 1.32471795724474602596;
  const double x = 0.5 + i / plastic;
  const double y = 0.5 + i / (plastic * plastic);
  return {x - std::floor(x), y - std::floor(y)};
}

Vec3d on_sphere(const Studio& studio, Point2 p) {
  const double z = 1 - 2 * p.x;
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  const double angle = 2 * std::numbers::pi * p.y;
  return studio.right * (r * std::cos(angle)) + studio.back * (r * std::sin(angle)) + studio.up * z;
}

Vec3d in_cone(const Vec3d& axis, double cosine, Point2 p) {
  const Vec3d u = any_orthogonal(axis);
  const Vec3d v = cross(axis, u);
  const double z = 1 - (1 - cosine) * p.x;
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  const double angle = 2 * std::numbers::pi * p.y;
  return u * (r * std::cos(angle)) + v * (r * std::sin(angle)) + axis * z;
}

// exp(k (cos - 1)): a round light of angular width about 1 / sqrt(k).
double lobe(const Vec3d& d, const Vec3d& axis, double k) { return std::exp(k * (dot(d, axis) - 1)); }

// Irradiance / pi of a patch that faces light of radiance 1 from everywhere is 1.
Vec3d sky(const Studio& studio, const Vec3d& d) {
  const double t = std::clamp(0.5 + 0.75 * dot(d, studio.up), 0.0, 1.0);
  const double smooth = t * t * (3 - 2 * t);
  const Vec3d below = Vec3d{0.17, 0.155, 0.14};  // light that a pale floor throws back
  const Vec3d above = Vec3d{0.36, 0.375, 0.40};
  Vec3d radiance = below * (1 - smooth) + above * smooth;
  radiance += Vec3d{0.34, 0.37, 0.42} * lobe(d, studio.direction(1.0, 0.35, 0.35), 5);   // fill, from the right
  radiance += Vec3d{1.10, 1.12, 1.15} * lobe(d, studio.direction(0.25, 0.75, -0.9), 7);  // rim, from behind
  return radiance;
}

constexpr double kKeyCosine = 0.94;  // half angle 20 degrees

Light key_light(const Studio& studio, Point2 p, double share) {
  const Vec3d axis = studio.direction(-0.62, 0.95, 0.62);
  return {Vec3f(in_cone(axis, kKeyCosine, p)), Vec3f(Vec3d{0.98, 0.95, 0.90} * share)};
}

Light sky_light(const Studio& studio, Point2 p, double share) {
  const Vec3d d = on_sphere(studio, p);
  return {Vec3f(d), Vec3f(sky(studio, d) * (4 * share))};
}

}  // namespace

Occluder make_occluder(const std::vector<DrawSurface>& surfaces, const Vec3d& up, double cell,
                       std::size_t max_triangles, double point_radius) {
  Occluder occluder;
  for (const DrawSurface& surface : surfaces) append(surface, occluder);
  occluder.is_solid = std::all_of(surfaces.begin(), surfaces.end(), [](const DrawSurface& surface) {
    return surface.is_solid || surface.indices.empty();
  });
  measure(occluder, up, point_radius);
  if (occluder.indices.size() > 3 * max_triangles) merge_cells(occluder, cell * occluder.radius);
  return occluder;
}

void clip_occluder(Occluder& occluder, const std::array<float, 4>& plane) {
  std::erase_if(occluder.points, [&](const Vec3f& p) { return beyond(plane, p) > 0; });
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    std::array<Vec3f, 3> triangle;
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = occluder.positions[occluder.indices[i + k]];
    const auto is_beyond = [&](const Vec3f& p) { return beyond(plane, p) > 0; };
    const auto count = std::count_if(triangle.begin(), triangle.end(), is_beyond);
    if (count > 0) occluder.is_solid = false;
    if (count == 0) {
      for (std::size_t k = 0; k < 3; ++k) indices.push_back(occluder.indices[i + k]);
    } else if (count < 3) {
      const auto first = static_cast<std::uint32_t>(occluder.positions.size());
      const std::vector<Vec3f> kept = clipped(triangle, plane);
      occluder.positions.insert(occluder.positions.end(), kept.begin(), kept.end());
      for (std::uint32_t k = 2; k < kept.size(); ++k) indices.insert(indices.end(), {first, first + k - 1, first + k});
    }
  }
  occluder.indices = std::move(indices);
}

std::vector<Light> studio_lights(const View& view, int count) {
  const Studio studio = make_studio(view);
  const int keys = std::max(1, (count * 3) / 8);
  const int skies = std::max(1, count - keys);
  std::vector<Light> lights;
  lights.reserve(static_cast<std::size_t>(keys) + static_cast<std::size_t>(skies));
  for (int i = 0; i < keys; ++i) lights.push_back(key_light(studio, r2(i), 1.0 / keys));
  for (int i = 0; i < skies; ++i) lights.push_back(sky_light(studio, r2(i), 1.0 / skies));
  return lights;
}

}  // namespace knead::render
