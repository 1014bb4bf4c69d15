#include "knead/mesh/polygonise_relax.h"

#include <algorithm>
#include <cmath>

namespace knead::polygonise_detail {
namespace {

// What the quadrilaterals at a vertex give.
struct Surroundings {
  Vec3d normal;  // not of unit length
  Vec3d sum;     // of the neighbours
  double count = 0;
};

std::vector<Surroundings> survey(const QuadSurface& surface) {
  std::vector<Surroundings> around(surface.positions.size());
  for (const Quad& quad : surface.quads) {
    const auto p = [&](std::size_t i) { return surface.positions[quad[i]]; };
    const Vec3d normal = cross(p(2) - p(0), p(3) - p(1));
    for (std::size_t i = 0; i < 4; ++i) {
      Surroundings& s = around[quad[i]];
      s.normal += normal;
      s.sum += p((i + 1) % 4);  // every edge is visited once in each direction
      s.count += 1;
    }
  }
  return around;
}

// Returns p moved by the largest of the steps d, d/2, d/4, d/8 along `direction` that does not increase |f|, or p if
// all do.
Vec3d guarded_step(const ScalarFunction& f, const Vec3d& p, double value, const Vec3d& step) {
  double t = 1;
  for (int i = 0; i < 4; ++i, t *= 0.5) {
    const Vec3d q = p + step * t;
    if (std::abs(f(q)) <= std::abs(value)) return q;
  }
  return p;
}

Vec3d gradient(const ScalarFunction& f, const Vec3d& p, double value, double h) {
  return Vec3d{f({p.x + h, p.y, p.z}) - value, f({p.x, p.y + h, p.z}) - value, f({p.x, p.y, p.z + h}) - value} / h;
}

Vec3d limited(const Vec3d& v, double length) {
  const double size = norm(v);
  return size <= length ? v : v * (length / size);
}

// One Newton step along the gradient, at most half a cell; returns the gradient's length, 0 where there is no step.
double newton(const ScalarFunction& f, double cell, Vec3d& p) {
  const double value = f(p);
  const Vec3d g = gradient(f, p, value, 1e-5 * cell);
  const double steepness = norm2(g);
  if (!(steepness > 0) || !std::isfinite(steepness) || !std::isfinite(value)) return 0;
  p = guarded_step(f, p, value, limited(g * (-value / steepness), 0.5 * cell));
  return std::sqrt(steepness);
}

// One secant step along the normal of the surface, given the slope of f there: two evaluations instead of five.
Vec3d return_along(const ScalarFunction& f, const Vec3d& p, const Vec3d& normal, double steepness, double cell) {
  const double value = f(p);
  const double size = norm(normal);
  if (!(steepness > 0) || !(size > 0) || !std::isfinite(value)) return p;
  return guarded_step(f, p, value, limited(normal * (-value / (steepness * size)), 0.5 * cell));
}

// One step towards the neighbours within the tangent plane.
Vec3d smoothed(const Vec3d& p, const Surroundings& around) {
  const double size = norm2(around.normal);
  const Vec3d move = around.sum / around.count - p;
  return size > 0 ? p + (move - around.normal * (dot(move, around.normal) / size)) * 0.6 : p;
}

double smallest_angle_cosine(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto cosine = [](const Vec3d& u, const Vec3d& v) {
    const double size = std::sqrt(norm2(u) * norm2(v));
    return size > 0 ? dot(u, v) / size : 1.0;
  };
  return std::max({cosine(b - a, c - a), cosine(a - b, c - b), cosine(a - c, b - c)});
}

}  // namespace

void relax(QuadSurface& surface, const ScalarFunction& f, double cell, int rounds) {
  if (rounds == 0) return;
  const std::vector<Vec3d> home = surface.positions;
  std::vector<double> steepness;
  for (Vec3d& p : surface.positions) steepness.push_back(newton(f, cell, p));
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Surroundings> around = survey(surface);
    for (std::size_t i = 0; i < home.size(); ++i) {
      const Vec3d p = home[i] + limited(smoothed(surface.positions[i], around[i]) - home[i], cell);
      surface.positions[i] = return_along(f, p, around[i].normal, steepness[i], cell);
    }
  }
  for (Vec3d& p : surface.positions) newton(f, cell, p);
}

Mesh split_quads(const QuadSurface& surface) {
  Mesh mesh;
  mesh.positions = surface.positions;
  mesh.face_begin.reserve(2 * surface.quads.size() + 1);
  mesh.corner_vertex.reserve(6 * surface.quads.size());
  for (const Quad& q : surface.quads) {
    const auto p = [&](std::size_t i) { return surface.positions[q[i]]; };
    const double even = std::max(smallest_angle_cosine(p(0), p(1), p(2)), smallest_angle_cosine(p(0), p(2), p(3)));
    const double odd = std::max(smallest_angle_cosine(p(1), p(2), p(3)), smallest_angle_cosine(p(1), p(3), p(0)));
    const std::size_t s = even <= odd ? 0 : 1;
    mesh.add_face(std::array{q[s], q[s + 1], q[s + 2]});
    mesh.add_face(std::array{q[s], q[s + 2], q[(s + 3) % 4]});
  }
  return mesh;
}

}  // namespace knead::polygonise_detail
