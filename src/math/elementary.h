// Elementary functions composed of + - * / and sqrt. Those of C libraries differ in the last bits between systems,
// versions, and processors with and without multiply-adds.
#pragma once

namespace knead::elementary {

// Each errs by at most 2 units in the last place, and is exact where the comment says so. Arguments that are not
// finite, or outside the domain, give the results of <cmath>.

// For |radians| <= 1e4, with the bound of sincos() in vec.h.
double cos(double radians);
double sin(double radians);
double tan(double radians);

// The angle of (x, y) in [-pi, pi]. Exact on the axes, up to the rounding of pi.
double atan2(double y, double x);
double atan(double tangent);

double log(double x);
double exp(double x);
// Of a positive base. Exact for the exponents 0 and 1.
double pow(double base, double exponent);
// Exact for cubes of whole numbers.
double cbrt(double x);
// The length of (x, y, z), without overflow.
double hypot(double x, double y, double z = 0);

// The logarithm of the odds of a probability, and back.
inline double logit(double x) { return log(x / (1 - x)); }
inline double sigmoid(double x) { return 1 / (1 + exp(-x)); }

// 10^n, rounded once for |n| <= 22, which is exact where 10^n is a number.
double power_of_ten(int n);
// The largest n with 10^n <= x, for a positive number.
int decimal_exponent(double x);

}  // namespace knead::elementary
