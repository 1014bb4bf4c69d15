// The formulas of vec.h, field.h and region.h in GLSL: motions, regions, v, and the distances of point sets.
#include "gpu/glsl.h"

namespace knead::gpu {

// R is float or double, R3 its vector. NUMBER(f, k) is the k-th number of field f, in the layout of glsl.h.
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

#ifdef FALLOFF
// The wide falloff without an inner region (wide_weight of field.h).
R2 wide_weight(int f, R r) {
  R per_bump = NUMBER(f, kPerBump);
  R ratio = NUMBER(f, kOuter) * per_bump;
  R k = R(1) / (ratio * ratio);
  R linear = R(1) + k;
  R quadratic = (R(1) + k * linear) / R(3);
  precise R y = (r * per_bump) * (r * per_bump);
  R per_r = R(2) * r * per_bump * per_bump;
  if (y < R(1)) return R2(y * (y * quadratic - linear) + R(1), per_r * (R(2) * y * quadratic - linear));
  precise R rest = max((NUMBER(f, kOuter) - r) * per_bump, R(0)) * (ratio + r * per_bump) * k;
  R base = rest * rest / (R(3) * (R(1) - k) * y);
  return R2(base * rest, -per_r * base * (rest / y + R(3) * k));
}
#endif

// w and dw/dr; exactly 1 and 0 inside, 0 and 0 outside.
R2 blend_weight(int f, R r) {
  R outer = NUMBER(f, kOuter);
  R inverse = NUMBER(f, kInverseWidth);
  precise R rest = clamp((outer - r) * inverse, R(0), R(1));
  precise R s = R(1) - rest;
#ifdef FALLOFF
  R degree = NUMBER(f, kFalloff);
  if (degree == R(kWideFalloff)) return wide_weight(f, r);
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
  int kind = motion_kind(f);
  u = R3(0);
  a = R3(0);
#ifdef MOTION_TRANSLATION
  if (kind == kTranslation) {
    u = PART(f, kMotion);
    a = cross(PART(f, kMotion + 3), d) + PART(f, kMotion + 6) * dot(PART(f, kMotion + 9), d);
  }
#endif
#ifdef MOTION_ROTATION
  if (kind == kRotation) {
    R3 axis = PART(f, kMotion);
    R height = dot(axis, d);
    R3 across = d - axis * height;
    u = cross(axis, d) * NUMBER(f, kMotion + 3);
    a = across * (NUMBER(f, kMotion + 4) * height) +
        axis * (NUMBER(f, kMotion + 5) * dot(across, across) + NUMBER(f, kMotion + 6) * height * height);
  }
#endif
#ifdef MOTION_TWIST
  if (kind == kTwist) {
    R3 axis = PART(f, kMotion);
    R height = dot(axis, d);
    R3 across = d - axis * height;
    u = cross(axis, d) * (NUMBER(f, kMotion + 3) * height);
    a = across * (NUMBER(f, kMotion + 4) * height * height) +
        axis * (NUMBER(f, kMotion + 5) * dot(across, across) * height);
  }
#endif
#ifdef MOTION_STRAIN
  if (kind == kStrainMotion) {
    u = R3(dot(PART(f, kMotion), d), dot(PART(f, kMotion + 3), d), dot(PART(f, kMotion + 6), d));
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
  R angle = NUMBER(f, kRegion + 6);
  R3 normal = PART(f, kRegion);
  if (angle == R(0)) return normal;
  return turned(normal, PART(f, kRegion + 3), sincos_of(angle * t));
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
    R3 half_axis = PART(f, kRegion);
    return distance_to_origin(d - half_axis * clamp(dot(half_axis, d) * NUMBER(f, kRegion + 3), R(-1), R(1)));
  }
#endif
#ifdef REGION_HALF_SPACE
  if (kind == kHalfSpace) {
    R3 normal = normal_at(f, t);
    return Region(dot(normal, d), normal);
  }
#endif
#ifdef REGION_SET
  if (kind == kSet) return set_distance(field_table(f) + kFirstSet, d, NUMBER(f, kOuter));
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
  return at - PART(f, 0);
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
#if defined(BLENDED) || defined(REGION_HALF_SPACE)
  for (int f = 0; f < field_count; ++f) {
    R3 d = at_field(f, at);
#ifdef BLENDED
    R3 before = velocity_of(f, d, R(0));
    R3 after = velocity_of(f, d - displacement, R(0));
    greatest = max(greatest, sqrt(max(dot(before, before), dot(after, after))));
#else
    d -= displacement * t;
    if (region_kind(f) != kHalfSpace) continue;
    R angle = NUMBER(f, kRegion + 6);
    if (angle == R(0)) continue;
    R3 axis = PART(f, kRegion + 3);
    greatest = max(greatest, abs(angle * dot(cross(axis, normal_at(f, t)), d)));
#endif
  }
#endif
  return greatest;
}
)";

// Powers, and sums over points.
const char* const kGlslPowers = R"(
#ifdef REGION_SET

R4 integer_powers(R4 base, int exponent) {
  R4 result = (exponent & 1) != 0 ? base : R4(1);
  base *= base;
  if ((exponent & 2) != 0) result *= base;
  base *= base;
  if ((exponent & 4) != 0) result *= base;
  base *= base;
  if ((exponent & 8) != 0) result *= base;
  for (exponent >>= 4; exponent > 0; exponent >>= 1) {
    base *= base;
    if ((exponent & 1) != 0) result *= base;
  }
  return result;
}

R integer_power(R base, int exponent) { return integer_powers(R4(base), exponent).x; }

// sum^(-1/m) for sum > 0, as in region.h.
R inverse_root(R sum, int m) {
  R y = R(1) / sum;
  int q = 1;
  for (; 2 * q <= m; q *= 2) y = sqrt(y);
  if (q == m) return y;
  if (sum < R(1)) y = sqrt(y);
  R inverse = R(1) / R(m);
  for (int i = 0; i < 64; ++i) {
    R next = y + y * (R(1) - sum * integer_power(y, m)) * inverse;
    if (!(next > y)) break;
    y = next;
  }
  return y;
}

R squared_distance(R3 d, int point) {
  R3 from = d - part(point);
  return dot(from, from);
}

// The squared distance of the nearest point, without curves. Four at a time; the last one fills up.
R nearest_point_squared(int first, int last, R3 d) {
  R least = kNever;
  for (int i = first; i < last; i += 12) {
    least = min(least, min(min(squared_distance(d, i), squared_distance(d, min(i + 3, last - 3))),
                           min(squared_distance(d, min(i + 6, last - 3)), squared_distance(d, min(i + 9, last - 3)))));
  }
  return least;
}

// (scale / d_i)^m of all points added up (x), and the gradient's sum (yzw). Four at a time, written out: NVIDIA's driver
// cannot set a component of a double vector by its number.
R4 sum_over_points(int first, int last, R3 d, R inverse, int half_exponent) {
  R4 sum = R4(0);
  for (int i = first; i < last; i += 12) {
    R3 from0 = (d - part(i)) * inverse;
    R3 from1 = (d - part(min(i + 3, last - 3))) * inverse;
    R3 from2 = (d - part(min(i + 6, last - 3))) * inverse;
    R3 from3 = (d - part(min(i + 9, last - 3))) * inverse;
    R4 squares = R4(dot(from0, from0), dot(from1, from1), dot(from2, from2), dot(from3, from3));
    R4 ratios = R4(1) / squares;
    R4 terms = integer_powers(ratios, half_exponent);
    if (i + 3 >= last) terms.y = R(0);
    if (i + 6 >= last) terms.z = R(0);
    if (i + 9 >= last) terms.w = R(0);
    R4 slopes = terms * ratios;
    sum.x += (terms.x + terms.y) + (terms.z + terms.w);
    sum.yzw += (from0 * slopes.x + from1 * slopes.y) + (from2 * slopes.z + from3 * slopes.w);
  }
  return sum;
}
#endif
)";

// The distances of point sets. A set's entries in table[], from `set` on: its first number in n[], the number of its
// points, the exponent, the list of its curves in table[], the number of curves, then its tree (glsl_surface.cpp). The
// list has for each curve its first number in n[] and the number of its points.
const char* const kGlslSets = R"(
#ifdef REGION_SET

#ifdef WITH_CURVES
R squared_distance_to_segment(R3 d, R3 a, R3 b) {
  R3 e = b - a;
  R3 from = d - a;
  R square = dot(e, e);
  R3 rest = from - e * clamp(dot(e, from) / (square > R(0) ? square : R(1)), R(0), R(1));
  return dot(rest, rest);
}

// The integral of |x - y|^-5 dl over one segment (x), and its gradient (yzw); the forms of region.h.
R4 segment_integral(R3 from, R3 e, R len) {
  R foot = dot(e, from);
  R3 h = from - e * foot;
  R h2 = dot(h, h);
  R l1 = -foot;
  R l2 = len - foot;
  R i1 = R(1) / (h2 + l1 * l1);
  R i2 = R(1) / (h2 + l2 * l2);
  R r1 = sqrt(h2 + l1 * l1);
  R r2 = sqrt(h2 + l2 * l2);
  R product = r1 * r2;
  R difference;
  R g;
  if (l1 * l2 >= R(0)) {
    difference = (l2 * l2 - l1 * l1) / (product * (l2 * r1 + l1 * r2));
    g = (h2 + l1 * l1 + l2 * l2) / (product * (product + l1 * l2));
  } else {
    difference = (l2 * r1 - l1 * r2) / (h2 * product);
    g = (product - l1 * l2) / (h2 * product);
  }
  R five = difference * (i1 + i2 + g) * R(1.0lf / 3.0lf);
  R seven = difference * (R(3) * (i1 * i1 + i2 * i2) + R(2) * g * g + i1 * i2 + R(3) * g * (i1 + i2)) *
            R(1.0lf / 15.0lf);
  R ends = i1 * i1 / r1 - i2 * i2 / r2;
  return R4(five, e * ends - h * (R(5) * seven));
}

R squared_distance_to_curve(int first, int count, R3 d) {
  R least = kNever;
  for (int i = 0; i + 1 < count; ++i) {
    least = min(least, squared_distance_to_segment(d, part(first + 3 * i), part(first + 3 * i + 3)));
  }
  return least;
}

// r_k of one polyline and its gradient.
Region curve_distance(int first, int count, R3 d) {
  R near = sqrt(squared_distance_to_curve(first, count, d));
  if (!(near > R(0))) return Region(R(0), R3(0));
  R scale = R(1) / near;
  R4 sum = R4(0);
  for (int i = 0; i + 1 < count; ++i) {
    R3 a = part(first + 3 * i);
    R3 edge = part(first + 3 * i + 3) - a;
    R len = length(edge);
    if (len == R(0)) continue;
    sum += segment_integral((d - a) * scale, edge / len, len * scale);
  }
  R scaled = R(1) / sqrt(sqrt(R(0.75) * sum.x));
  return Region(scaled * near, sum.yzw * (R(-0.25) * scaled / sum.x));
}
#endif

// The true distance of the nearest element, squared.
R nearest_squared(int set, R3 d) {
#ifdef WITH_TREES
  if (table[set + 7] > 0) return tree_nearest_squared(set, d);
#endif
  R least = nearest_point_squared(table[set], table[set] + 3 * table[set + 1], d);
#ifdef WITH_CURVES
  for (int k = 0; k < table[set + 4]; ++k) {
    int curve = table[set + 3] + 2 * k;
    least = min(least, squared_distance_to_curve(table[curve], table[curve + 1], d));
  }
#endif
  return least;
}

// The smallest r_k of all elements.
R nearest_element(int set, int first, int last, R3 d) {
  R least = sqrt(nearest_point_squared(first, last, d));
#ifdef WITH_CURVES
  for (int k = 0; k < table[set + 4]; ++k) {
    int curve = table[set + 3] + 2 * k;
    least = min(least, curve_distance(table[curve], table[curve + 1], d).value);
  }
#endif
  return least;
}

// r of a set and its gradient. Lengths are divided by about r, so that no power is out of range: by `scale` if that
// will do (0: it will not), else by the distance of the nearest element, for which all must be asked before.
Region set_distance(int set, R3 d, R scale) {
  int first = table[set];
  int last = first + 3 * table[set + 1];
  int exponent = table[set + 2];
#ifdef WITH_TREES
  Region by_tree;
  if (table[set + 7] > 0 && is_known_by_tree(set, d, by_tree)) return by_tree;
#endif
  if (table[set + 4] > 0) scale = R(0);
  R4 sum = R4(0);
  for (int pass = scale > R(0) ? 0 : 1; pass < 2; ++pass) {
    if (pass == 1) scale = nearest_element(set, first, last, d);
    if (!(scale > R(0))) return Region(R(0), R3(0));
    sum = sum_over_points(first, last, d, R(1) / scale, exponent / 2);
    if (sum.x > R(1e-20) && sum.x < R(1e20)) break;
  }
#ifdef WITH_CURVES
  for (int k = 0; k < table[set + 4]; ++k) {
    int curve = table[set + 3] + 2 * k;
    Region own = curve_distance(table[curve], table[curve + 1], d);
    R ratio = scale / own.value;
    R term = integer_power(ratio, exponent);
    sum += R4(term, own.gradient * (term * ratio));
  }
#endif
  R root = inverse_root(sum.x, exponent);
  return Region(scale * root, sum.yzw * (root / sum.x));
}
#endif
)";

}  // namespace knead::gpu
