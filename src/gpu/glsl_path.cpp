// Closed forms, path lines through segments, and pins in GLSL.
#include "gpu/glsl.h"

namespace knead::gpu {

// The closed forms of closed_form.cpp.
const char* const kGlslClosedForm = R"(
// d turned about the unit axis by the angle, minus d.
R3 turn_displacement(R3 d, R3 axis, R angle) {
  if (abs(angle) > R(1e4)) angle -= R(6.283185307179586lf) * nearest_integer(angle * R(0.15915494309189535lf));
  R half_sine = sincos_of(angle * R(0.5)).s;
  R3 across = d - axis * dot(axis, d);
  return cross(axis, d) * sincos_of(angle).s - across * (R(2) * half_sine * half_sine);
}

// The greatest value over the angles from phi0 to phi1 of n(phi).d, n turning about the unit axis.
R greatest_over_turn(R3 normal, R3 axis, R3 d, R phi0, R phi1) {
  R level = dot(axis, normal) * dot(axis, d);
  R cosine = dot(normal, d) - level;
  R sine = dot(cross(axis, normal), d);
  R amplitude = sqrt(cosine * cosine + sine * sine);
  if (abs(phi1 - phi0) >= R(3.14159265358979lf)) return level + amplitude;
  SinCos low = sincos_of(min(phi0, phi1));
  SinCos high = sincos_of(max(phi0, phi1));
  bool rises = sine * low.c - cosine * low.s > R(0);
  bool falls = sine * high.c - cosine * high.s < R(0);
  if (rises && falls) return level + amplitude;
  return level + max(cosine * low.c + sine * low.s, cosine * high.c + sine * high.s);
}

// Whether the motion of the point from `begin` to `end` is known; d is x - c(begin).
bool is_known(R3 d, R begin, R end, out Motion by) {
  by = Motion(R3(0), R(0));
  R duration = end - begin;
  R inner = NUMBER(0, kInner);
#if defined(MOTION_ROTATION) && defined(REGION_BALL)
  if (closed_form == kTurningBall) {
    R3 axis = PART(0, kMotion);
    R r = length(d);
    R2 w = blend_weight(0, r);
    R height = dot(axis, d);
    R3 across = d - axis * height;
    R gauge = NUMBER(0, kMotion + 7);
    R counter = r > R(0) ? gauge * w.y * (height * height + R(0.5) * dot(across, across)) / (R(2) * r) : R(0);
    by.moved = turn_displacement(d, axis, NUMBER(0, kMotion + 3) * (w.x + counter) * duration);
    return true;
  }
#endif
#if defined(MOTION_TWIST) && defined(REGION_HALF_SPACE)
  if (closed_form == kParallelTwist) {
    R3 axis = PART(0, kMotion);
    R3 normal = PART(0, kRegion);
    R height = dot(axis, d);
    R2 w = blend_weight(0, dot(normal, d));
    R counter = R(0.25) * NUMBER(0, kMotion + 7) * w.y * dot(normal, axis) * height;
    by.moved = turn_displacement(d, axis, NUMBER(0, kMotion + 3) * height * (w.x + counter) * duration);
    return true;
  }
#endif
#if (defined(MOTION_ROTATION) || defined(MOTION_TWIST)) && defined(REGION_HALF_SPACE)
  if (closed_form == kTurningSpace) {
    R3 axis = PART(0, kMotion);
    R rate = NUMBER(0, kMotion + 3);
    if (motion_kind(0) == kTwist) rate *= dot(axis, d);
    R turn = NUMBER(0, kRegion + 6) * (dot(PART(0, kRegion + 3), axis) > R(0) ? R(1) : R(-1));
    R phi0 = begin * turn;
    R phi1 = phi0 + duration * (turn - rate);
    if (greatest_over_turn(PART(0, kRegion), axis, d, phi0, phi1) >= inner) return false;
    by.moved = turn_displacement(d, axis, rate * duration);
    return true;
  }
#endif
#if defined(MOTION_STRAIN) && defined(REGION_BALL)
  if (closed_form == kStretchedCore) {
    int m = segment_numbers + kStrain;
    R3 moved = R3(dot(part(m), d), dot(part(m + 3), d), dot(part(m + 6), d));
    if (length(d) >= inner || length(moved) >= inner) return false;
    by.moved = moved - d;
    return true;
  }
#endif
  return false;
}
)";

// A path line through a segment, by the rule of flow/step_rule.h, and the shader's main function.
const char* const kGlslPath = R"(
R speed_at(R3 at, R3 slope, R t) { return max(length(slope - tool_velocity), tool_speed) + hidden_speed(at, t); }

// The longest step that misses nothing.
R longest_step_at(R speed, R reach, R t) {
#ifdef BLENDED
  return min(longest_step(speed, reach), longest_blended_step(t));
#else
  return longest_step(speed, reach);
#endif
}

bool is_number(R x) { return !isnan(x) && !isinf(x); }

// Tries the whole segment as one step of second order, then of third: moved is the step if the result is true.
bool crosses_in_one_step(R3 base, R t, R end, R3 k0, R speed, R reach, R longest, out R3 moved) {
  moved = R3(0);
  R h = end - t;
  R part = h / longest;
  R part2 = part * part;
  R speed2 = (speed / reach) * (speed / reach);
  R scale = kExpectedError * reach / tolerance;
  if (expected_third_order_error2(part2, speed2, scale * scale) > R(1)) return false;
  if (part2 > R(kThirdOrderReach * kThirdOrderReach)) return false;
  R3 k1 = velocity_at(base + k0 * h, end);
  R part_there = h * length(k1 - tool_velocity) / reach;
  part2 = maximum(part2, part_there * part_there);
  R3 slope = (k0 + k1) * R(0.5);
  R3 change = (k1 - slope) / tolerance;
  R change2 = dot(change, change);
  // Drivers may take !(a <= b) for a > b, and any maximum for one that drops what is not a number.
  if (!is_number(change2)) return false;
  if (second_order_excess(change2, part2) > R(1) || slope == R3(0)) {
    if (third_order_outlook(change2, part2) > R(1)) return false;
    R3 k2 = velocity_at(base + (k0 + k1) * (R(0.25) * h), t + R(0.5) * h);
    R3 correction = (k2 - slope) * R(2.0 / 3.0);
    slope += correction;
    change = correction / tolerance;
    change2 = dot(change, change);
    if (!is_number(change2) || third_order_excess(change2, part2) > R(1) || slope == R3(0)) return false;
  }
  moved = slope * h;
  ++accepted;
  return true;
}

// Integrates from the time t on.
Motion run(R3 base, R t, R end) {
  R direction = end >= t ? R(1) : R(-1);
  R3 moved = R3(0);
  R3 slope = R3(0);
  bool have_slope = true;
  bool at_contact = false;
  bool at_beginning = true;
  R trial = abs(end - t);
  while ((end - t) * direction > R(0)) {
    if (!have_slope) slope = velocity_at(base + moved, t);
    if (slope == R3(0) && !at_contact) {
      R contact = next_contact(base + moved, t, end);
      if (contact == kNever) break;
      have_slope = t == contact && !at_beginning;
      t = contact;
      if (at_beginning) trial = abs(end - t);
      at_contact = true;
      continue;
    }
    at_contact = false;
    if (carries && slope == tool_velocity) return Motion(moved, end - t);
    R speed = speed_at(base + moved, slope, t);
    R reach = greatest_reach;  // how far a step may pass
    R longest = longest_step_at(speed, reach, t);
    if (at_beginning) {
      at_beginning = false;
      R3 whole;
      if (crosses_in_one_step(base, t, end, slope, speed, reach, longest, whole)) return Motion(whole, R(0));
    }
    R remaining = abs(end - t);
    R shortest = shortest_step(longest, kShortestPart);
    R h = chosen_step(trial, shortest, longest, remaining);
    bool is_last = h >= remaining;
    R3 by;
    R3 estimate;
    R3 last;
    try_step(base + moved, slope, t, direction * h, by, estimate, last);
    R3 error = estimate / tolerance;
    R3 rounding = by * (R(kRoundingOfSlope) * kEpsilon / tolerance);
    R error2 = dot(error, error);
    if (kExtrapolates) error2 = extrapolated_error2(error2, h, shortest, kShortestPart);
    bool accept = error2 <= R(1) + dot(rounding, rounding) || h <= shortest;
    trial = h * step_factor(error2, kErrorOrder);
    if (accept) ++accepted; else ++rejected;
    if (accepted >= kStepLimit || rejected >= kStepLimit || !is_number(error2)) {
      complete = false;
      break;
    }
    have_slope = true;
    if (!accept) continue;
    moved += by * (direction * h);
    t = is_last ? end : t + direction * h;
    slope = last;
    have_slope = kFirstSameAsLast;
  }
  return Motion(moved, R(0));
}

// The motion of the point that is at x at the time `begin` of the segment.
Motion motion_of(dvec3 x, R begin, R end) {
  precise dvec3 from = x - centre;
  R3 base = R3(from);
#ifdef WITH_GRID
  if (!is_in_use(from)) return Motion(R3(0), R(0));
#endif
#if defined(SINGLE_FIELD) && !defined(BLENDED)
  Motion known;
  if (closed_form != 0 && is_known(base - displacement * begin, begin, end, known)) return known;
#endif
  return run(base, begin, end);
}

void open_segment(int s) {
  int entry = s * kSegmentEntries;
  field_count = FIELD_COUNT(table[entry]);
  first_field = table[entry + 1];
  carries = (table[entry + 2] & kCarries) != 0;
  closed_form = table[entry + 2] / kClosedForm;
  segment_numbers = table[entry + 3];
  segment_places = s * kSegmentPlaces;
  R4 way = quads[segment_numbers / 4];
  R4 rule = quads[segment_numbers / 4 + 1];
  displacement = way.xyz;
#ifdef BLENDED
  tool_velocity = R3(0);
  tool_speed = R(0);
#else
  tool_velocity = displacement;
  tool_speed = way.w;
#endif
  greatest_reach = rule.x;
  tolerance = rule.y;
  least_motion = rule.z;
  centre = place(segment_places);
  open_field();
}

// Whether no point of the ball is in the support of a field at any time of the segment.
#ifdef WITH_GRID
bool misses(int s, dvec3 at, double radius) {
  int bounds = table[table[s * kSegmentEntries + 1] + kBounds];
  return any(lessThan(at + radius, place(bounds))) || any(greaterThan(at - radius, place(bounds + 3)));
}
#else
bool misses(int s, dvec3 at, double radius) {
  int first = table[s * kSegmentEntries + 1];
  for (int f = 0; f < FIELD_COUNT(table[s * kSegmentEntries]); ++f) {
    int bounds = table[first + f * kFieldEntries + kBounds];
    dvec3 from = at - place(bounds);
    dvec3 way = place(bounds + 3);
    double reach = e[bounds + 6];
    double along = e[bounds + 7];
    double away;
    if (along < 0.0) {
      away = dot(from, way);
    } else {
      from -= way * clamp(dot(from, way) * along, 0.0, 1.0);
      away = sqrt(dot(from, from));
    }
    if (!(away - radius > reach)) return false;
  }
  return true;
}
#endif

#ifdef WITH_CYLINDER
bool is_within(dvec3 x) {
  int at = segment_places + 8;
  precise dvec3 d = x - place(at);
  dvec3 direction = place(at + 3);
  precise dvec3 across = d - direction * dot(direction, d);
  return dot(across, across) <= e[at + 6];
}
#endif

void count(uint at, uint number) {
  if (number == 0u) return;
  uint before = atomicAdd(counts[at], number);
  if (before + number < before) atomicAdd(counts[at + 1u], 1u);
}

// Moves the point at x by the segment. Returns whether it moves.
bool is_moved_by(int s, inout dvec3 x) {
  open_segment(s);
  R begin = n[segment_numbers + kBegin];
  R end = n[segment_numbers + kEnd];
#ifdef WITH_CYLINDER
  // The limit cylinder selects points at t = 0, to which the point is first moved back.
  bool asks = (table[s * kSegmentEntries + 2] & kHasCylinder) != 0;
  if (asks && begin == R(0) && !is_within(x)) return false;
  Motion by = Motion(R3(0), R(0));
  for (int pass = asks && begin != R(0) ? 0 : 1; pass < 2; ++pass) {
    uvec3 before = uvec3(accepted, rejected, evaluations);
    by = motion_of(x, begin, pass == 0 ? R(0) : end);
    if (pass == 1) break;
    accepted = before.x;
    rejected = before.y;
    evaluations = before.z;
    if (!is_within(x + dvec3(by.moved) + exact_displacement() * double(by.carried))) return false;
  }
#else
  Motion by = motion_of(x, begin, end);
#endif
  // A motion as small as the rounding at the support's border keeps the point's bits.
  R3 about = by.moved + displacement * by.carried;
  if (max(abs(about.x), max(abs(about.y), abs(about.z))) <= least_motion) return false;
  dvec3 exactly = dvec3(by.moved);
  if (by.carried != R(0)) exactly += exact_displacement() * double(by.carried);
  // Only coordinates that move, so that -0 stays -0.
  precise dvec3 to = x;
  if (about.x != R(0)) to.x += exactly.x;
  if (about.y != R(0)) to.y += exactly.y;
  if (about.z != R(0)) to.z += exactly.z;
  x = to;
  return true;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= point_count) return;
  uint group = gl_WorkGroupID.x;
  dvec3 middle = dvec3(bounds[4u * group], bounds[4u * group + 1u], bounds[4u * group + 2u]);
  double radius = double(uintBitsToFloat(radii[group]));
  int s = 0;
  while (s < segment_count && misses(s, middle, radius)) ++s;
  if (s == segment_count) return;
  dvec3 x = dvec3(points[3u * i], points[3u * i + 1u], points[3u * i + 2u]);
  bool is_moved = false;
  for (; s < segment_count && complete; ++s) {
    if (is_moved_by(s, x)) is_moved = true;
  }
  if (is_moved) {
    points[3u * i] = x.x;
    points[3u * i + 1u] = x.y;
    points[3u * i + 2u] = x.z;
    atomicMax(radii[group], floatBitsToUint(float(distance(x, middle)) * 1.000001));
  }
  if (counts_steps) steps[i] += accepted;
  // Some drivers stop all loops after a number of rounds (Mesa's on the CPU after 65535), and then also this one.
  int rounds = 0;
  while (rounds < segment_count + 1) ++rounds;
  bool is_cut_short = rounds < segment_count + 1;
  uint stripe = (group % uint(kCountStripes)) * uint(kCounters);
  count(stripe, accepted);
  count(stripe + 2u, rejected);
  count(stripe + 4u, evaluations);
  if (!complete) atomicOr(counts[stripe + 6u], 1u);
  if (is_cut_short) atomicOr(counts[stripe + 7u], 1u);
}
)";

// The pins of kernel_pins.h, instead of all other fields. The numbers of a part's pins are contiguous in n[]
// (packed_tree.cpp); lengths are in radii. Pins are evaluated four at a time, and their powers without a loop, because
// some drivers count the rounds of loops. Turns, which are fewer, loop, which compiles faster.
const char* const kGlslPins = R"(
void open_field() {}

// Psi a of the pin whose numbers begin at `pin`, for y from the pin and y.y < 1.
R3 velocity_of_pin(int pin, int degree, R3 y, R square, R s) {
  int powers = pin + kPowers;
  R3 a = part(powers + 3 * degree);
  for (int power = kMaxPinDegree - 1; power >= 0; --power) {
    if (power < degree) a = a * s + part(powers + 3 * power);
  }
  R r = sqrt(square);
  R rest = R(1) - r;
  R fourth = (rest * rest) * (rest * rest);
  return a * (fourth * (R(1) + r * (R(4) - R(20) * r))) + y * (fourth * (R(15) * dot(a, y)));
}

#ifdef WITH_TURNS
// The same of a turn, whose powers are the rate, and the strain's xx, yy, zz, xy, xz, yz.
R3 velocity_of_turn(int turn, int degree, R3 y, R square, R s) {
  int highest = turn + kPowers + 9 * degree;
  R3 rate = part(highest);
  R3 own = part(highest + 3);
  R3 across = part(highest + 6);
  for (int i = highest - 9; i >= turn + kPowers; i -= 9) {
    rate = rate * s + part(i);
    own = own * s + part(i + 3);
    across = across * s + part(i + 6);
  }
  R r = sqrt(square);
  R rest = R(1) - r;
  R cube = rest * rest * rest;
  R3 strained = R3(dot(R3(own.x, across.x, across.y), y), dot(R3(across.x, own.y, across.z), y),
                   dot(R3(across.y, across.z, own.z), y));
  R along = cube * R(4.0lf / 3.0lf) * dot(y, strained) / max(r, R(1e-18));
  return cross(rate, y) * (cube * (R(1) - R(1.8lf) * r)) + strained * (cube * (R(1) - R(7.0lf / 3.0lf) * r)) + y * along;
}
#endif

R3 velocity_at(R3 at, R t) {
  ++evaluations;
  int degree = table[first_field + kDegree];
  int stride = kPowers + 3 * (degree + 1);
  int first = field_numbers(0);
  int last = first + stride * (field_count - 1);
  R3 x = at * n[segment_numbers + kPerRadius];
  R s = (t - n[segment_numbers + kMiddle]) * n[segment_numbers + kPerHalf];
  R3 sum = R3(0);
  for (int i = first; i <= last; i += 4 * stride) {
    for (int k = 0; k < 4; ++k) {
      int pin = min(i + k * stride, last);
      R3 y = x - part(pin) - part(pin + 3) * t;
      R square = dot(y, y);
      if (square < R(1) && i + k * stride <= last) sum += velocity_of_pin(pin, degree, y, square, s);
    }
  }
#ifdef WITH_TURNS
  int turn = table[first_field + kFirstTurn];
  for (int k = 0; k < table[first_field + kTurns]; ++k) {
    R3 y = x - part(turn) - part(turn + 3) * t;
    R square = dot(y, y);
    if (square < R(1)) sum += velocity_of_turn(turn, degree, y, square, s);
    turn += kPowers + 9 * (degree + 1);
  }
#endif
  return sum;
}

R hidden_speed(R3 at, R t) { return R(0); }

// The earliest time, from t towards `end`, at which a pin reaches the resting point; kNever if none does.
R next_contact(R3 at, R t, R end) {
  R direction = end >= t ? R(1) : R(-1);
  R3 x = at * n[segment_numbers + kPerRadius];
  R first = kNever;
  for (int f = 0; f < field_count; ++f) {
    int pin = field_numbers(f);
    R3 by = part(pin + 3);
    R3 y = x - part(pin) - by * t;
    first = min(first, dot(y, y) < R(1) ? R(0) : sphere_contact(y, by * -direction, R(1)));
  }
  return first < abs(end - t) ? t + direction * first : kNever;
}
)";

}  // namespace knead::gpu
