/// @file
/// The few functions that the control law needs, written so that every processor gives the same
/// bits: no library calls, no fused operations, no dependence on rounding modes.
#pragma once

#include <bit>
#include <cstdint>

namespace torsio::core {

inline constexpr float kTwoPi = 6.28318530717958647692F;

/// The processor finds the smaller or larger of two numbers in one instruction, VMINNM or VMAXNM,
/// which do not pass NaN on. Elsewhere fminf and fmaxf would be calls of the library.
#if defined(__ARM_ARCH_8M_MAIN__) && defined(__ARM_FP)
inline constexpr bool kHasNumberMinMax = true;
#else
inline constexpr bool kHasNumberMinMax = false;
#endif

/// True for everything but NaN and the infinities. By the bits, so that no compiler option can
/// remove the question.
constexpr bool is_finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) != 0x7F800000U;
}

/// One instruction where there is floating point, without a comparison.
constexpr float absolute(float value) { return __builtin_fabsf(value); }
constexpr float smaller(float a, float b) { return b < a ? b : a; }

/// For numbers, never NaN. Between zeros of both signs the order may decide.
constexpr float larger(float a, float b) {
  if constexpr (kHasNumberMinMax) return __builtin_fmaxf(a, b);
  return a < b ? b : a;
}

/// The same of the smaller.
constexpr float smaller_number(float a, float b) {
  if constexpr (kHasNumberMinMax) return __builtin_fminf(a, b);
  return smaller(a, b);
}

/// @param limit >= 0
/// @returns value held within [-limit, limit]
constexpr float clamp_symmetric(float value, float limit) {
  if (absolute(value) <= limit) return value;  // nearly always, and then it is one comparison
  return value > limit ? limit : value < -limit ? -limit : value;
}

/// The same for a number, never NaN.
constexpr float clamp_number(float value, float limit) {
  if constexpr (kHasNumberMinMax) return __builtin_fmaxf(__builtin_fminf(value, limit), -limit);
  return clamp_symmetric(value, limit);
}

/// Decaying states end at exactly zero, before they become subnormal: those are slow on some
/// processors and flushed by others.
inline constexpr float kTiny = 1e-20F;
constexpr float flush_tiny(float value) { return absolute(value) < kTiny ? 0.0F : value; }

/// The same for a number, never NaN: one selection where there is floating point.
constexpr float flush_tiny_number(float value) { return absolute(value) >= kTiny ? value : 0.0F; }

/// sin(2 pi phase / 2^32). The phase wraps as unsigned integers do, so it never loses precision.
/// Error below 2e-7 (odd minimax polynomial of degree 9 on a quarter turn).
constexpr float sin_phase(std::uint32_t phase) {
  // Fold the second and third quarter: sin(pi - x) = sin(x).
  if (phase + 0x40000000U > 0x80000000U) phase = 0x80000000U - phase;
  const float x = static_cast<float>(static_cast<std::int32_t>(phase)) * 0x1p-30F;
  const float y = x * x;
  return x * (1.57079637F + y * (-0.645963788F +
                                 y * (0.0796899274F + y * (-0.00467415759F + y * 1.51678527e-4F))));
}

/// exp(-x) for x >= 0; relative error below 3e-7. Used where parameters are prepared, not in a
/// tick.
constexpr float exp_negative(float x) {
  if (!(x < 87.0F)) return 0.0F;
  const float halvings = static_cast<float>(static_cast<std::int32_t>(x * 1.44269504F + 0.5F));
  // ln 2 in two parts, so that the remainder keeps its digits.
  const float r = (x - halvings * 0.693145752F) - halvings * 1.42860677e-6F;
  const float series =
      1.0F +
      r * (-1.0F +
           r * (0.5F + r * (-0.166664153F +
                            r * (0.0416660830F + r * (-0.00837512873F + r * 0.00139560562F)))));
  const auto exponent = static_cast<std::uint32_t>(127 - static_cast<std::int32_t>(halvings));
  return series * std::bit_cast<float>(exponent << 23);
}

/// Square root of value >= 0, relative error below 2e-7. Used where parameters are prepared.
constexpr float square_root(float value) {
  if (!(value > 0.0F)) return 0.0F;
  // Halving the exponent is a guess within 6 %; each step of Newton's doubles the digits.
  float root = std::bit_cast<float>((std::bit_cast<std::uint32_t>(value) >> 1) + 0x1FBD1DF5U);
  for (int i = 0; i < 4; ++i) root = 0.5F * (root + value / root);
  return root;
}

/// Whole number nearest to value >= 0, held at the largest 32-bit one.
constexpr std::uint32_t round_to_u32(float value) {
  if (!(value > 0.0F)) return 0;
  if (value >= 4294967040.0F) return 0xFFFFFFFFU;
  return static_cast<std::uint32_t>(value < 8388608.0F ? value + 0.5F : value);
}

}  // namespace torsio::core
