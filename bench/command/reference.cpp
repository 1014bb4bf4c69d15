// The paper's method in its plain form.
#include "yardsticks.h"

#include <algorithm>
#include <cmath>

#include "knead/field.h"

namespace knead::bench {

namespace {

// e, f and their gradients (paper, Eq. 6 and 7 and section 4.5).
struct Scalars {
  double e = 0;
  double f = 0;
  Vec3d grad_e;
  Vec3d grad_f;
};

Scalars scalars(const Translation<double>& motion, const Vec3d& d) {
  const Vec3d a = any_orthogonal(normalized(motion.velocity));
  const Vec3d b = cross(motion.velocity, a);
  return {dot(a, d), dot(b, d), a, b};
}

Scalars scalars(const Rotation<double>& motion, const Vec3d& d) {
  const double height = dot(motion.axis, d);
  const Vec3d d_perp = d - motion.axis * height;
  return {height, 0.5 * motion.rate * norm2(d_perp), motion.axis, d_perp * motion.rate};
}

Scalars scalars(const Twist<double>& motion, const Vec3d& d) {
  const double height = dot(motion.axis, d);
  const Vec3d d_perp = d - motion.axis * height;
  return {0.5 * motion.rate * height * height, 0.5 * norm2(d_perp), motion.axis * (motion.rate * height), d_perp};
}

// v = grad p x grad q, p = (1-b) e, q = (1-b) f (Eq. 2 to 5), where the motion has e and f and the weight is that of
// the paper; else from its potential.
template <class M, class R>
Vec3d field_velocity(const M& motion, const R& region, const Thresholds<double>& thresholds, const Vec3d& d, double t) {
  if constexpr (requires { scalars(motion, d); }) {
    if (motion.gauge == 1 && thresholds.falloff == kDefaultFalloff) {
      const RegionValue<double> r = evaluate(region, d, t);
      const double width = thresholds.outer - thresholds.inner;
      const double s = std::clamp((r.value - thresholds.inner) / width, 0.0, 1.0);
      const double rest = 1 - (4 * s * s * s - 3 * s * s * s * s);
      const Vec3d grad_b = r.gradient * (12 * s * s * (1 - s) / width);
      const Scalars u = scalars(motion, d);
      return cross(u.grad_e * rest - grad_b * u.e, u.grad_f * rest - grad_b * u.f);
    }
  }
  return velocity(motion, region, thresholds, d, t);
}

struct Particle {
  Vec3d x;
  double t = 0;
  double h = 1;
};

// One classical Runge-Kutta step (Kutta 1901).
template <class V>
Vec3d rk4_step(const V& v, const Vec3d& x, const Vec3d& k1, double t, double h) {
  const Vec3d k2 = v(x + k1 * (h / 2), t + h / 2);
  const Vec3d k3 = v(x + k2 * (h / 2), t + h / 2);
  const Vec3d k4 = v(x + k3 * h, t + h);
  return x + (k1 + k2 * 2 + k3 * 2 + k4) * (h / 6);
}

// A step and the two halves of it; returns whether their difference was small enough, and the particle moved.
template <class V>
bool doubled_step(const V& v, Particle& particle, double tolerance, double longest) {
  const double h = std::min({particle.h, longest, 1 - particle.t});
  const Vec3d k1 = v(particle.x, particle.t);
  const Vec3d whole = rk4_step(v, particle.x, k1, particle.t, h);
  const Vec3d half = rk4_step(v, particle.x, k1, particle.t, h / 2);
  const Vec3d halves = rk4_step(v, half, v(half, particle.t + h / 2), particle.t + h / 2, h / 2);
  const double error = norm(halves - whole) / 15;
  particle.h = h * std::clamp(0.9 * std::pow(tolerance / std::max(error, 1e-300), 0.2), 0.2, 5.0);
  if (error > tolerance) return false;
  particle.x = halves + (halves - whole) / 15;
  particle.t = h == 1 - particle.t ? 1 : particle.t + h;
  return true;
}

template <class M, class R>
ReferenceResult advect_segment(const M& motion, const R& region, const Segment& segment, std::span<Vec3d> points,
                               double tolerance) {
  const Field& field = segment.fields.front();
  ReferenceResult result;
  const auto v = [&](const Vec3d& x, double t) {
    ++result.evaluations;
    return field_velocity(motion, region, field.thresholds, x - field.center - segment.displacement * t, t);
  };
  const double way = norm(segment.displacement);
  const double longest = way > 0 ? 0.2 * (field.thresholds.outer - field.thresholds.inner) / way : 1;
  for (Vec3d& point : points) {
    Particle particle{point};
    while (particle.t < 1) {
      if (doubled_step(v, particle, tolerance, longest)) ++result.accepted_steps;
    }
    point = particle.x;
  }
  return result;
}

}  // namespace

ReferenceResult advect_reference(const Flow& flow, std::span<Vec3d> points, double tolerance) {
  ReferenceResult sum;
  for (const Segment& segment : flow.segments) {
    const Field& field = segment.fields.front();
    const ReferenceResult part =
        std::visit([&](const auto& motion,
                       const auto& region) { return advect_segment(motion, region, segment, points, tolerance); },
                   field.motion, field.region);
    sum.accepted_steps += part.accepted_steps;
    sum.evaluations += part.evaluations;
  }
  return sum;
}

}  // namespace knead::bench
