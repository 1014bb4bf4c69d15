// Elementary functions: their accuracy, their exact values and their bits.
#include "math/elementary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "knead/vec.h"

namespace knead::elementary_test {
namespace {

// Numbers from integers alone, the same everywhere.
class Numbers {
 public:
  double between(double low, double high) {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return low + (high - low) * (static_cast<double>(state_ >> 11) * 0x1p-53);
  }

 private:
  std::uint64_t state_ = 7;
};

double units_off(double got, long double wanted) {
  const double size = std::abs(static_cast<double>(wanted));
  const double unit = std::nextafter(size, kInfinity) - size;
  return std::abs(static_cast<double>((static_cast<long double>(got) - wanted) / unit));
}

TEST(Elementary, ErrsByAtMostTwoUnitsInTheLastPlace) {
  Numbers numbers;
  for (int i = 0; i < 100000; ++i) {
    const long double x = numbers.between(-1, 1);
    const long double y = numbers.between(-1, 1);
    const double a = static_cast<double>(x);
    const double b = static_cast<double>(y);
    const double positive = std::ldexp(1 + std::abs(a), static_cast<int>(100 * b));
    ASSERT_LE(units_off(elementary::atan2(b, a), std::atan2(y, x)), 2) << b << " " << a;
    ASSERT_LE(units_off(elementary::atan(9 * a), std::atan(static_cast<long double>(9 * a))), 2) << a;
    ASSERT_LE(units_off(elementary::log(positive), std::log(static_cast<long double>(positive))), 2) << positive;
    ASSERT_LE(units_off(elementary::exp(600 * a), std::exp(static_cast<long double>(600 * a))), 2) << a;
    ASSERT_LE(units_off(elementary::pow(1 + a, b), std::pow(static_cast<long double>(1 + a), y)), 2) << a << " " << b;
    ASSERT_LE(units_off(elementary::cbrt(positive), std::cbrt(static_cast<long double>(positive))), 2) << positive;
    ASSERT_LE(units_off(elementary::hypot(a, b), std::hypot(x, y)), 2) << a << " " << b;
  }
}

TEST(Elementary, IsExactWhereItSaysSo) {
  for (int i = -2000; i <= 2000; ++i) {
    ASSERT_EQ(elementary::cbrt(static_cast<double>(i) * i * i), i);
  }
  for (const double x : {1e-300, 0.1, 1.5, 7.0, 1e300}) {
    EXPECT_EQ(elementary::pow(x, 1), x);
    EXPECT_EQ(elementary::pow(x, 0), 1);
  }
  EXPECT_EQ(elementary::atan2(0, 1), 0);
  EXPECT_EQ(elementary::atan2(1, 0), std::atan2(1, 0));
  EXPECT_EQ(elementary::atan2(-1, 0), -std::atan2(1, 0));
  EXPECT_EQ(elementary::atan2(0, -1), std::atan2(0, -1));
  EXPECT_EQ(elementary::hypot(3, 4), 5);
  EXPECT_EQ(elementary::hypot(0x1.8p600, 0x1p601), 0x1.4p601);
  for (int n = -22; n <= 22; ++n) {
    EXPECT_EQ(elementary::power_of_ten(n), std::strtod(("1e" + std::to_string(n)).c_str(), nullptr)) << n;
    EXPECT_EQ(elementary::decimal_exponent(elementary::power_of_ten(n)), n);
    EXPECT_EQ(elementary::decimal_exponent(std::nextafter(elementary::power_of_ten(n), 0)), n - 1);
  }
}

TEST(Elementary, TakesWhatIsNotFiniteAsTheStandardLibrary) {
  EXPECT_EQ(elementary::atan2(kInfinity, kInfinity), elementary::atan2(1, 1));
  EXPECT_EQ(elementary::atan2(1, kInfinity), 0);
  EXPECT_TRUE(std::isnan(elementary::atan2(std::nan(""), 1)));
  EXPECT_TRUE(std::isnan(elementary::log(-1)));
  EXPECT_EQ(elementary::log(0), -kInfinity);
  EXPECT_EQ(elementary::exp(-kInfinity), 0);
  EXPECT_EQ(elementary::exp(kInfinity), kInfinity);
  EXPECT_EQ(elementary::hypot(-kInfinity, 1), kInfinity);
  EXPECT_EQ(elementary::cbrt(-kInfinity), -kInfinity);
}

// As golden_test.cpp: a system where these differ writes other files.
TEST(Elementary, HasTheSameBitsEverywhere) {
  Numbers numbers;
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&](double x) { hash = (hash ^ bit_cast<std::uint64_t>(x)) * 1099511628211U; };
  for (int i = 0; i < 100000; ++i) {
    const double a = numbers.between(-1, 1);
    const double b = numbers.between(-1, 1);
    for (const double x : {elementary::atan2(b, a), elementary::log(1 + a), elementary::exp(9 * a),
                           elementary::pow(1 + a, b), elementary::cbrt(9 * a), elementary::hypot(a, b, a + b),
                           elementary::tan(a), elementary::cos(9 * b), std::fma(a, b, -a * b)}) {
      add(x);
    }
  }
  EXPECT_EQ(hash, 12457233495103074381U);
}

}  // namespace
}  // namespace knead::elementary_test
