// Elementary functions by tables, Taylor series and the rounding errors of sums and products.
#include "math/elementary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "knead/vec.h"

namespace knead::elementary {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A number and its rounding error.
struct Rounded {
  double value = 0;
  double rest = 0;
};

// atan(k / 16).
constexpr std::array<Rounded, 17> kAtan = {{
    {0.0, 0.0},
    {0.06241880999595735, -1.5490756308295046e-18},
    {0.12435499454676144, -3.1253241424539383e-18},
    {0.18534794999569476, 4.180692268843079e-18},
    {0.24497866312686414, 1.0698755618734451e-17},
    {0.3028848683749714, -1.1010827903001369e-17},
    {0.35877067027057225, -2.4623815582638635e-17},
    {0.4124104415973873, -1.587652227770689e-17},
    {0.4636476090008061, 2.2698777452961687e-17},
    {0.5123894603107377, -2.5462781472855804e-17},
    {0.5585993153435624, -5.4556305485916264e-18},
    {0.6022873461349642, 2.950430737228402e-17},
    {0.6435011087932844, 1.5834785051444286e-17},
    {0.6823165548747481, 6.943223671560008e-18},
    {0.7188299996216245, -2.1478388444456983e-17},
    {0.7531512809621944, -2.4256934659182068e-17},
    {0.7853981633974483, 3.061616997868383e-17},
}};
constexpr Rounded kHalfPi = {1.5707963267948966, 6.123233995736766e-17};
constexpr Rounded kPi = {3.141592653589793, 1.2246467991473532e-16};
// The value has 32 bits, so that its product with an exponent is exact.
constexpr Rounded kLn2 = {0.6931471803691238, 1.9082149292705877e-10};

// The angle of (x, y) for 0 <= y <= x, 0 < x.
Rounded first_octant(double y, double x) {
  const double ratio = y / x;
  const double k = ratio < 1.0 / 16 ? 0 : round_to_integer(16 * ratio);  // t would cancel half of the table's 1 / 16
  const double c = k / 16;
  const double t = k == 0 ? ratio : (y - c * x) / (x + c * y);
  const double z = t * t;
  double s = -1.0 / 15;
  for (const double term : {1.0 / 13, -1.0 / 11, 1.0 / 9, -1.0 / 7, 1.0 / 5, -1.0 / 3}) s = s * z + term;
  const Rounded table = kAtan[static_cast<std::size_t>(k)];
  return k == 0 ? Rounded{t, t * (z * s)} : Rounded{table.value, table.rest + (t + t * (z * s))};
}

// The angle of (x, y) for positive x, y that are not too large or small.
Rounded first_quadrant(double y, double x) {
  if (y <= x) return first_octant(y, x);
  const Rounded other = first_octant(x, y);
  return {kHalfPi.value - other.value,
          kHalfPi.rest + ((kHalfPi.value - (kHalfPi.value - other.value)) - other.value) - other.rest};
}

// x = 2^exponent (1 + f), with 1 + f between sqrt(1/2) and sqrt(2).
struct Split {
  double f = 0;
  int exponent = 0;
};
Split split(double x) {
  Split result;
  double m = std::frexp(x, &result.exponent);
  if (m < std::numbers::sqrt2 / 2) {
    m *= 2;
    --result.exponent;
  }
  result.f = m - 1;
  return result;
}

// log(x) of a positive finite number.
Rounded log_of(double x) {
  const Split parts = split(x);
  const double f = parts.f;
  const double s = f / (2 + f);
  const double z = s * s;
  double r = 2.0 / 25;
  for (const double k : {23.0, 21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0}) r = r * z + 2 / k;
  r *= z;
  const double half = 0.5 * f * f;
  const double n = parts.exponent;
  const double small = s * (half + r) + n * kLn2.rest;
  const double rest = small - half;
  const double high = n * kLn2.value;
  const double sum = high + f;
  const double lost = (high - (sum - f)) + (f - (sum - (sum - f)));
  const double value = sum + (rest + lost);
  return {value, (sum - value) + (rest + lost)};
}

// e^(x + rest) for a small rest.
double exp_of(double x, double rest) {
  if (x > 710) return kInfinity;
  if (x < -746) return 0;
  const double n = round_to_integer(x * (1 / std::numbers::ln2));
  const double r = (x - n * kLn2.value) + (rest - n * kLn2.rest);
  double sum = 1.0 / 87178291200;
  for (const double term : {1.0 / 6227020800, 1.0 / 479001600, 1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320,
                            1.0 / 5040, 1.0 / 720, 1.0 / 120, 1.0 / 24, 1.0 / 6, 0.5}) {
    sum = sum * r + term;
  }
  return std::ldexp(1 + (r + r * r * sum), static_cast<int>(n));
}

}  // namespace

double cos(double radians) { return sincos(radians).cos; }
double sin(double radians) { return sincos(radians).sin; }
double tan(double radians) {
  const SinCos<double> of = sincos(radians);
  return of.sin / of.cos;
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNan;
  double a = std::abs(x);
  double b = std::abs(y);
  if (std::isinf(a) || std::isinf(b)) {
    a = std::isinf(a) ? 1 : 0;
    b = std::isinf(b) ? 1 : 0;
  }
  const double size = std::max(a, b);
  Rounded angle;
  if (size > 0) {
    const double scale = size > 0x1p900 ? 0x1p-200 : size < 0x1p-900 ? 0x1p200 : 1;
    angle = first_quadrant(b * scale, a * scale);
  }
  const double result =
      std::signbit(x) ? (kPi.value - angle.value) - (angle.rest - kPi.rest) : angle.value + angle.rest;
  return std::copysign(result, y);
}

double atan(double tangent) { return atan2(tangent, 1); }

double log(double x) {
  if (std::isnan(x) || x < 0) return kNan;
  if (x == 0) return -kInfinity;
  return std::isinf(x) ? x : log_of(x).value;
}

double exp(double x) { return std::isnan(x) ? x : exp_of(x, 0); }

double pow(double base, double exponent) {
  if (exponent == 1) return base;
  if (exponent == 0 || base == 1) return 1;
  if (std::isnan(exponent) || !(base > 0) || std::isinf(base) || std::isinf(exponent)) return std::pow(base, exponent);
  const Rounded of = log_of(base);
  const double product = exponent * of.value;
  if (std::abs(product) > 800) return exp_of(product, 0);
  // The product's rounding error, by halves of 26 bits (Dekker 1971).
  const auto high = [](double x) {
    const double c = x * 134217729;
    return c - (c - x);
  };
  const double a = high(exponent);
  const double b = high(of.value);
  const double lost = ((a * b - product) + a * (of.value - b) + (exponent - a) * b) + (exponent - a) * (of.value - b);
  return exp_of(product, lost + exponent * of.rest);
}

double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  const double size = std::abs(x);
  double root = exp_of(log_of(size).value / 3, 0);
  const int third = std::ilogb(root);  // with numbers near 1, cubes neither overflow nor underflow
  root = std::ldexp(root, -third);
  const double cube = std::ldexp(size, -3 * third);
  for (int i = 0; i < 2; ++i) root -= (root * root * root - cube) / (3 * root * root);
  return std::copysign(std::ldexp(root, third), x);
}

double hypot(double x, double y, double z) {
  const double size = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (std::isinf(x) || std::isinf(y) || std::isinf(z)) return kInfinity;
  if (!(size > 0x1p500) && !(size < 0x1p-400)) return std::sqrt(x * x + y * y + z * z);
  const double scale = size > 1 ? 0x1p-600 : 0x1p600;
  return std::sqrt(x * scale * (x * scale) + y * scale * (y * scale) + z * scale * (z * scale)) / scale;
}

double power_of_ten(int n) {
  constexpr std::array<double, 23> powers = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                             1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  double result = 1;
  int left = std::min(std::abs(n), 700);
  for (; left > 22; left -= 22) result = n > 0 ? result * 1e22 : result / 1e22;
  const double last = powers[static_cast<std::size_t>(left)];
  return n > 0 ? result * last : result / last;
}

int decimal_exponent(double x) {
  int n = static_cast<int>(std::floor(log_of(x).value / std::numbers::ln10));
  while (power_of_ten(n + 1) <= x) ++n;
  while (power_of_ten(n) > x) --n;
  return n;
}

}  // namespace knead::elementary
