/// @file The functions that the plant and its noise need, from additions, multiplications and
/// divisions alone. The C library's functions differ in the last bit between processors, and
/// friction that sticks or slides makes a different run of it.
#pragma once

#include <cmath>
#include <numbers>

namespace torsio::emulator {

/// exp(x) - 1 for x <= 0; relative error below 4e-15.
[[nodiscard]] inline double expm1_of(double x) {
  if (!(x > -40.0)) return -1.0;  // exactly, to the last bit
  int doublings = 0;
  for (; x < -0.125; x *= 0.5) ++doublings;
  // x + x^2 / 2 + x^3 / 6 ..., from its end.
  double sum = 1.0;
  for (int k = 13; k > 1; --k) sum = 1.0 + sum * x / k;
  double change = x * sum;
  for (; doublings > 0; --doublings) change *= change + 2.0;
  return change;
}

/// The natural logarithm of 0 < x < infinity; error below 2e-16 of itself, near 1 of x - 1.
[[nodiscard]] inline double log_of(double x) {
  int exponent = 0;
  double part = std::frexp(x, &exponent);
  if (part < 0.5 * std::numbers::sqrt2) {
    part *= 2.0;
    --exponent;
  }
  // log((1 + s) / (1 - s)) = 2 (s + s^3 / 3 + s^5 / 5 ...), with s^2 < 0.03.
  const double s = (part - 1.0) / (part + 1.0);
  const double square = s * s;
  double sum = 0.0;
  for (int k = 23; k > 0; k -= 2) sum = sum * square + 1.0 / k;
  return exponent * std::numbers::ln2 + 2.0 * s * sum;
}

/// cos(2 pi turns) for 0 <= turns <= 1; error below 3e-16.
[[nodiscard]] inline double cos_of_turns(double turns) {
  const int quarter = static_cast<int>(4.0 * turns + 0.5);
  const double x = 2.0 * std::numbers::pi * (turns - 0.25 * quarter);  // within pi / 4
  const double square = x * x;
  double cosine = 1.0;
  for (int k = 18; k > 0; k -= 2) cosine = 1.0 - cosine * square / (k * (k - 1));
  double sine = 1.0;
  for (int k = 18; k > 0; k -= 2) sine = 1.0 - sine * square / (k * (k + 1));
  sine *= x;
  switch (quarter % 4) {
    case 0:
      return cosine;
    case 1:
      return -sine;
    case 2:
      return -cosine;
    default:
      return sine;
  }
}

}  // namespace torsio::emulator
