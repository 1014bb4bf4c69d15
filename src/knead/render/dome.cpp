#include "knead/render/dome.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knead::render {
namespace {

// The studio stands still relative to the camera: up is the ground's, `back` points from the scene to the viewer.
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

std::vector<Light> studio_lights(const View& view, int count) {
  const Studio studio = make_studio(view);
  const int keys = std::max(1, (count * 3) / 8);
  const int skies = std::max(1, count - keys);
  std::vector<Light> lights;
  for (int i = 0; i < keys; ++i) lights.push_back(key_light(studio, r2(i), 1.0 / keys));
  for (int i = 0; i < skies; ++i) lights.push_back(sky_light(studio, r2(i), 1.0 / skies));
  return lights;
}

}  // namespace knead::render
