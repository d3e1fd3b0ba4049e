/// @file
/// core/math.hpp for the 64-bit build of the controller: the same functions, to double precision.
#pragma once

#include <bit>
#include <cstdint>

namespace torsio::wide::core {

inline constexpr double kTwoPi = 6.28318530717958647692;

constexpr bool is_finite(double value) {
  constexpr std::uint64_t exponent = 0x7FF0000000000000U;
  return (std::bit_cast<std::uint64_t>(value) & exponent) != exponent;
}

constexpr double absolute(double value) { return value < 0.0 ? -value : value; }
constexpr double smaller(double a, double b) { return b < a ? b : a; }
constexpr double smaller_number(double a, double b) { return smaller(a, b); }
constexpr double larger(double a, double b) { return a < b ? b : a; }

constexpr double clamp_symmetric(double value, double limit) {
  return value > limit ? limit : value < -limit ? -limit : value;
}

constexpr double clamp_number(double value, double limit) { return clamp_symmetric(value, limit); }

inline constexpr double kTiny = 1e-20;
constexpr double flush_tiny(double value) { return absolute(value) < kTiny ? 0.0 : value; }
constexpr double flush_tiny_number(double value) { return flush_tiny(value); }

/// sin(2 pi phase / 2^32), by its series on a quarter turn.
constexpr double sin_phase(std::uint32_t phase) {
  if (phase + 0x40000000U > 0x80000000U) phase = 0x80000000U - phase;
  const double x = static_cast<double>(static_cast<std::int32_t>(phase)) * (0x1p-32 * kTwoPi);
  double term = x;
  double sum = 0.0;
  for (int n = 1; n < 25; n += 2) {
    sum += term;
    term *= -x * x / ((n + 1) * (n + 2));
  }
  return sum;
}

/// exp(-x) for x >= 0: the series of a 2^-10th of it, squared ten times.
constexpr double exp_negative(double x) {
  if (!(x < 700.0)) return 0.0;
  const double small = -x * 0x1p-10;
  double term = 1.0;
  double sum = 0.0;
  for (int n = 1; n < 24; ++n) {
    sum += term;
    term *= small / n;
  }
  for (int i = 0; i < 10; ++i) sum *= sum;
  return sum;
}

constexpr double square_root(double value) { return value > 0.0 ? __builtin_sqrt(value) : 0.0; }

constexpr std::uint32_t round_to_u32(double value) {
  if (!(value > 0.0)) return 0;
  if (value >= 4294967295.0) return 0xFFFFFFFFU;
  return static_cast<std::uint32_t>(value + 0.5);
}

}  // namespace torsio::wide::core
