#include "knead/gpu/glsl.h"

namespace knead::gpu {

// What stands in flow and field as templates over the scalar, again for the GPU: blend.h, motion.h, region.h,
// sincos.h, field.h. R is float or double, R3 its vector. The numbers of field f begin at field_numbers(f) in n[]; how
// they lie there says packed_flow.cpp.
const char* const kGlslField = R"(
struct SinCos { R s; R c; };
struct Region { R value; R3 gradient; };

R nearest_integer(R x) { return floor(x + R(0.5)); }

SinCos sincos_of(R x) {
  precise R quarter = nearest_integer(x * R(0.63661977236758134308lf));
#ifdef IN_DOUBLE
  precise R y = ((x - quarter * R(1.57079632673412561417lf)) - quarter * R(6.07710050630396597660e-11lf)) -
                quarter * R(2.02226624879595063154e-21lf);
#else
  precise R y = ((x - quarter * R(1.5703125)) - quarter * R(4.837512969970703125e-4)) -
                quarter * R(7.54978995489188216e-8);
#endif
  R z = y * y;
  R s = R(1.0lf / 355687428096000.0lf);
  s = s * z + R(-1.0lf / 1307674368000.0lf);
  s = s * z + R(1.0lf / 6227020800.0lf);
  s = s * z + R(-1.0lf / 39916800.0lf);
  s = s * z + R(1.0lf / 362880.0lf);
  s = s * z + R(-1.0lf / 5040.0lf);
  s = s * z + R(1.0lf / 120.0lf);
  s = s * z + R(-1.0lf / 6.0lf);
  R c = R(1.0lf / 20922789888000.0lf);
  c = c * z + R(-1.0lf / 87178291200.0lf);
  c = c * z + R(1.0lf / 479001600.0lf);
  c = c * z + R(-1.0lf / 3628800.0lf);
  c = c * z + R(1.0lf / 40320.0lf);
  c = c * z + R(-1.0lf / 720.0lf);
  c = c * z + R(1.0lf / 24.0lf);
  R sine = y + y * (z * s);
  R cosine = R(1) - (z * R(0.5) - z * (z * c));
  R turn = quarter - R(4) * floor(quarter * R(0.25));
  if (turn == R(0)) return SinCos(sine, cosine);
  if (turn == R(1)) return SinCos(cosine, -sine);
  if (turn == R(2)) return SinCos(-sine, -cosine);
  return SinCos(-cosine, sine);
}

// v turned about the unit axis.
R3 turned(R3 v, R3 axis, SinCos by) {
  return v * by.c + cross(axis, v) * by.s + axis * (dot(axis, v) * (R(1) - by.c));
}

// w and dw/dr; exactly 1 and 0 inside, 0 and 0 outside.
R2 blend_weight(int f, R r) {
  int at = field_numbers(f);
  R outer = n[at + kOuter];
  R inverse = n[at + kInverseWidth];
  precise R rest = clamp((outer - r) * inverse, R(0), R(1));
  precise R s = R(1) - rest;
#ifdef FALLOFF
  R degree = n[at + kFalloff];
  if (degree == R(3)) {
    precise R c = rest * (rest * (rest - R(3)) + R(3));
    return R2(c * c * c, c * c * (s * s) * (R(-9) * inverse));
  }
  if (degree != R(4)) {
    R power = rest;
    for (R i = R(4); i < degree; ++i) power *= rest;
    precise R sum = rest * (degree * s + rest) + s * s * (degree * (degree - R(1)) * R(0.5));
    precise R c = power * rest * sum;
    return R2(c * c, c * (s * s * power) * (-degree * (degree - R(1)) * (degree - R(2)) * inverse));
  }
#endif
  precise R complement = rest * rest * (rest * (R(3) * rest + R(-8)) + R(6));
  return R2(complement * complement, complement * (s * s * rest) * (R(-24) * inverse));
}

// u and A of d = x - c.
void motion_at(int f, R3 d, out R3 u, out R3 a) {
  int at = field_numbers(f) + kMotion;
  int kind = motion_kind(f);
  u = R3(0);
  a = R3(0);
#ifdef MOTION_TRANSLATION
  if (kind == kTranslation) {
    u = part(at);
    a = cross(part(at + 3), d) + part(at + 6) * dot(part(at + 9), d);
  }
#endif
#ifdef MOTION_ROTATION
  if (kind == kRotation) {
    R3 axis = part(at);
    R height = dot(axis, d);
    R3 across = d - axis * height;
    u = cross(axis, d) * n[at + 3];
    a = across * (n[at + 4] * height) + axis * (n[at + 5] * dot(across, across) + n[at + 6] * height * height);
  }
#endif
#ifdef MOTION_TWIST
  if (kind == kTwist) {
    R3 axis = part(at);
    R height = dot(axis, d);
    R3 across = d - axis * height;
    u = cross(axis, d) * (n[at + 3] * height);
    a = across * (n[at + 4] * height * height) + axis * (n[at + 5] * dot(across, across) * height);
  }
#endif
#ifdef MOTION_STRAIN
  if (kind == kStrainMotion) {
    u = R3(dot(part(at), d), dot(part(at + 3), d), dot(part(at + 6), d));
    a = cross(u, d) * R(1.0lf / 3.0lf);
  }
#endif
}

Region distance_to_origin(R3 d) {
  R r = sqrt(dot(d, d));
  return Region(r, r > R(0) ? d / r : R3(0));
}

// n(t) of a half-space.
R3 normal_at(int f, R t) {
  int at = field_numbers(f) + kRegion;
  R angle = n[at + 6];
  if (angle == R(0)) return part(at);
  return turned(part(at), part(at + 3), sincos_of(angle * t));
}
)";

// Follows the sets.
const char* const kGlslVelocity = R"(
// r and its gradient at d = x - c(t).
Region region_at(int f, R3 d, R t) {
  int kind = region_kind(f);
#ifdef REGION_BALL
  if (kind == kBall) return distance_to_origin(d);
#endif
#ifdef REGION_CAPSULE
  if (kind == kCapsule) {
    int at = field_numbers(f) + kRegion;
    R3 half_axis = part(at);
    return distance_to_origin(d - half_axis * clamp(dot(half_axis, d) * n[at + 3], R(-1), R(1)));
  }
#endif
#ifdef REGION_HALF_SPACE
  if (kind == kHalfSpace) {
    R3 normal = normal_at(f, t);
    return Region(dot(normal, d), normal);
  }
#endif
#ifdef REGION_SET
  if (kind == kSet) return set_distance(field_table(f) + kFirstSet, d, n[field_numbers(f) + kOuter]);
#endif
#ifdef REGION_HANDLES
  if (kind == kHandles) return handles_at(f, d, t);
#endif
  return Region(R(0), R3(0));
}

// The one formula: v = w u + (dw/dr) grad r x A.
R3 velocity_of(int f, R3 d, R t) {
  Region r = region_at(f, d, t);
  R2 w = blend_weight(f, r.value);
  R3 u;
  R3 a;
  motion_at(f, d, u, a);
  return u * w.x + cross(r.gradient, a) * w.y;
}

// d = x - c of field f at the segment's t = 0, from that of the first field.
R3 at_field(int f, R3 at) {
#ifdef SINGLE_FIELD
  return at;
#else
  return at - part(field_numbers(f));
#endif
}

R3 velocity_at(R3 at, R t) {
  ++evaluations;
  R3 sum = R3(0);
  for (int f = 0; f < field_count; ++f) {
    R3 d = at_field(f, at);
#ifdef BLENDED
    sum += velocity_of(f, d, t) * (R(1) - t) + velocity_of(f, d - displacement, t) * t;
#else
    sum += velocity_of(f, d - displacement * t, t);
#endif
  }
  return sum;
}

// A speed at which r may change besides that of the point relative to the tool's frame.
R hidden_speed(R3 at, R t) {
  R greatest = R(0);
#if defined(BLENDED) || defined(REGION_HALF_SPACE) || defined(REGION_HANDLES)
  for (int f = 0; f < field_count; ++f) {
    R3 d = at_field(f, at);
#ifdef BLENDED
    R3 before = velocity_of(f, d, R(0));
    R3 after = velocity_of(f, d - displacement, R(0));
    greatest = max(greatest, sqrt(max(dot(before, before), dot(after, after))));
#else
    d -= displacement * t;
    int kind = region_kind(f);
    if (kind != kHalfSpace && kind != kHandles) continue;
    int region = field_numbers(f) + kRegion;
    R angle = n[region + 6];
    if (angle == R(0)) continue;
    R3 axis = part(region + 3);
    R speed = kind == kHandles ? length(cross(axis, d)) : abs(dot(cross(axis, normal_at(f, t)), d));
    greatest = max(greatest, abs(angle) * speed);
#endif
  }
#endif
  return greatest;
}

// Between handles: the distance from one set past the point to the other.
R local_width(R3 at, R t) {
  R least = kNever;
#ifdef REGION_HANDLES
  for (int f = 0; f < field_count; ++f) {
    if (region_kind(f) == kHandles) least = min(least, handles_width(f, at_field(f, at) - displacement * t, t));
  }
#endif
  return least;
}
)";

}  // namespace knead::gpu
