#include "knead/gpu/glsl.h"

namespace knead::gpu {

// kernel_pins.h for the GPU, in the place of all other fields. The numbers of a part's pins stand one after the other
// in n[], as packed_pins.cpp puts them; lengths are in radii. Pins are gone through four at a time, and their powers
// without a loop, since some drivers count the rounds of loops. Turns, which are fewer, loop: that compiles faster.
const char* const kGlslPins = R"(
// Psi a of the pin whose numbers begin at `pin`, for y from the pin and y.y < 1.
R3 velocity_of_pin(int pin, int degree, R3 y, R square, R s) {
  int powers = pin + kPowers;
  R3 a = part(powers + 3 * degree);
  for (int power = kMostPinDegree - 1; power >= 0; --power) {
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

R local_width(R3 at, R t) { return kNever; }

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
