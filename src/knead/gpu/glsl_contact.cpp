#include "knead/gpu/glsl.h"

namespace knead::gpu {

// contact.cpp for the GPU: when a moving tool reaches a resting point. In R, with d relative to the tool: a
// tool that is found out to graze by less than the rounding moves nothing that could be seen.
const char* const kGlslSphereContact = R"(
// The first s >= 0 with |d + s velocity| = radius, for |d| >= radius.
R sphere_contact(R3 d, R3 velocity, R radius) {
  R a = dot(velocity, velocity);
  R b = -dot(d, velocity);
  if (!(b > R(0))) return kNever;
  R along = b / a;
  R3 across = d + velocity * along;
  R inside = radius * radius - dot(across, across);
  if (inside < R(0)) return kNever;
  return max(R(0), along - sqrt(inside / a));
}
)";

const char* const kGlslContact = R"(
#ifdef REGION_CAPSULE
// A capsule is the union of two end balls and a cylinder.
R capsule_contact(R3 half_axis, R3 d, R3 velocity, R outer) {
  R first = min(sphere_contact(d - half_axis, velocity, outer), sphere_contact(d + half_axis, velocity, outer));
  R len = length(half_axis);
  if (len == R(0)) return first;
  R3 axis = half_axis / len;
  R3 across = d - axis * dot(axis, d);
  if (length(across) <= outer) return abs(dot(axis, d)) <= len ? R(0) : first;
  R side = sphere_contact(across, velocity - axis * dot(axis, velocity), outer);
  if (side < kNever && abs(dot(axis, d + velocity * side)) <= len) first = min(first, side);
  return first;
}
#endif

#if defined(REGION_HALF_SPACE) || defined(REGION_SET)
// How far x may move, or how much time may pass, before r can be below outer.
R safe_advance(int f, R3 d, R r, R speed) {
  R outer = n[field_numbers(f) + kOuter];
#ifdef REGION_SET
  if (region_kind(f) == kSet) {
    int set = field_table(f) + kFirstSet;
    R factor = table[set + 4] == 0 ? R(1) : R(0.8lf);
    return factor * sqrt(nearest_squared(set, d)) * (R(1) - outer / r) / max(speed, R(1e-30));
  }
#endif
  int at = field_numbers(f) + kRegion;
  R turning = abs(n[at + 6]) * length(cross(part(at + 3), d));
  return (r - outer) / max(speed + turning, R(1e-30));
}

R traced_contact(int f, R3 d, R3 velocity, R t, R direction, R left) {
  R outer = n[field_numbers(f) + kOuter];
  R slack = R(1e-4) / n[field_numbers(f) + kInverseWidth];
  R speed = length(velocity);
  R s = R(0);
  for (int i = 0; i < 4096 && s <= left; ++i) {
    R3 there = d + velocity * s;
    R r = region_at(f, there, t + direction * s).value;
    if (r < outer + slack) return s;
    s += max(safe_advance(f, there, r, speed), R(1e-6));
  }
  return s <= left ? s : kNever;
}
#endif

R contact_of(int f, R3 d, R3 velocity, R t, R direction, R left) {
  int kind = region_kind(f);
  R outer = n[field_numbers(f) + kOuter];
#ifdef REGION_BALL
  if (kind == kBall) return length(d) < outer ? R(0) : sphere_contact(d, velocity, outer);
#endif
#ifdef REGION_CAPSULE
  if (kind == kCapsule) {
    if (region_at(f, d, R(0)).value < outer) return R(0);
    return capsule_contact(part(field_numbers(f) + kRegion), d, velocity, outer);
  }
#endif
#if defined(REGION_HALF_SPACE) || defined(REGION_SET)
  if (kind == kHalfSpace || kind == kSet) return traced_contact(f, d, velocity, t, direction, left);
#endif
  return R(0);  // everything moves but the zero set, where v is 0 of itself
}

// The earliest time, from t towards `end`, at which the resting point can be inside the support of a field; kNever if
// it never is.
R next_contact(R3 at, R t, R end) {
  R direction = end >= t ? R(1) : R(-1);
  R left = abs(end - t);
  R first = kNever;
  for (int f = 0; f < field_count; ++f) {
    R3 d = at_field(f, at);
#ifdef BLENDED
    for (int k = 0; k < 2; ++k) {
      first = min(first, contact_of(f, k == 0 ? d : d - displacement, R3(0), t, direction, left));
    }
#else
    first = min(first, contact_of(f, d - displacement * t, displacement * -direction, t, direction, left));
#endif
  }
  return first < left ? t + direction * first : kNever;
}
)";

}  // namespace knead::gpu
