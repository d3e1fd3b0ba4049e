/// @file
/// Angles as fixed-point turns, in doubles alone: what a processor has beyond them is not
/// everywhere the same. With long double the library for Windows was wrong by hundreds of 2^-32
/// turn.
#pragma once

#include <cstdint>

namespace torsio::conversion {

/// A number as the sum of two doubles. The second is the first one's rounding error.
struct Exact {
  double value = 0.0;
  double rest = 0.0;
};

inline constexpr Exact kTurnRad{6.283185307179586, 2.4492935982947064e-16};

/// 2^32 times dividend over divisor, to the nearest whole number; before rounding it is off by less
/// than 1e-5. A quotient beyond 2^30 is taken for one of that size; one that is no number gives 0.
std::int64_t quotient_q32(Exact dividend, Exact divisor);

}  // namespace torsio::conversion
